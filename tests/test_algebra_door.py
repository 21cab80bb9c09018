"""Through the door and back: nothing is lost, nothing is rounded, nothing changes its value."""

from __future__ import annotations

import pytest
import symengine as se
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from sympy.physics.mechanics import dynamicsymbols

from voronec import DefinitionError, EngineLimit, prove_equal, time, velocity
from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.algebra.sympy_bridge import SymPyBridge

pytestmark = pytest.mark.slow

x, y, z = sp.symbols("x y z")
f, g = sp.Function("f"), sp.Function("g")
p, r = dynamicsymbols("p r")
Q = sp.Rational

SAME = [
    x, sp.Integer(3), Q(-7, 5), Q(10**40 + 1, 3**50), sp.pi, sp.E, sp.I, sp.Integer(0),
    x + y, x * y / z, x**-2, sp.sqrt(x), x ** Q(2, 3), x**y, sp.exp(x), 2**x, 2 ** Q(1, 3),
    sp.sin(x), sp.cos(x), sp.tan(x), sp.cot(x), sp.sec(x), sp.csc(x),
    sp.asin(x), sp.acos(x), sp.atan(x), sp.acot(x), sp.atan2(y, x), sp.log(x),
    sp.sinh(x), sp.cosh(x), sp.tanh(x), sp.coth(x), sp.asinh(x), sp.acosh(x), sp.atanh(x),
    f(x), g(x, y), f(x + 1), f(f(x)), f(sp.sin(x) * y), f(1), g(1, x),
    f(x).diff(x), f(x).diff(x, 3), g(x, y).diff(x, y, y), f(x).diff(x) * f(y).diff(y, 2),
    sp.Symbol("a b"), sp.Symbol("lambda"), sp.Symbol("x'"), sp.Symbol("sin"), sp.Symbol("E"),
    sp.Function("sin_of")(x), sp.Function("E")(x), sp.Function("lambda")(x, y).diff(x),
]  # fmt: skip


@pytest.mark.parametrize("expr", SAME, ids=str)
def test_there_and_back_is_the_same_expression(expr):
    bridge = SymPyBridge()
    assert bridge.outward(bridge.inward(expr)) == expr
    assert bridge.inward(bridge.outward(bridge.inward(expr))) == bridge.inward(expr)


def test_inside_are_plain_symbols_of_the_users_names():
    fancy = sp.Symbol("x", positive=True)
    bridge = SymPyBridge([fancy, p, p.diff(time), time])
    assert bridge.inward(fancy) == se.Symbol("x")
    assert bridge.inward(p) == se.Symbol("p") and bridge.inward(p.diff(time)) == se.Symbol("pdot")
    assert bridge.inward(sp.sin(p) ** 2 * p.diff(time)) == se.sin(se.Symbol("p")) ** 2 * se.Symbol(
        "pdot"
    )


USER = [
    sp.Symbol("a", positive=True), sp.Symbol("b", real=True), sp.Symbol("c", integer=True),
    sp.Dummy("d"), p, r, p.diff(time), r.diff(time), p.diff(time, 2), time,
]  # fmt: skip
BUILT = [
    lambda s: s**2 + 1,
    lambda s: sp.sin(s) / s,
    lambda s: sp.sqrt(s**2),
    lambda s: f(s),
    lambda s: f(s).diff(s),
    lambda s: f(s**2).diff(s),
    lambda s: g(s, x).diff(s, x),
    lambda s: f(3 * s).diff(s, 2),
]


@pytest.mark.parametrize("symbol", USER, ids=str)
@pytest.mark.parametrize("build", BUILT)
def test_assumptions_and_functions_of_time_come_back(symbol, build):
    bridge = SymPyBridge([symbol])
    expr = build(symbol)
    back = bridge.outward(bridge.inward(expr))
    assert concrete(back - expr) == 0
    assert symbol in back.atoms(type(symbol)) | back.free_symbols
    assert back.free_symbols == expr.free_symbols


def test_the_root_of_a_square_stays_whatever_is_assumed():
    """positive=True makes SymPy shorten sqrt(a^2) before the door; inside nothing does."""
    bridge = SymPyBridge()
    inside = bridge.inward(sp.sqrt(x**2))
    assert inside != se.Symbol("x") and bridge.outward(inside) == sp.sqrt(x**2)


@pytest.mark.parametrize("pair", [
    (x, sp.Symbol("x", positive=True)), (sp.Symbol("p"), p), (sp.Dummy("x"), sp.Dummy("x")),
    (p.diff(time), sp.Symbol("pdot")), (velocity(x), sp.Symbol("xdot", real=True)),
])  # fmt: skip
def test_two_symbols_of_one_name_are_refused(pair):
    with pytest.raises(DefinitionError, match="two different symbols are named") as caught:
        SymPyBridge(pair)
    assert "\n" not in str(caught.value)
    bridge = SymPyBridge(pair[:1])
    with pytest.raises(DefinitionError, match="two different symbols"):
        bridge.admit(pair[1])
    assert SymPyBridge([pair[0], pair[0]]).inward(pair[0]) == bridge.inward(pair[0])


DECIMALS = {
    "0.1": Q(1, 10), "9.81": Q(981, 100), "1e-3": Q(1, 1000), "-2.5e-7": Q(-25, 10**8),
    "3.0": 3, "12345.67": Q(1234567, 100), "1e20": 10**20, "0.3333": Q(3333, 10**4),
}  # fmt: skip


@pytest.mark.parametrize(("text", "exact"), DECIMALS.items())
def test_decimals_are_the_decimals_they_were_written_as(text, exact):
    for number in (float(text), sp.Float(text), sp.Float(text, 30), sp.Float(text, 7)):
        assert SymPyBridge().outward(SymPyBridge().inward(number)) == exact
        assert SymPyBridge().outward(SymPyBridge().inward(number * x + y)) == exact * x + y


@given(st.integers(-(10**12), 10**12), st.integers(-20, 20))
def test_any_short_decimal_is_exact(digits, shift):
    given = float(f"{digits}e{shift}")
    assert SymPyBridge().outward(SymPyBridge().inward(given)) == digits * Q(10) ** shift


def known(expr):
    """The expression with f(a) = a^3 + 2 a^5 and g(a, b) = a^2 b^3 + a b, by definition alone."""
    if isinstance(expr, sp.Derivative):
        names = {v: sp.Dummy() for v, _ in expr.variable_count}
        value = known(expr.expr.xreplace(names))
        for v, count in expr.variable_count:
            value = value.diff(names[v], count)
        return value.xreplace({d: known(v) for v, d in names.items()})
    if isinstance(expr, sp.Subs):
        at = dict(zip(expr.variables, map(known, expr.point), strict=True))
        return known(expr.expr).xreplace(at)
    args = [known(a) for a in expr.args]
    if expr.func == f:
        return args[0] ** 3 + 2 * args[0] ** 5
    if expr.func == g:
        return args[0] ** 2 * args[1] ** 3 + args[0] * args[1]
    return expr.func(*args) if args else expr


def concrete(expr):
    return sp.expand(known(sp.sympify(expr)))


DERIVATIVES = {
    "at a multiple": f(2 * x).diff(x),
    "at a square": f(x**2).diff(x),
    "twice at a square": f(x**2).diff(x, 2),
    "at another symbol": sp.Subs(f(x).diff(x), x, y),
    "at a sum": sp.Subs(f(x).diff(x, x), x, x + y),
    "in the first place": g(x * y, y).diff(x),
    "in both places": g(x * y, x).diff(x),
    "in both sums": g(x + y, x - y).diff(y),
    "two at once": sp.Subs(g(x, y).diff(x, y), (x, y), (x * y, z)),
    "two swapped": sp.Subs(g(x, y).diff(x), (x, y), (y, x)),
    "under a product": sp.Subs(x * f(x) + f(x).diff(x), x, z**2),
    "of a known thing": sp.Subs(sp.Derivative(sp.sin(x) ** 2, x), x, y),
    "unevaluated": sp.Derivative(x**2 * f(x), x, x),
    "at a function": g(x, f(y)).diff(y),
    "its own name": sp.Subs(f(x).diff(x), x, x**2) * f(x).diff(x),
    "inside": f(f(2 * x)).diff(x),
    "beside": f(2 * x).diff(x) * f(3 * x).diff(x) - f(2 * x),
    "a constant in place": g(2, x).diff(x),
    "of time": f(2 * p).diff(p),
}


def kept(bridge, expr):
    """What comes in, or nothing where the door says that it does not take it."""
    try:
        return bridge.inward(expr)
    except (EngineLimit, DefinitionError):
        return None


HARD = {
    "at a number": sp.Subs(f(x).diff(x), x, 2),
    "one at a number": sp.Subs(g(x, y).diff(x, y), (x, y), (1, z)),
    "subs in subs": sp.Subs(f(x).diff(x) * sp.Subs(g(y, x).diff(y), y, 3 * x), x, z),
    "product in subs": sp.Subs(f(x * y).diff(y), y, x + 2),
    "captured": sp.Subs(sp.Subs(g(x, y).diff(x), x, y), y, x),
}


@pytest.mark.parametrize("expr", HARD.values(), ids=HARD)
def test_a_hard_derivative_is_kept_or_refused_and_never_changed(expr):
    bridge = SymPyBridge()
    inside = kept(bridge, expr)
    assert inside is None or concrete(bridge.outward(inside)) == concrete(expr)


@pytest.mark.parametrize("expr", DERIVATIVES.values(), ids=DERIVATIVES)
def test_derivatives_of_unknown_functions_keep_their_meaning(expr):
    bridge = SymPyBridge([p])
    assert concrete(bridge.outward(bridge.inward(expr))) == concrete(expr)


@pytest.mark.parametrize("expr", DERIVATIVES.values(), ids=DERIVATIVES)
def test_differentiation_commutes_with_the_door(expr):
    bridge = SymPyBridge([p])
    for name in (x, y, p):
        inside = bridge.inward(expr).diff(bridge.inward(name))
        assert concrete(bridge.outward(inside)) == concrete(concrete(expr).diff(name))


polynomials = st.recursive(
    st.sampled_from([x, y, x + y, 2 * x, x * y, sp.Integer(1)]),
    lambda c: st.one_of(
        st.tuples(c, c).map(lambda s: s[0] * s[1]),
        st.tuples(c, c).map(lambda s: s[0] - s[1]),
        c.map(f),
        st.tuples(c, c).map(lambda s: g(*s)),
        c.map(lambda e: e.diff(x)),
        c.map(lambda e: sp.Subs(e.diff(y), y, x + 2)),
    ),
    max_leaves=3,
)


@settings(max_examples=60, deadline=None)
@given(polynomials)
def test_random_expressions_keep_their_values(expr):
    bridge, at = SymPyBridge(), {x: Q(1, 2), y: Q(-1, 3)}
    inside = kept(bridge, expr)
    assume(inside is not None)
    slope = inside.diff(bridge.inward(x))
    assert known(bridge.outward(inside)).xreplace(at) == known(expr).xreplace(at)
    assert known(bridge.outward(slope)).xreplace(at) == known(expr).diff(x).xreplace(at)


def test_absolute_values_and_signs_are_roots():
    bridge = SymPyBridge()
    size, sign = bridge.inward(sp.Abs(x - 1)), bridge.inward(sp.sign(x - 1))
    for value in (Q(-5, 3), Q(7, 2)):
        at = {x: value}
        assert bridge.outward(size).xreplace(at) == abs(value - 1)
        assert bridge.outward(sign).xreplace(at) == sp.sign(value - 1)
        assert bridge.outward(size.diff(bridge.inward(x))).xreplace(at) == sp.sign(value - 1)


def test_numbers_of_python_are_numbers():
    assert SymPyBridge().inward_all([1, 2.5, "x", "1/3"]) == [
        1, se.Rational(5, 2), se.Symbol("x"), se.Rational(1, 3)
    ]  # fmt: skip


def test_matrices_keep_their_shape():
    bridge = SymPyBridge([p])
    found = bridge.outward_matrix(
        [[se.Symbol("p"), se.Integer(2)], [se.Symbol("y"), se.Symbol("x")]]
    )
    assert found == sp.ImmutableMatrix([[p, 2], [y, x]])
    assert bridge.outward_matrix([]).shape == (0, 0)


UNKNOWN = [
    sp.DiracDelta(x), sp.SingularityFunction(x, 1, 2), sp.Integral(f(x), x), sp.LambertW(x),
    sp.gamma(x), x > 0, sp.zoo, sp.nan, sp.erf(x), sp.Sum(x, (x, 1, 3)),
]  # fmt: skip


@pytest.mark.parametrize("expr", UNKNOWN, ids=str)
def test_what_the_engine_cannot_differentiate_is_named(expr):
    with pytest.raises(DefinitionError, match=type(expr).__name__) as caught:
        SymPyBridge().inward(expr)
    assert "\n" not in str(caught.value)


def test_names():
    assert plain_name(p.diff(time, 2)) == "pdotdot" and plain_name(velocity(x)) == "xdot"
    assert velocity(velocity(p)) == p.diff(time, 2)
    assert is_symbolic_name(p) and is_symbolic_name(x)
    assert not is_symbolic_name(f(x)) and not is_symbolic_name(p.diff(time))
    for bad in (sp.sin(x), x + 1, sp.Integer(2)):
        with pytest.raises(DefinitionError, match="is not a symbol"):
            plain_name(bad)


def test_signs_of_powers_are_taken_of_their_bases():
    """symengine recurses without end over sign((-x)**n)."""
    x, n = sp.symbols("x n")
    for expr, same in (
        (sp.sign(sp.sqrt(-x)), sp.sign(-x)),
        (sp.sign((-x) ** n), sp.sign(-x) ** n),
        (sp.sign((-x) ** sp.Rational(-1, 3)), 1 / sp.sign(-x)),
    ):
        bridge = SymPyBridge()
        assert bridge.inward(expr) == bridge.inward(same)


def test_what_sympy_differentiates_as_complex_is_real_inside():
    for size in (sp.Abs(x), sp.Abs(x * y), sp.Abs(y + sp.sin(x))):
        inner = size.args[0]
        own = inner.diff(x)
        assert prove_equal(sp.diff(size, x), sp.sign(inner) * own).proved
        assert prove_equal(sp.Derivative(size, x), inner * own / size).proved
    assert SymPyBridge().inward(sp.diff(sp.arg(x), x)) == 0


PIECES = [
    sp.Heaviside(x), sp.Heaviside(x, 1), sp.Max(x, y, 1), sp.Min(x, y), sp.floor(x), sp.frac(x),
    sp.ceiling(x), sp.Mod(x, Q(3, 2)), sp.Piecewise((x**2, x < 1), (y, x > 1), (7, True)),
    sp.Piecewise((1, (x > 0) & (y <= 1) | sp.Eq(x, -1)), (x, ~(x < 0)), (y, True)),
]  # fmt: skip


@pytest.mark.parametrize("expr", PIECES, ids=str)
def test_functions_in_pieces_keep_their_values_on_the_switches_too(expr):
    bridge = SymPyBridge()
    back = bridge.outward(bridge.inward(expr))
    places = [Q(n, 2) for n in range(-4, 5)]
    for a in places:
        for b in (0, 1, Q(5, 2)):
            at = {x: a, y: b}
            assert back.subs(at).doit() == expr.subs(at).doit()

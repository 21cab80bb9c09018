"""Whatever a normal form does to an expression, its values stay: at negative points too."""

from __future__ import annotations

import itertools

import pytest
import sympy as sp
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from voronec import EngineLimit, VoronecError, prove_equal
from voronec.algebra.normal import canonical, shorten, shortest
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.tape import Tape

x, y, z, v, w, k = sp.symbols("x y z v w k")
f = sp.Function("f")
ONE = sp.sin(x) ** 2 + sp.cos(x) ** 2
Q = sp.Rational

POINTS = [
    (Q(3, 7), Q(5, 4), Q(8, 9)),
    (Q(-9, 7), Q(4, 11), Q(-17, 6)),
    (Q(-3, 11), Q(-23, 10), Q(7, 5)),
    (Q(31, 9), Q(-2, 13), Q(-5, 8)),
]


def made_known(expr):
    """The expression with f(a) = a^2/3 + sin(2 a)."""
    return sp.sympify(expr).replace(f, lambda a: a**2 / 3 + sp.sin(2 * a)).doit()


def balls(exprs, point, names=(x, y, z), bits=400):
    bridge = SymPyBridge()
    inside = bridge.inward_all([made_known(e) for e in exprs])
    return Tape(inside).arb({str(n): p for n, p in zip(names, point, strict=True)}, bits)


def narrow(ball):
    return ball.is_finite() and float(ball.rad()) <= 1e-20 * (1 + abs(float(ball.mid())))


def agree(one, other, points=POINTS):
    """How many points there are at which the first is real; the second has its value at each."""
    real = 0
    for point in points:
        a, b = balls([one, other], point)
        if narrow(a):
            assert narrow(b) and a.overlaps(b), (one, other, point)
            real += 1
    return real


STRANGE = (sp.I, sp.oo, -sp.oo, sp.zoo, sp.nan, sp.re, sp.im, sp.AccumBounds)


def sane(expr):
    """Whether SymPy made nothing infinite or imaginary of an expression, with f known or not."""
    return not expr.has(*STRANGE) and not made_known(expr).has(*STRANGE)


def same_forms(exprs):
    """Every function of the module, applied to expressions."""
    bridge = SymPyBridge()
    inside = bridge.inward_all(exprs)
    collected = [bridge.inward(n) for n in (x, y)]
    yield shorten(exprs)
    yield [bridge.outward(e) for e in canonical(inside)]
    yield [bridge.outward(e) for e in shortest(inside, group=collected)]


leaves = st.sampled_from([x, y, z, x, y, sp.Integer(2), Q(-1, 3), sp.pi, f(x).diff(x, 2)])


def grown(children):
    pair = st.tuples(children, children)
    return st.one_of(
        pair.map(lambda p: p[0] + p[1]),
        pair.map(lambda p: p[0] * p[1]),
        pair.map(lambda p: p[0] / (p[1] + 5)),
        pair.map(lambda p: sp.sqrt(p[0] / (p[1] - 3))),
        pair.map(lambda p: f(p[0] - p[1])),
        children.map(sp.sin),
        children.map(sp.cos),
        children.map(lambda e: sp.tan(e / 2)),
        children.map(lambda e: sp.sqrt(e**2 + e + 3)),
        children.map(lambda e: sp.sqrt(e)),
        children.map(lambda e: (e**2 + 1) ** Q(-1, 3)),
        children.map(sp.Abs),
        children.map(lambda e: sp.exp(-e / 2)),
        children.map(sp.sinh),
    )


terms = st.recursive(leaves, grown, max_leaves=6)
quick = settings(
    max_examples=120, deadline=None, suppress_health_check=[HealthCheck.filter_too_much]
)


@pytest.mark.slow
@quick
@given(st.lists(terms, min_size=1, max_size=2))
def test_every_form_has_the_values_of_what_went_in(exprs):
    assume(all(map(sane, exprs)))
    try:
        forms = list(same_forms(exprs))
    except EngineLimit:
        assume(False)
    for form in forms:
        for before, after in zip(exprs, form, strict=True):
            agree(before, after)


def fractions(*leaves):
    return st.recursive(
        st.sampled_from(leaves),
        lambda c: st.one_of(
            st.tuples(c, c).map(lambda p: p[0] + p[1]),
            st.tuples(c, c).map(lambda p: p[0] * p[1]),
            st.tuples(c, c).map(lambda p: p[0] / (p[1] ** 2 + 7)),
        ),
        max_leaves=4,
    )


def written_twice(p, q, r):
    """Two equal expressions, written differently."""
    yield p * (q + r), p * q + r * p
    yield (q * p + q * r) / (q**2 + 2), (p + r) / (q + 2 / q)


plain = fractions(x, y, f(x), sp.exp(y), sp.Integer(3))
wavy = fractions(x, sp.sin(x), sp.cos(x), sp.sqrt(y), sp.sin(2 * x), sp.tan(x / 2))


@pytest.mark.slow
@quick
@given(plain, plain, plain)
def test_equal_fractions_get_one_canonical_form(p, q, r):
    for pair in written_twice(p, q, r):
        assert len(set(canonical(SymPyBridge().inward_all(pair)))) == 1


@pytest.mark.slow
@quick
@given(wavy, wavy, wavy)
def test_the_difference_of_equal_things_is_zero(p, q, r):
    assume(q != 0)
    try:
        for one, other in written_twice(p, q, r):
            assert canonical(SymPyBridge().inward_all([one - other, other - one])) == [0, 0]
    except EngineLimit:
        assume(False)


@pytest.mark.slow
@quick
@given(plain, st.one_of(plain, wavy))
def test_a_form_is_settled(p, q):
    expr = p * (q + x) + p
    try:
        once = shorten([expr])[0]
        twice = shorten([once])[0]
    except EngineLimit:
        assume(False)
    agree(expr, twice)
    assert sp.count_ops(twice) <= sp.count_ops(once) * 5 // 4 + 2


SHORT = {
    "pythagoras": (ONE + y, y + 1),
    "one minus a square": ((1 - sp.cos(x) ** 2) / sp.sin(x), sp.sin(x)),
    "tangent": (sp.tan(x) * sp.cos(x), sp.sin(x)),
    "difference": (sp.sin(x - 2 * y) + sp.cos(x) * sp.sin(2 * y), sp.sin(x) * sp.cos(2 * y)),
    "cosecant squared": ((y + sp.sin(x)) / (1 - sp.cos(x) ** 2), (y + sp.sin(x)) / sp.sin(x) ** 2),
    "sines below": ((y * sp.sin(x) + z * (1 - sp.cos(x) ** 2)) / sp.sin(x) ** 2, z + y / sp.sin(x)),
    "half angle": (2 * sp.sin(x / 2) * sp.cos(x / 2) * 3 - 3 * sp.sin(x), 0),
    "difference of squares": ((x**2 - y**2) / (x - y), x + y),
    "square below": (1 / (4 * x**2 + 12 * x * y + 9 * y**2), (2 * x + 3 * y) ** -2),
    "root over root": ((x**2 + 1) / sp.sqrt(x**2 + 1), sp.sqrt(x**2 + 1)),
    "one over a root": (sp.sqrt(x**2 + 1) / (x**2 + 1), 1 / sp.sqrt(x**2 + 1)),
    "cosecant": (sp.sin(x) / (1 - sp.cos(x) ** 2), 1 / sp.sin(x)),
    "exponential": (sp.exp(x) * sp.exp(-x) * y, y),
    "hyperbolic": (sp.cosh(x) - sp.sinh(x), sp.exp(-x)),
    "a function": (f(x) * ONE - f(x), 0),
    "sign": (sp.sign(y * sp.sin(x) ** 2 + y * sp.cos(x) ** 2), sp.sign(y)),
    "signs in a sign": (sp.sign(y + sp.sign(z * ONE)), sp.sign(y + sp.sign(z))),
    "factors": (x**2 + 2 * x * y + y**2, (x + y) ** 2),
    "numbers": (sp.sqrt(8) / 2, sp.sqrt(2)),
}  # fmt: skip


@pytest.mark.parametrize(("given", "short"), SHORT.values(), ids=SHORT)
def test_short_forms_known_by_hand(given, short):
    found = shorten([given])[0]
    assert agree(given, short) and agree(found, short) and agree(short, found)
    assert sp.count_ops(found) <= sp.count_ops(short) + 2


@pytest.mark.parametrize(("p", "q"), [*itertools.permutations(sp.symbols("a b c d u w"), 2)])
def test_radicals_of_quotients_keep_their_sign(p, q):
    """sqrt(p/q) q = sqrt(p q) |q|/q: what the names are, and so their order, does not matter."""
    exprs = [
        sp.sqrt(p / q) * q,
        z * sp.sqrt(p / q) + sp.sqrt(p * q),
        sp.sqrt(p * q) / q + sp.sqrt(p / q),
        sp.sqrt((p + q) / q) - sp.sqrt((p + q) * q) / q,
        (p / q) ** Q(1, 3) * q,
        1 / (sp.sqrt(p / q) + sp.sqrt(q / p)),
    ]
    for expr, short in zip(exprs, shorten(exprs), strict=True):
        real = 0
        for point in ((Q(2), Q(3), Q(5)), (Q(-2), Q(-3), Q(5)), (Q(-7), Q(-2), Q(-1))):
            a, b = balls([expr, short], point, (p, q, z))
            if narrow(a):
                real += 1
                assert narrow(b) and a.overlaps(b)
        assert real


def test_collecting_by_velocities_keeps_the_coefficients_apart():
    bridge = SymPyBridge()
    energy = (x + y) ** 2 * v**2 + (x - 2 * x * sp.sin(y) ** 2 - x * sp.cos(2 * y)) * v * w
    energy += w**2 * sp.sin(x) * sp.cos(y) / (1 + y) - w**2 * sp.sin(x) + z
    inside = shortest([bridge.inward(energy)], group=[bridge.inward(v), bridge.inward(w)])
    found = bridge.outward(inside[0])
    collected = sp.collect(sp.expand(found), (v, w), evaluate=False)
    assert set(collected) == {v**2, w**2, 1} and agree(collected[v**2], (x + y) ** 2) == 4
    assert {term.as_independent(v, w)[1] for term in sp.Add.make_args(found)} == {v**2, w**2, 1}


SPHERE = x**2 + y**2 + z**2 - 1
q = sp.symbols("q0:4")
UNIT = sum(c**2 for c in q) - 1
a, b, c, d = q
ROTATION = sp.Matrix(
    [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]
)


def test_a_quaternion_turns_orthogonally():
    assert shorten(list(ROTATION * ROTATION.T), (UNIT,)) == list(sp.eye(3))
    assert shorten([ROTATION.det()], (UNIT,)) == [1]
    assert shorten([ROTATION.det()]) != [1]


SPHERICAL = {
    "radius": (x**2 + y**2 + z**2, 1),
    "invertible": ((1 - x**2) / (y**2 + z**2), 1),
    "root": (sp.sqrt(x**2 + y**2 + z**2 + k**2) - sp.sqrt(1 + k**2), 0),
    "moment": (k * (y**2 + z**2) + k * x**2 - k, 0),
    "stereographic": ((x**2 + y**2) / (1 - z), 1 + z),
}


@pytest.mark.parametrize(("given", "short"), SPHERICAL.values(), ids=SPHERICAL)
def test_on_a_sphere(given, short):
    assert prove_equal(shorten([given], (SPHERE,))[0], short).proved


numbers = st.integers(-5, 5)
monomials = st.tuples(*[st.integers(0, 3)] * 4, numbers)


@pytest.mark.slow
@quick
@given(st.lists(monomials, min_size=1, max_size=5), monomials, st.tuples(numbers, numbers, numbers))
def test_forms_modulo_a_relation_agree_on_it(many, below, place):
    def product(exponents):
        return exponents[4] * sp.Mul(*[n**e for n, e in zip(q, exponents, strict=False)])

    expr = sp.Add(*map(product, many)) / (product(below) ** 2 + 2)
    square = sum(p * p for p in place)
    unit = [Q(1 - square, 1 + square), *(Q(2 * p, 1 + square) for p in place)]
    try:
        found = shorten([expr], (UNIT,))[0]
    except EngineLimit:
        assume(False)
    at = dict(zip(q, unit, strict=True))
    assert found.xreplace(at) == expr.xreplace(at)


def test_angles_whose_cosine_is_a_letter_are_turned_as_others_are():
    """cos(acos(x)) is x, which says nothing of an angle."""
    bridge = SymPyBridge()
    a, b = 3 * sp.acos(x), 3 * sp.acos(y)
    turned = sp.cos(a) * sp.cos(b) + sp.sin(a) * sp.sin(b)
    (found,) = map(bridge.outward, shortest([bridge.inward(turned)]))
    at = {x: 0.3, y: 0.4}
    assert abs(sp.N((found - turned).subs(at))) < 1e-12


def test_a_budget_is_kept():
    bridge = SymPyBridge()
    huge = (sum(sp.symbols("a b c d e f g h")) + 1) ** 30 / (x + ONE)
    with pytest.raises(EngineLimit):
        canonical([bridge.inward(huge)])
    with pytest.raises(EngineLimit):
        shortest([bridge.inward((x + y) ** 9 * (x - y) ** 9)], work_limit=10)


@pytest.mark.parametrize("hidden", [ONE - 1, (x + y) ** 2 - x**2 - 2 * x * y - y**2])
def test_dividing_by_a_hidden_zero_is_an_error_of_ours(hidden):
    with pytest.raises(VoronecError) as caught:
        shorten([y / hidden])
    assert "\n" not in str(caught.value)


def test_common_factors_are_found_that_sines_and_cosines_hide():
    wide, narrow_part = x * sp.sin(y) * sp.sin(z) - sp.sin(z) ** 2, x * sp.sin(y) - sp.sin(z)
    hidden = wide.subs(sp.sin(z) ** 2, 1 - sp.cos(z) ** 2)
    assert shorten([w * sp.cos(y) * narrow_part / hidden]) == [w * sp.cos(y) / sp.sin(z)]
    assert shorten([(x - sp.sin(z)) / (x * sp.sin(z) + sp.cos(z) ** 2 - 1)]) == [1 / sp.sin(z)]
    root = sp.sqrt(1 + x**2)
    assert shorten([(y - root) / (y * root - 1 - x**2)]) == [1 / root]
    # where nothing is common nothing is put below that vanishes elsewhere
    for alone in (sp.cos(z) / (1 + sp.sin(z)), (y + sp.sin(z)) / (y * sp.sin(z) - sp.sin(z) ** 2)):
        (found,) = shorten([alone])
        assert agree(alone, found) and sp.fraction(found)[1].subs(z, -sp.asin(y)) != 0


@pytest.mark.parametrize(
    "expr",
    [
        -x + sp.exp(-1000 * (y - Q(1, 2)) ** 2),
        sp.tanh(20 * (x - 5)) * sp.exp(-x / 5),
        sp.exp(-x / 5) / (1 + sp.exp(20 * x)),
        y * sp.exp(-((x - y) ** 2)) + sp.exp(x + y),
    ],
    ids=str,
)
def test_exponentials_stay_short(expr):
    (found,) = shorten([expr])
    assert found.count_ops() <= expr.count_ops() + 2
    assert prove_equal(found, expr).proved


def test_exponentials_that_depend_on_one_another_are_seen():
    e = sp.exp
    assert shorten([e(x + y) * e(-x) - e(y), e(2 * x + 1) - e(x + 1) * e(x)]) == [0, 0]
    square = e((x - y) ** 2)
    assert prove_equal(square**2 / e(2 * x**2), e(2 * y**2) / e(4 * x * y)).proved
    assert prove_equal(sp.tanh(x + y), (e(2 * x) - e(-2 * y)) / (e(2 * x) + e(-2 * y))).proved
    assert prove_equal(sp.tanh(20 * x), sp.tanh(x)).refuted


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ((sp.exp(2) - 1) / (sp.E - 1), sp.E + 1),
        (2 * sp.cosh(1), sp.E + sp.exp(-1)),
        (sp.log(sp.E * x + sp.exp(2)), 1 + sp.log(x + sp.E)),
        (sp.log(1 + sp.exp(x)), x + sp.log(1 + sp.exp(-x))),
        (sp.log(sp.cosh(x + 1)), x + 1 + sp.log(1 + sp.exp(-2 * x - 2)) - sp.log(2)),
        (sp.log(sp.exp(2 * x) - 1) - sp.log(sp.exp(x) + 1), sp.log(sp.exp(x) - 1)),
        (sp.atan(sp.exp(x)) + sp.atan(sp.exp(-x)), sp.pi / 2),
        (sp.tanh(x) + sp.tanh(7 * x), sp.sinh(8 * x) / sp.cosh(x) / sp.cosh(7 * x)),
        (sp.exp(x / 7) + sp.tanh(x), sp.exp(x / 7) + 1 - 2 / (sp.exp(2 * x) + 1)),
    ],
    ids=str,
)
def test_identities_between_exponentials_are_proved(left, right):
    assert prove_equal(left, right).proved

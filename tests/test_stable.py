"""What is computed neither overflows nor cancels where the value is an ordinary number."""

from __future__ import annotations

import shutil
from functools import cache
from random import Random

import mpmath as mp
import numpy as np
import pytest
import symengine as se
import sympy as sp
from test_program import c_function

import voronec as vo
from voronec import Fibration, System, velocity
from voronec.algebra.numeric_functions import elementary
from voronec.algebra.stable import stable_all
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.equations.program import Program, compile_program
from voronec.equations.program.taylor import taylor_system

x, y = sp.symbols("x y", real=True)
v = velocity(x)

SMALL, LARGE = (1e-20, -1e-9, 0.3, 3.0), (300.0, -300.0, 40.0, -40.0)
HUGE = (1e200, -3e200, 1e-200, 3.0)
CASES = {
    sp.sqrt(x**2 + 4 * y**2): HUGE, -x / sp.sqrt(x**2 + y**2): HUGE, sp.sqrt(1 + x**2): HUGE,
    sp.log(1 + sp.exp(x)): (*SMALL, *LARGE, 800.0), sp.log(2 + 3 * sp.exp(2 * x)): (800.0, -800.0),
    sp.log(sp.cosh(x)): (3.0, 800.0, -800.0), sp.log(sp.cosh(x) + 2): (0.1, 800.0, -800.0),
    sp.log(1 + x): SMALL, sp.log(1 + x * y): SMALL, sp.exp(x) - 1: (*SMALL, -800.0),
    2 * sp.exp(-x / 2) - 2: SMALL, y * sp.exp(x) - y + x: SMALL,
    sp.tanh(x) / x: (*SMALL, 800.0, -800.0),
    1 / sp.cosh(x): (*SMALL, *LARGE), 1 / sp.cosh(x) ** 4: (3.0, 40.0, -40.0),
    1 / (1 + sp.exp(x)) ** 3: (3.0, 40.0, -800.0), sp.exp(x) / (1 + sp.exp(x)): LARGE,
    sp.sinh(x) / sp.cosh(x) ** 3: (*SMALL, 40.0, -40.0),
    1 - sp.cos(x): SMALL, y - y * sp.cos(2 * x): SMALL,
    sp.sqrt(1 + x) - 1: SMALL, 2 * y - y * sp.sqrt(4 + x): SMALL,
    sp.sqrt(1 + x**2) - 1: (*SMALL, *HUGE[:2]), sp.sqrt(1 + x**2 * y + x) - 1: SMALL,
    sp.diff(sp.sin(x) / x, x): SMALL, (x * sp.cos(x) - sp.sin(x)) / x**2: SMALL,
    sp.diff(sp.sin(x * y) / x, x): SMALL,
    sp.diff(sp.sin(x) ** 2 / x**2, x): SMALL,
    sp.cot(x) - 1 / x: SMALL, x / sp.sinh(x): (*SMALL, 40.0),
    x**2 / (1 - sp.cos(x)): SMALL, x / sp.tan(x): SMALL, x / (sp.exp(x) - 1): (*SMALL, 40.0),
    sp.log(1 + x) / x: SMALL, sp.log(1 + x * y) / (x * y): SMALL, x / sp.log(1 + x): SMALL,
    sp.atan(x) / x: (*SMALL, 0.2, -0.26, 300.0), sp.atan(2 * x) / x: SMALL,
    sp.exp(-x / 5) / (1 + sp.exp(20 * (5 - x))): (-4.0, 4.9, 5.1, 40.0, 80.0),
    sp.exp(-x / 3) / sp.cosh(10 * x): (*SMALL, 3.0), 1 / (1 + sp.exp(x**2)): (20.0, 0.1),
    (sp.exp(2 * x) + sp.exp(x) + 3) ** -4: (0.3, -300.0, 80.0),
    sp.diff(1 / (2 + sp.exp(2 * x) + sp.exp(x)), x, 3): (0.3, -3.0),
    (sp.exp(x / 3) - 5 * sp.exp(3 * x) + 1) / (sp.exp(2 * x) + sp.exp(x) + 3) ** 4: (0.3, 3.0),
    (sp.exp(x) / 2 + sp.exp(2 * y - 3 * x)) * sp.exp(-x) - sp.tanh(x - 2 * y): (0.3, 3.0),
    (3 * sp.cosh(2 * x) - 5 * sp.exp(-2 * x - 2) - sp.exp(2 * (x - y) / 3)) * sp.exp(2 * x + 2 * y):
        (0.3, 2.0),
    (sp.exp(y - x) / 2 - 5 * sp.exp(x + y)) / (2 * sp.exp(y - x) + sp.exp(x)): (3.0, -1e4),
    sp.tanh(20 * (x - 5)) * sp.exp(-x / 5): (-3.0, 5.1, 40.0, 80.0),
}  # fmt: skip
"""Forces, and where they are ordinary numbers."""
ROOTS = [e for e in CASES if e.atoms(sp.Pow) and CASES[e] is HUGE]


@cache
def system(force) -> System:
    rate = velocity(y)
    return System(
        name="s", fibration=Fibration((x, y)), lagrangian=(v**2 + rate**2) / 2, forces={x: force}
    )


def taylor_of(program):
    import heyoka as hy

    rows = taylor_system(program)
    function = hy.cfunc([rate for _, rate in rows], [variable for variable, _ in rows])
    return lambda _t, state, _parameters: function(np.array(state))


@pytest.mark.slow
@pytest.mark.parametrize("force", CASES, ids=str)
def test_every_emitter_has_the_digits_of_many_digits(force, tmp_path):
    made, written = vo.derive(system(force)), {}
    exec(made.python(), written)
    program = Program.of(made.form)
    functions = [written["rhs"], compile_program(program)[0], compile_program(program, True)[0]]
    functions += [c_function(made.c(), tmp_path, 4)] if shutil.which("cc") else []
    functions += [taylor_of(program)] if force not in ROOTS else []  # there states have units
    for place in CASES[force]:
        with mp.workdps(1500):
            truth = float(sp.lambdify((x, y), force, "mpmath")(mp.mpf(place), mp.mpf(1)))
        value = pytest.approx(truth, rel=3e-14, abs=0)
        state = [place, 1.0, 0.0, 0.0]
        assert [float(f(0.0, state, [])[2]) for f in functions] == [value] * len(functions), place
        point = {x: place, y: 1, v: 0, velocity(y): 0}
        theirs = vo.multiplier_acceleration(system(force), point, 20)
        for found in (made.acceleration(point, 20), theirs):
            assert float(found[x]) == value


@pytest.mark.parametrize("force", CASES, ids=str)
def test_what_is_computed_equals_what_was_given(force):
    bridge = SymPyBridge()
    (found,) = stable_all([bridge.inward(force)])
    outward = sp.lambdify((x, y), bridge.outward(elementary(found)), "mpmath")
    given = sp.lambdify((x, y), force, "mpmath")
    with mp.workdps(60):
        for place in (mp.mpf("-1.7"), mp.mpf("0.4"), mp.mpf(2)):
            if not (force.has(sp.log(1 + x)) or force.has(sp.log(1 + x * y))) or place > 0:
                assert abs(outward(place, 3) - given(place, mp.mpf(3))) < mp.mpf(10) ** -50


@pytest.mark.parametrize("method", ["scipy", "heyoka", "flint"])
@pytest.mark.parametrize("unit", [1e200, 1e-200])
def test_friction_against_the_slip_has_its_direction_in_any_unit(unit, method):
    """Dry friction in the plane, v' = -mu v/|v|: a straight line, the speed falls evenly."""
    u, w = velocity(x), velocity(y)
    slip = sp.sqrt(u**2 + w**2)
    disc = System(
        name="disc", fibration=Fibration((x, y)), lagrangian=(u**2 + w**2) / 2,
        forces={x: -sp.Symbol("mu") * u / slip, y: -sp.Symbol("mu") * w / slip},
        parameters=(vo.Parameter(sp.Symbol("mu"), positive=True),),
    )  # fmt: skip
    start = {u: 3 * unit, w: -4 * unit}
    run = vo.integrate(disc, times=[0, 1], parameters={"mu": unit}, initial=start, method=method)
    assert float(run["xdot"][-1]) == pytest.approx(2.4 * unit, rel=1e-12)
    assert float(run["y"][-1]) == pytest.approx(-0.8 * 4.5 * unit, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["scipy", "heyoka", "flint"])
def test_a_soft_switch_throws_back(method):
    """A force from the potential log(1 + exp(k x))/k, steep and flat to the last digit outside."""
    k = 50
    potential = 4 * sp.log(1 + sp.exp(k * x)) / k
    switch = System(
        name="switching surface", fibration=Fibration(x), lagrangian=v**2 / 2 - potential
    )
    run = vo.integrate(switch, times=[0, 4], initial={x: -1, v: 1}, method=method)
    with mp.workdps(50):

        def height(s):
            return mp.mpf(4) * mp.log(1 + mp.exp(k * s)) / k

        energy = mp.mpf(1) / 2 + height(-1)
        top = mp.findroot(lambda s: height(s) - energy, 0.125)

        def time_from(place):  # s = top - r^2 takes away the root at the turning point
            nodes = [mp.mpf("1e-15"), *mp.linspace(0, mp.sqrt(top - place), 12)[1:]]
            return mp.quad(lambda r: 2 * r / mp.sqrt(2 * (energy - height(top - r * r))), nodes)

        passed = time_from(mp.mpf(-1)) + time_from(mp.mpf(float(run["x"][-1])))
    assert float(passed) == pytest.approx(4, abs=1e-9)


@pytest.mark.parametrize("name", "sech csch asec acsc asech acsch acoth".split())
def test_reciprocal_functions_have_the_values_of_mpmath(name):
    """In both routes, in generated Python and in a run."""
    at = sp.Rational(1, 2) if name in ("sech", "csch", "asech", "acsch") else sp.Rational(3, 2)
    q = sp.Symbol("q")
    force = getattr(sp, name)(q)
    system = System(
        name=name, fibration=Fibration(q), lagrangian=velocity(q) ** 2 / 2, forces={q: force}
    )
    with mp.workdps(40):
        truth = getattr(mp, name)(mp.mpf(at.p) / at.q)
    point = {q: at, velocity(q): 0}
    found = vo.derive(system).acceleration(point, 30)[q]
    other = vo.multiplier_acceleration(system, point, 30)[q]
    assert abs(found - sp.Float(truth, 40)) < 1e-28 and abs(other - found) < 1e-28
    space: dict = {}
    exec(vo.derive(system).python(), space)
    assert space["rhs"](0.0, [float(at), 0.0], [])[1] == pytest.approx(float(truth), rel=1e-15)
    assert vo.prove_equal(sp.sech(q) ** 2, 1 - sp.tanh(q) ** 2).proved


@pytest.mark.parametrize("at", [0.0, 0.3, 1.0, -1.0])
@pytest.mark.parametrize(("k", "n"), [(2, 3), (1, 2), (4, 6), (2, 4)])
def test_ratios_of_hyperbolic_cosines_do_not_overflow(k, n, at):
    """cosh(500 k x)/cosh(500 n x), neither argument a multiple of the other, in doubles."""
    q = sp.Symbol("q")
    force = sp.cosh(500 * k * q) / sp.cosh(500 * n * q)
    system = System(
        name="ratio", fibration=Fibration(q), lagrangian=velocity(q) ** 2 / 2, forces={q: force}
    )
    program = Program.of(vo.derive(system).form)
    found = compile_program(program, scalar=True)[0](0.0, [at, 0.0], [])[1]
    with mp.workdps(30):
        truth = mp.cosh(500 * k * mp.mpf(at)) / mp.cosh(500 * n * mp.mpf(at))
    assert found == pytest.approx(float(truth), rel=1e-12, abs=1e-300)


def test_an_exponential_and_its_inverse_do_not_overflow():
    """exp(-x^2) + x, which a normal form writes as exp(-x^2) (1 + x exp(x^2))."""
    q = sp.Symbol("q")
    force = velocity(q) * (sp.exp(-(q**2)) + q)
    system = System(
        name="drag", fibration=Fibration(q), lagrangian=velocity(q) ** 2 / 2, forces={q: force}
    )
    rates = compile_program(Program.of(vo.derive(system).form), scalar=True)[0]
    for at in (0.5, 3.0, 40.0):
        assert rates(0.0, [at, 2.0], [])[1] == pytest.approx(2 * (np.exp(-(at**2)) + at), rel=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["heyoka", "scipy", "c"])
@pytest.mark.parametrize(
    "force", [lambda w: sp.sin(w) / w, lambda w: (1 - sp.cos(w)) / w**2, lambda w: sp.tan(w) / w]
)
def test_quotients_of_sines_of_sums_have_a_value_where_the_sum_vanishes(force, method):
    """A normal form expands sin(x - 2 y): numbers are computed without one.  The difference
    moves as a coordinate of its own does."""
    w, dy = x - 2 * y, velocity(y)
    pair = System(
        name="pair", fibration=Fibration((x, y)), lagrangian=(v**2 + dy**2) / 2,
        forces={x: force(w)},
    )  # fmt: skip
    one = System(name="one", fibration=Fibration(x), lagrangian=v**2 / 2, forces={x: force(x)})
    start = {x: 2, y: 1, v: 0.1, dy: 0.0}
    found = vo.integrate(pair, initial=start, times=[0, 0.5], method=method)
    truth = vo.integrate(one, initial={x: 0, v: 0.1}, times=[0, 0.5], method=method)
    assert abs(found["x"][-1] - found["y"][-1] * 2 - truth["x"][-1]) < 1e-13
    space = {}
    exec(vo.derive(pair).python(), space)
    for gap in (0.0, 1e-8, 1e-3):
        exact = float(sp.limit(force(x), x, 0)) if not gap else float(force(sp.Float(gap, 60)))
        assert space["rhs"](0, [gap, 0, 0, 0], [])[2] == pytest.approx(exact, rel=1e-15)


def test_a_sum_keeps_a_term_that_another_becomes():
    """1 - cos x becomes 2 sin^2(x/2), and one of these was lost where both stood."""
    whole, near = sp.sin(x / 2) ** 2 * 2, sp.Rational(1, 10**10)
    bridge = SymPyBridge()
    both, apart = stable_all(
        [bridge.inward(1 - sp.cos(x) + whole), bridge.inward(1 + near - sp.cos(x))]
    )
    assert float(both.subs({bridge.inward(x): 1}).n(53)) == pytest.approx(2 * (1 - np.cos(1)))
    assert float(apart.subs({bridge.inward(x): 1e-5}).n(53)) == pytest.approx(1.5e-10, rel=1e-9)


def random_sum(dice, depth=1):
    """A sum of products of what is written otherwise, with what it would cancel against."""
    a, b, c = (se.Symbol(name) for name in "xyc")
    w = dice.choice([a, 2 * a, a / 2, a * b, a**2])
    known = [
        se.cos(w), se.cosh(w), se.exp(w), se.exp(-w), se.sin(w), se.sinh(w), se.tanh(w), se.tan(w),
        se.sqrt(1 + w**2), se.sqrt(4 + w**2), se.log(1 + w**2), se.sin(w / 2) ** 2, w * se.sin(w),
        w * se.cos(w), w * se.exp(w), w * se.cosh(w), se.atan(w), w, 1 / (1 + se.exp(w)),
    ]  # fmt: skip
    factor = dice.choice([1, -1, 2, -2, c, -c, b, 2 * c, c * a, 1 / a, 1 / a**2])
    if depth and dice.random() < 0.35:
        return factor * random_sum(dice, depth - 1)
    terms = [factor * dice.choice([1, dice.choice(known)]) for _ in range(dice.randint(2, 4))]
    return se.Add(*terms, dice.choice([0, -factor, factor]))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_sum_beside_what_it_becomes_keeps_its_value(seed):
    """What is written otherwise may stand in the sum as well: then one was lost."""
    dice = Random(seed)
    place = {"x": sp.Rational(7312, 10000), "y": sp.Rational(3, 7), "c": sp.Rational(13, 11)}

    def value(expr):
        return sp.N(sp.sympify(elementary(expr)).subs(place), 30)

    for _ in range(60):
        given = random_sum(dice)
        given = given.diff(se.Symbol("x")) if dice.random() < 0.3 else given
        (written,) = stable_all([given])
        both = given.expand() + dice.choice([1, 2, -2]) * written
        assert abs(value(stable_all([both])[0]) - value(both)) < 1e-20 * (1 + abs(value(both)))

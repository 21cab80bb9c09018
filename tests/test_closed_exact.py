"""Exact decisions about a motion: signs, rest, multiple roots, rational turns."""

from fractions import Fraction

import pytest
import sympy as sp
from flint import arb, ctx

import voronec as vo
from voronec.closed.arithmetic import (
    angle,
    ball,
    compile_expressions,
    exact,
    precise,
    root,
    vanishes,
)
from voronec.closed.inverted_motion import Turn, turn_of

pytestmark = pytest.mark.slow

R = sp.Rational
x, y = sp.symbols("x y")


@pytest.fixture(scope="module")
def system():
    return vo.load("demchenko")


def test_compiled_expressions_enclose_their_values_at_any_precision():
    expressions = [sp.sqrt(x**2 + y) / 3, sp.atan2(y, -x), x**-3 + sp.pi, sp.acos(y / 9), R(1, 7)]
    function = compile_expressions(expressions, (x, y))
    for bits in (53, 300):
        with precise(bits):
            found = function([ball(R(2, 3)), ball(5)])
        for e, value in zip(expressions, found, strict=True):
            with precise(bits + 60):
                true = ball(e.subs({x: R(2, 3), y: 5}))
                assert value.contains(true.mid())
                assert value.rel_accuracy_bits() > bits - 12


def test_doubles_and_decimals_are_what_they_are():
    assert exact(0.1) == R(3602879701896397, 36028797018963968)
    assert exact(sp.Float(0.5) * x) == x / 2
    with precise(200):
        assert ball(0.1) == arb(0.1)
        assert ball(Fraction(1, 3)).contains(ball(R(1, 3)).mid())


def test_roots_and_angles_hold_at_the_edge_of_their_range():
    with precise(100):
        near_zero = (arb(2).sqrt() ** 2 - 2) * 1
        assert near_zero.contains(0)
        assert root(near_zero).contains(0)
        assert root(near_zero).is_finite()
        half_turn = angle(near_zero, arb(-1))
        assert abs(half_turn - arb.pi()) < arb("1e-20")


@pytest.mark.parametrize(
    ("value", "zero"),
    [
        (sp.sin(R(1, 3)) ** 2 + sp.cos(R(1, 3)) ** 2 - 1, True),
        (sp.sin(R(2, 3)) - 2 * sp.sin(R(1, 3)) * sp.cos(R(1, 3)), True),
        (sp.sin(1) - R(841, 1000), False),
        (sp.sin(R(1, 2)) - sp.cos(R(1, 3)), False),
        (sp.sqrt(2) * sp.sqrt(3) - sp.sqrt(6), True),
        (R(0), True),
    ],
)
def test_numbers_are_proved_to_vanish_or_not_to(value, zero):
    assert vanishes(value) is zero


def test_a_sign_is_decided_however_small_the_number(system):
    form = vo.closed_form(system, initial={"u": R(1), "u1": R(1), "tau": R(1, 10**80), "n": 1})
    own = form.problem.prepared.motion
    assert form.sign(own.constants[sp.Symbol("h2")]) == 1
    assert form.sign(-sp.Symbol("tau")) == -1
    assert form.sign(sp.sin(sp.Symbol("u")) ** 2 + sp.cos(sp.Symbol("u")) ** 2 - 1) == 0


def test_what_is_not_proved_is_not_said(system, monkeypatch):
    monkeypatch.setattr("voronec.closed.problem.vanishes", lambda _: None)
    form = vo.closed_form(system, initial={"u": R(1), "u1": R(1), "n": 1})
    with pytest.raises(vo.EngineLimit, match="cannot be decided"):
        form.sign(sp.sin(sp.Symbol("u")) ** 2 + sp.cos(sp.Symbol("u")) ** 2 - 1)


def precession(u, n):
    """s of a regular precession of the default ball at tau = 0, of the two the algebraic one."""
    s = sp.Symbol("s")
    P, A, mu, k = R(7, 5), R(2, 5), R(3, 2), R(3)
    # P dtau/dt = 0, with dv/dt = s/(mu sin u) [demchenko's equations]
    rate = (
        (mu - 1) * A * n * s / mu - P * s * (n + s * sp.cos(u) / (mu * sp.sin(u)))
        + k * (n * sp.sin(u) + s * sp.cos(u))
    )  # fmt: skip
    return sp.solve(rate, s)


@pytest.mark.parametrize("which", [0, 1])
def test_a_regular_precession_rests_exactly(system, which):
    n = R(3, 2)
    # u with a rational cosine and sine, so that s is an algebraic number
    u = sp.acos(R(3, 5))
    s = precession(u, n)[which]
    initial = {"u": u, "u1": 1, "s": s, "n": n}
    resting = vo.closed_form(system, initial=initial)
    assert resting.rests
    assert resting.kind == "rest"
    moving = vo.closed_form(system, initial={**initial, "s": s + R(1, 10**200)})
    assert not moving.rests
    run = vo.integrate(
        system, times=[0, 2], initial=initial, method="flint", tol=1e-20, outputs=("u", "v1")
    )
    found = resting.enclose(2, 25)
    for name in ("u", "v1"):
        assert abs(float(found[name]) - float(run[name][-1])) < 1e-14


def test_the_level_of_a_precession_has_a_double_root(system):
    n, cosine = R(1, 10), R(3, 5)
    for s in precession(sp.acos(cosine), n):
        resting = vo.closed_form(system, initial={"u": sp.acos(cosine), "u1": 1, "s": s, "n": n})
        factors = resting.problem.source(200).factors
        assert sorted(times for _, times in factors) == [1, 2]
        with ctx.workprec(200):
            (double,) = (f for f, times in factors if times == 2)
            assert abs(-double[0] / double[1] - arb(3) / 5) < arb("1e-40")


@pytest.mark.parametrize(
    ("roots", "multiplicities"),
    [
        ((1, 2, 3, 4), [1]),
        ((1, 1, 2, 3), [1, 2]),
        ((1, 1, 1, 3), [1, 3]),
        ((1, 1, 2, 2), [1, 2]),
        ((1, 1, 1, 1), [1, 4]),
        ((1, 1, 2), [1, 2]),
        ((1, 1), [1, 2]),
        ((1, 2), [1]),
    ],
)
def test_multiplicities_of_roots_are_decided_exactly(roots, multiplicities):
    from types import SimpleNamespace

    from voronec.closed.problem import squarefree

    z = sp.Symbol("z")
    shift = sp.sqrt(2)
    poly = sp.Poly(3 * sp.prod(z - shift - r for r in roots), z)
    row = [poly.coeff_monomial(z**i) for i in range(5)]
    problem = SimpleNamespace(
        prepared=SimpleNamespace(quartic=row),
        sign=lambda e: 0 if sp.simplify(e) == 0 else 1,
    )
    with precise(200):
        factors = squarefree(problem, [ball(sp.expand(c)) for c in row])
        assert sorted(times for _, times in factors) == multiplicities
        at = ball(R(1, 3))
        product = arb(1)
        for factor, times in factors:
            product *= sum((c * at**i for i, c in enumerate(factor)), arb(0)) ** times
        assert product.overlaps(ball(sp.expand(poly.as_expr().subs(z, R(1, 3)))))


def test_where_nothing_moves_there_are_no_roots(system):
    still = {"u": R(1), "u1": 1, "s": 0, "tau": 0, "n": 0}
    assert vo.closed_form(system, initial=still, parameters={"k": 0}).roots == ()
    form = vo.closed_form(system, initial=still)
    assert form.kind == "rest"
    assert len(form.roots) == 4
    assert set(form.arguments.values()) == {None}


def test_rational_turns_are_told_from_near_ones():
    with precise(200):
        turn = 2 * arb.pi()
        assert turn_of(turn * 355 / 113).fraction == Fraction(355, 113)
        assert turn_of(turn * (arb(1) / 3 + arb("1e-40"))).fraction is None
        assert turn_of(turn / 1009).fraction is None


def test_theta_swings_on_the_default_motion(system):
    turns = vo.closed_form(system).turns
    assert turns["theta"] == Turn(turns["theta"].advance, Fraction(0))
    assert turns["v"].fraction is None

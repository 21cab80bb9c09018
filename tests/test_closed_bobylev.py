"""Bobylev's ball in closed form, whose quartic is in a time of its own; places on a plane."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy as sp
from flint import arb, ctx

import voronec as vo

pytestmark = pytest.mark.slow

R = sp.Rational
OBLATE, PROLATE, ROUND = R(3, 5), R(3, 10), R(2, 5)
MOMENTS = {
    "C > A": OBLATE,
    "C < A": PROLATE,
    "C = A": ROUND,
    "C - A = 1e-6": ROUND + R(1, 10**6),
    "A - C = 1e-12": ROUND - R(1, 10**12),
}
START = {
    "u": R(2), "v": R(3, 10), "theta": R(7, 10), "x": R(1, 2), "y": -R(1, 3),
    "omega1": R(1, 2), "omega2": R(1), "omega3": R(1),
}  # fmt: skip


@pytest.fixture(scope="module")
def ball():
    return vo.load("bobylev-ball")


def names_of(system):
    return [str(q) for q in (*system.coordinates, *system.velocities)]


def apart(ball, number):
    with mpmath.workdps(45):
        return abs(float(mpmath.mpf(ball.str(45, radius=False)) - number))


@pytest.mark.parametrize("case", MOMENTS)
def test_enclosures_agree_with_an_integration_in_many_digits(ball, case):
    parameters, names = {"C": MOMENTS[case]}, names_of(ball)
    form = vo.closed_form(ball, parameters=parameters, initial=START)
    run = vo.integrate(
        ball, times=[0, 2], outputs=names, parameters=parameters, initial=START,
        method="flint", tol=1e-30,
    )  # fmt: skip
    found = form.enclose(2, 35)
    for name in names:
        assert float(found[name].rad()) < 1e-35
        assert apart(found[name], run[name][-1]) < 3e-30, name


@pytest.mark.parametrize("case", MOMENTS)
def test_doubles_agree_with_enclosures_at_every_phase_and_late(ball, case):
    form = vo.closed_form(ball, parameters={"C": MOMENTS[case]}, initial=START)
    times = np.concatenate([np.linspace(-1.3, 1.3, 9) * form.period, [987.65, 1234567.8]])
    rough, wrapped = form.at(times), form.modulo(times)
    turns, straight = form.turns, {"x", "y"}
    assert {*turns} == {"v", "theta"}
    for i, t in enumerate(times):
        exact = form.enclose(float(t), 20)
        for name, ball_ in exact.items():
            size = max(1.0, abs(float(ball_)))
            assert abs(float(arb(float(rough[name][i])) - ball_)) < 1e-14 * size, (name, t)
            if name not in straight:
                with ctx.workprec(150):
                    off = (arb(float(wrapped[name][i])) - ball_) / (2 * arb.pi())
                    off -= round(float(off))
                assert abs(float(off)) < 2e-15, (name, t)


def test_a_hundred_digits_at_a_late_time_are_those_of_sixty(ball):
    form = vo.closed_form(ball, parameters={"C": PROLATE}, initial=START)
    t = Fraction(10**12, 7)
    more, less = form.enclose(t, 100), form.enclose(t, 60)
    for name in more:
        assert float(more[name].rad()) < 1e-100
        assert less[name].overlaps(more[name])


@pytest.mark.parametrize("moment", [OBLATE, PROLATE, ROUND])
def test_integrals_are_constant_to_forty_digits_however_late(ball, moment):
    form = vo.closed_form(ball, parameters={"C": moment}, initial=START)
    known = {p.symbol: moment if str(p.symbol) == "C" else p.value for p in ball.parameters}
    symbols = {**{q: str(q) for q in ball.coordinates}, **{v: str(v) for v in ball.velocities}}
    meaning = {sp.Symbol(f"gamma{i}"): ball.invariants[f"gamma{i}"] for i in (1, 2, 3)}
    first, last = form.enclose(0, 45), form.enclose(Fraction(10**9, 3), 45)
    for expr in ball.integrals.values():
        read = expr.xreplace(meaning).subs(known)
        f = sp.lambdify(tuple(symbols), read, "mpmath")
        with mpmath.workdps(50):
            one, two = (
                f(*(mpmath.mpf(state[n].str(50, radius=False)) for n in symbols.values()))
                for state in (first, last)
            )
            assert abs(one - two) < mpmath.mpf(10) ** -40


def test_a_trajectory_of_the_closed_form_is_that_of_an_integration(ball):
    times = np.linspace(0, 20, 5)
    closed, other = (
        vo.integrate(ball, times=times, initial=START, outputs=names_of(ball), method=m, tol=1e-13)
        for m in ("closed-form", "scipy")
    )
    assert closed.cost.method == "closed-form"
    for name in names_of(ball):
        assert (
            np.abs(np.asarray(closed[name], float) - np.asarray(other[name], float)).max() < 1e-10
        )
    fine = vo.integrate(ball, times=[0, 3], initial=START, outputs=("x", "y"),
                        method="closed-form", tol=1e-25)  # fmt: skip
    exact = vo.closed_form(ball, initial=START).enclose(3, 30)
    assert all(apart(exact[n], fine[n][-1]) < 1e-24 for n in ("x", "y"))


def test_the_period_and_the_turns_are_in_the_time_itself(ball):
    form = vo.closed_form(ball, initial=START)
    one, two = form.at([1.0, 1.0 + form.period], ["u", "v", "theta"]).values(), form.turns
    u, v, theta = one
    assert u[1] == pytest.approx(u[0], abs=1e-14)
    assert v[1] - v[0] == pytest.approx(two["v"].advance, abs=1e-13)
    assert theta[1] - theta[0] == pytest.approx(two["theta"].advance, abs=1e-13)


def without_direction(system, value):
    """A start at which momentum has no horizontal part: value(s) = 0 for the spin s along e_u."""
    s, n = sp.Symbol("s"), R(1, 3)
    u, v = (system.coordinates[i] for i in (0, 1))
    contact = vo.kinematics.RollingBall.on_plane(1, 1, (R(2, 5),) * 3)
    own = contact.contact.body.frame.subs(dict(zip(contact.base[:2], (u, v), strict=True)))
    spin = own.subs({u: 2, v: START["v"]}) * sp.Matrix([s, 0, n])
    found = sp.solve(value(s, spin[2]), s)[0]
    return {**START, **{f"omega{i + 1}": sp.expand(e.subs(s, found)) for i, e in enumerate(spin)}}


def test_a_motion_that_tends_to_a_limit_for_ever_is_found_exactly(ball):
    """(dz/dt)^2 = 9/56 z^2 - 625/3136 z^4 has a double root."""
    start = {
        "u": sp.acos(R(1, 10)), "omega1": -5 * sp.sqrt(11) / 672, "omega2": sp.sqrt(181) / 336,
        "omega3": -R(225, 224),
    }  # fmt: skip
    form = vo.closed_form(ball, parameters={"C": ROUND}, initial=start)
    assert form.period == float("inf") and not form.rests
    times = np.array([-3.0, 2.0, 10.0, 60.0])
    rough = form.at(times)
    for i, t in enumerate(times):
        for name, exact in form.enclose(float(t), 25).items():
            assert abs(rough[name][i] - float(exact)) < 2e-15 * max(1, abs(float(exact))), name
    assert rough["u"][-1] == pytest.approx(np.pi / 2, abs=1e-8)


@pytest.mark.parametrize(("name", "excess"), [("zhukovsky-ball", 0), ("bobylev-ball", R(1, 5))])
def test_without_horizontal_momentum_the_contact_goes_round_a_circle(name, excess):
    system, k = vo.load(name), R(1, 2)
    start = without_direction(
        system, lambda s, third: R(7, 5) * s - (excess * third + k) * sp.sin(2)
    )
    form = vo.closed_form(system, initial=start)
    assert form.rests
    names = names_of(system)
    run = vo.integrate(system, times=[0, 2], outputs=names, initial=start, method="flint",
                       tol=1e-25)  # fmt: skip
    exact, rough = form.enclose(2, 30), form.at([2.0], names)
    for n in names:
        assert apart(exact[n], run[n][-1]) < 1e-24, n
        assert abs(float(rough[n][0]) - float(exact[n])) < 1e-15, n


@pytest.mark.parametrize("moment", [OBLATE, PROLATE, ROUND])
def test_spinning_about_its_axis_the_ball_rolls_straight(ball, moment):
    start = {"u": R(1), "v": 0, "theta": R(1, 2), "omega1": 0, "omega2": 0, "omega3": 1}
    form = vo.closed_form(ball, parameters={"C": moment}, initial=start)
    assert form.rests
    late = form.enclose(100, 30)
    assert late["u"].contains(1) and late["omega3"].contains(1)
    run = vo.integrate(ball, times=[0, 100], outputs=("x", "y", "v"), initial=start,
                       parameters={"C": moment}, method="scipy", tol=1e-13)  # fmt: skip
    found = form.at([100.0], ("x", "y", "v"))
    assert all(found[n][0] == pytest.approx(run[n][-1], abs=1e-10) for n in found)


def test_a_share_that_vanishes_identically_is_exactly_zero():
    form = vo.closed_form(vo.load("demchenko"))
    for integral in form.problem.source(200).integrals:
        for value in (integral.constant, integral.linear, integral.square):
            assert value.is_zero() or not value.contains(0)


def test_an_advance_that_is_no_turn_at_all_is_shown_as_zero():
    from voronec.closed.inverted_motion import turn_of

    turn = turn_of(arb(-2.9e-77))
    assert turn == vo.closed.Turn(0.0, Fraction(0))


def off_from_enclosures(form, t, wrap):
    """By how much doubles miss balls: coordinates by their size, velocities by the largest one."""
    found, exact = (form.modulo if wrap else form.at)([t]), form.enclose(t, 25)
    fastest = max(abs(float(exact[f"omega{i}"])) for i in (1, 2, 3))
    off = {}
    for name, x in exact.items():
        size = max(1.0, fastest if name.startswith("omega") else abs(float(x)))
        with ctx.workprec(150):
            gap = arb(float(found[name][0])) - x
            if wrap and name in ("v", "theta"):
                gap -= 2 * arb.pi() * round(float(gap / (2 * arb.pi())))
                size = 1.0
        off[name] = abs(float(gap)) / size
    return off


@pytest.mark.parametrize("name", ["zhukovsky-ball", "bobylev-ball"])
@pytest.mark.parametrize("late", [12345.678, 1e9, -1e9 / 3])
def test_late_states_have_all_digits_however_many_turns(name, late):
    start = {**START, "omega1": R(700), "omega2": R(-900), "omega3": R(400)}
    form = vo.closed_form(vo.load(name), initial=start)
    assert 1e9 / form.period > 2**27  # whole periods times 26 bits are no longer exact
    assert max(off_from_enclosures(form, late, False).values()) < 1e-14
    assert max(off_from_enclosures(form, late, True).values()) < 1e-14


def test_more_periods_than_doubles_count_are_refused(ball):
    form = vo.closed_form(ball, initial=START)
    with pytest.raises(vo.EngineLimit, match="enclose that time"):
        form.at([1e14])


@pytest.mark.parametrize("name", ["zhukovsky-ball", "bobylev-ball"])
@pytest.mark.parametrize("small", ["1e-4", "1e-9", "1e-14"])
def test_places_where_the_vector_in_the_plane_nearly_vanishes(name, small):
    system = vo.load(name)
    start = {"u": R("1.1"), "v": R(0), "theta": R(7, 10), "x": R(1, 2), "y": -R(1, 3)}
    known = {**start, **{str(p.symbol): p.value for p in system.parameters}, "omega3": 1}
    # linear in the rest: two of the velocities are left to be found
    vector = [sp.N(e.subs(known)) for e in system.motion.plane.direction]
    (turn,) = sp.linsolve(vector, *sp.symbols("omega1 omega2"))
    turning = {f"omega{i + 1}": R(float(x)) for i, x in enumerate(turn)}
    turning["omega1"] += R(small)
    form = vo.closed_form(system, initial={**start, **turning, "omega3": R(1)})
    assert 0.1 < form.constants["H"] / float(small) < 10
    for t in (0.3 * form.period, -1.7 * form.period, 1e6):
        assert max(off_from_enclosures(form, t, False).values()) < 1e-13


def test_doubles_at_a_start_next_to_a_pole_are_those_of_the_start(ball):
    start = {**START, "u": sp.pi - R(1, 10**20)}
    found = vo.closed_form(ball, parameters={"C": PROLATE}, initial=start).at([0])
    for name, value in start.items():
        assert found[name][0] == pytest.approx(float(value), abs=1e-12), name

"""Regular precessions, motions at the poles, remarkable trajectories and the ordinary ball."""

from __future__ import annotations

import dataclasses
import math
from itertools import product

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.closed.special import (
    elementary,
    linear_matrix,
    precessions,
    pseudo_regular,
    remarkable,
)
from voronec.closed.special.precessions import upright

pytestmark = pytest.mark.slow

R = sp.Rational
m, A, R1, R2, M, k = sp.symbols("m A R1 R2 M k")
u, s, tau, n = sp.symbols("u s tau n")
DIMENSIONLESS = {"R2": 1, "M": 1, "R1": 1 / m, "k": 1}
INNER = {"R1": -3, "R2": 1, "M": 1, "A": R(2, 5), "k": 3}


@pytest.fixture(scope="module")
def demchenko():
    return vo.load("demchenko")


@pytest.fixture(scope="module")
def family(demchenko):
    return precessions(demchenko)


@pytest.fixture(scope="module")
def bare(demchenko):
    """In units of the ball's M, R2 and of k; m = R2/R1."""
    return precessions(demchenko, DIMENSIONLESS)


def numbers(family, parameters, place, rate):
    return family.numbers(place, rate, parameters)


def start_at(system, place, velocities, parameters):
    """A scene with the momentum upright."""
    x = sp.sympify(place)
    values = {p.symbol: sp.sympify(parameters.get(p.name, p.value)) for p in system.parameters}
    state = {sp.Symbol(name): sp.sympify(e) for name, e in velocities.items()}
    known = {**state, **values}
    angles = upright(system.motion.space, known, u, x, sp.sqrt(1 - x**2))
    return vo.Scene(initial={u: sp.acos(x), **state, **angles}, parameters=values)


# -- the family -------------------------------------------------------------------------------


def test_the_essential_variables_rest_on_the_whole_family(family):
    assert family.proved().proved


@pytest.mark.parametrize("name", ["bobylev-ball", "zhukovsky-ball"])
def test_a_family_in_letters_is_followed_by_the_equations(name):
    """The variable of Bobylev's ball is no cosine, and its velocities turn with an angle."""
    ball = vo.load(name)
    family = precessions(ball)
    assert family.proved().proved
    wrong = {c: e + int(str(c) == "C5") for c, e in family.constants.items()}
    assert dataclasses.replace(family, constants=wrong).proved().refuted
    at = family.numbers(R(1, 5), R(1, 2), {})
    angle, cosine = family.colatitude
    u = sp.acos(cosine.xreplace(at))
    place = {**at, angle: u, sp.Symbol("v"): 0, sp.Symbol("theta"): 0}
    start = {str(q): sp.N(e.xreplace(place)) for q, e in family.state.items()}
    motion = vo.integrate(
        ball, initial={"u": u, "v": 0, "theta": 0, **start}, times=np.linspace(0, 5, 6),
        outputs=("u", "v", "theta"), method="scipy",
    )  # fmt: skip
    assert np.ptp(motion["u"]) < 1e-9
    for q, rate in family.rates.items():
        found = float(rate.xreplace(dict(family.levels)).xreplace(at))
        assert np.abs(motion[str(q)] - found * motion.t).max() < 1e-9


def test_a_wrong_family_is_not_at_rest(family):
    constants = {c: e * (2 if str(c) == "C5" else 1) for c, e in family.constants.items()}
    assert dataclasses.replace(family, constants=constants).proved().refuted


def test_the_quartic_has_a_double_root_on_the_family(family):
    assert family.derivative(0) == 0
    assert family.derivative(1) == 0


def test_the_linearised_equations_have_the_same_frequency(bare):
    # another route: the matrix comes from the equations of motion, f'' from the quartic
    z = sp.Symbol("z")
    found = (z * sp.eye(4) - linear_matrix(bare)).det(method="laplace")
    assert vo.prove_equal(found, z**2 * (z**2 - bare.derivative(2) / 2)).proved


def test_the_second_derivative_splits_into_equator_and_pole(bare):
    x, w = bare.place, bare.rate
    P, b0, b1 = 1 + A, 1 + m + 2 * A, 1 + m + A
    equator = P * (1 - b1 * w) ** 2 * (A * P * w**2 - b0 * w + 1)
    pole = A * (P * b1 * w**2 - 2 * P * w + 1) ** 2
    whole = -2 * ((1 - x**2) * equator + x**2 * pole) / (A * P**2 * (1 - b1 * w) ** 2)
    assert vo.prove_equal(bare.derivative(2), whole).proved


def test_rates_and_frequency_are_those_of_an_integration(demchenko, family):
    scene = family.scene(R(1, 3), 1, aside=R(1, 10**5))
    at = numbers(family, {}, R(1, 3), 1)
    times = np.linspace(0, 60, 6001)
    run = vo.integrate(demchenko, scene=scene, times=times, outputs=("u", "v", "v1"))
    away = np.cos(run["u"]) - 1 / 3
    up = np.flatnonzero((away[1:] > 0) & (away[:-1] <= 0))
    period = (times[up[-1]] - times[up[0]]) / (len(up) - 1)
    assert abs(2 * math.pi / period - float(family.frequency.xreplace(at))) < 2e-3
    rest = vo.integrate(demchenko, scene=family.scene(R(1, 3), 1), times=times)
    assert np.ptp(rest["u"]) < 1e-10
    for name in ("v", "v1"):
        rate = family.rates[sp.Symbol(name)].xreplace(dict(family.levels)).xreplace(at)
        assert abs((rest[name][-1] - rest[name][0]) / 60 - float(rate)) < 1e-10


def test_no_family_without_quadratures():
    with pytest.raises(vo.DefinitionError, match="declares no quadratures"):
        precessions(vo.load("rattleback"))


@pytest.mark.parametrize("order", [-1, 5, 2.0, "2", None])
def test_a_derivative_of_no_such_order_is_refused(family, order):
    with pytest.raises(vo.DefinitionError, match="give a whole number from 0 to 4"):
        family.derivative(order)


def test_a_place_outside_is_refused(family):
    with pytest.raises(vo.DefinitionError, match="not between -1 and 1"):
        family.stability(2, 1)


# -- stability --------------------------------------------------------------------------------


@pytest.mark.parametrize(("rate", "stable"), [(R(1), True), (R(3), False)])
def test_stability_at_the_equator_is_seen_in_motions_nearby(demchenko, family, rate, stable):
    found = family.stability(0, rate)
    assert found.stable is stable
    assert found.order == 2
    low, high = vo.closed_form(demchenko, family.scene(0, rate, aside=R(1, 10**6))).ends
    assert (high - low < 1e-5) is stable
    assert (high - low > 0.1) is not stable


def test_every_precession_is_stable_where_the_leading_coefficient_is_positive(bare):
    # f'''' > 0 is I mu^2 + 4 A mu' < 0; the factor at the equator has then no real root
    w = bare.rate
    leading = bare.derivative(4)
    root = 1 + 2 * m + m**2 + 4 * A * m
    assert vo.prove_equal(leading, -6 * root / (A**2 * (1 + A) ** 2)).proved
    factor = A * (1 + A) * w**2 - (1 + m + 2 * A) * w + 1
    assert vo.prove_equal(sp.discriminant(factor, w), root).proved


def test_a_double_zero_of_second_and_third_derivative_is_stable_for_outer_rolling(family):
    # the edges of the unstable equator: A P w^2 - b0 k w + k^2 = 0, with I = 1, mu' = 1, A = 1/4
    values = {"R1": 1, "R2": 1, "M": 1, "A": R(1, 4), "k": 1}
    w = sp.Symbol("w")
    edge = sp.roots(R(5, 16) * w**2 - R(5, 2) * w + 1, w)
    for rate in edge:
        found = family.stability(0, rate, values)
        assert (found.stable, found.order, found.sign) == (True, 4, -1)


def test_a_third_derivative_makes_it_unstable(demchenko, family):
    values = {"R1": 2, "R2": 1, "M": 1, "A": R(2, 5), "k": 3}
    x, w = family.place, family.rate
    at = {p.symbol: values[p.name] for p in demchenko.parameters}
    second = sp.fraction(sp.together(family.derivative(2).xreplace({**at, w: 2})))[0]
    place = next(r for r in sp.roots(second, x) if 0 < r < 1)
    found = family.stability(place, 2, values)
    assert (found.stable, found.order) == (False, 3)


def test_where_the_quartic_vanishes_the_precession_is_unstable_though_both_vanish(
    demchenko, family
):
    # inner rolling with I mu^2 + 4 A mu' = 0, against "stable if X''' = 0"
    values = {"R1": -R(4, 3), "R2": 1, "M": 1, "A": R(1, 48), "k": 1}
    found = family.stability(0, R(48, 7), values)
    assert (found.stable, found.order) == (False, 0)
    low, high = vo.closed_form(demchenko, family.scene(0, R(48, 7), values, aside=R(1, 1000))).ends
    assert low < -0.99 < 0.99 < high


def test_a_place_that_is_no_double_root_is_refused(demchenko):
    from voronec.closed.special.stability import decide_stability

    values = {p.symbol: sp.sympify(p.value) for p in demchenko.parameters}
    constants = {sp.Symbol("C5"): 1, sp.Symbol("S0"): 1, sp.Symbol("h2"): 1}
    with pytest.raises(vo.DefinitionError, match="no double root"):
        decide_stability(demchenko.motion, constants, values, R(1, 2))


# -- stationary motions -----------------------------------------------------------------------


def test_rest_is_stable_with_a_gyroscope(family):
    second = family.derivative(2).xreplace({family.rate: 0, M: 1, R2: 1, R1: 1 / m})
    x = sp.Symbol("q", positive=True)
    inside = second.subs(family.place, x / sp.sqrt(1 + x**2))
    assert vo.prove_inequality(inside, "<", 0, positive=(A, x, k)).proved


def test_a_ball_that_spins_at_a_pole_is_stable_outside(bare):
    for end in bare.ends:
        outer = end.second.subs(m, sp.Symbol("m", positive=True))
        assert vo.prove_inequality(outer, "<", 0, positive=(A,)).proved


def test_inside_it_is_unstable_between_two_spins(bare):
    # k mu / (sqrt(P) +- sqrt(-I mu'))^2, the other way round at the other pole
    q = sp.Symbol("q", positive=True)
    P = sp.Symbol("P", positive=True)
    upper, lower = bare.ends
    for sign in (1, -1):
        edge = -(1 - q**2) / (P + sign * q) ** 2
        put = {m: -(q**2), A: P**2 - 1}
        assert vo.prove_equal(upper.second.xreplace(put).subs(upper.free, edge), 0).proved
        assert vo.prove_equal(lower.second.xreplace(put).subs(lower.free, -edge), 0).proved


def test_at_a_pole_it_is_stable_where_the_quartic_is_negative_inside(demchenko):
    from voronec.closed.special.stability import decide_stability

    family, told = precessions(demchenko, INNER), set()
    for end, spin in product(family.ends, (R(-9, 2), -2, R(-1, 3), R(1, 3), 1, 6)):
        constants = {c: sp.sympify(e).xreplace({end.free: spin}) for c, e in end.constants.items()}
        values = dict(family.values)
        stable = decide_stability(demchenko.motion, constants, values, end.place).stable
        assert stable is bool(end.second.xreplace({**values, end.free: spin}) < 0)
        told.add((end.place, stable))
    assert len(told) == 4


@pytest.mark.parametrize(("spin", "stable"), [(-2, False), (1, True), (-6, True)])
def test_a_motion_shows_it(demchenko, spin, stable):
    place = 1 - R(1, 10**4)
    scene = start_at(demchenko, place, {"s": 0, "tau": 0, "n": spin}, INNER)
    low, _ = vo.closed_form(demchenko, scene).ends
    assert (low > 0.99) is stable
    assert (low < 0.8) is not stable
    run = vo.integrate(demchenko, scene=scene, times=np.linspace(0, 60, 3001), outputs=("u",))
    assert abs(float(np.cos(run["u"]).min()) - low) < 2e-3


@pytest.mark.parametrize(
    ("radius", "inertia", "spin"), [(-2, R(1, 3), R(-3, 4)), (R(-1, 2), R(3, 2), R(4, 5))]
)
def test_the_motions_that_the_audit_names_leave_the_pole(demchenko, radius, inertia, spin):
    values = {"R1": radius, "R2": 1, "M": 1, "A": inertia, "k": 1}
    scene = start_at(demchenko, 1 - R(1, 10**6), {"s": 0, "tau": 0, "n": spin}, values)
    low, _ = vo.closed_form(demchenko, scene).ends
    assert low < 0.5


# -- remarkable trajectories and the ordinary ball --------------------------------------------


def test_the_only_path_for_every_energy_is_the_equator_with_the_axis_along_the_spin(family):
    found = remarkable(family)
    assert found.workless.proved
    assert found.places == (0,)
    x = family.place
    axis = {s: -sp.sqrt(1 - x**2), tau: 0, n: x}  # of the gyroscope, along (u, v, n)
    assert all(vo.prove_equal(found.direction[v], e).proved for v, e in axis.items())


@pytest.mark.parametrize("speed", [R(1, 2), 1, 4])
def test_its_path_is_two_great_circles_at_every_energy(demchenko, speed):
    scene = start_at(demchenko, 0, {"s": speed, "tau": 0, "n": 0}, {})
    run = vo.integrate(demchenko, scene=scene, times=(0, 5))
    assert np.ptp(run["u"]) < 1e-9
    assert np.ptp(run["u1"]) < 1e-9
    assert abs(run["u1"][0] - math.pi / 2) < 1e-12


def test_the_ordinary_ball_moves_by_sines(demchenko):
    scene = start_at(demchenko, R(1, 3), {"s": R(1, 2), "tau": 0, "n": R(3, 2)}, {"k": 0, "R1": 2})
    own = elementary(demchenko, {"k": 0})
    closed = vo.closed_form(demchenko, scene)
    at = {p.symbol: p.value for p in demchenko.parameters}
    at |= {sp.Symbol(name): value for name, value in closed.constants.items()}
    centre, half, pace = (
        float(e.xreplace(at)) for e in (own.centre, own.half_width, own.frequency)
    )
    assert abs(2 * math.pi / pace - closed.period) < 1e-12
    assert np.allclose([centre - half, centre + half], closed.ends, rtol=0, atol=1e-13)
    assert vo.prove_equal(own.rates[sp.Symbol("v")], 0).proved
    # between two states of one nutation v grows by the arc tangents at the poles 1 and -1
    times = np.linspace(0.05, 0.45, 40) * closed.period
    v, x = closed.at(times)["v"], np.cos(closed.at(times)["u"])
    phase = np.arccos(np.clip((x - centre) / half, -1, 1))
    falling = (x[1:] < x[:-1]).all()
    rising = (x[1:] > x[:-1]).all()
    assert falling or rising
    shares = own.shares[sp.Symbol("v")]

    def swung(angle):
        terms = [c * own.periodic_term(p, angle).xreplace(at) for p, c in shares.items()]
        return float(sp.Add(*terms))

    grown = (swung(phase[-1]) - swung(phase[0])) * (1 if falling else -1)
    assert abs(grown - (v[-1] - v[0])) < 1e-9


def test_parameters_that_are_put_in_are_those_of_stability_and_scenes(demchenko):
    whole = precessions(demchenko)
    for put in (INNER, {"R1": -3 * sp.Symbol("R2"), "A": 2 * sp.Symbol("M") / 5}):
        own = precessions(demchenko, put)
        for place, rate in ((0, 3), (R(1, 2), -1)):
            assert own.stability(place, rate) == whole.stability(place, rate, INNER)
            assert own.scene(place, rate).initial == whole.scene(place, rate, INNER).initial
    with pytest.raises(vo.DefinitionError, match="'k' = 4, but the precessions were made with 3"):
        precessions(demchenko, INNER).stability(0, 3, {"k": 4})


def test_expansions_for_a_fast_gyroscope_are_refused_for_a_negative_one(demchenko):
    start = {"x": R(3, 5), "s": R(1, 2), "tau": R(1, 3), "n": R(1, 5)}
    body = {name: value for name, value in INNER.items() if name != "k"}
    expansions = pseudo_regular(demchenko, "k", 1, body, start)
    with pytest.raises(vo.DefinitionError, match="'k' = -50: expansions hold for positive"):
        expansions.at(start, {"k": -50})
    with pytest.raises(vo.EngineLimit, match="give the other parameters numbers"):
        pseudo_regular(demchenko, "k")


def test_precessions_in_a_time_of_their_own_have_velocities_by_that_of_the_system():
    ball = vo.load("bobylev-ball")
    body = {"m": 1, "R": 1, "A": R(2, 5), "C": R(3, 5), "k": R(1, 2)}
    family = precessions(ball, body)
    z, upward = R(1, 5), R(1, 5) / (1 - R(5, 64) / 25)  # cos(u) = z/(1 - beta z^2)
    place = {sp.Symbol("u"): sp.acos(upward), sp.Symbol("v"): 0}
    at = {family.place: z, family.rate: R(1, 2), sp.Symbol("theta"): 0}
    start = {str(q): e.subs({**place, **at}) for q, e in family.state.items()}
    form = vo.closed_form(ball, parameters=body, initial={"u": sp.acos(upward), **start})
    low, high = form.ends
    assert high - low < 1e-12
    assert float(family.frequency.subs(at)) == pytest.approx(0.496884735, abs=1e-9)

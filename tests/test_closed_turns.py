"""Whole turns in closed form: exact for any momentum, however far apart the instants are."""

import importlib
import pickle
import sys
from dataclasses import replace
from math import floor
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from flint import arb, ctx
from test_closed_form import START, R

import voronec as vo
from voronec.closed.passages import certain_floor_sum, first_doubt, floor_sum, tally
from voronec.closed.winding import winding_of

pytestmark = pytest.mark.slow

TOOLS = Path(__file__).resolve().parent.parent / "tools"
ANGLES = ("v", "v1", "theta")
STRAIGHT = {"u": sp.pi / 2, "s": R(1, 2), "u1": 1, "v1": R(1, 3)}
"""Without its gyroscope the ball then rolls along a great circle: for theta = 0 a meridian."""


@pytest.fixture(scope="module")
def ball():
    return vo.load("demchenko")


@pytest.fixture(scope="module")
def fuzz():
    """The fuzzer of turns: motions, and integration in space with angles followed closely."""
    if str(TOOLS) not in sys.path:
        sys.path.insert(0, str(TOOLS))
    return importlib.import_module("scenes.turns")


def by_scipy(fuzz):
    from scipy.integrate import solve_ivp

    def run(start, numbers, span):
        def slope(_, state):
            return np.array(fuzz.rates(state, numbers))

        found = solve_ivp(
            slope, (0.0, span), start, method="DOP853", rtol=1e-10, atol=1e-12, dense_output=True
        )
        return lambda times: found.sol(times).T

    return run


@pytest.mark.parametrize("number", range(12))
def test_two_instants_are_apart_by_the_turns_of_integration(fuzz, number):
    motion = fuzz.random_motion(np.random.default_rng((11, number)), 10.0)
    motion = replace(motion, span=float(np.clip(motion.span, -10, 10)))
    found, _ = motion.closed_form()
    true = fuzz.follow(by_scipy(fuzz), motion)
    assert np.abs(found - true).max() < 1e-3, motion.kind


def tilted(ball, **changes):
    return vo.closed_form(ball, initial={**START, **changes})


FOUR = {"u": 0.8, "u1": 2.84, "theta": -0.81, "n": -6.61, "s": 0.05, "tau": 0.68}
"""The contact comes into both caps."""
WINDING = [{"u": 2.2, "u1": 0.5, "theta": -0.5}, {"u": 2.2, "u1": 1.2, "theta": 0.7}, FOUR]


@pytest.mark.parametrize("changes", WINDING)
@pytest.mark.parametrize("way", [1, -1])
def test_one_instant_knows_what_a_fine_grid_knows(ball, changes, way):
    form = tilted(ball, **changes)
    grid = way * np.linspace(0, 40 * form.period, 12001)
    whole, part = form.at(grid, ANGLES), form.modulo(grid, ANGLES)
    shuffled = np.random.default_rng(3).permutation(grid)[:300]
    few = form.at(shuffled, ANGLES)
    exact = form.enclose(float(grid[-1]), 25)
    for name in ANGLES:
        steps = np.diff(np.unwrap(part[name]))
        assert np.abs(steps).max() < 1.5
        assert np.abs(np.diff(whole[name]) - steps).max() < 1e-9, name
        assert whole[name][0] == pytest.approx(float({**START, **changes}[name]), abs=1e-13)
        places = np.searchsorted(way * grid, way * shuffled)
        assert np.abs(few[name] - whole[name][places]).max() < 1e-9, name
        assert abs(float(exact[name]) - whole[name][-1]) < 1e-9, name


def test_turns_are_exact_however_late_and_however_many_periods_lie_between(ball):
    form = tilted(ball, **WINDING[0])
    assert winding_of(form).passages(192).passages
    times = form.period * np.array([-3e9, -1e6, 2.5, 1e6 + 0.3, 7e8])
    found = form.at(times, ANGLES)
    for i, t in enumerate(times):
        exact = form.enclose(float(t), 20)
        for name in ANGLES:
            value = found[name][i]
            assert abs(float(exact[name]) - value) < 1e-9 + 4 * np.spacing(abs(value)), (name, t)


def test_sums_over_periods_are_those_of_each_period(ball):
    form = tilted(ball, **WINDING[1])
    level = winding_of(form).passages(192)
    assert level.passages
    with ctx.workprec(192):
        near = tally(winding_of(form), level, form.period * np.arange(-400.0, 400.0))
        sparse = tally(winding_of(form), level, form.period * np.array([-4e5, 399.0, 3e5]))
        for one, place in ((near, -1), (sparse, 1)):
            count = level.numbers(arb(form.period * 399))
            here = one.first[one.state[place]], one.last[one.state[place]]
            assert here == winding_of(form).gain(level, count)


@pytest.mark.parametrize("changes", [{"u1": 2, "theta": -1}, {"u1": 0.4, "theta": 2.5}])
def test_motions_without_a_period_wind_as_they_are_seen_to(ball, changes):
    data = {"u": sp.acos(R(20, 29)), "s": R(-375, 406), "tau": sp.sqrt(353475) / 41209**R(1, 2),
            "n": R(5, 2)}  # fmt: skip
    form = vo.closed_form(
        ball, parameters={"R1": R(-1, 2), "A": R(3, 5), "k": 6}, initial={**data, **changes}
    )
    assert form.period == np.inf and not form.attitude.upright
    for last in (30.0, -30.0):
        grid = np.linspace(0, last, 20001)
        part, end = form.modulo(grid, ANGLES), form.at([last], ANGLES)
        for name in ANGLES:
            seen = np.unwrap(part[name])
            assert np.abs(np.diff(seen)).max() < 1.5
            start = float({**data, **changes}.get(name, 0))
            assert end[name][0] - start == pytest.approx(seen[-1] - seen[0], abs=1e-9)


@pytest.mark.parametrize(("theta", "instant"), [(0, 12.8495559215388), (sp.pi, 6.0)])
def test_through_a_pole_an_angle_has_no_number_of_turns(ball, theta, instant):
    given = {"parameters": {"k": 0}, "initial": {**STRAIGHT, "theta": theta}}
    form = vo.closed_form(ball, **given)
    words = f"v1 and theta have no number of whole turns beyond t = {instant:.15g}"
    for ask in (lambda: form.at([60.0], ["v1"]), lambda: form.enclose(60, 20)):
        with pytest.raises(vo.EngineLimit, match=words) as caught:
            ask()
        assert pickle.loads(pickle.dumps(caught.value)).time == caught.value.time
    assert form.at([instant - 1], ["v1"])["v1"][0] == pytest.approx(1 / 3)
    across = form.modulo([60.0], ["v1"])["v1"][0]
    assert across == pytest.approx(1 / 3 - np.pi)
    assert float(form.enclose(60, 20, whole=False)["v1"]) == pytest.approx(across)
    assert np.isfinite(form.at([60.0], ["u", "v", "u1"])["u1"][0])
    for tol in (1e-13, 1e-20):
        run = vo.integrate(ball, **given, times=[5, 65], method="closed-form", tol=tol)
        assert len(run.notes) == 1 and f"beyond t = {5 + instant:.15g}" in run.notes[0]
        assert float(run["v1"][-1]) == pytest.approx(across)
    given |= {"times": [5, 65], "method": "closed-form"}
    for asked in (("u",), ("u", "v"), ("v1",)):
        late = vo.integrate(ball, **given, outputs=asked)
        assert len(late.notes) == 1 and f"beyond t = {5 + instant:.15g}" in late.notes[0]
        assert float(late["v1"][-1]) == pytest.approx(across)


@pytest.mark.parametrize("extra", [{}, {"dense": True}, {"tol": 1e-20}, {"outputs": ("v",)}])
def test_where_some_angles_have_lost_their_turns_the_others_keep_theirs(ball, extra):
    """Along the ball's equator v falls evenly; the contact passes the poles of the sphere."""
    equator = {"u": sp.pi / 2, "v": R(1, 3), "theta": 0, "u1": sp.pi / 2, "v1": 0,
               "s": -1, "tau": 0, "n": 0}  # fmt: skip
    times = [0, 4, 20, 40]
    run = vo.integrate(ball, initial=equator, times=times, method="closed-form", **extra)
    assert run.notes[0].startswith("v1 and theta have no number of whole turns beyond t = 4.712388")
    at = run.at(times) if extra.get("dense") else run
    assert np.abs(at["v"].astype(float) - (1 / 3 - np.array(times) / 1.5)).max() < 1e-13
    assert np.abs(run.state[:, 1].astype(float) - at["v"].astype(float)).max() < 1e-13


def test_beside_a_pole_it_has_one(ball):
    form = vo.closed_form(ball, parameters={"k": 0}, initial={**STRAIGHT, "theta": R(1, 10**9)})
    before, after = (form.at([t], ["v1"])["v1"][0] for t in (31, 32))
    assert after - before == pytest.approx(np.pi, abs=1e-6)


@pytest.mark.parametrize("kind", ["the contact stays", "the ball stays", "straight on"])
def test_motions_at_rest_wind_evenly(ball, kind):
    still = {"s": 0, "tau": 0, "n": 0}
    changes = {"the contact stays": {"n": 2}, "the ball stays": {},
               "straight on": {"s": R(1, 2), "u": sp.pi / 2}}  # fmt: skip
    initial = {**still, **changes[kind]}
    form = vo.closed_form(ball, parameters={"k": 0}, initial={**START, **initial})
    assert form.rests
    grid = np.linspace(0, 90, 3001)
    whole, part, last = (form.at(grid, ANGLES), form.modulo(grid, ANGLES), form.at([90], ANGLES))
    for name in ANGLES:
        seen = np.unwrap(part[name])
        assert np.abs(whole[name] - seen - (START[name] - seen[0])).max() < 1e-12
        assert last[name][0] == pytest.approx(whole[name][-1])
        assert float(form.enclose(90, 20)[name]) == pytest.approx(whole[name][-1])


def test_a_pole_of_a_motions_own_coordinates_is_noted_with_its_instant(ball):
    """The momentum is upright, and the contact passes through the pole of the sphere."""
    s, tau, n = R(191, 112), sp.sqrt(6431) / 112, -R(3, 4)
    u = sp.acos(R(4, 5))
    along_u, along_v, along_n = R(7, 5) * s - 3 * sp.sin(u), R(7, 5) * tau, R(2, 5) * n + R(12, 5)
    upright = {"theta": sp.atan2(along_u, -along_v),
               "u1": sp.atan2(sp.sqrt(along_u**2 + along_v**2), -along_n)}  # fmt: skip
    given = {"initial": {"u": u, "s": s, "tau": tau, "n": n, **upright}, "times": [0, 30]}
    run = vo.integrate(ball, **given, method="closed-form")
    late = vo.integrate(ball, **given, outputs=("u",), method="closed-form")
    assert late.notes == run.notes and np.array_equal(late.state, run.state)
    assert "v1 and theta have no number of whole turns beyond t = 2.96603600555" in run.notes[0]


def test_runs_know_the_turns_of_angles_that_nobody_asked_for(ball):
    form = tilted(ball)
    true = form.at(np.linspace(0, 300, 9001), ["v1", "theta"])
    given = {"initial": START, "times": [0, 300], "outputs": ("u", "v"), "method": "closed-form"}
    for options in ({}, {"tol": 1e-25}):
        run = vo.integrate(ball, **given, **options, dense=True)
        for name in ("v1", "theta"):
            assert float(run[name][-1]) == pytest.approx(true[name][-1], abs=1e-9)
            assert float(run.at([150.0])[name][0]) == pytest.approx(true[name][4500], abs=1e-9)


def test_over_long_spans_auto_takes_the_closed_form_for_angles_too(ball):
    run = vo.integrate(ball, initial=START, times=[0, 2e4], outputs=("v1",))
    assert run.cost.method == "closed-form"
    assert run["v1"][-1] == pytest.approx(float(tilted(ball).enclose(20000, 20)["v1"]))


def test_an_angle_that_is_counted_the_other_way_round_winds_the_other_way(ball):
    """The same ball with phi = -theta in the place of theta."""
    phi, theta = sp.symbols("phi theta")
    own, motion = ball.motion, None
    swap = {theta: -phi, vo.velocity(theta): -vo.velocity(phi)}
    space = replace(own.space, frame=own.space.frame.xreplace(swap), coordinates={
        phi if q == theta else q: -e if q == theta else e for q, e in own.space.coordinates.items()
    })  # fmt: skip
    motion = replace(own, space=space, integrals={
        phi if q == theta else q: -e if q == theta else e for q, e in own.integrals.items()
    })  # fmt: skip
    base = tuple(phi if q == theta else q for q in ball.fibration.base)
    mirrored = vo.System(
        name="mirrored", fibration=vo.Fibration(base=base, fibre=ball.fibration.fibre),
        frame=vo.Frame.quasi({
            v: e.xreplace(swap)
            for v, e in zip(ball.frame.velocities, ball.frame.expressions, strict=True)
        }),
        lagrangian=ball.lagrangian.xreplace(swap),
        constraints=tuple(e.xreplace(swap) for e in ball.constraints),
        parameters=ball.parameters, motion=motion,
    )  # fmt: skip
    start = {**START, **WINDING[0]}
    other = vo.closed_form(
        mirrored, initial={**{k: x for k, x in start.items() if k != "theta"},
                           "phi": -start["theta"]},
    )  # fmt: skip
    times = [0.0, 91.0]
    true, found = tilted(ball, **WINDING[0]).at(times), other.at(times)
    assert found["v1"] == pytest.approx(true["v1"], abs=1e-10)
    assert found["phi"] == pytest.approx(-true["theta"], abs=1e-10)


def test_a_frame_that_is_made_otherwise_is_known_modulo_a_turn_alone(ball):
    theta = sp.Symbol("theta")
    space = ball.motion.space
    motion = replace(
        ball.motion, space=replace(space, frame=space.frame.xreplace({theta: 2 * theta}))
    )
    form = vo.closed_form(replace(ball, motion=motion), initial=START)
    assert np.isfinite(form.modulo([1.0], ["v1"])["v1"]).all()
    with pytest.raises(vo.EngineLimit, match="longitude and the colatitude of a trace"):
        form.at([1.0], ["v1"])


def test_sums_of_floors_are_exact_and_doubts_are_found():
    rng = np.random.default_rng(5)
    for _ in range(300):
        count, first, step = (int(n) for n in rng.integers((0, -50, -50), (40, 50, 50)))
        unit = int(rng.integers(1, 30))
        plain = sum((first + j * step) // unit for j in range(count))
        assert floor_sum(count, first, step, unit) == plain
    with ctx.workprec(128):
        first, step = 7 * arb(2).sqrt(), -arb(3).sqrt()
        for count in (-30, 0, 30):
            each = range(count) if count > 0 else range(count, 0)
            plain = sum(floor(float(first) + j * float(step)) for j in each)
            assert certain_floor_sum(count, first, step) == (plain if count > 0 else -plain)
        open_at = 3 - 5 * step  # a whole number at j = 5, which a ball does not tell
        assert certain_floor_sum(5, open_at, step) is not None
        assert certain_floor_sum(10**15, open_at, step) is None
        assert first_doubt(10**15, open_at, step) == 5
        assert first_doubt(-10, 3 + 5 * step, step) == -5


def test_a_pole_of_the_ball_takes_the_turns_of_the_third_angle_too(ball):
    start = {"u": 1, "u1": 1, "theta": 0.5, "tau": 0.5}  # K is horizontal
    run = vo.integrate(ball, times=[0, 9], parameters={"k": 0}, initial=start, method="closed-form")
    assert run.notes[0].startswith("v and theta have no number of whole turns beyond t = 3,")

"""Events, stop conditions, dense output, progress, and what is kept where a motion ends early."""

from __future__ import annotations

from importlib.util import find_spec
from random import Random
from shutil import which
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.motion.crossings import StepCourse, crossings, roots
from voronec.motion.request import Guard
from voronec.motion.steppers import heyoka_stepper as taylor
from voronec.motion.steppers import run
from voronec.motion.steppers import run as marching

pytestmark = pytest.mark.slow

DOUBLES = ("scipy", "lsoda", *(["heyoka"] if find_spec("heyoka") else []))
# The method numba compiles the steps that c has: it is tested in test_compiled_methods.
COMPILED = ("c",) if which("cc") else ()
doubles = pytest.mark.parametrize("method", DOUBLES)
every = pytest.mark.parametrize("method", [*DOUBLES, "flint"])

x, y, m = sp.symbols("x y m")
Dx, Dy = map(vo.velocity, (x, y))
GRID = np.linspace(0.0, 10.0, 21)


def oscillator() -> vo.System:
    """x is a cosine."""
    return vo.System(
        name="oscillator",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=Dx**2 / 2 - x**2 / 2,
        integrals={"energy": Dx**2 / 2 + x**2 / 2},
    )


def cosine(method: str, grid: Any = GRID, **more: Any) -> vo.Trajectory:
    """The cosine from its top."""
    return vo.integrate(oscillator(), times=grid, initial={x: 1}, method=method, **more)


def close(found: Any, wanted: Any, by: float = 2e-12) -> bool:
    """Whether two arrays agree, of mpmath's numbers or doubles."""
    found, wanted = np.array(found, dtype=float), np.array(wanted, dtype=float)
    return found.shape == wanted.shape and bool(np.abs(found - wanted).max(initial=0.0) < by)


@every
def test_crossings_are_found_where_they_are(method: str) -> None:
    half = vo.Event(x - sp.Rational(1, 2), "half", direction=-1)
    traj = cosine(method, outputs=(x, Dx * x), events=("x", half, vo.Event(x - 2, "never")))
    assert list(traj.events) == ["x", "half", "never"] and traj.stopped == ""
    assert close(traj.events["x"].t, np.pi / 2 + np.pi * np.arange(3))
    assert close(traj.events["x"][Dx], [-1, 1, -1])
    assert close(traj.events["half"].t, np.pi / 3 + 2 * np.pi * np.arange(2))
    assert close(traj.events["half"]["x*xdot"], [-np.sqrt(3) / 4] * 2)
    assert len(traj.events["never"]) == 0 and traj.events["never"].state.shape == (0, 2)
    with pytest.raises(vo.DefinitionError, match="crossings hold no 'u'"):
        traj.events["x"]["u"]


@every
def test_a_direction_is_that_of_time_also_backwards(method: str) -> None:
    grid = np.linspace(0, -7, 8)
    events = (vo.Event(x, "up", direction=1), vo.Event(x, "down", direction=-1))
    traj = cosine(method, grid, events=events)
    assert close(traj.events["up"].t, [-np.pi / 2])
    assert close(traj.events["down"].t, [-3 * np.pi / 2])


@every
def test_a_stop_ends_the_run_at_the_crossing(method: str) -> None:
    events = (vo.Event(Dx, "turn", stop=True), vo.Event(x, "zero"), vo.Event(Dx + x, "later"))
    traj = cosine(method, events=events)
    # it starts at a turning point, which is no crossing
    assert traj.stopped == "turn" and close(traj.events["turn"].t, [np.pi])
    assert close(traj.t, [*np.arange(0, 3.5, 0.5), np.pi])
    assert close(traj["x"], np.cos(np.array(traj.t, dtype=float)))
    assert close(traj.events["zero"].t, [np.pi / 2]) and not traj.interrupted
    assert close(traj.events["later"].t, [3 * np.pi / 4 - np.pi / 2])


@every
def test_two_crossings_between_two_points_of_the_grid(method: str) -> None:
    traj = cosine(method, [0.0, 20.0], events=(vo.Event(x - 0.9999, "near the top"),))
    angle = float(sp.acos(sp.Float("0.9999", 30)))
    tops = 2 * np.pi * np.arange(4)
    wanted = np.sort(np.concatenate([tops + angle, tops[1:] - angle]))
    assert close(traj.events["near the top"].t, wanted, by=1e-9)


@every
def test_dense_output_is_as_good_as_the_grid(method: str) -> None:
    traj = cosine(method, [0.0, 4.0, 10.0], dense=True, outputs=(x**2,))
    times = [9.9, 0.0, 0.3, 10.0, 4.0, 7.123]
    seen = traj.at(times)
    assert close(seen["x**2"], np.cos(times) ** 2) and close(seen["x"], np.cos(times))
    assert close(traj.at(2.5)["x"], [np.cos(2.5)])
    with pytest.raises(vo.DefinitionError, match="reaches from t = 0 to 10; give times within"):
        traj.at([3.0, 10.5])
    with pytest.raises(vo.DefinitionError, match="no times are given"):
        traj.at([])
    with pytest.raises(vo.DefinitionError, match="integrate with dense=True"):
        cosine(method).at(1.0)
    stopped = cosine(method, dense=True, events=vo.Event(x, "zero", stop=True))
    assert close(stopped.at([1.5])["x"], np.cos([1.5]))
    with pytest.raises(vo.DefinitionError, match="give times within"):
        stopped.at([1.6])


@every
def test_dense_output_of_a_single_instant(method: str) -> None:
    assert close(cosine(method, [2.0], dense=True).at(2.0)["x"], [1.0])


@every
def test_progress_tells_the_fraction(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "EVERY", -1.0)
    monkeypatch.setattr(taylor, "CHUNK", 5)
    told: list[float] = []
    cosine(method, progress=told.append)
    assert len(told) > 1 and told == sorted(told) and told[-1] == pytest.approx(1)


@every
def test_ctrl_c_keeps_what_is_done(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "EVERY", -1.0)
    monkeypatch.setattr(taylor, "CHUNK", 5)

    def stop(fraction: float) -> None:
        if fraction > 0.4:
            raise KeyboardInterrupt

    traj = cosine(method, progress=stop, dense=True, events="x", tol=1e-14)
    assert traj.interrupted and 1 < len(traj.t) < len(GRID)
    assert close(traj["x"], np.cos(GRID[: len(traj)])) and close(traj.at(1.1)["x"], [np.cos(1.1)])
    assert close(traj.events["x"].t[:1], [np.pi / 2])


@doubles
def test_a_run_with_friction_keeps_where_it_stood_too(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run, "EVERY", -1.0)

    def stop(fraction: float) -> None:
        if fraction > 1e-3:
            raise KeyboardInterrupt

    push = sp.sin(vo.time) / 10 - sp.sign(Dx) / 10**5
    traj = vo.integrate(
        falling(x**2 / 2, forces={x: push}), times=[0, 3e4], initial={x: 1}, method=method,
        progress=stop,
    )  # fmt: skip
    assert traj.interrupted and len(traj.t) == 2 and traj.cost.switches > 5 and traj.t[1] > 20
    end = traj.t[1]  # without friction, which is small
    resonant = np.cos(end) + (np.sin(end) - end * np.cos(end)) / 20
    assert close(traj["x"][1:], [resonant], 1e-2)


def falling(potential: Any, inertia: Any = 1, **more: Any) -> vo.System:
    """One coordinate in a potential."""
    lagrangian = inertia * Dx**2 / 2 - potential
    return vo.System(
        name="falling", fibration=vo.Fibration(base=(x,)), lagrangian=lagrangian,
        integrals={"energy": inertia * Dx**2 / 2 + potential}, **more,
    )  # fmt: skip


@every
def test_a_collapse_keeps_the_trajectory(method: str) -> None:
    with pytest.raises(vo.IntegrationError) as caught:
        vo.integrate(falling(-1 / x), times=GRID / 5, initial={x: 1}, method=method, dense=True)
    # from rest at 1, falling into -1/x takes pi / (2 sqrt 2)
    assert float(caught.value.time) == pytest.approx(np.pi / np.sqrt(8), abs=1e-6)
    kept = caught.value.trajectory
    assert close(kept.t, np.arange(0, 1.15, 0.1)) and kept.halted and kept.drift["energy"] < 1e-9
    # t = (sqrt(x (1 - x)) + arccos(sqrt x)) / sqrt 2
    place = float(kept.at(0.55)["x"][0])
    fall = np.sqrt(place * (1 - place)) + np.arccos(np.sqrt(place))
    assert fall / np.sqrt(2) == pytest.approx(0.55, abs=1e-11)


REGULAR = {x: -(Dx**2) / 2 - (1 - x) * x}


@pytest.mark.parametrize("method", [*DOUBLES, "flint", *COMPILED])
def test_a_mass_that_vanishes_on_the_way_is_named_where_it_is_stepped_over(method: str) -> None:
    # the force makes the motion x = 2 sin t regular where the mass 1 - x changes its sign
    system = falling(0, inertia=1 - x, forces=REGULAR)
    with pytest.raises(vo.IntegrationError, match="mass matrix is singular there") as caught:
        vo.integrate(system, times=[0.0, 0.5, 1.5], initial={x: 0, Dx: 2}, method=method)
    assert 0.5 <= float(caught.value.time) <= np.pi / 6
    assert close(caught.value.trajectory.t, [0, 0.5])


@pytest.mark.parametrize("method", DOUBLES)
def test_what_fails_beyond_a_singular_mass_has_failed_there(method: str) -> None:
    late = REGULAR[x] + (1 - x) / (sp.Rational(6, 5) - vo.time) ** 3  # no motion after t = 6/5
    system = falling(0, inertia=1 - x, forces={x: late})
    with pytest.raises(vo.IntegrationError, match="mass matrix is singular there") as caught:
        vo.integrate(system, times=[0, 0.25, 1, 2], initial={x: 0, Dx: 2}, method=method)
    assert close(caught.value.trajectory.t, [0, 0.25])


@pytest.mark.parametrize("method", COMPILED)
def test_loops_that_look_at_few_steps_end_at_the_last_before_a_singular_mass(method: str) -> None:
    system, ends = falling(0, inertia=1 - x, forces=REGULAR), []
    for each in ("scipy", method):
        with pytest.raises(vo.IntegrationError) as caught:
            vo.integrate(system, times=[0, 0.01, 1.5], initial={x: 0, Dx: 2}, method=each, tol=1e-9)
        ends.append(float(caught.value.time))
    assert ends[1] == pytest.approx(ends[0], abs=1e-5)


def test_what_happened_beyond_a_singular_mass_is_not_told() -> None:
    system = falling(0, inertia=1 - x, forces=REGULAR)
    events = (vo.Event(x - sp.Rational(1, 4), "before"), vo.Event(x - sp.Rational(3, 2), "beyond"))
    with pytest.raises(vo.IntegrationError) as caught:
        vo.integrate(system, times=GRID, initial={x: 0, Dx: 2}, method="scipy", events=events)
    seen = caught.value.trajectory.events
    assert close(seen["before"].t, [np.arcsin(1 / 8)]) and len(seen["beyond"]) == 0


def test_steps_that_lead_nowhere_end_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(marching, "WINDOW", 3)
    monkeypatch.setattr(marching, "CRAWL", 0.5)
    with pytest.raises(vo.IntegrationError, match="1e10 steps away after t") as caught:
        cosine("scipy")
    # the pace of the first three is what that of the next is compared with
    assert caught.value.trajectory.cost.steps == 6 and caught.value.trajectory.halted


def test_events_that_make_no_sense_are_named() -> None:
    with pytest.raises(vo.DefinitionError, match="no output 'z'"):
        cosine("scipy", events=("z",))
    with pytest.raises(vo.DefinitionError, match="two events are called 'x'"):
        cosine("scipy", events=("x", vo.Event(x - 1, "x")))
    with pytest.raises(vo.DefinitionError, match="direction = 2 must be 1"):
        vo.Event(x, direction=2)


def root(function: Any, *bracket: Any) -> Any:
    """A zero of one function, between two places with the values there."""
    a, left, b, right = (np.array([x]) for x in bracket)
    return roots(lambda t, _: np.array([function(t[0])]), a, left, b, right)[0]


def test_roots_to_the_last_digit() -> None:
    assert root(lambda t: t**3 - 2, 0.0, -2.0, 2.0, 6.0) == pytest.approx(2 ** (1 / 3), rel=4e-16)
    with mpmath.workdps(50):
        a, b = mpmath.mpf(1), mpmath.mpf(2)
        found = root(lambda t: mpmath.cos(t), a, mpmath.cos(a), b, mpmath.cos(b))
        assert abs(found - mpmath.pi / 2) < mpmath.mpf(10) ** -48


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("method", ["heyoka", "scipy", "lsoda", "flint"])
def test_what_comes_back_soon_after_the_start_is_seen(method, way):
    """A stone thrown upwards at 1 is there again after 2 v."""
    x = sp.Symbol("x")
    dot = vo.velocity(x)
    fall = vo.System("fall", vo.Fibration(base=(x,)), dot**2 / 2 - x)
    least = 1e-5 if method == "lsoda" else 1e-7  # its polynomials begin beside the start
    for speed in np.geomspace(least, 1e-2, 40):
        run = vo.integrate(
            fall, initial={x: 1, dot: way * speed}, times=[0, 15 * way], method=method, dense=True,
            events=(vo.Event(x - 1, "again"),),
        )  # fmt: skip
        assert run.events["again"].t == pytest.approx([2 * way * speed], rel=1e-2)
        assert run.at([way * speed / 50])["xdot"] == pytest.approx(
            [way * speed * 49 / 50], rel=1e-8
        )


@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
def test_a_zero_at_the_start_hides_no_later_one(method):
    x = sp.Symbol("x")
    dot = vo.velocity(x)
    fall = vo.System("fall", vo.Fibration(base=(x,)), dot**2 / 2 - x)
    found = vo.integrate(fall, initial={dot: 1}, times=[0, 5], events=(x,), method=method)
    assert np.allclose(found.events["x"].t.astype(float), [2], atol=1e-12)


PUSH = sp.Symbol("u")
ALL = ["heyoka", "scipy", "c", "lsoda", "flint"]


def pushed(table: vo.Table, event: vo.Event, speed: float, method: str) -> vo.Trajectory:
    place = sp.Symbol("x")
    rate = vo.velocity(place)
    cart = vo.System(
        name="cart", fibration=vo.Fibration(place), lagrangian=rate**2 / 2,
        forces={place: PUSH}, inputs=(PUSH,),
    )  # fmt: skip
    return vo.integrate(
        cart, initial={rate: speed}, times=[0, 2], inputs={PUSH: table}, events=(event,),
        method=method,
    )  # fmt: skip


@pytest.mark.parametrize("method", ALL)
def test_events_at_the_instants_of_a_table_happen_once(method: str) -> None:
    """Where inputs change a run starts anew, and each part sees a zero at its end, or its start."""
    place = sp.Symbol("x")
    rest = vo.Table([0, 1, 2], [0, 0, 0])
    run = pushed(rest, vo.Event(place - 1, "there", stop=True), 1, method)
    assert run.stopped == "there" and float(run.t[-1]) == pytest.approx(1, abs=1e-12)
    passages = [
        (vo.Table([0, 1, 2], [1, 0, -1]), PUSH, 0), (vo.Table([0, 1, 2], [1, 0, -2]), PUSH, 0),
        (vo.Table([0, 1, 2], [-1, -1, -2], "held"), vo.velocity(place), 1),
        (vo.Table([0, 0.5, 1, 2], [1, 0, -1, -1], "held"), PUSH, 0),
        (vo.Table([0, 0.5, 1, 2], [1, 0, 0, -1]), PUSH, 0),
    ]  # fmt: skip
    for table, function, speed in passages:
        found = pushed(table, vo.Event(function, "zero"), speed, method).events["zero"]
        assert found.t.astype(float) == pytest.approx([1], abs=1e-9)
        upwards = pushed(table, vo.Event(function, "zero", direction=1), speed, method)
        assert len(upwards.events["zero"].t) == 0
    touches = [
        (vo.Table([0, 1, 2], [-1, 0, -1]), PUSH, 0),
        (vo.Table([0, 1, 2], [-1, 1, 1], "held"), vo.velocity(place), 1),
        (vo.Table([0, 0.5, 1, 2], [1, 0, 0, 1]), PUSH, 0),
    ]
    for table, function, speed in touches:
        run = pushed(table, vo.Event(function, "zero", stop=True), speed, method)
        assert len(run.events["zero"].t) == 0 and float(run.t[-1]) == 2


@pytest.mark.parametrize("method", ["scipy", "flint", "c"])
def test_an_event_without_a_value_at_a_switch_leaves_the_others(method: str) -> None:
    place = sp.Symbol("x")
    rate = vo.velocity(place)
    free = vo.System(name="free", fibration=vo.Fibration(place), lagrangian=rate**2 / 2)
    events = (
        vo.Event(sp.sign(place - 1), "side"), vo.Event(1 / (place - 1), "pole"),
        vo.Event(sp.Abs(place - 1) - sp.Rational(1, 4), "near"),
    )  # fmt: skip
    run = vo.integrate(free, initial={rate: 1}, times=[0, 1.7], events=events, method=method)
    assert run.events["near"].t.astype(float) == pytest.approx([0.75, 1.25], abs=1e-9)
    assert run.events["side"].t.astype(float) == pytest.approx([1], abs=1e-9)
    assert len(run.events["pole"].t) == 0


@pytest.mark.parametrize("method", ALL)
def test_events_that_happen_more_often_than_steps_are_taken_are_all_found(method: str) -> None:
    """A point moves evenly: of sin(20 x) two thirds of the zeros were missed."""
    free = vo.System(name="free", fibration=vo.Fibration(x), lagrangian=Dx**2 / 2)
    events = (
        vo.Event(sp.sin(20 * x), "often"), vo.Event(sp.cos(x), "seldom"),
        vo.Event(1 / (2 + sp.sin(11 * x)) - sp.Rational(1, 2), "quotient"),
    )  # fmt: skip
    run = vo.integrate(
        free, initial={x: sp.Rational(1, 10), Dx: 1}, times=[0, 5, 10], events=events,
        method=method, dense=True,
    )  # fmt: skip
    for name, first, step in (
        ("often", 1, np.pi / 20), ("seldom", 0.5, np.pi), ("quotient", 1, np.pi / 11),
    ):  # fmt: skip
        truth = np.arange(first, 11 / step) * step - 0.1
        found = run.events[name].t.astype(float)
        assert found == pytest.approx(truth[truth <= 10], abs=1e-9)
    assert run["x"].astype(float) == pytest.approx([0.1, 5.1, 10.1], abs=1e-11)
    assert float(run.at([7.25])["x"][0]) == pytest.approx(7.35, abs=1e-11)


@pytest.mark.parametrize("method", [m for m in DOUBLES if m != "lsoda"])
@pytest.mark.parametrize("place", [0, 10_000])
def test_zeros_of_third_order_are_passed_once(method: str, place: int) -> None:
    """Series have three zeros or none there, off by the cube root of rounding: each passage was
    told twice or thrice, or not at all."""
    far = x - place
    spring = vo.System(name="spring", fibration=vo.Fibration(x), lagrangian=Dx**2 / 2 - far**2 / 2)
    functions = {
        "cube": (far**3, 1e-10),
        "seventh": (-2 * far**7, 1e-10),
        "factors": (far**3 * (Dx**2 + 1) ** 2, 1e-10),
        "sines": (far * sp.sin(far) * sp.tan(far), 1e-10),
        "difference": (sp.sin(far) - far, 1e-7),
        "touches": (far**3 + far**2 * Dx / 100, 1e-9),
    }
    places = np.array([0.5, 1.5, 2.5]) * np.pi
    shifted = places - np.arctan(0.01)
    for name, (function, error) in functions.items():
        for tol in (1e-13, 1e-16):
            run = vo.integrate(
                spring,
                initial={x: place + 1},
                times=[0, 10],
                events=(vo.Event(function, name=name),),
                method=method,
                tol=tol,
            )
            found, true = run.events[name].t, shifted if name == "touches" else places
            assert len(found) == 3, (name, found)
            assert np.abs(found - true).max() < error, name
    touch = vo.Event(-(far**2), name="touch")  # far off it is zero itself there
    run = vo.integrate(spring, initial={x: place + 1}, times=[0, 10], events=touch, method=method)
    assert len(run.events["touch"].t) == 0
    down = vo.Event(sp.sin(far) - far, name="down", direction=-1, stop=True)
    run = vo.integrate(spring, initial={x: place + 1}, times=[0, 10], events=down, method=method)
    assert run.stopped == "down" and abs(run.t[-1] - 1.5 * np.pi) < 1e-7


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("method", [m for m in (*DOUBLES, "flint") if m != "lsoda"])
def test_a_zero_at_the_last_instant_counts(method: str, way: int) -> None:
    """heyoka took it for the start of a step that never comes; lsoda ends 1e-16 before it."""
    free = vo.System(name="free", fibration=vo.Fibration(base=(x,)), lagrangian=Dx**2 / 2)
    level = x - sp.Rational(3, 4) * way
    events = (
        vo.Event(level, "up", direction=1), vo.Event(level, "down", direction=-1),
        vo.Event(level, "end", stop=True), vo.Event(x - way, "later"),
    )  # fmt: skip
    for grid in ([0.0, 0.75 * way], np.linspace(0.0, 0.75 * way, 7)):
        run = vo.integrate(free, times=grid, initial={Dx: 1}, events=events, method=method)
        assert [len(run.events[e.name]) for e in events] == [1, 0, 1, 0] and run.stopped == "end"
        assert close([run.events["up"].t[0], run.t[-1]], [0.75 * way] * 2)


@pytest.mark.parametrize("ends", [(0.3, 1.0), (1.0, 1.7), (0.3, 1.7)])
def test_a_pole_beside_the_end_of_a_step_is_no_passage(ends: tuple[float, float]) -> None:
    event = {0: Guard("level")}
    passages = [lambda t: t - 1, lambda t: (t - 1) ** 3, lambda t: np.tanh(1e10 * (t - 1))]
    jumps = [np.sign, lambda t: np.where(t < 0, -1, 5), lambda t: np.where(t < 0, -0.01, 5)]
    poles = [lambda t: 1 / t, lambda t: np.cbrt(1 / t), lambda t: 1 / t**3 - t]
    passages += [lambda t, jump=jump: jump(t - 1) for jump in jumps]

    def found(level: Any, begin: float, end: float) -> list[Any]:
        step = StepCourse(np.array([begin, end]), lambda times: np.zeros((len(times), 1)))
        return crossings(event, lambda times, _: level(np.asarray(times))[:, None], step).passages

    # a step that begins or ends there does so one to four units in the last place beyond
    for beyond in np.spacing(1.0) * np.arange(1, 5):
        begin, end = (t if t != 1 else t + s for t, s in zip(ends, (-beyond, beyond), strict=True))
        for level in passages:
            times = [float(t) for t, _ in found(level, begin, end)]
            assert times == pytest.approx([1], abs=1e-15)
        with np.errstate(divide="ignore"):
            for level in poles:  # which lie between two doubles
                assert not found(lambda t, level=level: level(t - 1 - 1e-16), begin, end)


def test_a_zero_is_found_to_the_last_digit_in_few_looks() -> None:
    """Ends that no secant moved were brought up by halves: 200 looks, at 70 digits."""
    looks = []

    def simple(place):
        looks.append(place)
        return mpmath.cos(place) - third

    with mpmath.workdps(70):
        third, begin, end = mpmath.mpf(1) / 3, mpmath.mpf(0), mpmath.mpf(2)
        found = root(simple, begin, simple(begin), end, simple(end))
        assert abs(found - mpmath.acos(third)) < mpmath.mpf(10) ** -69 and len(looks) < 50
    looks.clear()
    assert root(lambda t: looks.append(t) or (t - 0.3) ** 3, 0.0, -0.027, 2.0, 4.913) == 0.3
    assert len(looks) < 130


@pytest.mark.parametrize("method", [*DOUBLES, "flint", *COMPILED])
def test_what_touches_zero_is_none_and_what_dips_below_it_two(method: str) -> None:
    touch, dip = vo.Event(x + 1, "touch"), vo.Event(x + 1 - sp.Float("1e-9"), "dip")
    found = cosine(method, tol=1e-13, events=(touch, dip)).events
    apart = np.arccos(1 - 1e-9)
    places = [turn * np.pi + side * apart for turn in (1, 3) for side in (-1, 1)]
    assert len(found["touch"]) == 0 and close(found["dip"].t, places, 1e-6)


def polynomial(roots: Any) -> tuple[vo.System, dict[Any, Any], sp.Expr]:
    """A body whose place x is (t - a)(t - b)..., and its start at t = 0."""
    place = sp.expand(sp.prod([vo.time - root for root in roots]))
    rate = place.diff(vo.time)
    force = {x: rate.diff(vo.time)}
    system = vo.System("polynomial", vo.Fibration(base=(x,)), lagrangian=Dx**2 / 2, forces=force)
    return system, {x: place.subs(vo.time, 0), Dx: rate.subs(vo.time, 0)}, rate


DICE = Random(3)
ROOTS = [
    [1, 2, 3], [sp.Rational(k, 2) for k in range(2, 8)],
    [1, 1 + sp.Rational(1, 10**5), 2], [1, 2, 2 + sp.Rational(1, 10**4)],
    *(sorted(DICE.sample([sp.Rational(k, 20) for k in range(1, 80)], n)) for n in (2, 5, 8)),
]  # fmt: skip


METHODS = (*DOUBLES, "flint", *COMPILED)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("roots", ROOTS, ids=str)
def test_simple_roots_of_polynomials_are_all_found_once(roots: Any, method: str) -> None:
    """They are where a step is halved, or close together: Taylor's method takes one step."""
    system, start, rate = polynomial(roots)
    run = vo.integrate(
        system, initial=start, times=[0, 2, 4], events=("x", vo.Event(Dx, "turn")), method=method
    )
    assert close(run.events["x"].t, roots, 1e-6)
    assert close(run.events["turn"].t, sp.Poly(rate, vo.time).nroots(n=30), 1e-6)
    up = vo.Event("x", "up", direction=1, stop=True)
    end = vo.integrate(system, initial=start, times=[0, 4], events=up, method=method)
    assert end.stopped == "up" and close(end.t[-1:], roots[len(roots) % 2 == 0 :][:1], 1e-6)


@pytest.mark.skipif("heyoka" not in DOUBLES, reason="no heyoka")
def test_a_search_among_roots_that_rounding_hides_ends() -> None:
    """Where four lie close together a long step's rounding exceeds the polynomial."""
    system, start, _ = polynomial(
        [2, *(sp.Rational(k, 10**5) for k in (566667, 566677, 567667, 567767))]
    )
    run = vo.integrate(system, initial=start, times=[0, 10], events="x", method="heyoka")
    first, *others = np.array(run.events["x"].t, dtype=float)
    assert (
        abs(first - 2) < 1e-9
        and len(others) in (0, 2, 4)
        and all(abs(t - 5.67) < 0.02 for t in others)
    )


@pytest.mark.skipif("heyoka" not in DOUBLES, reason="no heyoka")
def test_a_root_without_a_change_of_sign_is_noted() -> None:
    system, start, _ = polynomial([2, 2])
    run = vo.integrate(system, initial=start, times=[0, 4], events="x", method="heyoka")
    (note,) = run.notes
    assert note.startswith("the event 'x' touches zero at t = 2") and not len(run.events["x"])


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("method", [*DOUBLES, "flint"])
def test_all_that_happens_at_the_instant_of_a_stop_is_told(method: str, way: int) -> None:
    stops = [vo.Event(k * x, f"{k}", stop=True) for k in (1, 2)]
    later = vo.Event(x + sp.Rational(1, 10**6), "later")
    found = cosine(method, way * GRID, events=(*stops, vo.Event(x * Dx, "product"), later))
    assert found.stopped in ("1", "2") and len(found.events["later"]) == 0
    for name in ("1", "2", "product"):
        assert close(found.events[name].t, [way * np.pi / 2])
        assert found.events[name].t[0] == found.t[-1]

"""No run ends well that did not go well; what cannot be had is refused, what is done is kept."""

from __future__ import annotations

import dataclasses
import warnings
from typing import Any

import numpy as np
import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec.equations.program import Block, Program, compile_program, hoist
from voronec.motion import methods, step_defects
from voronec.motion import motion_pool as many_motions
from voronec.motion.integration import first_success
from voronec.motion.steppers import Termination
from voronec.motion.steppers import heyoka_stepper as taylor
from voronec.motion.steppers.samples import NODES, StepSamples, by_owner

pytestmark = pytest.mark.slow

x, u = sp.symbols("x u")
m, length, g = sp.symbols("m l g")
OSCILLATOR = vo.System(
    name="oscillator",
    fibration=vo.Fibration(base=(x,)),
    lagrangian=vo.velocity(x) ** 2 / 2 - x**2 / 2,
)
PENDULUM = vo.System(
    name="pendulum",
    fibration=vo.Fibration(base=(u,)),
    lagrangian=m * length**2 * vo.velocity(u) ** 2 / 2 + m * g * length * sp.cos(u),
    parameters=(m, length, g),
)


def test_one_number_is_the_end_of_the_span() -> None:
    traj = vo.integrate(OSCILLATOR, times=5.0, initial={x: 1})
    assert traj.t[0] == 0 and traj.t[-1] == 5 and len(traj) == 1001
    assert np.abs(traj["x"] - np.cos(traj.t)).max() < 1e-12
    assert vo.integrate(OSCILLATOR, times=-2, initial={x: 1}).t[-1] == -2
    with pytest.raises(vo.DefinitionError, match="end of a span"):
        vo.integrate(OSCILLATOR, times=0.0, initial={x: 1})


def test_names_of_one_block_mean_nothing_in_another() -> None:
    a, q, c = se.symbols("a q c0")
    program = Program(
        time=se.Symbol("t"), coordinates=(q,), velocities=(), parameters=(a,),
        derivative=Block(((c, -(a**2)),), (c * q,)),
        names=("root",), extras=Block(((c, q + a),), (se.sqrt(c),)),
    )  # fmt: skip
    raised = hoist(program)
    values = raised.values([2.0])
    assert np.isfinite(values).all()
    assert compile_program(raised.program)[1](0.0, [7.0], values)[0] == 3.0
    assert compile_program(raised.program)[0](0.0, [7.0], values)[0] == -28.0


def test_a_parameter_that_leaves_no_inertia_is_refused() -> None:
    wanted: dict[str, Any] = {"times": [0, 1], "parameters": {m: 0, length: 1, g: 1}}
    for outputs in ((), ("u",)):
        with pytest.raises(vo.DefinitionError, match="for m = 0 the mass matrix is singular"):
            vo.integrate(PENDULUM, initial={u: 1}, outputs=outputs, **wanted)
    assert vo.integrate(
        PENDULUM, initial={u: 1}, **wanted | {"parameters": {m: 1, length: 1, g: 0}}
    )
    found = vo.ensemble(PENDULUM, {"u": 1.0}, {"m": [0.0, 1.0], "l": 1, "g": 1}, times=[0, 1])
    assert "m = 0" in str(found.errors[0]) and found.finished.tolist() == [False, True]


@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
def test_ctrl_c_between_distant_instants_keeps_where_the_run_stood(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if method == "heyoka":
        pytest.importorskip("heyoka")
    monkeypatch.setattr(taylor, "CHUNK", 50)
    monkeypatch.setattr("voronec.motion.steppers.run.EVERY", 0.0)

    def stop(fraction: float) -> None:
        if fraction > 0.2:
            raise KeyboardInterrupt

    times = [0, 3000] if method != "flint" else [0, 1000]
    traj = vo.integrate(OSCILLATOR, times=times, initial={x: 1}, method=method, progress=stop)
    assert traj.interrupted and len(traj) == 2 and 0 < traj.t[1] < times[1] / 2
    assert abs(float(traj["x"][1]) - np.cos(float(traj.t[1]))) < 1e-10


@pytest.mark.parametrize(("method", "end"), [("scipy", 1000), ("flint", 60)])
def test_ctrl_c_in_a_window_that_nobody_asked_for_keeps_where_the_run_stood(
    method: str, end: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("voronec.motion.steppers.run.EVERY", 0.0)

    def stop(fraction: float) -> None:
        if fraction > 1 - 1.8 / end:
            raise KeyboardInterrupt

    traj = vo.integrate(OSCILLATOR, times=[0, end], initial={x: 1}, method=method, progress=stop)
    assert traj.interrupted and len(traj) == 2 and end - 2 <= traj.t[1] < end
    assert abs(float(traj["x"][1]) - np.cos(float(traj.t[1]))) < 1e-9


def test_ctrl_c_in_the_set_up_of_an_ensemble_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_args: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(many_motions, "starts_in_arrays", stop)
    found = vo.ensemble(OSCILLATOR, {"x": [1.0, 2.0, 3.0, 4.0]}, times=[0, 1])
    assert found.interrupted and not found.finished.any() and not found.errors
    assert found["x"].shape == (4, 2) and np.isnan(found["x"]).all()


def test_auto_goes_on_with_another_method_where_its_choice_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("heyoka")
    monkeypatch.setattr(methods, "HEAVY", 0)  # so that DOP853 is chosen over so short a span

    make = methods.METHODS["scipy"].make
    assert make is not None

    def broken(problem: Any) -> Any:
        def run(grid: np.ndarray) -> Any:
            whole = make(problem)(grid)
            halt = Termination("the step size collapsed", whole.t[1], whole.states[1])
            return dataclasses.replace(whole, t=whole.t[:2], states=whole.states[:2], halt=halt)

        return run

    fails = dataclasses.replace(methods.METHODS["scipy"], make=broken)
    monkeypatch.setitem(methods.METHODS, "scipy", fails)
    disc = vo.derive(vo.load("falling-disc"))
    start = {"theta": 1.2, "p": 0.3, "q": 1e-6, "s": 1e-6}
    wanted: dict[str, Any] = {
        "initial": start,
        "times": [0, 0.5, 1, 2, 3],
        "outputs": ("theta", "p"),
    }
    with pytest.raises(vo.IntegrationError):
        vo.integrate(disc, method="scipy", **wanted)
    found = vo.integrate(disc, **wanted)
    assert found.cost.method == "heyoka" and "scipy" in found.cost.reason
    exact = vo.integrate(disc, method="flint", tol=1e-25, **wanted)
    for name in ("theta", "p"):
        assert np.abs(found[name] - exact[name].astype(float)).max() < 1e-6


def test_the_error_of_the_attempt_that_came_farthest_is_raised() -> None:
    errors = [vo.IntegrationError(str(t), t, np.zeros(1)) for t in (1.0, 5.0, 2.0)]

    def failing(error: vo.IntegrationError) -> Any:
        def way(_: Any) -> Any:
            raise error

        return way

    with pytest.raises(vo.IntegrationError, match=r"5\.0"):
        first_success([failing(e) for e in errors], 0.0)


def corrupted(monkeypatch: pytest.MonkeyPatch, time: float, jump: np.ndarray) -> None:
    """scipy's integrator goes on from another state after some time, once, and says nothing."""
    from scipy.integrate import DOP853

    step, done = DOP853.step, []

    def wrong(self: Any) -> Any:
        before = self.t
        message = step(self)
        if min(before, self.t) < time <= max(before, self.t) and not done:
            done.append(self.t)
            self.y = self.y + np.pad(jump, (0, len(self.y) - len(jump)))
            self.f = self.fun(self.t, self.y)
        return message

    monkeypatch.setattr(DOP853, "step", wrong)


GRID = np.linspace(0, 10, 501)


def test_a_tolerance_that_was_not_taken_is_told() -> None:
    fine, held = (
        vo.integrate(OSCILLATOR, times=[0, 1], initial={x: 1}, method="scipy", tol=tol)
        for tol in (1e-15, 1e-13)
    )
    assert fine.notes == ("scipy goes no finer than tol = 2.3e-14, taken for 1e-15",)
    assert held.notes == ()


def test_claims_that_drift_are_told_of_many_motions() -> None:
    """Of an ensemble, of a section in lanes, and of one that is followed by ``integrate``."""
    dot, u = vo.velocity(x), sp.Symbol("u")
    energy = dot**2 / 2 + x**2 / 2
    system = dataclasses.replace(OSCILLATOR, integrals={"energy": energy, "false": x + 2 * dot})
    starts = {x: np.array([1.0, 2.0])}
    many = vo.ensemble(system, times=GRID, starts=starts, method="scipy")
    passed = vo.section(system, plane="x", starts=starts, crossings=3, method="scipy")
    driven = dataclasses.replace(system, forces={x: u}, inputs=(u,))
    table = vo.Table([0, 30], [0, 0])
    followed = vo.section(
        driven, plane="x", starts=starts, crossings=3, until=20, method="scipy", inputs={u: table}
    )
    for found in (many, passed, followed):
        assert {*found.notes} == {0, 1} and not found.errors
        assert all(any("'false' is only claimed, and drifts: at t = " in note for note in notes)
                   for notes in found.notes.values())  # fmt: skip
    assert not vo.ensemble(OSCILLATOR, times=GRID, starts=starts, method="scipy").notes


def test_a_lost_integral_ends_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    dot = vo.velocity(x)
    system = dataclasses.replace(
        OSCILLATOR, integrals={"energy": dot**2 / 2 + x**2 / 2, "position": x, "none": x - x}
    )
    # what is only claimed, and not so, is a note
    sound = vo.integrate(system, times=GRID, initial={x: 1}, method="scipy")
    assert len(sound.notes) == 1
    assert "'position' is only claimed, and drifts: at t = " in sound.notes[0]
    corrupted(monkeypatch, 4.0, np.array([1e-6, 0.0]))
    with pytest.raises(vo.IntegrationError, match="the integral 'energy' drifts by") as caught:
        vo.integrate(system, times=GRID, initial={x: 1}, method="scipy")
    trajectory = caught.value.trajectory
    assert trajectory.t[-1] == caught.value.time and 3 < caught.value.time < 5
    assert np.abs(trajectory["x"] - np.cos(trajectory.t)).max() < 1e-10


def test_a_lost_relation_ends_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """That of variables which have it by their meaning."""
    system = dataclasses.replace(vo.load("suslov"), integrals={})
    corrupted(monkeypatch, 1.0, np.array([0, 1e-3]))
    with pytest.raises(vo.IntegrationError, match=r"the relation .* gamma3\*\*2 = 0 is lost by"):
        vo.integrate(
            system, times=np.linspace(0, 2, 21), outputs=("gamma1", "gamma2", "gamma3"),
            method="scipy", tol=1e-10,
        )  # fmt: skip


@pytest.mark.parametrize("mass", [1e-20, 1, 1e20])
def test_a_wrong_run_is_noticed_whatever_the_masses(
    monkeypatch: pytest.MonkeyPatch, mass: float
) -> None:
    dot, m = vo.velocity(x), sp.Symbol("m")
    energy = m * dot**2 / 2 + m * x**2 / 2
    system = dataclasses.replace(
        OSCILLATOR, lagrangian=energy - m * x**2, parameters=(m,),
        integrals={"energy": energy, "false": m * (x + 2 * dot)},
    )  # fmt: skip
    options: dict[str, Any] = {"parameters": {m: mass}, "method": "scipy"}
    starts = {x: [1.0, 2.0]}
    runs = {
        "integrate": lambda: vo.integrate(system, times=GRID, initial={x: 1}, **options),
        "ensemble": lambda: vo.ensemble(system, times=GRID, starts=starts, **options),
        "section": lambda: vo.section(system, "x", starts=starts, crossings=3, **options),
    }
    sound = {name: run() for name, run in runs.items()}
    assert len(sound["integrate"].notes) == 1 and sound["integrate"].drift["false"] > 0.5
    for name in ("ensemble", "section"):
        assert {*sound[name].notes} == {0, 1} and not sound[name].errors
        assert sound[name].drift["energy"].max() < 1e-9 < 0.5 < sound[name].drift["false"].min()
    for name, run in runs.items():
        with monkeypatch.context() as patch:
            corrupted(patch, 4.0, np.array([1e-6, 0.0]))
            if name == "integrate":
                with pytest.raises(vo.IntegrationError, match="the integral 'energy' drifts by"):
                    run()
            else:
                assert "the integral 'energy' drifts by" in str(run().errors[0])


def test_an_integral_that_begins_without_a_value_is_followed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    dot = vo.velocity(x)
    ratio = (dot**3 + dot**2 * x + dot * x**2 + x**3) / (dot + x)  # 0/0 at the start
    system = dataclasses.replace(OSCILLATOR, integrals={"ratio": ratio})
    start = {x: 1, dot: -1}
    sound = vo.integrate(system, times=GRID, initial=start, method="scipy")
    assert np.isnan(sound.integrals["ratio"][0]) and 0 < sound.drift["ratio"] < 1e-11
    corrupted(monkeypatch, 4.0, np.array([1e-6, 0.0]))
    with pytest.raises(vo.IntegrationError, match="the integral 'ratio' drifts by"):
        vo.integrate(system, times=GRID, initial=start, method="scipy")


@pytest.mark.parametrize("times", [[0, 10], [0, 3, 10], [20, 10], [*range(10), 12]])
def test_a_coarse_grid_is_looked_at_between_its_instants(
    monkeypatch: pytest.MonkeyPatch, times: list[float]
) -> None:
    """Before some of them, in windows that resolve the motion; nobody sees those."""
    good = vo.integrate(OSCILLATOR, times=times, initial={x: 1}, method="scipy")
    assert good.t.tolist() == times
    assert np.abs(good["x"] - np.cos(good.t - times[0])).max() < 1e-11
    late = times[-1] - 0.1 if times[0] == 0 else 10.1
    corrupted(monkeypatch, late, np.array([0.0, 1e-4]))
    with pytest.raises(vo.IntegrationError, match="do not obey the equations") as caught:
        vo.integrate(OSCILLATOR, times=times, initial={x: 1}, method="scipy")
    assert caught.value.trajectory.t.tolist() == times[:-1]


@pytest.mark.parametrize("times", [[0, 2.9], np.linspace(0, 2.9, 100), [0, 6], [0, 4, 5, 6]])
def test_what_is_not_smooth_is_looked_at_on_both_sides_of_its_switches(
    monkeypatch: pytest.MonkeyPatch, times: Any
) -> None:
    """A block on a spring slides to rest after half a period and is held; a clock swings on."""
    dot, clock = vo.velocity(x), sp.Symbol("y")
    system = vo.System(
        name="block and clock",
        fibration=vo.Fibration(base=(x, clock)),
        lagrangian=(dot**2 - x**2 + vo.velocity(clock) ** 2 - 9 * clock**2) / 2,
        forces={x: -2 * sp.sign(dot) / 5},
    )
    start = {x: 1, clock: 1}
    good = vo.integrate(system, times=times, initial=start, method="scipy")
    still = np.minimum(good.t, np.pi)
    assert np.abs(good["x"] - 0.4 - 0.6 * np.cos(still)).max() < 1e-10
    assert np.abs(good["y"] - np.cos(3 * good.t)).max() < 1e-10 and len(good) == len(times)
    corrupted(monkeypatch, times[-1] - 0.15, np.array([0.0, 0.0, 0.0, 1e-4]))
    with pytest.raises(vo.IntegrationError, match="do not obey the equations"):
        vo.integrate(system, times=times, initial=start, method="scipy")


def test_states_that_do_not_obey_the_equations_end_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    driven = dataclasses.replace(OSCILLATOR, forces={x: sp.cos(sp.sqrt(2) * vo.time)})
    good = vo.integrate(driven, times=GRID, initial={x: 1}, method="scipy")
    exact = 2 * np.cos(GRID) - np.cos(np.sqrt(2) * GRID)  # of x'' + x = cos(sqrt(2) t)
    assert np.abs(good["x"] - exact).max() < 1e-10 and not good.notes
    corrupted(monkeypatch, 6.0, np.array([0.0, 1e-4]))
    with pytest.raises(vo.IntegrationError, match="do not obey the equations") as caught:
        vo.integrate(driven, times=GRID, initial={x: 1}, method="scipy")
    assert 4 < caught.value.time < 6.5
    seen = caught.value.trajectory
    apart = np.abs(seen["x"] - exact[: len(seen)])
    # the polynomial of the step that the jump ends feels it before, by a part of 1e-4
    assert apart[seen.t < 5.5].max() < 1e-10 and apart.max() < 1e-8


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_what_is_fast_between_two_instants_is_no_fault(method: str) -> None:
    # a free particle in polar coordinates passes the origin at a distance of 1e-3: phi turns by pi
    if method == "heyoka":
        pytest.importorskip("heyoka")
    r, phi = sp.symbols("r phi")
    system = vo.System(
        name="polar",
        fibration=vo.Fibration(base=(r, phi)),
        lagrangian=(vo.velocity(r) ** 2 + r**2 * vo.velocity(phi) ** 2) / 2,
        integrals={"momentum": r**2 * vo.velocity(phi)},
    )
    near = 1e-3
    away = np.hypot(1, near)
    initial = {r: away, "rdot": -1 / away, "phidot": -near / away**2}
    times = np.linspace(0, 1.987, 400)
    traj = vo.integrate(system, times=times, initial=initial, method=method)
    turned = np.arctan2(near, 1.0) - np.arctan2(near, 1 - times)
    assert np.abs(traj["phi"] - turned).max() < 1e-6
    assert not traj.notes


def test_a_run_through_a_singular_frame_is_right_or_refused() -> None:
    pytest.importorskip("heyoka")
    ball = vo.derive(vo.load("veselova"))
    wanted: dict[str, Any] = {
        "times": np.linspace(0, 10, 401),
        "outputs": ("omega1", "omega2", "gamma1", "gamma3"),
        "initial": {"theta": 1.2, "omega1": 0.9, "omega2": 0.45},
    }
    exact = vo.integrate(ball, method="flint", tol=1e-30, **wanted)
    for tol in (1e-13, 1e-16):
        try:
            found = vo.integrate(ball, method="heyoka", tol=tol, **wanted)
        except vo.IntegrationError as error:
            found = error.trajectory
        for name in wanted["outputs"]:
            true = exact[name][: len(found)].astype(float)
            assert np.abs(found[name] - true).max() < 1e-3


@pytest.mark.parametrize("name", ["sleigh", "falling-disc", "suslov", "snakeboard"])
def test_nothing_is_said_of_a_run_that_went_well(name: str) -> None:
    equations = vo.derive(vo.load(name))
    for scene in equations.system.scenes:
        assert vo.integrate(equations, scene, method="scipy").notes == ()


@pytest.mark.parametrize("outputs", [(), ("x",)])
def test_a_mass_matrix_that_is_not_positive_is_told_of(outputs: tuple[str, ...]) -> None:
    y, m = sp.symbols("y m")
    kinetic = m * vo.velocity(x) ** 2 / 2 + x * vo.velocity(x) * vo.velocity(y) / 4
    system = vo.System(
        name="pair", fibration=vo.Fibration((x, y)), parameters=(m,),
        lagrangian=kinetic + vo.velocity(y) ** 2 / 2 - y**2 / 2,
    )  # fmt: skip
    given = {"times": [0, 0.1], "initial": {x: 1, y: 1}, "outputs": outputs}
    assert vo.integrate(system, **given, parameters={m: 1}).notes == ()
    (note,) = vo.integrate(system, **given, parameters={m: -1}).notes
    assert note == "the mass matrix is not positive definite at the start; check the signs in L"


def test_a_motion_of_an_ensemble_that_goes_wrong_is_marked(monkeypatch: pytest.MonkeyPatch) -> None:
    dot = vo.velocity(x)
    system = dataclasses.replace(OSCILLATOR, integrals={"energy": dot**2 / 2 + x**2 / 2})
    for own in (system, dataclasses.replace(OSCILLATOR, forces={x: sp.Rational(1, 10)})):
        with monkeypatch.context() as patch:
            # the first motion jumps, where its windows see it: near the start
            corrupted(patch, 0.05, np.array([0.0, 1e-3]))
            found = vo.ensemble(own, {"x": [1.0, 2.0]}, times=GRID, method="scipy")
        assert set(found.errors) == {0} and found.finished.tolist() == [False, True]
        assert found.errors[0].time < 0.2 and np.isnan(found["x"][0, -1])
        again = vo.ensemble(own, {"x": [1.0, 2.0]}, times=GRID, method="scipy")
        assert not again.errors and np.array_equal(again["x"][1], found["x"][1])


def test_coarse_grids_of_ensembles_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    driven = dataclasses.replace(OSCILLATOR, forces={x: sp.Rational(1, 10)})
    sound = vo.ensemble(driven, {"x": [1.0, 2.0]}, times=[0, 10], method="scipy")
    assert not sound.errors and sound["x"].shape == (2, 2)
    assert np.abs(sound["x"][:, 1] - 0.1 - np.array([0.9, 1.9]) * np.cos(10)).max() < 1e-10
    corrupted(monkeypatch, 9.5, np.array([0.0, 1e-4]))
    found = vo.ensemble(driven, {"x": [1.0, 2.0]}, times=[0, 10], method="scipy")
    assert set(found.errors) == {0} and found.errors[0].time > 8
    assert np.array_equal(found["x"][1], sound["x"][1]) and np.isnan(found["x"][0, 1])


def test_a_section_keeps_the_points_before_an_integral_is_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    dot = vo.velocity(x)
    system = dataclasses.replace(OSCILLATOR, integrals={"energy": dot**2 / 2 + x**2 / 2})
    wanted: dict[str, Any] = {"starts": {"x": [1.0]}, "crossings": 8, "outputs": ("xdot",)}
    sound = vo.section(system, x, method="scipy", **wanted)
    assert not sound.errors and np.abs(sound["xdot"] - 1).max() < 1e-9
    corrupted(monkeypatch, 20.0, np.array([0.0, 1e-7]))
    cut = vo.section(system, x, method="scipy", **wanted)
    assert "'energy' drifts" in str(cut.errors[0]) and cut.ends == ("failed",)
    assert 0 < len(cut) < 8 and cut.t[-1] < 21 and np.abs(cut["xdot"] - 1).max() < 1e-9


def test_a_section_keeps_the_points_before_the_equations_are_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    driven = dataclasses.replace(OSCILLATOR, forces={x: sp.Rational(1, 10)})
    wanted: dict[str, Any] = {"starts": {"x": [1.0]}, "crossings": 8, "outputs": ("xdot",)}
    sound = vo.section(driven, x, method="scipy", **wanted)
    assert not sound.errors and len(sound) == 8
    corrupted(monkeypatch, 20.0, np.array([0.0, 1e-4]))
    cut = vo.section(driven, x, method="scipy", **wanted)
    assert "do not obey the equations" in str(cut.errors[0]) and cut.ends == ("failed",)
    assert 0 < len(cut) < 8 and np.abs(cut["xdot"] - sound["xdot"][: len(cut)]).max() < 1e-9


def test_only_steps_that_seem_wrong_are_integrated_again() -> None:
    """Of a motion, of one that jumps at the end of a step, and of one that jumps between two."""
    asked = []

    def rates(t: np.ndarray, states: np.ndarray) -> np.ndarray:
        asked.append(len(t))
        return np.stack([states[..., 1], -states[..., 0]], axis=-1)

    times = np.arange(3.0)[:, None] + NODES
    states = np.stack([np.cos(times), -np.sin(times)], axis=-1)

    def wrong(rows: np.ndarray) -> list[int]:
        samples = by_owner([StepSamples(times, rows)])
        return [i for _, _, i in step_defects.wrong_steps(samples, lambda _: rates, 1e-10)]

    assert wrong(states) == [] and asked == [times.size]
    within, between = states.copy(), states.copy()
    within[2, -1] += 1e-4
    assert wrong(within) == [2] and len(asked) > 2
    between[1:] *= 1 + 1e-4  # which is a motion, too
    assert wrong(between) == [0]


def test_rows_that_are_off_their_steps_are_seen() -> None:
    times = np.arange(3.0)[:, None] + NODES
    t, steps = np.linspace(0, 3, 7), StepSamples(times, np.cos(times)[..., None])
    rows = np.cos(t)[:, None]
    assert [*step_defects.strayed_rows(t, rows[None], steps, 1e-10)] == []
    rows[4] += 1e-5
    assert [*step_defects.strayed_rows(t, rows[None], steps, 1e-10)] == [3]


@pytest.mark.parametrize("method", ["heyoka", "c", "scipy"])
@pytest.mark.parametrize("tol", [1e-6, 1e-13])
def test_what_is_right_is_not_integrated_again(
    method: str, tol: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the grids of users, coarse or fine, whatever the spins; alone and side by side."""
    if methods.METHODS[method].absence:
        pytest.skip(method)
    asked, again = [], step_defects.again
    monkeypatch.setattr(step_defects, "again", lambda *x: asked.append(x) or again(*x))
    ball, dice = vo.derive(vo.load("ball-on-sphere")), np.random.default_rng(4)
    for times in ([0, 30], np.linspace(0, 30, 11), np.linspace(0, 30, 200)):
        spins = {f"omega{i}": dice.normal(size=4, scale=2.0) for i in (1, 2, 3)}
        start = {"u": 2.0, "theta": 1.0, "u1": 1.0}
        many = vo.ensemble(ball, {**start, **spins}, times=times, method=method, tol=tol)
        assert not many.errors
        for k in range(4):
            own = {**start, **{name: x[k] for name, x in spins.items()}}
            run = vo.integrate(ball, times=times, initial=own, method=method, tol=tol)
            assert "fails" not in run.cost.reason
    assert not asked


@pytest.mark.parametrize("method", ["heyoka", "flint"])
def test_an_output_without_a_value_is_noted(method: str) -> None:
    x = sp.Symbol("x")
    oscillator = vo.System(
        name="oscillator",
        fibration=vo.Fibration(x),
        lagrangian=vo.velocity(x) ** 2 / 2 - x**2 / 2,
    )
    run = vo.integrate(
        oscillator, initial={x: 1}, times=[0, 1, 2, 3], outputs=(sp.log(x),), method=method
    )
    (note,) = run.notes
    assert note == "the output 'log(x)' has no finite value at 2 of 4 instants, first at t = 2"


@pytest.mark.parametrize("method", ["auto", "scipy"])
def test_a_state_beyond_doubles_ends_a_run_in_words_alone(method):
    """Squares of 1e160 are infinite, and so are the integrals."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(vo.IntegrationError, match=r"no longer finite|collapsed") as caught:
            vo.integrate(vo.load("suslov"), initial={"omega1": 1e160}, times=[0, 1], method=method)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("end", [2, 0])
@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_a_run_that_ends_at_a_pole_in_time_says_where(method, end):
    x = sp.Symbol("x")
    kicked = vo.System(
        name="kicked",
        fibration=vo.Fibration(x),
        lagrangian=vo.velocity(x) ** 2 / 2,
        forces={x: 1 / (vo.time - 1)},
    )
    with pytest.raises(vo.IntegrationError) as caught:
        vo.integrate(kicked, initial={x: 0}, times=[2 - end, end], method=method)
    assert caught.value.time == pytest.approx(1, abs=1e-6)
    assert np.isfinite(caught.value.state).all()


@pytest.mark.parametrize("tol", [1e-13, 1e-16, 1e-25])
def test_a_claim_that_drifts_is_told_at_every_tolerance(tol):
    # the curvature of x^2 was taken for rounding over rounding where tolerances are finer than it
    x = sp.Symbol("x")
    v = vo.velocity(x)
    spring = vo.System(
        name="spring", fibration=vo.Fibration((x,)), lagrangian=(v**2 - x**2) / 2,
        integrals={"wrong": v**2 + 2 * x**2},
    )  # fmt: skip
    run = vo.integrate(spring, initial={x: 1}, times=[0, 1, 3], tol=tol)
    assert "'wrong' is only claimed, and drifts" in run.notes[0]

"""Trajectories: closed forms, conservation, two integrators, and what a user may get wrong."""

from __future__ import annotations

import csv
import dataclasses
import sys
from dataclasses import replace
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from sympy.physics.mechanics import dynamicsymbols

import voronec as vo
from voronec.motion import batches
from voronec.motion.steppers import heyoka_stepper as taylor
from voronec.motion.steppers import run as steps
from voronec.motion.steppers import scipy_stepper as stepwise

METHODS = ("scipy", "heyoka") if find_spec("heyoka") else ("scipy",)
both = pytest.mark.parametrize("method", METHODS)

x, y, phi, v, w, m, a, J, k, g = sp.symbols("x y phi v w m a J k g")
Dx, Dy, Dphi = map(vo.velocity, (x, y, phi))

SLEIGH = vo.System(
    name="test-sleigh",
    fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
    frame=vo.Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
    lagrangian=m * ((Dx - a * sp.sin(phi) * Dphi) ** 2 + (Dy + a * sp.cos(phi) * Dphi) ** 2) / 2
    + J * Dphi**2 / 2,
    constraints=(Dy * sp.cos(phi) - Dx * sp.sin(phi),),
    parameters=(
        vo.Parameter(m, 1, positive=True),
        vo.Parameter(J, sp.Rational(1, 3), positive=True),
        a,
    ),
    integrals={"energy": (m * v**2 + (J + m * a**2) * w**2) / 2, "nothing": w - Dphi},
    scenes={
        "default": vo.Scene(initial={v: 1, w: 2}, times=(0, 5), parameters={a: 0.2}),
        "spin": vo.Scene(initial={"w": 1}, parameters={"a": 0.5}, outputs=("x", x**2 + y**2)),
    },
)
GRID = np.linspace(0.0, 7.0, 141)


def oscillator(**more: Any) -> vo.System:
    """xddot = -k x / m + force."""
    return vo.System(
        name="oscillator", fibration=vo.Fibration(base=(x,)),
        lagrangian=m * Dx**2 / 2 - k * x**2 / 2, parameters=(vo.Parameter(m, 2), k), **more,
    )  # fmt: skip


def pendulum() -> vo.System:
    """phiddot = -g sin(phi)."""
    energy = Dphi**2 / 2 - g * sp.cos(phi)
    return vo.System(
        name="pendulum", fibration=vo.Fibration(base=(phi,)), parameters=(g,),
        lagrangian=Dphi**2 / 2 + g * sp.cos(phi), integrals={"energy": energy},
    )  # fmt: skip


def test_two_integrators_agree_and_say_what_they_did() -> None:
    first, second = (vo.integrate(SLEIGH, method=name) for name in (METHODS[-1], METHODS[0]))
    assert np.abs(first.state - second.state).max() < 1e-10
    assert len(first.t) == 1001 and first.t[-1] == 5
    for traj in (first, second):
        assert max(traj.drift.values()) < 1e-11
        assert traj.cost.evaluations >= traj.cost.steps
        assert "asked for" in str(traj.cost)


def test_auto_takes_scipy_where_heyoka_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    # None in the table of modules is how Python says that an import fails
    for name in ("heyoka", "numba"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setenv("PATH", "")  # and no C compiler
    traj = vo.integrate(SLEIGH, tol=1e-15)  # too fine a tolerance for Python alone
    assert traj.cost.method == "scipy" and "not installed" in traj.cost.reason
    assert traj.cost.tolerance == stepwise.FINEST
    with pytest.raises(vo.DefinitionError, match="heyoka is not installed"):
        vo.integrate(SLEIGH, method="heyoka")


def test_tighter_tolerance_means_less_error() -> None:
    exact = np.cos(2 * GRID)
    errors = []
    for tol in (1e-4, 1e-8, 1e-12):
        traj = vo.integrate(
            oscillator(), times=GRID, initial={x: 1}, parameters={k: 8}, tol=tol, method="scipy"
        )
        errors.append(np.abs(traj["x"] - exact).max())
    assert errors[0] > 30 * errors[1] > 900 * errors[2]


def test_names_symbols_and_expressions_are_understood() -> None:
    traj = vo.integrate(SLEIGH, outputs=("x", phi, Dy, "energy", sp.cos(phi) * v, vo.time * a))
    assert traj.outputs == ("x", "phi", "ydot", "energy", "v*cos(phi)", "a*t")
    assert np.array_equal(traj["x"], traj[x]) and np.array_equal(traj[v], traj["v"])
    assert np.allclose(traj["ydot"], traj[v] * np.sin(traj[phi]), rtol=1e-15)
    assert np.allclose(traj[sp.cos(phi) * v], traj[v] * np.cos(traj[phi]), rtol=1e-15)
    assert np.allclose(traj["a*t"], 0.2 * traj.t, rtol=1e-15)
    assert np.ptp(traj["energy"]) < 1e-12
    assert dict(traj.parameters) == pytest.approx({"m": 1, "J": 1 / 3, "a": 0.2})


def test_dynamicsymbols_are_understood() -> None:
    q = dynamicsymbols("q")
    system = vo.System(
        name="dynamic", fibration=vo.Fibration(base=(q,)),
        lagrangian=q.diff(vo.time) ** 2 / 2 - q**2 / 2,
    )  # fmt: skip
    traj = vo.integrate(system, times=GRID, initial={q: 0, q.diff(vo.time): 2}, outputs=(q, q**2))
    assert np.allclose(traj[q], 2 * np.sin(GRID), atol=1e-11)
    assert np.allclose(traj[q**2], traj["q"] ** 2)


def test_a_scene_gives_what_is_not_given() -> None:
    traj = vo.integrate(SLEIGH, scene="spin", initial={"x": 3}, times=[0.0, 1.0])
    assert traj.outputs == ("x", "x**2 + y**2") and traj["x"][0] == 3 and traj["w"][0] == 1
    same = vo.integrate(SLEIGH, scene=SLEIGH.scenes["spin"], initial={"x": 3}, times=[0.0, 1.0])
    assert np.array_equal(traj.state, same.state)
    # equations derived before save the derivation, and say the same
    again = vo.integrate(vo.derive(SLEIGH), scene="spin", initial={"x": 3}, times=[0.0, 1.0])
    assert np.array_equal(traj.state, again.state)


@pytest.mark.parametrize(
    "initial",
    [
        {"v": 2, "phi": sp.pi / 6, "w": 3},
        {Dx: sp.sqrt(3), phi: sp.pi / 6, w: 3},
        {"ydot": 1, "phi": sp.pi / 6, Dphi: 3},
        {"xdot": sp.sqrt(3), "ydot": 1, "v": 2, "phidot": 3, "phi": sp.pi / 6},
        {"v": 10 * a, "phi": sp.pi / 6, "w": 3},
    ],
)
def test_initial_velocities_of_any_kind(initial: Any) -> None:
    traj = vo.integrate(SLEIGH, times=[0.0], initial=initial, parameters={a: 0.2})
    assert traj["v"][0] == pytest.approx(2, rel=1e-12) and traj["w"][0] == 3
    assert traj.cost.steps == 0


def test_what_the_scene_says_of_other_velocities_stays() -> None:
    traj = vo.integrate(SLEIGH, scene="default", initial={"xdot": 4}, times=[0.0])
    assert (traj["v"][0], traj["w"][0]) == (pytest.approx(4), 2)


def test_an_integral_that_starts_at_zero_has_a_meaningful_drift() -> None:
    energy = m * Dx**2 / 2 + k * x**2 / 2
    system = oscillator(
        integrals={"even": energy - 8 * 10**6, "drifting": x, "zero": 0 * x, "whole": energy}
    )
    # sqrt(2) makes the even energy start at rounding error, not at zero
    start = {x: 1000 * sp.sqrt(2)}
    traj = vo.integrate(system, times=GRID, initial=start, parameters={k: 8})
    assert abs(traj["even"][0]) < 1e-6 < np.abs(traj["whole"]).min()
    assert traj.drift["even"] < 1e-12  # relative to its terms, of size 8e6
    assert traj.drift["even"] == pytest.approx(traj.drift["whole"] / 2, rel=0.1)
    assert traj.drift["drifting"] == pytest.approx(2, rel=1e-3)
    assert traj.drift["zero"] == 0
    at_rest = vo.integrate(
        oscillator(integrals={"p": Dx}), times=GRID, initial={x: 0}, parameters={k: 8}
    )
    assert at_rest.drift["p"] == 0


@pytest.mark.parametrize("unit", [1, 10**9])
@both
def test_rounding_beside_rounding_is_no_drift(method: str, unit: int) -> None:
    system = replace(oscillator(), parameters=(m, k, a), integrals={"shade": m * Dx * sp.cos(a)})
    start = {"initial": {x: unit}, "times": GRID, "method": method}
    lost = vo.integrate(system, **start, parameters={m: 2, k: 8, a: sp.pi / 2})
    assert 0 < np.abs(lost["shade"]).max() < 1e-14 * unit and lost.drift["shade"] < 1e-14
    for small in (1e-3, 1e-8):  # such terms are there, and change altogether
        seen = vo.integrate(system, **start, parameters={m: 2, k: 8, a: np.pi / 2 - small})
        assert seen.drift["shade"] > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("method", ["scipy", "closed-form"])
@pytest.mark.parametrize("tol", [1e-13, 1e-7])
def test_momenta_that_vanish_throughout_do_not_drift(method: str, tol: float) -> None:
    start = {"u": 1, "v": 0.3, "theta": sp.pi / 2, "u1": 1, "v1": 0.2, "s": 0, "tau": 1, "n": 0}
    found = vo.integrate(
        vo.load("demchenko"), initial=start, parameters={"k": 0}, times=[0, 20], method=method,
        tol=tol,
    )  # fmt: skip
    assert 0 < np.abs(found["momentum z"]).max() < 1e-6
    assert max(found.drift.values()) < 10 * tol


@both
def test_a_parameter_that_the_motion_ignores_may_lack_a_value(method: str) -> None:
    system = vo.System(
        name="ignorant", fibration=vo.Fibration(base=(x,)), parameters=(J, k, m, a),
        lagrangian=m * Dx**2 / 2 - m * k * x**2 / 2,
        integrals={"energy": Dx**2 + k * x**2},
    )  # fmt: skip
    traj = vo.integrate(
        system, times=GRID, initial={x: 1}, parameters={m: 3, k: 4, J: 7}, method=method
    )
    assert np.abs(traj["x"] - np.cos(2 * GRID)).max() < 1e-11
    assert dict(traj.parameters) == {"J": 7, "k": 4, "m": 3}


def unit_vector() -> vo.System:
    """A particle on the unit sphere, by its three coordinates and the angular velocity."""
    n, turn = sp.symbols("n1:4"), sp.symbols("omega1:3")
    dots = [vo.velocity(c) for c in n]
    return vo.System(
        name="unit-vector",
        fibration=vo.Fibration(base=n, relations=(n[0] ** 2 + n[1] ** 2 + n[2] ** 2 - 1,)),
        frame=vo.Frame.quasi(
            {
                turn[0]: n[1] * dots[2] - n[2] * dots[1],
                turn[1]: n[2] * dots[0] - n[0] * dots[2],
            }
        ),
        lagrangian=sum(d**2 for d in dots) / 2 - n[2],
        integrals={"energy": sum(d**2 for d in dots) / 2 + n[2]},
    )


def test_relations_are_checked_at_the_start_and_watched() -> None:
    start = {"n1": 0.6, "n2": 0, "n3": 0.8, "omega1": 0.3, "omega2": -0.2}
    traj = vo.integrate(unit_vector(), times=np.linspace(0, 1, 11), initial=start)
    assert list(traj.residuals) == ["n1**2 + n2**2 + n3**2 - 1 = 0"]
    assert max(traj.residuals.values()) < 1e-12 and traj.drift["energy"] < 1e-12
    with pytest.raises(vo.DefinitionError, match=r"relation .* \(residual 0.0439\)"):
        vo.integrate(unit_vector(), times=[0.0, 1.0], initial=start | {"n1": 0.6355})


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ({"outputs": ("fi",)}, "no output 'fi'"),
        ({"outputs": ("phy",)}, "did you mean 'phi'"),
        ({"outputs": (sp.Symbol("q") + x,)}, "contains 'q'"),
        ({"scene": "defalt"}, "no scene 'defalt'; did you mean 'default'"),
        ({"parameters": {"M": 1}}, "no parameter 'M'"),
        ({"parameters": {m: -1}}, "'m' = -1 must be positive"),
        ({"parameters": {m: "heavy"}}, "'m' = heavy is not a real number"),
        ({"initial": {"m": 1}}, "no initial value 'm', a parameter; give parameters={'m': ...}"),
        ({"initial": {"v": 1, "w": 1}}, "no value for the parameter.* a; give parameters="),
        ({"scene": "spin", "initial": {"ydot": 1}}, "off the constraints: 'ydot' = 1, .* 0 "),
        ({"initial": {"v": 1, "xdot": 2}, "parameters": {a: 0}}, r"where the others give 1 "),
        ({"initial": {"v": 1, v: 2}}, "initial value 'v' is given twice"),
        ({"initial": {"v": sp.nan}, "parameters": {a: 0}}, "initial value 'v' = nan"),
        ({"initial": {"v": 2 * x}, "parameters": {a: 0}}, "initial value 'v' = 2.x is not"),
        ({"times": [0, 1, 1]}, r"times = \[0. 1. 1.\]: times must be a strictly monotonic"),
        ({"times": []}, "strictly monotonic"),
        ({"times": "soon"}, "'soon' .*; times must be a strictly monotonic"),
        ({"times": "0:20"}, "times = 0:20 is not.*; times must be a strictly monotonic"),
        ({"times": (0, 3 * sp.Symbol("second"))}, "times = 3.second is not"),
        ({"times": np.array([0, 3], "timedelta64[s]")}, r"of kind timedelta64\[s\] are no numbers"),
        ({"times": [0, np.inf]}, "finite"),
        (
            {"method": "euler"},
            "no method 'euler'; methods are auto, heyoka, scipy, numba, c, lsoda, flint",
        ),
        ({"tol": 0}, "tol = 0 is not a number between 0 and 1"),
    ],
)
def test_mistakes_are_named(mistake: dict[str, Any], message: str) -> None:
    with pytest.raises(vo.DefinitionError, match=message) as caught:
        vo.integrate(SLEIGH, **mistake)
    assert "\n" not in str(caught.value)


def test_missing_pieces_are_named() -> None:
    with pytest.raises(vo.DefinitionError, match="no scene 'default'; give initial="):
        vo.integrate(oscillator(), parameters={k: 1}, times=GRID)
    with pytest.raises(vo.DefinitionError, match="no scene to take the span from; give times"):
        vo.integrate(oscillator(), parameters={k: 1}, initial={x: 1})
    unknown = sp.Function("U")(x)
    system = vo.System(
        name="unknown", fibration=vo.Fibration(base=(x,)), lagrangian=Dx**2 / 2 - unknown
    )
    with pytest.raises(vo.DefinitionError, match="holds the unknown function"):
        vo.integrate(system, times=GRID, initial={x: 1})
    with pytest.raises(vo.DefinitionError, match=r"'f\(x\)': the function 'f\(x\)' is unknown"):
        vo.integrate(SLEIGH, outputs=(sp.Function("f")(x),))


@both
def test_undetermined_velocities_are_named(method: str) -> None:
    disc = vo.System(
        name="plane", fibration=vo.Fibration(base=(x, y)), lagrangian=Dx**2 + Dy**2,
        frame=vo.Frame.quasi({v: Dx + Dy, w: Dx - Dy}),
    )  # fmt: skip
    with pytest.raises(vo.DefinitionError, match="do not determine v, w"):
        vo.integrate(disc, times=GRID, initial={"xdot": 1}, method=method)
    traj = vo.integrate(disc, times=[0.0], initial={"xdot": 1, "ydot": 3}, method=method)
    assert (traj["v"][0], traj["w"][0]) == (pytest.approx(4), pytest.approx(-2))


def falling(potential: Any, inertia: Any = 1) -> vo.System:
    """One coordinate in a potential."""
    return vo.System(
        name="falling",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=inertia * Dx**2 / 2 - potential,
    )


@both
def test_a_collision_stops_with_time_and_state(method: str) -> None:
    # from rest at 1, falling into -1/x takes pi / (2 sqrt 2)
    with pytest.raises(vo.IntegrationError) as caught:
        vo.integrate(falling(-1 / x), times=GRID, initial={x: 1}, method=method)
    assert caught.value.time == pytest.approx(np.pi / np.sqrt(8), abs=1e-3)
    position, speed = caught.value.state
    assert 0 <= position < 0.02 and speed < -9
    assert speed**2 / 2 - 1 / position == pytest.approx(-1, abs=1e-6 / position)


@both
def test_a_singular_mass_matrix_is_named(method: str) -> None:
    # (1 - x) xdot^2 / 2 keeps its value, so x reaches 1 at t = 2/3 where the mass vanishes
    system = falling(0, inertia=1 - x)
    with pytest.raises(vo.IntegrationError, match="mass matrix is singular there") as e:
        vo.integrate(system, times=GRID, initial={x: 0, Dx: 1}, method=method)
    assert e.value.time == pytest.approx(2 / 3, abs=1e-3)
    with pytest.raises(vo.IntegrationError, match="singular at the initial point") as e:
        vo.integrate(system, times=GRID, initial={x: 1, Dx: 1}, method=method)
    assert e.value.time == 0


@both
def test_the_start_outside_the_domain_is_named(method: str) -> None:
    with pytest.raises(vo.IntegrationError, match="not defined at the initial point"):
        vo.integrate(falling(sp.sqrt(x)), times=GRID, initial={x: -1}, method=method)


def test_ctrl_c_keeps_what_is_done_with_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    from scipy.integrate import DOP853

    step = DOP853.step

    def interrupted(self: Any) -> Any:
        if self.t > 3:
            raise KeyboardInterrupt
        return step(self)

    monkeypatch.setattr(DOP853, "step", interrupted)
    traj = vo.integrate(SLEIGH, times=GRID, initial={v: 1, w: 2}, parameters={a: 0}, method="scipy")
    assert traj.interrupted and 3 <= traj.t[-1] < 4 and len(traj["x"]) == len(traj.t)
    assert traj.drift["energy"] < 1e-11


def test_ctrl_c_keeps_what_is_done_with_heyoka(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(taylor, "CHUNK", 2)
    whole = vo.integrate(SLEIGH, times=GRID, method=METHODS[-1])
    way = steps.StallDetector.distance
    monkeypatch.setattr(steps.StallDetector, "distance", interrupt_at_third_call(way))
    traj = vo.integrate(SLEIGH, times=GRID, method=METHODS[-1])
    if METHODS[-1] == "heyoka":
        assert traj.interrupted and 1 < len(traj.t) < len(GRID)
    assert np.abs(traj.state - whole.state[: len(traj.t)]).max() < 1e-11


def test_ctrl_c_ends_a_run_whose_angles_are_read_off(monkeypatch: pytest.MonkeyPatch) -> None:
    from scipy.integrate import DOP853

    step, ball = DOP853.step, vo.load("demchenko")
    times = np.linspace(0, 4000, 1001)  # too coarse to tell the branches of u apart
    seen: list[float] = []

    def interrupted(self: Any) -> Any:
        if self.t > 5 and not seen:
            seen.append(self.t)
            raise KeyboardInterrupt
        return step(self)

    monkeypatch.setattr(DOP853, "step", interrupted)
    traj = vo.integrate(ball, times=times, outputs=("u", "v"), method="scipy", tol=1e-6)
    assert seen and traj.interrupted and traj.t[-1] <= 8


def interrupt_at_third_call(function: Any) -> Any:
    """The function, but the third call is where Ctrl-C arrives."""
    calls = []

    def wrapped(*args: Any) -> Any:
        calls.append(args)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return function(*args)

    return wrapped


@both
def test_small_chunks_and_sparse_grids_change_nothing(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    sparse, dense = GRID[[0, 1, 70, 140]], GRID
    whole = vo.integrate(SLEIGH, times=dense, method=method)
    monkeypatch.setattr(taylor, "CHUNK", 3)
    for grid in (sparse, dense):
        traj = vo.integrate(SLEIGH, times=grid, method=method)
        assert np.array_equal(traj.t, grid)
        assert np.abs(traj.state - whole.state[np.isin(dense, grid)]).max() < 1e-11


def test_a_trajectory_is_frozen_and_names_what_it_lacks() -> None:
    traj = vo.integrate(SLEIGH, outputs=("x",))
    with pytest.raises(dataclasses.FrozenInstanceError):
        traj.t = GRID  # type: ignore[misc]
    for array in (traj.t, traj.state, traj["x"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(vo.DefinitionError, match=r"holds no 'phidott'.*ask for it in outputs"):
        traj["phidott"]


def test_saving_keeps_every_digit(tmp_path: Any) -> None:
    traj = vo.integrate(SLEIGH, times=GRID, scene="spin")
    with traj.save(tmp_path / "motion.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["t", "x", "x**2 + y**2"]
    assert np.array_equal(np.array(rows[1:], dtype=float)[:, 1], traj["x"])
    with np.load(traj.save(tmp_path / "motion.npz")) as data:
        assert np.array_equal(data["state"], traj.state)
        assert list(data["names"]) == list(traj.names) and data["parameter a"] == 0.5
    assert sorted(p.name for p in tmp_path.iterdir()) == ["motion.csv", "motion.npz"]
    for path, message in (("motion.txt", "must end in"), ("no/motion.csv", "no folder")):
        with pytest.raises(vo.DefinitionError, match=message):
            traj.save(tmp_path / path)


@pytest.mark.slow
def test_errors_of_steps_by_scipy_add_up_to_less_than_those_of_scipy_alone() -> None:
    """A pendulum over 1202 steps, against 22 digits and the same method without our care, at the
    tolerance that a step of ours may use up."""
    theta = sp.Symbol("theta")
    rate = vo.velocity(theta)
    pendulum = vo.System(
        name="pendulum", fibration=vo.Fibration((theta,), ()),
        lagrangian=rate**2 / 2 + sp.cos(theta),
    )  # fmt: skip
    run = {"times": [0, 300], "initial": {theta: 1, rate: 0.3}}
    truth = float(vo.integrate(pendulum, method="flint", tol=1e-22, **run)["theta"][-1])
    here = vo.integrate(pendulum, method="scipy", tol=1e-9, **run)
    plain = solve_ivp(
        lambda _, y: [y[1], -np.sin(y[0])], (0, 300), [1, 0.3], "DOP853", rtol=1e-10, atol=1e-10
    )
    assert abs(here["theta"][-1] - truth) < abs(plain.y[0, -1] - truth) < 1e-8
    assert here.cost.evaluations < plain.nfev


def spring() -> vo.System:
    """It takes steps of one length for ever: none of them is short."""
    return vo.System(name="even", fibration=vo.Fibration((x,), ()), lagrangian=(Dx**2 - x**2) / 2)


def comet() -> vo.System:
    """On its ellipse, whose eccentricity is 0.99, steps are of many lengths again and again."""
    energy = (Dx**2 + Dphi**2) / 2 + 1 / sp.sqrt(x**2 + phi**2)
    return vo.System(name="comet", fibration=vo.Fibration((x, phi), ()), lagrangian=energy)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "tol"), [("scipy", 1e-9), ("lsoda", 1e-9), ("heyoka", 1e-16), ("flint", 1e-20)]
)
def test_an_end_that_is_too_far_away_is_named(method: str, tol: float) -> None:
    far = r"the end is more than 1e10 steps away after .*; ask for a shorter span or a coarser tol"
    away = {x: 1.99, phi: 0, Dx: 0, Dphi: (0.01 / 1.99) ** 0.5}
    for system, start in ((spring(), {x: 0, Dx: 1}), (comet(), away)):
        with pytest.raises(vo.IntegrationError, match=far):
            vo.integrate(system, times=[0, 1e14], initial=start, method=method, tol=tol)


def siren(rate: sp.Expr, *parameters: sp.Symbol) -> vo.System:
    """x'' = sin(phi) while phi'' is given."""
    return vo.System(
        name="siren", fibration=vo.Fibration((phi, x), ()), lagrangian=(Dphi**2 + Dx**2) / 2,
        forces={phi: rate, x: sp.sin(phi)}, parameters=parameters,
    )  # fmt: skip


@pytest.mark.slow
@both
def test_a_run_that_never_ends_is_ended(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """x'' = sin(phi) while phi grows as e^t: steps grow shorter as fast, to t = 100 there are
    10^43 of them.  Up to t = 7 there are few, and they are taken."""
    monkeypatch.setattr(steps, "LONG", 2_000)
    run = {"initial": {phi: 0, Dphi: 1}, "method": method, "tol": 1e-9, "outputs": ("x",)}
    assert vo.integrate(siren(Dphi), times=[0, 7], **run).t[-1] == 7
    with pytest.raises(vo.IntegrationError, match="step size collapsed after") as caught:
        vo.integrate(siren(Dphi), times=[0, 100], **run)
    assert 7 < float(caught.value.time) < 20


@pytest.mark.slow
@both
def test_an_ensemble_that_never_ends_is_ended(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that is evenly accelerated is not, whatever it takes."""
    monkeypatch.setattr(steps, "LONG", 2_000)
    monkeypatch.setattr(batches, "LONG", 2_000)
    run = {"starts": [{phi: 0, Dphi: 1}], "method": method, "tol": 1e-9, "outputs": ("x",)}
    a, b = sp.symbols("a b")
    system = siren(a * Dphi + b, a, b)  # which is compiled once
    many = vo.ensemble(system, times=[0, 100], parameters={a: 1, b: 0}, **run)
    assert 7 < many.errors[0].time < 25
    assert "step size collapsed" in str(many.errors[0])
    even = vo.ensemble(system, times=[0, 150], parameters={a: 0, b: 1}, **run)
    assert not even.errors and even.cost.steps > 2_000


@pytest.mark.parametrize(("method", "tol"), [("heyoka", 1e-13), ("scipy", 1e-9), ("flint", 1e-18)])
def test_a_mass_that_grows_without_bound_is_not_singular(method: str, tol: float) -> None:
    y = sp.Symbol("y")
    speed = vo.velocity(x), vo.velocity(y)
    system = vo.System(
        name="escape",
        fibration=vo.Fibration(base=(x, y)),
        lagrangian=speed[0] ** 2 / 2 + (1 + x**2) * speed[1] ** 2 / 2 + x**4 / 4,
    )
    start = {"x": 1, "y": 0, "xdot": 1, "ydot": 0.1}
    with pytest.raises(vo.IntegrationError) as e:
        vo.integrate(system, initial=start, times=(0, 10), method=method, tol=tol)
    assert "singular" not in str(e.value) and not e.value.singular


@pytest.mark.slow
def test_short_steps_without_end_say_that_their_errors_add_up() -> None:
    x = sp.Symbol("x")
    spring = vo.System(
        name="spring",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=(vo.velocity(x) ** 2 - x**2) / 2,
    )
    short, far = (
        vo.integrate(spring, initial={"x": 1}, times=[0, end], method="lsoda")
        for end in (10.0, 1500.0)
    )
    assert not short.notes
    (note,) = far.notes
    assert note.startswith(f"lsoda took {far.cost.steps} steps, whose errors add up, to ")
    assert abs(far["x"][-1] - np.cos(1500)) > 1e-12

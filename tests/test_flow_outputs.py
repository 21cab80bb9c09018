"""What may be asked of a motion: reaction forces, traces of a contact, the configuration."""

from __future__ import annotations

import dataclasses
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

import voronec as vo

pytestmark = pytest.mark.slow

x, y, z, phi, v, w, m, a, J, g = sp.symbols("x y z phi v w m a J g")
Dx, Dy, Dz, Dphi = map(vo.velocity, (x, y, z, phi))
GRID = np.linspace(0.0, 3.0, 31)


EDGE = Dy * sp.cos(phi) - Dx * sp.sin(phi)


def sleigh(constraint: Any = EDGE, **more: Any) -> vo.System:
    """A knife edge below the centre of mass, or ``a`` behind it."""
    return vo.System(
        name="edge",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        frame=vo.Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
        lagrangian=m * ((Dx - a * sp.sin(phi) * Dphi) ** 2 + (Dy + a * sp.cos(phi) * Dphi) ** 2) / 2
        + J * Dphi**2 / 2,
        constraints=(constraint,),
        parameters=(vo.Parameter(m, 2, positive=True), vo.Parameter(J, 3), vo.Parameter(a, 0)),
        integrals={"energy": m * v**2 / 2 + (J + m * a**2) * w**2 / 2, "spin": J * w},
        **more,
    )


def referee(trajectory: vo.Trajectory, at: int) -> list[float]:
    """The multipliers by d'Alembert's principle at one instant of a trajectory."""
    state = zip(trajectory.names, trajectory.state[at].tolist(), strict=True)
    point = {**dict(state), **trajectory.parameters}
    try:
        found = vo.reaction_forces(trajectory.system, {**point, "t": float(trajectory.t[at])}, 20)
    except vo.DefinitionError:  # the time occurs nowhere
        found = vo.reaction_forces(trajectory.system, point, 20)
    assert found.multipliers is not None
    return [float(value) for value in found.multipliers]


@pytest.mark.parametrize(
    "name",
    [
        "demchenko",
        "rattleback",
        "suslov",  # a group
        "veselova-in-rn",  # a group whose coordinates are redundant
        "torus-on-ellipsoid",  # redundant coordinates
        "growing-sleigh",  # the Lagrangian holds the time
        "ball-on-turntable-in-time",  # the constraints hold it
    ],
)
def test_reactions_are_those_of_the_independent_route(name: str) -> None:
    system = vo.load(name)
    outputs = [f"reaction {k + 1}" for k in range(len(system.constraints))]
    traj = vo.integrate(system, "default", GRID, outputs, method="scipy", tol=1e-12)
    assert traj.outputs == tuple(outputs)
    for at in (0, 11, 30):
        expected = np.array(referee(traj, at))
        found = np.array([traj[name][at] for name in outputs])
        assert np.abs(found - expected).max() <= 1e-10 * (1e-3 + np.abs(expected).max())
    assert max(np.abs(traj[name]).max() for name in outputs) > 1e-3


def test_a_reaction_turns_the_edge_and_is_finite_where_the_fibre_is_not_fit() -> None:
    # the centre of mass runs in a circle: the edge pushes sideways with m v w.  Where the edge
    # points along y the constraint does not hold the fibre velocity
    grid = np.linspace(0.0, 2.0, 33)  # w = pi / 2: the edge is along y at t = 1
    traj = vo.integrate(
        sleigh(), times=grid, initial={v: 1.5, w: sp.pi / 2}, outputs=("reaction 1", phi)
    )
    assert traj[phi][16] == pytest.approx(np.pi / 2, abs=1e-12)
    assert np.abs(traj["reaction 1"] - 2 * 1.5 * np.pi / 2).max() < 1e-11


def test_twice_the_constraint_has_half_the_multiplier_and_forces_count() -> None:
    start = {v: 1, w: 2}
    pushed = {y: g * sp.cos(5 * vo.time)}
    more = {"forces": {k: e.xreplace({g: sp.Integer(7)}) for k, e in pushed.items()}}
    once, twice, free = (
        vo.integrate(s, times=GRID, initial=start, parameters={a: 0.3}, outputs=["reaction 1"])
        for s in (sleigh(**more), sleigh(2 * EDGE, **more), sleigh())
    )
    assert np.abs(once["reaction 1"] - 2 * twice["reaction 1"]).max() < 1e-12
    assert np.abs(once["reaction 1"] - free["reaction 1"]).max() > 1
    assert once["reaction 1"][7] == pytest.approx(referee(once, 7)[0], rel=1e-12)


def test_reactions_keep_the_precision_of_the_states() -> None:
    system = sleigh()
    run = vo.integrate(
        system, times=[0, 1], initial={"x": sp.Rational(1, 3), phi: sp.pi / 5, v: 1, w: 2},
        parameters={a: sp.Rational(1, 7)}, outputs=("reaction 1", x * phi), tol=1e-40,
    )  # fmt: skip
    state = zip(run.names, run.state[-1], strict=True)
    with mp.workdps(60):
        point = {k: sp.Float(number, 60) for k, number in (*state, *run.parameters.items())}
        (expected,) = vo.reaction_forces(system, point, 50).multipliers
        assert abs(run["reaction 1"][-1] - mp.mpf(expected._mpf_)) < mp.mpf(10) ** -38
        product = mp.mpf((point["x"] * point["phi"])._mpf_)
        assert abs(run[x * phi][-1] - product) < mp.mpf(10) ** -38


def test_a_reaction_that_is_not_unique_is_refused() -> None:
    system = vo.load("bychkov-ball")  # its constraints keep the length of the normal
    with pytest.raises(vo.DefinitionError, match=r"'reaction \d' is not unique, because constr"):
        vo.integrate(system, times=GRID, outputs=("reaction 2",))


def test_traces_and_the_configuration_stand_for_coordinates() -> None:
    traj = vo.integrate(
        vo.load("demchenko"), "default", GRID, ("on the sphere", "reaction 2", "configuration"),
        method="scipy",
    )  # fmt: skip
    assert traj.outputs == ("u1", "v1", "reaction 2", "u", "v", "theta")
    assert np.array_equal(traj["v1"], traj.state[:, traj.names.index("v1")])
    with pytest.raises(vo.DefinitionError, match="did you mean 'on the ball'"):
        vo.integrate(vo.load("demchenko"), "default", GRID, ("on the bal",))


def test_a_scene_may_ask_for_them() -> None:
    scene = vo.Scene({v: 1, w: 1}, outputs=("configuration", "reaction 1"))
    traj = vo.integrate(dataclasses.replace(sleigh(), scenes={"default": scene}), times=GRID)
    assert traj.outputs == ("x", "phi", "y", "reaction 1")


def test_a_quantity_of_the_system_comes_before_a_group_of_its_name() -> None:
    system = dataclasses.replace(
        sleigh(), invariants={"configuration": sp.sin(phi)}, drawing={"energy": ("x", "y")}
    )
    run = vo.integrate(
        system, times=GRID, initial={v: 1, w: 2}, outputs=("configuration", "energy", v, phi, "phi")
    )
    assert run.outputs == ("configuration", "energy", "v", "phi")  # in order, each once
    assert np.abs(run["configuration"] - np.sin(run["phi"])).max() < 1e-14
    assert set(run.drift) == {"energy", "spin"}


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("reaction 2", "no output 'reaction 2'; did you mean 'reaction 1'"),
        ("configurations", "did you mean 'configuration'"),
        ("enrgy", "did you mean 'energy'"),
        (sp.Symbol("psi") + x, "contains 'psi'; did you mean 'phi'"),
        (None, "an output is 'None'"),
        ("x + psi", "contains 'psi'; did you mean 'phi'"),
        ("x +", "an output: 'x \\+' is not a formula"),
        ("__import__('os')", "no formula has this sign"),
    ],
)
def test_unknown_outputs_are_answered_with_the_nearest(output: Any, message: str) -> None:
    with pytest.raises(vo.DefinitionError, match=message) as caught:
        vo.integrate(sleigh(), times=GRID, initial={v: 1}, outputs=(output,))
    assert "\n" not in str(caught.value) and str(caught.value).count("system '") == 1


def test_formulas_may_be_text() -> None:
    """As on the command line: outputs, events and the planes of sections."""
    end = vo.Event("2*x - 1", stop=True)
    run = vo.integrate(sleigh(), times=GRID, initial={v: 1}, outputs=("v*x", " x "), events=end)
    assert run.outputs == ("v*x", "x") and run.stopped == "2*x - 1"
    assert run["x"][-1] == pytest.approx(0.5) and (run["v*x"] == run["x"] * run["v"]).all()
    with pytest.raises(vo.DefinitionError, match="the plane 'psi \\+ x' contains 'psi'"):
        vo.section(sleigh(), "x + psi", starts=[{"v": 1.0}], crossings=1)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_an_angle_that_is_read_off_loses_no_turn_between_two_points(method: str) -> None:
    """Two turns within a tenth of the grid's spacing, which ends and mean steps do not show."""
    if method == "heyoka":
        pytest.importorskip("heyoka")
    q, r = sp.symbols("q r")
    width = sp.Rational(1, 10000)
    rate = 4 * width / (width**2 + r**2)  # of q, as r passes 0 at unit speed
    pulse = vo.System(
        name="pulse", fibration=vo.Fibration(base=(q, r), fibre=()),
        lagrangian=(vo.velocity(q) ** 2 + vo.velocity(r) ** 2) / 2, constraints=(),
        forces={q: sp.diff(rate, r) * vo.velocity(r)},
        invariants={"g1": sp.cos(q), "g2": sp.sin(q), "g3": r},
    )  # fmt: skip
    start = {"r": -1.001, "rdot": 1, "qdot": float(rate.subs(r, -1.001))}
    run = vo.integrate(
        pulse, initial=start, times=np.linspace(0, 2, 1001), outputs=("q",), method=method
    )
    ends = [np.arctan(x / float(width)) for x in (0.999, -1.001)]
    assert run["q"][-1] == pytest.approx(4 * (ends[0] - ends[1]), abs=1e-7)


@pytest.mark.parametrize("tilt", ["1/2", "-1/2"])
def test_an_angle_whose_sine_is_known_by_a_root_starts_where_it_was_told(tilt: str) -> None:
    """Of Euler's angles zyz the vertical is (-sin theta cos psi, sin theta sin psi, cos theta)."""
    pytest.importorskip("heyoka")
    run = vo.prepare(vo.load("skate-on-sphere"), outputs=("theta", "phi", "psi"), method="heyoka")
    found = run.run(initial={"theta": tilt, "v": "1/5", "w": 3}, times=np.linspace(0, 2, 1001))
    assert abs(found["theta"][0] - float(sp.Rational(tilt))) < 1e-15
    assert np.ptp(found["theta"]) < 0.2


@pytest.mark.parametrize("tilt", [1e-9, 1e-7, 1e-5])
def test_reactions_next_to_a_pole(tilt: float) -> None:
    """There inertia and forces along the angles cancel."""
    ball = vo.load("chaplygin-ball")
    start = {"theta": tilt, "omega1": 0.5, "omega2": 1, "omega3": 1}
    given = {"initial": start, "times": [0, 0.01], "outputs": ("reaction 1", "reaction 2")}
    run, truth = vo.integrate(ball, **given), vo.integrate(ball, tol=1e-20, **given)
    for name in given["outputs"]:
        assert np.abs(run[name] - np.array(truth[name], dtype=float)).max() < 1e-10


def test_an_output_is_fetched_by_the_text_it_was_asked_for_by() -> None:
    motion = vo.integrate(vo.load("sleigh"), times=[0, 1], outputs=("x+5",))
    assert np.array_equal(motion["x+5"], motion["x + 5"])
    with pytest.raises(vo.DefinitionError, match=r"no 'x\+6'"):
        motion["x+6"]


@pytest.mark.parametrize("output", ["log(-1-x**2)", "sqrt(-2 - x**2)/2"])
def test_an_output_without_real_values_is_told_at_rest_too(output: str) -> None:
    x = sp.Symbol("x")
    rest = vo.System("rest", vo.Fibration((x,)), vo.velocity(x) ** 2 / 2 - x**2 / 2)
    motion = vo.integrate(rest, initial={x: 0}, times=[0, 1], outputs=(output,))
    assert np.isnan(motion[output]).all()
    assert any("has no finite value at 2 of 2 instants" in note for note in motion.notes)


def test_an_output_that_is_complex_for_a_while_has_no_number_then_in_many_digits() -> None:
    x = sp.Symbol("x")
    free = vo.System("free", vo.Fibration((x,)), vo.velocity(x) ** 2 / 2)
    start = {"initial": {x: -1, vo.velocity(x): 1}, "times": [0, 1, 2]}
    motion = vo.integrate(free, outputs=("asin(2*x)",), tol=1e-30, **start)
    assert [bool(mp.isnan(value)) for value in motion["asin(2*x)"]] == [True, False, True]

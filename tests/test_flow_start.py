"""Initial data: on the constraints, refused with the residual, or moved onto them on request."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

import voronec as vo

x, y, z, phi, v, w = sp.symbols("x y z phi v w")
a, b, k, m = sp.symbols("a b k m")
Dx, Dy, Dz, Dphi = map(vo.velocity, (x, y, z, phi))
START = [0.0]


def edge() -> vo.System:
    """A knife edge, its frame the speed and the turn."""
    return vo.System(
        name="edge",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        frame=vo.Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
        lagrangian=m * (Dx**2 + Dy**2) / 2 + Dphi**2 / 2,
        constraints=(Dy * sp.cos(phi) - Dx * sp.sin(phi),),
        parameters=(vo.Parameter(m, 1, positive=True), vo.Parameter(k, 1, lower=0, upper=2)),
    )


def on_surface(relation: Any, **scenes: vo.Scene) -> vo.System:
    """A particle on a surface in space, pushed down."""
    n, turn = (x, y, z), (v, w)
    return vo.System(
        name="surface",
        fibration=vo.Fibration(base=n, relations=(relation,)),
        frame=vo.Frame.quasi({turn[0]: y * Dz - z * Dy, turn[1]: z * Dx - x * Dz}),
        lagrangian=(Dx**2 + Dy**2 + Dz**2) / 2 - z,
        parameters=(vo.Parameter(a, 2), vo.Parameter(b, 1)),
        scenes=scenes,
    )


ELLIPSOID = x**2 / a**2 + y**2 + z**2 / 9 - b
SPHERE = x**2 + y**2 + z**2 - b


def test_coordinates_off_the_relations_are_refused_with_the_residual() -> None:
    with pytest.raises(vo.DefinitionError, match=r"relation .* = 0 \(residual 0.562\).*project="):
        vo.integrate(on_surface(SPHERE), times=START, initial={x: 0.75, z: 1})


def test_coordinates_are_moved_to_the_nearest_point_on_request() -> None:
    traj = vo.integrate(
        on_surface(SPHERE), times=START, initial={x: 0.75, z: 1, v: 0.5}, project=True
    )
    assert traj.state[0] == pytest.approx([0.6, 0, 0.8, 0.5, 0], abs=1e-14)
    assert len(traj.notes) == 1
    assert "moved by 0.25 onto the relations (x from 0.75 to 0.6, z from 1 to 0.8)" in traj.notes[0]


@pytest.mark.slow
@pytest.mark.parametrize("far", [(2.5, 0.5, 1.0), (0.3, 0.1, 0.8), (4.0, 3.0, -9.0), (9.0, 7.0, 2)])
def test_the_nearest_point_is_nearer_than_all_others(far: tuple[float, ...]) -> None:
    start = dict(zip((x, y, z), far, strict=True))
    traj = vo.integrate(on_surface(ELLIPSOID), times=START, initial=start, project=True)
    found = traj.state[0, :3]
    assert abs(found[0] ** 2 / 4 + found[1] ** 2 + found[2] ** 2 / 9 - 1) < 1e-12
    rng = np.random.default_rng(1)
    others = rng.normal(size=(200_000, 3))
    others *= np.array([2.0, 1.0, 3.0]) / np.linalg.norm(others, axis=1, keepdims=True)
    distance = np.linalg.norm(found - far)
    assert distance <= np.linalg.norm(others - far, axis=1).min() + 1e-9
    # the way there is normal to the surface
    slope = np.array([found[0] / 4, found[1], found[2] / 9])
    assert np.linalg.norm(np.cross(slope, found - far)) < 1e-7 * distance


def test_where_no_point_is_near_projection_refuses_too() -> None:
    with pytest.raises(vo.DefinitionError, match="no point nearby was found"):
        vo.integrate(
            on_surface(SPHERE), times=START, initial={x: 1, z: 0.3}, parameters={b: -1},
            project=True,
        )  # fmt: skip


@pytest.mark.slow
def test_relations_may_hold_the_time() -> None:
    growing = x**2 + y**2 + z**2 - (1 + vo.time) ** 2
    late, start = [1.0], {x: 1.2, z: 1.6}
    assert vo.integrate(on_surface(growing), times=late, initial=start).notes == ()
    with pytest.raises(vo.DefinitionError, match="residual 3"):
        vo.integrate(on_surface(growing), times=START, initial=start)
    moved = vo.integrate(on_surface(growing), times=START, initial=start, project=True)
    assert moved.state[0, :3] == pytest.approx([0.6, 0, 0.8], abs=1e-14)


def test_velocities_off_the_constraints_are_refused_with_the_residual() -> None:
    with pytest.raises(
        vo.DefinitionError, match=r"'ydot' = 2, where the others give 1 \(residual 1\).*project="
    ):
        vo.integrate(edge(), times=START, initial={phi: sp.pi / 4, "xdot": 1, "ydot": 2, w: 0})


def test_velocities_are_moved_by_least_squares_on_request() -> None:
    start = {phi: sp.pi / 4, "xdot": 1, "ydot": 2, w: 3}
    traj = vo.integrate(edge(), times=START, initial=start, project=True)
    # along the edge: the mean of 1 and 2, each of them v / sqrt(2)
    assert traj["v"][0] == pytest.approx(1.5 * np.sqrt(2), rel=1e-14) and traj["w"][0] == 3
    assert "moved by 0.707 onto the constraints (xdot from 1 to 1.5" in traj.notes[0]
    assert "ydot from 2 to 1.5" in traj.notes[0] and "w from" not in traj.notes[0]
    over = vo.integrate(edge(), times=START, initial=start | {v: 0}, project=True)
    rows, right = np.array([[np.sqrt(0.5)], [np.sqrt(0.5)], [1.0]]), np.array([1.0, 2.0, 0.0])
    assert over["v"][0] == pytest.approx(np.linalg.lstsq(rows, right, rcond=None)[0][0], rel=1e-14)


def test_data_that_fit_are_not_moved() -> None:
    for system, start in (
        (edge(), {phi: 0.3, v: 2, w: 1}),
        (on_surface(SPHERE), {x: 0.6, z: 0.8, v: 0.1}),
        (on_surface(SPHERE), {x: 0.6, z: 0.8 + 1e-11, v: 0.1}),
    ):
        plain = vo.integrate(system, times=START, initial=start)
        asked = vo.integrate(system, times=START, initial=start, project=True)
        assert np.array_equal(plain.state, asked.state) and asked.notes == ()


def circling(value: Any, given: dict[Any, Any]) -> vo.System:
    """Two fibre coordinates bound by a relation; the scene starts at ``value``."""
    return vo.System(
        name="circling",
        fibration=vo.Fibration(base=(z,), fibre=(x, y), relations=(x**2 + y**2 - a**2,)),
        lagrangian=m * (Dx**2 + Dy**2 + Dz**2) / 2,
        constraints=(Dz * a - x * Dy + y * Dx,),
        parameters=(m, vo.Parameter(a, 2), vo.Parameter(b)),
        scenes={"default": vo.Scene({x: value, Dz: 1}, parameters={m: 1} | given)},
    )


@pytest.mark.parametrize(
    ("value", "given"), [(a, {}), (b, {b: 2}), (3 * b / 2 - a / 2, {"b": 2}), (b - a, {b: 2, a: 1})]
)
def test_a_scene_may_start_at_parameters_where_relations_bind_the_fibre(
    value: Any, given: dict[Any, Any]
) -> None:
    # y = 0 there: y' must be solved from the constraint, since the relation does not hold it
    equations = vo.derive(circling(value, given))
    traj = vo.integrate(equations, times=np.linspace(0, 1, 5))
    radius = traj.parameters["a"]
    # the point at which the solved constraints are made to hold
    assert float(equations.definition.near["x"]) == radius
    assert np.abs(traj["x"] - radius * np.cos(traj.t / radius)).max() < 1e-11
    assert np.abs(traj["y"] - radius * np.sin(traj.t / radius)).max() < 1e-11


def test_a_parameter_without_a_value_is_named_where_the_start_needs_it() -> None:
    system = circling(b, {})
    with pytest.raises(vo.DefinitionError, match=r"'x' = b is not a real .*, since 'b' has no val"):
        vo.integrate(system, times=START)
    assert vo.integrate(system, times=START, parameters={b: 2})["x"][0] == 2


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ({"parameters": {k: 3}}, "'k' = 3 is above 2"),
        ({"parameters": {k: -0.1}}, "'k' = -0.1 is below 0"),
        ({"parameters": {m: 0}}, "'m' = 0 must be positive"),
        ({"parameters": {m: float("nan")}}, "'m' = nan is not a real number"),
        ({"parameters": {m: 2**2000}}, "'m' = .* is not a real number"),
        ({"parameters": [1]}, "parameters = .* is not a mapping"),
        ({"parameters": {"mm": 1}}, "no parameter 'mm'; did you mean 'm'"),
        ({"initial": [1]}, "initial = .* is not a mapping"),
        ({"initial": {v: sp.oo}}, "'v' = oo is not finite"),
        ({"initial": {v: "fast"}}, "'v' = fast is not a real number"),
        ({"initial": {"fi": 1}}, "no initial value 'fi'; did you mean 'phi'|there are"),
        ({"initial": {"xdot": 1, "ydot": 1}}, "off the constraints"),
    ],
)
def test_bad_input_is_told_in_one_line_that_names_the_system_once(
    mistake: dict[str, Any], message: str
) -> None:
    with pytest.raises(vo.DefinitionError, match=message) as caught:
        vo.integrate(edge(), **{"times": START, "initial": {v: 1}, **mistake})
    text = str(caught.value)
    assert "\n" not in text and text.count("system 'edge'") <= 1 and len(text) < 250


@pytest.mark.slow
def test_parameters_without_which_the_equations_mean_nothing_are_named() -> None:
    with pytest.raises(vo.DefinitionError, match="not defined for R1 = -1, R2 = 1") as caught:
        vo.integrate(vo.load("ball-on-sphere"), times=[0, 1], parameters={"R1": -1})
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_velocities_of_coordinates_at_a_pole_whose_sine_is_rounding() -> None:
    # sin(pi) is 1e-16 in doubles, so that rates of angles are finite there, and mean nothing
    ball = vo.derive(vo.load("demchenko"))
    given = {"theta": 0.98, "u1": 0.62, "udot": 0.69, "vdot": 0.43, "thetadot": 0.32}
    ends = []
    for u in (np.pi, np.pi - 1e-6):
        run = vo.integrate(ball, times=[0, 1], outputs=("u1", "v1"), initial={"u": u, **given})
        ends.append([run["u1"][-1], run["v1"][-1]])
    assert np.abs(np.subtract(*ends)).max() < 1e-4


@pytest.mark.slow
def test_velocities_of_coordinates_are_met_where_a_pivot_of_the_elimination_is_rounding() -> None:
    """At u = pi/2 the constraints of a ball were solved by cos(u) = 6e-17: quotients by it are
    finite, and mean nothing; the declared velocities follow from those of the coordinates."""
    ball = vo.load("ball-on-sphere")
    place = {"u": np.pi / 2, "theta": 0.7, "v": 0.4, "u1": 1.0}
    spins = {"omega1": 0.3, "omega2": -0.5, "omega3": 0.2}
    names = [f"{x}dot" for x in ball.coordinates]
    first = vo.integrate(ball, initial=place | spins, times=[0, 1e-9], outputs=names)
    dots = {name: first[name][0] for name in names}
    run, same = (vo.integrate(ball, initial=place | pace, times=[0, 1]) for pace in (dots, spins))
    for name in ("omega1", "omega2", "omega3", "theta"):
        assert abs(run[name][0] - same[name][0]) < 1e-14
        assert abs(run[name][1] - same[name][1]) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("pole", [0.0, np.pi])
def test_a_pole_of_angles_in_a_divisor_that_is_none_of_theirs(pole: float) -> None:
    """A ball on a paraboloid divides by sin(beta) (c r cos(beta) sin(phi - alpha) - sin(beta)); it
    is homogeneous, so that its path does not depend on how it is turned at first."""
    system, r, R = vo.load("ball-on-paraboloid"), 0.798, 0.2
    place = {"r": r, "phi": -0.364, "psi": 0.059, "alpha": 0.8}
    paths = ("r", "phi", "v", "w", "s")
    # at the pole the spin in space is (beta' cos(alpha), beta' sin(alpha), alpha' +- psi')
    tilt, slope, swing, turn = 0.3, np.sqrt(1 + r**2), -0.33, 0.8 + 0.364
    ahead = R * tilt * np.sin(turn) / slope
    upright = (-slope * r * swing / R - tilt * np.cos(turn)) / r
    spins = {"v": ahead, "w": swing, "s": (upright - r * tilt * np.cos(turn)) / slope}
    dots = {"rdot": ahead, "phidot": swing, "betadot": tilt, "psidot": 0.2}
    dots["alphadot"] = upright - 0.2 * np.cos(pole)
    truth = vo.integrate(system, initial={**place, **spins, "beta": 1}, times=[0, 1], outputs=paths)
    for pace in (spins, dots):
        initial = {**place, **pace, "beta": pole}
        run = vo.integrate(system, initial=initial, times=[0, 1])
        assert max(np.abs(run[name] - truth[name]).max() for name in paths) < 1e-10


def test_a_start_at_the_origin_with_speeds_that_stay_is_no_division_by_zero() -> None:
    x = sp.Symbol("x")
    system = vo.System(
        name="free", fibration=vo.Fibration(base=(x,)), lagrangian=vo.velocity(x) ** 2 / 2
    )
    for at in (0.0, 1e-25):
        run = vo.integrate(
            system, times=[0.0, 2.0], initial={x: at, vo.velocity(x): 1}, outputs=("x",)
        )
        assert run["x"][-1] == pytest.approx(2.0, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("method", [pytest.param("scipy", marks=pytest.mark.slow), "closed-form"])
def test_a_start_that_is_kept_is_nobody_elses(method: str) -> None:
    """Between two calls from one start come others, with other values, kinds of numbers, instants
    and outputs; each is the motion of a system that has computed nothing before."""
    ball = vo.load("demchenko")
    own = {"u": 1.1, "u1": 1.0, "s": 0.3, "n": 0.2}
    calls: list[dict[str, Any]] = [
        {"initial": own},
        {"initial": {**own, "tau": 0.0}},
        {"initial": {**own, "tau": -0.0}},
        {"initial": {**own, "tau": sp.Float("0.1", 40)}},
        {"initial": {**own, "tau": sp.Float("0.1")}},
        {"initial": {**own, "tau": sp.Rational(1, 10)}},
        {"initial": own, "parameters": {"k": 0.5}},
        {"initial": own, "times": [1.0, 2.0, 3.0]},
        {"initial": own, "outputs": ("v",)},
    ]

    def motion(system: vo.System, call: dict[str, Any]) -> np.ndarray:
        given: dict[str, Any] = {"times": [0.0, 1.0, 2.0], "outputs": ("u", "v"), **call}
        run = vo.integrate(system, method=method, **given)
        return np.stack([run[name] for name in given["outputs"]])

    fresh = [motion(replace(ball), call) for call in calls]
    for i in (0, 1, 2, 0, 3, 4, 5, 0, 6, 0, 7, 0, 8, 0):
        kept = motion(ball, calls[i])
        assert np.array_equal(kept, fresh[i])
        assert np.array_equal(np.signbit(kept), np.signbit(fresh[i]))

"""Friction on wheels: one sets in while another holds, and levers vanish while the body stands."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

import voronec as vo
from voronec import velocity

pytestmark = pytest.mark.slow

R = sp.Rational
x, y, phi, v, w = sp.symbols("x y phi v w")
METHODS = {"heyoka": 1e-13, "scipy": 1e-13, "c": 1e-13, "flint": 1e-20}
CARRIAGE = vo.load("two-wheeled-carriage")
LEFT, RIGHT, *_, HEADING = CARRIAGE.coordinates
SPEED, TURN = CARRIAGE.velocities


def carriage(forces: dict[sp.Expr, sp.Expr]) -> vo.System:
    return vo.System(
        name="rough carriage", fibration=CARRIAGE.fibration, frame=CARRIAGE.frame,
        lagrangian=CARRIAGE.lagrangian, constraints=CARRIAGE.constraints,
        parameters=CARRIAGE.parameters, forces=forces,
    )  # fmt: skip


def friction(size: sp.Expr, coordinate: sp.Expr) -> sp.Expr:
    return -size * sp.sign(velocity(coordinate))


def steep_motion(forces: dict[sp.Expr, sp.Expr], given: dict[str, Any]) -> vo.Trajectory:
    """Truth to a thousandth: the same with steep smooth friction, where nothing switches."""
    steep = {q: f.replace(sp.sign, lambda u: sp.tanh(20_000 * u)) for q, f in forces.items()}
    return vo.integrate(carriage(steep), method="lsoda", tol=1e-10, **given)


PUSH = sp.cos(vo.time) / 3
FRICTIONS = {
    "both wheels": {RIGHT: friction(R(1, 2), RIGHT), LEFT: friction(R(1, 5), LEFT)},
    "both alike": {RIGHT: friction(R(1, 2), RIGHT), LEFT: friction(R(1, 2), LEFT)},
    "wheel and heading": {RIGHT: friction(R(1, 2), RIGHT), HEADING: friction(R(1, 5), HEADING)},
    "let go": {RIGHT: friction(R(1, 5), RIGHT), HEADING: PUSH + friction(R(1, 5), HEADING)},
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", FRICTIONS)
def test_one_friction_sets_in_while_another_holds(case: str, method: str) -> None:
    forces = FRICTIONS[case]
    start = {HEADING: R(2, 5), SPEED: R(3, 10), TURN: R(1, 10)}
    given = {"initial": start, "times": [0, 4.0], "outputs": ("phi", "leftdot", "rightdot")}
    smooth = steep_motion(forces, given)
    run = vo.integrate(carriage(forces), method=method, tol=METHODS[method], **given)
    for name in given["outputs"]:
        assert abs(float(run[name][-1]) - smooth[name][-1]) < 1e-3, name


def test_one_friction_sets_in_in_ensembles() -> None:
    forces, speeds = FRICTIONS["both wheels"], np.array([0.3, -0.7, 1.1, 0.9])
    run = vo.ensemble(
        carriage(forces), {HEADING: 0.4, SPEED: speeds, TURN: 0.1}, {}, [0, 1.0, 4.0],
        ("leftdot", "rightdot"), method="heyoka",
    )  # fmt: skip
    assert not run.errors
    assert np.abs(run["leftdot"][:, -1]).max() < 1e-12
    assert np.abs(run["rightdot"][:, -1]).max() < 1e-12


@pytest.mark.parametrize("method", ["scipy", "flint"])
def test_two_wheels_that_are_held_hold_a_third(method: str) -> None:
    """Three frictions on two velocities: the last switching surface says nothing of its own, and
    was switched at again and again."""
    forces = {
        LEFT: friction(R(1, 4), LEFT),
        RIGHT: friction(R(1, 20), RIGHT),
        CARRIAGE.coordinates[3]: friction(R(11, 20), CARRIAGE.coordinates[3]),
    }
    given = {"initial": {SPEED: 1, TURN: R(2, 5)}, "times": [0, 3.0], "outputs": ("phi", "x")}
    smooth = steep_motion(forces, given)
    run = vo.integrate(carriage(forces), method=method, tol=METHODS[method], **given)
    for name in given["outputs"]:
        assert abs(float(run[name][-1]) - smooth[name][-1]) < 1e-4
    assert run.cost.switches < 10


LEVERS = {
    "at rest": friction(R(3, 10), x),
    "quotient": -R(3, 10) * velocity(x) / sp.Abs(velocity(x)),
    "held against a push": R(1, 10) + friction(R(3, 10), x),
    "held against a push in time": sp.sin(3 * vo.time) / 5 + friction(R(3, 10), x),
}


@cache
def turning_blade(force: sp.Expr) -> vo.System:
    """A blade that turns evenly, and is held by friction along x: its lever is cos(phi)."""
    along = velocity(x) * sp.cos(phi) + velocity(y) * sp.sin(phi)
    return vo.System(
        name="turning blade",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=(velocity(x) ** 2 + velocity(y) ** 2 + velocity(phi) ** 2) / 2,
        constraints=(velocity(x) * sp.sin(phi) - velocity(y) * sp.cos(phi),),
        frame=vo.Frame.quasi({v: along, w: velocity(phi)}),
        forces={x: force},
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("force", LEVERS.values(), ids=LEVERS.keys())
def test_a_lever_of_friction_vanishes_while_it_holds(force: sp.Expr, method: str) -> None:
    run = vo.integrate(
        turning_blade(force), initial={phi: R(3, 10), v: 0, w: 1}, times=[0, 2.0, 9.0],
        method=method, tol=METHODS[method],
    )  # fmt: skip
    ends = {name: float(run[name][-1]) for name in ("x", "y", "v", "phi")}
    assert ends == pytest.approx({"x": 0, "y": 0, "v": 0, "phi": 9.3}, abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_a_blade_comes_to_rest_and_turns_on(method: str) -> None:
    """v' = -0.3 |cos phi| with phi = 0.3 + t, up to v = 0 beyond the first zero of the lever."""

    def speed(angle: float) -> float:
        fallen = np.sin(angle) if angle < np.pi / 2 else 2 - np.sin(angle)
        return float(0.5 - 0.3 * (fallen - np.sin(0.3)))

    end = np.pi - np.arcsin(2 - 0.5 / 0.3 - np.sin(0.3))
    assert abs(speed(end)) < 1e-15
    parts = ((0.3, np.pi / 2), (np.pi / 2, end))
    place = [
        sum(quad(lambda a, f=f: speed(a) * f(a), *part, epsabs=1e-14)[0] for part in parts)
        for f in (np.cos, np.sin)
    ]
    run = vo.integrate(
        turning_blade(LEVERS["at rest"]), initial={phi: R(3, 10), v: R(1, 2), w: 1},
        times=[0, 9.0], method=method, tol=METHODS[method],
    )  # fmt: skip
    assert [float(run[q][-1]) for q in "xy"] == pytest.approx(place, abs=1e-12)
    assert abs(float(run["v"][-1])) < 1e-30

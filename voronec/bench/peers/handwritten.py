"""The best program by hand: Chaplygin's balls in the momentum G and the normal gamma, for heyoka.

    Gdot = G x omega,   gammadot = epsilon gamma x omega,
    omega = J (G + D (omega, gamma) gamma),
    (omega, gamma) = (J G, gamma) / (1 - D (J gamma, gamma)),

with J = (I + D)^-1 and D = m R^2 [Chaplygin1903], [DragovicGajicJovanovic2020].  Constants are
numbers in the program, and everything is written so as to multiply least.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.bench.contender import Contender, NotHere, Outcome, Run, missing, timed, without
from voronec.bench.level import Level, level
from voronec.bench.question import Question
from voronec.errors import VoronecError

__all__ = ["BALLS", "HANDWRITTEN", "Ball", "taylor_program"]

OFFERED = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16)


@dataclass(frozen=True)
class Ball:
    """The constants of a rolling ball: principal moments (3,), D = m R^2, epsilon."""

    moments: tuple[float, float, float]
    D: float
    epsilon: float


def _on_plane(p: Mapping[str, float]) -> Ball:
    return Ball((p["I1"], p["I2"], p["I3"]), p["m"] * p["R"] ** 2, 1.0)


def _homogeneous(p: Mapping[str, float]) -> Ball:
    return Ball((p["A"], p["A"], p["A"]), p["m"] * p["R"] ** 2, 1.0)


def _on_sphere(p: Mapping[str, float]) -> Ball:
    ratio = p["R1"] / (p["R1"] + p["R2"])
    return Ball((p["I1"], p["I2"], p["I3"]), p["m"] * p["R2"] ** 2, ratio)


BALLS: dict[str, Callable[[Mapping[str, float]], Ball]] = {
    "chaplygin-ball": _on_plane,
    "homogeneous-ball": _homogeneous,
    "ball-on-sphere": _on_sphere,
}
"""Systems that somebody has written by hand, with how their parameters are read."""


def taylor_program(ball: Ball) -> tuple[list[tuple[Any, Any]], list[Any], list[Any]]:
    """The six equations for ``heyoka.taylor_adaptive``, its variables, and omega in them."""
    import heyoka as hy

    G, gamma = hy.make_vars("G1", "G2", "G3"), hy.make_vars("g1", "g2", "g3")
    J = [1.0 / (moment + ball.D) for moment in ball.moments]
    # squares cost the Taylor method half of a product, and constants nothing
    above = hy.sum([j * (g * p) for j, g, p in zip(J, gamma, G, strict=True)])
    below = 1.0 / ball.D - hy.sum([j * g**2.0 for j, g in zip(J, gamma, strict=True)])
    share = above / below
    omega = [j * (p + share * g) for j, p, g in zip(J, G, gamma, strict=True)]
    turning = [ball.epsilon * e if ball.epsilon != 1.0 else e for e in _cross(gamma, omega)]
    variables = [*G, *gamma]
    return list(zip(variables, [*_cross(G, omega), *turning], strict=True)), variables, omega


def _cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    return [a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)]


def _start(ball: Ball, question: Question) -> list[float]:
    """G and gamma from the velocities given and the normal at the start."""
    at = _level(question)
    named = dict(zip(map(str, at.field.variables), at.state, strict=True))
    gamma = np.array([named[f"gamma{i}"] for i in (1, 2, 3)])
    omega = np.array([named[f"omega{i}"] for i in (1, 2, 3)])
    momentum = np.array(ball.moments) * omega + ball.D * (omega - omega.dot(gamma) * gamma)
    return [*momentum, *gamma]


def _level(question: Question) -> Level:
    try:
        return level(question, "invariants")
    except VoronecError as refusal:
        raise NotHere(str(refusal)) from None


def _prepare(question: Question) -> Run:
    if question.system.name not in BALLS:
        raise NotHere("nobody has written this system by hand")
    missing(question.outputs, OFFERED)
    try:
        import heyoka as hy
    except ImportError:
        raise without("heyoka") from None
    ball = BALLS[question.system.name](question.parameters)
    start, at = _start(ball, question), _level(question)
    equations, variables, omega = taylor_program(ball)
    spin = hy.cfunc(omega, variables)
    grid = question.grid

    def run(tol: float) -> Outcome:
        integrator = hy.taylor_adaptive(equations, start, tol=tol)

        def once() -> tuple[int, np.ndarray]:
            integrator.time = float(grid[0])
            integrator.state[:] = start
            _, _, _, steps, _, rows = integrator.propagate_grid(grid)
            return steps, rows

        (steps, rows), seconds = timed(once)
        if len(rows) < len(grid):
            raise NotHere("the integration stopped short")
        turned = spin(np.ascontiguousarray(rows.T))
        known = dict(zip(OFFERED, [*rows.T[3:], *turned], strict=True))
        states = np.column_stack([known[str(s)] for s in at.field.variables])
        values, drift = at.observed(grid, states)
        return Outcome(values, seconds, steps, steps, drift)

    return run


HANDWRITTEN = Contender(
    "heyoka-by-hand", "a heyoka program written by hand, in momentum and normal", TOLERANCES,
    _prepare,
)  # fmt: skip

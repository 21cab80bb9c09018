"""Angles near the poles of their coordinates, against the attitude integrated without any."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import voronec as vo
from voronec.model.denominators import with_positive_denominators

SPIN = (0.5, 1.0, 1.0)


def euler(phi: float, theta: float, psi: float) -> np.ndarray:
    """The rotation Rz(phi) Rx(theta) Rz(psi), body to space."""

    def about(i: int, angle: float) -> np.ndarray:
        j, k = (i + 1) % 3, (i + 2) % 3
        turn = np.eye(3)
        turn[j, j] = turn[k, k] = np.cos(angle)
        turn[k, j] = np.sin(angle)
        turn[j, k] = -turn[k, j]
        return turn

    return about(2, phi) @ about(0, theta) @ about(2, psi)


def turning(rates: Callable[[np.ndarray, np.ndarray], np.ndarray], start: np.ndarray, spin: Any,
            times: Any) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Attitudes (k, 3, 3) and body angular velocities (k, 3): R' = R hat(omega)."""

    def right(_: float, y: np.ndarray) -> np.ndarray:
        attitude, omega = y[:9].reshape(3, 3), y[9:12]
        # the rows of R are fixed directions as the body sees them
        return np.concatenate([np.cross(attitude, omega).ravel(), rates(attitude, omega)])

    first = np.concatenate([start.ravel(), spin])
    found = solve_ivp(
        right, (times[0], times[-1]), first, method="DOP853", t_eval=times, rtol=2.3e-14, atol=1e-15
    )
    return found.y[:9].T.reshape(-1, 3, 3), found.y[9:12].T


def chaplygin(attitude: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """G = (I + D) omega - D (omega, gamma) gamma, G' = G x omega, gamma' = gamma x omega."""
    inertia, normal = np.diag([1.4, 1.5, 1.7]), attitude[2]
    moving = np.cross(normal, omega)
    momentum = inertia @ omega - omega.dot(normal) * normal
    known = np.cross(momentum, omega) + omega.dot(moving) * normal + omega.dot(normal) * moving
    return np.linalg.solve(inertia - np.outer(normal, normal), known)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_angles_on_invariants_near_a_pole(method: str) -> None:
    ball = vo.derive(vo.load("chaplygin-ball"))
    start = {"theta": 1e-7, **{f"omega{i}": x for i, x in enumerate(SPIN, 1)}}
    times = np.linspace(0, 3, 31)
    motion = vo.integrate(
        ball, times=times, outputs=("phi",), initial=start, tol=1e-16, method=method
    )
    attitudes, _ = turning(chaplygin, euler(0, 1e-7, 0), SPIN, times)
    phi = np.arctan2(attitudes[-1, 0, 2], -attitudes[-1, 1, 2])
    assert abs(np.remainder(motion["phi"][-1] - phi + np.pi, 2 * np.pi) - np.pi) < 1e-8


def test_denominators_that_are_sums_of_squares() -> None:
    import symengine as se

    x, y, z, a = se.symbols("x y z a")
    sphere = [x**2 + y**2 + z**2 - 1]
    found = with_positive_denominators(a / ((1 + z) * (z - 1)), sphere)
    assert found == -a / (x**2 + y**2)
    assert with_positive_denominators(a / (1 - z**2), sphere) == a / (x**2 + y**2)
    for other in (a / (1 + z), a / (2 - z**2), a / z, se.Integer(1)):
        assert with_positive_denominators(other, sphere) == other
    assert sp.simplify(sp.sympify(with_positive_denominators(1 / (z**2 - 1) ** 2, sphere))) == (
        1 / sp.sympify(x**2 + y**2) ** 2
    )


POLAR = ("homogeneous-ball", "zhukovsky-ball", "bobylev-ball", "gyroscopic-ball-on-plane")


@pytest.mark.parametrize("name", POLAR)
def test_whole_turns_past_a_pole_do_not_depend_on_the_grid(name: str) -> None:
    ball = vo.derive(vo.load(name))
    spins = tuple(map(str, ball.system.velocities))
    wanted = ("configuration", *spins)
    start = {"u": 1e-4, "v": 1.3, **dict(zip(spins, (0.9, 1.4, 0.6), strict=True))}
    back = vo.integrate(ball, times=[0, -1.5], initial=start, outputs=wanted)
    begin = {x: back[x][-1] for x in back.outputs}

    def ends(grid: np.ndarray, method: str = "scipy", **more: Any) -> np.ndarray:
        motion = vo.integrate(
            ball, times=grid, initial=begin, outputs=wanted, method=method, **more
        )
        assert motion.cost.switches == 2
        return np.array([motion[x][-1] for x in motion.outputs])

    fine = np.unique(np.concatenate([np.linspace(-1.5, 1.5, 301), np.linspace(-1e-2, 1e-2, 4001)]))
    truth = ends(fine)
    # on the fine grid no angle moves by more than a right angle between two instants
    whole = vo.integrate(ball, times=fine, initial=begin, outputs=wanted, method="scipy")
    assert max(np.abs(np.diff(whole[x])).max() for x in ("u", "v", "theta")) < np.pi / 2
    for method in ("scipy", "heyoka"):
        assert ends(np.array([-1.5, 1.5]), method) == pytest.approx(truth, abs=1e-9)
        assert ends(np.linspace(-1.5, 1.5, 7), method) == pytest.approx(truth, abs=1e-9)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_a_motion_through_a_pole_says_so(method: str) -> None:
    ball = vo.derive(vo.load("homogeneous-ball"))
    # about the horizontal axis across v = 0.3, at right angles to the meridian
    start = {"u": 1, "v": 0.3, "omega1": -np.sin(0.3), "omega2": np.cos(0.3)}
    for times in ([0, 3], [0, 0.5, 1, 1.5, 3]):
        motion = vo.integrate(
            ball, times=times, initial=start, method=method, outputs=("configuration",)
        )
        assert motion["u"][-1] == pytest.approx(2)
        (note,) = motion.notes
        assert note.startswith("at t = 1 the motion passes through a pole of the coordinates")

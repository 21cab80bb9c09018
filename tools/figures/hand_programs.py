"""The best programs by hand: rolling balls in a momentum G and the normal
gamma.

Constants are numbers in the programs, and everything is written so as to multiply least.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.motion.steppers import heyoka

NORMAL = ("gamma1", "gamma2", "gamma3")
SPIN = ("omega1", "omega2", "omega3")

Values = Mapping[str, float]


@dataclass(frozen=True)
class HandProgram:
    """``equations``: pairs (variable, right side) of heyoka; ``start`` takes the values of our
    variables by name to the state (n,), ``back`` takes states (k, n) to outputs, among them
    ``outputs``, which are compared."""

    equations: list[tuple[Any, Any]]
    start: Callable[[Values], np.ndarray]
    back: Callable[[np.ndarray], dict[str, np.ndarray]]
    outputs: tuple[str, ...]


def ball(moments: Sequence[float], D: float, epsilon: float) -> HandProgram:
    """A ball of principal moments I rolling on a plane (epsilon = 1) or on a sphere.

        Gdot = G x omega,   gammadot = epsilon gamma x omega,
        omega = J (G + D (omega, gamma) gamma),
        (omega, gamma) = (J G, gamma) / (1 - D (J gamma, gamma)),

    with J = (I + D)^-1 and D = m R^2 [Chaplygin1903], [DragovicGajicJovanovic2020].
    """
    hy = heyoka()
    inertia = np.array(moments, dtype=float)
    J = 1 / (inertia + D)
    G, gamma = hy.make_vars("G1", "G2", "G3"), hy.make_vars(*NORMAL)
    # squares cost the Taylor method half of a product, and constants nothing
    above = hy.sum([j * (g * p) for j, g, p in zip(J, gamma, G, strict=True)])
    below = 1 / D - hy.sum([j * g**2.0 for j, g in zip(J, gamma, strict=True)])
    share = above / below
    omega = [j * (p + share * g) for j, p, g in zip(J, G, gamma, strict=True)]
    turning = [epsilon * e if epsilon != 1 else e for e in _cross(gamma, omega)]

    def start(values: Values) -> np.ndarray:
        g, w = (np.array([values[n] for n in names]) for names in (NORMAL, SPIN))
        return np.array([*(inertia * w + D * (w - w.dot(g) * g)), *g])

    def back(rows: np.ndarray) -> dict[str, np.ndarray]:
        momentum, g = rows[:, :3], rows[:, 3:]
        along = (momentum * J * g).sum(1) / (1 - D * (J * g**2).sum(1))
        w = J * (momentum + D * along[:, None] * g)
        return dict(zip(NORMAL + SPIN, [*g.T, *w.T], strict=True))

    variables, rates = [*G, *gamma], [*_cross(G, omega), *turning]
    return HandProgram(list(zip(variables, rates, strict=True)), start, back, NORMAL + SPIN)


def demchenko(p: Values) -> HandProgram:
    """Demchenko's ball, whose inertia A is spherical, with the axis of its gyroscope k along e3.

    With J = A + D, c = gamma x G and the spin (gamma, omega) = ((gamma, G) - k gamma3) / A,

        Gdot = -(D spin c + k G x e3) / J,   gammadot = epsilon (c - k gamma x e3) / J.

    gamma is minus the ball's own normal at the contact, so u and v are its spherical angles; v is
    known up to whole turns only, and not offered.  Twelve products.
    """
    hy = heyoka()
    A, k, D = p["A"], p["k"], p["M"] * p["R2"] ** 2
    J, epsilon = A + D, p["R1"] / (p["R1"] + p["R2"])
    G, gamma = hy.make_vars("G1", "G2", "G3"), hy.make_vars(*NORMAL)
    across = _cross(gamma, G)
    spin = hy.sum([g * m for g, m in zip(gamma, G, strict=True)]) - k * gamma[2]
    scaled = (-D / J / A) * spin
    e, turn = epsilon / J, epsilon * k / J
    rates = [
        scaled * across[0] - (k / J) * G[1],
        scaled * across[1] + (k / J) * G[0],
        scaled * across[2],
        e * across[0] - turn * gamma[1],
        e * across[1] + turn * gamma[0],
        e * across[2],
    ]

    def start(values: Values) -> np.ndarray:
        u, v = values["u"], values["v"]
        along_u = np.array([np.cos(u) * np.cos(v), np.cos(u) * np.sin(v), -np.sin(u)])
        along_v = np.array([-np.sin(v), np.cos(v), 0.0])
        g = -np.array([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)])
        w = values["s"] * along_u + values["tau"] * along_v - values["n"] * g
        return np.concatenate([J * w - D * g.dot(w) * g + [0.0, 0.0, k], g])

    def back(rows: np.ndarray) -> dict[str, np.ndarray]:
        g = rows[:, 3:].T
        return {"u": np.arctan2(np.hypot(g[0], g[1]), -g[2]), "v": np.arctan2(-g[1], -g[0])}

    return HandProgram(list(zip([*G, *gamma], rates, strict=True)), start, back, ("u",))


def sleigh(p: Values) -> HandProgram:
    """Chaplygin's sleigh, whose centre of mass lies at the distance a before the blade:

    vdot = a omega^2,   (J + m a^2) omegadot = -m a v omega.
    """
    hy = heyoka()
    names = ("x", "y", "phi", "v", "w")
    x, y, phi, v, w = hy.make_vars(*names)
    a, drag = p["a"], p["m"] * p["a"] / (p["J"] + p["m"] * p["a"] ** 2)
    rates = [v * hy.cos(phi), v * hy.sin(phi), w, a * w**2.0, -drag * (v * w)]
    return HandProgram(
        list(zip([x, y, phi, v, w], rates, strict=True)),
        lambda values: np.array([values[n] for n in names]),
        lambda rows: dict(zip(names, rows.T, strict=True)), names,
    )  # fmt: skip


def _cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def _on_plane(p: Values) -> HandProgram:
    return ball([p["I1"], p["I2"], p["I3"]], p["m"] * p["R"] ** 2, 1.0)


def _homogeneous(p: Values) -> HandProgram:
    return ball([p["A"]] * 3, p["m"] * p["R"] ** 2, 1.0)


def _on_sphere(p: Values) -> HandProgram:
    moments = [p["I1"], p["I2"], p["I3"]]
    return ball(moments, p["m"] * p["R2"] ** 2, p["R1"] / (p["R1"] + p["R2"]))


BY_HAND: dict[str, Callable[[Values], HandProgram]] = {
    "chaplygin-ball": _on_plane,
    "homogeneous-ball": _homogeneous,
    "ball-on-sphere": _on_sphere,
    "demchenko": demchenko,
    "sleigh": sleigh,
}
"""Systems that somebody has written by hand, as functions of their parameters' values."""

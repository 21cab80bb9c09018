"""Programs for heyoka written by hand, as short as the author can make them: peers of the engine.

Each peer is a function of the parameters' values that gives the pairs (variable, right side), with
the numbers put in, and a function from the engine's variables to the initial state.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["Peer", "ball_on_plane", "ball_on_sphere", "demchenko"]

Values = Mapping[str, float]


@dataclass(frozen=True)
class Peer:
    """``equations``: pairs (variable, right side) of heyoka; ``state(values)``: their initial
    values from those of the engine's variables, by name; ``back(state)``: the other way."""

    equations: list[tuple[Any, Any]]
    state: Callable[[Values], np.ndarray]
    back: Callable[[np.ndarray], dict[str, np.ndarray]]


def ball_on_sphere(parameters: Values) -> Peer:
    """The non-symmetric ball on a sphere in the momentum G about the contact and the normal gamma.

        G' = G x omega,  gamma' = epsilon gamma x omega,  omega = J^-1 (G + s gamma),
        s = (gamma, J^-1 G) / (1/D - (gamma, J^-1 gamma)),  J = I + D,  D = m R2^2

    The state is (gamma, G).  22 products, 3 of which are squares.
    """
    p = parameters
    return _ball(p, p["m"] * p["R2"] ** 2, p["R1"] / (p["R1"] + p["R2"]))


def ball_on_plane(parameters: Values) -> Peer:
    """The same on a plane: epsilon = 1."""
    return _ball(parameters, parameters["m"] * parameters["R"] ** 2, 1.0)


def demchenko(parameters: Values) -> Peer:
    """Demchenko's ball in the momentum G about the contact and the normal gamma, with A spherical.

    With J = A + D, c = gamma x G, and s = (gamma, omega) = ((gamma, G) - k gamma3) / A,

        G' = -(D s c + k G x e3) / J,  gamma' = epsilon (c - k gamma x e3) / J.

    The state is (gamma, G); gamma is minus the ball's own normal at the contact, so u and v are its
    spherical angles.  12 products.
    """
    import heyoka as hy

    p = parameters
    d, k, a = p["M"] * p["R2"] ** 2, p["k"], p["A"]
    j, epsilon = a + d, p["R1"] / (p["R1"] + p["R2"])
    normal = hy.make_vars("gamma1", "gamma2", "gamma3")
    momentum = hy.make_vars("G1", "G2", "G3")
    across = _cross(normal, momentum)
    spin = hy.sum([g * m for g, m in zip(normal, momentum, strict=True)]) - k * normal[2]
    scaled = (-d / j / a) * spin
    first, second, _ = momentum
    rates = [
        scaled * across[0] - (k / j) * second,
        scaled * across[1] + (k / j) * first,
        scaled * across[2],
    ]
    e, kept = epsilon / j, epsilon * k / j
    turning = [
        e * across[0] - kept * normal[1],
        e * across[1] + kept * normal[0],
        e * across[2],
    ]
    equations = [*zip(normal, turning, strict=True), *zip(momentum, rates, strict=True)]

    def state(values: Values) -> np.ndarray:
        u, v = values["u"], values["v"]
        along_u = np.array([np.cos(u) * np.cos(v), np.cos(u) * np.sin(v), -np.sin(u)])
        along_v = np.array([-np.sin(v), np.cos(v), 0.0])
        g = -np.array([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)])
        w = values["s"] * along_u + values["tau"] * along_v - values["n"] * g
        return np.concatenate([g, j * w - d * (g @ w) * g + [0.0, 0.0, k]])

    def back(rows: np.ndarray) -> dict[str, np.ndarray]:
        """v up to whole turns."""
        g = rows[..., :3]
        return {
            "u": np.arctan2(np.hypot(g[..., 0], g[..., 1]), -g[..., 2]),
            "v": np.arctan2(-g[..., 1], -g[..., 0]),
        }

    return Peer(equations, state, back)


def _ball(parameters: Values, d: float, epsilon: float) -> Peer:
    import heyoka as hy

    j = np.array([parameters[f"I{i}"] for i in (1, 2, 3)]) + d
    normal = hy.make_vars("gamma1", "gamma2", "gamma3")
    momentum = hy.make_vars("G1", "G2", "G3")
    above = hy.sum([g * m * (d / x) for g, m, x in zip(normal, momentum, j, strict=True)])
    below = 1.0 - hy.sum([g**2 * (d / x) for g, x in zip(normal, j, strict=True)])
    share = above / below
    spin = [(m + share * g) * (1 / x) for m, g, x in zip(momentum, normal, j, strict=True)]
    turning = _cross(normal, spin)
    rates = turning if epsilon == 1 else [epsilon * e for e in turning]
    equations = [
        *zip(normal, rates, strict=True),
        *zip(momentum, _cross(momentum, spin), strict=True),
    ]

    def state(values: Values) -> np.ndarray:
        g = np.array([values[f"gamma{i}"] for i in (1, 2, 3)], dtype=float)
        w = np.array([values[f"omega{i}"] for i in (1, 2, 3)], dtype=float)
        return np.concatenate([g, j * w - d * (g @ w) * g])

    def back(rows: np.ndarray) -> dict[str, np.ndarray]:
        g, m = rows[..., :3], rows[..., 3:]
        pivot = 1 - d * (g**2 / j).sum(-1)
        w = (m + (d * (g * m / j).sum(-1) / pivot)[..., None] * g) / j
        return {f"gamma{i + 1}": g[..., i] for i in range(3)} | {
            f"omega{i + 1}": w[..., i] for i in range(3)
        }

    return Peer(equations, state, back)


def _cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]

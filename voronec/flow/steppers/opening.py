"""First steps of heyoka's integrators, where their own would be far too long.

heyoka takes the length of a step from the last two Taylor coefficients, which vanish at once where
the start is special: x'' = 1 - x^2 from rest at 0 has those of t^2, t^6, t^10, ... alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["opening", "openings"]

SPARSE = 2.0
"""A step so many times longer than the other coefficients allow is not to be trusted."""


def opening(coefficients: np.ndarray, taken: float, tol: float) -> float:
    """The length of a step whose Taylor coefficients are (n, order + 1), where the one ``taken`` is
    too long; else infinite.

    It goes by the latter half of them: the radius of convergence that each suggests, times
    tol^(1/order).
    """
    sizes = np.abs(coefficients).max(axis=0)
    sizes = sizes / max(1.0, sizes[0])
    order = len(sizes) - 1
    later = [(k, sizes[k]) for k in range(order // 2, order + 1) if sizes[k] > 0]
    radius = min((size ** (-1.0 / k) for k, size in later), default=np.inf)
    length = float(radius * tol ** (1.0 / order))
    return length if abs(taken) > SPARSE * length else np.inf


def openings(integrator: Any, spans: np.ndarray) -> np.ndarray:
    """Such lengths for all lanes of a batch integrator, no step going beyond ``spans``; it stands
    afterwards where it stood."""
    times, state = [part.copy() for part in integrator.dtime], integrator.state.copy()
    integrator.step(max_delta_t=spans.tolist(), write_tc=True)
    taken = [length for _, length in integrator.step_res]
    found = [
        opening(integrator.tc[:, :, lane], length, integrator.tol)
        for lane, length in enumerate(taken)
    ]
    integrator.set_dtime(*times)
    integrator.state[:] = state
    return np.array(found)

"""First steps of heyoka's integrators, where their own would be far too long.

heyoka takes the length of a step from the last two Taylor coefficients, which vanish at once where
the start is special: x'' = 1 - x^2 from rest at 0 has those of t^2, t^6, t^10, ... alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["GROWING", "STRIDE", "opening", "openings", "overlong_lanes"]

SPARSE = 2.0
"""A step so many times longer than the other coefficients allow is not to be trusted."""
STRIDE = 4.0
"""A step so many times the mean of the others of its chunk may have been made too long by
coefficients that vanish; then the chunk is looked at step by step.  So is each chunk of a run that
began with such a step, since a motion comes back."""
GROWING = 1.5
"""Of these, only such are looked at as are so many times longer than the step before."""
SPECK = 1e-300
"""A step of a lane that has come to its end: heyoka takes none of length zero."""


def opening(coefficients: np.ndarray, taken: float, tol: float) -> float:
    """The length of a step whose Taylor coefficients are (n, order + 1), where the one ``taken`` is
    too long; else infinite.

    It goes by the latter half of them: the radius of convergence that each suggests, times
    tol^(1/order).
    """
    sizes = np.abs(coefficients).max(axis=0).tolist()
    scale, order = max(1.0, sizes[0]), len(sizes) - 1
    later = ((k, sizes[k] / scale) for k in range(order // 2, order + 1))
    radii = [size ** (-1.0 / k) for k, size in later if size > 0]
    length = min(radii, default=np.inf) * tol ** (1.0 / order)
    return float(length if abs(taken) > SPARSE * length else np.inf)


def _openings(coefficients: np.ndarray, taken: np.ndarray, tol: float) -> np.ndarray:
    """The same of several steps (k,), with coefficients (n, order + 1, k)."""
    sizes = np.abs(coefficients).max(axis=0)
    sizes = sizes / np.fmax(1.0, sizes[0])
    order = len(sizes) - 1
    powers = -1.0 / np.arange(order // 2, order + 1)[:, None]
    later = sizes[order // 2 :]
    sound = np.where(later > 0, later, 0.0)  # to a negative power: infinite
    with np.errstate(divide="ignore"):
        lengths = (sound**powers).min(axis=0) * tol ** (1.0 / order)
    return np.where(np.abs(taken) > SPARSE * lengths, lengths, np.inf)


def openings(integrator: Any, spans: np.ndarray) -> np.ndarray:
    """Such lengths for all lanes of a batch integrator, no step going beyond ``spans``; it stands
    afterwards where it stood."""
    times, state = [part.copy() for part in integrator.dtime], integrator.state.copy()
    integrator.step(max_delta_t=spans.tolist(), write_tc=True)
    taken = np.array([length for _, length in integrator.step_res])
    found = _openings(integrator.tc, taken, integrator.tol)
    integrator.set_dtime(*times)
    integrator.state[:] = state
    return found


def overlong_lanes(
    integrator: Any, begin: tuple[np.ndarray, ...], state: np.ndarray, stride: np.ndarray
) -> np.ndarray:
    """Which lanes (width,) of a batch integrator took a step that was made too long, from
    ``begin`` (its ``dtime``) and ``state`` (n, width) to where it stands, and stands afterwards.

    Lanes of which one step is more than ``stride`` (width,) times the others are gone over again.
    """
    ends, there = tuple(part.copy() for part in integrator.dtime), integrator.state.copy()
    width = len(ends[0])
    taken, longest = (
        np.array([abs(result[k]) for result in integrator.propagate_res]) for k in (3, 2)
    )
    span = np.abs(ends[0] - begin[0])
    others = (span - longest) / np.maximum(taken - 1, 1)
    suspect, found = (taken > 1) & (longest > stride * others), np.zeros(width, dtype=bool)
    if not suspect.any() or not np.isfinite(there).all():
        return found
    integrator.set_dtime(*begin)
    integrator.state[:] = state
    before = np.full(width, np.inf)
    for _ in range(int(taken[suspect].max())):
        left = ends[0] - integrator.time
        # a lane that has arrived, or whose motion ends on the way, stands still
        still = (left == 0) | ~np.isfinite(left)
        integrator.step(max_delta_t=np.where(still, SPECK, left).tolist(), write_tc=True)
        for lane in np.flatnonzero(suspect & ~found):
            length = abs(integrator.step_res[lane][1])
            if length > GROWING * before[lane]:
                tol, tc = integrator.tol, integrator.tc[:, :, lane]
                found[lane] = opening(tc, length, tol) < np.inf
            before[lane] = length
    integrator.set_dtime(*ends)
    integrator.state[:] = there
    return found

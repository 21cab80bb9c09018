"""Where a function of Python's changes fast: steps end there, as at the instants of a table.

An integrator asks a function for its values at a dozen instants of a step, and from rest its steps
grow to the whole span: a pulse between these would be lost without a word.  So a function is asked
beforehand, at ``SAMPLES`` + 1 instants over the span, and the span is halved until the samples in
every part are a polynomial through a few of them, to ``RESOLUTION`` of the function's range: what
the integrator sees of such a part is all that the samples tell.  In a part that no halving resolves
a jump is sought between two neighbours among the doubles: a step over a jump that is large beside
the motion would be shorter than rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

SAMPLES = 4096
"""Parts of a span at whose ends a function is asked: a power of two."""
NODES = 9
"""A part is a polynomial through so many samples: fewer than an integrator sees in a step."""
RESOLUTION = 1e-4
"""What lies within this part of a function's range is one polynomial."""
MOST_SHARP = SAMPLES // 32
"""So many pairs of neighbours may hold a jump or a corner: a function that has more is noise, or
vibrates faster than it is sampled, and steps that end everywhere would help nobody."""
PROBES = (0, 1, SAMPLES // 3, SAMPLES)
"""Samples that are compared, where a function takes arrays, with those of the instants alone."""


def breaks(
    function: Callable[[Any], Any], start: float, end: float
) -> tuple[list[float], list[tuple[float, float]]] | None:
    """The instants between the parts of a span, on both sides of a jump, and those parts that the
    samples do not resolve, as at a jump; None where there are more of these than a few."""
    times = np.linspace(start, end, SAMPLES + 1)
    values = _samples(function, times)
    size = np.ptp(values[np.isfinite(values)]) if np.isfinite(values).any() else 0.0
    instants: list[float] = []
    sharp: list[tuple[float, float]] = []
    parts = [(0, SAMPLES)] if size > 0 else []
    while parts:
        first, last = parts.pop()
        off = _off_polynomial(values[first : last + 1])
        if not off > RESOLUTION * size:  # what has no value somewhere is the run's to refuse
            continue
        middle = (first + last) // 2
        instants.append(float(times[middle]))
        if last - first > 2:
            parts += [(first, middle), (middle, last)]
            continue
        sharp.append((float(min(times[first], times[last])), float(max(times[first], times[last]))))
        if len(sharp) > MOST_SHARP:
            return None
    jumps = [t for low, high in sharp for t in _jump(function, low, high, RESOLUTION * size)]
    return [*instants, *jumps], sharp


def _jump(function: Callable[[Any], Any], low: float, high: float, least: float) -> list[float]:
    """The two doubles between which a function jumps by more than the ``least``; none where it does
    not, or has no value."""
    try:
        below, above = float(function(low)), float(function(high))
        while low < (middle := low + (high - low) / 2) < high:
            value = float(function(middle))
            if abs(value - below) > abs(above - value):
                high, above = middle, value
            else:
                low, below = middle, value
    except Exception:  # told where the run comes there
        return []
    return [low, high] if abs(above - below) > least else []


def _samples(function: Callable[[Any], Any], times: np.ndarray) -> np.ndarray:
    """The values at instants (k,), at once where the function takes arrays; not a number where it
    has no value."""

    def single(instant: float) -> float:
        try:
            return float(function(instant))
        except Exception:  # told where the run comes there
            return np.nan

    try:
        with np.errstate(all="ignore"):
            samples = np.array(function(times.copy()), dtype=float)
    except Exception:  # it takes no arrays
        samples = np.empty(0)
    if samples.shape == times.shape:
        alone = np.array([single(float(times[k])) for k in PROBES])
        if np.allclose(samples[[*PROBES]], alone, rtol=1e-9, atol=0.0, equal_nan=True):
            return samples
    return np.array([single(t) for t in times.tolist()])


def _off_polynomial(values: np.ndarray) -> float:
    """How far samples (k,) are off the polynomial through a few of them."""
    places, matrix = _interpolation(len(values) - 1)
    return float(np.abs(matrix @ values[places] - values).max())


@lru_cache
def _interpolation(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Places of the nodes among ``count`` + 1 samples, dense at both ends, and the matrix from
    values there to values everywhere."""
    nodes = min(NODES, count // 2 + 1)
    places = np.round(count * (1 - np.cos(np.pi * np.arange(nodes) / (nodes - 1))) / 2).astype(int)
    basis = np.polynomial.legendre.legvander(np.linspace(-1, 1, count + 1), nodes - 1)
    return places, basis @ np.linalg.inv(basis[places])

"""The natural sizes of states: integrators control their steps by them, not by 1.

A step of Taylor's method is as long as the largest state allows, and small states count as if they
were of size 1.  So in other units of length the same motion had other errors.  States far from
ordinary size are measured in units of their own, powers of two: what is of ordinary size is
computed with the same bits as ever.
"""

from __future__ import annotations

from collections.abc import Collection
from math import frexp

import numpy as np

from voronec.flow.steppers.run import Problem
from voronec.program import compiled

__all__ = ["natural_units"]

SMALL, LARGE = 2.0**-24, 2.0**10
"""Sizes between these are ordinary: their unit is 1."""
STILL = 2.0**-40
"""A rate below this part of the largest is mostly rounding, and tells no time."""


def natural_units(problem: Problem, angles: Collection[int] = ()) -> np.ndarray:
    """The unit of each state (n,): 1, or the power of two next to its size at the start.

    The size is |x|, or |x'| over the time in which states change by as much as they are, in the
    median; rates that are rounding do not count.  ``angles``, positions of states that matter up
    to turns only, have the unit 1.
    """
    state = np.array(problem.start, dtype=float)
    units = np.ones(len(state))
    with np.errstate(all="ignore"):
        given = [np.float64(x) for x in problem.parameters]
        rates = np.array(compiled(problem.program)[0](np.float64(0.0), list(state), given), float)
    x, slope = np.abs(state), np.abs(rates)
    if not np.isfinite(slope).all():
        return units
    moving = (x > 0) & (slope > STILL * slope.max(initial=0.0))
    time = float(np.median(x[moving] / slope[moving])) if moving.any() else 0.0
    for i, size in enumerate(np.maximum(x, slope * time)):
        if i not in angles and size > 0 and not SMALL <= size <= LARGE:
            units[i] = 2.0 ** frexp(size)[1]
    return units

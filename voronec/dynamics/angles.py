"""Which variables are angles, as the equations tell."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

SAME = 1e-9
"""Two right sides are equal at a point where they differ by this part of their size."""


def are_angles(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray, n: int) -> np.ndarray:
    """Which of the first n arguments are angles (n,): a whole turn of them changes no value of
    ``function`` at a random point, or at several (..., N)."""
    there, turns = function(at), 2 * np.pi * np.eye(at.shape[-1])[:n]
    off = [np.abs(function(at + turn) - there).max() for turn in turns]
    return np.array(off) <= SAME * np.abs(there).max()

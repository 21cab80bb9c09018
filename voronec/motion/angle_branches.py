"""Whether angles that are read off on a grid are certain to be on their branches."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from voronec.motion.steppers.run import Run
from voronec.motion.trajectory import Trajectory

__all__ = ["Untold", "require_branches"]

PER_STEP = 4
"""So many points of the grid in a step, on the average, tell the branches of angles apart; nowhere
may two be farther apart than the shortest step between them."""
SWING = np.pi / 2
"""What an angle may turn by from one point to the next; where it is more, a pole is near."""


class Untold(Exception):
    """Branches of angles could not be told: these are to be integrated."""


def require_branches(trajectory: Trajectory, names: Iterable[str], run: Run) -> None:
    """Raise ``Untold`` where the integrator's own steps do not tell branches apart.

    Within a step a motion is nearly a polynomial: what turns by more than half a turn between two
    points that are nearer to each other than the steps there has come near its pole.
    """
    angles = [trajectory[name].astype(float) for name in names]
    if not angles or run.steps == 0:
        return
    if len(trajectory) < PER_STEP * run.steps or not is_resolved(trajectory.t, run.ends):
        raise Untold
    if any(np.abs(np.diff(angle)).max(initial=0.0) > SWING for angle in angles):
        raise Untold


def is_resolved(grid: np.ndarray, ends: Iterable[float]) -> bool:
    """Whether no two neighbours on a grid are farther apart than the shortest step between them."""
    marks = np.abs(np.array([grid[0], *ends], dtype=float) - float(grid[0]))
    times = np.abs(grid.astype(float) - float(grid[0]))
    lengths = np.diff(marks)
    if not lengths.size:
        return False
    lengths[-1] = max(lengths[-1], *lengths[-2:])  # the last step ends where the grid does
    first = np.searchsorted(marks, times[:-1], side="right") - 1
    last = np.searchsorted(marks, times[1:], side="left") - 1
    first, last = (np.clip(place, 0, lengths.size - 1) for place in (first, last))
    shortest = np.minimum(lengths[first], lengths[last])
    return bool((np.diff(times) <= shortest).all() and (last - first <= 1).all())

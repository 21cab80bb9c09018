"""How much a case magnifies relative changes: its condition numbers.

With Phi(t, s) the propagator of the variational equations, o an output, p the parameters,

    kappa(t) = 1 + sum_p |do(t)/dp| |p| / |o|
                 + max over s <= t of sum_i |do(t)/dx (t) Phi(t, s)|_i X_i / |o|.

The first sum is of what an error of the parameters does, the second of what an error made at any
time s on the way does: rounding errors are made all along, not only in the initial data.  |o| is
the largest value of the output along the motion.  X_i is the size of a state: an angle's largest
value, but at least one radian; for other coordinates, and for velocities, the largest of them all.
An angle is what occurs under a sine or a cosine.
"""

from __future__ import annotations

import numpy as np

from voronec.accuracy.hard.case_program import PreciseProblem
from voronec.accuracy.hard.multiprecision import Passage

__all__ = ["UNIT", "condition_numbers", "output_sizes", "sizes", "times"]

UNIT = 2.0**-53
"""The largest relative error of rounding to a double."""
NOTHING = 1e-20
"""An output that stays below this is zero, and is compared absolutely: |o| is one."""


def sizes(problem: PreciseProblem, states: np.ndarray) -> np.ndarray:
    """X_i of the kept states (k, n): see the module; shape (n,)."""
    largest = np.abs(states.astype(float)).max(axis=0)
    coordinates = len(problem.program.coordinates)
    angle = np.array([i in problem.angles for i in problem.kept])
    moving = np.array([i >= coordinates for i in problem.kept])
    result = np.maximum(largest, 1.0)
    for group in (moving, ~moving & ~angle):
        if group.any():
            result[group] = largest[group].max() or 1.0
    return result


def condition_numbers(problem: PreciseProblem, passage: Passage) -> np.ndarray:
    """kappa of every output at every instant of a passage; shape (k, m)."""
    scale = output_sizes(passage.outputs)
    size = sizes(problem, passage.states)
    constants = np.abs(np.array([float(x) for x in problem.values]))
    count, width = passage.outputs.shape
    drift = np.zeros((passage.states.shape[1], len(constants)), dtype=object)
    result = np.empty((count, width))
    for j in range(count):
        if j:
            drift = times(passage.steps[j - 1], drift) + passage.drives[j - 1]
        slopes = times(passage.gradients[j], drift) + passage.by_parameters[j]
        data = np.abs(slopes.astype(float)) @ constants
        result[j] = 1.0 + (data + _error_growth(passage, j, size)) / scale
    return result


def output_sizes(outputs: np.ndarray) -> np.ndarray:
    """|o|, the largest value of every output (k, m); one where it is always nothing."""
    largest = np.abs(outputs.astype(float)).max(axis=0)
    return np.where(largest > NOTHING, largest, 1.0)


def _error_growth(passage: Passage, j: int, size: np.ndarray) -> np.ndarray:
    """What an error made at the worst instant up to the j-th does to the outputs there."""
    reach = passage.gradients[j]
    worst = np.abs(reach.astype(float)) @ size
    for step in passage.steps[:j][::-1]:
        reach = times(reach, step)
        worst = np.maximum(worst, np.abs(reach.astype(float)) @ size)
    return worst


def times(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """A product of matrices of many digits."""
    if right.shape[1] == 0:
        return np.zeros((left.shape[0], 0), dtype=object)
    return left.astype(object) @ right.astype(object)

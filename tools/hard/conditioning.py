"""How much a motion magnifies relative changes: its condition numbers.

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

from voronec.accuracy.precise_motion import PreciseMotion
from voronec.accuracy.problem import ProblemFormulation, dependence_of_names
from voronec.accuracy.solution import output_sizes
from voronec.algebra.graphs import nodes
from voronec.equations.program import Program


def sizes(problem: ProblemFormulation, states: np.ndarray) -> np.ndarray:
    """X_i of the kept states (k, n): see the module; shape (n,)."""
    largest = np.abs(states.astype(float)).max(axis=0)
    coordinates = len(problem.program.coordinates)
    angles = _angle_places(problem.program)
    angle = np.array([i in angles for i in problem.places])
    moving = np.array([i >= coordinates for i in problem.places])
    result = np.maximum(largest, 1.0)
    for group in (moving, ~moving & ~angle):
        if group.any():
            result[group] = largest[group].max() or 1.0
    return result


def _angle_places(program: Program) -> set[int]:
    """The positions of coordinates that occur, by whatever names, under a sine or a cosine."""
    place = {q: i for i, q in enumerate(program.coordinates)}
    found: set[int] = set()
    for block in (program.derivative, program.extras):
        reach = dependence_of_names(block, place)
        for node in nodes(block.expressions):
            if type(node).__name__ in ("sin", "cos", "tan", "cot"):
                found = found.union(*(reach.get(s, set()) for s in node.free_symbols))
    return found


def condition_numbers(problem: ProblemFormulation, passage: PreciseMotion) -> np.ndarray:
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


def _error_growth(passage: PreciseMotion, j: int, size: np.ndarray) -> np.ndarray:
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

"""Constraints where they are dependent, though the velocities they admit are known by continuity.

    gamma4 Omega12 = gamma2 Omega14 - gamma1 Omega24,  and so on for the pairs 13 and 23

are two conditions where gamma4 = 0, and three beside it.  Solved for other velocities, in normal
form, they have the divisor gamma1 in its place, and are good where that is not 0.  Which ones is
told by the velocities that are admissible beside the place; that these have a limit there, and it
is what the solution says, is looked at in numbers.

On a group alone: its frame is good everywhere, so that it is the constraints that fail.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any

import numpy as np
import symengine as se

from voronec.declaration.system import System
from voronec.equations.definition import read
from voronec.equations.derivation import Derivation

__all__ = ["are_dependent", "has_limit", "places_beside", "solution_rows"]

DEPENDENT = 1e-3
"""Constraints whose least singular value is below this part of the largest are dependent."""
BESIDE, SIDES = 1e-4, 4
"""So far away, in units of the coordinates' size, and at so many places it is looked beside."""
LIMIT = 1e-2
"""By less than this part do velocities that are admissible beside the place miss the limit."""


def are_dependent(rows: np.ndarray) -> bool:
    """Whether the rows (m, N) of constraints are dependent at one place."""
    sizes = np.linalg.svd(_unit(rows), compute_uv=False)
    return bool(sizes.min(initial=1.0) < DEPENDENT * sizes.max(initial=1.0))


def _unit(rows: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.asarray(rows / np.where(lengths == 0, 1.0, lengths))


def places_beside(q: np.ndarray) -> np.ndarray:
    """Places (n, k) beside coordinates q (n,)."""
    dice = Random(0)
    ways = np.array([dice.uniform(-1, 1) for _ in range(q.size * SIDES)]).reshape(-1, SIDES)
    return np.asarray(q[:, None] + BESIDE * max(1.0, np.abs(q).max(initial=0.0)) * ways)


def solution_rows(system: System, directions: Sequence[Any]) -> list[list[Any]]:
    """Rows of the constraints, each with its offset, solved for the fibre of a group in normal
    form; a column for each of the ``directions``, the same velocities in another order."""
    found = Derivation(read(system), exact=True).fibre
    own = {w: a for a, w in enumerate(system.directions)}
    rows = []
    for k, (slopes, offset) in enumerate(zip(found.matrix, found.offset, strict=True)):
        unit = [se.Integer(int(k == i)) for i in range(len(found.matrix))]
        row = [*(-s for s in slopes), *unit]
        rows.append([*(row[own[w]] for w in directions), -offset])
    return rows


def has_limit(rows: np.ndarray, beside: Sequence[np.ndarray]) -> bool:
    """Whether rows (m, N) are numbers, and hold for what is admissible beside, by bases (N, k)."""
    if not np.isfinite(rows).all():
        return False
    left = _unit(rows)
    return all(np.abs(left @ ways).max(initial=0.0) < LIMIT for ways in beside)

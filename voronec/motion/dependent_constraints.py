"""Constraints where they are dependent, though the velocities they admit are known by continuity.

    gamma4 Omega12 = gamma2 Omega14 - gamma1 Omega24,  and so on for the pairs 13 and 23

are two conditions where gamma4 = 0, and three beside it.  Solved for other velocities, in normal
form, they have the divisor gamma1 in its place, and are good where that is not 0.  Which ones is
told by the velocities that are admissible beside the place; that these have a limit there, and it
is what the solution says, is looked at in numbers.

That is so on a group: its frame is good everywhere, so that it is the constraints that fail.  Where
coordinates that are carried along have a pole,

    du1/dt = x,    dv1/dt = y/sin(u1),    dtheta/dt = -n - y cot(u1),

rows are infinite, and what finite rates meet is the limit of the space that they span: y = 0 and
dtheta/dt + cos(u1) dv1/dt = -n.  It is looked at so near, in so many digits, that it is the limit
to the last digit of a double.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.declaration.system import System
from voronec.equations.definition import read
from voronec.equations.derivation import Derivation

__all__ = [
    "DIGITS",
    "are_dependent",
    "are_infinite",
    "has_limit",
    "next_places",
    "orthonormal_rows",
    "places_beside",
    "solution_rows",
]

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


DIGITS = 120
"""Of numbers in which infinite rows are looked at."""
NEXT = mpmath.mpf("1e-20")
"""So far beside a place that is: at two poles at once rows are the inverse of its square."""
SAME = mpmath.mpf("1e-80")
"""A row that is, but for this part, a sum of others is dependent."""
INFINITE = 1e8
"""An entry of rows so many times the middle one is a division by zero."""


def are_infinite(rows: np.ndarray) -> bool:
    """Whether rows (m, N) of constraints divide by zero, but for rounding."""
    sizes = np.abs(rows[rows != 0])
    return bool(sizes.size and not sizes.max() < INFINITE * np.median(sizes))


def next_places(q: np.ndarray) -> list[list[Any]]:
    """Two places next to coordinates q (n,), on opposite sides, in mpmath's numbers."""
    dice = Random(0)
    ways = [NEXT * dice.uniform(0.5, 1) for _ in q]
    return [
        [mpmath.mpf(x) + sign * way for x, way in zip(q, ways, strict=True)] for sign in (1, -1)
    ]


def orthonormal_rows(rows: np.ndarray) -> np.ndarray:
    """Orthonormal rows that span what rows (m, N + 1) with offsets do, and zeros for those that
    depend on the others."""
    found: list[np.ndarray] = []
    for row in rows:
        rest = row / (mpmath.sqrt(row[:-1].dot(row[:-1])) or 1)
        for other in found:
            rest = rest - rest[:-1].dot(other[:-1]) * other
        size = mpmath.sqrt(rest[:-1].dot(rest[:-1]))
        found.append(rest / size if size > SAME else 0 * rest)
    return np.array(found)

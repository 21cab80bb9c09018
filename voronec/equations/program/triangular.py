"""Solving mass * vdot = force in straight-line code, without inverting anything symbolically.

The symmetric elimination M = L D L^T runs on names: what it computes becomes assignments.  Pivots
are chosen by structure (fewest neighbours first), so a diagonal matrix costs nothing, independent
blocks stay apart and a matrix of numbers folds into numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Any

import symengine as se

from voronec.errors import DefinitionError

__all__ = ["coupled_rows", "solve_symmetric"]

Name = Callable[[Any], Any]
"""Gives an expression a name (an assignment) and returns the name; numbers pass unchanged."""


def coupled_rows(matrix: Sequence[Sequence[Any]]) -> set[int]:
    """Rows of a symmetric matrix that hold an entry off the diagonal."""
    size = len(matrix)
    return {i for i in range(size) for j in range(size) if i != j and matrix[i][j] != 0}


def solve_symmetric(matrix: Sequence[Sequence[Any]], right: Sequence[Any], name: Name) -> list[Any]:
    """The solution x of matrix * x = right, as names, by L D L^T.

    The matrix is symmetric and positive definite (any order of pivots is then stable); a zero on
    the diagonal that is visible in the expressions is passed over by pivots of size two.  Raises
    ``DefinitionError`` where a row has nothing left to be solved for.
    """
    size = len(right)
    entries = {(i, j): matrix[i][j] for i in range(size) for j in range(i + 1) if matrix[i][j] != 0}
    rest, active = [name(r) for r in right], set(range(size))
    steps: list[tuple[tuple[int, ...], dict[Any, Any], dict[Any, Any]]] = []
    while active:
        pivot = _pivot(entries, active)
        active -= set(pivot)
        inverse = _inverse(entries, pivot, name)
        lower = {
            (j, p): name(se.Add(*[_at(entries, j, k) * inverse[k, p] for k in pivot]))
            for j in sorted(active)
            for p in pivot
            if any(_at(entries, j, k) != 0 for k in pivot)
        }
        _reduce(entries, rest, pivot, lower, name)
        steps.append((pivot, inverse, lower))
    solution: dict[int, Any] = {}
    for pivot, inverse, lower in reversed(steps):
        for p in pivot:
            terms = [inverse[p, k] * rest[k] for k in pivot]
            terms += [-factor * solution[j] for (j, k), factor in lower.items() if k == p]
            solution[p] = name(se.Add(*terms))
    return [solution[i] for i in range(size)]


def _at(entries: dict[tuple[int, int], Any], i: int, j: int) -> Any:
    return entries.get((max(i, j), min(i, j)), se.Integer(0))


def _pivot(entries: dict[tuple[int, int], Any], active: set[int]) -> tuple[int, ...]:
    """The row with the fewest neighbours; a pair where every diagonal entry is a plain zero."""
    order = sorted(active)
    degree = {i: sum(_at(entries, i, j) != 0 for j in order if j != i) for i in order}
    single = [i for i in order if _at(entries, i, i) != 0]
    if single:
        return (min(single, key=lambda i: degree[i]),)
    pairs = [p for p in combinations(order, 2) if _at(entries, *p) != 0]
    if not pairs:
        raise DefinitionError(
            "the mass matrix is singular: after elimination nothing is left in row "
            f"{order[0] + 1}; give that velocity inertia, or remove it"
        )
    return min(pairs, key=lambda p: degree[p[0]] + degree[p[1]])


def _inverse(
    entries: dict[tuple[int, int], Any], pivot: tuple[int, ...], name: Name
) -> dict[tuple[int, int], Any]:
    if len(pivot) == 1:
        p = pivot[0]
        return {(p, p): name(1 / entries[p, p])}
    p, q = pivot  # both diagonal entries are zero: the inverse is off the diagonal, too
    reciprocal = name(1 / _at(entries, p, q))
    zero = se.Integer(0)
    return {(p, p): zero, (q, q): zero, (p, q): reciprocal, (q, p): reciprocal}


def _reduce(
    entries: dict[tuple[int, int], Any],
    rest: list[Any],
    pivot: tuple[int, ...],
    lower: dict[tuple[int, int], Any],
    name: Name,
) -> None:
    """The Schur complement and the forward substitution for one pivot."""
    rows = sorted({j for j, _ in lower})
    for j in rows:
        for k in (k for k in rows if k <= j):
            change = se.Add(*[lower[j, p] * _at(entries, k, p) for p in pivot])
            if change != 0:
                entries[j, k] = name(_at(entries, j, k) - change)
        rest[j] = name(rest[j] - se.Add(*[lower[j, p] * rest[p] for p in pivot]))

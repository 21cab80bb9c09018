"""Sparse elimination of linear equations whose coefficients are expression graphs.

Nothing is expanded.  Every entry is shadowed by its value at a generic point in ball arithmetic:
a ball that excludes zero proves a pivot; an entry whose ball holds zero is settled by a normal
form before it is dropped.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import decide_zero
from voronec.errors import EngineLimit


@dataclass(frozen=True)
class LinearSolution:
    """The outcome of an elimination of rows * x = right.

    ``values[j][c]`` solves for unknown j and column c of the right side; ``free`` are the unknowns
    left undetermined; ``dependent`` the rows that reduce to zero; ``contradictory`` the rows that
    reduce to 0 = something.
    """

    values: list[list[Any]]
    free: tuple[int, ...]
    dependent: tuple[int, ...]
    contradictory: tuple[int, ...]


@dataclass
class _Row:
    label: int
    left: dict[int, Any]
    right: dict[int, Any]
    shadow_left: dict[int, Any]
    shadow_right: dict[int, Any]
    near_left: dict[int, Any]


def independent_columns(
    rows: Sequence[Sequence[Any]], order: Iterable[int], relations: Sequence[Any] = ()
) -> list[int]:
    """As many columns as there are rows, where so many are independent: the first of an order."""
    chosen: list[int] = []
    for j in order:
        trial = [*chosen, j]
        columns = [[row[i] for i in trial] for row in rows]
        if not solve_linear(columns, [[se.Integer(0)]] * len(columns), relations).free:
            chosen = trial
        if len(chosen) == len(rows):
            break
    return sorted(chosen)


def null_vectors(
    rows: Sequence[Sequence[Any]], bound: Sequence[int], relations: Sequence[Any] = ()
) -> list[list[Any]]:
    """Vectors w that span rows * w = 0, a unit vector each in all but the ``bound`` columns, which
    are independent."""
    size = range(len(rows[0]))
    free = [j for j in size if j not in bound]
    left = [[row[j] for j in bound] for row in rows]
    right = [[-row[j] for j in free] for row in rows]
    solved = solve_linear(left, right, relations).values
    vectors = [[se.Integer(int(i == j)) for i in size] for j in free]
    for k, vector in enumerate(vectors):
        for i, values in zip(bound, solved, strict=True):
            vector[i] = values[k]
    return vectors


def solve_linear(
    rows: Sequence[Sequence[Any]],
    right: Sequence[Sequence[Any]],
    relations: Sequence[Any] = (),
    prefer: int = 0,
    near: Mapping[str, Any] | None = None,
) -> LinearSolution:
    """Solve rows * x = right exactly, for any number of right sides; rows may be redundant.

    The first ``prefer`` rows are used before the others, so that what reduces to zero is, where
    possible, one of the others.  Pivots that do not vanish at the point ``near`` (numbers by name)
    are preferred, so that the solution is defined there too.
    """
    unknowns = len(rows[0]) if rows else 0
    work = _shadow_rows(rows, right, relations, near)
    done: list[tuple[int, _Row]] = []
    while True:
        choice = _pivot(work, prefer)
        if choice is None:
            break
        row, column = choice
        work.remove(row)
        for other in work:
            if column in other.left:
                _subtract(other, row, column, relations)
        done.append((column, row))
    dependent: list[int] = []
    contradictory: list[int] = []
    for row in work:
        _settle(row.left, row.shadow_left, relations)
        _settle(row.right, row.shadow_right, relations)
        (contradictory if row.right else dependent).append(row.label)
    pivots = {column for column, _ in done}
    free = tuple(j for j in range(unknowns) if j not in pivots)
    width = len(right[0]) if right else 0
    return LinearSolution(
        _back_substitute(done, unknowns, width), free, tuple(dependent), tuple(contradictory)
    )


def _shadow_rows(
    rows: Sequence[Sequence[Any]],
    right: Sequence[Sequence[Any]],
    relations: Sequence[Any],
    near: Mapping[str, Any] | None,
) -> list[_Row]:
    entries = [e for row in rows for e in row] + [e for row in right for e in row]
    tape = Tape(entries)
    samples = sample_evaluable(tape, relations, GENERIC, count=1)
    if not samples:
        raise EngineLimit("no point was found at which the linear equations have real values")
    point, shadows = samples[0]
    width = len(rows[0]) if rows else 0
    wide = len(right[0]) if right else 0
    at_near = shadows
    if near is not None:
        at_near = tape.arb({a: near.get(str(a), value) for a, value in point.items()}, GENERIC)
    border = len(rows) * width
    return [
        _Row(
            i,
            {j: e for j, e in enumerate(rows[i]) if e != 0},
            {c: e for c, e in enumerate(right[i]) if e != 0},
            dict(enumerate(shadows[i * width : (i + 1) * width])),
            dict(enumerate(shadows[border + i * wide : border + (i + 1) * wide])),
            dict(enumerate(at_near[i * width : (i + 1) * width])),
        )
        for i in range(len(rows))
    ]


def _pivot(work: list[_Row], prefer: int) -> tuple[_Row, int] | None:
    """The provably nonzero entry with the least fill-in (Markowitz), the simplest of those."""
    counts: dict[int, int] = {}
    for row in work:
        for j in row.left:
            counts[j] = counts.get(j, 0) + 1
    best, best_cost = None, None
    for row in work:
        for j, entry in row.left.items():
            if row.shadow_left[j].contains(0):
                continue
            fill = (len(row.left) - 1) * (counts[j] - 1)
            lost = row.near_left[j].contains(0)  # true also where the value is not finite
            cost = (row.label >= prefer, lost, fill, not entry.is_Number, len(entry.args))
            if best_cost is None or cost < best_cost:
                best, best_cost = (row, j), cost
    return best


def _subtract(target: _Row, pivot: _Row, column: int, relations: Sequence[Any]) -> None:
    """target -= (target[column]/pivot[column]) * pivot."""
    factor = target.left[column] / pivot.left[column]
    shadow = target.shadow_left[column] / pivot.shadow_left[column]
    del target.left[column]
    target.shadow_left[column] = shadow * 0
    at_near = target.near_left[column] / pivot.near_left[column]
    for j in pivot.left:
        target.near_left[j] = target.near_left[j] - at_near * pivot.near_left[j]
    for into, shadows, source, source_shadows in (
        (target.left, target.shadow_left, pivot.left, pivot.shadow_left),
        (target.right, target.shadow_right, pivot.right, pivot.shadow_right),
    ):
        for j, entry in source.items():
            if j == column and source is pivot.left:
                continue
            into[j] = into.get(j, se.Integer(0)) - factor * entry
            shadows[j] = shadows[j] - shadow * source_shadows[j]
            if into[j] == 0:
                del into[j]
    _settle(target.left, target.shadow_left, relations)


def _settle(entries: dict[int, Any], shadows: dict[int, Any], relations: Sequence[Any]) -> None:
    """Drop the entries that are proved to vanish."""
    for j in [j for j in entries if shadows[j].contains(0)]:
        verdict = decide_zero(entries[j], relations)
        if verdict.proved:
            del entries[j]
        elif verdict.undecided:
            raise EngineLimit(f"whether '{_short(entries[j])}' vanishes is undecided")


def _short(expr: Any) -> str:
    text = str(expr)
    return text if len(text) < 60 else text[:57] + "..."


def _back_substitute(done: list[tuple[int, _Row]], unknowns: int, width: int) -> list[list[Any]]:
    values = [[se.Integer(0)] * width for _ in range(unknowns)]
    for column, row in reversed(done):
        pivot = row.left[column]
        for c in range(width):
            total = row.right.get(c, se.Integer(0))
            for j, entry in row.left.items():
                if j != column and values[j][c] != 0:
                    total = total - entry * values[j][c]
            values[column][c] = total / pivot
    return values

"""Linear systems whose rank is found on the way, in mpmath at the working precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mpmath as mp

__all__ = ["Elimination", "eliminate", "negligible"]

Vector = list[Any]


@dataclass(frozen=True)
class Elimination:
    """What Gauss-Jordan elimination of A x = b found.

    ``pivots`` are (row, column) pairs: these rows are independent.  ``leftover`` maps every other
    row to what remains of its right side, which is zero where the system is consistent.
    ``solution`` has zeros in the ``free`` columns; ``kernel`` has a vector for each free column.
    ``size`` is the largest right side; rows were divided by their largest coefficient.
    """

    pivots: tuple[tuple[int, int], ...]
    leftover: dict[int, Any]
    free: tuple[int, ...]
    solution: Vector
    kernel: tuple[Vector, ...]
    size: Any

    @property
    def independent(self) -> list[int]:
        """The rows that carry a pivot, in their order."""
        return sorted(row for row, _ in self.pivots)


def negligible() -> Any:
    """Where a pivot counts as zero: half the working digits, relative to its row."""
    return mp.mpf(10) ** (-mp.mp.dps // 2)


def eliminate(
    matrix: Sequence[Vector],
    right: Vector,
    width: int,
    first: int | None = None,
) -> Elimination:
    """Solve A x = b with the largest pivot of all, A having ``width`` columns.

    The ``first`` rows are used up before later ones are touched: so rows that hold exactly come
    before rows that hold to the accuracy of somebody's numbers.
    """
    rows = _scale_rows(matrix, right)
    count = len(rows)
    groups = [range(count)] if first is None else [range(first), range(first, count)]
    size = max((abs(row[-1]) for row in rows), default=mp.mpf(0))
    tiny = negligible()
    pivots: list[tuple[int, int]] = []
    columns = list(range(width))
    for group in groups:
        open_rows = list(group)
        while open_rows and columns:
            largest, r, c = max((abs(rows[r][c]), -r, -c) for r in open_rows for c in columns)
            if largest <= tiny:
                break
            r, c = -r, -c
            pivots.append((r, c))
            open_rows.remove(r)
            columns.remove(c)
            _clear(rows, r, c)
    solution = [mp.mpf(0)] * width
    kernel = [[mp.mpf(int(c == f)) for c in range(width)] for f in columns]
    for r, c in pivots:
        solution[c] = rows[r][-1]
        for vector, f in zip(kernel, columns, strict=True):
            vector[c] = -rows[r][f]
    used = {r for r, _ in pivots}
    leftover = {r: rows[r][-1] for r in range(count) if r not in used}
    return Elimination(tuple(pivots), leftover, tuple(columns), solution, tuple(kernel), size)


def _scale_rows(matrix: Sequence[Vector], right: Vector) -> list[Vector]:
    """Augmented rows, each divided by its largest coefficient unless all of them are noise."""
    sizes = [max(map(abs, row), default=mp.mpf(0)) for row in matrix]
    largest = max(sizes, default=mp.mpf(0)) or mp.mpf(1)
    floor = largest * negligible()
    scales = [size if size > floor else largest for size in sizes]
    return [
        [entry / scale for entry in (*row, b)]
        for row, b, scale in zip(matrix, right, scales, strict=True)
    ]


def _clear(rows: list[Vector], pivot_row: int, column: int) -> None:
    """Make the pivot 1 and everything else in its column 0."""
    pivot = rows[pivot_row][column]
    base = rows[pivot_row] = [entry / pivot if entry else entry for entry in rows[pivot_row]]
    filled = [j for j, entry in enumerate(base) if entry]
    for index, row in enumerate(rows):
        factor = row[column]
        if index == pivot_row or not factor:
            continue
        for j in filled:
            row[j] -= factor * base[j]
        row[column] = mp.mpf(0)

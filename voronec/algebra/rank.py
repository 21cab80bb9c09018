"""Ranks by elimination in ball arithmetic, at a point or a generic one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import flint

from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC, SHARP
from voronec.algebra.tape import Tape
from voronec.errors import EngineLimit


def generic_rank(rows: Sequence[Sequence[Any]], relations: Sequence[Any] = ()) -> int:
    """The rank where relations vanish, at a generic point: the largest proved one among several.

    Raises ``EngineLimit`` where no point is found at which all entries have real values.
    """
    width = len(rows[0]) if rows else 0
    entries = [e for row in rows for e in row]
    if not entries:
        return 0
    samples = sample_evaluable(Tape(entries), relations, SHARP)
    if not samples:
        raise EngineLimit("no point was found at which all entries of a matrix have real values")
    tables = ([v[i : i + width] for i in range(0, len(v), width)] for _, v in samples)
    return max((proved_rank(table, SHARP) for table in tables), default=0)


def generic_rows(
    rows: Sequence[Sequence[Any]],
    relations: Sequence[Any] = (),
    bits: int = GENERIC,
    failure: str = "no point was found at which all entries of a matrix have real values",
) -> list[int]:
    """The positions of rows of expressions that, one after the other, enlarge the span of those
    before them, at a generic point where relations vanish, in balls of ``bits``.

    Raises ``EngineLimit`` with the text ``failure`` where no point is found.
    """
    if not rows or not rows[0]:
        return []
    tape, width = Tape([e for row in rows for e in row]), len(rows[0])
    for _, values in sample_evaluable(tape, relations, bits, count=1):
        return independent_rows([values[i : i + width] for i in range(0, len(values), width)], bits)
    raise EngineLimit(failure)


def independent_rows(rows: Sequence[Sequence[Any]], bits: int) -> list[int]:
    """The rows that, one after the other, enlarge the span of those before them.

    Entries are balls; one that holds zero is not taken for a pivot, so what is returned is
    independent, and the rest is so only as far as the precision tells.
    """
    kept: list[int] = []
    reduced: list[tuple[int, list[Any]]] = []
    with flint.ctx.workprec(bits):
        for index, given in enumerate(rows):
            row = list(given)
            for pivot, other in reduced:
                factor = row[pivot] / other[pivot]
                row = [a - factor * b for a, b in zip(row, other, strict=True)]
                row[pivot] = flint.arb(0)
            sizes = [0.0 if e.contains(0) else abs(float(e.mid())) for e in row]
            best = max(range(len(row)), key=sizes.__getitem__, default=-1)
            if best >= 0 and sizes[best] > 0:
                reduced.append((best, row))
                kept.append(index)
    return kept


def proved_rank(rows: Sequence[Sequence[Any]], bits: int) -> int:
    """A lower bound for the rank, which is the rank at a generic point."""
    return len(independent_rows(rows, bits))

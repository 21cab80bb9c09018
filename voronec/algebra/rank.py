"""Ranks at a point, by elimination in ball arithmetic: every pivot is proved to be nonzero."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import flint

__all__ = ["independent_rows", "proved_rank"]


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

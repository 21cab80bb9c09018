"""Ranks of matrices of expressions at generic points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from voronec.algebra.points import sample_evaluable
from voronec.algebra.rank import proved_rank
from voronec.algebra.tape import Tape
from voronec.errors import EngineLimit

__all__ = ["generic_rank"]

BITS = 256


def generic_rank(rows: Sequence[Sequence[Any]], relations: Sequence[Any] = ()) -> int:
    """The rank where relations vanish, at a generic point: the largest proved one among several.

    Raises ``EngineLimit`` where no point is found at which all entries have real values.
    """
    width = len(rows[0]) if rows else 0
    entries = [e for row in rows for e in row]
    if not entries:
        return 0
    samples = sample_evaluable(Tape(entries), relations, BITS)
    if not samples:
        raise EngineLimit("no point was found at which all entries of a matrix have real values")
    tables = ([v[i : i + width] for i in range(0, len(v), width)] for _, v in samples)
    return max((proved_rank(table, BITS) for table in tables), default=0)

"""Determinants of matrices of expression graphs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import symengine as se

__all__ = ["determinant"]


def determinant(rows: Sequence[Sequence[Any]]) -> Any:
    """The determinant without a division: expansion by rows, each minor made once."""
    minors: dict[tuple[int, ...], Any] = {(): se.Integer(1)}
    for row in rows:
        wider: dict[tuple[int, ...], list[Any]] = {}
        for columns, minor in minors.items():
            for j, entry in enumerate(row):
                if j not in columns and entry != 0 and minor != 0:
                    chosen = tuple(sorted((*columns, j)))
                    sign = (-1) ** (len(chosen) - 1 - chosen.index(j))
                    wider.setdefault(chosen, []).append(sign * entry * minor)
        minors = {columns: se.Add(*terms) for columns, terms in wider.items()}
    return minors.get(tuple(range(len(rows))), se.Integer(0))

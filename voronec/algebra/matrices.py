"""Vectors and matrices of expression graphs: scalar products, determinants, products recognised."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import symengine as se

from voronec.algebra.normal import canonical
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.tape import Tape
from voronec.errors import EngineLimit


def change_entries(
    change: Callable[[Sequence[Any]], Iterable[Any]], rows: Sequence[Sequence[Any]]
) -> list[list[Any]]:
    """Rows with all of their entries changed together, as normal forms take them."""
    flat = iter(change([e for row in rows for e in row]) if rows else ())
    return [[next(flat) for _ in row] for row in rows]


def dot(one: Sequence[Any], other: Sequence[Any]) -> Any:
    """The scalar product of two vectors of one length."""
    return se.Add(*[a * b for a, b in zip(one, other, strict=True)])


def is_product(
    column: Sequence[Any],
    matrix: Sequence[Sequence[Any]],
    vector: Sequence[Any],
    relations: Sequence[Any],
) -> bool:
    """Whether a column is proved to be matrix . vector; most that are not fail at one point."""
    pairs = zip(column, matrix, strict=True)
    differences = [c - se.Add(*map(se.Mul, row, vector)) for c, row in pairs]
    for _, values in sample_evaluable(Tape(differences), relations, GENERIC, count=1):
        if any(not value.contains(0) for value in values):
            return False
    try:
        return all(e == 0 for e in canonical(differences, relations))
    except EngineLimit:
        return False


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

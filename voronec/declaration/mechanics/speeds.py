"""Generalized speeds in terms of the rates of coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.normal import shortest
from voronec.algebra.rank import generic_rows
from voronec.errors import DefinitionError, EngineLimit

__all__ = ["Speeds", "constraint_columns", "constraint_rows", "solve_speeds"]


@dataclass(frozen=True)
class Speeds:
    """What each speed is in terms of the rates; what else the kinematic equations demand.

    ``unplaced`` are the positions of speeds that no coordinate belongs to: each is the rate of a
    coordinate of its own.
    """

    values: tuple[Any, ...]
    left_over: tuple[Any, ...]
    unplaced: tuple[int, ...]


def constraint_rows(rows: Sequence[Sequence[Any]], relations: Sequence[Any] = ()) -> list[int]:
    """The rows that, one after the other, enlarge the span of those before, at a generic point:
    where relations vanish, or anywhere, if no point is found there."""
    failure = "no point was found at which the constraints of a model have values"
    try:
        return generic_rows(rows, relations, failure=failure)
    except EngineLimit:
        return generic_rows(rows, failure=failure)


def constraint_columns(rows: Sequence[Sequence[Any]], relations: Sequence[Any] = ()) -> list[int]:
    """The columns that, one after the other, enlarge the span of those before."""
    return constraint_rows([*zip(*rows, strict=True)], relations) if rows else []


def solve_speeds(
    equations: Sequence[Any], speeds: Sequence[Any], dots: Sequence[Any], fresh: Sequence[Any]
) -> Speeds:
    """Solve kinematic equations for the speeds; ``fresh[j]`` is the rate of the coordinate that
    speed j gets where no other belongs to it."""
    rows = [[e.diff(u) for u in speeds] for e in equations]
    moving = {*speeds, *dots}
    for row, equation in zip(rows, equations, strict=True):
        if any(e.free_symbols & moving for e in row):
            raise DefinitionError(
                f"from_mechanics: the kinematic equation {equation} = 0 is not linear in the "
                "speeds; solve it for the rates first"
            )
    kept = constraint_rows(rows)
    columns = constraint_columns([rows[i] for i in kept])
    unplaced = [j for j in range(len(speeds)) if j not in columns]
    at_rest = dict.fromkeys(speeds, se.Integer(0))
    left = [rows[i] for i in kept]
    right = [[-equations[i].xreplace(at_rest)] for i in kept]
    for j in unplaced:
        left.append([se.Integer(int(k == j)) for k in range(len(speeds))])
        right.append([fresh[j]])
    values = tuple(v[0] for v in solve_linear(left, right).values) if left else ()
    if any(e.free_symbols for row in left for e in row):
        values = _tidy(values)
    meaning = dict(zip(speeds, values, strict=True))
    rest = (equations[i].xreplace(meaning) for i in range(len(equations)) if i not in kept)
    return Speeds(values, tuple(rest), tuple(unplaced))


def _tidy(values: Sequence[Any]) -> tuple[Any, ...]:
    """In the shortest form, where that is within the budget: pivots that vanish somewhere, as the
    cosine of a yaw, are in vain in most of what they divide."""
    try:
        return tuple(shortest(values))
    except EngineLimit:
        return tuple(values)

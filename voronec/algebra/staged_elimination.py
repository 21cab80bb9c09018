"""Elimination of linear equations on named stages, kept so that right sides can come later."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import flint
import symengine as se

from voronec.algebra.points import sample_evaluable
from voronec.algebra.stages import ZERO, Stages, linear_combination
from voronec.algebra.tape import Tape
from voronec.errors import EngineLimit

__all__ = ["StagedElimination"]

BITS = 192


class StagedElimination:
    """rows * x = right with a row for each unknown or more; rows to spare must be dependent.

    A pivot is an entry that ball arithmetic proves nonzero at a generic point of the relations.
    Raises ``EngineLimit`` where an unknown is left without a pivot.
    """

    def __init__(
        self, stages: Stages, rows: Sequence[Mapping[int, Any]], unknowns: int, relations: Any
    ) -> None:
        self._stages = stages
        self._left = [dict(row) for row in rows]
        self._steps: list[tuple[int, int, Any]] = []
        self._pivots: list[tuple[int, int]] = []
        shadows = self._shadows(relations)
        open_rows = list(range(len(rows)))
        with flint.ctx.workprec(BITS):
            while (choice := self._choice(open_rows, shadows)) is not None:
                self._pivots.append(choice)
                open_rows.remove(choice[0])
                for row in open_rows:
                    if choice[1] in self._left[row]:
                        self._subtract(row, *choice, shadows)
        if len(self._pivots) < unknowns:
            raise EngineLimit("the velocities are not determined stage by stage")

    def solve(self, right: Sequence[Any]) -> list[Any]:
        """The unknowns for right sides, in the order of the unknowns."""
        rest = list(right)
        for target, source, factor in self._steps:
            if rest[source] != 0:
                rest[target] = self._stages.name(rest[target] - factor * rest[source])
        values: dict[int, Any] = {}
        for row, column in reversed(self._pivots):
            left = self._left[row]
            known = linear_combination((e, values[j]) for j, e in left.items() if j != column)
            values[column] = self._stages.name(self._stages.name(rest[row] - known) / left[column])
        return [values[j] for j in sorted(values)]

    def _shadows(self, relations: Any) -> list[dict[int, Any]]:
        entries = [e for row in self._left for e in row.values()]
        definitions = self._stages.definitions
        atoms = Tape([*definitions.values(), *entries]).atoms
        free = [a for a in atoms if a not in definitions]
        for point, _ in sample_evaluable(Tape(free), relations, BITS):
            values = iter(self._stages.at(point, entries, BITS))
            shadows = [{j: next(values) for j in row} for row in self._left]
            if all(s.is_finite() for row in shadows for s in row.values()):
                return shadows
        raise EngineLimit("no point was found at which the linear equations have real values")

    def _choice(self, rows: Sequence[int], shadows: Any) -> tuple[int, int] | None:
        """Least fill-in (Markowitz), numbers first, then the shortest entry."""
        counts: dict[int, int] = {}
        for row in rows:
            for j in self._left[row]:
                counts[j] = counts.get(j, 0) + 1
        candidates = [
            ((len(self._left[row]) - 1) * (counts[j] - 1), not e.is_Number, len(str(e)), row, j)
            for row in rows
            for j, e in self._left[row].items()
            if not shadows[row][j].contains(0)
        ]
        return min(candidates)[-2:] if candidates else None

    def _subtract(self, target: int, source: int, column: int, shadows: Any) -> None:
        left, shadow = self._left[target], shadows[target]
        factor = self._stages.name(left.pop(column) / self._left[source][column])
        ratio = shadow.pop(column) / shadows[source][column]
        for j, entry in self._left[source].items():
            if j != column:
                left[j] = self._stages.name(left.get(j, ZERO) - factor * entry)
                shadow[j] = shadow.get(j, flint.arb(0)) - ratio * shadows[source][j]
                if left[j] == 0:
                    del left[j], shadow[j]
        if factor != se.Integer(0):
            self._steps.append((target, source, factor))

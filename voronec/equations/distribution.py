"""The distribution spanned by the horizontal fields: how it grows under brackets.

D_1 = span(h_i),  D_(m+1) = D_m + [D_1, D_m].  The dimensions at a generic point form the growth
vector.  What of the constraints integrates stands in ``integrable``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.precision import BRACKETS
from voronec.algebra.rank import generic_rows
from voronec.algebra.tape import Tape
from voronec.algebra.terms import atoms
from voronec.equations.connection import EhresmannConnection
from voronec.equations.definition import Definition
from voronec.equations.flags import flag
from voronec.errors import EngineLimit

__all__ = ["Distribution", "Space", "grow"]

Field = tuple[Any, ...]
NODES = 15_000
"""Fields of more nodes are not bracketed again: symengine would not come to an end."""


@dataclass(frozen=True)
class Distribution:
    """How the distribution of the constraints grows.

    ``growth``: dimensions of D_1, D_2, ... until they stay.  ``dimension``: of the space;
    ``timed``: whether the time is one of its coordinates, as it is where the constraints move or
    are affine.  ``cut``: whether further brackets were too large to be made, so that the growth may
    go on.
    """

    growth: tuple[int, ...]
    dimension: int
    timed: bool
    cut: bool = False


def grow(
    definition: Definition, raw: EhresmannConnection, exact: Callable[[], EhresmannConnection]
) -> Distribution:
    """The growth vector at a generic point.

    ``raw`` is the connection as it was derived, ``exact`` makes its normal form: brackets are made
    of it where residues do not serve.
    """
    timed = _uses_time(definition, raw)
    space, ranks = Space(raw, timed), _RankOracle(definition.relations)
    dimension = space.dimension
    if raw.group is None:
        dimension -= ranks.relations(raw.coordinates)
    if not definition.relations:
        with suppress(EngineLimit):
            return Distribution(space.flag(dimension), dimension, timed)
    growth, cut = _bracket(Space(exact(), timed), ranks, dimension)
    return Distribution(growth, dimension, timed, cut)


def _bracket(space: Space, ranks: _RankOracle, dimension: int) -> tuple[tuple[int, ...], bool]:
    """How brackets of brackets grow, until they bring nothing new; and whether they became too
    large before."""
    fields = space.fields
    frame, tops, growth = list(fields), list(fields), [len(fields)]
    while tops and growth[-1] < dimension:
        if Tape([e for field in tops for e in field]).size > NODES:
            return tuple(growth), True
        brackets = [
            space.bracket(x, y)
            for i, x in enumerate(fields)
            for j, y in enumerate(tops)
            if len(growth) > 1 or i < j
        ]
        tops = ranks.enlarge(frame, [b for b in brackets if any(e != 0 for e in b)])
        if tops:
            frame += tops
            growth.append(len(frame))
    return tuple(growth), False


def _uses_time(definition: Definition, connection: EhresmannConnection) -> bool:
    entries = [e for row in connection.lift for e in row]
    affine = any(row[-1] != 0 for row in connection.lift)
    return affine or definition.time in atoms(entries, se.Symbol)


@dataclass(frozen=True)
class Space:
    """Where the fields live: along the coordinates, or the fields of a group, and the time."""

    connection: EhresmannConnection
    timed: bool

    @property
    def dimension(self) -> int:
        """The number of components of a field."""
        return len(self.connection.lift) + int(self.timed)

    @property
    def fields(self) -> list[Field]:
        """The horizontal fields; with the time, that of motions at rest is the last."""
        columns = [*zip(*self.connection.lift, strict=True)]
        if not self.timed:
            return columns[:-1]
        return [(*c, se.Integer(int(i == self.connection.n))) for i, c in enumerate(columns)]

    @property
    def variables(self) -> tuple[Any, ...]:
        """The coordinates, and the time where it is one."""
        connection = self.connection
        return (*connection.coordinates, *((connection.time,) if self.timed else ()))

    def flag(self, full: int) -> tuple[int, ...]:
        """The growth vector, from residues."""
        return flag(self.fields, self.fields, self.bracket, self.rates, self.variables, full)

    def bracket(self, x: Field, y: Field) -> Field:
        """[x, y]."""
        moved = tuple(self._along(x, b) - self._along(y, a) for a, b in zip(x, y, strict=True))
        group = self.connection.group
        if group is None:
            return moved
        turned = group.bracket(x[: len(group.velocities)], y[: len(group.velocities)])
        turned += [se.Integer(0)] * int(self.timed)
        return tuple(m + t for m, t in zip(moved, turned, strict=True))

    def rates(self, field: Field) -> list[Any]:
        """Those of the variables along a field."""
        group = self.connection.group
        if group is None:
            return list(field)
        rates = group.coordinate_rates(field[: len(group.velocities)])
        return rates + [field[-1]] * int(self.timed)

    def _along(self, field: Field, function: Any) -> Any:
        terms = [
            rate * function.diff(q)
            for rate, q in zip(self.rates(field), self.variables, strict=True)
            if rate != 0
        ]
        return se.Add(*terms) if terms else se.Integer(0)


class _RankOracle:
    """Ranks at a generic point, by elimination in ball arithmetic."""

    def __init__(self, relations: Sequence[Any]) -> None:
        self._relations = relations

    def relations(self, variables: Sequence[Any]) -> int:
        """How many of the relations are independent."""
        if not self._relations:
            return 0
        return len(self._independent([[r.diff(q) for q in variables] for r in self._relations]))

    def enlarge(self, frame: Sequence[Field], candidates: Sequence[Field]) -> list[Field]:
        """The candidates that, one after the other, enlarge the span of the frame."""
        kept = self._independent([*frame, *candidates])
        return [candidates[i - len(frame)] for i in kept if i >= len(frame)]

    def _independent(self, rows: Sequence[Sequence[Any]]) -> list[int]:
        failure = "no point was found at which the distribution is defined"
        return generic_rows(rows, self._relations, BRACKETS, failure)

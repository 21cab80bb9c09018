"""The distribution spanned by the horizontal fields: how it grows under brackets.

D_1 = span(h_i),  D_(m+1) = D_m + [D_1, D_m].  The dimensions at a generic point form the growth
vector.  What of the constraints integrates stands in ``integrable``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.precision import BRACKETS
from voronec.algebra.rank import generic_rows
from voronec.algebra.tape import Tape
from voronec.equations.connection import EhresmannConnection
from voronec.equations.definition import Definition
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
    go on.  ``closed``: whether it is proved that the growth ends below the dimension.
    """

    growth: tuple[int, ...]
    dimension: int
    timed: bool
    cut: bool = False
    closed: bool = False


def grow(definition: Definition, connection: EhresmannConnection) -> Distribution:
    """The growth vector at a generic point."""
    n = connection.n
    timed = _uses_time(definition, connection)
    space = Space(connection, timed)
    fields = [_field(connection, i, timed) for i in range(n + 1 if timed else n)]
    frame, tops, growth = list(fields), list(fields), [len(fields)]
    rank_of = _RankOracle(definition.relations)
    dimension = space.dimension
    if connection.group is None:
        dimension -= rank_of.relations(connection.coordinates)
    cut = closed = False
    while tops and growth[-1] < dimension:
        cut = Tape([e for field in tops for e in field]).size > NODES
        if cut:
            break
        brackets = [
            space.bracket(x, y)
            for i, x in enumerate(fields)
            for j, y in enumerate(tops)
            if len(growth) > 1 or i < j
        ]
        brackets = [b for b in brackets if any(e != 0 for e in b)]
        tops = rank_of.enlarge(frame, brackets)
        if not tops:
            closed = _is_spanned(brackets, frame, definition.relations)
            break
        frame += tops
        growth.append(len(frame))
    return Distribution(
        growth=tuple(growth),
        dimension=dimension,
        timed=timed,
        cut=cut,
        closed=closed,
    )


def _is_spanned(fields: Sequence[Field], frame: Sequence[Field], relations: Sequence[Any]) -> bool:
    """Whether normal forms prove that fields are combinations of a frame."""
    if not fields:
        return True
    rows, right = ([list(r) for r in zip(*some, strict=True)] for some in (frame, fields))
    try:
        return not solve_linear(rows, right, relations).contradictory
    except EngineLimit:
        return False


def _uses_time(definition: Definition, connection: EhresmannConnection) -> bool:
    time = definition.time
    moving = any(se.has_symbol(e, time) for row in connection.lift for e in row)
    return moving or any(row[-1] != 0 for row in connection.lift)


def _field(connection: EhresmannConnection, i: int, timed: bool) -> Field:
    column = [row[i] for row in connection.lift]
    return (*column, se.Integer(int(i == connection.n))) if timed else tuple(column)


@dataclass(frozen=True)
class Space:
    """Where the fields live: along the coordinates, or the fields of a group, and the time."""

    connection: EhresmannConnection
    timed: bool

    @property
    def dimension(self) -> int:
        """The number of components of a field."""
        return len(self.connection.lift) + int(self.timed)

    def bracket(self, x: Field, y: Field) -> Field:
        """[x, y]."""
        moved = tuple(self._along(x, b) - self._along(y, a) for a, b in zip(x, y, strict=True))
        group = self.connection.group
        if group is None:
            return moved
        turned = group.bracket(x[: len(group.velocities)], y[: len(group.velocities)])
        turned += [se.Integer(0)] * int(self.timed)
        return tuple(m + t for m, t in zip(moved, turned, strict=True))

    def _along(self, field: Field, function: Any) -> Any:
        coordinates, group = self.connection.coordinates, self.connection.group
        rates = list(
            field if group is None else group.coordinate_rates(field[: len(group.velocities)])
        )
        variables = list(coordinates)
        if self.timed:
            variables.append(self.connection.time)
            rates += [field[-1]] if group is not None else []
        terms = [f * function.diff(q) for f, q in zip(rates, variables, strict=True) if f != 0]
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

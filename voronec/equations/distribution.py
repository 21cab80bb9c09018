"""The distribution spanned by the horizontal fields: how it grows under brackets.

D_1 = span(h_i),  D_(m+1) = D_m + [D_1, D_m].  The dimensions at a generic point form the growth
vector.  What of the constraints integrates stands in ``integrable``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
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
    timed, relations = _uses_time(definition, raw), definition.relations
    space = FieldSpace(raw, timed)
    dimension = space.dimension
    if raw.group is None and relations:
        slopes = [[r.diff(q) for q in raw.coordinates] for r in relations]
        dimension -= len(generic_rows(slopes, relations, BRACKETS))
    if not relations:
        with suppress(EngineLimit):
            return Distribution(space.flag(dimension), dimension, timed)
    space = FieldSpace(exact(), timed)
    independent = partial(generic_rows, relations=relations, bits=BRACKETS)
    closure = close_under_brackets(
        space.fields, space.fields, space.bracket, independent, dimension
    )
    return Distribution(closure.growth, dimension, timed, closure.made is None)


@dataclass(frozen=True)
class BracketClosure:
    """Fields ``frame`` that span D_1, D_2, ... one after the other, ``growth`` of each; the
    brackets ``made`` last, none of which enlarge the span where it ends below all dimensions, and
    None where they would be too large."""

    frame: list[Field]
    growth: tuple[int, ...]
    made: list[Field] | None


def close_under_brackets(
    fields: Sequence[Field],
    start: Sequence[Field],
    bracket: Callable[[Field, Field], Field],
    independent: Callable[[Sequence[Field]], list[int]],
    full: int,
) -> BracketClosure:
    """D_1, spanned by ``start``, and D_(m+1) = D_m + [fields, D_m], by brackets of brackets, until
    they bring nothing new or span ``full`` dimensions; ``independent`` are the rows that enlarge
    the span of those before them."""
    frame = tops = [start[i] for i in independent(start)]
    growth, made = [len(frame)], list[Field]()
    while tops and growth[-1] < full:
        if Tape([e for field in tops for e in field]).size > NODES:
            return BracketClosure(frame, tuple(growth), None)
        brackets = [bracket(x, y) for x in fields for y in tops]
        made = [b for b in brackets if any(e != 0 for e in b)]
        new = independent([*frame, *made])[len(frame) :]
        tops = [made[i - len(frame)] for i in new]
        frame = [*frame, *tops]
        growth += [len(frame)] if tops else []
    return BracketClosure(frame, tuple(growth), made)


def along(rates: Sequence[Any], function: Any, variables: Sequence[Any]) -> Any:
    """The derivative of a function along a field that gives rates to variables."""
    pairs = zip(rates, variables, strict=True)
    return se.Add(*[rate * function.diff(x) for rate, x in pairs if rate != 0])


def _uses_time(definition: Definition, connection: EhresmannConnection) -> bool:
    entries = [e for row in connection.lift for e in row]
    affine = any(row[-1] != 0 for row in connection.lift)
    return affine or definition.time in atoms(entries, se.Symbol)


@dataclass(frozen=True)
class FieldSpace:
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
        forth, back = self.rates(x), self.rates(y)
        moved = tuple(
            along(forth, b, self.variables) - along(back, a, self.variables)
            for a, b in zip(x, y, strict=True)
        )
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

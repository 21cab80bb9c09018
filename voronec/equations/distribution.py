"""The distribution spanned by the horizontal fields: how it grows under brackets, what integrates.

D_1 = span(h_i),  D_(m+1) = D_m + [D_1, D_m].  The dimensions at a generic point form the growth
vector.  A constraint is integrable where its form annihilates the involutive closure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import dot
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import BRACKETS
from voronec.algebra.rank import generic_rows
from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import decide_zero
from voronec.equations.connection import EhresmannConnection
from voronec.equations.definition import Definition
from voronec.equations.flags import flag
from voronec.errors import EngineLimit

__all__ = ["Distribution", "grow"]

Field = tuple[Any, ...]
NODES = 15_000
"""Fields of more nodes are not bracketed again: symengine would not come to an end."""


@dataclass(frozen=True)
class Distribution:
    """How the distribution of the constraints grows, and which constraints integrate.

    ``growth``: dimensions of D_1, D_2, ... until they stay.  ``integrable``: positions of the
    constraints proved to annihilate the closure; ``undecided``: of those that do so in numbers
    only.  ``dimension``: of the space; ``timed``: whether the time is one of its coordinates, as it
    is where the constraints move or are affine.  ``cut``: whether further brackets were too large
    to be made, so that the growth may go on.  ``closed``: whether it is proved that the growth ends
    below the dimension.
    """

    growth: tuple[int, ...]
    integrable: tuple[int, ...]
    undecided: tuple[int, ...]
    dimension: int
    timed: bool
    cut: bool = False
    closed: bool = False


def grow(
    definition: Definition, raw: EhresmannConnection, exact: Callable[[], EhresmannConnection]
) -> Distribution:
    """The growth vector at a generic point, and the constraints proved to be integrable.

    ``raw`` is the connection as it was derived, ``exact`` makes its normal form: brackets are made
    of it where residues do not serve, and where they do not span everything.
    """
    timed = _uses_time(definition, raw)
    dimension = _Space(raw, timed).dimension
    if raw.group is None:
        dimension -= _RankOracle(definition.relations).relations(raw.coordinates)
    growth: tuple[int, ...] = ()
    if not definition.relations:
        with suppress(EngineLimit):
            growth = _Space(raw, timed).flag(dimension)
    if growth and growth[-1] == dimension:  # no form annihilates everything
        return Distribution(growth, (), (), dimension, timed)
    space = _Space(exact(), timed)
    made = _bracket(definition, space, dimension)
    standing = _integrability(definition, space.connection, made.new, timed)
    if (
        made.cut
    ):  # what annihilates the brackets that were made may not annihilate those that were not
        standing = ["undecided" if s == "proved" else s for s in standing]
    return Distribution(
        growth=growth or made.growth,
        integrable=tuple(i for i, s in enumerate(standing) if s == "proved"),
        undecided=tuple(i for i, s in enumerate(standing) if s == "undecided"),
        dimension=dimension,
        timed=timed,
        cut=made.cut and not growth,
        closed=made.closed,
    )


@dataclass(frozen=True)
class _Closure:
    """Brackets that were made, as ``new`` fields beside the first ones, and how they grew."""

    growth: tuple[int, ...]
    new: list[Field]
    cut: bool
    closed: bool


def _bracket(definition: Definition, space: _Space, dimension: int) -> _Closure:
    """Brackets of brackets, until they bring nothing new, or are too large."""
    fields = space.fields
    frame, tops, growth = list(fields), list(fields), [len(fields)]
    rank_of = _RankOracle(definition.relations)
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
    return _Closure(tuple(growth), frame[len(fields) :], cut, closed)


def _is_spanned(fields: Sequence[Field], frame: Sequence[Field], relations: Sequence[Any]) -> bool:
    """Whether normal forms prove that fields are combinations of a frame."""
    if not fields:
        return True
    rows, right = ([list(r) for r in zip(*some, strict=True)] for some in (frame, fields))
    try:
        return not solve_linear(rows, right, relations).contradictory
    except EngineLimit:
        return False


def _integrability(
    definition: Definition, connection: EhresmannConnection, new: Sequence[Field], timed: bool
) -> list[str]:
    """For each constraint: is it integrable?  proved, refuted or undecided."""
    relations, result = definition.relations, []
    variables = (*connection.coordinates, *((connection.time,) if timed else ()))
    alone = connection.group is None  # the form of one constraint by itself, in coordinates
    for row, offset in zip(
        definition.constraints.matrix, definition.constraints.offset, strict=True
    ):
        form = (*row, offset) if timed else row
        on_new = [dot(form, field) for field in new]
        if _is_nonzero_somewhere(on_new, relations):
            result.append("refuted")
        elif _are_all_zero(on_new, relations) or (alone and _frobenius(form, variables, relations)):
            result.append("proved")
        else:
            result.append("undecided")
    return result


def _is_nonzero_somewhere(exprs: Sequence[Any], relations: Sequence[Any]) -> bool:
    """Whether ball arithmetic shows one of the expressions to be nonzero somewhere."""
    samples = sample_evaluable(Tape(exprs), relations, BRACKETS)
    return any(not value.contains(0) for _, values in samples for value in values)


def _are_all_zero(exprs: Sequence[Any], relations: Sequence[Any]) -> bool:
    return all(decide_zero(e, relations).proved for e in exprs)


def _frobenius(form: Field, variables: Sequence[Any], relations: Sequence[Any]) -> bool:
    """Whether a one-form is proved to be integrable by itself: w ^ dw = 0."""
    m = len(variables)
    d = {
        (a, b): form[b].diff(variables[a]) - form[a].diff(variables[b])
        for a in range(m)
        for b in range(a + 1, m)
    }
    if _are_all_zero(list(d.values()), relations):
        return True
    triples = [
        form[a] * d[b, c] - form[b] * d[a, c] + form[c] * d[a, b]
        for a in range(m)
        for b in range(a + 1, m)
        for c in range(b + 1, m)
    ]
    return _are_all_zero(triples, relations)


def _uses_time(definition: Definition, connection: EhresmannConnection) -> bool:
    time = definition.time
    moving = any(se.has_symbol(e, time) for row in connection.lift for e in row)
    return moving or any(row[-1] != 0 for row in connection.lift)


@dataclass(frozen=True)
class _Space:
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

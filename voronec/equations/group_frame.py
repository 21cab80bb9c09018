"""Frames that are known by their brackets: Lie groups, and what moves along with them.

    [X_a, X_b] = C_ab^c X_c,      qdot = X_a(q) w^a

Velocities w^a stand in the place that velocities of coordinates have elsewhere; the coordinates q
may be fewer, or redundant [Theory, eq. (17)].  Everything here is in the engine's symbols.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.matrices import dot
from voronec.algebra.symbols import plain_name, time
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.verdicts import decide_zero
from voronec.declaration.geometry import Frame
from voronec.errors import DefinitionError

Vector = Sequence[Any]


@dataclass(frozen=True)
class GroupFrame:
    """Fields X_a with constant brackets, the independent velocities first.

    ``fields[q][a]`` is X_a(q), ``brackets`` holds (a, b, c, C_ab^c) for one order of a pair.
    """

    velocities: tuple[Any, ...]
    fields: tuple[tuple[Any, ...], ...]
    brackets: tuple[tuple[int, int, int, Any], ...]

    def coordinate_rates(self, x: Vector) -> list[Any]:
        """The rates of the coordinates along x^a X_a."""
        return [_total([(f, e) for f, e in zip(row, x, strict=True)]) for row in self.fields]

    def bracket(self, x: Vector, y: Vector) -> list[Any]:
        """C_ab^c x^a y^b, for each c: the bracket of two fields with constant components."""
        terms: list[list[tuple[Any, ...]]] = [[] for _ in self.velocities]
        for a, b, c, coefficient in self.brackets:
            terms[c] += [(coefficient, x[a], y[b]), (-coefficient, x[b], y[a])]
        return [_total(t) for t in terms]

    def keeps_vertical(self, base: int) -> bool:
        """Whether the fields from ``base`` on span an ideal, so that their leaves are fibres."""
        return not any(c < base and max(a, b) >= base for a, b, c, _ in self.brackets)


def _total(products: Sequence[tuple[Any, ...]]) -> Any:
    terms = [se.Mul(*p) for p in products if not any(f == 0 for f in p)]
    return se.Add(*terms) if terms else se.Integer(0)


def read_group(
    frame: Frame, coordinates: Sequence[sp.Expr], bridge: SymPyBridge, place: str
) -> GroupFrame:
    """A group's frame in the engine's symbols, with its brackets and rates checked."""
    velocities = tuple(map(bridge.inward, frame.ambient))
    position = {w: a for a, w in enumerate(frame.ambient)}
    table = tuple(
        (position[a], position[b], position[c], bridge.inward(value))
        for (a, b), parts in (frame.brackets or {}).items()
        for c, value in parts.items()
        if value != 0
    )
    rates = [bridge.inward(frame.rates[q]) for q in coordinates]
    _check_still(frame, coordinates, place)
    fields = []
    for q, rate in zip(coordinates, rates, strict=True):
        row = tuple(rate.diff(w) for w in velocities)
        left = rate - dot(row, velocities)
        if any(e.free_symbols & set(velocities) for e in row) or se.expand(left) != 0:
            raise DefinitionError(
                f"{place}: the rate of '{plain_name(q)}' is not linear in the velocities of the "
                "frame; write it as a combination of them"
            )
        fields.append(row)
    group = GroupFrame(velocities, tuple(fields), table)
    _check_jacobi(group, frame, place)
    _check_rates(group, [bridge.inward(q) for q in coordinates], frame, coordinates, place)
    return group


def _check_still(frame: Frame, coordinates: Sequence[sp.Expr], place: str) -> None:
    """Rates do not hold the time by itself: with fields that depend on it the equations have a
    further term, which is not made."""
    still = {x: sp.Dummy() for x in (*coordinates, *frame.ambient)}
    for q in coordinates:
        if frame.rates[q].xreplace(still).has(time):
            raise DefinitionError(
                f"{place}: the rate of '{plain_name(q)}' holds the time; take the time in as a "
                "coordinate, or use Frame.quasi"
            )


def _check_jacobi(group: GroupFrame, frame: Frame, place: str) -> None:
    """[[X_a, X_b], X_c] + [[X_b, X_c], X_a] + [[X_c, X_a], X_b] = 0."""
    table: dict[tuple[int, int], list[tuple[int, Any]]] = {}
    for a, b, c, value in group.brackets:
        table.setdefault((a, b), []).append((c, value))
        table.setdefault((b, a), []).append((c, -value))
    for triple in combinations(range(len(group.velocities)), 3):
        a, b, c = triple
        sums: dict[int, Any] = {}
        for x, y, z in ((a, b, c), (b, c, a), (c, a, b)):
            for d, first in table.get((x, y), ()):
                for e, second in table.get((d, z), ()):
                    sums[e] = sums.get(e, se.Integer(0)) + first * second
        if not all(s == 0 or decide_zero(s).proved for s in sums.values()):
            names = ", ".join(plain_name(frame.ambient[i]) for i in triple)
            raise DefinitionError(
                f"{place}: the brackets of the frame do not satisfy Jacobi's identity for {names}; "
                "correct a coefficient"
            )


def _check_rates(
    group: GroupFrame, inside: Vector, frame: Frame, coordinates: Sequence[sp.Expr], place: str
) -> None:
    """X_a X_b - X_b X_a = C_ab^c X_c on every coordinate."""
    size = range(len(group.velocities))
    columns = list(zip(*group.fields, strict=True)) or [() for _ in size]
    slopes = [[[e.diff(q) for q in inside] for e in column] for column in columns]
    given: dict[tuple[int, int], list[tuple[int, Any]]] = {}
    for a, b, c, value in group.brackets:
        given.setdefault((min(a, b), max(a, b)), []).append((c, value if a < b else -value))
    for a, b in combinations(size, 2):
        terms = given.get((a, b), ())
        for k, q in enumerate(coordinates):
            ab = _total([(s, e) for s, e in zip(slopes[b][k], columns[a], strict=True)])
            ba = _total([(s, e) for s, e in zip(slopes[a][k], columns[b], strict=True)])
            wanted = _total([(value, columns[c][k]) for c, value in terms])
            excess = se.expand(ab - ba - wanted)
            if excess != 0 and not decide_zero(excess).proved:
                names = f"{plain_name(frame.ambient[a])} and {plain_name(frame.ambient[b])}"
                raise DefinitionError(
                    f"{place}: the rate of '{plain_name(q)}' does not obey the bracket of "
                    f"{names}; correct the rate or the bracket (their sign)"
                )

"""Constraints that become dependent at a place alone, and those that they imply there.

    gamma4 Omega12 = gamma2 Omega14 - gamma1 Omega24,  and so on for the pairs 13 and 23

are dependent where gamma4 = 0: gamma3, -gamma2, gamma1 times them are gamma4 times a fourth one,
gamma3 Omega12 - gamma2 Omega13 + gamma1 Omega23 = 0, which every motion through the place keeps by
continuity.  So are the two of a snakeboard where cos(phi) = 0.  With such constraints beside them
the rank is the same there as elsewhere.

Places at which a coordinate vanishes are looked at, and such at which the sine or the cosine of an
angle does: of a coordinate, or of a sum a = k q + b that stands under one, with a number k.  There
q is replaced by (q - b)/k, so that a is called q.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.elimination import null_vectors
from voronec.algebra.matrices import dot
from voronec.algebra.normal import canonical, quotient, without_denominators
from voronec.algebra.rank import generic_rows
from voronec.algebra.terms import atoms

SIDE = se.Symbol("which side")
"""The value, 1 or -1, of the sine where the cosine vanishes."""

Row = Sequence[Any]


def with_implied_rows(
    rows: Sequence[Row], relations: Sequence[Any], coordinates: Sequence[Any]
) -> tuple[list[Row], list[Row]]:
    """Rows of constraints, with those that they imply where they are dependent [Theory, eq. (22b)];
    and sums of all these that vanish everywhere, one for each that was added.

    ``rows`` hold coefficients of velocities and an offset, in functions of the ``coordinates``, on
    which ``relations`` vanish.
    """
    extended, idle = [*rows], list[Row]()
    for place in _places(rows, coordinates) if rows else ():
        turned = [[place.rename(e) for e in row] for row in rows]
        ideal = [place.rename(r) for r in relations]
        near = [[e.xreplace(place.values) for e in row] for row in turned]
        onto = [r for r in (r.xreplace(place.values) for r in ideal) if r.free_symbols]
        if len(kept := generic_rows(near, onto)) == len(rows):
            continue
        width, flat = len(rows[0]), canonical([e for row in turned for e in row])
        if not place.is_plain(flat):
            continue
        short = [flat[k : k + width] for k in range(0, len(flat), width)]
        columns = [[e.xreplace(place.letters) for e in part] for part in zip(*short, strict=True)]
        there = [r.xreplace(place.letters) for r in ideal] + place.known
        for vector in null_vectors(columns, kept, there):
            sums = [e.xreplace(place.back) for e in without_denominators(vector, there)]
            new = canonical([dot(sums, part) / place.factor for part in zip(*short, strict=True)])
            if all(quotient(e)[1].is_Number for e in new):
                whole = [*sums, *([se.Integer(0)] * (len(extended) - len(rows))), -place.factor]
                idle.append([place.spell(e) for e in whole])
                extended.append([place.spell(e) for e in new])
    return extended, [(*row, *([se.Integer(0)] * (len(extended) - len(row)))) for row in idle]


@dataclass(frozen=True)
class _Place:
    """Where a ``factor`` vanishes: the sine or the cosine of what a ``coordinate`` is called there,
    or the coordinate itself.  ``values`` are those of it, ``letters`` of its sine and cosine, with
    relations ``known`` between these; ``name`` is what is called so in the user's coordinates, and
    ``old`` the coordinate then."""

    factor: Any
    coordinate: Any
    values: Mapping[Any, Any]
    letters: Mapping[Any, Any]
    known: list[Any]
    name: Any
    old: Any

    def rename(self, expr: Any) -> Any:
        """An expression in the user's coordinates as one in those of the place."""
        if self.name == self.coordinate:
            return se.sympify(expr)
        return se.expand(se.sympify(expr).xreplace({self.coordinate: self.old}))

    def spell(self, expr: Any) -> Any:
        """An expression in the coordinates of the place as one in the user's."""
        return expr.xreplace({self.coordinate: self.name})

    @property
    def back(self) -> dict[Any, Any]:
        """The sine or the cosine that the side is the value of."""
        return {value: side for side, value in self.letters.items() if value == SIDE}

    def is_plain(self, exprs: Sequence[Any]) -> bool:
        """Whether the coordinate stands alone under sines and cosines, so that letters take the
        place of all of these."""
        arguments = {f.args[0] for f in atoms(exprs, se.sin, se.cos)}
        return all(a == self.coordinate or self.coordinate not in a.free_symbols for a in arguments)


def _places(rows: Sequence[Row], coordinates: Sequence[Any]) -> Iterator[_Place]:
    exprs = [se.sympify(e) for row in rows for e in row]
    arguments = {f.args[0] for f in atoms(exprs, se.sin, se.cos)}
    turned = set().union(*(a.free_symbols for a in arguments))
    held, zero = set().union(*(e.free_symbols for e in exprs)), se.Integer(0)
    for q in coordinates:
        if q in held - turned:
            yield _Place(q, q, {q: zero}, {q: zero}, [], q, q)
    alone = [q for q in coordinates if q in turned]
    for angle in (*alone, *sorted(arguments - {*alone}, key=str)):
        slopes = [(q, angle.diff(q)) for q in alone]
        for q, k in [(q, k) for q, k in slopes if k != 0 and k.is_Number][:1]:
            old, sine, cosine = se.expand((q - angle) / k + q), se.sin(q), se.cos(q)
            known = [SIDE**2 - 1]
            yield _Place(sine, q, {q: zero}, {sine: zero, cosine: SIDE}, known, angle, old)
            letters = {cosine: zero, sine: SIDE}
            yield _Place(cosine, q, {q: se.pi / 2}, letters, known, angle, old)

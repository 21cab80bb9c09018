"""Constraints that become dependent at a place alone, and those that they imply there.

    gamma4 Omega12 = gamma2 Omega14 - gamma1 Omega24,  and so on for the pairs 13 and 23

are dependent where gamma4 = 0: gamma3, -gamma2, gamma1 times them are gamma4 times a fourth one,
gamma3 Omega12 - gamma2 Omega13 + gamma1 Omega23 = 0, which every motion through the place keeps by
continuity.  So are the two of a snakeboard where cos(phi) = 0.  With such constraints beside them
the rank is the same there as elsewhere.

Places at which a coordinate, or the sine or the cosine of an angle, vanishes are looked at.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
    found, idle = [*rows], list[Row]()
    for factor, place, letters, known in _places(rows, coordinates) if rows else ():
        there = [r.xreplace(letters) for r in relations] + known
        near = [[se.sympify(e).xreplace(place) for e in row] for row in rows]
        onto = [r for r in (r.xreplace(place) for r in relations) if r.free_symbols]
        if len(kept := generic_rows(near, onto)) == len(rows):
            continue
        width, flat = len(rows[0]), canonical([e for row in rows for e in row])
        short = [flat[k : k + width] for k in range(0, len(flat), width)]
        columns = [[e.xreplace(letters) for e in column] for column in zip(*short, strict=True)]
        back = {value: side for side, value in letters.items() if value == SIDE}
        for vector in null_vectors(columns, kept, there):
            sums = [e.xreplace(back) for e in without_denominators(vector, there)]
            new = canonical([dot(sums, column) / factor for column in zip(*short, strict=True)])
            if all(quotient(e)[1].is_Number for e in new):
                idle.append((*sums, *([se.Integer(0)] * (len(found) - len(rows))), -factor))
                found.append(new)
    return found, [(*row, *([se.Integer(0)] * (len(found) - len(row)))) for row in idle]


def _places(
    rows: Sequence[Row], coordinates: Sequence[Any]
) -> Iterator[tuple[Any, dict[Any, Any], dict[Any, Any], list[Any]]]:
    """What vanishes at a place, where that is, its letters there, and relations between these."""
    exprs = [se.sympify(e) for row in rows for e in row]
    turned = set().union(*(f.free_symbols for f in atoms(exprs, se.sin, se.cos)))
    held, zero = set().union(*(e.free_symbols for e in exprs)), se.Integer(0)
    for q in coordinates:
        sine, cosine = se.sin(q), se.cos(q)
        if q in turned:
            yield sine, {q: zero}, {sine: zero, cosine: SIDE}, [SIDE**2 - 1]
            yield cosine, {q: se.pi / 2}, {cosine: zero, sine: SIDE}, [SIDE**2 - 1]
        elif q in held:
            yield q, {q: zero}, {q: zero}, []

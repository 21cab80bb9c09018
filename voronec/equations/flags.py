"""How fast brackets of vector fields span, from series in one variable modulo a prime.

    D_1 = span of some X_j,   D_(m+1) = D_m + span of [X_i, D_m] over all i,   at a generic point

A motion x' = V = u_i(t) X_i(x) transports X_j back to its start, where the series Y_j(t) has
combinations of brackets for coefficients: Y_j = B X_j(x), where B' d_b = -B [d_b, V].  With
controls t^(w - 1) v_i(t), deg v_i = d, brackets with r fields beside X_j stand at the orders r w to
r (w + d), which are apart for r d < w: they lie in D_(r+1).  They span it with those of smaller r
if their brackets with c_i X_i do, with random constants c_i, which are the change of Y_j where the
motion first goes along that [Theory, eq. (11a)].
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, chain, count
from math import ceil
from typing import Any

import flint
import symengine as se
import sympy as sp

from voronec.algebra.generators import TRIGONOMETRIC, Generators, linear_terms
from voronec.algebra.graphs import nodes
from voronec.algebra.matrices import dot
from voronec.algebra.tape import Tape
from voronec.errors import EngineLimit

Field = Sequence[Any]
PRIME = 2**61 - 1
FIRST = 3
"""Brackets are nested so often at first, and then twice as often, until they bring nothing new."""
ZERO, ONE = flint.nmod_poly([], PRIME), flint.nmod_poly([1], PRIME)


def flag(
    fields: Sequence[Field],
    start: Sequence[Field],
    bracket: Callable[[Any, Any], Field],
    rates: Callable[[Any], Field],
    variables: Sequence[Any],
    full: int,
) -> tuple[int, ...]:
    """The dimensions of D_1, D_2, ... until they stay, or are ``full``.

    ``start`` are the X_j, ``fields`` all X_i; ``rates`` gives those of the ``variables`` along a
    field.  Each number is proved to be a lower bound.  It is the dimension unless a point and
    motions drawn at random are roots of a polynomial of some thousand degrees modulo 2^61 - 1,
    which one in 10^14 draws is.  ``EngineLimit`` where fields are no rational functions, with sines
    and cosines, of their variables.
    """
    motions = _Motions(fields, start, bracket, rates, variables)
    steps = FIRST
    while True:
        dimensions = _dimensions(motions, steps)
        if full in dimensions or dimensions[-1] == dimensions[-2]:
            return tuple(dimensions[: dimensions.index(dimensions[-1]) + 1])
        pace = (dimensions[-1] - dimensions[0]) / steps
        steps += ceil((full - dimensions[-1]) / pace)


def _dimensions(motions: _Motions, steps: int) -> list[int]:
    """The dimensions of D_1, ..., D_(steps + 1), from as many motions as it takes for them to be
    closed: those of all vectors with their brackets are those of the vectors alone."""
    spans: list[list[Any]] = [[] for _ in range(steps + 1)]
    brackets: list[list[Any]] = [[] for _ in range(steps + 1)]
    for k in count():
        vectors, further = motions.transport(steps, k // 2)
        for r in range(steps + 1):
            spans[r] += vectors[r]
            brackets[r] += further[r - 1] if r else []
        dimensions = _ranks(spans)
        if dimensions == _ranks([a + b for a, b in zip(spans, brackets, strict=True)]):
            return dimensions
    raise AssertionError


def _ranks(levels: Sequence[Sequence[Any]]) -> list[int]:
    """Those of the vectors of the first level, of the first two, ..."""
    return [
        flint.nmod_mat(len(rows), len(rows[0]), [*chain(*rows)], PRIME).rank()
        for rows in accumulate(levels)
    ]


class _Motions:
    """Motions from one random point along V, with any controls: of the variables, of cosine, sine
    and tangent of angles, and of B."""

    def __init__(
        self,
        fields: Sequence[Field],
        carried: Sequence[Field],
        bracket: Callable[[Any, Any], Field],
        rates: Callable[[Any], Field],
        variables: Sequence[Any],
    ) -> None:
        self._source = random.Random("voronec flag")
        unit = se.eye(len(fields[0])).tolist()
        paces = [rates(x) for x in fields]
        functions = self._draw_point([*variables, *chain(*paces, *fields, *carried)])
        self._moving = [*variables, *functions]
        slopes = [[f.diff(q) for q in variables] for f in functions]
        moving = [[*pace, *(dot(slope, pace) for slope in slopes)] for pace in paces]
        turning = [chain(*(bracket(tuple(d), x) for d in unit)) for x in fields]
        self._rates, self._slopes, self._carried = (
            Tape([*chain(*rows)], functions)
            for rows in (zip(*moving, strict=True), zip(*turning, strict=True), carried)
        )
        self._count, self._size = len(fields), len(unit)

    def _draw(self) -> Any:
        return flint.nmod(self._source.randrange(1, PRIME), PRIME)

    def _draw_point(self, exprs: Sequence[Any]) -> list[Any]:
        """Values of all symbols, and of the functions of angles that are returned."""
        generators = Generators()
        generators.scan(exprs)
        strange = [
            *generators.radicals,
            *generators.units,
            *generators.exponents,
            *generators.tangents,
        ]
        strange += [a for a in generators.atoms if not isinstance(a, se.Symbol)]
        strange += [a for a in generators.angles if not isinstance(a, se.Symbol)]
        angles = {node.args[0] for node in nodes(exprs) if isinstance(node, TRIGONOMETRIC)}
        folds = {a: linear_terms(a) for a in sorted(angles, key=str)}
        strange += [a for a, terms in folds.items() if not terms.keys() <= generators.angles.keys()]
        if strange:
            raise EngineLimit(f"'{strange[0]}' has no residues modulo a prime")
        symbols = sorted({*generators.atoms, *generators.angles}, key=str)
        self._point = {x: self._draw() for x in symbols}
        letters = {unit: se.Symbol(f"angle {i}") for i, unit in enumerate(generators.angles)}
        turns = {}
        for letter in letters.values():
            half = self._draw()
            turns[se.cos(letter)] = (1 - half**2) / (1 + half**2)
            turns[se.sin(letter)] = 2 * half / (1 + half**2)
        for angle, terms in folds.items():
            folded = sp.Add(
                *(c * generators.angles[unit] * letters[unit] for unit, c in terms.items())
            )
            cosine, sine = (se.sympify(sp.expand_trig(f(folded))) for f in (sp.cos, sp.sin))
            values = Tape([cosine, sine, sine / cosine], turns).run(turns, _residue)
            functions = [f(angle) for f in (se.cos, se.sin, se.tan)]
            self._point |= zip(functions, values, strict=True)
        return [f for f in self._point if not isinstance(f, se.Symbol)]

    def transport(self, steps: int, degree: int) -> tuple[list[Any], list[Any]]:
        """Coefficients of fields transported along a random motion, those that hold brackets with r
        fields for r = 0, 1, ..., ``steps``; and the brackets of these with a random
        combination of the fields."""
        block = steps * degree + 1
        end = (steps + 1) * block  # the order of what is tiny: its square is left out
        controls = self._draw_series(end, degree + 1, block - 1)
        still, tiny = self._draw_series(end, 0, 0), self._draw_series(end, 1, end)
        plain, turned = (self._carry(steps, controls, ahead) for ahead in (still, tiny))
        changes = [
            [b - a for a, b in zip(*pair, strict=True)] for pair in zip(plain, turned, strict=True)
        ]
        orders = [range(r * block, r * (block + degree) + 1) for r in range(steps + 1)]
        spans, brackets = (
            [
                [[int(e.poly[first + k]) for e in y] for y in fields for k in powers]
                for powers in orders
            ]
            for fields, first in ((plain, 0), (changes, end))
        )
        return spans, brackets

    def _draw_series(self, end: int, count: int, order: int) -> list[_Residues]:
        """For each field one with so many terms, from an order on."""
        rows = [[self._draw() for _ in range(count)] for _ in range(self._count)]
        return [_Residues(flint.nmod_poly(row, PRIME).left_shift(order), end) for row in rows]

    def _carry(
        self, steps: int, controls: Sequence[_Residues], ahead: Sequence[_Residues]
    ) -> list[list[_Residues]]:
        """The carried fields along the motion that goes along the fields by what is tiny, and then
        with the controls."""
        end, size = controls[0].end, range(self._size)
        start = {x: _Residues(ONE * value, end) for x, value in self._point.items()}
        begin = at = self._move(start, self._along(self._rates, start, ahead))
        for _ in range(steps):  # each round finds the brackets with one field more
            rates = self._along(self._rates, at, controls)
            at = self._move(begin, [e.integral() for e in rates])
        turn = _rows(self._along(self._slopes, start, ahead), self._size)
        first = back = [
            [_Residues(ONE * int(a == b), end) - turn[b][a] for b in size] for a in size
        ]
        slopes = _rows(self._along(self._slopes, at, controls), self._size)
        for _ in range(steps):
            back = [
                [e - _dot(row, x).integral() for e, x in zip(entries, slopes, strict=True)]
                for entries, row in zip(first, back, strict=True)
            ]
        carried = _rows(self._run(self._carried, at, end), self._size)
        return [[_dot(row, x) for row in back] for x in carried]

    def _move(self, begin: Mapping[Any, Any], changes: Sequence[Any]) -> dict[Any, Any]:
        moved = {x: begin[x] + e for x, e in zip(self._moving, changes, strict=True)}
        return {**begin, **moved}

    def _along(
        self, tape: Tape, at: Mapping[Any, _Residues], controls: Sequence[_Residues]
    ) -> list[_Residues]:
        """What a tape has for each field, along the motion."""
        rows = _rows(self._run(tape, at, controls[0].end), self._count)
        return [_dot(row, controls) for row in rows]

    def _run(self, tape: Tape, at: Mapping[Any, _Residues], end: int) -> list[_Residues]:
        return tape.run(at, lambda e: _Residues(ONE * _residue(e), end))


def _rows(entries: list[Any], width: int) -> list[list[Any]]:
    return [entries[k : k + width] for k in range(0, len(entries), width)]


@dataclass(frozen=True)
class _Residues:
    """A polynomial modulo a prime; from the order ``end`` on it is tiny, and cut off at twice."""

    poly: Any
    end: int

    def __add__(self, other: _Residues) -> _Residues:
        return _Residues(self.poly + other.poly, self.end)

    def __sub__(self, other: _Residues) -> _Residues:
        return _Residues(self.poly - other.poly, self.end)

    def __mul__(self, other: _Residues) -> _Residues:
        return _Residues(self.poly.mul_low(other.poly, 2 * self.end), self.end)

    def __rtruediv__(self, one: int) -> _Residues:
        if self.poly[0] == 0:
            raise EngineLimit("a denominator vanishes at a random point")
        return _Residues(self.poly.inverse_series_trunc(2 * self.end) * one, self.end)

    def integral(self) -> _Residues:
        """That of what is not tiny, and that of what is."""
        plain, tiny = self.poly.truncate(self.end), self.poly.right_shift(self.end)
        return _Residues(plain.integral() + tiny.integral().left_shift(self.end), self.end)


def _dot(left: Sequence[_Residues], right: Sequence[_Residues]) -> _Residues:
    pairs = zip(left, right, strict=True)
    products = [a * b for a, b in pairs if a.poly.length() and b.poly.length()]
    return sum(products, _Residues(ZERO, left[0].end))


def _residue(number: Any) -> Any:
    return flint.nmod(int(number.p), PRIME) / int(number.q)

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
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, chain, count
from math import ceil
from typing import Any

import flint
import symengine as se

from voronec.algebra.generators import TRIGONOMETRIC, Generators, linear_terms
from voronec.algebra.graphs import nodes
from voronec.algebra.matrices import dot
from voronec.algebra.tape import Tape
from voronec.errors import EngineLimit

__all__ = ["flag"]

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
        found = _dimensions(motions, steps)
        if full in found or found[-1] == found[-2]:
            return tuple(found[: found.index(found[-1]) + 1])
        pace = (found[-1] - found[0]) / steps
        steps += ceil((full - found[-1]) / pace)


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
        found = _ranks(spans)
        if found == _ranks([a + b for a, b in zip(spans, brackets, strict=True)]):
            return found
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
        self._point: dict[Any, Any] = {}
        functions = self._draw_point([*variables, *chain(*paces, *fields, *carried)])
        self._moving = [*variables, *functions]
        slopes = [[f.diff(q) for q in variables] for f in functions]
        moving = [[*pace, *(dot(slope, pace) for slope in slopes)] for pace in paces]
        turning = [chain(*(bracket(tuple(d), x) for d in unit)) for x in fields]
        self._rates, self._slopes, self._carried = (
            Tape([*chain(*rows)], functions)
            for rows in (zip(*moving, strict=True), zip(*turning, strict=True), carried)
        )
        self._count, self._size = len(fields), range(len(unit))

    def _draw(self) -> Any:
        return flint.nmod(self._source.randrange(1, PRIME), PRIME)

    def _draw_point(self, exprs: Sequence[Any]) -> list[Any]:
        """Values of all symbols, and of the functions of angles that are returned."""
        found = Generators()
        found.scan(exprs)
        strange = [*found.radicals, *found.units, *found.exponents, *found.tangents]
        strange += [a for a in found.atoms if not isinstance(a, se.Symbol)]
        strange += [a for a in found.angles if not _is_monomial(a)]
        angles = {node.args[0] for node in nodes(exprs) if isinstance(node, TRIGONOMETRIC)}
        folds = {a: linear_terms(a) for a in sorted(angles, key=str)}
        strange += [a for a, terms in folds.items() if not terms.keys() <= found.angles.keys()]
        if strange:
            raise EngineLimit(f"'{strange[0]}' has no residues modulo a prime")
        symbols = {*found.atoms}.union(*(a.free_symbols for a in angles))
        self._point |= {x: self._draw() for x in sorted(symbols, key=str)}
        turns = {}
        for unit in found.angles:
            half = self._draw()
            turns[unit] = (1 - half**2) / (1 + half**2), 2 * half / (1 + half**2)
        for angle, terms in folds.items():
            cosine, sine = flint.nmod(1, PRIME), flint.nmod(0, PRIME)
            for unit, factor in terms.items():
                fold, (c, s) = int(factor * found.angles[unit]), turns[unit]
                for _ in range(abs(fold)):
                    t = s if fold > 0 else -s
                    cosine, sine = cosine * c - sine * t, sine * c + cosine * t
            values = {se.cos: cosine, se.sin: sine, se.tan: sine / cosine}
            self._point |= {f(angle): value for f, value in values.items()}
        return [f for f in self._point if not isinstance(f, se.Symbol)]

    def transport(self, steps: int, degree: int) -> tuple[list[Any], list[Any]]:
        """Coefficients of fields transported along a random motion, those that hold brackets with r
        fields for r = 0, 1, ..., ``steps``; and the brackets of these with a random
        combination of the fields."""
        block, size = steps * degree + 1, range(self._count)
        end = (steps + 1) * block  # the order of what is tiny: its square is left out
        controls = [
            flint.nmod_poly([self._draw() for _ in range(degree + 1)], PRIME).left_shift(block - 1)
            for _ in size
        ]
        still, tiny = [ZERO for _ in size], [ONE.left_shift(end) * self._draw() for _ in size]
        plain, turned = (self._carry(controls, steps, ahead, end) for ahead in (still, tiny))
        pairs = [zip(a, b, strict=True) for a, b in zip(plain, turned, strict=True)]
        changes = [[(b - a).right_shift(end) for a, b in pair] for pair in pairs]
        orders = [range(r * block, r * (block + degree) + 1) for r in range(steps + 1)]
        spans, brackets = (
            [[[int(e[k]) for e in y] for y in series for k in own] for own in orders]
            for series in (plain, changes)
        )
        return spans, brackets

    def _carry(
        self, controls: Sequence[Any], steps: int, tiny: Sequence[Any], end: int
    ) -> list[list[Any]]:
        """The series of the carried fields along the motion that goes along the fields by what is
        ``tiny``, and then with the controls."""
        size, length = self._size, 2 * end
        start = {x: ONE * value for x, value in self._point.items()}
        begin = at = self._move(start, self._along(self._rates, start, tiny, length))
        for _ in range(steps):  # each round finds the brackets with one field more
            rates = self._along(self._rates, at, controls, length)
            at = self._move(begin, [_integral(e, end) for e in rates])
        turn = self._along(self._slopes, start, tiny, length)
        first = back = [[ONE * int(a == b) - turn[b * len(size) + a] for b in size] for a in size]
        slopes = _rows(self._along(self._slopes, at, controls, length), len(size))
        for _ in range(steps):
            back = [
                [e - _integral(_dot(row, x, length), end) for e, x in zip(own, slopes, strict=True)]
                for own, row in zip(first, back, strict=True)
            ]
        carried = _rows(self._run(self._carried, at, length), len(size))
        return [[_dot(row, x, length) for row in back] for x in carried]

    def _move(self, begin: Mapping[Any, Any], changes: Sequence[Any]) -> dict[Any, Any]:
        moved = {x: begin[x] + e for x, e in zip(self._moving, changes, strict=True)}
        return {**begin, **moved}

    def _along(
        self, tape: Tape, at: Mapping[Any, Any], controls: Sequence[Any], length: int
    ) -> list[Any]:
        """What a tape has for each field, along the motion."""
        rows = _rows(self._run(tape, at, length), self._count)
        return [_dot(row, controls, length) for row in rows]

    def _run(self, tape: Tape, at: Mapping[Any, Any], length: int) -> list[Any]:
        values = {x: _Series(e, length) for x, e in at.items()}
        found = tape.run(values, lambda e: _Series(ONE * _residue(e), length))
        return [e.series for e in found]


def _rows(entries: list[Any], width: int) -> list[list[Any]]:
    return [entries[k : k + width] for k in range(0, len(entries), width)]


@dataclass(frozen=True)
class _Series:
    """A polynomial modulo a prime, cut off before the order ``length``."""

    series: Any
    length: int

    def __add__(self, other: _Series) -> _Series:
        return _Series(self.series + other.series, self.length)

    def __mul__(self, other: _Series) -> _Series:
        return _Series(self.series.mul_low(other.series, self.length), self.length)

    def __rtruediv__(self, one: int) -> _Series:
        if self.series[0] == 0:
            raise EngineLimit("a denominator vanishes at a random point")
        return _Series(self.series.inverse_series_trunc(self.length) * one, self.length)


def _dot(left: Iterable[Any], right: Iterable[Any], length: int) -> Any:
    pairs = [(a, b) for a, b in zip(left, right, strict=True) if a.length() and b.length()]
    return sum((a.mul_low(b, length) for a, b in pairs), ZERO)


def _integral(series: Any, end: int) -> Any:
    """The integral of what is not tiny, and that of what is."""
    return series.truncate(end).integral() + series.right_shift(end).integral().left_shift(end)


def _residue(number: Any) -> Any:
    return flint.nmod(int(number.p), PRIME) / int(number.q)


def _is_monomial(angle: Any) -> bool:
    """Whether it is a product of powers of symbols: such angles, if none is a multiple of another,
    have independent sines."""
    factors = angle.args if isinstance(angle, se.Mul) else (angle,)
    bases = [f.args[0] if isinstance(f, se.Pow) and f.args[1].is_Integer else f for f in factors]
    return all(b == 1 or isinstance(b, se.Symbol) for b in bases)

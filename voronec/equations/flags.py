"""How fast brackets of vector fields span, from series in one variable modulo a prime.

    D_1 = span of some X_j,   D_(m+1) = D_m + span of [X_i, D_m] over all i,   at a generic point

A motion x' = u_i(t) X_i(x) transports X_j back to its start, where the series Y_j(t) has
combinations of brackets for coefficients.  With controls t^(w - 1) v_i(t), deg v_i = d, brackets
with r fields beside X_j stand at the orders r w to r (w + d), which are apart for r d < w: they lie
in D_(r+1).  They span it with those of smaller r if their brackets with all X_i do, which are the
change of Y_j where the motion first goes along X_i [Theory, eq. (11a)].
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import chain, count
from math import ceil
from typing import Any

import flint
import symengine as se

from voronec.algebra.generators import Generators, linear_terms
from voronec.algebra.jets import BY_SINES
from voronec.algebra.matrices import dot
from voronec.algebra.memo import remember
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
    size = range(len(fields[0]))
    units = [tuple(se.Integer(int(a == b)) for a in size) for b in size]
    slopes = [[bracket(unit, x) for unit in units] for x in fields]
    motions = _Motions([rates(x) for x in fields], slopes, start, variables)
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
    found, basis = [], list[Any]()
    for level in levels:
        rows = [*basis, *level]
        matrix, rank = flint.nmod_mat(len(rows), len(rows[0]), [*chain(*rows)], PRIME).rref()
        basis = [[int(e) for e in row] for row in matrix.tolist()[:rank]]
        found.append(rank)
    return found


class _Motions:
    """Motions from one random point: ``rates[i]`` of the ``variables``, and ``slopes[i][b]``, which
    is [d_b, X_i], of the fields that move; ``carried`` are transported."""

    def __init__(
        self,
        rates: Sequence[Field],
        slopes: Sequence[Sequence[Field]],
        carried: Sequence[Field],
        variables: Sequence[Any],
    ) -> None:
        self._source = random.Random("voronec flag")
        found = Generators()
        found.scan(chain(*rates, *carried, *chain(*slopes)))
        strange = [*found.radicals, *found.units, *found.exponents, *found.tangents]
        strange += [a for a in found.atoms if not isinstance(a, se.Symbol)]
        strange += [a for a in found.angles if not _is_monomial(a)]
        if strange:
            raise EngineLimit(f"'{strange[0]}' has no residues modulo a prime")
        units = {a: a / d for a, d in found.angles.items()}
        symbols = {*variables, *found.atoms}.union(*(a.free_symbols for a in units))
        self._point = {x: ONE * self._draw() for x in sorted(symbols, key=str)}
        self._turns = {a: self._draw_turn() for a in units}
        turning = [[a.diff(q) for q in variables] for a in units.values()]
        moving = [[*own, *(dot(row, own) for row in turning)] for own in rates]
        columns = [zip(*own, strict=True) for own in zip(*slopes, strict=True)]
        self._variables, self._count, self._size = variables, len(rates), len(carried[0])
        self._rates = _Program(zip(*moving, strict=True), units)
        self._slopes = _Program(chain(*columns), units)
        self._carried = _Program(carried, units)

    def _draw(self) -> Any:
        return flint.nmod(self._source.randrange(1, PRIME), PRIME)

    def _draw_turn(self) -> tuple[Any, Any]:
        half = self._draw()
        return ONE * ((1 - half**2) / (1 + half**2)), ONE * (2 * half / (1 + half**2))

    def transport(self, steps: int, degree: int) -> tuple[list[Any], list[Any]]:
        """Coefficients of fields transported along a random motion, those that hold brackets with r
        fields for r = 0, 1, ..., ``steps``; and the brackets of these with all fields."""
        block, size = steps * degree + 1, range(self._count)
        end = (steps + 1) * block  # the order of what is tiny: its square is left out
        controls = [
            flint.nmod_poly([self._draw() for _ in range(degree + 1)], PRIME).left_shift(block - 1)
            for _ in size
        ]
        tiny = [[ONE.left_shift(end) * int(i == k) for i in size] for k in (-1, *size)]
        plain, *turned = (self._carry(controls, steps, ahead, 2 * end) for ahead in tiny)
        pairs = [pair for own in turned for pair in zip(plain, own, strict=True)]
        changes = [[(b - a).right_shift(end) for a, b in zip(*pair, strict=True)] for pair in pairs]
        orders = [range(r * block, r * (block + degree) + 1) for r in range(steps + 1)]
        spans, brackets = (
            [[[int(e[k]) for e in y] for y in series for k in own] for own in orders]
            for series in (plain, changes)
        )
        return spans, brackets

    def _carry(
        self, controls: Sequence[Any], steps: int, tiny: Sequence[Any], length: int
    ) -> list[list[Any]]:
        """The series of the carried fields along the motion that goes along the fields by what is
        ``tiny``, and then with the controls."""
        size = range(self._size)
        begin = at = _Series(self._point, self._turns, length)
        turn = [at.dot(row, tiny) for row in self._slopes.run(at)]
        start = [[ONE * int(a == b) - turn[b * len(size) + a] for b in size] for a in size]
        changes = [at.dot(row, tiny) for row in self._rates.run(at)]
        begin = at = begin.move(at, self._variables, changes, lambda e: e)
        for _ in range(steps):  # each round finds the brackets with one field more
            changes = [at.dot(row, controls) for row in self._rates.run(at)]
            at = begin.move(at, self._variables, changes, at.integral)
        turn, back = [at.dot(row, controls) for row in self._slopes.run(at)], start
        columns = [turn[b * len(size) : (b + 1) * len(size)] for b in size]
        for _ in range(steps):
            back = [
                [
                    e - at.integral(at.dot(row, column))
                    for e, column in zip(own, columns, strict=True)
                ]
                for own, row in zip(start, back, strict=True)
            ]
        return [[at.dot(row, field) for row in back] for field in self._carried.run(at)]


@dataclass(frozen=True)
class _Series:
    """Series of symbols, and of cosine and sine of angles, along a motion: half of the ``length``,
    and half for changes that are tiny."""

    symbols: Mapping[Any, Any]
    turns: Mapping[Any, tuple[Any, Any]]
    length: int

    def move(
        self,
        at: _Series,
        variables: Sequence[Any],
        rates: Sequence[Any],
        change: Callable[[Any], Any],
    ) -> _Series:
        """These with the changes that rates of variables, then of angles, make at another place."""
        moved = {q: self.symbols[q] + change(e) for q, e in zip(variables, rates, strict=False)}
        turns = {}
        for (angle, (c, s)), rate in zip(self.turns.items(), rates[len(variables) :], strict=True):
            cosine, sine = (change(at.dot([e], [rate])) for e in at.turns[angle])
            turns[angle] = c - sine, s + cosine
        return _Series({**self.symbols, **moved}, turns, self.length)

    def dot(self, left: Iterable[Any], right: Iterable[Any]) -> Any:
        """The sum of products."""
        pairs = [(a, b) for a, b in zip(left, right, strict=True) if a.length() and b.length()]
        return sum((a.mul_low(b, self.length) for a, b in pairs), ZERO)

    def product(self, *factors: Any) -> Any:
        """The product."""
        return reduce(lambda a, b: a.mul_low(b, self.length), factors)

    def power(self, base: Any, exponent: int) -> Any:
        """An integer power; ``EngineLimit`` where there is none."""
        if exponent < 0:
            if base[0] == 0:
                raise EngineLimit("a denominator vanishes at a random point")
            base = base.inverse_series_trunc(self.length)
        return base.pow_trunc(abs(exponent), self.length)

    def turn(self, folds: Sequence[tuple[Any, int]]) -> tuple[Any, Any]:
        """Cosine and sine of a sum of multiples of angles."""
        cosine, sine = ONE, ZERO
        for angle, fold in folds:
            c, s = self.turns[angle]
            s = s if fold > 0 else -s
            for _ in range(abs(fold)):
                pair = cosine, sine
                cosine, sine = self.dot(pair, [c, -s]), self.dot(pair, [s, c])
        return cosine, sine

    def integral(self, series: Any) -> Any:
        """The integral of what is not tiny, and that of what is."""
        end = self.length // 2
        return series.truncate(end).integral() + series.right_shift(end).integral().left_shift(end)


class _Program:
    """A table of expressions as steps of arithmetic with series; ``units`` are the angles whose
    cosine and sine are known, by the terms of which they are fractions."""

    def __init__(self, rows: Iterable[Sequence[Any]], units: Mapping[Any, Any]) -> None:
        self._units = units
        self._known: dict[Any, int] = {}
        self._steps: list[tuple[Callable[..., Any], Sequence[int]]] = []
        self._rows = [[self._slot(se.sympify(e)) for e in row] for row in rows]

    def run(self, at: _Series) -> list[list[Any]]:
        """The series of all expressions."""
        values: list[Any] = []
        for operation, slots in self._steps:
            values.append(operation(at, *[values[k] for k in slots]))
        return [[values[k] for k in row] for row in self._rows]

    @remember("_known")
    def _slot(self, expr: Any) -> int:
        operation, arguments = self._operation(expr)
        self._steps.append((operation, [self._slot(a) for a in arguments]))
        return len(self._steps) - 1

    def _operation(self, expr: Any) -> tuple[Callable[..., Any], Sequence[Any]]:
        if isinstance(expr, se.Symbol):
            return (lambda at: at.symbols[expr]), ()
        if expr.is_Number:
            number = ONE * (flint.nmod(int(expr.p), PRIME) / int(expr.q))
            return (lambda at: number), ()
        if isinstance(expr, se.Add):
            return (lambda at, *terms: sum(terms, ZERO)), expr.args
        if isinstance(expr, se.Mul):
            return _Series.product, expr.args
        if isinstance(expr, se.Pow):
            exponent = int(expr.args[1])
            return (lambda at, base: at.power(base, exponent)), expr.args[:1]
        if not isinstance(expr, se.sin | se.cos):
            return (lambda at, value: value), [se.sympify(BY_SINES[type(expr)](*expr.args))]
        terms = linear_terms(expr.args[0])
        if se.pi in terms:
            raise EngineLimit(f"'{expr}' has no residues modulo a prime")
        folds = [(a, int(factor * a / self._units[a])) for a, factor in terms.items()]
        return (lambda at: at.turn(folds)[isinstance(expr, se.sin)]), ()


def _is_monomial(angle: Any) -> bool:
    """Whether it is a product of powers of symbols: such angles, if none is a multiple of another,
    have independent sines."""
    factors = angle.args if isinstance(angle, se.Mul) else (angle,)
    bases = [f.args[0] if isinstance(f, se.Pow) and f.args[1].is_Integer else f for f in factors]
    return all(b == 1 or isinstance(b, se.Symbol) for b in bases)

"""Straight-line programs of sums: every sum has a name, products stay open.

A derivative of such a program is again one, made stage by stage, and a derivative that is a sum met
before (up to a factor) is found again, not written a second time: the derivative of
cos(a)*x + sin(a)*y is the stage cos(a)*y - sin(a)*x.

Where a system does not change when a coordinate is shifted, the coordinate cancels from what is
computed, but no rewriting rule sees it.  Values at neighbouring points suggest the cancellation;
the derivative, expanded until it is zero, proves it, but for functions of many branches.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import count, islice
from typing import Any

import flint
import symengine as se

from voronec.algebra.brackets import (
    Pair,
    bracket,
    factor_exponents,
    share_pairs,
    term_pairs,
    with_term_pair,
)
from voronec.algebra.branches import is_branching
from voronec.algebra.graphs import is_atom, is_flat, nodes
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.ring import Ring
from voronec.algebra.tape import Tape
from voronec.algebra.terms import spread_length
from voronec.errors import EngineLimit

WIDEST = 60
"""Sums with more terms than this are left alone."""


def split_number(term: Any) -> tuple[Any, Any]:
    """A term without its number, and the number."""
    number = coefficient(term)
    return (ONE, number) if term.is_Number else (term / number, number)


def shared_sums(definitions: Mapping[Any, Any], fresh: Callable[[], Any]) -> dict[Any, Any]:
    """Name every pair of terms that several sums share, up to a factor, most shared first.

    Pairs of named pairs follow, so that longer common parts are found, too.
    """
    bags = {
        x: dict(map(split_number, e.args))
        for x, e in definitions.items()
        if isinstance(e, se.Add) and len(e.args) <= WIDEST
    }

    def define(pair: Pair) -> tuple[dict[Any, Any], Any]:
        name, (first, second, ratio) = fresh(), pair
        bags[name] = {first: ONE, second: ratio}
        return bags[name], name

    share_pairs(bags, term_pairs, define, with_term_pair)
    sums = {x: se.Add(*[c * m for m, c in bag.items()]) for x, bag in bags.items()}
    return _sorted_stages({**definitions, **sums})


def factor_sums(definitions: Mapping[Any, Any], fresh: Callable[[], Any]) -> dict[Any, Any]:
    """Write a*b + a*c as a*(b + c) in every sum, the factor that most terms share first."""
    names: dict[Any, Any] = {}
    result: dict[Any, Any] = {}

    def name(expr: Any) -> Any:
        if not isinstance(expr, se.Add):
            return expr
        number, expr = primitive(expr)
        if expr not in names:
            names[expr] = fresh()
            result[names[expr]] = expr
        return number * names[expr]

    for x, expr in definitions.items():
        result[x] = expr
        if isinstance(expr, se.Add):
            result[x] = bracket([*map(factor_exponents, expr.args)], set(), max, name)
    return _sorted_stages(result)


class StagedElimination:
    """rows * x = right with a row for each unknown or more; rows to spare must be dependent.

    A pivot is an entry that ball arithmetic proves nonzero at a generic point of the relations.
    Raises ``EngineLimit`` where an unknown is left without a pivot.
    """

    def __init__(
        self, stages: Stages, rows: Sequence[Mapping[int, Any]], unknowns: int, relations: Any
    ) -> None:
        self._stages = stages
        self._left = [dict(row) for row in rows]
        self._steps: list[tuple[int, int, Any]] = []
        self._pivots: list[tuple[int, int]] = []
        shadows = self._shadows(relations)
        open_rows = list(range(len(rows)))
        with flint.ctx.workprec(GENERIC):
            while (choice := self._choice(open_rows, shadows)) is not None:
                self._pivots.append(choice)
                open_rows.remove(choice[0])
                for row in open_rows:
                    if choice[1] in self._left[row]:
                        self._subtract(row, *choice, shadows)
        if len(self._pivots) < unknowns:
            raise EngineLimit("the velocities are not determined stage by stage")

    def solve(self, right: Sequence[Any]) -> list[Any]:
        """The unknowns for right sides, in the order of the unknowns."""
        rest = list(right)
        for target, source, factor in self._steps:
            if rest[source] != 0:
                rest[target] = self._stages.name(rest[target] - factor * rest[source])
        values: dict[int, Any] = {}
        for row, column in reversed(self._pivots):
            left = self._left[row]
            known = _linear_combination((e, values[j]) for j, e in left.items() if j != column)
            values[column] = self._stages.name(self._stages.name(rest[row] - known) / left[column])
        return [values[j] for j in sorted(values)]

    def _shadows(self, relations: Any) -> list[dict[int, Any]]:
        entries = [e for row in self._left for e in row.values()]
        definitions = self._stages.definitions
        atoms = Tape([*definitions.values(), *entries]).atoms
        free = [a for a in atoms if a not in definitions]
        for point, _ in sample_evaluable(Tape(free), relations, GENERIC):
            values = iter(self._stages.at(point, entries, GENERIC))
            shadows = [{j: next(values) for j in row} for row in self._left]
            if all(s.is_finite() for row in shadows for s in row.values()):
                return shadows
        raise EngineLimit("no point was found at which the linear equations have real values")

    def _choice(self, rows: Sequence[int], shadows: Any) -> tuple[int, int] | None:
        """Least fill-in (Markowitz), numbers first, then the shortest entry."""
        counts: dict[int, int] = {}
        for row in rows:
            for j in self._left[row]:
                counts[j] = counts.get(j, 0) + 1
        candidates = [
            ((len(self._left[row]) - 1) * (counts[j] - 1), not e.is_Number, len(str(e)), row, j)
            for row in rows
            for j, e in self._left[row].items()
            if not shadows[row][j].contains(0)
        ]
        return min(candidates)[-2:] if candidates else None

    def _subtract(self, target: int, source: int, column: int, shadows: Any) -> None:
        left, shadow = self._left[target], shadows[target]
        factor = self._stages.name(left.pop(column) / self._left[source][column])
        ratio = shadow.pop(column) / shadows[source][column]
        for j, entry in self._left[source].items():
            if j != column:
                left[j] = self._stages.name(left.get(j, ZERO) - factor * entry)
                shadow[j] = shadow.get(j, flint.arb(0)) - ratio * shadows[source][j]
                if left[j] == 0:
                    del left[j], shadow[j]
        if factor != se.Integer(0):
            self._steps.append((target, source, factor))


DEPTH = 5
"""How many levels of stages a proof opens."""
SIZE = 400
"""A derivative that opens into more terms than this is opened no further."""
WORK = 20_000
"""The work of one exact proof; a proof that a whole sum is zero may cost twenty times as much."""
LENGTH = 4000
"""An expression with more letters than this is not proved to be zero."""
NEAR = flint.arb("1e-12")
"""What changes by no more than such a part may not change at all."""
PATIENCE = 6
"""So many failed proofs in a row, and a coordinate is tried no more."""


class Cyclic:
    """Finds the coordinates that cancel from stages; ``support`` is what each stage is made of."""

    def __init__(self, coordinates: Sequence[Any]) -> None:
        self.coordinates = list(coordinates)
        self.support: dict[Any, frozenset[Any]] = {}
        self._source = random.Random("voronec cyclic")
        self._points: list[dict[Any, Any]] = [{} for _ in range(len(self.coordinates) + 1)]
        self._slopes: dict[tuple[Any, Any], Any] = {}
        self._branches: dict[tuple[Any, Any], bool] = {}
        self._failures = dict.fromkeys(coordinates, 0)
        self._lost = 0

    def add(self, symbol: Any, expr: Any) -> None:
        """Take note of a new stage."""
        self.support[symbol] = support = self.free_symbols(expr)
        for point, values in zip(self._points, self._values([expr], support), strict=True):
            point[symbol] = values[0]

    def free_symbols(self, expr: Any) -> frozenset[Any]:
        """The symbols, no stages among them, that occur in an expression."""
        symbols: set[Any] = set()
        for w in expr.free_symbols:
            symbols |= self.support.get(w, {w})
        return frozenset(symbols)

    def absent(self, expr: Any, stages: Stages) -> Iterator[Any]:
        """Coordinates that occur in the expression and are proved to cancel."""
        support = self.free_symbols(expr)
        (there,), *moved = self._values([expr], support)
        for q, (value,) in zip(self.coordinates, moved, strict=True):
            if q not in support or self._failures[q] >= PATIENCE:
                continue
            if not abs(value - there) <= NEAR * abs(there):
                continue
            if self._cancels(expr, q, stages):
                self._failures[q] = 0
                yield q
            else:
                self._failures[q] += 1

    def vanishes(self, expr: Any, stages: Stages) -> bool:
        """Whether a sum is proved to be zero."""
        values, *_ = self._values(expr.args, ())
        small = abs(sum(values)) <= NEAR * abs(max(values, key=abs))
        if not small or self._lost >= PATIENCE:
            return False
        for _ in range(DEPTH + 1):
            inside = {w: stages.definitions[w] for w in expr.free_symbols & self.support.keys()}
            if not inside or len(str(expr)) > LENGTH:
                break
            expr = expr.xreplace(inside)
            if _is_zero(expr, 20 * WORK):
                return True
        self._lost += 1
        return False

    def _cancels(self, expr: Any, q: Any, stages: Stages) -> bool:
        """Whether an expression is proved not to depend on a coordinate."""
        if not self._has_branches(expr, q, stages):
            return self._is_proved(expr, q, stages)
        # what has many branches may be the same in two stages; to open more of them costs too much
        nearest = islice(self._expansions(expr, q, stages), 2)
        return any(q not in self.free_symbols(e) for e in nearest)

    def _has_branches(self, expr: Any, q: Any, stages: Stages) -> bool:
        """Whether no slope along the coordinate means less than that it cancels: q/sqrt(q^2) has
        none, and two values."""
        inner = [w for w in expr.free_symbols if q in self.support.get(w, ())]
        moving = {q, *inner}
        for node in filter(is_branching, nodes([expr])):
            for arg in node.args:
                if arg.free_symbols & moving and not self._cancels(arg, q, stages):
                    return True
        for w in inner:
            if (w, q) not in self._branches:
                self._branches[w, q] = self._has_branches(stages.definitions[w], q, stages)
        return any(self._branches[w, q] for w in inner)

    def _is_proved(self, expr: Any, q: Any, stages: Stages) -> bool:
        for slope in self._expansions(self._slope(expr, q, stages), q, stages):
            if slope == 0:
                return True
        return _is_zero(slope, WORK)

    def _expansions(self, expr: Any, q: Any, stages: Stages) -> Iterator[Any]:
        """An expression, and with the stages in it that hold a coordinate opened and expanded,
        again and again."""
        yield expr
        inner = stages.definitions
        for _ in range(DEPTH):
            held = [w for w in expr.free_symbols if w in inner and q in self.support[w]]
            inside = {w: inner[w] for w in held}
            opened = expr.xreplace(inside)
            if not inside or spread_length(opened, SIZE) > SIZE:
                break
            expr = se.expand(opened)
            yield expr

    def _slope(self, expr: Any, q: Any, stages: Stages) -> Any:
        """The derivative along a coordinate, in stages; none is opened."""
        terms = [expr.diff(q)]
        for w in expr.free_symbols:
            if w in stages.definitions and q in self.support[w]:
                if (w, q) not in self._slopes:
                    slope = self._slope(stages.definitions[w], q, stages)
                    self._slopes[w, q] = stages.name_of_sum(slope)
                terms.append(expr.diff(w) * self._slopes[w, q])
        return se.expand(se.Add(*terms))

    def _values(self, exprs: Sequence[Any], support: Collection[Any]) -> list[list[Any]]:
        """Balls around expressions of a support at a point, then with each coordinate moved alone;
        infinite ones where they are undefined."""
        tape = Tape(exprs)
        for atom in tape.atoms:
            if atom not in self._points[0]:
                centre, step = flint.arb(self._source.uniform(0.3, 0.9)), flint.arb(0.173)
                for point, q in zip(self._points, (None, *self.coordinates), strict=True):
                    point[atom] = centre + step * (q in atom.free_symbols)
        here = tape.arb(self._points[0], GENERIC)
        moved = zip(self.coordinates, self._points[1:], strict=True)
        return [here, *(tape.arb(at, GENERIC) if q in support else here for q, at in moved)]


def _is_zero(expr: Any, work: int) -> bool:
    try:
        return bool(Ring([expr], (), work).fraction(expr).num == 0)
    except (EngineLimit, ZeroDivisionError):
        return False


ZERO, ONE = se.Integer(0), se.Integer(1)


def _linear_combination(pairs: Iterable[tuple[Any, Any]]) -> Any:
    """The sum of the products of pairs."""
    return se.Add(*[a * b for a, b in pairs if a != 0 and b != 0])


def coefficient(term: Any) -> Any:
    """The number in front of a term."""
    if term.is_Number:
        return term
    if isinstance(term, se.Mul) and term.args[0].is_Number:
        return term.args[0]
    return ONE


EXACT = 2**53
"""The largest of the whole numbers that doubles all hold."""


def primitive(total: Any) -> tuple[Any, Any]:
    """A sum as number * sum, the second with whole coprime coefficients and few minus signs.

    Where doubles do not hold these, the largest is 1 and the others are fractions.
    """
    numbers = [coefficient(t) for t in total.args]
    if not all(isinstance(c, se.Rational) for c in numbers):
        return ONE, total
    top = math.gcd(*(abs(int(c.p)) for c in numbers))
    factor = se.Integer(top) / math.lcm(*(int(c.q) for c in numbers))
    largest = max(map(abs, numbers))
    if largest / factor > EXACT:
        factor = largest
    negative = sum(int(c.p) < 0 for c in numbers)
    if 2 * negative > len(numbers):
        factor = -factor
    return factor, total if factor == 1 else se.Add(*[t / factor for t in total.args])


def _sorted_stages(definitions: Mapping[Any, Any]) -> dict[Any, Any]:
    """The stages, each after those it uses."""
    return {x: definitions[x] for x in needed_stages(definitions, definitions)}


def needed_stages(definitions: Mapping[Any, Any], results: Iterable[Any]) -> list[Any]:
    """The stages that results need, each after those it uses."""
    done: dict[Any, None] = {}
    for result in results:
        stack = [result] if result in definitions else _uses(definitions, result)
        while stack:
            x = stack[-1]
            missing = [] if x in done else [w for w in _uses(definitions, definitions[x])
                                            if w not in done]  # fmt: skip
            if missing:
                stack += missing
            else:
                done[stack.pop()] = None
    return list(done)


def _uses(definitions: Mapping[Any, Any], expr: Any) -> list[Any]:
    return sorted((w for w in se.sympify(expr).free_symbols if w in definitions), key=str)


class Stages:
    """A growing program; ``definitions`` holds the stages, each after those it uses.

    Names are ``prefix0, prefix1, ...``.  With ``cyclic``, stages that are proved not to depend on
    a coordinate are written without it.
    """

    def __init__(self, prefix: str, cyclic: Cyclic | None = None) -> None:
        self.definitions: dict[Any, Any] = {}
        self._prefix = prefix
        self._names: dict[Any, Any] = {}
        self._flat: dict[Any, Any] = {}
        self._cyclic = cyclic
        self._count = count()

    def name(self, expr: Any) -> Any:
        """The expression with every sum in it, and itself if it is one, replaced by its name."""
        expr = se.sympify(expr)
        if not expr.args or is_atom(expr):
            return expr
        if is_flat(expr):
            return ZERO
        known = self._flat.get(expr)
        if known is None:
            args = [self.name(a) for a in expr.args]
            if isinstance(expr, se.Add):
                known = self._sum(se.Add(*args))
            elif isinstance(expr, se.Mul):
                known = se.Mul(*args)
            else:
                known = expr if args == list(expr.args) else expr.func(*args)
            self._flat[expr] = known
        return known

    def total(self, pairs: Iterable[tuple[Any, Any]]) -> Any:
        """The name of the sum of the products of pairs."""
        return self.name(_linear_combination(pairs))

    def replace(self, definitions: Mapping[Any, Any]) -> None:
        """Exchange the stages for an equivalent set."""
        self.definitions = _sorted_stages(definitions)
        self._names = {e: x for x, e in self.definitions.items()}
        self._flat = {}

    def fresh(self) -> Any:
        """A name for a further stage."""
        return se.Symbol(f"{self._prefix}{next(self._count)}")

    def at(self, point: Mapping[Any, Any], exprs: Sequence[Any], bits: int) -> list[Any]:
        """Enclosures of expressions in stages, at a point for what is no stage."""
        values = dict(point)
        for x in needed_stages(self.definitions, exprs):
            values[x] = Tape([self.definitions[x]]).arb(values, bits)[0]
        return Tape(exprs).arb(values, bits)

    def name_of_sum(self, expr: Any) -> Any:
        """The name of a sum of products of stages and symbols, as it stands."""
        return self._sum(expr, False)

    def _sum(self, expr: Any, shorten: bool = True) -> Any:
        if not isinstance(expr, se.Add):
            return expr
        factor, expr = primitive(expr)
        if expr in self._names:
            return factor * self._names[expr]
        opposite = se.Add(*[-t for t in expr.args])
        if opposite in self._names:
            return -factor * self._names[opposite]
        if self._cyclic is not None and shorten:
            if self._cyclic.vanishes(expr, self):
                self._names[expr] = ZERO
                return ZERO
            for q in self._cyclic.absent(expr, self):
                shorter = self._without(expr, q)
                if shorter is not None:
                    self._names[expr] = shorter
                    return factor * shorter
        symbol = self.fresh()
        self._names[expr] = symbol
        self.definitions[symbol] = expr
        if self._cyclic is not None:
            self._cyclic.add(symbol, expr)
        return factor * symbol

    def _without(self, expr: Any, coordinate: Any) -> Any:
        """The expression at coordinate = 0, where that makes sense."""
        assert self._cyclic is not None
        point = {coordinate: ZERO}
        for w in expr.free_symbols:
            if w in self.definitions and coordinate in self._cyclic.support[w]:
                point[w] = self._without(self.definitions[w], coordinate)
                if point[w] is None:
                    return None
        result = expr.xreplace(point)
        if not _is_finite(result):
            return None
        return self.name(result)


def _is_finite(expr: Any) -> bool:
    return not any(bad in str(expr) for bad in ("zoo", "nan", "oo"))

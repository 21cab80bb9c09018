"""Straight-line programs of sums: every sum has a name, products stay open.

A derivative of such a program is again one, made stage by stage, and a derivative that is a sum met
before (up to a factor) is found again, not written a second time: the derivative of
cos(a)*x + sin(a)*y is the stage cos(a)*y - sin(a)*x.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import count
from typing import Any

import symengine as se

from voronec.algebra.cyclic import Cyclic
from voronec.algebra.tape import Tape, is_atom

__all__ = ["Stages", "linear_combination", "needed", "primitive", "sorted_stages"]

ZERO, ONE = se.Integer(0), se.Integer(1)


def linear_combination(pairs: Iterable[tuple[Any, Any]]) -> Any:
    """The sum of the products of pairs."""
    return se.Add(*[a * b for a, b in pairs if a != 0 and b != 0])


def coefficient(term: Any) -> Any:
    """The number in front of a term."""
    if term.is_Number:
        return term
    if isinstance(term, se.Mul) and term.args[0].is_Number:
        return term.args[0]
    return ONE


def primitive(total: Any) -> tuple[Any, Any]:
    """A sum as number * sum, the second with whole coprime coefficients and few minus signs."""
    numbers = [coefficient(t) for t in total.args]
    if not all(isinstance(c, se.Rational) for c in numbers):
        return ONE, total
    top = math.gcd(*(abs(int(c.p)) for c in numbers))
    factor = se.Integer(top) / math.lcm(*(int(c.q) for c in numbers))
    negative = sum(int(c.p) < 0 for c in numbers)
    if 2 * negative > len(numbers):
        factor = -factor
    return factor, total if factor == 1 else se.Add(*[t / factor for t in total.args])


def sorted_stages(definitions: Mapping[Any, Any]) -> dict[Any, Any]:
    """The same stages, each after those it uses."""
    return {x: definitions[x] for x in needed(definitions, definitions)}


def needed(definitions: Mapping[Any, Any], results: Iterable[Any]) -> list[Any]:
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
        return self.name(linear_combination(pairs))

    def replaced(self, definitions: Mapping[Any, Any]) -> None:
        """Exchange the stages for an equivalent set."""
        self.definitions = sorted_stages(definitions)
        self._names = {e: x for x, e in self.definitions.items()}
        self._flat = {}

    def fresh(self) -> Any:
        """A name for a further stage."""
        return se.Symbol(f"{self._prefix}{next(self._count)}")

    def at(self, point: Mapping[Any, Any], exprs: Sequence[Any], bits: int) -> list[Any]:
        """Enclosures of expressions in stages, at a point for what is no stage."""
        values = dict(point)
        for x in needed(self.definitions, exprs):
            values[x] = Tape([self.definitions[x]]).arb(values, bits)[0]
        return Tape(exprs).arb(values, bits)

    def written(self, expr: Any) -> Any:
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

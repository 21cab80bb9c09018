"""Coordinates on which a stage does not depend, although they occur in it.

Where a system does not change when a coordinate is shifted, the coordinate cancels from what is
computed, but no rewriting rule sees it.  Values at neighbouring points suggest the cancellation;
the derivative, expanded until it is zero, proves it.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import symengine as se

from voronec.algebra.ring import Ring
from voronec.algebra.tape import is_atom
from voronec.errors import EngineLimit

if TYPE_CHECKING:
    from voronec.algebra.stages import Stages

__all__ = ["Cyclic"]

DEPTH = 5
"""How many levels of stages a proof opens."""
SIZE = 400
"""A derivative that opens into more terms than this is opened no further."""
WORK = 20_000
"""The work of one exact proof; a proof that a whole sum is zero may cost twenty times as much."""
LENGTH = 4000
"""An expression with more letters than this is not proved to be zero."""
PATIENCE = 6
"""So many failed proofs in a row, and a coordinate is tried no more."""

_FUNCTIONS: dict[type, Callable[[float], float]] = {
    se.sin: math.sin,
    se.cos: math.cos,
    se.tan: math.tan,
    se.asin: math.asin,
    se.acos: math.acos,
    se.atan: math.atan,
    se.sinh: math.sinh,
    se.cosh: math.cosh,
    se.tanh: math.tanh,
    se.log: math.log,
}


class Cyclic:
    """Finds the coordinates that cancel from stages; ``support`` is what each stage is made of."""

    def __init__(self, coordinates: Sequence[Any]) -> None:
        self.coordinates = list(coordinates)
        self.support: dict[Any, frozenset[Any]] = {}
        self._source = random.Random("voronec cyclic")
        self._values: dict[Any, tuple[float, ...]] = {}
        self._slopes: dict[tuple[Any, Any], Any] = {}
        self._failures = dict.fromkeys(coordinates, 0)
        self._lost = 0

    def add(self, symbol: Any, expr: Any) -> None:
        """Take note of a new stage."""
        self.support[symbol] = self.made_of(expr)
        self._values[symbol] = self._value(expr)

    def made_of(self, expr: Any) -> frozenset[Any]:
        """The symbols, no stages among them, that occur in an expression."""
        found: set[Any] = set()
        for w in expr.free_symbols:
            found |= self.support.get(w, {w})
        return frozenset(found)

    def absent(self, expr: Any, stages: Stages) -> Iterator[Any]:
        """Coordinates that occur in the expression and are proved to cancel."""
        support = self.made_of(expr)
        values = self._value(expr)
        for index, q in enumerate(self.coordinates):
            if q not in support or self._failures[q] >= PATIENCE:
                continue
            change = abs(values[index + 1] - values[0])
            if not change <= 1e-10 * abs(values[0]):
                continue
            if self._proved(expr, q, stages):
                self._failures[q] = 0
                yield q
            else:
                self._failures[q] += 1

    def vanishes(self, expr: Any, stages: Stages) -> bool:
        """Whether a sum is proved to be zero."""
        values = [self._value(t)[0] for t in expr.args]
        if not all(map(math.isfinite, values)):
            return False
        small = abs(math.fsum(values)) <= 1e-12 * max(map(abs, values))
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

    def _proved(self, expr: Any, q: Any, stages: Stages) -> bool:
        slope = self._slope(expr, q, stages)
        inner = stages.definitions
        for _ in range(DEPTH):
            if slope == 0:
                return True
            inside = {
                w: inner[w] for w in slope.free_symbols if w in inner and q in self.support[w]
            }
            if not inside or _terms(slope, inside) > SIZE:
                break
            slope = se.expand(slope.xreplace(inside))
        if slope == 0:
            return True
        return _is_zero(slope, WORK)

    def _slope(self, expr: Any, q: Any, stages: Stages) -> Any:
        """The derivative along a coordinate, in stages; none is opened."""
        terms = [expr.diff(q)]
        for w in expr.free_symbols:
            if w in stages.definitions and q in self.support[w]:
                if (w, q) not in self._slopes:
                    slope = self._slope(stages.definitions[w], q, stages)
                    self._slopes[w, q] = stages.written(slope)
                terms.append(expr.diff(w) * self._slopes[w, q])
        return se.expand(se.Add(*terms))

    def _value(self, expr: Any) -> tuple[float, ...]:
        """Values at a point, then with each coordinate moved alone; nan where undefined."""
        known = self._values.get(expr)
        if known is None:
            try:
                known = self._computed(expr)
            except (ValueError, TypeError, ZeroDivisionError, OverflowError, KeyError):
                known = (math.nan,) * (len(self.coordinates) + 1)
            self._values[expr] = known
        return known

    def _computed(self, expr: Any) -> tuple[float, ...]:
        width = len(self.coordinates) + 1
        if is_atom(expr):
            return self._atom(expr)
        if expr.is_Number or not expr.args:
            return (float(expr),) * width
        args = [self._value(a) for a in expr.args]
        if isinstance(expr, se.Add):
            return tuple(map(math.fsum, zip(*args, strict=True)))
        if isinstance(expr, se.Mul):
            return tuple(map(math.prod, zip(*args, strict=True)))
        if isinstance(expr, se.Pow):
            return tuple(_power(b, e) for b, e in zip(*args, strict=True))
        return tuple(map(_FUNCTIONS[type(expr)], args[0]))

    def _atom(self, atom: Any) -> tuple[float, ...]:
        centre = self._source.uniform(0.3, 0.9)
        moved = (centre + 0.173 * (q in atom.free_symbols) for q in self.coordinates)
        return (centre, *moved)


def _is_zero(expr: Any, work: int) -> bool:
    try:
        return bool(Ring([expr], (), work).fraction(expr).num == 0)
    except (EngineLimit, ZeroDivisionError):
        return False


def _terms(expr: Any, inside: Mapping[Any, Any]) -> int:
    """How many terms a sum has at most, once stages are opened and everything is expanded."""
    total = 0
    for term in expr.args if isinstance(expr, se.Add) else (expr,):
        count = 1
        for factor in term.args if isinstance(term, se.Mul) else (term,):
            base, power = factor.args if isinstance(factor, se.Pow) else (factor, se.Integer(1))
            if base in inside and isinstance(inside[base], se.Add):
                count *= len(inside[base].args) ** min(abs(int(float(power))) or 1, 9)
        total += count
    return total


def _power(base: float, exponent: float) -> float:
    value = base**exponent
    if isinstance(value, complex):
        raise TypeError("a root of a negative number")
    return float(value)

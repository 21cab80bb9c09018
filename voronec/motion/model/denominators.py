"""Denominators without cancellation: on the relations, sums of squares in place of differences.

The normal form of an angle's rate on the Poisson vector has the denominator (1 + z) (z - 1), which
near a pole, z = 1 - 1e-14, is all rounding.  On |(x, y, z)|^2 = 1 it is -(x^2 + y^2), whose terms
cannot cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import symengine as se

__all__ = ["with_positive_denominators"]


def with_positive_denominators(expr: Any, relations: Sequence[Any]) -> Any:
    """An expression with denominators that equal a sum of squares, where ``relations`` vanish,
    written as that sum."""
    expanded = [r for r in map(se.expand, relations) if _constant(r) != 0]
    return _rewrite(expr, expanded, {}) if expanded else expr


def _rewrite(expr: Any, relations: Sequence[Any], done: dict[Any, Any]) -> Any:
    if not expr.args:
        return expr
    if expr not in done:
        found = expr.func(*[_rewrite(a, relations, done) for a in expr.args])
        if isinstance(found, se.Mul | se.Pow):
            found = _divide(found, relations)
        done[expr] = found
    return done[expr]


def _divide(product: Any, relations: Sequence[Any]) -> Any:
    """A product, with single factors and pairs of its denominator replaced."""
    factors = product.args if isinstance(product, se.Mul) else (product,)
    below = {
        f.args[0]: int(-f.args[1])
        for f in factors
        if isinstance(f, se.Pow) and isinstance(f.args[1], se.Integer) and f.args[1] < 0
    }
    for count in (1, 2):
        for bases in combinations([b for b in below if isinstance(b, se.Add)], count):
            power = min((below[b] for b in bases), default=0)
            sign, squares = _as_squares(se.Mul(*bases), relations) if power else (1, None)
            if squares is not None:
                product = product * se.Mul(*bases) ** power * sign**power / squares**power
                below = {b: n - power * (b in bases) for b, n in below.items()}
    return product


def _as_squares(divisor: Any, relations: Sequence[Any]) -> tuple[int, Any | None]:
    """The sign and the sum of squares that a divisor is where the relations vanish, if it is one:
    a multiple of a relation takes its constant term away."""
    poly = se.expand(divisor)
    size = _constant(poly)
    for relation in relations:
        found = se.expand(poly - size / _constant(relation) * relation)
        # a sum of all the squares never vanishes: then nothing cancels as it is
        vanishes = found.free_symbols < relation.free_symbols
        for sign in (1, -1) if size != 0 and found != 0 and vanishes else ():
            if _is_positive(se.expand(sign * found)):
                return sign, se.expand(sign * found)
    return 1, None


def _constant(poly: Any) -> Any:
    """The constant term of an expanded polynomial, a number."""
    terms = poly.args if isinstance(poly, se.Add) else (poly,)
    return se.Add(*[t for t in terms if t.is_Number])


def _is_positive(poly: Any) -> bool:
    """Whether every term is a positive number times even powers of symbols."""
    terms = poly.args if isinstance(poly, se.Add) else (poly,)
    return all(_is_square(f) for t in terms for f in (t.args if isinstance(t, se.Mul) else (t,)))


def _is_square(factor: Any) -> bool:
    if factor.is_Number:
        return bool(factor > 0)
    if not isinstance(factor, se.Pow) or not factor.args[0].is_Symbol:
        return False
    power = factor.args[1]
    return isinstance(power, se.Integer) and power > 0 and int(power) % 2 == 0

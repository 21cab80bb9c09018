"""What a straight-line program costs: for Taylor's method, and for methods that evaluate it.

Taylor's method of order p computes p coefficients of every intermediate quantity.  A sum, or a
product with a constant, takes p operations; a product of two moving quantities takes a convolution,
p^2 / 2 multiplications and as many additions.  So at the orders in use only the nonlinear
operations count, and everything made of parameters and numbers alone is free.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import symengine as se

from voronec.algebra.numeric_functions import formula

SQUARE, QUOTIENT, ROOT, POWER = 0.5, 1.1, 1.2, 1.5
"""A square: half of the products in its convolution occur twice.  The others, and the functions
below, in products of two moving quantities: measured with heyoka 7 at order 20."""
FUNCTIONS = {
    "exp": 1.4, "log": 1.4, "sin": 2.8, "cos": 2.8, "sinh": 2.8, "cosh": 2.8, "tan": 2.6,
    "tanh": 2.6, "asin": 2.8, "acos": 2.8, "atan": 2.0, "asinh": 2.8, "acosh": 2.8, "atanh": 2.0,
    "atan2": 4.5, "cot": 4.1, "coth": 4.1, "sec": 4.3, "csc": 4.3, "acot": 3.5, "Abs": 0.1,
    "sign": 0.1,
}  # fmt: skip
"""A sine brings its cosine, and the other way."""
PAIRS = {"sin": "cos", "cos": "sin", "sinh": "cosh", "cosh": "sinh"}
UNKNOWN = 4.0
"""Any other function."""
LINEAR = 0.02
"""A sum or a product with a constant: breaks ties, and counts in very large programs."""
CALL = 10
"""A function costs a method that evaluates about as much as ten sums."""


def taylor_weight(
    assignments: Iterable[tuple[Any, Any]], results: Iterable[Any], constants: Iterable[Any]
) -> float:
    """The cost in products of moving quantities.

    ``constants`` are the symbols that do not move; assigned names that hold only those are
    constant too.  What occurs twice is counted once.
    """
    weighing = _Walk(constants)
    total = 0.0
    for name, expr in assignments:
        total += weighing.of(se.sympify(expr))
        if not weighing.moves(se.sympify(expr)):
            weighing.still.add(name)
    return total + sum(weighing.of(se.sympify(e)) for e in results)


def evaluation_weight(expressions: Iterable[Any]) -> int:
    """The cost of one evaluation in additions: functions, roots and quotients cost more."""
    seen: set[Any] = set()
    stack, total = [se.sympify(e) for e in expressions], 0
    while stack:
        node = stack.pop()
        if not node.args or node in seen or node.is_Number:
            continue
        seen.add(node)
        plain = formula(node)
        stack += node.args if plain is None else (plain,)
        if isinstance(node, se.Add | se.Mul):
            total += len(node.args) - 1
        elif isinstance(node, se.Pow) and node.args[1].is_Number:
            total += _power_steps(node.args[1])
        elif plain is None:
            total += CALL
    return total


def _power_steps(exponent: Any) -> int:
    if not isinstance(exponent, se.Integer):
        return CALL
    size = abs(int(exponent))
    return size.bit_length() + bin(size).count("1") - 2 + (4 if exponent < 0 else 0)


class _Walk:
    """One walk over expressions that share subexpressions."""

    def __init__(self, constants: Iterable[Any]) -> None:
        self.still = set(constants)
        self._seen: set[Any] = set()
        self._moving: dict[Any, bool] = {}

    def moves(self, expr: Any) -> bool:
        """Whether anything in an expression moves."""
        if not expr.args:
            return isinstance(expr, se.Symbol) and expr not in self.still
        moving = self._moving.get(expr)
        if moving is None:
            moving = self._moving[expr] = any(self.moves(a) for a in expr.args)
        return moving

    def of(self, expr: Any) -> float:
        """The cost of an expression, less what was counted before."""
        if not expr.args or expr in self._seen or not self.moves(expr):
            return 0.0
        self._seen.add(expr)
        plain = formula(expr)
        if plain is not None:
            return self.of(plain)
        moving = [a for a in expr.args if self.moves(a)]
        if isinstance(expr, se.Add):
            return LINEAR * (len(expr.args) - 1) + sum(self.of(a) for a in moving)
        if isinstance(expr, se.Mul):
            return self._product(expr, moving)
        if isinstance(expr, se.Pow):
            return _power(expr, self.moves(expr.args[1])) + sum(self.of(a) for a in moving)
        return self._function(expr) + sum(self.of(a) for a in moving)

    def _product(self, expr: Any, moving: Sequence[Any]) -> float:
        """Factors over factors: the quotient is one operation, whatever stands above."""
        below = [a for a in moving if _is_below(a)]
        above = len(moving) - len(below)
        products = max(above - 1, 0) + max(len(below) - 1, 0)
        total = LINEAR * (len(expr.args) - len(moving)) + products
        total += (QUOTIENT if above else POWER) if below else 0.0
        for a in moving:
            total += self.of(1 / a) if _is_below(a) else self.of(a)
        return total

    def _function(self, expr: Any) -> float:
        name = type(expr).__name__
        partner = PAIRS.get(name)
        if partner:
            self._seen.add(getattr(se, partner)(*expr.args))
        return FUNCTIONS.get(name, UNKNOWN)


def _is_below(factor: Any) -> bool:
    """Whether a factor stands under the fraction bar."""
    return isinstance(factor, se.Pow) and factor.args[1].is_Number and bool(factor.args[1] < 0)


def _power(expr: Any, moving_exponent: bool) -> float:
    exponent = expr.args[1]
    if moving_exponent:
        return FUNCTIONS["exp"] + (1 + FUNCTIONS["log"] if expr.args[0] != se.E else 0)
    special = {se.Integer(2): SQUARE, se.Rational(1, 2): ROOT}
    return special.get(exponent, POWER)


def operation_count(expressions: Iterable[Any]) -> int:
    """How many additions, products, quotients and functions expressions take as they are written:
    what is subtracted costs no more than what is added, and x^n as many products as squaring
    needs."""
    return sum(_operation_count(se.sympify(e)) for e in expressions)


def _operation_count(expr: Any) -> int:
    if not expr.args or expr.is_Number:
        return 0
    if isinstance(expr, se.Add):
        signs = [_is_negative(a) for a in expr.args]
        inner = sum(_operation_count(-a if n else a) for a, n in zip(expr.args, signs, strict=True))
        return len(signs) - 1 + inner + all(signs)
    if isinstance(expr, se.Mul):
        total = sum(_operation_count(1 / a if _is_below(a) else a) for a in expr.args)
        return total + len(expr.args) - 1 + all(_is_below(a) for a in expr.args)
    if isinstance(expr, se.Pow):
        base, exponent = expr.args
        if isinstance(exponent, se.Integer):
            size = abs(int(exponent))
            steps = size.bit_length() + size.bit_count() - 2
            return _operation_count(base) + steps + int(exponent < 0)
        below = exponent.is_Number and exponent < 0
        return _operation_count(base) + _operation_count(exponent) + 1 + int(below)
    return 1 + sum(map(_operation_count, expr.args))


def _is_negative(term: Any) -> bool:
    """Whether a term is subtracted."""
    first = term.args[0] if isinstance(term, se.Mul) else term
    return bool(first.is_Number and first < 0)

"""Expressions of symengine in parts: all of them, terms, factors, rational numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import inf
from typing import Any

import symengine as se
from symengine.lib.symengine_wrapper import Boolean


def rational(number: Any) -> Any:
    """A rational number of flint or SymPy as one of symengine."""
    return se.Integer(int(number.p)) / se.Integer(int(number.q))


def subexpressions(
    exprs: Iterable[Any], is_leaf: Callable[[Any], bool] = lambda _: False
) -> Iterator[Any]:
    """Every part of expressions, and of what stands inside of derivatives, each once: written out,
    graphs that share parts are too large.  Nothing is looked for inside of a leaf."""
    seen, waiting = set[Any](), list(exprs)
    while waiting:
        node = waiting.pop()
        if node not in seen:
            seen.add(node)
            yield node
            waiting += () if is_leaf(node) else node.args


def atoms(exprs: Iterable[Any], *kinds: type) -> set[Any]:
    """Every part of some kinds.  symengine's own search takes a part that is shared as often as it
    stands: 2^n times, where n sums of two are nested."""
    return {part for part in subexpressions(map(se.sympify, exprs)) if isinstance(part, kinds)}


def summands(expr: Any) -> tuple[Any, ...]:
    """The terms of a sum; anything else is its only term."""
    return expr.args if isinstance(expr, se.Add) else (expr,)


def ordered_terms(expr: Any) -> tuple[Any, ...]:
    """The arguments of an expression, terms of a sum in an order that outlives a process, as that
    of SymEngine does not."""
    return tuple(sorted(expr.args, key=hash)) if isinstance(expr, se.Add) else expr.args


def factors_of(expr: Any) -> tuple[Any, ...]:
    """The factors of a product; anything else is its only factor."""
    return expr.args if isinstance(expr, se.Mul) else (expr,)


MOST_TERMS = 2000
"""Sums of more terms are not made of products: they take a tenth of a second, or never end."""


def expand_short(expr: Any) -> Any:
    """Products of sums written out, in functions too, where that does not make too many terms; else
    the expression as it is."""
    return expr.expand() if spread_length(expr, MOST_TERMS) <= MOST_TERMS else expr


def spread_length(expr: Any, most: float) -> float:
    """About how many terms there are with products of sums written out, and in functions."""
    total, product = 0.0, 1.0
    for arg in expr.args:
        length = spread_length(arg, most)
        total, product = total + length, product * length
        if total > most:
            return inf
    if isinstance(expr, se.Mul):
        return max(total, product)
    if isinstance(expr, se.Pow) and isinstance(expr.args[1], se.Integer) and total > 2:
        return (total - 1) ** min(abs(int(expr.args[1])), 64)  # more is beyond all bounds
    return max(total, 1.0)


def is_exponential(expr: Any) -> bool:
    """Whether an expression is exp(w), which symengine has for a power of e."""
    return isinstance(expr, se.Pow) and bool(expr.args[0] == se.E)


def is_fraction(exponent: Any) -> bool:
    """Whether it is a rational number and not a whole one: what is raised to it is a root."""
    return isinstance(exponent, se.Rational) and not isinstance(exponent, se.Integer)


def with_arguments(expr: Any, args: list[Any]) -> Any:
    """A function, sum or product of equal arguments, written otherwise; conditions stay as
    they are."""
    if args == list(expr.args) or isinstance(expr, Boolean):
        return expr
    if isinstance(expr, se.Piecewise):  # takes its cases in pairs
        return se.Piecewise(*zip(args[::2], args[1::2], strict=True))
    return expr.func(*args)


class Rewriter:
    """Rewrites expressions from the inside out: a part is what ``change(part, rewriter)`` makes of
    it, once."""

    def __init__(self, change: Callable[[Any, Rewriter], Any]) -> None:
        self._change = change
        self._known: dict[Any, Any] = {}

    def __call__(self, expr: Any) -> Any:
        """What an expression becomes."""
        changed = self._known.get(expr)
        if changed is None:
            changed = self._known[expr] = self._change(expr, self)
        return changed


def rewrite_kinds(expr: Any, kinds: type | tuple[type, ...], change: Callable[[Any], Any]) -> Any:
    """An expression with every part of some kinds changed, inner ones first."""

    def each(part: Any, inner: Rewriter) -> Any:
        if not part.args or part.is_Number:
            return part
        whole = part.func(*map(inner, part.args))
        return change(whole) if isinstance(whole, kinds) else whole

    return Rewriter(each)(expr)

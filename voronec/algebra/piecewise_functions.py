"""Functions in pieces written with absolute values, signs and floors.

Steps, limits and cases are such functions.  Absolute values, signs and floors are what the engine
knows of cuts: an absolute value is a root, and a sign or a floor has no slope off its cut.  What
is written with them has the values of the original on the cuts too, where a sign is zero: an
indicator is (s^2 + s)/2 for g > 0, 1 - s^2 for g = 0, s = sign(g).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import Any

import sympy as sp
from sympy.logic.boolalg import BooleanFunction

from voronec.errors import DefinitionError

HALF = sp.Rational(1, 2)


def written_with_signs(expr: Any) -> sp.Expr | None:
    """A function in pieces by ``Abs``, ``sign`` and ``floor``; None for any other expression.

    The argument is the node itself: what is inside of its arguments stays as it is.
    """
    rule = _RULES.get(type(expr))
    return None if rule is None else rule(expr)


def _step(expr: Any) -> sp.Expr:
    g, middle = expr.args[0], expr.args[1] if len(expr.args) > 1 else HALF
    side = sp.sign(g)
    return (1 + side) / 2 + (middle - HALF) * (1 - side**2)


def _largest(expr: Any) -> sp.Expr:
    return reduce(lambda a, b: (a + b + sp.Abs(a - b)) / 2, sp.ordered(expr.args))


def _least(expr: Any) -> sp.Expr:
    return reduce(lambda a, b: (a + b - sp.Abs(a - b)) / 2, sp.ordered(expr.args))


def _remainder(expr: Any) -> sp.Expr:
    a, b = expr.args
    return a - b * sp.floor(a / b)


def _cases(expr: Any) -> sp.Expr:
    """The first case whose condition holds."""
    total, none_before = sp.Integer(0), sp.Integer(1)
    for value, condition in expr.args:
        here = _indicator(condition)
        total += value * none_before * here
        none_before *= 1 - here
    if none_before != 0 and expr.args[-1][1] != sp.true:
        raise DefinitionError(
            f"'{expr}' says nothing where none of its conditions holds; end it with a case "
            "(value, True)"
        )
    return total


def _indicator(condition: Any) -> sp.Expr:
    """1 where a condition holds, 0 where it does not."""
    if condition in (sp.true, True):
        return sp.Integer(1)
    if condition in (sp.false, False):
        return sp.Integer(0)
    relation = _RELATIONS.get(type(condition))
    if relation is not None:
        return relation(sp.sign(condition.lhs - condition.rhs))
    if isinstance(condition, BooleanFunction) and type(condition) in _CONNECTIVES:
        return _CONNECTIVES[type(condition)]([_indicator(c) for c in condition.args])
    raise DefinitionError(
        f"the condition '{condition}' is not made of comparisons; use <, <=, >, >=, Eq, Ne with "
        "&, | and ~"
    )


_RELATIONS: dict[Any, Callable[[Any], sp.Expr]] = {
    sp.StrictGreaterThan: lambda s: (s**2 + s) / 2,
    sp.StrictLessThan: lambda s: (s**2 - s) / 2,
    sp.GreaterThan: lambda s: 1 - (s**2 - s) / 2,
    sp.LessThan: lambda s: 1 - (s**2 + s) / 2,
    sp.Equality: lambda s: 1 - s**2,
    sp.Unequality: lambda s: s**2,
}
_CONNECTIVES: dict[Any, Callable[[list[Any]], sp.Expr]] = {
    sp.And: sp.prod,
    sp.Or: lambda given: 1 - sp.prod([1 - x for x in given]),
    sp.Not: lambda given: 1 - given[0],
    sp.ITE: lambda given: given[0] * given[1] + (1 - given[0]) * given[2],
    sp.Xor: lambda given: reduce(lambda a, b: a + b - 2 * a * b, given),
}
_RULES: dict[type, Callable[[Any], sp.Expr]] = {
    sp.Heaviside: _step,
    sp.Max: _largest,
    sp.Min: _least,
    sp.Mod: _remainder,
    sp.Piecewise: _cases,
    sp.ceiling: lambda expr: -sp.floor(-expr.args[0]),
    sp.frac: lambda expr: expr.args[0] - sp.floor(expr.args[0]),
}
IN_PIECES = tuple(_RULES)
"""The functions that are written so."""

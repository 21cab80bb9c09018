"""Sums as products of irreducible factors, nested, where that takes fewer operations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import flint
import symengine as se

from voronec.algebra.factors import irreducible_factors, write_polynomial
from voronec.equations.program.straight import factor_exponents, nest_sums
from voronec.equations.program.weight import operation_count
from voronec.errors import EngineLimit

__all__ = ["bracket_sums", "spread_products"]

WIDEST = 60
"""Sums of more terms are not factored."""


Change = Callable[[Any], Any]


def bracket_sums(expr: Any, choice: Any = min) -> Any:
    """An expression whose sums, inner ones first, are nested, or products of the factors that they
    have over Q, functions counted as letters, where that takes fewer operations."""
    return _rewrite(se.sympify(expr), se.Add, lambda total: _shortest(total, choice), {})


def spread_products(expr: Any) -> Any:
    """An expression with sums times single factors as sums, inner ones first.

    Products of two sums stay: written out, their terms may cancel, and digits are lost.
    """
    return _rewrite(se.sympify(expr), se.Mul, _spread, {})


def _rewrite(expr: Any, kind: type, change: Change, memo: dict[Any, Any]) -> Any:
    if not expr.args or expr.is_Number:
        return expr
    if expr not in memo:
        inner = expr.func(*[_rewrite(a, kind, change, memo) for a in expr.args])
        memo[expr] = change(inner) if isinstance(inner, kind) else inner
    return memo[expr]


def _spread(term: Any) -> Any:
    sums = [f for f in term.args if isinstance(f, se.Add)]
    held = any(isinstance(f, se.Pow) and isinstance(f.args[0], se.Add) for f in term.args)
    if len(sums) != 1 or held:
        return term
    factor = term / sums[0]
    return se.Add(*[factor * t for t in sums[0].args])


def _shortest(total: Any, choice: Any) -> Any:
    forms = [total, nest_sums(total, (), choice)]
    flat = se.expand(total)
    if isinstance(flat, se.Add) and len(flat.args) <= WIDEST:
        forms += _factor_forms(flat)
    return min(forms, key=lambda e: operation_count([e]))


def _factor_forms(total: Any) -> list[Any]:
    """A sum as a product of factors, each of them nested; none where it has one factor, or is no
    polynomial over Q."""
    terms = [factor_exponents(t) for t in total.args]
    letters = sorted({b for t in terms for b in t if not b.is_Number}, key=str)
    lowest = [min(t.get(b, 0) for t in terms) for b in letters]
    context = flint.fmpq_mpoly_ctx.get([f"x{i}" for i in range(len(letters))], flint.Ordering.lex)
    polynomial = context.constant(0)
    for t in terms:
        number = se.Mul(*[b**e for b, e in t.items() if b.is_Number])
        if not isinstance(number, se.Rational):
            return []
        exponents = tuple(t.get(b, 0) - low for b, low in zip(letters, lowest, strict=True))
        size = flint.fmpq(int(number.p), int(number.q))
        polynomial += context.from_dict({exponents: size})
    try:
        unit, factors = irreducible_factors(polynomial)
    except EngineLimit:
        return []
    outside = [b**low for b, low in zip(letters, lowest, strict=True)]
    inside = [nest_sums(write_polynomial(f, letters), ()) ** e for f, e in factors]
    if len(factors) == 1 and factors[0][1] == 1 and unit == 1 and not any(lowest):
        return []
    return [se.Mul(se.Integer(int(unit.p)) / int(unit.q), *outside, *inside)]

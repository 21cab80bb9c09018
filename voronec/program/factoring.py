"""Sums rewritten so that fewer products of moving quantities are left.

A normal form is expanded; as it stands a*b*c + a*b*d takes four products, as a*b*(c + d) two.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

import symengine as se

__all__ = ["nested"]


def nested(expr: Any, constants: Iterable[Any]) -> Any:
    """An expression whose sums take the factor that most of their terms share before a bracket,
    and so on inside; ``constants`` are no such factors."""
    return _nested(se.sympify(expr), set(constants), {})


def _nested(expr: Any, still: set[Any], memo: dict[Any, Any]) -> Any:
    if not expr.args or expr.is_Number:
        return expr
    done = memo.get(expr)
    if done is None:
        if isinstance(expr, se.Add):
            terms = [_factors(_nested(t, still, memo)) for t in expr.args]
            done = _bracketed(terms, still)
        else:
            done = expr.func(*[_nested(a, still, memo) for a in expr.args])
        memo[expr] = done
    return done


def _factors(term: Any) -> dict[Any, int]:
    """A term as {factor: exponent}; numbers and odd powers are factors of their own."""
    found: dict[Any, int] = {}
    for factor in term.args if isinstance(term, se.Mul) else [term]:
        base, exponent = factor, 1
        if isinstance(factor, se.Pow) and isinstance(factor.args[1], se.Integer):
            base, exponent = factor.args[0], int(factor.args[1])
        found[base] = found.get(base, 0) + exponent
    return found


def _product(factors: Mapping[Any, int]) -> Any:
    return se.Mul(*[se.Pow(base, e) for base, e in factors.items()])


def _bracketed(terms: list[dict[Any, int]], still: set[Any]) -> Any:
    """The sum of terms, factors that are shared before brackets, the most frequent first."""
    counts: Counter[Any] = Counter()
    for term in terms:
        for base, exponent in term.items():
            if base.is_Number or base.free_symbols <= still:
                continue
            counts[base, 1 if exponent > 0 else -1] += 1
    frequent = max(counts.values(), default=0)
    if frequent < 2 or len(terms) < 2:
        return se.Add(*map(_product, terms))
    (base, sign) = min((k for k, n in counts.items() if n == frequent), key=str)
    inside, outside = [], []
    for term in terms:
        exponent = term.get(base, 0)
        if exponent * sign > 0:
            rest = {b: e for b, e in term.items() if b != base}
            if exponent != sign:
                rest[base] = exponent - sign
            inside.append(rest)
        else:
            outside.append(term)
    bracket = _bracketed(inside, still)
    factor = base if sign > 0 else 1 / base
    if not outside:
        return factor * bracket
    return se.Add(factor * bracket, _bracketed(outside, still))

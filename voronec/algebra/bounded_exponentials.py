"""Quotients of exponentials, written so that nothing overflows.

1/(1 + exp(w)) is exact, and useless in doubles for w > 710.  With y = exp(w) and T = tanh(w/2),
y = (1 + T)/(1 - T); so where P and Q are polynomials in y and no power of y in P lies beyond those
in Q,

    P(y)/Q(y) = (1 - T)^n P / (1 - T)^n Q,    n the degree of Q,

is a quotient of polynomials in T whose denominator does not vanish where exp(w) overflows.  The
hyperbolic functions are sums of exponentials too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import comb, gcd, lcm
from typing import Any

import symengine as se

from voronec.algebra.terms import (
    Rewriter,
    factors_of,
    is_exponential,
    subexpressions,
    summands,
    with_arguments,
)

__all__ = ["bound_all_exponentials", "bound_exponentials", "exponential_sum", "holds_exponentials"]

DEGREE = 6
"""Powers of T up to this one: the sums alternate, and lose more digits the higher they are."""

_Laurent = dict[int, Any]
"""Powers of y with their coefficients."""


def bound_exponentials(expr: Any) -> Any:
    """An equal expression in which quotients of exponentials are bounded functions."""
    return bound_all_exponentials([expr])[0]


def bound_all_exponentials(exprs: Iterable[Any]) -> list[Any]:
    """``bound_exponentials`` of several expressions; what they share is looked at once."""
    given = [se.sympify(e) for e in exprs]
    return [*map(Rewriter(_rewrite), given)] if holds_exponentials(*given) else given


def _rewrite(expr: Any, inner: Rewriter) -> Any:
    if not expr.args:
        return expr
    whole = _quotient(expr) if isinstance(expr, (se.Mul, se.Pow)) else None
    if whole is not None:
        return whole
    # a quotient that is not bounded stays whole: exp(2 w)/(1 + exp(w)) would lose digits
    kept = _below(expr.args) if isinstance(expr, se.Mul) else []
    return with_arguments(expr, [a if a in kept else inner(a) for a in expr.args])


def exponential_sum(expr: Any) -> tuple[Any, dict[int, Any]] | None:
    """(w, {k: c_k}) of a sum of c_k exp(k w) with several terms; None for anything else."""
    found = [w for f in (expr, *expr.args) for w in _arguments(f)]
    terms = _laurent(expr, min(found, key=_size)) if found else None
    return (min(found, key=_size), terms) if terms is not None and len(terms) > 1 else None


def holds_exponentials(*exprs: Any) -> bool:
    """Whether there is an exponential, or a hyperbolic sine or cosine, in some expressions."""
    return any(
        isinstance(node, (se.sinh, se.cosh)) or is_exponential(node)
        for node in subexpressions(exprs)
    )


def _quotient(expr: Any) -> Any | None:
    """A product rewritten; None where it is no quotient of exponentials that is bounded."""
    factors = factors_of(expr)
    if not _below(factors):
        return None
    found = [w for f in factors for w in _arguments(f.args[0] if _is_power(f) else f)]
    argument = _unit(found)
    rest, top, bottom = [], {0: se.Integer(1)}, {0: se.Integer(1)}
    for factor in factors:
        base, power = (factor.args[0], int(factor.args[1])) if _is_power(factor) else (factor, 1)
        terms = _laurent(base, argument)
        if terms is None:
            rest.append(factor)
        else:
            for _ in range(abs(power)):
                top, bottom = (
                    (_times(top, terms), bottom) if power > 0 else (top, _times(bottom, terms))
                )
            if max(len(top), len(bottom)) > 2 * DEGREE:
                return None
    low, high = min(bottom), max(bottom)
    if min(top) < low or max(top) > high or high == low:
        return None
    unit = gcd(*(k - low for k in (*top, *bottom)))  # exp(w) may occur in whole powers alone
    degree = (high - low) // unit
    if degree > DEGREE:
        bounded = _over_two_ends(top, bottom, argument)
        return None if bounded is None else se.Mul(*bound_all_exponentials(rest), bounded)
    tangent = se.tanh(unit * argument / 2)
    numerator, denominator = (
        _in_tangent({(k - low) // unit: c for k, c in p.items()}, degree, tangent)
        for p in (top, bottom)
    )
    return se.Mul(*bound_all_exponentials(rest), numerator) / denominator


def _over_two_ends(top: _Laurent, bottom: _Laurent, argument: Any) -> Any | None:
    """The quotient over c y^m (y^h +- y^-h) = 2 c y^m cosh(h w), or 2 c y^m sinh(h w), whatever h
    is; None over another.

    With T = tanh(n w), S = tanh((h - n) w/2) and 0 <= n <= h, where T and S have the same sign,

        cosh(n w)/cosh(h w) = (1 - S^2)/(1 + S^2 + 2 T S),    sinh(n w) = T cosh(n w).
    """
    (low, c), (high, d) = min(bottom.items()), max(bottom.items())
    if len(bottom) != 2 or c not in (d, -d):
        return None
    half, argument = high - low, argument / 2
    terms = {2 * k - low - high: e for k, e in top.items()}
    total = se.Integer(0)
    for n in sorted({abs(k) for k in terms}):
        t, s = se.tanh(n * argument), se.tanh((half - n) * argument / 2)
        up, down = (terms.get(k, se.Integer(0)) for k in (n, -n))
        both = (up + down if n else up) + (up - down) * t
        total += both * (1 - s**2) / (1 + s**2 + 2 * t * s)
    return total / (2 * d) / (1 if c == d else se.tanh(half * argument))


def _is_power(expr: Any) -> bool:
    return (
        isinstance(expr, se.Pow) and isinstance(expr.args[1], se.Integer) and (expr.args[0] != se.E)
    )


def _below(factors: Iterable[Any]) -> list[Any]:
    """Of the factors of a product those by whose sums of exponentials it is divided."""
    return [f for f in factors if _is_power(f) and f.args[1] < 0 and _arguments(f.args[0])]


def _arguments(expr: Any) -> list[Any]:
    """The w of which a sum, or a hyperbolic function, holds exp(w)."""
    found = []
    for term in summands(expr):
        for factor in factors_of(term):
            if isinstance(factor, (se.sinh, se.cosh)):
                found.append(factor.args[0])
            elif is_exponential(factor):
                found.append(factor.args[1])
    return [w for w in found if w.free_symbols]


def _unit(arguments: Sequence[Any]) -> Any:
    """The largest w of which all arguments are whole multiples, where they are of the least one."""
    least = min(arguments, key=_size)
    ratios = [a / least for a in arguments]
    fractions = [int(r.q) for r in ratios if isinstance(r, se.Rational)]
    return least / lcm(*fractions)


def _size(argument: Any) -> tuple[float, str]:
    numbers = [a for a in argument.args if a.is_Number] if isinstance(argument, se.Mul) else []
    return abs(float(numbers[0])) if numbers else 1.0, str(argument)


def _laurent(expr: Any, argument: Any) -> _Laurent | None:
    """An expression as a polynomial in exp(w) and exp(-w) with at least one such power; None."""
    total: _Laurent = {}
    for term in summands(expr):
        product: _Laurent = {0: se.Integer(1)}
        for factor in factors_of(term):
            part = _single(factor, argument)
            if part is None:
                return None
            product = _times(product, part)
        for k, c in product.items():
            total[k] = total.get(k, se.Integer(0)) + c
    total = {k: c for k, c in total.items() if c != 0}
    return total if any(total) else None


def _single(factor: Any, argument: Any) -> _Laurent | None:
    if isinstance(factor, (se.sinh, se.cosh)):
        n = _multiple(factor.args[0], argument)
        half = se.Rational(1, 2)
        return None if n is None else {n: half, -n: half if isinstance(factor, se.cosh) else -half}
    if is_exponential(factor):
        n = _multiple(factor.args[1], argument)
        return None if n is None else {n: se.Integer(1)}
    return None if holds_exponentials(factor) else {0: factor}


def _multiple(argument: Any, unit: Any) -> int | None:
    ratio = argument / unit
    return int(ratio) if isinstance(ratio, se.Integer) else None


def _times(a: _Laurent, b: _Laurent) -> _Laurent:
    found: _Laurent = {}
    for i, x in a.items():
        for j, y in b.items():
            found[i + j] = found.get(i + j, se.Integer(0)) + x * y
    return {k: c for k, c in found.items() if c != 0} or {0: se.Integer(0)}


def _in_tangent(terms: _Laurent, degree: int, tangent: Any) -> Any:
    """(1 - T)^n times the sum of c y^k, expanded in powers of T."""
    powers: Sequence[Any] = [se.Integer(0)] * (degree + 1)
    for k, c in terms.items():
        up, down = k, degree - k
        powers = [
            p
            + c
            * sum(
                comb(up, i) * comb(down, j - i) * (-1) ** (j - i)
                for i in range(max(0, j - down), min(up, j) + 1)
            )
            for j, p in enumerate(powers)
        ]
    return se.Add(*[p * tangent**j for j, p in enumerate(powers)])

"""Expressions as they are computed: equal to what is given, without overflow and cancellation.

Where a formula is exact and useless in doubles it is written otherwise, for numbers alone:

    sqrt(a^2 + b^2)                     ->  hypot(a, b)
    log(1 + x),   c exp(w) - c          ->  log1p x,   c expm1 w
    log(1 + exp(w))                     ->  (w + |w|)/2 + log1p exp(-|w|)
    1 - cos w,   cosh w - 1             ->  2 sin^2(w/2),   2 sinh^2(w/2)
    sqrt(1 + x) - 1                     ->  x/(sqrt(1 + x) + 1),   2 sinh^2(asinh(y)/2) of x = y^2
    1 - tanh w                          ->  2 exp(-w - |w|)/(1 + exp(-2|w|)), and powers of it
    exp(-w) (a + b exp(w))              ->  a exp(-w) + b

What holds |w| is the same function of w on both sides of w = 0, so that it is no wall there.
Quotients such as sin(w)/w are those of ``cardinal``, quotients of exponentials those of
``bounded_exponentials``.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import symengine as se

from voronec.algebra.bounded_exponentials import exponential_sum
from voronec.algebra.cardinal import cardinal_all
from voronec.algebra.numeric_functions import EXPM1, HYPOT, LOG1P, SIZE
from voronec.algebra.terms import (
    Rewriter,
    expand_short,
    factors_of,
    is_exponential,
    with_arguments,
)

__all__ = ["stable_all"]

NEARBY = se.Rational(1, 8)
"""Numbers that differ by less than this part lose three bits or more by subtraction."""
_Terms = dict[int, Any]
"""Powers with their coefficients."""


def stable_all(exprs: Iterable[Any]) -> list[Any]:
    """Equal expressions, as they are computed."""
    return [*map(Rewriter(_stable), cardinal_all(exprs))]


def _stable(expr: Any, inner: Rewriter) -> Any:
    if not expr.args or isinstance(expr, (se.Derivative, se.Subs)):
        return expr
    whole = _write(expr)
    return with_arguments(whole, [*map(inner, whole.args)])


@lru_cache(2**14)  # programs of one system have their parts in common
def _write(expr: Any) -> Any:
    if isinstance(expr, se.Pow):
        return _root(*expr.args) or expr
    if isinstance(expr, se.log):
        return _logarithm(expr.args[0]) or expr
    if isinstance(expr, se.Mul):
        return _balance(expr)
    if isinstance(expr, se.Add):
        total = _less_one(expr)
        return _with_tails(_with_differences(total)) if isinstance(total, se.Add) else total
    return expr


def _balance(product: Any) -> Any:
    """A product of an exponential and a sum in which its inverse stands, term by term: exp(w) is
    beyond doubles where exp(-w) (a + b exp(w)) is not."""
    factors = factors_of(product)
    sums = [f for f in factors if isinstance(f, se.Add)]
    for power in filter(is_exponential, factors):
        inverse = 1 / power
        for total in sums:
            if any(inverse in factors_of(term) for term in total.args):
                return product / power / total * se.Add(*[power * term for term in total.args])
    return product


def _root(base: Any, exponent: Any) -> Any | None:
    """A root of a sum of squares; None for any other power."""
    if not isinstance(base, se.Add) or not isinstance(exponent, se.Rational) or exponent.q == 1:
        return None
    sides = [_side(term) for term in base.args]
    if any(side is None for side in sides):
        return None
    return se.Function(HYPOT)(*sides) ** (2 * exponent)


def _side(term: Any) -> Any | None:
    """A root of a term that is a square at sight; None of any other."""
    roots = []
    for factor in factors_of(term):
        if factor.is_Number:
            if factor < 0:
                return None
            roots.append(se.sqrt(factor))
        elif isinstance(factor, se.Pow) and _is_even(factor.args[1]):
            roots.append(factor.args[0] ** (factor.args[1] / 2))
        else:
            return None
    return se.Mul(*roots)


def _is_even(exponent: Any) -> bool:
    return isinstance(exponent, se.Integer) and int(exponent) % 2 == 0


def _logarithm(inner: Any) -> Any | None:
    """log of a sum that may lie close to one, or overflow; None of any other."""
    found = exponential_sum(inner)
    if found is None:
        beside = isinstance(inner, se.Add) and se.Integer(1) in inner.args
        return se.Function(LOG1P)(inner - 1) if beside else None
    w, terms = found
    low, high = min(terms), max(terms)
    ends = terms[low], terms[high]
    if len(terms) == 2 and all(c.is_Number and c > 0 for c in ends):
        shift = se.log(ends[1] / ends[0])
        return low * w + se.log(ends[0]) + _soft((high - low) * w + shift)
    middle, size = (low + high) * w / 2, se.Function(SIZE)(w)
    reach = (high - low) * size / 2
    if all(terms.get(low + high - k) == c for k, c in terms.items()) and ends[0].is_Number:
        rest = [c / ends[0] * se.exp((k - high) * size) for k, c in terms.items() if k != high]
        return middle + reach + se.log(ends[0]) + se.Function(LOG1P)(se.Add(*rest))
    return (
        middle
        + reach
        + se.log(se.Add(*[c * se.exp(k * w - middle - reach) for k, c in terms.items()]))
    )


def _soft(w: Any) -> Any:
    """log(1 + exp(w))."""
    size = se.Function(SIZE)(w)
    return (w + size) / 2 + se.Function(LOG1P)(se.exp(-size))


def _with_differences(total: Any) -> Any:
    """A sum in which c exp(w) - c exp(u), u = 0 or a fraction of w, is c exp(u) expm1(w - u)."""
    terms = [_exponential(term) for term in total.args]
    if all(w == 0 for _, w in terms):
        return total
    # the longest exponents first: what they are paired with is a part of them
    terms.sort(key=lambda term: -_length(term[1]))
    left: dict[Any, list[Any]] = {}
    for c, w in terms:
        left.setdefault(c, []).append(w)
    kept = []
    for c, w in terms:
        if w not in left[c]:  # paired before
            continue
        left[c].remove(w)
        other = next((u for u in left.get(-c, ()) if _is_part(u, w)), None)
        if other is not None:
            left[-c].remove(other)
            kept.append(c * se.exp(other) * se.Function(EXPM1)(w - other))
        else:
            kept.append(c * se.exp(w))
    return se.Add(*kept)


def _less_one(total: Any) -> Any:
    """A sum in which c cos w - c, c cosh w - c and c sqrt(n + x) - c sqrt(n) do not cancel, nor
    numbers that are nearly such a c: 1 + 1e-10 - cos w is 1e-10 + 2 sin^2(w/2)."""
    left, written = [*total.args], list[Any]()
    for term in total.args:
        for factor in factors_of(term):
            found = _from_zero(factor)
            if found is None:
                continue
            rest = term / factor
            other = -rest * found[0]
            near = next((n for n in left if _is_near(n, other)), None)
            if term in left and near is not None:
                left.remove(term)
                left.remove(near)
                written += [rest * found[1], near - other]
                break
    return se.Add(*left, *written) if written else total


def _is_near(number: Any, other: Any) -> bool:
    """Whether a term is another, or a number so near to it that their difference cancels."""
    numbers = number.is_Number and other.is_Number
    return bool(number == other or (numbers and abs(number - other) < NEARBY * abs(other)))


def _from_zero(factor: Any) -> tuple[Any, Any] | None:
    """(c, d) with c the value at w = 0 of cos w, cosh w or sqrt(n + w), and d the difference from
    it, which is small with w and has all digits; None of any other factor."""
    if isinstance(factor, (se.cos, se.cosh)) and factor.free_symbols:
        half = factor.args[0] / 2
        square = -(se.sin(half) ** 2) if isinstance(factor, se.cos) else se.sinh(half) ** 2
        return se.Integer(1), 2 * square
    if not isinstance(factor, se.Pow) or factor.args[1] != se.Rational(1, 2):
        return None
    base = factor.args[0]
    numbers = [a for a in base.args if a.is_Number and a > 0] if isinstance(base, se.Add) else []
    if not numbers:
        return None
    value, x = se.sqrt(numbers[0]), base - numbers[0]
    side = None if isinstance(x, se.Add) else _side(x)
    if side is None:
        return value, x / (factor + value)
    # x^2 would overflow where its root does not
    return value, 2 * value * se.sinh(se.asinh(side / value) / 2) ** 2


def _exponential(term: Any) -> tuple[Any, Any]:
    """(c, w) with c exp(w) the term, and w = 0 where no exponential is in it."""
    factors = factors_of(term)
    powers = [*filter(is_exponential, factors)]
    if not powers:
        return term, se.Integer(0)
    w = se.Add(*[f.args[1] for f in powers])
    return se.Mul(*[f for f in factors if f not in powers]), w


def _length(w: Any) -> float:
    numbers = [a for a in w.args if a.is_Number] if isinstance(w, se.Mul) else []
    return 0.0 if w == 0 else abs(float(numbers[0])) if numbers else 1.0


def _is_part(u: Any, w: Any) -> bool:
    """Whether u is zero, or w times a number between 0 and 1, and w moves."""
    if w == 0 or not w.free_symbols:
        return False
    ratio = u / w
    return u == 0 or bool(ratio.is_Number and 0 < ratio < 1)


def _with_tails(total: Any) -> Any:
    """A sum that vanishes where tanh w = 1 or -1, with factors 1 - tanh w and 1 + tanh w."""
    if not isinstance(total, se.Add):
        return total
    tangents = [f for term in total.args for f in _tangents(term)]
    for tangent in dict.fromkeys(tangents):
        terms = _in_powers(total, tangent)
        tails, w = se.Integer(1), tangent.args[0]
        for end in (1, -1) if terms else ():
            while (rest := _without_root(terms, end)) is not None:
                terms, tails = rest, tails * _tail(end, w)
        if tails != 1:
            return tails * se.Add(*[c * tangent**k for k, c in terms.items()])
    return total


def _tangents(term: Any) -> list[Any]:
    factors = factors_of(term)
    bases = [f.args[0] if isinstance(f, se.Pow) else f for f in factors]
    return [b for b in bases if isinstance(b, se.tanh)]


def _in_powers(total: Any, tangent: Any) -> _Terms:
    """The coefficients of a sum in powers of a tangent; none where it is no polynomial in it."""
    parts: dict[int, list[Any]] = {}
    for term in total.args:
        power, rest = 0, [se.Integer(1)]
        for factor in factors_of(term):
            base, exponent = factor.args if isinstance(factor, se.Pow) else (factor, se.Integer(1))
            if base == tangent and isinstance(exponent, se.Integer) and exponent > 0:
                power += int(exponent)
            else:
                rest.append(factor)
        coefficient = se.Mul(*rest)
        if tangent in coefficient.atoms(se.tanh):
            return {}
        parts.setdefault(power, []).append(coefficient)
    # one sum for each power: sums that grow by a term at a time would cost its square
    return {power: se.Add(*terms) for power, terms in parts.items()}


def _without_root(terms: _Terms, end: int) -> _Terms | None:
    """P/(1 - end T) where P vanishes at T = end; None where it does not."""
    if max(terms, default=0) == 0:
        return None
    quotient, carried = {}, se.Integer(0)
    for k in range(max(terms) + 1):  # P = (1 - end T) Q, from the lowest power on
        carried = expand_short(terms.get(k, se.Integer(0)) + end * carried)
        quotient[k] = carried
    if quotient.pop(max(terms)) != 0:
        return None
    return {k: c for k, c in quotient.items() if c != 0}


def _tail(end: int, w: Any) -> Any:
    """1 - tanh w, or 1 + tanh w for the other end."""
    size = se.Function(SIZE)(w)
    return 2 * se.exp(-end * w - size) / (1 + se.exp(-2 * size))

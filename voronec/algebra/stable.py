"""Expressions as they are computed: equal to what is given, without overflow and cancellation.

Where a formula is exact and useless in doubles it is written otherwise, for numbers alone:

    sqrt(a^2 + b^2)                     ->  hypot(a, b)
    log(1 + x),   c exp(w) - c          ->  log1p x,   c expm1 w
    log(1 + exp(w))                     ->  (w + |w|)/2 + log1p exp(-|w|)
    1 - cos w,   cosh w - 1             ->  2 sin^2(w/2),   2 sinh^2(w/2)
    sqrt(1 + x) - 1                     ->  x/(sqrt(1 + x) + 1),   2 sinh^2(asinh(y)/2) of x = y^2
    1/(a exp(u) + b exp(w))             ->  exp(-m)/(a exp(u - m) + b exp(w - m)), m = max(u, w)

Hyperbolic sines and cosines are such sums, and exp(u) - exp(w) = (exp(u) + exp(w)) tanh((u - w)/2).
What holds |w| is the same function of w on both sides of w = 0, so that it is no cut there.
Quotients such as sin(w)/w are those of ``cardinal``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

import symengine as se

from voronec.algebra.cardinal import cardinal_all
from voronec.algebra.numeric_functions import EXPM1, HYPOT, LOG1P, SIZE, numeric_name
from voronec.algebra.terms import (
    Rewriter,
    expand_short,
    factors_of,
    is_exponential,
    with_arguments,
)

MOST_TERMS = 64
"""Products of sums of exponentials with more terms are not written out."""
_Exponentials = dict[Any, Any]
"""A sum of c exp(w) as {w: c}."""
_Ends = tuple[Any, Any]
"""The outermost two of its exponents."""


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
        return _root(*expr.args) or _over_largest(expr)
    if isinstance(expr, se.log):
        return _logarithm(expr.args[0]) or expr
    if isinstance(expr, se.Mul):
        return _over_largest(expr)
    if isinstance(expr, se.Add):
        total = _less_one(expr)
        return _with_differences(total) if isinstance(total, se.Add) else total
    return expr


def _over_largest(product: Any) -> Any:
    """A product in which sums of exponentials below are divided by the larger of their outermost
    terms, and so is what stands above: neither leaves doubles where the quotient does not."""
    above, below, every = list[Any](), list[Any](), Counter[_Ends]()
    for factor in factors_of(product):
        base, power = factor.args if isinstance(factor, se.Pow) else (factor, se.Integer(1))
        terms = _exponentials(base) if isinstance(power, se.Integer) and power < 0 else {}
        ends = _ends(terms)
        if ends is None:
            above.append(factor)
        else:
            below.append(_over(terms, {ends: 1}) ** power)
            every[ends] -= int(power)
    if not below:
        return product
    moving = [f for f in above if any(_exponentials(f))]
    rest = [f for f in above if f not in moving]
    return se.Mul(*rest, _over(_exponentials(se.Mul(*moving)), every), *below)


@lru_cache(2**14)  # parts that many expressions share are looked at once
def _exponentials(expr: Any) -> _Exponentials:
    """An expression as a sum of c exp(w), hyperbolic sines and cosines written out."""
    half = se.Rational(1, 2)
    if isinstance(expr, se.sinh | se.cosh):
        return {expr.args[0]: half, -expr.args[0]: half if isinstance(expr, se.cosh) else -half}
    if is_exponential(expr):
        return {expr.args[1]: se.Integer(1)}
    if isinstance(expr, se.Add):
        return _sum_of_terms(item for term in expr.args for item in _exponentials(term).items())
    factors = [*factors_of(expr)]
    if isinstance(expr, se.Pow) and isinstance(expr.args[1], se.Integer) and 0 < expr.args[1] <= 8:
        factors = [expr.args[0]] * int(expr.args[1])
    product = {se.Integer(0): se.Integer(1)}
    for factor in factors:
        terms = _exponentials(factor) if len(factors) > 1 else {}
        if not any(terms):
            terms = {se.Integer(0): factor}
        if len(product) * len(terms) > MOST_TERMS:
            return {se.Integer(0): expr}
        product = _sum_of_terms(
            (u + w, a * b) for u, a in product.items() for w, b in terms.items()
        )
    return product


def _sum_of_terms(items: Iterable[tuple[Any, Any]]) -> _Exponentials:
    total: _Exponentials = {}
    for w, c in items:
        total[w] = total.get(w, se.Integer(0)) + c
    return {w: c for w, c in total.items() if c != 0}


def _ends(terms: _Exponentials) -> _Ends | None:
    """The outermost exponents of a sum; None where there are none, or more than two of which
    nothing tells which are the outermost."""
    exponents = sorted(terms, key=str)
    if len(terms) < 2 or any(
        numeric_name(f) == SIZE for w in exponents for f in se.sympify(w).atoms(se.Function)
    ):
        return None  # nothing to choose, or done before
    steps = [_rates(w - exponents[0]) for w in exponents]
    letters = [*{letter for step in steps for letter in step}]
    if len(letters) == 1:
        order = sorted(range(len(steps)), key=lambda i: steps[i].get(letters[0], 0.0))
        return exponents[order[0]], exponents[order[-1]]
    return (exponents[0], exponents[1]) if letters and len(terms) == 2 else None


def _rates(exponent: Any) -> dict[Any, float]:
    """How an exponent changes with its letters."""
    numbers = expand_short(exponent).as_coefficients_dict().items()
    return {x: float(c) for x, c in numbers if not se.sympify(x).is_Number}


def _over(terms: _Exponentials, every: Mapping[_Ends, int]) -> Any:
    """A sum of exponentials over so many powers of the larger of some ends; of two terms that may
    cancel, c exp(u) - c exp(w), the sum times a tangent."""
    left, written = dict(terms), list[Any]()
    while left:
        u, c = left.popitem()
        w = next((w for w, d in left.items() if d == -c), None)
        total = se.exp(_less_largest(u, every))
        if w is not None:
            del left[w]
            c *= se.tanh(expand_short(u - w) / 2)
            total += se.exp(_less_largest(w, every))
        written.append(c * total)
    return se.Add(*written)


def _less_largest(w: Any, every: Mapping[_Ends, int]) -> Any:
    """w - n max(a, b) for ends a and b, as w - n a - n (b - a + |b - a|)/2 from the end that is
    nearer to it, so that less cancels."""
    shifts = []
    for ends, n in every.items():
        near, far = sorted(ends, key=lambda end: sum(map(abs, _rates(w - n * end).values())))
        w = expand_short(w - n * near)
        shift = (expand_short(far - near) + _size(ends)) / 2
        # a multiple of a sum is written out: symengine's search for common parts loses some of it
        shifts.append(-shift if n == 1 else expand_short(-n * shift))
    return se.Add(w, *shifts)


def _size(ends: _Ends) -> Any:
    return se.Function(SIZE)(expand_short(ends[1] - ends[0]))


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
    terms = _exponentials(inner)
    ends = _ends(terms)
    if ends is None:
        beside = isinstance(inner, se.Add) and se.Integer(1) in inner.args
        return se.Function(LOG1P)(inner - 1) if beside else None
    if len(terms) == 2 and all(c.is_Number and c > 0 for c in terms.values()):
        (u, a), (w, b) = sorted(terms.items(), key=lambda term: (len(str(term[0])), str(term[0])))
        return u + se.log(a) + _soft(w - u + se.log(b / a))
    return (se.Add(*ends) + _size(ends)) / 2 + se.log(_over(terms, {ends: 1}))


def _soft(w: Any) -> Any:
    """log(1 + exp(w))."""
    size = se.Function(SIZE)(w)
    return (w + size) / 2 + se.Function(LOG1P)(se.exp(-size))


def _with_differences(total: Any) -> Any:
    """A sum in which c exp(w) - c is c expm1(w)."""
    left, written = dict.fromkeys(total.args), list[Any]()
    for term in total.args:
        c, w = _exponential(term)
        if w.free_symbols and -c in left:
            del left[term], left[-c]
            written.append(c * se.Function(EXPM1)(w))
    return se.Add(*left, *written) if written else total


def _less_one(total: Any) -> Any:
    """A sum in which c cos w - c, c cosh w - c and c sqrt(n + x) - c sqrt(n) do not cancel."""
    left, written = dict.fromkeys(total.args), list[Any]()  # the terms of a sum are distinct
    for term in total.args:
        for factor in factors_of(term):
            parts = _from_zero(factor)
            if parts is None:
                continue
            rest = term / factor
            other = -rest * parts[0]
            if term in left and other in left:
                del left[term], left[other]
                written.append(rest * parts[1])
                break
    return se.Add(*left, *written) if written else total


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

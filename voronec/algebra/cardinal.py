"""Quotients such as sin(w)/w, which have a value at w = 0 that a division does not give.

    sinc w = sin(w)/w

is entire (``numeric_functions``).  1 - cos w = 2 sin^2(w/2), which loses no digits, and
tan w = sin(w)/cos(w) are divided likewise.  What cancels in its slope is taken together:

    cos(w)/w - sin(w)/w^2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import lru_cache
from math import ceil, comb
from typing import Any

import symengine as se

from voronec.algebra.numeric_functions import QUOTIENTS, SINC, SINC_SLOPE
from voronec.algebra.terms import Rewriter, factors_of, subexpressions, with_arguments

_Zero = tuple[Any, int, Any]
"""(w, p, c) of a function that is c w^p, where c has a value at w = 0."""


def coefficient(name: str, at: int, order: int, bits: int) -> int:
    """The coefficient of h^order in the quotient of ``at`` + h, |at| below its reach, both in
    2^-bits.

    sum_n c_n C(n, order) at^(n - order),    c_n those at zero.
    """
    terms = QUOTIENTS[name].coefficient
    total, power, n = 0, 1 << bits, order
    while n == order or abs(power) * comb(n, order) // terms(n)[1]:
        p, q = terms(n)
        total += p * power * comb(n, order) // q
        power = power * at >> bits
        n += 1
    return total


def loses_quotients(plain: Iterable[Any], short: Callable[[], Iterable[Any]]) -> bool:
    """Whether ``short`` forms of ``plain`` expressions, made if need be, divide by what these, once
    written as here, do not: normal forms take sums over one denominator, and expand sines."""
    given = [se.sympify(e) for e in plain]
    written = cardinal_all(given)
    if written == given or not (cured := _divisors(given) - _divisors(written)):
        return False
    return not cured.isdisjoint(_divisors(cardinal_all(short())))


def _divisors(exprs: Iterable[Any]) -> set[Any]:
    """What expressions divide by, letters and sums."""
    powers = (n.args for n in subexpressions([*exprs]) if isinstance(n, se.Pow))
    return {b for b, e in powers if e.is_Number and e < 0 and b.free_symbols}


def cardinal_all(exprs: Iterable[Any]) -> list[Any]:
    """Equal expressions, in which nothing is divided by w that vanishes with it."""
    given = [se.sympify(e) for e in exprs]
    arguments: set[Any] = set()
    for node in subexpressions(given):
        if isinstance(node, se.sin | se.cos | se.tan):
            arguments |= _factors(node.args[0]).keys()
    vanish = not arguments.isdisjoint(_divisors(given))
    return [*map(Rewriter(_rewrite), given)] if vanish else given


def _factors(expr: Any) -> dict[Any, Any]:
    """The factors of a product with their exponents, numbers left out."""
    exponents = {}
    for factor in factors_of(expr):
        if not factor.is_Number:
            plain = isinstance(factor, se.Pow) and factor.args[1].is_Number
            base, exponent = factor.args if plain else (factor, se.Integer(1))
            exponents[base] = exponent
    return exponents


def _rewrite(expr: Any, inner: Rewriter) -> Any:
    if not expr.args or isinstance(expr, (se.Derivative, se.Subs)):
        return expr
    if isinstance(expr, se.Add) and (sloped := _with_slopes(expr)) != expr:
        return inner(sloped)
    whole = with_arguments(expr, [*map(inner, expr.args)])
    return _quotient(whole) if isinstance(whole, se.Mul) else whole


@lru_cache(2**14)  # a sum stands in many products, of the equations and of what is made of them
def _with_slopes(total: Any) -> Any:
    """A sum in which terms that cancel at w = 0 are slopes of sin(w)/w."""
    left, written = dict.fromkeys(total.args), list[Any]()
    for term in total.args:
        for sine in (f for f in _factors(term) if isinstance(f, se.sin) and term in left):
            w, rest = sine.args[0], term / sine
            other = -rest * w * se.cos(w)
            if other in left and term != other:
                del left[term], left[other]
                written.append(rest * w**3 * se.Function(SINC_SLOPE)(w))
                break
    return se.Add(*left, *written) if written else total


def _quotient(product: Any) -> Any:
    """A product in which functions that vanish with w take up the powers of w below."""
    powers = _factors(product)
    below = {u: e for u, e in powers.items() if e.is_Number and e < 0}
    for base, exponent in powers.items() if below else ():
        zero = _zero(base) if isinstance(exponent, se.Integer) and exponent > 0 else None
        if zero is None:
            continue
        argument, order, value = zero
        for u, e in below.items():
            held = _factors(argument).get(u)
            if held is not None and held.is_Number and held > 0:
                times = min(int(exponent), ceil(abs(e) / (order * held)))
                return _quotient(product * (value * argument**order / base) ** times)
    return product


def _zero(factor: Any) -> _Zero | None:
    """(w, p, c) with c w^p equal to a factor that vanishes with w; None for any other."""
    if isinstance(factor, se.sin | se.tan):
        (w,) = factor.args
        quotient = se.Function(SINC)(w)
        return w, 1, quotient if isinstance(factor, se.sin) else quotient / se.cos(w)
    if not isinstance(factor, se.Add) or len(factor.args) != 2:
        return None
    number, term = sorted(factor.args, key=lambda a: not a.is_Number)
    cosine = -term / number if number.is_Number else None
    if not isinstance(cosine, se.cos):
        return None
    half = cosine.args[0] / 2
    return half, 2, 2 * number * se.Function(SINC)(half) ** 2

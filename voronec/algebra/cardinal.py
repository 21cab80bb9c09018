"""Quotients such as sin(w)/w, which have a value at w = 0 that a division does not give.

    sinc w = sin(w)/w,    sinhc w = sinh(w)/w,    exprel w = (exp(w) - 1)/w

are entire (``numeric_functions``).  1 - cos w = 2 sin^2(w/2), which loses no digits, and
tan w = sin(w)/cos(w) are divided likewise, and so is tanh, which is even but for the factor w:

    tanh(w)/w = 2 exprel(-2|w|)/(1 + exp(-2|w|)).

All of them divide, as in w/sinh w and tanh(2 w)/tanh w.  What cancels in the slopes of the first
two is taken together:

    cos(w)/w - sin(w)/w^2,    cosh(w)/w - sinh(w)/w^2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import lru_cache
from math import ceil, comb
from typing import Any

import symengine as se

from voronec.algebra.numeric_functions import (
    EXPREL,
    QUOTIENTS,
    SINC,
    SINC_SLOPE,
    SINHC,
    SINHC_SLOPE,
    SIZE,
)
from voronec.algebra.terms import (
    Rewriter,
    expand_short,
    factors_of,
    is_exponential,
    subexpressions,
    summands,
    with_arguments,
)

_Zero = tuple[Any, int, Callable[[Any], Any]]
"""(w, p, c) of a function that is c(w) w^p."""


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


def divides_sines_of_sums(exprs: Iterable[Any]) -> bool:
    """Whether there are quotients such as sin(u + w)/(u + w): normal forms expand the sine, and
    see no quotient that has a value where u + w vanishes."""
    sums, below = set[Any](), set[Any]()
    for node in subexpressions(map(se.sympify, exprs)):
        if isinstance(node, (se.sin, se.cos, se.tan)):
            sums |= {f for f in _factors(node.args[0]) if isinstance(f, se.Add)}
        elif isinstance(node, se.Pow) and node.args[1].is_Number and node.args[1] < 0:
            below.add(node.args[0])
    return any(_ratio(w, u) is not None for w in sums for u in below)


def loses_quotients(plain: Iterable[Any], short: Callable[[], Iterable[Any]]) -> bool:
    """Whether ``short`` forms of ``plain`` expressions, made if need be, divide by what these, once
    written as here, do not.  Normal forms have exponentials for hyperbolic functions: of what
    vanishes nothing is seen, of cosh(2 x) - 1 at once, of others once they are spread."""
    given = [se.sympify(e) for e in plain]
    written = cardinal_all(given)
    if written == given or not (cured := _divisors(given) - _divisors(written)):
        return False
    spread = any(isinstance(node, (se.cosh, se.sinh, se.tanh)) for node in subexpressions(given))
    return spread or not cured.isdisjoint(_divisors(cardinal_all(short())))


def _divisors(exprs: Iterable[Any]) -> set[Any]:
    """What expressions divide by, letters and sums."""
    powers = (n.args for n in subexpressions([*exprs]) if isinstance(n, se.Pow))
    return {b for b, e in powers if e.is_Number and e < 0 and b.free_symbols}


def cardinal_all(exprs: Iterable[Any]) -> list[Any]:
    """Equal expressions, in which nothing is divided by w that vanishes with it."""
    given = [se.sympify(e) for e in exprs]
    below: set[Any] = set()
    arguments: set[Any] = set()
    inverse = False
    for node in subexpressions(given):
        if isinstance(node, se.Pow):
            base, exponent = node.args
            if base == se.E:
                arguments |= _factors(exponent).keys()
            elif exponent.is_Number and exponent < 0:
                below.add(base)
        elif isinstance(node, _KINDS):
            arguments |= _factors(node.args[0]).keys()
        inverse = inverse or (isinstance(node, se.Mul) and _divides(node))
    sums = {a for a in arguments if isinstance(a, se.Add)}
    vanish = inverse or below & arguments or any(_ratio(a, b) for a in sums for b in below)
    return [*map(Rewriter(_rewrite), given)] if vanish else given


def _divides(product: Any) -> bool:
    """Whether what vanishes with w divides a product that holds a power of w, as in w/sinh w."""
    powers = _factors(product)
    divisors = (b for b, e in powers.items() if isinstance(e, se.Integer) and e < 0)
    zeros = filter(None, map(_zero, divisors))
    return any(powers.get(u, 0) > 0 for w, _, _ in zeros for u in _factors(w))


def _factors(expr: Any) -> dict[Any, Any]:
    """The factors of a product with their exponents, numbers left out."""
    found = {}
    for factor in factors_of(expr):
        if not factor.is_Number:
            plain = isinstance(factor, se.Pow) and factor.args[1].is_Number
            base, exponent = factor.args if plain else (factor, se.Integer(1))
            found[base] = exponent
    return found


def _ratio(one: Any, other: Any) -> Any | None:
    """The number by which one sum is a multiple of another; None where there is none."""
    if not (isinstance(one, se.Add) and isinstance(other, se.Add)):
        return None
    # To expand large sums for every pair of them takes minutes.
    if len(one.args) != len(other.args) or one.free_symbols != other.free_symbols:
        return None
    for term in other.args:
        ratio = one.args[0] / term
        if ratio.is_Number and expand_short(one - ratio * other) == 0:
            return ratio
    return None


def _rewrite(expr: Any, inner: Rewriter) -> Any:
    if not expr.args or isinstance(expr, (se.Derivative, se.Subs)):
        return expr
    if isinstance(expr, se.Mul):
        expr = _quotient(se.Mul(*map(_slopes_within, expr.args)))
    elif isinstance(expr, se.Add) and (sloped := _with_slopes(expr)) != expr:
        return inner(sloped)
    return with_arguments(expr, [*map(inner, expr.args)])


def _slopes_within(factor: Any) -> Any:
    """A factor of a product, sums in whole powers with slopes."""
    if isinstance(factor, se.Add):
        return _with_slopes(factor)
    if isinstance(factor, se.Pow) and isinstance(factor.args[1], se.Integer):
        base = factor.args[0]
        return _with_slopes(base) ** factor.args[1] if isinstance(base, se.Add) else factor
    return factor


@lru_cache(2**14)  # a sum stands in many products, of the equations and of what is made of them
def _with_slopes(total: Any) -> Any:
    """A sum in which terms that cancel at w = 0 are slopes of quotients."""
    left, written = dict.fromkeys(total.args), list[Any]()
    for term in total.args:
        sloped = (f for f in _factors(term) if type(f) in _SLOPES) if term in left else ()
        for function in sloped:
            partner, slope = _SLOPES[type(function)](function.args[0])
            rest = term / function
            other = -rest * partner
            if other in left and term != other:
                del left[term], left[other]
                written.append(rest * slope)
                break
    return se.Add(*left, *written) if written else total


def _quotient(product: Any, spread: bool = True) -> Any:
    """A product in which functions that vanish with w take up the powers of w below, or above where
    they divide.

    Sums are ``spread`` once: sums within sums would take time that grows with the power of depth.
    """
    powers = _factors(product)
    below = {u: e for u, e in powers.items() if e.is_Number and e < 0}
    above = {u: e for u, e in powers.items() if e.is_Number and e > 0}
    for base, exponent in powers.items():
        zero = _zero(base) if isinstance(exponent, se.Integer) else None
        if zero is None:
            continue
        argument, order, value = zero
        for u, e in (below if exponent > 0 else above).items():
            ratio = _ratio(argument, u)
            held = se.Integer(1) if ratio is not None else _factors(argument).get(u)
            if u == base or held is None or not held.is_Number or held < 0:
                continue
            argument = ratio * u if ratio is not None else argument
            times = min(abs(int(exponent)), ceil(abs(e) / (order * held)))
            whole = value(argument) * argument**order / base
            return _quotient(product * (whole if exponent > 0 else 1 / whole) ** times, spread)
    for base, exponent in powers.items() if spread else ():
        if isinstance(base, se.Add) and exponent == 1:
            vanish = _zeros(base) if below else set()
            sums = [w for w in vanish if isinstance(w, se.Add)]
            for u in below:
                if u not in vanish and not any(_ratio(w, u) is not None for w in sums):
                    continue
                found = _distribute(base, product / base, u)
                if found is not None:
                    return found
    return product


def _zeros(total: Any) -> set[Any]:
    """What terms of a sum may take up from below: their factors, and what these vanish with."""
    bases = {base for term in total.args for base, e in _factors(term).items() if e > 0}
    zeros = filter(None, map(_zero, bases))
    return bases.union(*({w, *_factors(w)} for w, _, _ in zeros))


def _distribute(above: Any, rest: Any, u: Any) -> Any | None:
    """A sum, times a product that divides it by u, term by term where that takes up all of u."""

    def is_clear(expr: Any) -> bool:
        terms = summands(expr)
        return all(_factors(t).get(u, 0) >= 0 for t in terms)

    parts = [(term, _quotient(term * rest, False)) for term in above.args]
    clear = [part for _, part in parts if is_clear(part)]
    left = [term for term, part in parts if not is_clear(part)]
    if left and clear:
        clear.append(_quotient(se.Add(*left) * rest, False))
    return se.Add(*clear) if clear and is_clear(clear[-1]) else None


def _zero(factor: Any) -> _Zero | None:
    """(w, p, c) with c(w) w^p equal to a factor that vanishes with w; None for any other."""
    if type(factor) in _ZEROS:
        return factor.args[0], 1, _ZEROS[type(factor)]
    if not isinstance(factor, se.Add) or len(factor.args) != 2:
        return None
    number, term = sorted(factor.args, key=lambda a: not a.is_Number)
    function = -term / number if number.is_Number else se.Integer(1)
    if isinstance(function, (se.cos, se.cosh)):
        name, sign = (SINC, 1) if isinstance(function, se.cos) else (SINHC, -1)
        return function.args[0] / 2, 2, lambda w: 2 * sign * number * se.Function(name)(w) ** 2
    if is_exponential(function):
        return function.args[1], 1, lambda w: -number * se.Function(EXPREL)(w)
    return None


def _tangent(w: Any) -> Any:
    """tanh(w)/w, without overflow for large w."""
    z = -2 * se.Function(SIZE)(w)
    return 2 * se.Function(EXPREL)(z) / (1 + se.exp(z))


_ZEROS: dict[type, Callable[[Any], Any]] = {
    se.sin: se.Function(SINC),
    se.sinh: se.Function(SINHC),
    se.tan: lambda w: se.Function(SINC)(w) / se.cos(w),
    se.tanh: _tangent,
}
"""Functions f that vanish at zero, with f(w)/w."""
_SLOPES: dict[type, Callable[[Any], tuple[Any, Any]]] = {
    se.sin: lambda w: (w * se.cos(w), w**3 * se.Function(SINC_SLOPE)(w)),
    se.sinh: lambda w: (w * se.cosh(w), -(w**3) * se.Function(SINHC_SLOPE)(w)),
}
"""Functions f with a term g that cancels beside them, and f - g."""
_KINDS: Any = (*_ZEROS, se.cos, se.cosh)

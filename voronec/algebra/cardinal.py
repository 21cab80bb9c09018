"""Quotients such as sin(w)/w, which have a value at w = 0 that a division does not give.

    sinc w = sin(w)/w,    sinhc w = sinh(w)/w,    exprel w = (exp(w) - 1)/w

are entire (``numeric_functions``).  1 - cos w = 2 sin^2(w/2), which loses no digits, and
tan w = sin(w)/cos(w) are divided likewise, and so is tanh, which is even but for the factor w:

    tanh(w)/w = 2 exprel(-2|w|)/(1 + exp(-2|w|)).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import ceil, comb, factorial
from typing import Any

import symengine as se

from voronec.algebra.numeric_functions import EXPREL, SINC, SINHC, SIZE

__all__ = ["cardinal_all", "coefficient"]


def coefficient(name: str, at: int, order: int, bits: int) -> int:
    """The coefficient of h^order in the function of ``at`` + h, |at| < 1, both in 2^-bits.

    sum_n s_n C(n, order) at^(n - order)/(n + 1)!,    s_n = 1, or -1, or 0.
    """
    total, power, n = 0, 1 << bits, order
    while abs(power) * comb(n, order) // factorial(n + 1) or n == order:
        if n % 2 == 0 or name == EXPREL:
            sign = -1 if name == SINC and n % 4 else 1
            total += sign * power * comb(n, order) // factorial(n + 1)
        power = power * at >> bits
        n += 1
    return total


def cardinal_all(exprs: Iterable[Any]) -> list[Any]:
    """Equal expressions, in which nothing is divided by w that vanishes with it."""
    given = [se.sympify(e) for e in exprs]
    below: set[Any] = set()
    arguments: set[Any] = set()
    for node in _nodes(given):
        if isinstance(node, se.Pow):
            base, exponent = node.args
            if base == se.E:
                arguments |= _factors(exponent).keys()
            elif exponent.is_Number and exponent < 0:
                below.add(base)
        elif isinstance(node, _KINDS):
            arguments |= _factors(node.args[0]).keys()
    if not below:
        return given
    sums = {a for a in arguments if isinstance(a, se.Add)}
    if not below & arguments and not any(_ratio(a, b) for a in sums for b in below):
        return given
    known: dict[Any, Any] = {}
    return [_rewritten(e, known) for e in given]


_KINDS = (se.sin, se.cos, se.tan, se.sinh, se.cosh, se.tanh)


def _nodes(exprs: Iterable[Any]) -> Iterator[Any]:
    """All parts of expressions that share parts, each once."""
    seen, waiting = set[Any](), list(exprs)
    while waiting:
        node = waiting.pop()
        if node.args and node not in seen:
            seen.add(node)
            waiting += node.args
            yield node


def _factors(expr: Any) -> dict[Any, Any]:
    """The factors of a product with their exponents, numbers left out."""
    found = {}
    for factor in expr.args if isinstance(expr, se.Mul) else (expr,):
        if not factor.is_Number:
            plain = isinstance(factor, se.Pow) and factor.args[1].is_Number
            base, exponent = factor.args if plain else (factor, se.Integer(1))
            found[base] = exponent
    return found


def _ratio(one: Any, other: Any) -> Any | None:
    """The number by which one sum is a multiple of another; None where there is none."""
    if not (isinstance(one, se.Add) and isinstance(other, se.Add)):
        return None
    for term in other.args:
        ratio = one.args[0] / term
        if ratio.is_Number and (one - ratio * other).expand() == 0:
            return ratio
    return None


def _rewritten(expr: Any, known: dict[Any, Any]) -> Any:
    if not expr.args or isinstance(expr, (se.Derivative, se.Subs)):
        return expr
    found = known.get(expr)
    if found is None:
        whole = _quotient(expr) if isinstance(expr, se.Mul) else expr
        args = [_rewritten(a, known) for a in whole.args]
        found = known[expr] = whole if args == list(whole.args) else whole.func(*args)
    return found


def _quotient(product: Any, spread: bool = True) -> Any:
    """A product in which functions that vanish with w take up the powers of w below.

    Sums are ``spread`` once: sums within sums would take time that grows with the power of depth.
    """
    powers = _factors(product)
    below = {u: e for u, e in powers.items() if e.is_Number and e < 0}
    for base, exponent in powers.items():
        zero = _zero(base) if isinstance(exponent, se.Integer) and exponent > 0 else None
        if zero is None:
            continue
        argument, order, value = zero
        for u, e in below.items():
            ratio = _ratio(argument, u)
            held = se.Integer(1) if ratio is not None else _factors(argument).get(u)
            if held is None or not held.is_Number or held < 0:
                continue
            argument = ratio * u if ratio is not None else argument
            times = min(int(exponent), ceil(-e / (order * held)))
            whole = value(argument) * argument**order / base
            return _quotient(product * whole**times, spread)
    for base, exponent in powers.items() if spread else ():
        if isinstance(base, se.Add) and exponent == 1:
            for u in below:
                found = _shared_out(base, product / base, u)
                if found is not None:
                    return found
    return product


def _shared_out(above: Any, rest: Any, u: Any) -> Any | None:
    """A sum, times a product that divides it by u, term by term where that takes up all of u."""

    def is_clear(expr: Any) -> bool:
        terms = expr.args if isinstance(expr, se.Add) else (expr,)
        return all(_factors(t).get(u, 0) >= 0 for t in terms)

    parts = [(term, _quotient(term * rest, False)) for term in above.args]
    clear = [part for _, part in parts if is_clear(part)]
    left = [term for term, part in parts if not is_clear(part)]
    if left and clear:
        clear.append(_quotient(se.Add(*left) * rest, False))
    return se.Add(*clear) if clear and is_clear(clear[-1]) else None


def _zero(factor: Any) -> tuple[Any, int, Callable[[Any], Any]] | None:
    """(w, p, c) with c(w) w^p equal to a factor that vanishes with w; None for any other."""
    if isinstance(factor, (se.sin, se.sinh)):
        name = SINC if isinstance(factor, se.sin) else SINHC
        return factor.args[0], 1, se.Function(name)
    if isinstance(factor, se.tan):
        return factor.args[0], 1, lambda w: se.Function(SINC)(w) / se.cos(w)
    if isinstance(factor, se.tanh):
        return factor.args[0], 1, _tangent
    if not isinstance(factor, se.Add) or len(factor.args) != 2:
        return None
    number, term = sorted(factor.args, key=lambda a: not a.is_Number)
    function = -term / number if number.is_Number else se.Integer(1)
    if isinstance(function, (se.cos, se.cosh)):
        name, sign = (SINC, 1) if isinstance(function, se.cos) else (SINHC, -1)
        return function.args[0] / 2, 2, lambda w: 2 * sign * number * se.Function(name)(w) ** 2
    if isinstance(function, se.Pow) and function.args[0] == se.E:
        return function.args[1], 1, lambda w: -number * se.Function(EXPREL)(w)
    return None


def _tangent(w: Any) -> Any:
    """tanh(w)/w, without overflow for large w."""
    z = -2 * se.Function(SIZE)(w)
    return 2 * se.Function(EXPREL)(z) / (1 + se.exp(z))

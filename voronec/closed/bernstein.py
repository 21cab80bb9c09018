"""Polynomials in the variable between its ends, without cancellation.

Where x = (1 - s) base + s other, a polynomial of degree d is the sum of
C(d, k) b_k (1 - s)^(d - k) s^k, and all b_k lie near its values: a large constant that cancels
against a large slope leaves no trace in them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import comb
from typing import Any

import numpy as np

from voronec.closed.arithmetic import ball, precise
from voronec.closed.inverted_motion import InvertedMotion

__all__ = ["Bernstein", "bernstein", "evaluate_form", "inner", "round_numbers"]

FINE = 64
"""Bits that a number must have before it is rounded to a double."""
MOST = 1 << 13
NOTHING = 2.0**-400
"""A number below this is none for doubles."""

Bernstein = tuple[float, ...]
"""The numbers b_k."""


def round_numbers(
    form: InvertedMotion, at: Callable[[int, Any], Sequence[Any]]
) -> tuple[float, ...]:
    """Numbers that a function of bits and of the motion's constants gives, to the last bit."""
    bits = 2 * FINE
    while True:
        with precise(bits):
            found = at(bits, form.solution.constants(bits))
        good = (x.is_zero() or x.rel_accuracy_bits() >= FINE for x in found)
        if all(good) or bits >= MOST:
            return tuple(0.0 if abs(x) < ball(NOTHING) else float(x) for x in found)
        bits *= 2


def bernstein(form: InvertedMotion, ascending: Callable[[int], Sequence[Any]]) -> Bernstein:
    """The numbers b_k of a polynomial whose coefficients are known to any number of bits."""
    return round_numbers(form, lambda bits, constants: inner(ascending(bits), constants))


def inner(ascending: Sequence[Any], constants: Any) -> list[Any]:
    """The numbers b_k of a polynomial as balls: all its values between the ends lie among them."""
    row = _shift(ascending, constants.base)
    degree, span = len(row) - 1, constants.other - constants.base
    grown = [c * span**j for j, c in enumerate(row)]
    return [
        sum((c * comb(k, j) / comb(degree, j) for j, c in enumerate(grown[: k + 1])), ball(0))
        for k in range(degree + 1)
    ]


def _shift(row: Sequence[Any], place: Any) -> list[Any]:
    """Coefficients in powers of x - place."""
    found = list(row)
    for i in range(len(found)):
        for j in range(len(found) - 2, i - 1, -1):
            found[j] = found[j] + place * found[j + 1]
    return found


def evaluate_form(numbers: Bernstein, near: np.ndarray, far: np.ndarray) -> Any:
    """The polynomial where x = near base + far other."""
    degree = len(numbers) - 1
    if degree == 0:
        return numbers[0]
    total: Any = 0.0
    for k, b in enumerate(numbers):
        if b:
            total = total + comb(degree, k) * b * near ** (degree - k) * far**k
    return total

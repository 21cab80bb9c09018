"""Polynomials and rational functions of the variable, in balls and in doubles without cancellation.

Rational functions of the variable: the cosines of traces and the clock, in balls and doubles.

Polynomials in the variable between its ends, without cancellation.

Where x = (1 - s) base + s other, a polynomial of degree d is the sum of
C(d, k) b_k (1 - s)^(d - k) s^k, and all b_k lie near its values: a large constant that cancels
against a large slope leaves no trace in them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import comb
from typing import Any

import numpy as np
import sympy as sp

from voronec.closed.arithmetic import Function, ball, compile_expressions, precise
from voronec.closed.compiled_motion import CompiledMotion
from voronec.closed.fractions import ascending_coefficients
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.problem import InversionProblem

__all__ = [
    "Bernstein",
    "Polynomial",
    "Ratio",
    "bernstein",
    "evaluate_form",
    "inner",
    "ratios",
    "round_numbers",
]


@dataclass(frozen=True, eq=False)
class Polynomial:
    """In the variable, its coefficients functions of a level."""

    coefficients: Function

    @classmethod
    def of(cls, value: Any, own: CompiledMotion) -> Polynomial:
        """An expression as a polynomial."""
        x = own.motion.x
        degree = int(sp.degree(sp.expand(value), x)) if value.has(x) else 0
        return cls(compile_expressions(ascending_coefficients(value, x, degree), own.level))

    def row(self, problem: InversionProblem, bits: int) -> list[Any]:
        """The coefficients as balls."""
        level = problem.level(bits)
        with precise(bits):
            return self.coefficients(level)

    def value(self, problem: InversionProblem, x: Any, bits: int) -> Any:
        """At one value of the variable."""
        total = ball(0)
        for c in reversed(self.row(problem, bits)):
            total = total * x + c
        return total

    def bernstein(self, form: InvertedMotion) -> Bernstein:
        """For doubles."""
        return bernstein(form, lambda bits: self.row(form.problem, bits))


@dataclass(frozen=True, eq=False)
class Ratio:
    """p/q: ``above``, ``below``; ``south`` is q - p, ``north`` q + p, and ``bend`` p' q - p q'."""

    above: Polynomial
    below: Polynomial
    south: Polynomial
    north: Polynomial
    bend: Polynomial

    @classmethod
    def of(cls, value: Any, own: CompiledMotion) -> Ratio:
        """An expression as a ratio of polynomials."""
        x = own.motion.x
        p, q = sp.fraction(value)
        bend = sp.diff(p, x) * q - p * sp.diff(q, x)
        return cls(*(Polynomial.of(e, own) for e in (p, q, q - p, q + p, bend)))

    def value(self, problem: InversionProblem, x: Any, bits: int) -> Any:
        """At one value of the variable."""
        return self.above.value(problem, x, bits) / self.below.value(problem, x, bits)


def ratios(own: CompiledMotion) -> Sequence[Ratio]:
    """The cosine of each trace, and the clock."""
    return own.memo.once("ratios", lambda: _ratios(own))


def _ratios(own: CompiledMotion) -> Sequence[Ratio]:
    given = (*(t.cosine for t in own.motion.traces), own.motion.clock)
    return [Ratio.of(e.xreplace(dict(own.gone)), own) for e in given]


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

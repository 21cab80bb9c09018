"""Rational functions of the variable: the cosines of traces and the clock, in balls and doubles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.closed.arithmetic import Function, ball, compile_expressions, precise
from voronec.closed.bernstein import Bernstein, bernstein
from voronec.closed.compiled_motion import CompiledMotion
from voronec.closed.fractions import ascending_coefficients
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.problem import InversionProblem

__all__ = ["Polynomial", "Ratio", "ratios"]


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

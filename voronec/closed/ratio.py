"""What doubles need of a motion: polynomials, rational functions and rounded constants.

Rational functions of the variable are the cosines of traces and the clock, in balls and doubles.
Polynomials are evaluated between the ends of the variable without cancellation: where x = (1 - s)
base + s other, a polynomial of degree d is the sum of C(d, k) b_k (1 - s)^(d - k) s^k, and all b_k
lie near its values: a large constant that cancels against a large slope leaves no trace in them.

Constants of a motion are computed once, and rounded to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from math import comb
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.precision import FIRST
from voronec.closed.arithmetic import Function, ball, compile_expressions, precise
from voronec.closed.compiled_motion import CompiledMotion, reading_of
from voronec.closed.fractions import ascending_coefficients
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.problem import InversionProblem


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
    return [Ratio.of(e.xreplace(dict(own.special)), own) for e in given]


BITS = FIRST
"""Bits that a number must have before it is rounded to a double."""
MOST = 1 << 13
"""Bits beyond which a number stays unrounded: it is zero, or the quotient has no value."""
NOTHING = 2.0**-1000
"""A number below this is none for doubles."""

Bernstein = tuple[float, ...]
"""The numbers b_k."""


def _round_numbers(
    form: InvertedMotion, at: Callable[[int, Any], Sequence[Any]]
) -> tuple[float, ...]:
    """Numbers that a function of bits and of the motion's constants gives, to the last bit."""
    bits = 2 * BITS
    while True:
        with precise(bits):
            numbers = at(bits, form.solution.constants(bits))
        good = (x.is_zero() or x.rel_accuracy_bits() >= BITS for x in numbers)
        if all(good) or bits >= MOST:
            return tuple(0.0 if abs(x) < ball(NOTHING) else float(x) for x in numbers)
        bits *= 2


def bernstein(form: InvertedMotion, ascending: Callable[[int], Sequence[Any]]) -> Bernstein:
    """The numbers b_k of a polynomial whose coefficients are known to any number of bits."""
    return _round_numbers(form, lambda bits, constants: inner(ascending(bits), constants))


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
    coefficients = list(row)
    for i in range(len(coefficients)):
        for j in range(len(coefficients) - 2, i - 1, -1):
            coefficients[j] = coefficients[j] + place * coefficients[j + 1]
    return coefficients


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


FINE = 192
"""Bits of what is rounded to doubles."""


def less_turns(angle: Any) -> float:
    """An angle modulo a turn."""
    turn = 2 * ball(1).pi()
    return float(angle - turn * round(float(angle / turn)))


@dataclass(frozen=True, eq=False)
class RoundedConstants:
    """Numbers of one motion; what nobody asks for is not computed."""

    form: InvertedMotion

    @cached_property
    def starts(self) -> list[tuple[float, float]]:
        """The angles at the start, of the motion turned upright: whole, and modulo a turn."""
        with precise(FINE):
            return [(float(a), less_turns(a)) for a in self.form.begin(FINE)]

    @cached_property
    def level(self) -> list[float]:
        """Parameters and constants of the motion."""
        return [float(c) for c in self.form.problem.level(FINE)]

    @cached_property
    def branches(self) -> list[tuple[int, int]]:
        """Of each trace: the branch of its colatitude."""
        return [self.form.branch(i) for i in range(len(self.form.quadratures.traces))]

    @cached_property
    def turn(self) -> list[float]:
        """From the motion turned upright to that in space: nine entries, row by row."""
        assert self.form.attitude is not None
        return [float(e) for e in self.form.attitude.turn(FINE)]

    @cached_property
    def place(self) -> tuple[float, list[float], tuple[float, ...]]:
        """On a plane: the variable and the place at the start, and the direction."""
        plane = self.form.quadratures.plane
        assert plane is not None
        origin = [float(self.form.exact(q)(FINE)) for q in plane.place]
        direction = tuple(map(float, self.form.direction(FINE)))
        return float(self.form.problem.place(FINE)), origin, direction

    @cached_property
    def from_start(self) -> tuple[float, float]:
        """The variable less its value at the start, at both ends: what it goes is known to its own
        last bit, however short its way."""
        with precise(FINE):
            constants = self.form.solution.constants(FINE)
            place = self.form.problem.place(FINE)
            return float(constants.base - place), float(constants.other - place)

    @cached_property
    def reach(self) -> list[tuple[tuple[float, float], tuple[float, float]]]:
        """Of each trace: 1 - cosine and 1 + cosine at both ends."""
        reaches = []
        for i in range(len(self.form.quadratures.traces)):
            south, north = (self._cosine_from(i, side) for side in (-1, 1))
            reaches.append((south, north))
        return reaches

    def _cosine_from(self, i: int, side: int) -> tuple[float, float]:
        def at(bits: int, constants: Any) -> list[Any]:
            offset, slope = self._part(bits, self.form.problem.prepared.cosine_at + 2 * i, 2)
            return [1 + side * (offset + slope * x) for x in (constants.base, constants.other)]

        low, high = _round_numbers(self.form, at)
        return max(low, 0.0), max(high, 0.0)

    @cached_property
    def cosines(self) -> list[tuple[float, float]]:
        """Of each trace: the cosine, offset + slope x."""
        count = len(self.form.quadratures.traces)
        flat = [float(c) for c in self._part(FINE, self.form.problem.prepared.cosine_at, 2 * count)]
        return list(zip(flat[::2], flat[1::2], strict=True))

    @cached_property
    def distances(self) -> list[tuple[float, float]]:
        """Of each pole: x less its place at both ends."""
        gaps = []
        for i in range(len(self.form.problem.prepared.poles)):

            def at(bits: int, constants: Any, i: int = i) -> list[Any]:
                place = self._part(bits, 5 + 2 * i, 1)[0]
                return [constants.base - place, constants.other - place]

            low, high = _round_numbers(self.form, at)
            gaps.append((low, high))
        return gaps

    @cached_property
    def fractions(self) -> list[tuple[Bernstein, tuple[int, ...]]]:
        """Of each rate: its numerator, and which poles are in its denominator."""
        weights = [pole.weight for pole in self.form.problem.source(FINE).poles]
        quotients = []
        for j, row in enumerate(self.form.problem.prepared.shares):
            used = [i for i, share in enumerate(row) if share and not weights[i].is_zero()]
            numerator = bernstein(self.form, partial(self._numerator, j, used))
            quotients.append((numerator, tuple(used)))
        return quotients

    def _numerator(self, j: int, used: Sequence[int], bits: int) -> list[Any]:
        from flint import arb_poly

        compiled = self.form.problem.prepared
        with precise(bits):
            factors = [arb_poly([-self._part(bits, 5 + 2 * i, 1)[0], 1]) for i in used]
            total = arb_poly(self._part(bits, compiled.quotient_at + 3 * j, 3))
            for factor in factors:
                total *= factor
            for at, i in enumerate(used):
                part = arb_poly([compiled.shares[j][i] * self._part(bits, 6 + 2 * i, 1)[0]])
                for other in factors[:at] + factors[at + 1 :]:
                    part *= other
                total += part
            row = list(total)
            while len(row) > 1 and row[-1].is_zero():
                row.pop()
            return row or [ball(0)]

    @cached_property
    def polynomials(self) -> list[Bernstein]:
        """Polynomials in x that the velocities hold."""
        x = self.form.quadratures.x
        forms = []
        for e in reading_of(self.form.problem.prepared).polynomials:
            exact = [self.form.exact(c) for c in ascending_coefficients(e, x, int(sp.degree(e, x)))]
            forms.append(bernstein(self.form, partial(_at, exact)))
        return forms

    @cached_property
    def slides(self) -> list[tuple[float, float, float]]:
        """Of a place on a plane: the slopes by the variable, along and across."""
        flat = [float(c) for c in self._part(FINE, self.form.problem.prepared.slope_at, 6)]
        return list(zip(flat[::3], flat[1::3], flat[2::3], strict=True))

    def rates(self, sample: Any, ends: tuple[np.ndarray, np.ndarray]) -> list[Any]:
        """The rates of angles and places by the time of the quartic; ``ends``: shares in x."""
        apart = [sample.affine(*distances) for distances in self.distances]
        speeds = []
        for numerator, used in self.fractions:
            rate = evaluate_form(numerator, *ends)
            for i in used:
                rate = rate / apart[i]
            speeds.append(rate)
        return speeds

    def _part(self, bits: int, first: int, count: int) -> list[Any]:
        return self.form.problem.table(bits)[first : first + count]


def _at(row: Sequence[Callable[[int], Any]], bits: int) -> list[Any]:
    return [c(bits) for c in row]


def rounded_constants(form: InvertedMotion) -> RoundedConstants:
    """Those of a motion, kept with it."""
    return form.memo.once("rounded constants", lambda: RoundedConstants(form))

"""Taylor's method in any precision, on integers: slow, portable, and an independent reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, inf, log, log2
from typing import Any

import flint
import mpmath
import numpy as np

from voronec.algebra.tape import as_ball
from voronec.equations.program import Program
from voronec.equations.program.python import compiled_digits
from voronec.equations.program.recurrences import Recurrences, fixed_point, recurrences
from voronec.motion.crossings import Levels
from voronec.motion.steppers.run import COLLAPSE, INFINITE, Integrator, Problem, Run
from voronec.motion.steppers.series_reach import BLIND, FAITHFUL, HALVINGS, SHRINKS
from voronec.motion.steppers.step_loop import IntegratorFailure, Stride, march
from voronec.motion.steppers.units import SMALL, natural_units

GUARD = 64
"""Bits beyond those of the tolerance."""
NARROW = 24
"""A divisor or a factor that costs more bits than this asks for as many more."""
WIDEST = 4096
"""More guard bits than these are not asked for."""
ORDER = 0.6
"""The order of the method, in units of log(1/tol)."""
SPARSE = 1.0
"""A step longer than the other coefficients allow, by so many powers of two, is not trusted."""
SHARES = 200
"""Bits of the share of a step that there is room for: beside a corner that is hardly rounded it is
a millionth of the first guess."""
SMALLEST, SHORTER = 1e-13, 1e-6
"""A step below the one part of the span, or the tolerance of it where that is less, and below the
other of the longest, leads nowhere."""
DOUBLE = 53
"""Bits of a double."""


def digits(problem: Problem) -> Integrator:
    """The integrator; ``EngineLimit`` for a function that it has no recurrence for.

    The order and the step come from the last two coefficients [JorbaZou2005, section 3]: with the
    order N = 0.6 log(1/tol) a step is as long as they leave the tolerance room.
    """
    rules = recurrences(problem.program)
    bits = ceil(-log2(problem.tol)) + GUARD
    if problem.exact is not None:
        start, parameters = problem.exact(bits)
        problem = replace(problem, start=start, parameters=parameters)
    levels = _digit_levels(problem.levels, problem.parameters)

    def run(grid: np.ndarray) -> Run:
        stepper = DigitsStepper(rules, problem, grid, bits)
        with mpmath.workprec(bits):
            course = march(problem, grid, stepper, levels)
            return replace(course, t=np.array([mpmath.mpf(t) for t in course.t], dtype=object))

    return run


def _digit_levels(levels: Program | None, parameters: Sequence[Any]) -> Levels:
    """The events' functions at times (k,) and states (k, n) of mpmath's numbers, (k, m)."""
    if levels is None:
        return lambda t, _states: np.empty((len(t), 0))
    _, extras = compiled_digits(levels)
    every = range(len(levels.names))

    def function(t: np.ndarray, states: np.ndarray) -> np.ndarray:
        try:
            results = extras(t, list(states.T), list(parameters))
        except ZeroDivisionError:  # where a step leads past a pole, or what cancels is divided by
            if len(t) == 1:
                return np.array([[_alone(levels, k, t[0], states[0], parameters) for k in every]])
            moments = range(len(t))
            return np.vstack([function(t[i : i + 1], states[i : i + 1]) for i in moments])
        return np.stack([np.broadcast_to(r, t.shape) for r in results], axis=1)

    return function


def _alone(
    levels: Program, place: int, time: Any, state: np.ndarray, parameters: Sequence[Any]
) -> Any:
    """One function of several, nan where it has no value: the others may have one."""
    single = levels.only([place])
    try:
        return compiled_digits(single)[1](time, list(state), list(parameters))[0]
    except ZeroDivisionError:
        return mpmath.nan


def _units_of(number: Any, bits: int) -> int:
    """A number in units of 2^-bits."""
    with flint.ctx.workprec(bits + 128):
        return fixed_point(as_ball(number), bits)


def _number(units: int, bits: int, kept: int) -> Any:
    return mpmath.mp.make_mpf(mpmath.libmp.from_man_exp(units, -bits, kept, "n"))


@dataclass(frozen=True)
class _Polynomial:
    """Rows of coefficients of ((t - start)/step)^k, all in units of 2^-bits."""

    rows: list[list[int]]
    start: int
    step: int
    bits: int
    kept: int

    def state(self, place: int) -> list[int]:
        """The variables where (t - start)/step is ``place``."""
        result = []
        for row in self.rows:
            value = 0
            for coefficient in reversed(row):
                value = (value * place >> self.bits) + coefficient
            result.append(value)
        return result

    def slopes(self, place: int) -> list[int]:
        """The rates of the variables there, times the step."""
        result = []
        for row in self.rows:
            value = 0
            for k in range(len(row) - 1, 0, -1):
                value = (value * place >> self.bits) + k * row[k]
            result.append(value)
        return result

    def at(self, times: np.ndarray) -> np.ndarray:
        """States (k, n) at times (k,), as mpmath's numbers."""
        states = np.empty((len(times), len(self.rows)), dtype=object)
        for i, time in enumerate(times):
            # a step to an end that is nearer than the last bit goes nowhere
            place = ((_units_of(time, self.bits) - self.start) << self.bits) // (self.step or 1)
            states[i] = [_number(x, self.bits, self.kept) for x in self.state(place)]
        return states


@dataclass
class DigitsStepper:
    """The integrator under way; all its numbers are integers in units of 2^-bits."""

    rules: Recurrences
    problem: Problem
    grid: np.ndarray
    bits: int
    evaluations: int = 0
    wider: int = 0
    longest: float = 0.0

    def __post_init__(self) -> None:
        self.kept = self.bits - GUARD // 2
        self.order = ceil(ORDER * -log(self.problem.tol)) + 3
        self.units = natural_units(self.problem)
        self.bits += self._below_one() + self._above_one()
        self.expand = self.rules.expansion(self.problem.parameters, self.bits)
        self.state = [_units_of(x, self.bits) for x in self.problem.start]
        self.time, self.end = (_units_of(t, self.bits) for t in self.grid[[0, -1]])
        self.least = min(SMALLEST, self.problem.tol) * float(np.ptp(self.grid))
        self.guess = min(abs(self.end - self.time), 1 << self.bits)

    def _below_one(self) -> int:
        """Bits before the first of what is smallest: fixed points have no digits of it without."""
        values = [abs(float(x)) for x in self.problem.parameters]
        least = min([x for x in (*self.units.tolist(), *values) if x > 0], default=1.0)
        return max(0, ceil(-log2(least))) if least < SMALL else 0

    def _above_one(self) -> int:
        """Bits that a large constant, such as 1/l^3 of a short length, makes of roundings."""
        larger = self.rules.magnitude(self.problem.parameters)
        return larger if larger > NARROW else 0

    def advance(self) -> Stride:
        """The next step, as long as the guess or, where that is too long, shorter."""
        left = self.end - self.time
        step = min(self.guess, abs(left)) * (1 if left > 0 else -1)
        before = self.bits
        rows = self.expand_step(step)
        bits, start, step = self.bits, self.time, step << self.bits - before
        room = self.room(rows)
        part = _share(1 << bits, min(room, 1.0))
        polynomial = _Polynomial(rows, start, step, bits, self.kept)
        self.guess = _share(abs(step), min(room, 2.0))
        part = self.faithful(polynomial, part)
        self.time = self.time + (step * part >> bits)
        taken = abs(self.time - start)
        self.longest = max(self.longest, float(_number(taken, bits, DOUBLE)))
        short = taken < _units_of(min(self.least, SHORTER * self.longest), bits)
        if short and self.time != self.end:
            raise IntegratorFailure(COLLAPSE)
        self.state = polynomial.state(part)
        return Stride(
            _number(start, bits, 2 * bits), _number(self.time, bits, 2 * bits),
            np.array([_number(x, bits, self.kept) for x in self.state], dtype=object),
            polynomial.at,
        )  # fmt: skip

    def expand_step(self, step: int) -> list[list[int]]:
        """The coefficients; with more bits, where a small divisor or a large factor ate them."""
        try:
            rows, least, grown = self.expand(self.state, self.time, step, self.order)
        except (ValueError, ZeroDivisionError, OverflowError):
            raise IntegratorFailure(INFINITE) from None
        self.evaluations += 1
        eaten = max(2 * (self.bits - least.bit_length()), grown)
        if eaten <= NARROW + self.wider or self.wider >= WIDEST:
            return rows
        more = eaten - self.wider
        self.wider, self.bits = self.wider + more, self.bits + more
        self.expand = self.rules.expansion(self.problem.parameters, self.bits)
        self.state = [x << more for x in self.state]
        self.time, self.end, self.guess = (x << more for x in (self.time, self.end, self.guess))
        return self.expand_step(step << more)

    def faithful(self, polynomial: _Polynomial, part: int) -> int:
        """The part of a step whose defect is of the size of the tolerance: half of it, and so on,
        where the series does not know what is to come."""
        deep = log2(self.problem.tol)
        allowed, worst = BLIND * deep, self.defect(polynomial, part)
        if worst <= allowed:
            return part
        for _ in range(HALVINGS):
            less = self.defect(polynomial, part >> 1)
            if worst <= allowed and less > worst + log2(SHRINKS):
                break  # what is left is rounding
            part, worst = part >> 1, less
            if worst <= min(allowed, deep + log2(FAITHFUL)):
                break
        self.guess = min(self.guess, abs(polynomial.step) * part >> self.bits)
        return part

    def defect(self, polynomial: _Polynomial, part: int) -> float:
        """log2 of by how much the slope of a series misses the right side at the end of a part."""
        state, bits, step = polynomial.state(part), self.bits, polynomial.step
        try:
            right, *_ = self.expand(state, polynomial.start + (step * part >> bits), step, 1)
        except (ValueError, ZeroDivisionError, OverflowError):
            return inf
        slopes = polynomial.slopes(part)
        missed = [
            (abs(row[1] - slope) * part >> bits, size)
            for row, slope, size in zip(right, slopes, self.sizes(polynomial.rows), strict=True)
        ]
        return max((_log(miss) - _log(size) for miss, size in missed), default=-inf)

    def sizes(self, rows: list[list[int]]) -> list[int]:
        """Of the variables at the start of a step: at least their units."""
        units = [_units_of(u, self.bits) for u in self.units.tolist()]
        return [max(u, abs(row[0])) for u, row in zip(units, rows, strict=True)]

    def room(self, rows: list[list[int]]) -> float:
        """The longest step that the tolerance leaves, in units of this one."""
        sizes = self.sizes(rows)
        radii = {}
        for k in range(self.order // 2, self.order + 1):
            pairs = zip(rows, sizes, strict=True)
            worst = max((_log(abs(row[k])) - _log(size) for row, size in pairs), default=-inf)
            if worst > -inf:
                radii[k] = -worst / k
        depth = log2(self.problem.tol)
        last = [radii[k] + depth / k for k in (self.order - 1, self.order) if k in radii]
        # where the last coefficients vanish at once, others tell
        others = min(radii.values(), default=inf) + depth / self.order
        radius = min(last, default=inf)
        return float(2.0 ** min(radius if radius <= others + SPARSE else others, 1023.0))


def _share(number: int, share: float) -> int:
    """A share of a number, however small."""
    return number * int(share * 2**SHARES) >> SHARES


def _log(number: int) -> float:
    return log2(number) if number else -inf

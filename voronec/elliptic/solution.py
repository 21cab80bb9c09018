"""The inversion of an elliptic integral: x and the integrals along it, at any time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from flint import acb, arb, ctx, fmpq

from voronec.elliptic.assembly import assemble
from voronec.elliptic.constants import Constants, Numbers, Source
from voronec.elliptic.doubles import BITS, Doubles, prepare_doubles
from voronec.elliptic.lattice import lattice_of, time_from
from voronec.elliptic.roots import OpenDecision, ends_of, interval, resolve
from voronec.elliptic.theta_balls import Moment, moment_of
from voronec.errors import EngineLimit

GUARD = 64
"""Bits beyond those asked for: inversions and logarithms lose some."""
PEOPLE = 60
"""Bits of what is shown to people: a double's, and some."""


@dataclass(frozen=True)
class Enclosed:
    """A motion at one time, each number as a ball that contains the truth.

    Attributes:
        x: the variable.
        rate: dx/dt.
        integrals: since t = 0, continuous.
        near: share of ``base`` in x, in [0, 1]; that of ``other`` is ``far``.
        far: ``x = near base + far other``.
        base: an end of the motion.
        other: the other end.
    """

    x: arb
    rate: arb
    integrals: tuple[arb, ...]
    near: arb
    far: arb
    base: arb
    other: arb

    def affine(self, at_base: arb, at_other: arb) -> arb:
        """An affine function of x, from its values at the ends: near at_base + far at_other."""
        return self.near * at_base + self.far * at_other


@dataclass(unsafe_hash=True)
class Solution:
    """A motion ``(dx/dt)^2 = f(x)`` and the integrals along it.

    Attributes:
        source: the exact problem, as numbers at any precision.
    """

    source: Source
    _known: dict[int, Constants] = field(default_factory=dict, repr=False, compare=False)

    def constants(self, bits: int) -> Constants:
        """All that does not depend on time, correct to at least so many bits.

        Raises:
            DefinitionError: there is no such motion.
            EngineLimit: a decision could not be taken: two roots of f that are perhaps equal.
        """
        for known in sorted(self._known):
            if known >= bits:
                return self._known[known]

        def work(working: int) -> Constants:
            constants = assemble(self.source(working))
            if not accurate(constants, bits):
                raise OpenDecision("the constants are not accurate enough")
            return constants

        self._known[bits] = resolve(work, bits + GUARD)
        return self._known[bits]

    @cached_property
    def doubles(self) -> Doubles:
        """What its values at many times are evaluated from, in doubles."""
        return prepare_doubles(self.constants(BITS))

    def enclose(self, t: Any, digits: int = 50) -> Enclosed:
        """The motion at a time, rigorously: every radius is below ``10^-digits``.

        The time is an int, a float, a Fraction, a decimal in a string, a ball, or a function
        that gives it as a ball at so many bits.

        Raises:
            EngineLimit: that cannot be had: the time is a wide ball, or the moment that of a
                passage through a pole.
        """
        bound = arb(10) ** -digits

        def work(working: int) -> Enclosed:
            constants = self.constants(working)
            enclosed = _enclose(constants, moment_of(constants, exact_time(t)))
            if all(
                value.rad() < bound for value in (enclosed.x, enclosed.rate, *enclosed.integrals)
            ):
                return enclosed
            if isinstance(t, arb) and not t.is_exact() and working > 4 * bits:
                raise EngineLimit(f"no {digits} digits at t = {t.str(10)}: the time is a wide ball")
            raise OpenDecision(f"no {digits} digits at t = {t}")

        bits = int(digits * 3.33) + GUARD
        return resolve(work, bits)

    def delay(self, place: arb, bits: int) -> arb:
        """The time from ``constants(bits).turn`` until x is at a place between the two ends.

        Raises:
            OpenDecision: more bits are needed.
        """
        constants = self.constants(bits)
        if constants.kind == "exponential":
            ratio = constants.mean * (place - constants.base) / (constants.other - place)
            return ratio.log() / (2 * constants.scale)
        numbers = _numbers(self.source, bits)
        return time_from(lattice_of(numbers, interval(numbers)), place - constants.base)

    @property
    def period(self) -> float:
        """The time from one turning point at an end to the next there; infinite if none."""
        half = self.constants(PEOPLE).half
        return float("inf") if half is None else 2 * float(half)

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the greatest x, or their limits."""
        constants = self.constants(PEOPLE)
        low, high = sorted((float(constants.base), float(constants.other)))
        return low, high

    @property
    def roots(self) -> tuple[complex, ...]:
        """The finite roots of f, real ones first, each as often as it is repeated."""
        return tuple(complex(root) for root in self.constants(PEOPLE).roots)

    @property
    def invariants(self) -> tuple[float, float, float]:
        """g2, g3 and the discriminant ``g2^3 - 27 g3^2``."""
        g2, g3, discriminant = self.constants(PEOPLE).invariants
        return float(g2), float(g3), float(discriminant)

    @property
    def arguments(self) -> tuple[complex | None, ...]:
        """The elliptic arguments of the poles: the complex times at which x is there.

        Counted from the turning point at ``constants.base``; the sign of the imaginary part is
        that of the turn of the integral. None for a pole that adds nothing.
        """
        constants = self.constants(PEOPLE)
        scale = complex(constants.scale)
        half = 0.0 if constants.half is None else float(constants.half)
        times: dict[int | None, complex] = {}
        for phase in constants.phases:
            times[phase.pole] = phase.side * half + 1j * float(phase.alpha) / scale
        for log_term in constants.log_terms:
            times[log_term.pole] = log_term.side * half + complex(log_term.place) / scale
        numbers = _numbers(self.source, PEOPLE)
        return tuple(times.get(place) for place in range(len(numbers.poles)))


def invert(source: Source) -> Solution:
    """The motion of a problem given at any precision.

    Raises:
        DefinitionError: there is no real motion through the start, or x is not bounded.
        EngineLimit: it could not be decided.
    """
    ends_of(source)
    return Solution(source)


def accurate(constants: Constants, bits: int) -> bool:
    """Whether every field is correct to so many bits (see ``_demands``)."""
    unit = arb(2) ** -bits
    return all(_within(value, least, unit) for value, least in _demands(constants))


def exact_time(t: Any) -> arb:
    """A time as a ball at the present precision."""
    if isinstance(t, arb):
        return t
    if callable(t):
        return t(ctx.prec)
    if isinstance(t, Fraction):
        return arb(fmpq(t.numerator, t.denominator))
    if isinstance(t, str):
        return exact_time(Fraction(t))
    return arb(t)


def _numbers(source: Source, bits: int) -> Numbers:
    before = ctx.prec
    try:
        ctx.prec = bits
        return source(bits)
    finally:
        ctx.prec = before


def _enclose(constants: Constants, moment: Moment) -> Enclosed:
    integrals = tuple(
        value - start for value, start in zip(moment.expressions, constants.starts, strict=True)
    )
    return Enclosed(
        moment.x, moment.rate, integrals, moment.near, moment.far, constants.base, constants.other
    )


def _demands(constants: Constants) -> Iterator[tuple[arb | acb, arb | int]]:
    """Numbers, and the least size against which their errors count."""
    span = abs(constants.other - constants.base)
    yield constants.base, span
    yield constants.other, span
    for value in (constants.scale, constants.mean, constants.nome):
        yield value, 0
    # Between two double roots nothing turns: "turn" is when x is at its mean, and may be zero.
    yield constants.turn, 1 / constants.scale if constants.kind == "exponential" else 0
    if constants.half is not None:
        yield constants.half, 0
    for rate in constants.rates:
        yield rate, constants.scale
    for value in (*constants.starts, *(constants.advances or ())):
        yield value, 1
    for pair in constants.bounded_terms:
        yield pair[0], 1
        yield pair[1], 1
    for phase in constants.phases:
        yield phase.alpha, 0
        yield from ((share, 1) for share in phase.shares if isinstance(share, arb))
    for log_term in constants.log_terms:
        yield log_term.place, 1
        yield from ((value, 1) for value in (*log_term.logs, *log_term.zetas))


def _within(value: arb | acb, least: arb | int, unit: arb) -> bool:
    if value.is_zero():
        return True
    size = abs(value.mid()) if isinstance(value, arb) else abs(acb(value.mid()))
    return bool(value.rad() <= unit * size.max(arb(least).abs_upper()))

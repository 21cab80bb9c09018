"""A motion at a stretch of times, in doubles: few enough that all arrays stay in the cache."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from voronec.elliptic.arguments import Arguments
from voronec.elliptic.doubles import Course, Doubles
from voronec.elliptic.reduction import two_product
from voronec.elliptic.strained import angle_into, strained

__all__ = ["Stretch"]

TURN = 2 * math.pi
Origin = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Stretch:
    """The motion at a stretch of times; what several results need is computed once.

    Attributes:
        doubles: the motion.
        arguments: of the sums at the times.
        courses: of the integrals.
        origins: of each integral: its value at t = 0 before it is taken off, in radians and turns.
    """

    doubles: Doubles
    arguments: Arguments
    courses: tuple[Course, ...]
    origins: tuple[Origin, ...]

    @property
    def x(self) -> np.ndarray:
        """The variable."""
        return self.affine(self.doubles.base, self.doubles.other)

    def affine(self, at_base: float, at_other: float) -> np.ndarray:
        """An affine function of x from its values at the ends."""
        near, far = self.arguments.weights
        passing = self.arguments.passing
        value = np.multiply(near, at_base, out=self.arguments.spare())
        mark = passing.mark()
        value += np.multiply(far, at_other, out=self.arguments.spare())
        passing.free(mark)
        return value

    def colatitude(self, south: tuple[float, float], north: tuple[float, float]) -> np.ndarray:
        """``2 atan sqrt((1 - l)/(1 + l))``, from ``1 - l`` and ``1 + l`` at both ends."""
        angle = self.affine(*south)
        mark = self.arguments.passing.mark()
        angle /= self.affine(*north)
        self.arguments.passing.free(mark)
        np.sqrt(angle, out=angle)
        np.arctan(angle, out=angle)
        angle *= 2.0
        return angle

    @cached_property
    def rate(self) -> np.ndarray:
        """dx/dt."""
        doubles = self.doubles
        near, far = self.arguments.weights
        kind = doubles.constants.kind
        if kind == "rest":
            return np.zeros_like(near)
        if kind == "exponential":
            return 2 * doubles.scale * doubles.span * near * far
        square = doubles.gradient * near * far
        for ratio in doubles.ratios:
            share = near + ratio.real * far
            square *= share**2 + (ratio.imag * far) ** 2 if ratio.imag else np.abs(share)
        speed = np.copysign(np.sqrt(square), self.arguments.reduced[1])
        speed *= math.copysign(1.0, doubles.span) * (1 - 2 * self.arguments.odd)
        return speed

    def integral(self, number: int, start: float = 0.0) -> np.ndarray:
        """An integral along the motion, ``start`` at t = 0 and continuous."""
        course = self.courses[number]
        count, rest = self.arguments.reduced
        periodic = self._periodic(number)
        value = np.multiply(rest, course.slope, out=self.arguments.spare())
        mark = self.arguments.passing.mark()
        spare = self.arguments.spare()
        if course.second:
            value += np.multiply(count, course.second, out=spare)
        _add(value, periodic, 1.0, spare)
        value += start - self.origins[number][0]
        # The only rounding of the size of the value is the last.
        if course.first:
            value += np.multiply(count, course.first, out=spare)
        self.arguments.passing.free(mark)
        return value

    def modulo(self, number: int, start: float = 0.0) -> np.ndarray:
        """The same as an angle in (-pi, pi]."""
        periodic = self._periodic(number)
        value = self.arguments.spare()
        mark = self.arguments.passing.mark()
        spare = self.arguments.spare()
        self._turned(self.courses[number], value, spare)
        _add(value, periodic, 1 / TURN, spare)
        value += start / TURN - self.origins[number][1]
        np.subtract(value, 0.5, out=spare)
        value -= np.ceil(spare, out=spare)
        value *= TURN
        self.arguments.passing.free(mark)
        return value

    def _turned(self, course: Course, value: np.ndarray, spare: np.ndarray) -> None:
        """The steady part of an integral in turns, less whole ones."""
        count, rest = self.arguments.reduced
        high, low = course.spin
        other = self.arguments.spare()
        if course.exact:
            first, second = self.arguments.reduction.tail(self.arguments.times, count)
            product, error = two_product(first, high)
            product -= np.rint(product)
            np.add(product, error + first * low + second * high, out=value)
        else:
            np.multiply(rest, high, out=value)
        for share in course.turns:
            if share:
                more = np.multiply(count, share, out=spare)
                more -= np.rint(more, out=other)
                value += more

    def _periodic(self, number: int) -> list[tuple[float, np.ndarray]]:
        """The periodic parts of an integral: factors and arrays."""
        doubles = self.doubles
        found = [(share, self._angles(place)) for place, share in doubles.shares[number]]
        ripple = doubles.ripples[number]
        if ripple.size:
            powers = self.arguments.powers[: ripple.size]
            found.append((1.0, np.matmul(ripple, powers, out=self.arguments.spare())))
        for place in doubles.strains[number]:
            z = self.arguments.z(doubles.constants.strains[place].side)
            found.append((1.0, strained(doubles, place, number, z)))
        p, q = doubles.swings[number]
        if p or q:
            found.append((1.0, (p + q * self.x) * self.rate))
        return found

    @cached_property
    def _known(self) -> dict[int, np.ndarray]:
        return {}

    def _angles(self, place: int) -> np.ndarray:
        """The periodic part of a phase, but for its ripple."""
        if place in self._known:
            return self._known[place]
        angle = self.doubles.angles[place]
        variable, across, z = self.arguments.own(angle.side)
        value = self.arguments.new()
        mark = self.arguments.passing.mark()
        angle_into(angle, variable, across, value, self.arguments.spare())
        self.arguments.passing.free(mark)
        sign = angle.sign
        if angle.side == 1 and self.doubles.constants.kind == "trigonometric":
            sign = -sign  # X is that of the base
        if sign < 0:
            np.negative(value, out=value)
        if angle.drift:
            value -= angle.drift * z
        self._known[place] = value
        return value


def _add(
    value: np.ndarray, parts: list[tuple[float, np.ndarray]], unit: float, spare: np.ndarray
) -> None:
    """Add parts with their factors, in that unit."""
    for share, part in parts:
        factor = share * unit
        if factor == 1.0:
            value += part
        elif factor == -1.0:
            value -= part
        else:
            value += np.multiply(part, factor, out=spare)

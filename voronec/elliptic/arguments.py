"""The arguments of the sums at a stretch of times, in doubles, and the shares of both ends in x.

Times are counted from the nearest turning point, of either end; what is counted from the other
one follows by the addition theorems of half a period, so that nothing cancels near either.

Arrays of one length are taken from memory and given back like a stack.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from voronec.elliptic.doubles import Doubles
from voronec.elliptic.reduction import Reduction
from voronec.elliptic.theta_polynomials import horner

__all__ = ["PIECE", "Arguments", "Rows", "matrix"]

PIECE = 1 << 19
"""Numbers in a piece of memory that the system hands out in large pages, which is far faster."""


def matrix(count: int, size: int) -> np.ndarray:
    """So many arrays, their values arbitrary, in one piece of memory."""
    enough = count * size
    piece = np.empty(max(enough, PIECE) if enough > PIECE // 8 else enough)
    return piece[:enough].reshape(count, size)


class Rows:
    """A stack of arrays in few pieces of memory.

    New memory for every array would cost as much as the arithmetic on it.
    """

    def __init__(self, count: int, size: int) -> None:
        """Arrays of up to ``size`` numbers, made ``count`` at a time."""
        self._count, self._size = count, size
        self._pieces: list[np.ndarray] = []
        self._rows: list[np.ndarray] = []
        self._taken = 0

    def new(self, size: int) -> np.ndarray:
        """An array of so many numbers, their values arbitrary."""
        place = self._taken
        if place == len(self._rows):
            self._add()
        self._taken = place + 1
        row = self._rows[place]
        return row if size == self._size else row[:size]

    def several(self, count: int, size: int) -> np.ndarray:
        """That many arrays, as the rows of a matrix."""
        if count > self._count:
            return np.empty((count, size))
        piece, place = divmod(self._taken, self._count)
        if place + count > self._count:
            piece, place = piece + 1, 0
        if piece == len(self._pieces):
            self._add()
        self._taken = piece * self._count + place + count
        return self._pieces[piece][place : place + count, :size]

    def _add(self) -> None:
        self._pieces.append(np.empty((self._count, self._size)))
        self._rows += list(self._pieces[-1])

    def mark(self) -> int:
        """Where to go back to with ``free``."""
        return self._taken

    def free(self, mark: int = 0) -> None:
        """Take back all arrays since the mark."""
        self._taken = mark


Arrays = tuple[np.ndarray, ...]
STEEP = 350.0
"""Half periods in z beyond which the polynomials are constants, and their variable overflows."""


@dataclass(frozen=True, eq=False)
class Arguments:
    """Arguments of the sums at given times, few enough for the cache.

    Attributes:
        doubles: the motion.
        times: in one dimension.
        reduction: how the times become phases.
        kept: memory of what is computed once.
        passing: memory of results and of what is needed on the way.
        phases: where the phases themselves are given, whole half periods, the rest of time and 1
            where the nearest turning point is at the other end, each of shape (times,).
    """

    doubles: Doubles
    times: np.ndarray
    reduction: Reduction
    kept: Rows
    passing: Rows
    phases: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def new(self) -> np.ndarray:
        """An array to be kept."""
        return self.kept.new(self.times.size)

    def spare(self) -> np.ndarray:
        """An array that passes."""
        return self.passing.new(self.times.size)

    @cached_property
    def phase_reduction(self) -> Arrays:
        """Whole half periods, and the rest of time from the nearest turning point."""
        if self.phases is not None:
            return self.phases[:2]
        number, rest = self.new(), self.new()
        mark = self.passing.mark()
        self.reduction.apply(self.times, number, rest, self.spare())
        self.passing.free(mark)
        return number, rest

    @cached_property
    def odd(self) -> np.ndarray:
        """1 where the nearest turning point is at the other end, 0 where at the base."""
        if self.phases is not None:
            return self.phases[2]
        count = self.phase_reduction[0]
        odd = np.multiply(count, 0.5, out=self.new())
        np.rint(odd, out=odd)
        odd *= -2.0
        odd += count
        odd *= odd
        return np.subtract(1.0, odd, out=odd) if self.doubles.odd else odd

    def own(self, side: int) -> Arrays:
        """Of the phases of a side: the variable of their polynomials, X, and z.

        Trigonometric: ``sin^2 z``, ``sin z cos z`` counted from the base for both sides, and
        no z. The others: ``sinh^2 z`` (where it is needed), ``tanh z`` or z, and z.
        """
        if self.doubles.constants.kind == "trigonometric":
            product, first, second = self._squares
            return second if side else first, product, product
        return self._second if side else self._first

    def z(self, side: int) -> np.ndarray:
        """z from the nearest turning point of a side, within half of a period."""
        near = self.doubles.scale * self.phase_reduction[1]
        half = self.doubles.half
        if not np.isfinite(half):
            return near
        away = 1.0 - self.odd if side else self.odd
        return np.asarray(near - away * np.copysign(half, near))

    @cached_property
    def powers(self) -> np.ndarray:
        """``sin z cos z cos^k 2z`` from the base, a row for each k that the ripples have."""
        product, first, _ = self._squares
        count = max((len(ripple) for ripple in self.doubles.ripples), default=0)
        rows = self.kept.several(count, self.times.size)
        mark = self.passing.mark()
        if count:
            double = np.multiply(first, -2.0, out=self.spare())
            double += 1.0
            np.copyto(rows[0], product)
        for k in range(1, count):
            np.multiply(rows[k - 1], double, out=rows[k])
        self.passing.free(mark)
        return rows

    @cached_property
    def weights(self) -> Arrays:
        """The shares of base and other in x."""
        kinds = {
            "trigonometric": self._trigonometric,
            "hyperbolic": self._hyperbolic,
            "rational": self._rational,
            "exponential": self._exponential,
            "rest": self._units,
        }
        near, far = kinds[self.doubles.constants.kind]()
        mark = self.passing.mark()
        whole = np.add(near, far, out=self.spare())
        near /= whole
        far /= whole
        self.passing.free(mark)
        return near, far

    @cached_property
    def _squares(self) -> Arrays:
        """sin z cos z from the base, and sin^2 z from either end."""
        odd = self.odd
        sine, first, second = self.new(), self.new(), self.new()
        mark = self.passing.mark()
        square = self.spare()
        np.multiply(self.phase_reduction[1], self.doubles.scale, out=sine)
        np.sin(sine, out=sine)
        np.multiply(sine, sine, out=square)
        np.subtract(1.0, square, out=first)
        # cos^2 - sin^2: what is added to sin^2 where the other end is nearer
        np.subtract(first, square, out=second)
        np.sqrt(first, out=first)
        sine *= first
        np.multiply(odd, second, out=first)
        second -= first
        first += square
        second += square
        np.multiply(odd, -2.0, out=square)
        square += 1.0
        sine *= square
        self.passing.free(mark)
        return sine, first, second

    @cached_property
    def _first(self) -> Arrays:
        return self._tanh(self.z(0))

    @cached_property
    def _second(self) -> Arrays:
        return self._tanh(self.z(1))

    def _tanh(self, z: np.ndarray) -> Arrays:
        if self.doubles.constants.kind == "rational":
            return z, z, z
        across, fading = _tanh(z)
        variable = across**2 / fading if self.doubles.half < STEEP else z
        return variable, across, z

    def _trigonometric(self) -> Arrays:
        weights = self.doubles.weights
        _, first, second = self._squares
        near = horner(first, weights.partner, self.new())
        near *= near
        near *= second
        near *= weights.mean
        far = horner(first, weights.sine, self.new())
        far *= far
        far *= first
        return near, far

    def _hyperbolic(self) -> Arrays:
        doubles, weights = self.doubles, self.doubles.weights
        across, fading = _tanh(self.phase_reduction[1] * doubles.scale)
        across *= across
        variable = across
        if len(weights.sine) > 1 or len(weights.partner) > 1:
            variable = across / fading
        sine = horner(variable, weights.sine, np.empty_like(across)) ** 2 * across
        partner = horner(variable, weights.partner, np.empty_like(across)) ** 2
        if doubles.constants.partner != "theta2":
            partner *= fading
        odd = self.odd > 0
        near = np.where(odd, weights.swapped * sine, weights.mean * partner)
        return near, np.where(odd, partner, sine)

    def _rational(self) -> Arrays:
        far = self.phase_reduction[1] * self.doubles.scale
        far *= far
        return np.full_like(far, self.doubles.weights.mean), far

    def _exponential(self) -> Arrays:
        z = self.phase_reduction[1] * self.doubles.scale
        fading, mean = np.exp(-2 * np.abs(z)), self.doubles.weights.mean
        return np.where(z > 0, mean * fading, mean), np.where(z > 0, 1.0, fading)

    def _units(self) -> Arrays:
        return np.ones_like(self.times), np.zeros_like(self.times)


def _tanh(z: np.ndarray) -> Arrays:
    """``tanh z`` and ``1/cosh^2 z``, both to the last bits however far they have come."""
    size = -2.0 * np.abs(z)
    fading = np.exp(size)
    whole = 1.0 + fading
    across = np.copysign(np.expm1(size) / whole, z)
    fading *= 4.0
    fading /= whole * whole
    return across, fading

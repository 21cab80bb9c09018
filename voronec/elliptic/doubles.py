"""What doubles need to evaluate a motion: rounded constants, reduced times, arguments of the sums.

The constants are rounded once, for all times.  The arguments of the sums are those at a stretch of
times, with the shares of both ends in x.  Times are counted from the nearest turning point, of
either end; what is counted from the other one follows by the addition theorems of half a period, so
that nothing cancels near either.

Arrays of one length are taken from memory and given back like a stack.

Whole half periods are taken off times exactly, and are turns exactly: a half period is split into
parts of so few bits that their products with the number of half periods are exact in doubles,
however late the time; so are the turns that an angle makes in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from flint import acb, arb, ctx

from voronec.elliptic.constants import Constants
from voronec.elliptic.theta_balls import Sums
from voronec.elliptic.theta_polynomials import (
    Angle,
    Weights,
    angle_of,
    period_of,
    periodic_terms_of,
    smooth,
    weights_of,
    with_series,
)
from voronec.errors import EngineLimit

BITS = 320
"""Of constants of which double doubles are made: what a late time magnifies is to be lost."""
SWIFTEST = 2.0**58
"""Radians in half a period, of which two doubles leave all digits of an angle."""
NOTHING = 1e-25
"""A factor of an angle that is none: what rounding leaves of 0."""
LONG = 60.0
"""Radians within half of a half period beyond which a product with a rate is taken exactly."""


@dataclass(frozen=True)
class SecularTerm:
    """What an integral does beside its periodic parts, for times up to some latest.

    Attributes:
        slope: mean rate.
        spin: mean rate in turns, as two doubles.
        exact: whether the product of rate and time must be exact.
        first, second: what it grows by in half a period, as two doubles.
        turns: the same in turns without whole ones, for exact products.
    """

    slope: float
    spin: tuple[float, float]
    exact: bool
    first: float
    second: float
    turns: tuple[float, ...]


@dataclass(eq=False)
class Doubles:
    """A motion ready for evaluation in doubles.

    Attributes:
        constants: with many bits; ``turn`` is the turning point nearest to t = 0.
        odd: whether that is at the other end.
        scale: of z.
        half: half period in z; infinite if there is none.
        base: x at the base.
        other: x at the other end.
        span: ``other - base``.
        weights: of the ends in x.
        angles: of the phases.
        log_phases: phases of the logarithms of the log terms, None where there are no logarithms.
        periodic_terms: of each integral, over ``X cos^k 2z``.
        shares: of each integral: the places of its phases and their factors, less those
            that are all in the periodic_term.
        log_terms: of each integral: the places of its log_terms.
        bounded_terms: as of the constants.
        gradient: ``(dx/dt)^2 = gradient near far product of |near + c far|`` over ``ratios``.
        ratios: c of the other roots of f.
        origins: of each integral: its value at t = 0 before it is taken off, in radians and
            turns; filled in when they are first needed.
        models: what an evaluation begins with, by the latest time that it reaches; the last one.
    """

    constants: Constants
    odd: bool
    scale: float
    half: float
    base: float
    other: float
    span: float
    weights: Weights
    angles: tuple[Angle, ...]
    log_phases: tuple[Angle | None, ...]
    periodic_terms: tuple[np.ndarray, ...]
    shares: tuple[tuple[tuple[int, float], ...], ...]
    log_terms: tuple[tuple[int, ...], ...]
    bounded_terms: tuple[tuple[float, float], ...]
    gradient: float
    ratios: tuple[complex, ...]
    origins: list[tuple[float, float]] = field(default_factory=list, repr=False)
    models: dict[float, Any] = field(default_factory=dict, repr=False)

    def reduction(self, latest: float) -> QuarticReduction:
        """Of times up to ``latest`` in absolute value."""
        with ctx.workprec(BITS):
            return QuarticReduction.of(self.constants.half, self.constants.turn, latest)

    def secular_term(self, number: int, reduction: QuarticReduction, latest: float) -> SecularTerm:
        """The steady part of an integral."""
        with ctx.workprec(BITS):
            constants = self.constants
            half, mean = constants.half, constants.rates[number]
            first, second = 0.0, 0.0
            whole: tuple[float, ...] = ()
            reach = latest + abs(float(constants.turn.mid()))
            if half is not None and constants.advances is not None:
                gained = constants.advances[number] / 2
                if abs(gained) > SWIFTEST:
                    raise EngineLimit(
                        f"an angle or a place grows by {float(2 * gained):.3g} in a period, which "
                        "doubles do not hold; enclose one instant instead"
                    )
                mean, reach = gained / half, float(half.mid()) / 2
                first, second = advance(gained, reduction)
                whole = turns(gained, reduction)
            spin = mean / (2 * arb.pi())
            high = float(spin.mid())
            return SecularTerm(
                float(mean.mid()), (high, float((spin - arb(high)).mid())),
                abs(float(mean.mid())) * reach > LONG, first, second, whole,
            )  # fmt: skip


def prepare_doubles(constants: Constants) -> Doubles:
    """The doubles of constants with at least ``BITS`` bits."""
    with ctx.workprec(BITS + 64):
        constants, odd = _recount(constants)
        period = period_of(constants)
        log_phases: list[Angle | None] = []
        for log_term in constants.log_terms:
            turning = any(not value.is_zero() for value in log_term.logs)
            alpha = log_term.place.imag
            sign = 1 if alpha.mid() > 0 or alpha.is_zero() else -1
            log_phases.append(angle_of(constants, log_term, alpha, sign) if turning else None)
        angles = tuple(angle_of(constants, p, p.alpha, p.sign) for p in constants.phases)
        gradient, ratios = _speed(constants)
        easy = smooth(angles) if constants.kind == "trigonometric" else (False,) * len(angles)
        with_terms = [with_series(a) if e else a for a, e in zip(angles, easy, strict=True)]
        count = len(constants.rates)
        return Doubles(
            constants=constants, odd=odd, scale=float(constants.scale.mid()),
            half=math.inf if period is None else float(period.mid()) / 2,
            base=float(constants.base.mid()), other=float(constants.other.mid()),
            span=float((constants.other - constants.base).mid()),
            weights=weights_of(constants),
            angles=angles, log_phases=tuple(log_phases),
            periodic_terms=periodic_terms_of(constants, with_terms),
            shares=tuple(_shares(constants, easy, number) for number in range(count)),
            log_terms=tuple(_log_terms(constants, number) for number in range(count)),
            bounded_terms=tuple(
                (float(p.mid()), float(q.mid())) for p, q in constants.bounded_terms
            ),
            gradient=gradient, ratios=ratios,
        )  # fmt: skip


def _recount(constants: Constants) -> tuple[Constants, bool]:
    """The constants with the turning point nearest to t = 0, of either end, as ``turn``."""
    if constants.half is None:
        return constants, False
    count = round(float((-constants.turn / constants.half).mid()))
    turn = constants.turn + count * constants.half if count else constants.turn
    return replace(constants, turn=turn), count % 2 == 1


def _speed(constants: Constants) -> tuple[float, tuple[complex, ...]]:
    """The factors of ``f = f'(base) span near far product of |near + c far|``."""
    if constants.kind in ("rest", "exponential"):
        return 0.0, ()
    base, other = acb(constants.base), acb(constants.other)
    left = list(constants.roots)
    for end in (base, other):
        left.remove(min(left, key=lambda root: float(abs((root - end).mid()))))
    ratios = [complex((other - root) / (base - root)) for root in left]
    span = constants.other - constants.base
    sums = Sums(constants.kind, constants.nome, constants.partner)
    first = constants.scale * sums.slope(arb(0)) / sums.c(arb(0))
    gradient = 4 * (first * span) ** 2 / constants.mean
    return float(gradient.mid()), tuple(ratio for ratio in ratios if ratio.imag >= 0)


def _shares(
    constants: Constants, easy: tuple[bool, ...], number: int
) -> tuple[tuple[int, float], ...]:
    """Of an integral: the phases that are not all in its periodic term, with their factors."""
    shares = [(place, float(one.shares[number])) for place, one in enumerate(constants.phases)]
    return tuple(
        (place, share) for place, share in shares if abs(share) > NOTHING and not easy[place]
    )


def _log_terms(constants: Constants, number: int) -> tuple[int, ...]:
    return tuple(
        place
        for place, one in enumerate(constants.log_terms)
        if not (one.logs[number].is_zero() and one.zetas[number].is_zero())
    )


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
        memory: arrays of what is computed once.
        scratch: arrays of results and of what is needed on the way.
        phases: where the phases themselves are given, whole half periods, the rest of time and 1
            where the nearest turning point is at the other end, each of shape (times,).
    """

    doubles: Doubles
    times: np.ndarray
    reduction: QuarticReduction
    memory: Rows
    scratch: Rows
    phases: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def new(self) -> np.ndarray:
        """An array to be kept."""
        return self.memory.new(self.times.size)

    def spare(self) -> np.ndarray:
        """An array that passes."""
        return self.scratch.new(self.times.size)

    @cached_property
    def phase_reduction(self) -> Arrays:
        """Whole half periods, and the rest of time from the nearest turning point."""
        if self.phases is not None:
            return self.phases[:2]
        number, rest = self.new(), self.new()
        mark = self.scratch.mark()
        self.reduction.apply(self.times, number, rest, self.spare())
        self.scratch.free(mark)
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
        """``sin z cos z cos^k 2z`` from the base, a row for each k that the periodic terms have."""
        product, first, _ = self._squares
        count = max(
            (len(periodic_term) for periodic_term in self.doubles.periodic_terms), default=0
        )
        rows = self.memory.several(count, self.times.size)
        mark = self.scratch.mark()
        if count:
            double = np.multiply(first, -2.0, out=self.spare())
            double += 1.0
            np.copyto(rows[0], product)
        for k in range(1, count):
            np.multiply(rows[k - 1], double, out=rows[k])
        self.scratch.free(mark)
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
        mark = self.scratch.mark()
        whole = np.add(near, far, out=self.spare())
        near /= whole
        far /= whole
        self.scratch.free(mark)
        return near, far

    @cached_property
    def _squares(self) -> Arrays:
        """sin z cos z from the base, and sin^2 z from either end."""
        odd = self.odd
        sine, first, second = self.new(), self.new(), self.new()
        mark = self.scratch.mark()
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
        self.scratch.free(mark)
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
        near = np.where(odd, weights.from_other_end * sine, weights.mean * partner)
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


def horner(variable: np.ndarray, coefficients: tuple[float, ...], out: np.ndarray) -> np.ndarray:
    """The polynomial with these ascending coefficients, written into ``out``."""
    *rest, last = coefficients
    if not rest:
        out.fill(last)
        return out
    if last == 1.0:
        np.add(variable, rest.pop(), out=out)
    else:
        np.multiply(variable, last, out=out)
        out += rest.pop()
    while rest:
        out *= variable
        out += rest.pop()
    return out


def _tanh(z: np.ndarray) -> Arrays:
    """``tanh z`` and ``1/cosh^2 z``, both to the last bits however far they have come."""
    size = -2.0 * np.abs(z)
    fading = np.exp(size)
    whole = 1.0 + fading
    across = np.copysign(np.expm1(size) / whole, z)
    fading *= 4.0
    fading /= whole * whole
    return across, fading


LATEST = 40
"""Half periods may be counted up to two to this power."""
SHARP = 110
"""A moment is kept to two to minus this power of a half period, or of the time to the turning point
that is nearest to the start where that is less: near a pole an angle may turn as fast."""


@dataclass(frozen=True)
class QuarticReduction:
    """How times become a whole number of half periods and a rest.

    Attributes:
        inverse: one over the half period; 0 where that is infinite.
        half: parts of the half period; empty where it is infinite.
        turn: parts of the time of the turning point nearest to t = 0.
        bits: how many a part has.
    """

    inverse: float
    half: tuple[float, ...]
    turn: tuple[float, ...]
    bits: int

    @classmethod
    def of(cls, half: arb | None, turn: arb, latest: float) -> QuarticReduction:
        """The reduction of times up to ``latest``, in absolute value.

        Raises:
            EngineLimit: the times are too many half periods away.
        """
        if half is None:
            return cls(0.0, (), parts(turn, 52, 3), 52)
        inverse = float((1 / half).mid())
        number = max(1, math.ceil(math.log2(latest * inverse + 2)))
        if not math.isfinite(latest) or number > LATEST:
            raise EngineLimit(
                f"t = {latest:.17g} is more than 2^{LATEST} half periods away; "
                "enclose that time instead"
            )
        bits = 52 - number
        top = _top(half)
        deep = 0 if turn.is_zero() else max(0, top - _top(turn))
        count = 1 + math.ceil((number + SHARP + deep - 53) / bits)
        return cls(inverse, parts(half, bits, count, top), parts(turn, bits, count, top), bits)

    def apply(
        self, times: np.ndarray, number: np.ndarray, rest: np.ndarray, product: np.ndarray
    ) -> None:
        """Fill ``number`` with whole half periods, ``rest`` with what is left of each time.

        Both are counted from the turning point, ``|rest|`` is at most half of a half period, and
        as accurate relative to its distance from the turning point as a double can be.
        ``product`` is memory that is needed on the way.
        """
        if not self.half:
            number.fill(0.0)
            np.subtract(times, self.turn[0], out=rest)
            for turn in self.turn[1:]:
                if turn:
                    rest -= turn
            return
        np.subtract(times, self.turn[0], out=number)
        number *= self.inverse
        np.rint(number, out=number)
        np.multiply(number, self.half[0], out=product)
        np.subtract(times, product, out=rest)
        rest -= self.turn[0]
        # What each step leaves is exact, or so large that nothing after it cancels.
        for half, turn in zip(self.half[1:], self.turn[1:], strict=True):
            np.multiply(number, half, out=product)
            if turn:
                product += turn
            rest -= product

    def tail(self, times: np.ndarray, number: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The rest of each time as a sum of two doubles."""
        high, low = times, np.zeros_like(times)
        terms: list[Any] = [number * half for half in self.half]
        for term in (*terms[:1], *self.turn, *terms[1:]):
            high, error = _two_sum(high, -term)
            low += error
        return _two_sum(high, low)


def parts(value: arb, bits: int, count: int, top: int | None = None) -> tuple[float, ...]:
    """Doubles of so many bits each, whose sum is the value below ``2^top``, without its end."""
    mantissa, exponent = (int(part) for part in value.mid().man_exp())
    sign, mantissa = (-1, -mantissa) if mantissa < 0 else (1, mantissa)
    if mantissa == 0:
        return (0.0,) * count
    top = mantissa.bit_length() + exponent if top is None else top
    shift = bits * count - top + exponent
    whole = mantissa << shift if shift >= 0 else mantissa >> -shift
    pieces = []
    for place in range(count - 1, -1, -1):
        pieces.append(math.ldexp(sign * (whole >> (bits * place)), top - bits * (count - place)))
        whole &= (1 << (bits * place)) - 1
    return tuple(pieces)


def turns(value: arb, reduction: QuarticReduction) -> tuple[float, ...]:
    """Parts of the angle ``value`` as a fraction of a turn, in (-1, 1), for exact products."""
    turn = value / (2 * arb.pi())
    whole = int((turn.mid() + arb(0.5)).floor().unique_fmpz())
    return parts(turn - whole, reduction.bits, len(reduction.half), 0)


def advance(value: arb, reduction: QuarticReduction) -> tuple[float, float]:
    """The value as two doubles, the first short enough for an exact product."""
    first = parts(value, reduction.bits, 1)[0]
    return first, float((value - arb(first)).mid())


def _two_sum(one: Any, two: Any) -> tuple[Any, Any]:
    """The rounded sum, and what was rounded off, exactly."""
    high = one + two
    back = high - one
    return high, (one - (high - back)) + (two - back)


def two_product(one: np.ndarray, two: float) -> tuple[np.ndarray, np.ndarray]:
    """The rounded product, and what was rounded off, exactly (no overflow is expected)."""
    high = one * two
    first, second = _halves(one)
    third, fourth = _halves(two)
    return high, ((first * third - high) + first * fourth + second * third) + second * fourth


def _halves(value: Any) -> tuple[Any, Any]:
    scaled = value * 134217729.0
    high = scaled - (scaled - value)
    return high, value - high


def _top(value: arb) -> int:
    mantissa, exponent = (int(part) for part in value.mid().man_exp())
    return abs(mantissa).bit_length() + exponent

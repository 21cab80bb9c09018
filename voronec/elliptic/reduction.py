"""Times less whole half periods, exactly; whole half periods as turns, exactly.

A half period is split into parts of so few bits that their products with the number of half
periods are exact in doubles, however late the time; so are the turns that an angle makes in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb

from voronec.errors import EngineLimit

__all__ = ["Reduction", "advance", "parts", "turns", "two_product", "two_sum"]

LATEST = 40
"""Half periods may be counted up to two to this power."""
SHARP = 110
"""A moment is kept to two to minus this power of a half period."""


@dataclass(frozen=True)
class Reduction:
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
    def of(cls, half: arb | None, turn: arb, latest: float) -> Reduction:
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
        count = 1 + math.ceil((number + SHARP - 53) / bits)
        top = _top(half)
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
            high, error = two_sum(high, -term)
            low += error
        return two_sum(high, low)


def parts(value: arb, bits: int, count: int, top: int | None = None) -> tuple[float, ...]:
    """Doubles of so many bits each, whose sum is the value below ``2^top``, without its end."""
    mantissa, exponent = (int(part) for part in value.mid().man_exp())
    sign, mantissa = (-1, -mantissa) if mantissa < 0 else (1, mantissa)
    if mantissa == 0:
        return (0.0,) * count
    top = mantissa.bit_length() + exponent if top is None else top
    shift = bits * count - top + exponent
    whole = mantissa << shift if shift >= 0 else mantissa >> -shift
    found = []
    for place in range(count - 1, -1, -1):
        found.append(math.ldexp(sign * (whole >> (bits * place)), top - bits * (count - place)))
        whole &= (1 << (bits * place)) - 1
    return tuple(found)


def turns(value: arb, reduction: Reduction) -> tuple[float, ...]:
    """Parts of the angle ``value`` as a fraction of a turn, in (-1, 1), for exact products."""
    turn = value / (2 * arb.pi())
    whole = int((turn.mid() + arb(0.5)).floor().unique_fmpz())
    return parts(turn - whole, reduction.bits, len(reduction.half), 0)


def advance(value: arb, reduction: Reduction) -> tuple[float, float]:
    """The value as two doubles, the first short enough for an exact product."""
    first = parts(value, reduction.bits, 1)[0]
    return first, float((value - arb(first)).mid())


def two_sum(one: Any, two: Any) -> tuple[Any, Any]:
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

"""What angles grow by in a period, and whether that is likely a rational part of a whole turn."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from voronec.algebra.precision import SHARP
from voronec.algebra.symbols import plain_name
from voronec.closed.arithmetic import ball, precise
from voronec.closed.inverted_motion import InvertedMotion

__all__ = ["Turn", "turns_of"]

DIGITS = 50
"""To so many a rational fraction is recognised."""
MOST = 1000
"""Denominators up to this."""


@dataclass(frozen=True)
class Turn:
    """What an angle grows by in a period.

    ``advance`` in radians; ``fraction`` is a fraction whose denominator is at most 1000 and with
    which advance / (2 pi) agrees to 50 digits: the curve is likely closed then, which is no proof.
    """

    advance: float
    fraction: Fraction | None = None


def turns_of(form: InvertedMotion) -> dict[str, Turn]:
    """The turns of all angles by name; none where there is no period."""
    if form.rests:
        return {}
    with precise(SHARP):
        advances = form.solution.constants(SHARP).advances
        if advances is None:
            return {}
        pairs = zip(form.quadratures.angles, advances, strict=False)
        return {plain_name(q): _turn(a) for q, a in pairs}


def _turn(advance: Any) -> Turn:
    fraction = _fraction(advance)
    if fraction is not None:  # the advance is that of the fraction, to the last bit of a double
        advance = 2 * ball(1).pi() * fraction.numerator / fraction.denominator
    return Turn(float(advance), fraction)


def _fraction(advance: Any) -> Fraction | None:
    whole = advance / (2 * ball(1).pi())
    mantissa, exponent = whole.mid().man_exp()
    middle = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    near = middle.limit_denominator(MOST)
    off = abs(whole - ball(near.numerator) / near.denominator)
    return near if off < ball(10) ** -DIGITS else None

"""The numbers of one inversion problem: a polynomial, a start and integrals along the motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from flint import acb, arb

__all__ = ["Integral", "Numbers", "Pole", "Source"]


@dataclass(frozen=True)
class Pole:
    """A pole of the integrands, on the x line.

    Attributes:
        place: where the integrand is infinite; a complex place (``acb``) adds the real part of
            its term, so that a conjugate pair is two poles with conjugate shares (or one with
            twice the share).
        weight: the signed ``w`` with ``f(place) = -4 w^2`` exactly, so that the integral of
            ``w/(x - place)`` is an angle; exactly ``arb(0)`` where the place is a root of
            ``f``; None for a pole of any other kind.
    """

    place: arb | acb
    weight: arb | None = None


@dataclass(frozen=True)
class Integral:
    """The integrand ``constant + linear x + square x^2 + sum of share_c w_c/(x - c)``.

    Attributes:
        constant: of the polynomial part.
        linear: of the polynomial part.
        square: of the polynomial part.
        shares: one per pole: an ``int`` (usually -1, 0 or 1) where the pole has a weight,
            else the number over ``x - c`` itself, an ``arb`` or ``acb``.
    """

    constant: arb
    linear: arb
    square: arb
    shares: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Numbers:
    """An inversion problem ``(dx/dt)^2 = f(x)`` at some precision.

    Attributes:
        factors: squarefree coprime factors of ``f``, coefficients ascending with a nonzero
            leading one, and their multiplicities; usually ``((c0, .., c4), 1)`` alone.
            None at all where f vanishes everywhere.
        place: x at t = 0.
        rate: dx/dt at t = 0; exactly ``arb(0)`` at a turning point.
        poles: the poles of the integrands.
        integrals: the integrands.
        rest: x stays at a multiple root.
    """

    factors: tuple[tuple[tuple[arb, ...], int], ...]
    place: arb
    rate: arb
    poles: tuple[Pole, ...] = ()
    integrals: tuple[Integral, ...] = ()
    rest: bool = False


Source = Callable[[int], Numbers]
"""The same exact problem at any number of bits; flint's ``ctx.prec`` is set by the caller."""

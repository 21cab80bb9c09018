"""The constants of a motion, rounded once to what doubles need to evaluate it at any time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from flint import acb, arb, ctx

from voronec.elliptic.constants import Constants
from voronec.elliptic.reduction import Reduction, advance, turns
from voronec.elliptic.sums import Sums
from voronec.elliptic.theta_polynomials import (
    Angle,
    Weights,
    angle_of,
    period_of,
    ripples_of,
    smooth,
    weights_of,
    with_series,
)

__all__ = ["Course", "Doubles", "doubles_of"]

BITS = 320
NOTHING = 1e-25
"""A factor of an angle that is none: what rounding leaves of 0."""
LONG = 60.0
"""Radians within half of a half period beyond which a product with a rate is taken exactly."""


@dataclass(frozen=True)
class Course:
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


@dataclass(frozen=True, eq=False)
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
        drawn: phases of the logarithms of the strains, None where there are no logarithms.
        ripples: of each integral, over ``X cos^k 2z``.
        shares: of each integral: the places of its phases and their factors, less those
            that are all in the ripple.
        strains: of each integral: the places of its strains.
        swings: as of the constants.
        gradient: ``(dx/dt)^2 = gradient near far product of |near + c far|`` over ``ratios``.
        ratios: c of the other roots of f.
        origins: of each integral: its value at t = 0 before it is taken off, in radians and
            turns; filled in when they are first needed.
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
    drawn: tuple[Angle | None, ...]
    ripples: tuple[np.ndarray, ...]
    shares: tuple[tuple[tuple[int, float], ...], ...]
    strains: tuple[tuple[int, ...], ...]
    swings: tuple[tuple[float, float], ...]
    gradient: float
    ratios: tuple[complex, ...]
    origins: list[tuple[float, float]] = field(default_factory=list, repr=False)

    def reduction(self, latest: float) -> Reduction:
        """Of times up to ``latest`` in absolute value."""
        with ctx.workprec(BITS):
            return Reduction.of(self.constants.half, self.constants.turn, latest)

    def course(self, number: int, reduction: Reduction, latest: float) -> Course:
        """The steady part of an integral."""
        with ctx.workprec(BITS):
            constants = self.constants
            half, mean = constants.half, constants.rates[number]
            first, second = 0.0, 0.0
            whole: tuple[float, ...] = ()
            reach = latest + abs(float(constants.turn.mid()))
            if half is not None and constants.advances is not None:
                gained = constants.advances[number] / 2
                mean, reach = gained / half, float(half.mid()) / 2
                first, second = advance(gained, reduction)
                whole = turns(gained, reduction)
            spin = mean / (2 * arb.pi())
            high = float(spin.mid())
            return Course(
                float(mean.mid()), (high, float((spin - arb(high)).mid())),
                abs(float(mean.mid())) * reach > LONG, first, second, whole,
            )  # fmt: skip


_known: WeakKeyDictionary[Any, Doubles] = WeakKeyDictionary()


def doubles_of(solution: Any) -> Doubles:
    """The doubles of a solution, prepared when they are first asked for."""
    try:
        return _known[solution]
    except KeyError:
        pass
    found = prepare_doubles(solution.constants(BITS))
    _known[solution] = found
    return found


def prepare_doubles(constants: Constants) -> Doubles:
    """The doubles of constants with at least ``BITS`` bits."""
    with ctx.workprec(BITS + 64):
        constants, odd = _recount(constants)
        period = period_of(constants)
        drawn: list[Angle | None] = []
        for strain in constants.strains:
            turning = any(not value.is_zero() for value in strain.logs)
            alpha = strain.place.imag
            sign = 1 if alpha.mid() > 0 or alpha.is_zero() else -1
            drawn.append(angle_of(constants, strain, alpha, sign) if turning else None)
        angles = tuple(angle_of(constants, p, p.alpha, p.sign) for p in constants.phases)
        gradient, ratios = _speed(constants)
        easy = smooth(angles) if constants.kind == "trigonometric" else (False,) * len(angles)
        rippled = [with_series(a) if e else a for a, e in zip(angles, easy, strict=True)]
        count = len(constants.rates)
        return Doubles(
            constants=constants, odd=odd, scale=float(constants.scale.mid()),
            half=math.inf if period is None else float(period.mid()) / 2,
            base=float(constants.base.mid()), other=float(constants.other.mid()),
            span=float((constants.other - constants.base).mid()),
            weights=weights_of(constants),
            angles=angles, drawn=tuple(drawn), ripples=ripples_of(constants, rippled),
            shares=tuple(_shares(constants, easy, number) for number in range(count)),
            strains=tuple(_strains(constants, number) for number in range(count)),
            swings=tuple((float(p.mid()), float(q.mid())) for p, q in constants.swings),
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
    """Of an integral: the phases that are not all in its ripple, with their factors."""
    found = [(place, float(one.shares[number])) for place, one in enumerate(constants.phases)]
    return tuple(
        (place, share) for place, share in found if abs(share) > NOTHING and not easy[place]
    )


def _strains(constants: Constants, number: int) -> tuple[int, ...]:
    return tuple(
        place
        for place, one in enumerate(constants.strains)
        if not (one.logs[number].is_zero() and one.zetas[number].is_zero())
    )

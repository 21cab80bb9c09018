"""A motion at one time, as rigorous balls."""

from __future__ import annotations

from dataclasses import dataclass

from flint import acb, arb

from voronec.elliptic.constants import Constants, Phase, Strain
from voronec.elliptic.sums import Sums, phase

__all__ = ["Moment", "moment_of", "nearest", "reduce_time", "strain_gain"]


@dataclass(frozen=True)
class Moment:
    """What a motion is at one time.

    Attributes:
        x: the variable.
        rate: its rate.
        near: share of the base in x: ``x = near base + far other``.
        far: share of the other end.
        expressions: one per integral, with its value at t = 0 not yet taken off.
    """

    x: arb
    rate: arb
    near: arb
    far: arb
    expressions: tuple[arb, ...]


def moment_of(constants: Constants, t: arb) -> Moment:
    """The motion at the time ``t``.

    Raises:
        Unresolved: the balls are too wide, or the moment is that of a pole.
    """
    if constants.kind == "rest":
        values = tuple(rate * t for rate in constants.rates)
        return Moment(constants.base, arb(0), arb(1), arb(0), values)
    sums = Sums(constants.kind, constants.nome, constants.partner)
    z, _ = reduce_time(constants, t, 0)
    s, c = sums.s(z), sums.c(z)
    near, far = constants.mean * c * c, s * s
    whole = near + far
    span = constants.other - constants.base
    turned = sums.slope(z) * c - s * sums.fall(z)
    rate = 2 * span * constants.mean * s * c * turned * constants.scale / (whole * whole)
    # Not the mean itself, so that the ball of x is not wider than that of the nearer end.
    x = constants.base + span * far / whole
    return Moment(x, rate, near / whole, far / whole, _expressions(constants, sums, t, x, rate))


def reduce_time(constants: Constants, t: arb, side: int) -> tuple[arb, int]:
    """z counted from the nearest turning point of that side, and the whole periods before."""
    time = t - constants.turn
    if constants.half is None:
        return constants.scale * time, 0
    time -= side * constants.half
    count = nearest(time / (2 * constants.half))
    return constants.scale * (time - 2 * count * constants.half), count


def nearest(value: arb) -> int:
    """The integer nearest to the middle of a ball."""
    return int((value.mid() + arb(0.5)).floor().mid().unique_fmpz() or 0)


def _expressions(constants: Constants, sums: Sums, t: arb, x: arb, rate: arb) -> tuple[arb, ...]:
    time = t - constants.turn
    values = [each * time for each in constants.rates]
    for one in constants.phases:
        turned = _growth(constants, sums, one, t)
        values = [value + share * turned for value, share in zip(values, one.shares, strict=True)]
    for strain in constants.strains:
        added = _strain_parts(constants, sums, strain, t)
        values = [value + more for value, more in zip(values, added, strict=True)]
    for place, (p, q) in enumerate(constants.swings):
        if not (p.is_zero() and q.is_zero()):
            values[place] += (p + q * x) * rate
    return tuple(values)


def _growth(constants: Constants, sums: Sums, one: Phase, t: arb) -> arb:
    z, count = reduce_time(constants, t, one.side)
    angle = phase(sums, z, one.alpha, one.sign)
    return angle if one.gain is None else angle + count * one.gain


def _strain_parts(constants: Constants, sums: Sums, strain: Strain, t: arb) -> list[arb]:
    z, count = reduce_time(constants, t, strain.side)
    a = strain.place
    images: tuple[acb, ...] = (z - a, z + a)
    if constants.kind == "exponential":
        sums, images = Sums("hyperbolic", arb(0), "one"), images[:1]
    zeta = acb(0)
    for image in images:
        zeta += sums.zeta(image)
    log = acb(0)
    if any(not factor.is_zero() for factor in strain.logs):
        log = _logarithm(constants, sums, a, images)
    values = [
        (factor * log + other * zeta).real
        for factor, other in zip(strain.logs, strain.zetas, strict=True)
    ]
    if count and strain.gains:
        values = [value + count * gain for value, gain in zip(values, strain.gains, strict=True)]
    return values


def _logarithm(constants: Constants, sums: Sums, a: acb, images: tuple[acb, ...]) -> acb:
    """``log s(z - a) - log s(z + a)``, continuous along real z, by the phases of both."""
    sign = 1 if a.imag > 0 else -1
    size, angle = arb(0), arb(0)
    for place, image in enumerate(images):
        size += (-1) ** place * abs(sums.s(image)).log()
        whole, count = image.real, 0
        gain = arb(0)
        if constants.half is not None:
            period = 2 * constants.half * constants.scale
            count = nearest(whole / period)
            whole -= count * period
            gain = strain_gain(sums, a.imag, sign)
        angle += phase(sums, whole, a.imag, sign) + count * gain
    return acb(size, angle)


def strain_gain(sums: Sums, alpha: arb, sign: int) -> arb:
    """What the phase of such a pole grows by in one period."""
    if sums.kind == "trigonometric":
        return sign * arb.pi()
    return sign * arb.pi() - (4 if sums.partner == "theta2" else 2) * alpha

"""Theta functions as rigorous balls, real or complex, and a motion at one time made of them."""

from __future__ import annotations

from dataclasses import dataclass

from flint import acb, arb

from voronec.elliptic.constants import Constants, LogTerm, ThetaPhase
from voronec.elliptic.roots import OpenDecision, power


@dataclass(frozen=True)
class Sums:
    """The functions s, its derivative and c of ``voronec.elliptic.constants``.

    Theta functions, of an imaginary argument where the kind is hyperbolic; what they tend to where
    the nome is 0.

    Attributes:
        kind: as there.
        nome: as there, the square of the nome of the theta functions.
        partner: as there.
    """

    kind: str
    nome: arb
    partner: str

    def s(self, z: arb | acb) -> arb | acb:
        """The odd sum."""
        if self.kind == "rational":
            return z
        if self.kind == "exponential":
            return (z / 2).exp()
        return self._theta(1, z, 0)

    def slope(self, z: arb | acb) -> arb | acb:
        """The derivative of s."""
        if self.kind == "rational":
            return z * 0 + 1
        if self.kind == "exponential":
            return (z / 2).exp() / 2
        return self._theta(1, z, 1)

    def zeta(self, z: arb | acb) -> arb | acb:
        """``s'/s``."""
        return self.slope(z) / self.s(z)

    def bend(self, z: arb | acb) -> arb | acb:
        """The derivative of ``s'/s``."""
        if self.kind == "rational":
            return -1 / (z * z)
        return self._theta(1, z, 2) / self.s(z) - power(self.zeta(z), 2)

    def c(self, z: arb | acb) -> arb | acb:
        """The partner."""
        if self.partner == "one":
            return z * 0 + 1
        if self.partner == "inverse":
            return (-z / 2).exp()
        return self._theta(4 if self.partner == "theta4" else 2, z, 0)

    def fall(self, z: arb | acb) -> arb | acb:
        """The derivative of c."""
        if self.partner == "one":
            return z * 0
        if self.partner == "inverse":
            return -(-z / 2).exp() / 2
        return self._theta(4 if self.partner == "theta4" else 2, z, 1)

    def _theta(self, number: int, z: arb | acb, order: int) -> arb | acb:
        """A derivative of theta1 or theta2 over ``2 q^(1/4)``, or of theta4; over i for sinh."""
        turn = acb(1) if self.kind == "trigonometric" else acb(0, 1)
        place = turn * z
        if self.nome.is_zero():
            value = _limit(number, place, order)
        else:
            # q^2 is the nome, so that q is imaginary where that is negative: tau = 1/2 + ...
            decay = abs(self.nome).log() / (2 * arb.pi())
            tau = acb(arb(0) if self.nome > 0 else arb(0.5), -decay)
            value = acb.modular_theta(place / arb.pi(), tau, order)[number - 1] / arb.pi() ** order
            if number != 4:
                value /= 2 * (acb(0, 1) * arb.pi() * tau / 4).exp()
        value *= turn ** (order - 1 if number == 1 else order)
        return value if isinstance(z, acb) else value.real


def _limit(number: int, z: acb, order: int) -> acb:
    """What :meth:`Sums._theta` has at nome 0: a derivative of sin, cos or 1."""
    if number == 4:
        return acb(0 if order else 1)
    sine, cosine = z.sin(), z.cos()
    return (sine, cosine, -sine, -cosine)[(order + (number == 2)) % 4]


def phase(sums: Sums, z: arb, alpha: arb, sign: int) -> arb:
    """``arg s(z - i alpha)`` continued from ``-sign pi/2`` at z = 0, within half a period.

    Raises:
        OpenDecision: the balls are too wide.
    """
    if alpha.is_zero():
        if z.is_zero() or z > 0:
            return arb(0)
        if z < 0:
            return -sign * arb.pi()
        raise OpenDecision("the moment is that of a passage through a pole, or very near it")
    value = sums.s(acb(z, -alpha))
    if sums.kind == "trigonometric":
        turned = value * acb(0, sign) * acb(0, -sign * z).exp()
        part = _arctangent(turned.imag, turned.real)
        return sign * (z - arb.pi() / 2) + part
    return sign * (_arctangent(value.real, -sign * value.imag) - arb.pi() / 2)


def _arctangent(across: arb, along: arb) -> arb:
    """The angle in (-pi/2, pi/2) of a direction with ``along > 0``."""
    if not along > 0:
        raise OpenDecision("the angle of a pole needs more bits")
    return (across / along).atan()


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
        OpenDecision: the balls are too wide, or the moment is that of a pole.
    """
    if constants.kind == "rest":
        values = tuple(rate * t for rate in constants.rates)
        return Moment(constants.base, arb(0), arb(1), arb(0), values)
    sums = Sums(constants.kind, constants.nome, constants.partner)
    z, _ = _reduce_time(constants, t, 0)
    s, c = sums.s(z), sums.c(z)
    near, far = constants.mean * c * c, s * s
    whole = near + far
    span = constants.other - constants.base
    turned = sums.slope(z) * c - s * sums.fall(z)
    rate = 2 * span * constants.mean * s * c * turned * constants.scale / (whole * whole)
    # Not the mean itself, so that the ball of x is not wider than that of the nearer end.
    x = constants.base + span * far / whole
    return Moment(x, rate, near / whole, far / whole, _expressions(constants, sums, t, x, rate))


def _reduce_time(constants: Constants, t: arb, side: int) -> tuple[arb, int]:
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
    for log_term in constants.log_terms:
        added = _log_term_parts(constants, sums, log_term, t)
        values = [value + more for value, more in zip(values, added, strict=True)]
    for place, (p, q) in enumerate(constants.bounded_terms):
        if not (p.is_zero() and q.is_zero()):
            values[place] += (p + q * x) * rate
    return tuple(values)


def _growth(constants: Constants, sums: Sums, one: ThetaPhase, t: arb) -> arb:
    z, count = _reduce_time(constants, t, one.side)
    angle = phase(sums, z, one.alpha, one.sign)
    return angle if one.gain is None else angle + count * one.gain


def _log_term_parts(constants: Constants, sums: Sums, log_term: LogTerm, t: arb) -> list[arb]:
    z, count = _reduce_time(constants, t, log_term.side)
    a = log_term.place
    images: tuple[acb, ...] = (z - a, z + a)
    if constants.kind == "exponential":
        sums, images = Sums("hyperbolic", arb(0), "one"), images[:1]
    zeta = acb(0)
    for image in images:
        zeta += sums.zeta(image)
    log = acb(0)
    if any(not factor.is_zero() for factor in log_term.logs):
        log = _logarithm(constants, sums, a, images)
    values = [
        (factor * log + other * zeta).real
        for factor, other in zip(log_term.logs, log_term.zetas, strict=True)
    ]
    if count and log_term.gains:
        values = [value + count * gain for value, gain in zip(values, log_term.gains, strict=True)]
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
            gain = _log_term_gain(sums, a.imag, sign)
        angle += phase(sums, whole, a.imag, sign) + count * gain
    return acb(size, angle)


def _log_term_gain(sums: Sums, alpha: arb, sign: int) -> arb:
    """What the phase of such a pole grows by in one period."""
    if sums.kind == "trigonometric":
        return sign * arb.pi()
    return sign * arb.pi() - (4 if sums.partner == "theta2" else 2) * alpha

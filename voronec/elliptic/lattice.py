r"""Periods, nome and turning points: the inversion of x without its integrals.

With ``A = f'(xr)/4`` and ``B = f''(xr)/24`` at a simple end xr, ``x = xr + A/(wp(t) - B)``, with t
counted from a turning point there [Theory, eq. (24)]; a root x_i belongs to
``e_i = B + A/(x_i - xr)``, infinity to B.
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import acb, arb, arb_poly

from voronec.elliptic.constants import Numbers
from voronec.elliptic.roots import Ends, OpenDecision, coefficients
from voronec.elliptic.theta_balls import Sums

ALMOST = 1 - 2.0**-10
"""Choices between equals must not depend on rounding, hence on the number of bits: a start in the
middle, a square lattice, a pole half way between the ends."""


@dataclass(frozen=True)
class Place:
    """A simple end of the interval, from which wp maps the x line.

    Attributes:
        x: the end.
        slope: A there.
        bend: B there.
    """

    x: arb
    slope: arb
    bend: arb

    def wp(self, x: arb | acb | None) -> arb | acb:
        """The value of wp where the variable is ``x``; None stands for infinity."""
        return self.bend if x is None else self.bend + self.slope / (x - self.x)


@dataclass(frozen=True)
class Lattice:
    """The motion of x: its periods and the sums that give it.

    Attributes:
        sums: the sums.
        base: the end from which z is counted.
        far: the other end, None where it is a multiple root.
        other: x at the other end.
        es: e1, e2, e3 with e1 that of the other end; e2 >= e3 real, or complex conjugates.
        period: None if infinite.
        vertical: the vertical period (of which a rhombic lattice has the half as the imaginary
            part of its complex period); None if infinite.
        rhombic: whether e2 and e3 are complex.
        scale: of z.
        mean: K.
    """

    sums: Sums
    base: Place
    far: Place | None
    other: arb
    es: tuple[arb | acb, arb | acb, arb | acb]
    period: arb | None
    vertical: arb | None
    rhombic: bool
    scale: arb
    mean: arb

    @property
    def half(self) -> arb | None:
        """Half of the period."""
        return None if self.period is None else self.period / 2

    def side(self, number: int) -> Place:
        """The end of side 0 or 1."""
        return self.base if number == 0 or self.far is None else self.far


def lattice_of(numbers: Numbers, ends: Ends) -> Lattice:
    """The lattice of a motion with at least one simple end.

    Raises:
        OpenDecision: more bits are needed.
    """
    coefficient = coefficients(numbers)
    one, two = ends.lower, ends.upper
    if one.times > 1 or (two.times == 1 and _nearer_upper(numbers, ends)):
        one, two = two, one
    base = _place(coefficient, one.value)
    far = _place(coefficient, two.value) if two.times == 1 else None
    others: list[arb | acb] = [two.value] * (two.times - 1)
    for root in ends.roots:
        if root is not one and root is not two:
            others += [root.value] * root.times
    values = [base.wp(value) for value in others]
    values += [base.bend] * (2 - len(values))
    second, third = values
    if isinstance(second, arb) and isinstance(third, arb) and third.mid() > second.mid():
        second, third = third, second
    es = (base.wp(two.value), second, third)
    if two.times == 3:
        sums, period, vertical, scale = Sums("rational", arb(0), "one"), None, None, arb(1)
    elif two.times == 2:
        scale = _positive(es[0] - es[2]).sqrt()
        sums, period, vertical = Sums("hyperbolic", arb(0), "one"), None, arb.pi() / scale
    elif not others or (len(others) == 2 and others[0] is others[1]):
        scale = _positive(es[0] - es[2]).sqrt()
        sums, period, vertical = Sums("trigonometric", arb(0), "theta2"), arb.pi() / scale, None
    else:
        sums, period, vertical, scale = _representation(es)
    first = scale * sums.slope(arb(0)) / sums.c(arb(0))
    mean = first * first * (two.value - base.x) / base.slope
    rhombic = isinstance(es[1], acb)
    return Lattice(sums, base, far, two.value, es, period, vertical, rhombic, scale, mean)


def turn_of(numbers: Numbers, ends: Ends, lattice: Lattice) -> arb:
    """The time of the turning point at the base, seen from t = 0.

    By ``wp(t) = B + A/d`` with the distance d from the base, which is ``rate^2/g`` for
    ``f = (x - xr) g``: its relative accuracy does not suffer near the turning point.
    """
    if ends.start is not None:
        return arb(0)
    base = lattice.base
    cofactor = _deflate(coefficients(numbers), base.x)
    distance = numbers.rate * numbers.rate / cofactor(numbers.place)
    time = time_from(lattice, distance)
    outwards = numbers.rate if distance > 0 else -numbers.rate
    if outwards > 0:
        return -time
    if outwards < 0:
        return time
    raise OpenDecision(f"the rate {numbers.rate.str(5)} may be 0")


def time_from(lattice: Lattice, distance: arb) -> arb:
    """The time from the turning point at the base until x is so far from it, signed as x moves:
    ``R_F(wp - e1, wp - e2, wp - e3)`` with ``wp = B + A/distance``.  [Carlson1995]"""
    base, sign = lattice.base, 1 if distance > 0 else -1
    x, y, z = (sign * (base.slope + distance * (base.bend - e)) for e in lattice.es)
    return _positive(abs(distance)).sqrt() * carlson(x, y, z)


def carlson(x: arb | acb, y: arb | acb, z: arb | acb) -> arb:
    """The real value of R_F(x, y, z), for real arguments or a complex pair among them."""
    return acb(x).elliptic_rf(acb(x), acb(y), acb(z)).real


def _representation(es: tuple[arb | acb, ...]) -> tuple[Sums, arb, arb, arb]:
    """Sums, period, vertical period and scale, in the representation with the smaller nome."""
    e1, e2, e3 = es
    rhombic = isinstance(e2, acb)
    period = _cycle(e1 - e2, e1 - e3)
    vertical = _cycle(e2 - e1, e3 - e1) if rhombic else _cycle(e2 - e3, e1 - e3)
    ratio = vertical / period
    if not ratio > 0:
        raise OpenDecision("two roots of f may be equal")
    hyperbolic = bool(ratio.mid() < ALMOST)
    decay = 1 / ratio if hyperbolic else ratio
    power = (-arb.pi() * decay).exp()
    nome = -power if rhombic else power * power
    partner = "theta4" if hyperbolic and not rhombic else "theta2"
    sums = Sums("hyperbolic" if hyperbolic else "trigonometric", nome, partner)
    return sums, period, vertical, arb.pi() / (vertical if hyperbolic else period)


def _cycle(x: arb | acb, y: arb | acb) -> arb:
    """``2 R_F(0, x, y)``, of positive numbers or a complex pair, by the mean of Gauss."""
    if isinstance(x, acb):
        root = x.sqrt()
        return arb.pi() / root.real.agm(abs(root))
    return arb.pi() / _positive(x).sqrt().agm(_positive(y).sqrt())


def _positive(value: arb) -> arb:
    if not value > 0:
        raise OpenDecision("two roots of f may be equal")
    return value


def _nearer_upper(numbers: Numbers, ends: Ends) -> bool:
    if ends.start is not None:
        return ends.start is ends.upper
    below = numbers.place.mid() - ends.lower.value.mid()
    return bool(ends.upper.value.mid() - numbers.place.mid() < ALMOST * below)


def _place(coefficient: list[arb], x: arb) -> Place:
    first = arb_poly(coefficient).derivative()
    return Place(x, first(x) / 4, first.derivative()(x) / 24)


def _deflate(coefficient: list[arb], x: arb) -> arb_poly:
    """The quotient of the polynomial by the factor of its root ``x``."""
    quotient: list[arb] = []
    carry = arb(0)
    for value in reversed(coefficient):
        carry = carry * x + value
        quotient.append(carry)
    return arb_poly(quotient[-2::-1])

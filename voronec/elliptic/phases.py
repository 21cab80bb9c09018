"""The poles of the integrands as angles, logarithms and zeta functions of time.

Each is a closed term whose derivative has the poles of a part of the integrand; what is left
is a constant, found by comparing both at a turning point.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from flint import acb, arb

from voronec.elliptic.constants import Phase, Strain
from voronec.elliptic.lattice import ALMOST, Lattice, Place, carlson
from voronec.elliptic.numbers import Numbers, Pole
from voronec.elliptic.roots import Unresolved, power, show_ball, value_at
from voronec.errors import DefinitionError

__all__ = [
    "Part",
    "Spot",
    "branch_spot",
    "cubic_part",
    "gain_of",
    "left_over",
    "pole_part",
    "polynomial_part",
    "spot_of",
    "strain_at",
]


@dataclass(frozen=True)
class Spot:
    """A place on the x line (or infinity) as a moment.

    Attributes:
        side: 0 or 1, the turning point from which it is counted.
        place: in z.
        imaginary: whether it is purely imaginary, above 0; f is negative at the place.
        sign: of dx/dt there, where it is real.
        velocity: dx/dt there, of a complex place.
    """

    side: int
    place: acb
    imaginary: bool
    sign: int = 0
    velocity: acb | None = None


def spot_of(lattice: Lattice, x: arb | acb | None) -> Spot:
    """The moment of a place outside the interval; None stands for infinity.

    Raises:
        DefinitionError: the place is where x moves.
        Unresolved: more bits are needed.
    """
    if isinstance(x, acb):
        return _complex(lattice, x)
    e1, e2, e3 = lattice.es
    p = lattice.base.wp(x)
    if p > e1:
        raise DefinitionError(f"x passes the pole {show_ball(x)}, where the integral is infinite")
    if lattice.rhombic:
        if not p < e1:
            raise Unresolved(f"the pole {_name(x)} may be an end of the motion")
        times = [_height(lattice, lattice.base, x), _height(lattice, lattice.far, x)]
        side = 1 if times[1].mid() < ALMOST * times[0].mid() else 0
        return Spot(side, acb(0, lattice.scale * times[side]), True)
    if p < e3:
        return Spot(0, acb(0, lattice.scale * _height(lattice, lattice.base, x)), True)
    if p > e2 and lattice.far is not None:
        return Spot(1, acb(0, lattice.scale * _height(lattice, lattice.far, x)), True)
    if not (p > e3 and p < e2) or lattice.vertical is None:
        raise Unresolved(f"the pole {_name(x)} may be a root of f")
    # wp(t + half of the vertical period) = e3 + (e3 - e1)(e3 - e2)/(wp(t) - e3)
    q = e3 + (e3 - e1) * (e3 - e2) / (p - e3)
    time = carlson(q - e1, q - e2, q - e3)
    sign = -1 if lattice.base.slope > 0 else 1
    return Spot(0, acb(time, lattice.vertical / 2) * lattice.scale, False, sign)


def branch_spot(lattice: Lattice) -> Spot:
    """The moment of infinity where that is a root of f: half a vertical period from an end."""
    _, e2, e3 = lattice.es
    at_third, at_second = (lattice.base.bend.overlaps(e) for e in (e3, e2))
    if (at_third and at_second) or lattice.vertical is None:
        raise Unresolved("two roots of f may be equal")
    height = lattice.scale * lattice.vertical / 2
    return Spot(0 if at_third else 1, acb(0, height), True)


def gain_of(lattice: Lattice, alpha: arb, sign: int) -> arb | None:
    """What the phase of a pole grows by in one period; None if there is no period."""
    if lattice.period is None:
        return None
    if lattice.sums.kind == "trigonometric":
        return sign * arb.pi()
    return sign * arb.pi() - (4 if lattice.rhombic else 2) * alpha


def _height(lattice: Lattice, end: Place | None, x: arb | None) -> arb:
    """The imaginary part of the first moment after that end at which the variable is ``x``."""
    if end is None:
        raise Unresolved(f"the pole {_name(x)} may be an end of the motion")
    p = end.wp(x)
    first, second, third = (e - p for e in lattice.es)
    height = carlson(first, second, third)
    if not height > 0:
        raise Unresolved(f"the pole {_name(x)} may be a root of f")
    return height


def _complex(lattice: Lattice, x: acb) -> Spot:
    """The moment of a place that is not real, near the origin of the lattice."""
    base = lattice.base
    p = base.wp(x)
    across = [acb(p - e) for e in lattice.es]
    time = across[0].elliptic_rf(*across)
    # dwp/dt = -2 product of the roots, the derivative of the inverse of R_F
    product = across[0].sqrt() * across[1].sqrt() * across[2].sqrt()
    velocity = 2 * base.slope * product / power(p - base.bend, 2)
    if lattice.vertical is not None:
        rise = lattice.vertical / 2 if lattice.rhombic else lattice.vertical
        shift = lattice.half if lattice.rhombic else arb(0)
        time -= _nearest(time.imag / rise) * acb(shift, rise)
    if lattice.period is not None:
        time -= _nearest(time.real / lattice.period) * lattice.period
    return Spot(0, time * lattice.scale, False, 0, velocity)


def _nearest(value: arb) -> int:
    return int((value.mid() + arb(0.5)).floor().unique_fmpz() or 0)


def _name(x: arb | None) -> str:
    return "at infinity" if x is None else show_ball(x)


@dataclass(frozen=True)
class Part:
    """A part of all integrals: its closed terms, and its linear rate in each integral."""

    phases: tuple[Phase, ...]
    strains: tuple[Strain, ...]
    rates: tuple[arb, ...]


def pole_part(numbers: Numbers, lattice: Lattice, place: int) -> Part | None:
    """The part of one pole; None where it adds nothing.

    Raises:
        DefinitionError: the weight contradicts f, or the pole is where x moves.
        Unresolved: more bits are needed.
    """
    shares = tuple(integral.shares[place] for integral in numbers.integrals)
    if all(_nothing(share) for share in shares):
        return None
    part = _part_of(numbers, lattice, numbers.poles[place], shares)
    if part is None:
        return None
    phases = tuple(replace(phase, pole=place) for phase in part.phases)
    return Part(phases, tuple(replace(one, pole=place) for one in part.strains), part.rates)


def _part_of(
    numbers: Numbers, lattice: Lattice, pole: Pole, shares: tuple[Any, ...]
) -> Part | None:
    if pole.weight is not None:
        return _phase_part(numbers, lattice, pole, pole.weight, shares)
    spot = spot_of(lattice, pole.place)
    value = value_at(numbers, pole.place)
    if isinstance(pole.place, acb):
        return _strain_part(lattice, spot, list(map(acb, shares)), pole.place, spot.velocity)
    shares = tuple(share.real if isinstance(share, acb) else share for share in shares)
    if spot.imaginary:
        weight = _positive(-value, pole).sqrt() / 2
        return _angle(lattice, spot, pole.place, weight, tuple(share / weight for share in shares))
    velocity = spot.sign * _positive(value, pole).sqrt()
    return _strain_part(lattice, spot, [acb(share) for share in shares], pole.place, acb(velocity))


def _phase_part(
    numbers: Numbers, lattice: Lattice, pole: Pole, weight: arb, shares: tuple[Any, ...]
) -> Part | None:
    if not value_at(numbers, pole.place).overlaps(-4 * weight * weight):
        raise DefinitionError(
            f"f = {show_ball(value_at(numbers, pole.place))} at the pole {show_ball(pole.place)}, "
            f"but its weight {show_ball(weight)} says -4 w^2 = {show_ball(-4 * weight * weight)}"
        )
    if not weight.is_zero():
        return _angle(lattice, spot_of(lattice, pole.place), pole.place, weight, shares)
    ends = (lattice.base.x,) if lattice.far is None else (lattice.base.x, lattice.far.x)
    near = [side for side, end in enumerate(ends) if end.overlaps(pole.place)]
    if len(near) > 1:
        raise Unresolved("the ends of the motion may be equal")
    if not near:
        return None
    # The trace passes through the pole at every turn at that end, and is a great circle there.
    alpha = arb(0)
    gain = gain_of(lattice, alpha, 1)
    return Part((Phase(near[0], alpha, 1, gain, shares),), (), tuple(arb(0) for _ in shares))


def _angle(lattice: Lattice, spot: Spot, place: arb, weight: arb, shares: tuple[Any, ...]) -> Part:
    """The part of ``weight/(x - place)`` with ``f(place) = -4 weight^2``."""
    if not spot.imaginary:
        raise DefinitionError(
            f"f is positive at the pole {show_ball(place)}, which therefore has no weight"
        )
    end = lattice.side(spot.side)
    lean = weight * end.slope
    if not (lean > 0 or lean < 0):
        raise Unresolved(f"the weight {weight.str(5)} of the pole {show_ball(place)} may be 0")
    sign = 1 if lean > 0 else -1
    alpha = sign * spot.place.imag
    zeta = lattice.sums.zeta(acb(0, alpha)).imag
    rate = weight / (end.x - place) + lattice.scale * zeta
    phase = Phase(spot.side, alpha, sign, gain_of(lattice, alpha, sign), shares)
    return Part((phase,), (), tuple(share * rate for share in shares))


def _strain_part(
    lattice: Lattice, spot: Spot, shares: list[acb], place: arb | acb, velocity: acb
) -> Part:
    """The part of ``Re share/(x - place)``, x having that velocity where it is ``place``."""
    end = lattice.side(spot.side)
    logs = tuple(share / velocity for share in shares)
    zetas = tuple(acb(0) for _ in shares)
    strain = strain_at(lattice, spot, logs, zetas)
    values = [(share / (end.x - place)).real for share in shares]
    return Part((), (strain,), left_over(lattice, strain, values))


def polynomial_part(numbers: Numbers, lattice: Lattice, coefficient: list[arb]) -> Part | None:
    """The part of ``linear x + square x^2``, where f has degree 4; None where both are 0.

    ``x = -1/(k t) - b + ...`` near its pole, with ``k^2 = f4`` and ``b = f3/(4 f4)``.
    """
    linear = [integral.linear for integral in numbers.integrals]
    square = [integral.square for integral in numbers.integrals]
    if all(_nothing(value) for value in (*linear, *square)):
        return None
    spot = spot_of(lattice, None)
    end = lattice.side(spot.side)
    lead = coefficient[4]
    simple = [
        one - two * coefficient[3] / (2 * lead) for one, two in zip(linear, square, strict=True)
    ]
    values = [one * end.x + two * end.x * end.x for one, two in zip(linear, square, strict=True)]
    zetas = tuple(acb(-lattice.scale * two / lead) for two in square)
    none = tuple(acb(0) for _ in square)
    side = 1 if end.slope > 0 else -1
    if not spot.imaginary:
        logs = tuple(acb(side * one / lead.sqrt()) for one in simple)
        strain = strain_at(lattice, spot, logs, zetas)
        return Part((), (strain,), left_over(lattice, strain, values))
    alpha = spot.place.imag
    shares = tuple(-2 * side * one / (-lead).sqrt() for one in simple)
    turned = lattice.scale * lattice.sums.zeta(acb(0, alpha)).imag
    values = [value + share * turned for value, share in zip(values, shares, strict=True)]
    phases = (Phase(spot.side, alpha, 1, gain_of(lattice, alpha, 1), shares),)
    if all(_nothing(value) for value in square):
        return Part(phases, (), tuple(values))
    strain = strain_at(lattice, spot, none, zetas)
    return Part(phases, (strain,), left_over(lattice, strain, values))


def cubic_part(numbers: Numbers, lattice: Lattice, linear: list[arb], lead: arb) -> Part | None:
    """The part of ``linear x`` where f has degree 3: ``x = 4/(f3 t^2) + ...`` near its pole."""
    if all(_nothing(value) for value in linear):
        return None
    spot = branch_spot(lattice)
    end: Place = lattice.side(spot.side)
    zetas = tuple(acb(-2 * lattice.scale * one / lead) for one in linear)
    strain = strain_at(lattice, spot, tuple(acb(0) for _ in linear), zetas)
    return Part((), (strain,), left_over(lattice, strain, [one * end.x for one in linear]))


def strain_at(
    lattice: Lattice, spot: Spot, logs: tuple[acb, ...], zetas: tuple[acb, ...]
) -> Strain:
    """The strain with these factors, and what it gains in a period."""
    gains = None
    if lattice.period is not None:
        sums, alpha = lattice.sums, spot.place.imag
        sign = 1 if alpha > 0 else -1
        turned = gain_of(lattice, alpha, sign) or arb(0)
        # s(z + 2 H) = -C exp(m z) s(z)
        wave = 0 if sums.kind == "trigonometric" else 4 if lattice.rhombic else 2
        change = acb(-2 * wave * spot.place.real, 2 * turned)
        gains = tuple(
            (log * change + 2 * wave * zeta).real for log, zeta in zip(logs, zetas, strict=True)
        )
    return Strain(spot.side, spot.place, logs, zetas, gains)


def left_over(lattice: Lattice, strain: Strain, values: list[arb]) -> tuple[arb, ...]:
    """The values of a part of the integrands at the turning point, less the strain's rates."""
    zeta, bend = lattice.sums.zeta(strain.place), lattice.sums.bend(strain.place)
    return tuple(
        value + 2 * lattice.scale * (log * zeta - factor * bend).real
        for value, log, factor in zip(values, strain.logs, strain.zetas, strict=True)
    )


def _nothing(share: Any) -> bool:
    return share == 0 if isinstance(share, int) else bool(share.is_zero())


def _positive(value: arb, pole: Pole) -> arb:
    if not value > 0:
        raise Unresolved(f"the pole {show_ball(pole.place)} may be a root of f")
    return value

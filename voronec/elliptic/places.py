"""Places on the x line as moments of complex time, counted from a turning point near them."""

from __future__ import annotations

from dataclasses import dataclass

from flint import acb, arb

from voronec.elliptic.lattice import ALMOST, Lattice, Place, carlson
from voronec.elliptic.roots import Unresolved, power, shown
from voronec.errors import DefinitionError

__all__ = ["Spot", "branch_spot", "gain_of", "spot_of"]


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
        raise DefinitionError(f"x passes the pole {shown(x)}, where the integral is infinite")
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
    return "at infinity" if x is None else shown(x)

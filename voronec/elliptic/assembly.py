"""The constants of a motion at one working precision.

The poles of the integrands become angles, logarithms and zeta functions of time: each is a closed
term whose derivative has the poles of a part of the integrand; what is left is a constant, found by
comparing both at a turning point.  Between two double roots of f the motion is elementary, without
a turning point: ``x = (base exp(-z) + other exp(z))/(2 cosh z)``, an affine function of tanh z.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from flint import acb, arb

from voronec.elliptic.constants import Constants, Integral, LogTerm, Numbers, Pole, ThetaPhase
from voronec.elliptic.lattice import ALMOST, Lattice, Place, carlson, lattice_of, turn_of
from voronec.elliptic.roots import (
    Ends,
    OpenDecision,
    coefficients,
    interval,
    power,
    show_ball,
    value_at,
)
from voronec.elliptic.theta_balls import moment_of
from voronec.errors import DefinitionError


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
        OpenDecision: more bits are needed.
    """
    if isinstance(x, acb):
        return _complex(lattice, x)
    e1, e2, e3 = lattice.es
    p = lattice.base.wp(x)
    if p > e1:
        raise DefinitionError(f"x passes the pole {show_ball(x)}, where the integral is infinite")
    if lattice.rhombic:
        if not p < e1:
            raise OpenDecision(f"the pole {_name(x)} may be an end of the motion")
        times = [_height(lattice, lattice.base, x), _height(lattice, lattice.far, x)]
        side = 1 if times[1].mid() < ALMOST * times[0].mid() else 0
        return Spot(side, acb(0, lattice.scale * times[side]), True)
    if p < e3:
        return Spot(0, acb(0, lattice.scale * _height(lattice, lattice.base, x)), True)
    if p > e2 and lattice.far is not None:
        return Spot(1, acb(0, lattice.scale * _height(lattice, lattice.far, x)), True)
    if not (p > e3 and p < e2) or lattice.vertical is None:
        raise OpenDecision(f"the pole {_name(x)} may be a root of f")
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
        raise OpenDecision("two roots of f may be equal")
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
        raise OpenDecision(f"the pole {_name(x)} may be an end of the motion")
    p = end.wp(x)
    first, second, third = (e - p for e in lattice.es)
    height = carlson(first, second, third)
    if not height > 0:
        raise OpenDecision(f"the pole {_name(x)} may be a root of f")
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
class IntegralPart:
    """A part of all integrals: its closed terms, and its linear rate in each integral."""

    phases: tuple[ThetaPhase, ...]
    log_terms: tuple[LogTerm, ...]
    rates: tuple[arb, ...]


def pole_part(numbers: Numbers, lattice: Lattice, place: int) -> IntegralPart | None:
    """The part of one pole; None where it adds nothing.

    Raises:
        DefinitionError: the weight contradicts f, or the pole is where x moves.
        OpenDecision: more bits are needed.
    """
    shares = tuple(integral.shares[place] for integral in numbers.integrals)
    if all(_nothing(share) for share in shares):
        return None
    part = _part_of(numbers, lattice, numbers.poles[place], shares)
    if part is None:
        return None
    phases = tuple(replace(phase, pole=place) for phase in part.phases)
    return IntegralPart(phases, tuple(replace(e, pole=place) for e in part.log_terms), part.rates)


def _part_of(
    numbers: Numbers, lattice: Lattice, pole: Pole, shares: tuple[Any, ...]
) -> IntegralPart | None:
    if pole.weight is not None:
        return _phase_part(numbers, lattice, pole, pole.weight, shares)
    spot = spot_of(lattice, pole.place)
    value = value_at(numbers, pole.place)
    if isinstance(pole.place, acb):
        return _log_term_part(lattice, spot, list(map(acb, shares)), pole.place, spot.velocity)
    shares = tuple(share.real if isinstance(share, acb) else share for share in shares)
    if spot.imaginary:
        weight = _positive(-value, pole).sqrt() / 2
        return _angle(lattice, spot, pole.place, weight, tuple(share / weight for share in shares))
    velocity = spot.sign * _positive(value, pole).sqrt()
    return _log_term_part(
        lattice, spot, [acb(share) for share in shares], pole.place, acb(velocity)
    )


def _phase_part(
    numbers: Numbers, lattice: Lattice, pole: Pole, weight: arb, shares: tuple[Any, ...]
) -> IntegralPart | None:
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
        raise OpenDecision("the ends of the motion may be equal")
    if not near:
        return None
    # The trace passes through the pole at every turn at that end, and is a great circle there.
    alpha = arb(0)
    gain = gain_of(lattice, alpha, 1)
    return IntegralPart(
        (ThetaPhase(near[0], alpha, 1, gain, shares),), (), tuple(arb(0) for _ in shares)
    )


def _angle(
    lattice: Lattice, spot: Spot, place: arb, weight: arb, shares: tuple[Any, ...]
) -> IntegralPart:
    """The part of ``weight/(x - place)`` with ``f(place) = -4 weight^2``
    [Theory, eq. (27)]."""
    if not spot.imaginary:
        raise DefinitionError(
            f"f is positive at the pole {show_ball(place)}, which therefore has no weight"
        )
    end = lattice.side(spot.side)
    lean = weight * end.slope
    if not (lean > 0 or lean < 0):
        raise OpenDecision(f"the weight {weight.str(5)} of the pole {show_ball(place)} may be 0")
    sign = 1 if lean > 0 else -1
    alpha = sign * spot.place.imag
    zeta = lattice.sums.zeta(acb(0, alpha)).imag
    rate = weight / (end.x - place) + lattice.scale * zeta
    phase = ThetaPhase(spot.side, alpha, sign, gain_of(lattice, alpha, sign), shares)
    return IntegralPart((phase,), (), tuple(share * rate for share in shares))


def _log_term_part(
    lattice: Lattice, spot: Spot, shares: list[acb], place: arb | acb, velocity: acb
) -> IntegralPart:
    """The part of ``Re share/(x - place)``, x having that velocity where it is ``place``."""
    end = lattice.side(spot.side)
    logs = tuple(share / velocity for share in shares)
    zetas = tuple(acb(0) for _ in shares)
    log_term = log_term_at(lattice, spot, logs, zetas)
    values = [(share / (end.x - place)).real for share in shares]
    return IntegralPart((), (log_term,), surplus(lattice, log_term, values))


def polynomial_part(
    numbers: Numbers, lattice: Lattice, coefficient: list[arb]
) -> IntegralPart | None:
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
        log_term = log_term_at(lattice, spot, logs, zetas)
        return IntegralPart((), (log_term,), surplus(lattice, log_term, values))
    alpha = spot.place.imag
    shares = tuple(-2 * side * one / (-lead).sqrt() for one in simple)
    turned = lattice.scale * lattice.sums.zeta(acb(0, alpha)).imag
    values = [value + share * turned for value, share in zip(values, shares, strict=True)]
    phases = (ThetaPhase(spot.side, alpha, 1, gain_of(lattice, alpha, 1), shares),)
    if all(_nothing(value) for value in square):
        return IntegralPart(phases, (), tuple(values))
    log_term = log_term_at(lattice, spot, none, zetas)
    return IntegralPart(phases, (log_term,), surplus(lattice, log_term, values))


def cubic_part(lattice: Lattice, linear: list[arb], lead: arb) -> IntegralPart | None:
    """The part of ``linear x`` where f has degree 3: ``x = 4/(f3 t^2) + ...`` near its pole."""
    if all(_nothing(value) for value in linear):
        return None
    spot = branch_spot(lattice)
    end: Place = lattice.side(spot.side)
    zetas = tuple(acb(-2 * lattice.scale * one / lead) for one in linear)
    log_term = log_term_at(lattice, spot, tuple(acb(0) for _ in linear), zetas)
    return IntegralPart((), (log_term,), surplus(lattice, log_term, [e * end.x for e in linear]))


def log_term_at(
    lattice: Lattice, spot: Spot, logs: tuple[acb, ...], zetas: tuple[acb, ...]
) -> LogTerm:
    """The log term with these factors, and what it gains in a period."""
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
    return LogTerm(spot.side, spot.place, logs, zetas, gains)


def surplus(lattice: Lattice, log_term: LogTerm, values: list[arb]) -> tuple[arb, ...]:
    """The values of a part of the integrands at the turning point, less the log term's rates."""
    zeta, bend = lattice.sums.zeta(log_term.place), lattice.sums.bend(log_term.place)
    return tuple(
        value + 2 * lattice.scale * (log * zeta - factor * bend).real
        for value, log, factor in zip(values, log_term.logs, log_term.zetas, strict=True)
    )


def _nothing(share: Any) -> bool:
    return share == 0 if isinstance(share, int) else bool(share.is_zero())


def _positive(value: arb, pole: Pole) -> arb:
    if not value > 0:
        raise OpenDecision(f"the pole {show_ball(pole.place)} may be a root of f")
    return value


def between_double_roots(numbers: Numbers, ends: Ends) -> dict[str, Any]:
    """The fields of the constants but those that describe f.

    Raises:
        OpenDecision: more bits are needed.
        DefinitionError: a pole there cannot have a weight.
    """
    if numbers.rate > 0:
        base, other = ends.lower.value, ends.upper.value
    elif numbers.rate < 0:
        base, other = ends.upper.value, ends.lower.value
    else:
        raise OpenDecision(f"the rate {numbers.rate.str(5)} may be 0")
    scale = coefficients(numbers)[4].sqrt() * abs(other - base) / 2
    start = ((numbers.place - base) / (other - numbers.place)).log() / 2
    rates, log_terms = _between_double_roots(numbers, base, other, scale)
    for place, pole in enumerate(numbers.poles):
        shares = [integral.shares[place] for integral in numbers.integrals]
        if pole.weight is not None:
            if not pole.weight.is_zero():
                raise DefinitionError(
                    f"f is positive at the pole {show_ball(pole.place)}, "
                    "which therefore has no weight"
                )
            continue
        log_term, left = _pole(list(map(acb, shares)), pole.place, base, other, scale)
        log_terms.append(log_term)
        rates = [one + two for one, two in zip(rates, left, strict=True)]
    return {
        "kind": "exponential", "base": base, "other": other, "turn": -start / scale,
        "half": None, "scale": scale, "nome": ZERO, "mean": arb(1), "partner": "inverse",
        "phases": (), "log_terms": tuple(log_terms),
        "bounded_terms": tuple((ZERO, ZERO) for _ in rates),
        "rates": tuple(rates), "advances": None, "starts": (),
    }  # fmt: skip


def _between_double_roots(
    numbers: Numbers, base: arb, other: arb, scale: arb
) -> tuple[list[arb], list[LogTerm]]:
    """The rates and the log term of the polynomial parts: tanh z = s'/s(z - i pi/2)."""
    middle, reach = (base + other) / 2, (other - base) / 2
    rates: list[arb] = []
    logs: list[acb] = []
    zetas: list[acb] = []
    for one in numbers.integrals:
        square = one.square * (middle * middle + reach * reach)
        rates.append(one.constant + one.linear * middle + square)
        logs.append(acb((one.linear + 2 * middle * one.square) * reach / scale))
        zetas.append(acb(-one.square * reach * reach / scale))
    if all(value.is_zero() for value in (*logs, *zetas)):
        return rates, []
    place = acb(0, arb.pi() / 2)
    return rates, [LogTerm(0, place, tuple(logs), tuple(zetas), None)]


def _pole(
    shares: list[acb], c: arb | acb, base: arb, other: arb, scale: arb
) -> tuple[LogTerm, list[arb]]:
    """The log term of ``Re share/(x - c)``, and what it leaves of the rates."""
    place = acb((c - base) / (c - other))
    place = (place.log() + acb(0, arb.pi())) / 2
    velocity = 2 * scale * acb((c - base) * (other - c)) / (other - base)
    logs = tuple(share / velocity for share in shares)
    middle = (base + other) / 2
    left = [
        (share / (middle - c) + log * scale * place.cosh() / place.sinh()).real
        for share, log in zip(shares, logs, strict=True)
    ]
    return LogTerm(0, place, logs, tuple(acb(0) for _ in shares), None), left


ZERO = arb(0)
BoundedTerms = tuple[tuple[arb, arb], ...]


def assemble(numbers: Numbers) -> Constants:
    """The constants, as accurate as the numbers and the precision allow.

    Raises:
        OpenDecision: more bits are needed.
        DefinitionError: there is no such motion.
    """
    ends = interval(numbers)
    if ends.at_rest:
        return at_rest(numbers, ends)
    if ends.lower.times > 1 and ends.upper.times > 1:
        shape = between_double_roots(numbers, ends)
        constants = Constants(**shape, **description(numbers, ends))
    else:
        constants = _invert(numbers, ends)
    starts = moment_of(constants, arb(0)).expressions
    return replace(constants, starts=starts)


def at_rest(numbers: Numbers, ends: Ends) -> Constants:
    """The constants of x that does not move: the integrals are linear in time."""
    x = numbers.place
    rates = []
    for integral in numbers.integrals:
        rate = integral.constant + integral.linear * x + integral.square * x * x
        for pole, share in zip(numbers.poles, integral.shares, strict=True):
            weight = arb(1) if pole.weight is None else pole.weight
            if share != 0 and not weight.is_zero():
                rate += (acb(share) * weight / (x - pole.place)).real
        rates.append(rate)
    none = tuple(ZERO for _ in rates)
    bounded_terms = tuple((ZERO, ZERO) for _ in rates)
    return Constants(
        kind="rest", base=x, other=x, turn=ZERO, half=None, scale=arb(1), nome=ZERO,
        mean=arb(1), partner="one", phases=(), log_terms=(), bounded_terms=bounded_terms,
        rates=tuple(rates), advances=None, starts=none, **description(numbers, ends),
    )  # fmt: skip


def _invert(numbers: Numbers, ends: Ends) -> Constants:
    lattice = lattice_of(numbers, ends)
    coefficient = coefficients(numbers)
    numbers, bounded_terms = _lower_poles(numbers, coefficient)
    parts = [_polynomial(numbers, lattice, coefficient)]
    parts += [pole_part(numbers, lattice, place) for place in range(len(numbers.poles))]
    known = [part for part in parts if part is not None]
    phases = tuple(phase for part in known for phase in part.phases)
    log_terms = tuple(log_term for part in known for log_term in part.log_terms)
    rates = [integral.constant for integral in numbers.integrals]
    for part in known:
        rates = [one + two for one, two in zip(rates, part.rates, strict=True)]
    return Constants(
        kind=lattice.sums.kind, base=lattice.base.x, other=lattice.other,
        turn=turn_of(numbers, ends, lattice), half=lattice.half, scale=lattice.scale,
        nome=lattice.sums.nome, mean=lattice.mean, partner=lattice.sums.partner,
        phases=phases, log_terms=log_terms, bounded_terms=bounded_terms, rates=tuple(rates),
        advances=_advances(rates, lattice.period, phases, log_terms),
        starts=(), **description(numbers, ends),
    )  # fmt: skip


def description(numbers: Numbers, ends: Ends) -> dict[str, Any]:
    """Roots and invariants, which describe f rather than the motion."""
    roots = tuple(acb(root.value) for root in ends.roots for _ in range(root.times))
    a4, a3, a2, a1, a0 = coefficients(numbers)
    a3, a2, a1 = a3 / 4, a2 / 6, a1 / 4
    g2 = a0 * a4 - 4 * a1 * a3 + 3 * a2 * a2
    g3 = a0 * a2 * a4 + 2 * a1 * a2 * a3 - power(a2, 3) - a0 * a3 * a3 - a1 * a1 * a4
    simple = all(times == 1 for _, times in numbers.factors) and degree(numbers) > 2
    discriminant = power(g2, 3) - 27 * g3 * g3 if simple else ZERO
    return {"roots": roots, "invariants": (g2, g3, discriminant)}


def degree(numbers: Numbers) -> int:
    """The degree of f."""
    return sum((len(factor) - 1) * times for factor, times in numbers.factors)


def _polynomial(numbers: Numbers, lattice: Lattice, coefficient: list[arb]) -> IntegralPart | None:
    if degree(numbers) == 4:
        return polynomial_part(numbers, lattice, coefficient)
    if degree(numbers) == 3:
        linear = [integral.linear for integral in numbers.integrals]
        return cubic_part(lattice, linear, coefficient[3])
    return None


def _lower_poles(numbers: Numbers, f: list[arb]) -> tuple[Numbers, BoundedTerms]:
    """The integrals less ``(p + q x) dx/dt``, so that infinity is a pole of low order.

    From ``d(dx/dt)/dt = f'/2`` and ``d(x dx/dt)/dt = f + x f'/2``.
    """
    integrals: list[Integral] = []
    bounded_terms: list[tuple[arb, arb]] = []
    for integral in numbers.integrals:
        constant, linear, square = integral.constant, integral.linear, integral.square
        p = q = ZERO
        if degree(numbers) == 3 and not square.is_zero():
            p = 2 * square / (3 * f[3])
            constant, linear, square = constant - p * f[1] / 2, linear - p * f[2], ZERO
        if degree(numbers) == 2:
            q = square / (2 * f[2])
            constant, linear = constant - q * f[0], linear - q * f[1] * 3 / 2
            p = linear / f[2]
            constant, linear, square = constant - p * f[1] / 2, ZERO, ZERO
        integrals.append(replace(integral, constant=constant, linear=linear, square=square))
        bounded_terms.append((p, q))
    return replace(numbers, integrals=tuple(integrals)), tuple(bounded_terms)


def _advances(
    rates: list[arb],
    period: arb | None,
    phases: tuple[ThetaPhase, ...],
    log_terms: tuple[LogTerm, ...],
) -> tuple[arb, ...] | None:
    if period is None:
        return None
    advances = [rate * period for rate in rates]
    for place in range(len(advances)):
        for phase in phases:
            advances[place] += phase.shares[place] * (phase.gain or 0)
        for log_term in log_terms:
            advances[place] += log_term.gains[place] if log_term.gains else 0
    return tuple(advances)

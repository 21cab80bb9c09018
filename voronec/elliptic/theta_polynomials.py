r"""The sums of theta functions as polynomials, in doubles.

With ``w = sin^2 z`` (``-sinh^2 z`` if hyperbolic) it is ``sin((2n+1) z) = sin z p_n(w)`` and
``cos((2n+1) z) = cos z q_n(w)``. So s and c are polynomials, and if hyperbolic
``s(z - i alpha) = sinh z A(w) - i cosh z B(w)`` with sin and cos of alpha in the coefficients.
If trigonometric the phase is that of ``sin(z - i alpha)``, and a series for the nome::

    arg s(z - i alpha) = arg sin(z - i alpha) - sum_k (2/k) r^k/(1 - r^k) sinh(2k alpha) sin 2kz

Coefficients are computed with many bits, rounded once, and left out below ``10^-18`` of the sum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from flint import arb, arb_poly

from voronec.elliptic.constants import Constants, LogTerm, ThetaPhase

NEGLIGIBLE = 1e-18
"""Below half a unit in the last place of a double, even of sums of many terms."""
MOST_TERMS = 12
"""Of theta series: with a nome below exp(-pi) the next is far below a double's last digit."""
MOST_RIPPLES = 64
"""Of the series of an angle; one that falls more slowly is left to the arc tangent."""
LARGEST = 1e290
"""Infinite, for doubles that are multiplied once more."""
NEAREST = 0.6
"""Poles nearer than this are left to the arc tangent: powers of cos 2z would cancel."""


@dataclass(frozen=True)
class Weights:
    """The shares of the ends in x: ``K c^2`` at the base, ``s^2`` at the other end.

    Attributes:
        mean: K.
        from_other_end: K where z is counted from the other end, c and s exchanged.
        sine: coefficients of ``s/sin z``, ascending, in the variable.
        partner: coefficients of ``c/cos z`` (of c itself if the partner is not "theta2").
    """

    mean: float
    from_other_end: float
    sine: tuple[float, ...]
    partner: tuple[float, ...]


@dataclass(frozen=True)
class Angle:
    """The periodic part of a phase: ``sign atan(X N(w)/D(w)) - drift z``, odd in z.

    ``X`` is ``sin z cos z`` if trigonometric, ``tanh z`` if hyperbolic, ``z`` if rational.

    Attributes:
        side: of the phase.
        sign: of the phase.
        above: coefficients of N, ascending, the last one 1.
        below: coefficients of D; a lone 0 where the trace passes through the pole.
        drift: what is linear in the phase and taken into the mean rate; 0 if trigonometric.
        periodic_term: factors of ``sin 2kz``, k = 1, 2, .., to be added; only if trigonometric.
    """

    side: int
    sign: int
    above: tuple[float, ...]
    below: tuple[float, ...]
    drift: float
    periodic_term: tuple[float, ...] = ()


def period_of(constants: Constants) -> arb | None:
    """The period in z, None where it is infinite."""
    return None if constants.half is None else 2 * constants.half * constants.scale


def weights_of(constants: Constants) -> Weights:
    """The weights of the two ends."""
    mean = swapped = constants.mean
    sine = _total(constants, _sines(constants), lambda n: arb((-1) ** n))
    partner = arb_poly([1])
    if constants.partner == "theta2":
        partner = _total(constants, _cosines(constants), lambda n: arb(1))
    elif constants.partner == "theta4":
        swapped = 16 * constants.nome.sqrt() * mean
        partner = _even(constants)
    reach = 1.0
    if constants.kind == "hyperbolic" and constants.half is not None:
        reach = _square(constants.half * constants.scale / 2)
    return Weights(
        float(mean.mid()),
        float(swapped.mid()),
        _round_coefficients(sine, reach),
        _round_coefficients(partner, reach),
    )


def angle_of(constants: Constants, phase: ThetaPhase | LogTerm, alpha: arb, sign: int) -> Angle:
    """The periodic part of the phase of a pole at that distance."""
    size = abs(alpha)
    if constants.kind == "trigonometric":
        near = _double((2 * size).expm1() / 2)
        return Angle(
            phase.side, sign, (1.0,), (near, 1.0), 0.0, _periodic_term(constants.nome, alpha)
        )
    drift = _drift(constants, alpha, sign)
    if alpha.is_zero():
        return Angle(phase.side, sign, (1.0,), (0.0,), drift)
    if constants.kind == "rational":
        return Angle(phase.side, sign, (1.0,), (_double(size),), drift)
    above = _total(constants, _sines(constants), lambda n: (-1) ** n * _cosine(n, size))
    below = _total(constants, _cosines(constants), lambda n: (-1) ** n * _sine(n, size))
    least = abs(below[0])
    reach = 1.0
    if constants.half is not None:
        reach = _square(constants.half * constants.scale)
    above, below = _significant(above, least, reach), _significant(below, least, reach)
    lead = above[-1]
    return Angle(
        phase.side,
        sign,
        (*(_double(value / lead) for value in above[:-1]), 1.0),
        tuple(_double(value / lead) for value in below),
        drift,
    )


def smooth(angles: Sequence[Angle]) -> tuple[bool, ...]:
    """Which phases are cheaper as a series ``sign sum_k e^(-2k alpha)/k sin 2kz`` altogether.

    A row of powers costs about a tenth of an arc tangent; the longest series counts.
    """
    heights = sorted((_height(angle) for angle in angles), reverse=True)
    best, least = 0.0, math.inf
    for count, height in enumerate(heights, 1):
        gain = 10 * count - (
            -math.log(NEGLIGIBLE) / (2 * height) if height >= NEAREST else math.inf
        )
        if gain > best:
            best, least = gain, height
    return tuple(_height(angle) >= least for angle in angles)


def _height(angle: Angle) -> float:
    """The size of alpha, 0 where there is no such series."""
    return math.log1p(2 * angle.below[0]) / 2 if len(angle.below) == 2 and not angle.drift else 0.0


def with_series(angle: Angle) -> Angle:
    """An angle with the series of the whole phase as its periodic term."""
    decay = math.exp(-2 * _height(angle))
    count = max(len(angle.periodic_term), math.ceil(math.log(NEGLIGIBLE) / math.log(decay)), 1)
    known = [*angle.periodic_term, *(0.0 for _ in range(count - len(angle.periodic_term)))]
    series = (angle.sign * decay**k / k for k in range(1, count + 1))
    return replace(angle, periodic_term=tuple(a + b for a, b in zip(known, series, strict=True)))


def periodic_terms_of(constants: Constants, angles: Sequence[Angle]) -> tuple[np.ndarray, ...]:
    """Of each integral: the periodic terms of its phases, over ``X cos^k 2z`` with z from the base.

    ``sin 2kz = 2 X U_(k-1)(cos 2z)``, and half a period later ``(-1)^k`` of it.
    """
    terms = []
    for number in range(len(constants.rates)):
        total = arb_poly([0])
        for phase, angle in zip(constants.phases, angles, strict=True):
            last, this = arb_poly([0]), arb_poly([2])
            share = arb(phase.shares[number])
            for k, factor in enumerate(angle.periodic_term, 1):
                flip = (-1) ** (k * angle.side)
                total += share * flip * arb(factor) * this
                last, this = this, arb_poly([0, 2]) * this - last
        terms.append(np.array([float(value.mid()) for value in total.coeffs()]))
    return tuple(terms)


def _periodic_term(nome: arb, alpha: arb) -> tuple[float, ...]:
    factors: list[float] = []
    if nome.is_zero() or alpha.is_zero():
        return ()
    for k in range(1, MOST_RIPPLES):
        power = nome**k
        factors.append(float((-2 * power / (1 - power) * (2 * k * alpha).sinh() / k).mid()))
        if abs(factors[-1]) < NEGLIGIBLE:
            break
    return tuple(factors)


def _double(value: arb) -> float:
    """The value, or as much of it as doubles can take."""
    return max(-LARGEST, min(LARGEST, float(value.mid())))


def _drift(constants: Constants, alpha: arb, sign: int) -> float:
    """The mean rate in z of ``sign atan(..)``, where it is not periodic."""
    period = period_of(constants)
    if period is None or constants.kind == "trigonometric":
        return 0.0
    waves = 4 if constants.partner == "theta2" else 2
    return float(((sign * arb.pi() - waves * alpha) / period).mid())


def _sines(constants: Constants) -> Iterator[arb_poly]:
    return _family(constants, -1)


def _cosines(constants: Constants) -> Iterator[arb_poly]:
    return _family(constants, 1)


def _family(constants: Constants, before: int) -> Iterator[arb_poly]:
    """p_n or q_n, by ``f((2n+3) z) = 2 cos 2z f((2n+1) z) - f((2n-1) z)``."""
    double = arb_poly([2, -4 if constants.kind == "trigonometric" else 4])
    last, this = arb_poly([before]), arb_poly([1])
    while True:
        yield this
        last, this = this, double * this - last


def _even(constants: Constants) -> arb_poly:
    """``1 + 2 sum (-1)^n r^(n^2/2) cosh 2nz`` in ``sinh^2 z``."""
    double = arb_poly([2, 4])
    last, this = arb_poly([1]), arb_poly([1, 2])
    total, root = last, constants.nome.sqrt()
    for n in range(1, MOST_TERMS):
        total += 2 * (-1) ** n * root ** (n * n) * this
        last, this = this, double * this - last
    return total


def _total(
    constants: Constants, family: Iterator[arb_poly], factor: Callable[[int], arb]
) -> arb_poly:
    """Sum of ``r^(n(n+1)/2)`` times the factor times the n-th of the family."""
    total = arb_poly([0])
    for n, each in zip(range(MOST_TERMS), family, strict=False):
        power = constants.nome ** (n * (n + 1) // 2)
        total += power * factor(n) * each
        if power.is_zero():
            break
    return total


def _significant(polynomial: arb_poly, size: arb, reach: float) -> list[arb]:
    """The coefficients that matter beside ``size``, for a variable up to ``reach``."""
    coefficients = polynomial.coeffs()
    bound = arb(NEGLIGIBLE) * size
    while (
        len(coefficients) > 1
        and abs(coefficients[-1]) * arb(reach) ** (len(coefficients) - 1) < bound
    ):
        coefficients.pop()
    return list(coefficients)


def _round_coefficients(polynomial: arb_poly, reach: float) -> tuple[float, ...]:
    return tuple(float(value.mid()) for value in _significant(polynomial, arb(1), reach))


def _square(z: arb) -> float:
    """``sinh^2 z``, as a bound of the variable; no more than doubles can take."""
    return float((z.min(arb(350)).sinh() ** 2).mid())


def _cosine(n: int, alpha: arb) -> arb:
    return ((2 * n + 1) * alpha).cos()


def _sine(n: int, alpha: arb) -> arb:
    return ((2 * n + 1) * alpha).sin()

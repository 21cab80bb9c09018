"""The constants of a motion at one working precision."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from flint import acb, arb

from voronec.elliptic.ball_evaluation import moment_of
from voronec.elliptic.constants import Constants, Phase, Strain
from voronec.elliptic.exponential import between_double_roots
from voronec.elliptic.lattice import Lattice, lattice_of, turn_of
from voronec.elliptic.numbers import Integral, Numbers
from voronec.elliptic.phases import Part, cubic_part, pole_part, polynomial_part
from voronec.elliptic.roots import Ends, coefficients, interval, power

__all__ = ["assemble", "at_rest", "degree", "description"]

ZERO = arb(0)
Swings = tuple[tuple[arb, arb], ...]


def assemble(numbers: Numbers) -> Constants:
    """The constants, as accurate as the numbers and the precision allow.

    Raises:
        Unresolved: more bits are needed.
        DefinitionError: there is no such motion.
    """
    ends = interval(numbers)
    if ends.rest:
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
    swings = tuple((ZERO, ZERO) for _ in rates)
    return Constants(
        kind="rest", base=x, other=x, turn=ZERO, half=None, scale=arb(1), nome=ZERO,
        mean=arb(1), partner="one", phases=(), strains=(), swings=swings,
        rates=tuple(rates), advances=None, starts=none, **description(numbers, ends),
    )  # fmt: skip


def _invert(numbers: Numbers, ends: Ends) -> Constants:
    lattice = lattice_of(numbers, ends)
    coefficient = coefficients(numbers)
    numbers, swings = _lower_poles(numbers, coefficient)
    parts = [_polynomial(numbers, lattice, coefficient)]
    parts += [pole_part(numbers, lattice, place) for place in range(len(numbers.poles))]
    known = [part for part in parts if part is not None]
    phases = tuple(phase for part in known for phase in part.phases)
    strains = tuple(strain for part in known for strain in part.strains)
    rates = [integral.constant for integral in numbers.integrals]
    for part in known:
        rates = [one + two for one, two in zip(rates, part.rates, strict=True)]
    return Constants(
        kind=lattice.sums.kind, base=lattice.base.x, other=lattice.other,
        turn=turn_of(numbers, ends, lattice), half=lattice.half, scale=lattice.scale,
        nome=lattice.sums.nome, mean=lattice.mean, partner=lattice.sums.partner,
        phases=phases, strains=strains, swings=swings, rates=tuple(rates),
        advances=_advances(rates, lattice.period, phases, strains),
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


def _polynomial(numbers: Numbers, lattice: Lattice, coefficient: list[arb]) -> Part | None:
    if degree(numbers) == 4:
        return polynomial_part(numbers, lattice, coefficient)
    if degree(numbers) == 3:
        linear = [integral.linear for integral in numbers.integrals]
        return cubic_part(numbers, lattice, linear, coefficient[3])
    return None


def _lower_poles(numbers: Numbers, f: list[arb]) -> tuple[Numbers, Swings]:
    """The integrals less ``(p + q x) dx/dt``, so that infinity is a pole of low order.

    From ``d(dx/dt)/dt = f'/2`` and ``d(x dx/dt)/dt = f + x f'/2``.
    """
    integrals: list[Integral] = []
    swings: list[tuple[arb, arb]] = []
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
        swings.append((p, q))
    return replace(numbers, integrals=tuple(integrals)), tuple(swings)


def _advances(
    rates: list[arb], period: arb | None, phases: tuple[Phase, ...], strains: tuple[Strain, ...]
) -> tuple[arb, ...] | None:
    if period is None:
        return None
    advances = [rate * period for rate in rates]
    for place in range(len(advances)):
        for phase in phases:
            advances[place] += phase.shares[place] * (phase.gain or 0)
        for strain in strains:
            advances[place] += strain.gains[place] if strain.gains else 0
    return tuple(advances)

"""Motion between two double roots of f: elementary, and without a turning point.

``x = (base exp(-z) + other exp(z))/(2 cosh z)``, an affine function of tanh z.
"""

from __future__ import annotations

from typing import Any

from flint import acb, arb

from voronec.elliptic.constants import Strain
from voronec.elliptic.numbers import Numbers
from voronec.elliptic.roots import Ends, Unresolved, coefficients, show_ball
from voronec.errors import DefinitionError

__all__ = ["between_double_roots"]

ZERO = arb(0)


def between_double_roots(numbers: Numbers, ends: Ends) -> dict[str, Any]:
    """The fields of the constants but those that describe f.

    Raises:
        Unresolved: more bits are needed.
        DefinitionError: a pole there cannot have a weight.
    """
    if numbers.rate > 0:
        base, other = ends.lower.value, ends.upper.value
    elif numbers.rate < 0:
        base, other = ends.upper.value, ends.lower.value
    else:
        raise Unresolved(f"the rate {numbers.rate.str(5)} may be 0")
    scale = coefficients(numbers)[4].sqrt() * abs(other - base) / 2
    start = ((numbers.place - base) / (other - numbers.place)).log() / 2
    rates, strains = _polynomial(numbers, base, other, scale)
    for place, pole in enumerate(numbers.poles):
        shares = [integral.shares[place] for integral in numbers.integrals]
        if pole.weight is not None:
            if not pole.weight.is_zero():
                raise DefinitionError(
                    f"f is positive at the pole {show_ball(pole.place)}, "
                    "which therefore has no weight"
                )
            continue
        strain, left = _pole(list(map(acb, shares)), pole.place, base, other, scale)
        strains.append(strain)
        rates = [one + two for one, two in zip(rates, left, strict=True)]
    return {
        "kind": "exponential", "base": base, "other": other, "turn": -start / scale,
        "half": None, "scale": scale, "nome": ZERO, "mean": arb(1), "partner": "inverse",
        "phases": (), "strains": tuple(strains), "swings": tuple((ZERO, ZERO) for _ in rates),
        "rates": tuple(rates), "advances": None, "starts": (),
    }  # fmt: skip


def _polynomial(
    numbers: Numbers, base: arb, other: arb, scale: arb
) -> tuple[list[arb], list[Strain]]:
    """The rates and the strain of the polynomial parts: tanh z = s'/s(z - i pi/2)."""
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
    return rates, [Strain(0, place, tuple(logs), tuple(zetas), None)]


def _pole(
    shares: list[acb], c: arb | acb, base: arb, other: arb, scale: arb
) -> tuple[Strain, list[arb]]:
    """The strain of ``Re share/(x - c)``, and what it leaves of the rates."""
    place = acb((c - base) / (c - other))
    place = (place.log() + acb(0, arb.pi())) / 2
    velocity = 2 * scale * acb((c - base) * (other - c)) / (other - base)
    logs = tuple(share / velocity for share in shares)
    middle = (base + other) / 2
    left = [
        (share / (middle - c) + log * scale * place.cosh() / place.sinh()).real
        for share, log in zip(shares, logs, strict=True)
    ]
    return Strain(0, place, logs, tuple(acb(0) for _ in shares), None), left

"""Groebner bases over Q, by flint, within limits."""

from __future__ import annotations

from collections.abc import Sequence
from math import lcm
from typing import Any

import flint

from voronec.errors import EngineLimit


def reduce_by(poly: Any, basis: Sequence[Any]) -> Any:
    """The remainder of a polynomial by a Groebner basis."""
    start = None
    while poly != start:
        start = poly
        for element in basis:
            poly = divmod(poly, element)[1]
    return poly


GROEBNER_LIMITS = (120, 400, 4000)
"""How many polynomials, how many terms in one, and how many bits in a coefficient."""


def groebner_basis(polynomials: Sequence[Any], context: Any) -> list[Any]:
    """A Groebner basis over Q of polynomials in a flint context.

    Raises ``EngineLimit`` where it grows past ``GROEBNER_LIMITS``.
    """
    if not polynomials:
        return []
    integral = flint.fmpz_mpoly_ctx.get(context.names(), context.ordering())
    cleared = []
    for p in polynomials:
        scale = lcm(*(int(c.q) for c in p.coeffs()))
        cleared.append(integral.from_dict({m: int((c * scale).p) for m, c in p.to_dict().items()}))
    found = flint.fmpz_mpoly_vec(cleared, integral).buchberger_naive(limits=GROEBNER_LIMITS)
    basis, complete = found
    if not complete:
        raise EngineLimit("the Groebner basis of the relations grows too large")
    rational = []
    for p in basis.autoreduction():
        rational.append(context.from_dict({m: flint.fmpq(c) for m, c in p.to_dict().items()}))
    return rational

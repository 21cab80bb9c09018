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

    The order that counts degrees goes first: from its basis that of another order is found in a few
    steps, where from the polynomials themselves the nine entries of a rotation never end.  Raises
    ``EngineLimit`` where it grows past ``GROEBNER_LIMITS``.
    """
    if not polynomials:
        return []
    generators = []
    for p in polynomials:
        scale = lcm(*(int(c.q) for c in p.coeffs()))
        generators.append({m: int((c * scale).p) for m, c in p.to_dict().items()})
    complete = False
    for order in dict.fromkeys((flint.Ordering.degrevlex, context.ordering())):
        integral = flint.fmpz_mpoly_ctx.get(context.names(), order)
        start = flint.fmpz_mpoly_vec([*map(integral.from_dict, generators)], integral)
        basis, complete = start.buchberger_naive(limits=GROEBNER_LIMITS)
        if complete:
            generators = [p.to_dict() for p in basis.autoreduction()]
    if not complete:
        raise EngineLimit("the Groebner basis of the relations grows too large")
    return [context.from_dict({m: flint.fmpq(c) for m, c in p.items()}) for p in generators]

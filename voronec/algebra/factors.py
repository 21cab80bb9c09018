"""Factors of polynomials over Q, by flint, within limits that do not depend on the machine."""

from __future__ import annotations

from typing import Any

from voronec.errors import EngineLimit

__all__ = ["irreducible_factors"]

MOST_TERMS, MOST_DEGREE = 20_000, 2_000
"""flint takes less than a second for polynomials of this size; for x^n - 1 the square of n."""


def irreducible_factors(poly: Any) -> tuple[Any, list[tuple[Any, int]]]:
    """A number, and the irreducible factors of a polynomial with their exponents.

    Raises ``EngineLimit`` where the polynomial has too many terms, or too high a degree.
    """
    if len(poly) > MOST_TERMS:
        raise EngineLimit(f"a polynomial of {len(poly)} terms is too large to be factored")
    if len(poly) > 1 and (degree := int(max(poly.degrees()))) > MOST_DEGREE:
        raise EngineLimit(f"a polynomial of degree {degree} is too large to be factored")
    unit, powers = poly.factor()
    return unit, [(factor, int(exponent)) for factor, exponent in powers]

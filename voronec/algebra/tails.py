"""Sums that vanish where a hyperbolic tangent is one, with factors that do not cancel there."""

from __future__ import annotations

from typing import Any

import symengine as se

from voronec.algebra.numeric_functions import SIZE

__all__ = ["with_tails"]

_Terms = dict[int, Any]
"""Powers with their coefficients."""


def with_tails(total: Any) -> Any:
    """A sum that vanishes where tanh w = 1 or -1, with factors 1 - tanh w and 1 + tanh w."""
    if not isinstance(total, se.Add):
        return total
    tangents = [f for term in total.args for f in _tangents(term)]
    for tangent in dict.fromkeys(tangents):
        terms = _in_powers(total, tangent)
        tails, w = se.Integer(1), tangent.args[0]
        for end in (1, -1) if terms else ():
            while (rest := _without_root(terms, end)) is not None:
                terms, tails = rest, tails * _tail(end, w)
        if tails != 1:
            return tails * se.Add(*[c * tangent**k for k, c in terms.items()])
    return total


def _tangents(term: Any) -> list[Any]:
    factors = term.args if isinstance(term, se.Mul) else (term,)
    bases = [f.args[0] if isinstance(f, se.Pow) else f for f in factors]
    return [b for b in bases if isinstance(b, se.tanh)]


def _in_powers(total: Any, tangent: Any) -> _Terms:
    """The coefficients of a sum in powers of a tangent; none where it is no polynomial in it."""
    parts: dict[int, list[Any]] = {}
    for term in total.args:
        power, rest = 0, [se.Integer(1)]
        for factor in term.args if isinstance(term, se.Mul) else (term,):
            base, exponent = factor.args if isinstance(factor, se.Pow) else (factor, se.Integer(1))
            if base == tangent and isinstance(exponent, se.Integer) and exponent > 0:
                power += int(exponent)
            else:
                rest.append(factor)
        coefficient = se.Mul(*rest)
        if tangent in coefficient.atoms(se.tanh):
            return {}
        parts.setdefault(power, []).append(coefficient)
    # one sum for each power: sums that grow by a term at a time would cost its square
    return {power: se.Add(*terms) for power, terms in parts.items()}


def _without_root(terms: _Terms, end: int) -> _Terms | None:
    """P/(1 - end T) where P vanishes at T = end; None where it does not."""
    if max(terms, default=0) == 0:
        return None
    quotient, carried = {}, se.Integer(0)
    for k in range(max(terms) + 1):  # P = (1 - end T) Q, from the lowest power on
        carried = (terms.get(k, se.Integer(0)) + end * carried).expand()
        quotient[k] = carried
    if quotient.pop(max(terms)) != 0:
        return None
    return {k: c for k, c in quotient.items() if c != 0}


def _tail(end: int, w: Any) -> Any:
    """1 - tanh w, or 1 + tanh w for the other end."""
    size = se.Function(SIZE)(w)
    return 2 * se.exp(-end * w - size) / (1 + se.exp(-2 * size))

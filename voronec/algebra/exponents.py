"""Exponents as rational combinations of independent ones among them.

exp(w_1), ..., exp(w_n) obey no relation where no rational combination of the w_i is zero; so they
serve as generators as they stand.  Taken apart into exponentials of the terms of w they would be
right as well, and useless in doubles:

    exp(-1000 (t - 1)^2)  =  exp(-1000) exp(2000 t) exp(-1000 t^2).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import symengine as se

__all__ = ["ExponentBasis"]

_Vector = dict[Any, Any]


class ExponentBasis:
    """Independent exponents among some that are given by their terms: {exponent: {term: number}}.

    Those with the fewest terms come first, as they are written shortest; ``members`` are they.
    """

    def __init__(self, exponents: Mapping[Any, Mapping[Any, Any]]) -> None:
        self.members: list[Any] = []
        # each with the term that it alone holds among those after it, there 1
        self._rows: list[tuple[Any, _Vector, _Vector]] = []
        for exponent in sorted(exponents, key=lambda w: (len(exponents[w]), _length(w), str(w))):
            self._add(exponent, exponents[exponent])

    def _add(self, exponent: Any, terms: Mapping[Any, Any]) -> None:
        rest, found = self._reduce(terms)
        if not rest:
            return
        pivot = min(rest, key=str)
        own = _combine({exponent: se.Integer(1)}, found, -1)
        self.members.append(exponent)
        scale = 1 / rest[pivot]
        self._rows.append((pivot, *({k: c * scale for k, c in v.items()} for v in (rest, own))))

    def _reduce(self, terms: Mapping[Any, Any]) -> tuple[_Vector, _Vector]:
        """What is left of an exponent, and the combination of members that was taken off."""
        rest, found = dict(terms), _Vector()
        for pivot, row, members in self._rows:
            factor = rest.get(pivot)
            if factor is not None:
                rest, found = _combine(rest, row, -factor), _combine(found, members, factor)
        return rest, found

    def coordinates(self, terms: Mapping[Any, Any]) -> _Vector | None:
        """{member: number} of an exponent; None where it is no combination of the members."""
        rest, found = self._reduce(terms)
        return None if rest else found


def _combine(one: Mapping[Any, Any], other: Mapping[Any, Any], factor: Any) -> _Vector:
    keys: Iterable[Any] = dict.fromkeys((*one, *other))
    zero = se.Integer(0)
    total = {k: one.get(k, zero) + factor * other.get(k, zero) for k in keys}
    return {k: c for k, c in total.items() if c != 0}


def _length(exponent: Any) -> int:
    return int(se.count_ops(exponent))

"""Exponents as rational combinations of independent ones among them.

exp(w_1), ..., exp(w_n) obey no relation where no rational combination of the w_i is zero; so they
serve as generators as they stand.  Taken apart into exponentials of the terms of w they would be
right as well, and useless in doubles:

    exp(-1000 (t - 1)^2)  =  exp(-1000) exp(2000 t) exp(-1000 t^2).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from math import gcd
from typing import Any

import symengine as se

from voronec.errors import EngineLimit

DEGREE = 60
"""Up to this degree exponentials are powers of others, or hyperbolic tangents quotients: tanh(20 t)
beside exp(t/5) would be one of degree 200."""

_Vector = dict[Any, Any]


class ExponentBasis:
    """Independent exponents among some that are given by their terms: {exponent: {term: number}}.

    Those with the fewest terms come first, as they are written shortest.  Where two differ by a
    number, exp(1) is taken for that.  The sign of a member is the one that most have, so that few
    stand below a fraction.
    """

    def __init__(self, exponents: Mapping[Any, Mapping[Any, Any]]) -> None:
        self.members: list[Any] = []
        # each with the term that it alone holds among those after it, there 1
        self._rows: list[tuple[Any, _Vector, _Vector]] = []
        signs = Counter(map(_orientation, exponents.values()))
        for exponent in sorted(exponents, key=lambda w: (len(exponents[w]), _length(w), str(w))):
            terms = exponents[exponent]
            first, sign = _orientation(terms)
            fewer = signs[first, sign] - signs[first, -sign]
            number = _content(terms) * (-1 if (fewer or sign) < 0 else 1)
            self._add(exponent / number, {t: c / number for t, c in terms.items()})

    def _add(self, exponent: Any, terms: Mapping[Any, Any]) -> None:
        rest, combination = self._reduce(terms)
        if not rest:
            return
        if {*rest} == {se.Integer(1)}:
            exponent, rest, combination = se.Integer(1), {se.Integer(1): se.Integer(1)}, {}
        pivot = min(rest, key=str)
        members = _combine({exponent: se.Integer(1)}, combination, -1)
        self.members.append(exponent)
        scale = 1 / rest[pivot]
        self._rows.append((pivot, *({k: c * scale for k, c in v.items()} for v in (rest, members))))

    def _reduce(self, terms: Mapping[Any, Any]) -> tuple[_Vector, _Vector]:
        """What is left of an exponent, and the combination of members that was taken off."""
        rest, combination = dict(terms), _Vector()
        for pivot, row, members in self._rows:
            factor = rest.get(pivot)
            if factor is not None:
                rest, combination = (
                    _combine(rest, row, -factor),
                    _combine(combination, members, factor),
                )
        return rest, combination

    def coordinates(self, terms: Mapping[Any, Any]) -> _Vector | None:
        """{member: number} of an exponent; None where it is no combination of the members."""
        rest, combination = self._reduce(terms)
        return None if rest else combination


def _combine(one: Mapping[Any, Any], other: Mapping[Any, Any], factor: Any) -> _Vector:
    zero = se.Integer(0)
    total = {k: one.get(k, zero) + factor * other.get(k, zero) for k in (*one, *other)}
    return {k: c for k, c in total.items() if c != 0}


def _length(exponent: Any) -> int:
    return int(se.count_ops(exponent))


def _content(terms: Mapping[Any, Any]) -> Any:
    """The whole number by which an exponent is divisible: exp(2 x) - 1 has factors in exp(x)."""
    if any(c.q != 1 for c in terms.values()):
        return se.Integer(1)
    divisor = gcd(*(int(c.p) for c in terms.values()))
    return se.Integer(divisor if 0 < divisor <= DEGREE else 1)


def _orientation(terms: Mapping[Any, Any]) -> tuple[Any, int]:
    """The first term by name that is no number, with the sign of its number; of numbers None."""
    first = min((t for t in terms if not t.is_Number), key=str, default=None)
    number = terms.get(first, se.Integer(1))
    if not number.is_real:
        raise EngineLimit(f"the number '{number}' is not rational")
    return first, -1 if number < 0 else 1

"""Rates and slopes of a declared motion as partial fractions, exactly.

The polynomial part is the quotient of a division.  At a pole with a weight the share is a whole
number; at any other pole it is the residue, a formula.  Which term has which pole, and what the
whole numbers are, is read off a motion whose numbers are in no special position.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.precision import SHARP
from voronec.algebra.text import as_expression
from voronec.closed.arithmetic import Function, ball, compile_expressions, precise
from voronec.errors import DefinitionError, EngineLimit

MOST = 6
"""Of numerators and denominators of rates, at most."""
NEAR = 2.0**-100
"""A share is this near to a whole number, as a check."""

Rows = tuple[tuple[Any, ...], ...]


def _nothing(_: Any) -> list[Any]:
    return []


@dataclass(frozen=True, eq=False)
class PartialFractions:
    """Partial fractions of rates and of slopes.

    quotients, slopes
        the polynomial parts, three coefficients each, ascending.
    shares
        of each rate, whole numbers, one per pole with a weight.
    foreign
        level, as complex balls -> the place of each other pole, then for each of these the
        residues of all rates and of all slopes.
    meets
        of each of these residues, whether there is one at all.
    """

    quotients: Rows = ()
    slopes: Rows = ()
    shares: tuple[tuple[int, ...], ...] = ()
    foreign: Function = _nothing
    meets: tuple[tuple[bool, ...], ...] = ()


@dataclass(frozen=True)
class Term:
    """A summand of a rate: coefficients of numerator and denominator, and both themselves."""

    above: list[Any]
    below: list[Any]
    numerator: Any
    denominator: Any


def partial_fractions(
    rates: Sequence[Any], slopes: Sequence[Any], poles: Sequence[tuple[Any, Any]],
    others: Sequence[Any], x: Any, level: tuple[Any, ...], example: list[Any],
) -> PartialFractions:  # fmt: skip
    """Rates and slopes over the poles, with their weights, and over other poles; ``example`` are
    values of the symbols of the level in no special position."""
    both = [
        [_term(t, x, level, example) for t in sp.Add.make_args(as_expression(e))]
        for e in (*rates, *slopes)
    ]
    quotients = [_sum(_quotient(t.above, t.below) for t in row) for row in both]
    foreign, meets = _foreign(both, others, x, level, example)
    count = len(rates)
    for row in both[count:]:
        _require_integrable(row, others, x, level, example)
    return PartialFractions(
        quotients=tuple(_with_exact_zeros(q, level, example) for q in quotients[:count]),
        slopes=tuple(_with_exact_zeros(q, level, example) for q in quotients[count:]),
        shares=_shares(both[:count], poles, x, level, example),
        foreign=foreign,
        meets=meets,
    )


def ascending_coefficients(value: Any, x: Any, degree: int) -> tuple[Any, ...]:
    """The coefficients of a polynomial, by its slopes at 0: nothing is multiplied out."""
    coefficients, slope = [], as_expression(value)
    for i in range(degree + 1):
        coefficients.append(slope.xreplace({x: sp.Integer(0)}) / sp.factorial(i))
        slope = sp.diff(slope, x)
    return tuple(coefficients)


def _term(term: Any, x: Any, level: tuple[Any, ...], example: list[Any]) -> Term:
    """Coefficients up to the last that does not vanish."""
    above, below = sp.fraction(term)
    parts = []
    for value in (above, below):
        row = list(ascending_coefficients(value, x, MOST))
        with precise(SHARP):
            seen = compile_expressions(row, level)(example)
        while len(row) > 1 and seen[len(row) - 1].contains(0):
            row.pop()
        parts.append(row)
    return Term(parts[0], parts[1], above, below)


def _quotient(above: list[Any], below: list[Any]) -> tuple[Any, ...]:
    """Of a division of polynomials, ascending, three coefficients."""
    rest, quotient = list(above), [sp.Integer(0)] * 3
    while len(rest) >= len(below):
        shift, factor = len(rest) - len(below), rest[-1] / below[-1]
        if shift > 2:
            raise EngineLimit("a rate grows faster than the square of the variable")
        quotient[shift] += factor
        for i, c in enumerate(below[:-1]):
            rest[shift + i] -= factor * c
        rest.pop()
    return tuple(quotient)


def _sum(rows: Any) -> tuple[Any, ...]:
    return tuple(sp.Add(*column) for column in zip(*rows, strict=True))


def _with_exact_zeros(
    row: tuple[Any, ...], level: tuple[Any, ...], example: list[Any]
) -> tuple[Any, ...]:
    """The coefficients; those that vanish identically as 0."""
    with precise(SHARP):
        seen = compile_expressions(row, level)(example)
    return tuple(
        sp.Integer(0) if value.contains(0) and sp.cancel(e) == 0 else e
        for e, value in zip(row, seen, strict=True)
    )


def _shares(
    rows: list[list[Term]], poles: Sequence[tuple[Any, Any]], x: Any, level: tuple[Any, ...],
    example: list[Any],
) -> tuple[tuple[int, ...], ...]:  # fmt: skip
    """Residues over weights."""
    with precise(SHARP):
        flat = compile_expressions([e for pole in poles for e in pole], level)(example)
        places = list(zip(flat[::2], flat[1::2], strict=True))
        shares = []
        for row in rows:
            parts = [
                e for t in row for e in (t.numerator, t.denominator, sp.diff(t.denominator, x))
            ]
            at = compile_expressions(parts, (*level, x))
            shares.append(tuple(_share(at([*example, c]), w) for c, w in places))
    return tuple(shares)


def _share(values: list[Any], weight: Any) -> int:
    residue = ball(0)
    for i in range(0, len(values), 3):
        above, below, slope = values[i : i + 3]
        if below.contains(0) and not slope.contains(0):
            residue += above / slope
    share = residue / weight
    whole = round(float(share))
    if not abs(share - whole) < NEAR:
        raise DefinitionError(
            f"a rate of the declared motion has the residue {float(share):.6g} times the weight of "
            "its pole, no whole number; declare the weight w with f(c) = -4 w^2"
        )
    return whole


def _foreign(
    rows: list[list[Term]], others: Sequence[Any], x: Any, level: tuple[Any, ...],
    example: list[Any],
) -> tuple[Function, tuple[tuple[bool, ...], ...]]:  # fmt: skip
    flat, meets = list(others), []
    for place in others:
        met = []
        for row in rows:
            singular = [t for t in row if _vanishes(t.denominator, place, x, level, example)]
            parts = [t.numerator / sp.diff(t.denominator, x) for t in singular]
            flat.append(sp.Add(*(e.xreplace({x: place}) for e in parts)))
            met.append(bool(singular))
        meets.append(tuple(met))
    return compile_expressions(flat, level), tuple(meets)


def _vanishes(
    below: Any, place: Any, x: Any, level: tuple[Any, ...], example: list[Any]
) -> bool:  # fmt: skip
    from flint import acb

    if not below.has(x):
        return False
    with precise(SHARP):
        value = compile_expressions([below.xreplace({x: place})], level)([acb(e) for e in example])[
            0
        ]
    return bool(acb(value).contains(0))


def _require_integrable(
    row: list[Term], others: Sequence[Any], x: Any, level: tuple[Any, ...], example: list[Any]
) -> None:
    for t in row:
        met = sum(_vanishes(t.denominator, c, x, level, example) for c in others)
        if met != len(t.below) - 1:
            raise EngineLimit(
                "a slope of a place on a plane has poles that are not declared; give them in "
                "others=(...)"
            )

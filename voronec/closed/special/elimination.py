"""The constants of a motion with constant x, by three equations, each linear in one of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.normal import shorten

__all__ = ["Branch", "branches_of", "linear_in", "short", "solve_constants"]


@dataclass(frozen=True)
class Branch:
    """Precessions that the family leaves out: x and w are fixed there, and ``free`` is not.

    Where the coefficient of the last constant and the rest of its equation both vanish, that
    constant may have any value.
    """

    place: sp.Expr
    rate: sp.Expr
    free: sp.Symbol
    constants: Mapping[sp.Symbol, sp.Expr]


def solve_constants(
    quartic: sp.Expr, rate: sp.Expr, x: sp.Symbol, constants: Sequence[sp.Symbol]
) -> tuple[dict[sp.Symbol, sp.Expr], sp.Expr, sp.Expr, sp.Symbol] | None:
    """The constants by three equations; of the last one its coefficient and its rest, too."""
    equations = [rate, quartic, sp.diff(quartic, x)]
    if len(constants) != len(equations):
        return None
    found: dict[sp.Symbol, sp.Expr] = {}
    left = list(constants)
    for equation in equations:
        above = _above(equation.xreplace(found))
        linear = [c for c in left if sp.degree(above, c) == 1]
        if not linear:
            return None
        # A coefficient without x vanishes for no place: such a constant is solved for first.
        constant = min(linear, key=lambda c: sp.diff(above, c).has(x))
        poly = sp.Poly(above, constant)
        slope, rest = poly.nth(1), poly.nth(0)
        value = short(-rest / slope)
        found = {c: short(e.xreplace({constant: value})) for c, e in found.items()}
        found[constant] = value
        left.remove(constant)
    common = sp.gcd(slope, rest)
    order = {c: found[c] for c in constants}
    return order, sp.cancel(slope / common), sp.cancel(rest / common), constant


def branches_of(
    rate: sp.Expr,
    quartic: sp.Expr,
    x: sp.Symbol,
    found: Mapping[sp.Symbol, sp.Expr],
    linear: tuple[sp.Expr, sp.Expr, sp.Symbol],
) -> tuple[Branch, ...]:
    """Where the coefficient of the last constant vanishes with the rest of its equation."""
    slope, rest, last = linear
    (w,) = rate.free_symbols & slope.free_symbols - {x, *found} - quartic.free_symbols or {None}
    if w is None:
        return ()
    branches = []
    for factor, _ in sp.factor_list(slope)[1]:
        for value in sp.roots(factor, w) if factor.has(w) else ():
            for place in sp.roots(_above(rest.xreplace({w: value})), x):
                branches += _branch(
                    rate.xreplace({w: value}), quartic, (x, place), value, last, found
                )
    return tuple(branches)


def _branch(
    rate: sp.Expr,
    quartic: sp.Expr,
    at: tuple[sp.Symbol, sp.Expr],
    w: sp.Expr,
    last: Any,
    names: Any,
) -> list[Branch]:
    """The constants there, but for ``last``; none outside the range of x."""
    x, place = at
    if place.is_number and not -1 < place < 1:
        return []
    values: dict[sp.Symbol, sp.Expr] = {last: last}
    for equation in (rate, quartic):
        here = _above(equation.xreplace(values).xreplace({x: place}))
        constant = next((c for c in names if c not in values and sp.degree(here, c) == 1), None)
        if constant is None:
            return []
        values[constant] = short(sp.solve(here, constant)[0])
    return [Branch(place, w, last, MappingProxyType(values))]


def short(value: sp.Expr) -> sp.Expr:
    """The shortest proved form."""
    (found,) = shorten([value])
    return found


def linear_in(value: sp.Expr, symbol: sp.Symbol, square: sp.Expr) -> sp.Expr:
    """A rational function of a symbol whose square is known, the denominator without it."""
    parts = []
    for part in sp.fraction(sp.together(short(value))):
        terms = sp.Poly(sp.expand(part), symbol).as_dict().items()
        even, odd = (
            sp.Add(*(c * square ** (n // 2) for (n,), c in terms if n % 2 == side))
            for side in (0, 1)
        )
        parts.append((short(even), short(odd)))
    (a, b), (c, d) = parts
    if d == 0:
        return short(a / c) + short(b / c) * symbol
    below = short(c**2 - d**2 * square)
    return short((a * c - b * d * square) / below) + short((b * c - a * d) / below) * symbol


def _above(value: sp.Expr) -> sp.Expr:
    """The numerator in lowest terms."""
    return sp.expand(sp.fraction(sp.together(short(value)))[0])

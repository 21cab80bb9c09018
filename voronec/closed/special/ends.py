"""Motions at a pole: the contact stays where the variable has an end of its range.

There f(c) = -4 w^2 with the weight w of the pole c, so w = 0 and f'(c) = 0; both are linear in a
constant, and one constant is left.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.factors import in_factors
from voronec.declaration.quadratures import Quadratures

__all__ = ["End", "ends_of"]


@dataclass(frozen=True)
class End:
    """The ball turns about the normal at a pole; the contact rests on both surfaces.

    place
        1 or -1.
    free
        the velocity that may have any value, or a constant where no velocity is linear in it.
    constants
        constant of the motion -> its value.
    second, third
        derivatives of the quartic there; x has an inner side only, so the motion is stable where
        the first that is not zero makes f negative inside.
    """

    place: sp.Expr
    free: Any
    constants: Mapping[sp.Symbol, sp.Expr]
    second: sp.Expr
    third: sp.Expr


def ends_of(quadratures: Quadratures, values: Mapping[Any, sp.Expr]) -> tuple[End, ...]:
    """The motions at 1 and at -1, where these are poles of the integrals."""
    found = []
    for place, weight in quadratures.poles.items():
        if place in (1, -1):
            end = _end(quadratures, place, weight.xreplace(dict(values)), values)
            found += [end] if end is not None else []
    return tuple(sorted(found, key=lambda end: -end.place))


def _end(
    quadratures: Quadratures, place: sp.Expr, weight: sp.Expr, values: Mapping[Any, sp.Expr]
) -> End | None:
    x = quadratures.x
    f = quadratures.quartic.xreplace(dict(values))
    names = [c for c in quadratures.constants if f.has(c)]
    constants: dict[sp.Symbol, sp.Expr] = {}
    for equation in (weight, sp.diff(f, x).xreplace({x: place})):
        above = sp.numer(sp.together(equation.xreplace(constants)))
        linear = [c for c in names if c not in constants and sp.degree(above, c) == 1]
        if not linear:
            return None
        # the last of them: its coefficient is simplest where constants come by their degree
        value = in_factors(sp.solve(above, linear[-1])[0])
        constants = {c: in_factors(e.xreplace({linear[-1]: value})) for c, e in constants.items()}
        constants[linear[-1]] = value
    (free,) = [c for c in names if c not in constants]
    constants[free] = free
    spin, level = _velocity(quadratures, place, constants, values, free)
    constants = {c: in_factors(constants[c].xreplace({free: level})) for c in names}
    slopes = [sp.diff(f, x, order).xreplace({x: place}) for order in (2, 3)]
    second, third = (in_factors(e.xreplace(constants)) for e in slopes)
    return End(place, spin, MappingProxyType(constants), second, third)


def _velocity(
    quadratures: Quadratures,
    place: sp.Expr,
    constants: Mapping[sp.Symbol, sp.Expr],
    values: Mapping[Any, sp.Expr],
    free: sp.Symbol,
) -> tuple[Any, sp.Expr]:
    """A velocity that is linear in the free constant there, and the constant by it."""
    for name, expr in quadratures.velocities.items():
        here = (
            expr.xreplace({quadratures.x: place}).xreplace(dict(constants)).xreplace(dict(values))
        )
        if free in here.free_symbols and not here.has(sp.Derivative, sp.sin):
            slope = sp.diff(here, free)
            if slope and not slope.has(free):
                return name, sp.solve(here - name, free)[0]
    return free, free

"""Precessions as initial data: the conserved vector upright, the contact where the family says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.errors import DefinitionError
from voronec.quadratures import Space
from voronec.scene import Scene

if TYPE_CHECKING:
    from voronec.closed.special.family import Precessions

__all__ = ["scene_of", "upright"]

ACROSS = sp.ImmutableMatrix([[0, 0, 1], [1, 0, 0], [0, 1, 0]])
"""A position in which no coordinate of a contact is singular, for a vector that is zero."""


def scene_of(
    family: Precessions, at: Mapping[Any, sp.Expr], aside: sp.Expr, times: tuple[float, float]
) -> Scene:
    """Initial data at a point of the family; ``aside`` is the velocity of the variable."""
    quadratures = family.quadratures
    meaning = quadratures.meaning
    if not isinstance(meaning, sp.cos) or not meaning.args[0].is_Symbol:
        raise DefinitionError(f"'{meaning}' is not the cosine of a coordinate: no scene is made")
    (angle,) = meaning.args
    x = at[family.place]
    sine = sp.sqrt(1 - x**2)
    turning = {velocity(q): e.xreplace(dict(at)) for q, e in _turning(family).items()}
    constants = {c: e.xreplace(dict(at)) for c, e in family.constants.items()}
    here = {velocity(angle): -aside / sine, family.place: x, **constants, **turning, **at}
    state: dict[Any, Any] = {angle: sp.acos(x)}
    for name, expr in quadratures.velocities.items():
        state[name] = _plain(expr.subs({sp.cos(angle): x, sp.sin(angle): sine}).xreplace(here))
    if quadratures.space is not None:
        state |= upright(quadratures.space, {**state, **at}, angle, x, sine)
    own = {p.symbol: at[p.symbol] for p in family.system.parameters if p.symbol in at}
    return Scene(initial=state, parameters=own, times=times)


def _turning(family: Precessions) -> dict[Any, sp.Expr]:
    """Rates of the angles that the velocities hold."""
    held = {s for e in family.quadratures.velocities.values() for s in e.atoms(sp.Derivative)}
    held |= {s for e in family.quadratures.velocities.values() for s in e.free_symbols}
    return {q: family.rates[q] for q in family.quadratures.integrals if velocity(q) in held}


def upright(
    space: Space, state: Mapping[Any, sp.Expr], angle: Any, cosine: sp.Expr, sine: sp.Expr
) -> dict[Any, sp.Expr]:
    """Coordinates in space for which the vector lies along the third axis, upwards."""
    known = {k: v for k, v in state.items() if k != angle}
    vector = space.vector.subs({sp.cos(angle): cosine, sp.sin(angle): sine}).xreplace(known)
    vector = vector.applyfunc(_plain)
    length = sp.sqrt(_plain(vector.dot(vector)))
    rows = ACROSS if length == 0 else _frame(vector / length)
    entries = dict(zip(space.entries, rows, strict=True))
    return {q: e.xreplace(entries) for q, e in space.coordinates.items()}


def _frame(third: sp.Matrix) -> sp.Matrix:
    """An orthogonal matrix with a given last row."""
    flat = sp.sqrt(_plain(third[0] ** 2 + third[1] ** 2))
    if flat == 0:
        return sp.diag(1, third[2], third[2])
    first = sp.Matrix([third[1], -third[0], 0]) / flat
    second = third.cross(first)
    return sp.Matrix([list(first), list(second), list(third)])


def _plain(value: Any) -> sp.Expr:
    """A number in its expanded form, so that what is zero reads so."""
    return sp.expand(value)

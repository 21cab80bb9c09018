"""Precessions as initial data: the conserved vector upright, the contact where the family says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.closed.upright import turned_upright
from voronec.errors import DefinitionError
from voronec.quadratures import Space
from voronec.scene import Scene

if TYPE_CHECKING:
    from voronec.closed.special.family import Precessions

__all__ = ["scene_of", "upright"]


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
    return turned_upright(space, vector.applyfunc(_plain))


def _plain(value: Any) -> sp.Expr:
    """A number in its expanded form, so that what is zero reads so."""
    return sp.expand(value)

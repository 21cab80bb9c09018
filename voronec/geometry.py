"""Fibrations and frames: which coordinates lie over which, and which velocities are used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.errors import DefinitionError

__all__ = ["Fibration", "Frame"]


@dataclass(frozen=True)
class Fibration:
    """pi : Q -> B, (r, s) -> r: base coordinates r, fibre coordinates s.

    The velocities of the base are free, those of the fibre are what the constraints determine.
    ``relations`` are expressions in the coordinates that vanish, for redundant coordinates (a
    quaternion, a Poisson vector); the motion stays on their zero set.
    """

    base: tuple[sp.Expr, ...]
    fibre: tuple[sp.Expr, ...] = ()
    relations: tuple[sp.Expr, ...] = ()

    def __post_init__(self) -> None:
        for part in ("base", "fibre"):
            object.__setattr__(self, part, _names(getattr(self, part), part))
        relations = tuple(sp.sympify(r) for r in self.relations)
        object.__setattr__(self, "relations", relations)
        seen: dict[str, sp.Expr] = {}
        for coordinate in self.base + self.fibre:
            name = plain_name(coordinate)
            if name in seen:
                raise DefinitionError(
                    f"coordinate '{name}' is listed twice in the fibration; list it once"
                )
            seen[name] = coordinate


@dataclass(frozen=True)
class Frame:
    """Quasi-velocities v_i and their definitions, affine in the velocities."""

    velocities: tuple[sp.Expr, ...]
    expressions: tuple[sp.Expr, ...]

    @classmethod
    def quasi(cls, definitions: Mapping[Any, Any]) -> Frame:
        """The frame whose quasi-velocities are defined by ``{v: expression, ...}``.

        Expressions are affine in any velocities, those of the fibre included; together with the
        constraints they must determine all velocities.
        """
        if not isinstance(definitions, Mapping) or not definitions:
            raise DefinitionError("Frame.quasi takes a non-empty mapping {velocity: expression}")
        velocities = _names(tuple(definitions), "frame")
        return cls(velocities, tuple(sp.sympify(e) for e in definitions.values()))


def _names(things: Any, part: str) -> tuple[sp.Expr, ...]:
    """A tuple of symbols out of one symbol or several."""
    if isinstance(things, sp.Basic) and not isinstance(things, sp.Tuple):
        things = (things,)
    for thing in things:
        if not is_symbolic_name(thing):
            raise DefinitionError(f"'{thing}' in the {part} is not a symbol; use sympy.Symbol")
    return tuple(things)

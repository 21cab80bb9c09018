"""Fibrations and frames: which coordinates lie over which, and which velocities are used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.errors import DefinitionError
from voronec.reading import expression, several, shown, vanishing

__all__ = ["Fibration", "Frame"]


@dataclass(frozen=True)
class Fibration:
    """pi : Q -> B, (r, s) -> r: base coordinates r, fibre coordinates s.

    The velocities of the base are free, those of the fibre are what the constraints determine.
    ``relations`` are expressions in the coordinates that vanish, for redundant coordinates (a
    quaternion, a Poisson vector); the motion stays on their zero set.  A single coordinate or
    relation may stand without a tuple.
    """

    base: tuple[sp.Expr, ...]
    fibre: tuple[sp.Expr, ...] = ()
    relations: tuple[sp.Expr, ...] = ()

    def __post_init__(self) -> None:
        for part in ("base", "fibre"):
            object.__setattr__(self, part, _names(getattr(self, part), part))
        given = enumerate(several(self.relations, "relations", "expression"))
        relations = tuple(vanishing(r, f"relation {i + 1} of the fibration") for i, r in given)
        object.__setattr__(self, "relations", relations)
        seen: set[str] = set()
        for name in map(plain_name, self.base + self.fibre):
            if name in seen:
                raise DefinitionError(
                    f"coordinate '{name}' is listed twice in the fibration; list it once"
                )
            seen.add(name)


@dataclass(frozen=True)
class Frame:
    """Quasi-velocities v_i and their definitions, affine in the velocities."""

    velocities: tuple[sp.Expr, ...]
    expressions: tuple[sp.Expr, ...]

    def __post_init__(self) -> None:
        velocities = _names(self.velocities, "frame")
        expressions = several(self.expressions, "expressions", "expression")
        if len(velocities) != len(expressions) or not velocities:
            raise DefinitionError(
                f"a frame has {len(velocities)} velocities and {len(expressions)} expressions; "
                "write Frame.quasi({velocity: expression})"
            )
        pairs = zip(velocities, expressions, strict=True)
        read = tuple(expression(e, f"the definition of '{plain_name(v)}'") for v, e in pairs)
        object.__setattr__(self, "velocities", velocities)
        object.__setattr__(self, "expressions", read)

    @classmethod
    def quasi(cls, definitions: Mapping[Any, Any]) -> Frame:
        """The frame whose quasi-velocities are defined by ``{v: expression, ...}``.

        Expressions are affine in any velocities, those of the fibre included; together with the
        constraints they must determine all velocities.
        """
        if not isinstance(definitions, Mapping) or not definitions:
            raise DefinitionError("Frame.quasi takes a non-empty mapping {velocity: expression}")
        return cls(tuple(definitions), tuple(definitions.values()))


def _names(things: Any, part: str) -> tuple[sp.Expr, ...]:
    """A tuple of symbols out of one symbol or several."""
    names = several(things, part, "symbol")
    for thing in names:
        if not is_symbolic_name(thing):
            raise DefinitionError(
                f"'{shown(thing)}' in the {part} is not a symbol; use sympy.Symbol"
            )
    return names

"""Declared integrals as functions on the field that is searched."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from voronec.algebra.normal import canonical
from voronec.algebra.ring import Ring
from voronec.algebra.shape import expression
from voronec.claims import Corrected
from voronec.errors import EngineLimit
from voronec.system import System
from voronec.vector_field import Motions, VectorField

__all__ = ["declared", "on_field"]

Values = Mapping[Any, sp.Expr]


def declared(system: System, values: Values, cases: Mapping[str, Values]) -> dict[str, sp.Expr]:
    """The declared integrals: those of the system, and those of the cases, each given with its
    parameters, that hold at these values of parameters."""
    claims = dict(system.integrals)
    for name, parameters in cases.items():
        if _implied(parameters, values):
            claims |= {f"{k} ({name})": v for k, v in system.cases[name].integrals.items()}
    return {k: c.right if isinstance(c, Corrected) else c for k, c in claims.items()}


def _implied(case: Values, values: Values) -> bool:
    """Whether the values given to parameters are among those of a case."""
    at = dict(values)
    return bool(case) and all(
        sp.cancel(symbol.xreplace(at) - value.xreplace(at)) == 0 for symbol, value in case.items()
    )


def on_field(motions: Motions, field: VectorField, claims: Mapping[str, sp.Expr]) -> dict[str, Any]:
    """The claims that are functions on the field, inside the door.

    One that holds coordinates is rewritten in the invariants, where that is possible; one that
    holds the time is left out.
    """
    plain, other = {}, {}
    for name, expr in claims.items():
        if field.level == "coordinates" or not motions.holds_coordinate([expr]):
            plain[name] = motions.at(field.level).read(expr)
        else:
            other[name] = motions.on_coordinates.read(expr)
    found = plain | _descended(motions, other)
    return {k: found[k] for k in claims if k in found and found[k].diff(field.time) == 0}


def _descended(motions: Motions, functions: Mapping[str, Any]) -> dict[str, Any]:
    """Functions of coordinates and velocities as functions of invariants and velocities, where
    elimination finds them as such."""
    if not functions:
        return {}
    definition, door = motions.equations.definition, motions.equations.door
    inside = [door.inward(g) for g in motions.system.invariants.values()]
    tags = [door.inward(s) for s in motions.system.invariant_symbols]
    ideal = [*definition.relations, *(g - t for g, t in zip(inside, tags, strict=True))]
    found = {}
    for name, function in functions.items():
        try:
            (target,) = canonical([function], definition.relations)
            ring = Ring([target, *inside, *tags, *definition.velocities], ideal)
            element = ring.fraction(target)
        except EngineLimit:
            continue
        moving = {*definition.coordinates}
        bound = [i for i, e in enumerate(ring.meaning) if e.free_symbols & moving]
        parts = [element.num, *(f for f, _ in ring.field.factors(element.den))]
        if not any(f != 0 and f.degrees()[i] for f in parts for i in bound):
            found[name] = expression(ring, element)
    return found

"""Generalized forces: what is declared along velocities acts along the coordinates.

A force Q along a velocity w = e_a qdot_a + e does the work Q w; on a virtual displacement e does
none, so along the coordinate q_a the force is Q e_a.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.symbols import names_in, plain_name, velocity
from voronec.declaration.reading import shown
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.declaration.system import System

__all__ = ["along_coordinates", "check_forces"]


def along_coordinates(system: System) -> Mapping[Any, sp.Expr]:
    """The forces of a system with those along velocities, quasi ones and expressions affine in
    velocities, spread over the coordinates; what is no velocity stays for ``check_forces``."""
    if system.on_group:
        return system.forces
    frame = system.frame
    spelled = dict(zip(frame.velocities, frame.expressions, strict=True)) if frame else {}
    found: dict[Any, sp.Expr] = {}
    for direction, force in system.forces.items():
        shares = _shares(direction, system.coordinates, spelled)
        for q, share in (shares or {direction: sp.Integer(1)}).items():
            found[q] = found.get(q, sp.Integer(0)) + share * force
    return found


def _shares(
    direction: Any, coordinates: tuple[sp.Expr, ...], spelled: Mapping[sp.Expr, sp.Expr]
) -> dict[sp.Expr, sp.Expr]:
    """The coefficients of a velocity by coordinate; none where it is no velocity."""
    if direction in coordinates or not isinstance(direction, sp.Expr):
        return {}
    written = direction.xreplace(spelled)
    dots = {q: velocity(q) for q in coordinates}
    shares = {q: written.diff(dot) for q, dot in dots.items()}
    if any(names_in(share) & {*dots.values()} for share in shares.values()):
        return {}
    return {q: share for q, share in shares.items() if share != 0}


def check_forces(system: System) -> None:
    """Forces act along coordinates and velocities; on a group along the fields of its frame."""
    one, all_of = "neither a coordinate nor a velocity", "coordinates"
    if system.on_group:
        one, all_of = "not a velocity of the frame", "these"
    for direction in system.forces:
        if direction not in system.directions:
            listed = ", ".join(f"'{plain_name(q)}'" for q in system.directions)
            if not system.on_group:
                listed += ", velocities " + ", ".join(
                    f"'{plain_name(v)}'"
                    for v in dict.fromkeys((*system.velocities, *map(velocity, system.coordinates)))
                )
            raise DefinitionError(
                f"system '{system.name}': a force is given for '{shown(direction)}', which is "
                f"{one}; {all_of} are {listed}"
            )

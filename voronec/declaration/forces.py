"""Generalized forces: what is declared along velocities acts along the coordinates.

A force Q along a velocity w = e_a qdot_a + e does the work Q w; on a virtual displacement e does
none, so along the coordinate q_a the force is Q e_a.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from voronec.algebra.symbols import names_in, velocity
from voronec.declaration.geometry import Frame

__all__ = ["along_coordinates"]


def along_coordinates(
    forces: Mapping[Any, sp.Expr], coordinates: tuple[sp.Expr, ...], frame: Frame | None
) -> Mapping[Any, sp.Expr]:
    """Forces with those along velocities, quasi ones and expressions affine in velocities, spread
    over the coordinates; what is no velocity stays."""
    spelled = dict(zip(frame.velocities, frame.expressions, strict=True)) if frame else {}
    found: dict[Any, sp.Expr] = {}
    for direction, force in forces.items():
        shares = _shares(direction, coordinates, spelled)
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

"""A body turned so that a vector known along its moving frame points upwards in space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy as sp

from voronec.quadratures import Space

__all__ = ["turned_upright"]

ACROSS = sp.ImmutableMatrix([[0, 0, 1], [1, 0, 0], [0, 1, 0]])
"""A position in which no coordinate of a contact is singular, for a vector that is zero."""


def turned_upright(space: Space, vector: Sequence[sp.Expr]) -> dict[Any, sp.Expr]:
    """Coordinates in space for which a vector, given along the moving frame, points upwards.

    The frame has the vector's direction as its third row; its second row is level, so that the
    longitude of a contact in space is zero.
    """
    entries: Mapping[Any, sp.Expr] = dict(zip(space.entries, _frame(*vector), strict=True))
    return {q: e.xreplace(entries) for q, e in space.coordinates.items()}


def _frame(a: sp.Expr, b: sp.Expr, c: sp.Expr) -> sp.Matrix:
    level = sp.expand(a**2 + b**2)
    size = sp.expand(level + c**2)
    if size == 0:
        return ACROSS
    third = sp.Matrix([[a, b, c]]) / sp.sqrt(size)
    second = sp.Matrix([[-b, a, 0]]) / sp.sqrt(level) if level != 0 else sp.Matrix([[0, 1, 0]])
    return sp.Matrix.vstack(second.cross(third), second, third)

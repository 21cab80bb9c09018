"""An Ehresmann connection, from nothing but the lift of the base: horizontal parts, brackets.

Vector fields are given by their components along the coordinates; the brackets of a formula,
``[X, Y]``, are their commutator.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp


@dataclass(frozen=True)
class Field:
    """A vector field on the space of the coordinates."""

    coordinates: tuple[sp.Symbol, ...]
    components: tuple[sp.Expr, ...]

    def along(self, value: Any) -> sp.Expr:
        """The derivative of a function along the field."""
        pairs = zip(self.components, self.coordinates, strict=True)
        return sp.Add(*[c * sp.diff(value, q) for c, q in pairs])

    def cross(self, other: Field) -> Field:
        """[X, Y]: the bracket in which a formula encloses two fields."""
        pairs = zip(self.components, other.components, strict=True)
        components = (self.along(b) - other.along(a) for a, b in pairs)
        return Field(self.coordinates, tuple(components))


@dataclass(frozen=True)
class Connection:
    """``lift``: row s holds the components of d/dt q_s along the velocities of the base."""

    coordinates: tuple[sp.Symbol, ...]
    lift: sp.Matrix

    @property
    def base(self) -> int:
        """n, the dimension of the base."""
        return int(self.lift.cols)

    def field(self, components: Sequence[sp.Expr]) -> Field:
        """A field with these components."""
        return Field(self.coordinates, tuple(components))

    def horizontal(self, value: Any) -> Any:
        """The horizontal part of a field, or of a vector."""
        found = list(self.lift * sp.Matrix(components_of(value)[: self.base]))
        return self.field(found) if isinstance(value, Field) else sp.Matrix(found)

    def vertical(self, value: Any) -> sp.Matrix:
        """The vertical part of a field, or of a vector: A(X)."""
        whole = sp.Matrix(components_of(value))
        return whole - sp.Matrix(components_of(self.horizontal(value)))

    def bracket(self, i: int, j: int) -> sp.Matrix:
        """The vertical part of [h_i, h_j], i and j from 1; h_i is the lift of d/dq_i."""
        return self._brackets[i - 1][j - 1]

    @cached_property
    def _brackets(self) -> list[list[sp.Matrix]]:
        lifts = [self.field(list(self.lift[:, k])) for k in range(self.base)]
        return [[self.vertical(a.cross(b)) for b in lifts] for a in lifts]

    def curvature(self, x: Any, y: Any) -> sp.Matrix:
        """sum X_i Y_j times the vertical part of [h_i, h_j]: what A makes of [X^h, Y^h]."""
        a, b = components_of(x), components_of(y)
        total = sp.zeros(len(self.coordinates), 1)
        for i in range(self.base):
            for j in range(self.base):
                total += a[i] * b[j] * self.bracket(i + 1, j + 1)
        return total


def components_of(value: Any) -> list[sp.Expr]:
    """The components of a field or of a vector."""
    return list(value.components if isinstance(value, Field) else value)

"""What the proofs of a motion by quadratures stand on: its symbols as functions of the state.

Integrals of coordinates in space hold on upright data, where the vector of ``Space`` lies along the
third axis: there m = G E^T e_3, which is solved for the velocities.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.angles import Angles
from voronec.algebra.elimination import solve_linear
from voronec.algebra.verdicts import Verdict
from voronec.analysis.decision import all_zero
from voronec.errors import EngineLimit
from voronec.quadratures import Quadratures
from voronec.vector_field import VectorField

__all__ = ["Ground", "Residuals"]

LENGTH = se.Symbol("length of the vector")

Residuals = list[tuple[str, Any]]


@dataclass(frozen=True)
class Ground:
    """A declaration, and the field on the coordinates from which it has to follow."""

    field: VectorField
    motion: Quadratures

    @cached_property
    def level(self) -> dict[Any, Any]:
        """The variable and the constants as functions of the state."""
        read, door = self.field.read, self.field.door
        given = (*self.motion.variable.items(), *self.motion.constants.items())
        return {door.inward(symbol): read(meaning) for symbol, meaning in given}

    def on_level(self, expr: sp.Expr) -> Any:
        """A function of the variable, constants and parameters as one of the state."""
        return self.at_level(self.field.door.inward(expr))

    def at_level(self, expr: Any) -> Any:
        """The same of an expression inside the door."""
        return self.field.express(expr.xreplace(self.level))

    @cached_property
    def pace(self) -> Any:
        """dt/dtau as a function of the state."""
        return self.on_level(self.motion.clock)

    @cached_property
    def run(self) -> Any:
        """dx/dtau as a function of the state."""
        return self.field.derivative(self.field.read(self.motion.meaning)) * self.pace

    def data_for(self, q: sp.Expr) -> Callable[[Any], Any]:
        """How functions of the state are read in a claim about a coordinate: as they are, or, for
        one in space, on upright data."""
        space = self.motion.space
        if space is None or q not in space.coordinates:
            return lambda expr: expr
        return self.upright

    @cached_property
    def angles(self) -> Angles:
        """Where the colatitudes of traces are between their poles, and the vector has a length."""
        sines = [se.sin(self.field.read(t.colatitude)) for t in self.motion.traces]
        return Angles(self.field.relations, (LENGTH, *sines))

    @cached_property
    def _upright(self) -> dict[Any, Any]:
        """The velocities on upright data."""
        space, field = self.motion.space, self.field
        assert space is not None
        vector = [field.read(e) for e in space.vector]
        third = [field.read(e) for e in space.frame.row(2)]
        rest = dict.fromkeys(field.velocities, se.Integer(0))
        matrix = [[m.diff(v) for v in field.velocities] for m in vector]
        right = [[LENGTH * e - m.xreplace(rest)] for e, m in zip(third, vector, strict=True)]
        solution = solve_linear(matrix, right, field.hypotheses)
        if solution.free or len(field.velocities) != len(vector):
            raise EngineLimit("the vector of the space does not determine the velocities")
        values = [row[0] for row in solution.values]
        return dict(zip(field.velocities, values, strict=True))

    def upright(self, expr: Any) -> Any:
        """A function of the state on upright data."""
        return self.angles.resolved(expr.xreplace(self._upright))

    def zero(self, residuals: Residuals) -> Verdict:
        """Whether all residuals vanish."""
        return all_zero(residuals, self.field.hypotheses)

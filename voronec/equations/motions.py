"""The motions of a system on two levels: its coordinates and, where it descends, its invariants."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from voronec.algebra.text import as_expression
from voronec.declaration.geometry import moving_names
from voronec.declaration.system import System
from voronec.equations.reduction import Reduction, descend
from voronec.equations.vector_field import VectorField, for_numbers, on_coordinates
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit, VoronecError


@dataclass(frozen=True)
class Motions:
    """The motion of one system on both levels, each made when it is asked for."""

    equations: VoronecEquations

    @classmethod
    def of(cls, system: System | VoronecEquations) -> Motions:
        """Derive the equations; what is made here is kept with them."""
        equations = system if isinstance(system, VoronecEquations) else derive(system)
        return equations.memo.once("motions", lambda: cls(equations))

    @property
    def system(self) -> System:
        """The system."""
        return self.equations.system

    @cached_property
    def _descent(self) -> Reduction | VoronecError:
        """The descent, or why there is none: it is tried once."""
        try:
            return descend(self.equations)
        except (DefinitionError, EngineLimit) as refusal:
            return refusal

    @property
    def reduction(self) -> Reduction:
        """The descent to the declared invariants; raises as ``descend`` does."""
        if isinstance(self._descent, VoronecError):
            raise self._descent
        return self._descent

    @property
    def on_coordinates(self) -> VectorField:
        """The field on coordinates and velocities."""
        return on_coordinates(self.equations)

    @property
    def for_numbers(self) -> VectorField:
        """The field on coordinates, without normal forms where these would be too large to be of
        use."""
        return for_numbers(self.equations)

    @cached_property
    def on_invariants(self) -> VectorField:
        """The field on invariants and velocities."""
        reduction, bridge = self.reduction, self.equations.bridge
        definition = self.equations.definition
        return VectorField(
            system=self.system,
            level="invariants",
            bridge=bridge,
            positions=tuple(bridge.inward(g) for g in reduction.invariants),
            velocities=definition.velocities,
            time=definition.time,
            parameters=definition.parameters,
            rates=tuple(bridge.inward_all(reduction.rates)),
            mass=tuple(
                tuple(bridge.inward_all(reduction.mass.row(i))) for i in range(reduction.mass.rows)
            ),
            force=tuple(bridge.inward_all(reduction.force)),
            relations=tuple(bridge.inward_all(reduction.relations)),
            meaning={},
            determinant=definition.determinant,
            conditions=definition.conditions,
        )

    def at(self, level: str) -> VectorField:
        """The field on ``coordinates`` or on ``invariants``."""
        return self.on_invariants if level == "invariants" else self.on_coordinates

    def holds_coordinate(self, exprs: Iterable[sp.Expr]) -> bool:
        """Whether any of the expressions holds what has no meaning on the invariants: a
        coordinate, a velocity that is none of the equations, a named momentum."""
        names = moving_names(self.system.coordinates, self.system.frame)
        moving = {*names} - {*self.system.velocities}
        return any(as_expression(e).has(*moving) for e in exprs)

    def field_for(self, exprs: Sequence[sp.Expr]) -> VectorField:
        """The field on which a claim about these functions is decided: the reduced one, where they
        hold no coordinate and the system descends to its invariants."""
        low = not self.system.invariants or self.holds_coordinate(exprs)
        if low or isinstance(self._descent, VoronecError):
            return self.on_coordinates
        return self.on_invariants

"""The motion of a system as a vector field: on coordinates and velocities, or on invariants.

    positions' = rates,   mass * velocities' = force

Claims and relations are statements about such fields.  Everything here is inside the door.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.door import Door
from voronec.algebra.elimination import solve_linear
from voronec.algebra.symbols import velocity
from voronec.equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit
from voronec.reduction import Reduction, descend
from voronec.system import System

__all__ = ["Motions", "VectorField"]


@dataclass(frozen=True)
class VectorField:
    """A field on ``variables``, positions before velocities, where ``relations`` vanish.

    ``meaning`` says what other symbols stand for: velocities of coordinates in terms of the state,
    and, on the coordinates, the invariants.  ``level`` is ``coordinates`` or ``invariants``.
    """

    system: System
    level: str
    door: Door
    positions: tuple[Any, ...]
    velocities: tuple[Any, ...]
    time: Any
    parameters: tuple[Any, ...]
    rates: tuple[Any, ...]
    mass: tuple[tuple[Any, ...], ...]
    force: tuple[Any, ...]
    relations: tuple[Any, ...]
    meaning: dict[Any, Any]

    @property
    def variables(self) -> tuple[Any, ...]:
        """Positions, then velocities."""
        return self.positions + self.velocities

    @property
    def dimension(self) -> int:
        """How many of the variables are independent, where relations are."""
        return len(self.variables) - len(self.relations)

    def read(self, expr: sp.Expr) -> Any:
        """A function of the state, from the user's symbols."""
        return self.express(self.door.inward(expr))

    def express(self, expr: Any) -> Any:
        """A function inside the door, with everything that has a meaning spelled out."""
        return expr.xreplace(self.meaning)

    def solve(self, columns: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """mass^-1 times the columns of a matrix given by rows."""
        if not self.velocities:
            return []
        return solve_linear(self.mass, columns, self.relations).values

    @cached_property
    def accelerations(self) -> tuple[Any, ...]:
        """velocities' = mass^-1 force."""
        return tuple(row[0] for row in self.solve([[f] for f in self.force]))

    @property
    def components(self) -> tuple[Any, ...]:
        """The rates of all variables."""
        return self.rates + self.accelerations

    def derivative(self, function: Any) -> Any:
        """d/dt along the motion.

        dF/dv . mass^-1 force is computed as y . force with mass y = dF/dv [Theory, eq. (13)].
        """
        gradient = [[function.diff(v)] for v in self.velocities]
        pushed: list[Any] = []
        if any(g[0] != 0 for g in gradient):
            solved = self.solve(gradient)
            pushed = [row[0] * f for row, f in zip(solved, self.force, strict=True)]
        moved = [
            rate * function.diff(q) for q, rate in zip(self.positions, self.rates, strict=True)
        ]
        return se.Add(function.diff(self.time), *moved, *pushed)


@dataclass(frozen=True)
class Motions:
    """The motion of one system on both levels, each made when it is asked for."""

    equations: VoronecEquations

    @classmethod
    def of(cls, system: System | VoronecEquations) -> Motions:
        """Derive the equations."""
        return cls(derive(system) if isinstance(system, System) else system)

    @property
    def system(self) -> System:
        """The system."""
        return self.equations.system

    @cached_property
    def reduction(self) -> Reduction:
        """The descent to the declared invariants; raises as ``descend`` does."""
        return descend(self.equations)

    @cached_property
    def on_coordinates(self) -> VectorField:
        """The field on coordinates and velocities."""
        d, door = self.equations.best, self.equations.door
        own = d.definition
        rates = tuple(d.rates)
        meaning = dict(zip(own.coordinate_velocities, rates, strict=True))
        for v in own.velocities:
            meaning.pop(v, None)
        for name, g in self.system.invariants.items():
            meaning[se.Symbol(name)] = door.inward(g)
        return VectorField(
            system=self.system,
            level="coordinates",
            door=door,
            positions=own.coordinates,
            velocities=own.velocities,
            time=own.time,
            parameters=own.parameters,
            rates=rates,
            mass=tuple(map(tuple, d.mass)),
            force=tuple(d.force),
            relations=own.relations,
            meaning=meaning,
        )

    @cached_property
    def on_invariants(self) -> VectorField:
        """The field on invariants and velocities."""
        found, door = self.reduction, self.equations.door
        own = self.equations.definition
        return VectorField(
            system=self.system,
            level="invariants",
            door=door,
            positions=tuple(door.inward(g) for g in found.invariants),
            velocities=own.velocities,
            time=own.time,
            parameters=own.parameters,
            rates=tuple(door.inward_all(found.rates)),
            mass=tuple(tuple(door.inward_all(found.mass.row(i))) for i in range(found.mass.rows)),
            force=tuple(door.inward_all(found.force)),
            relations=tuple(door.inward_all(found.relations)),
            meaning={},
        )

    def at(self, level: str) -> VectorField:
        """The field on ``coordinates`` or on ``invariants``."""
        return self.on_invariants if level == "invariants" else self.on_coordinates

    def holds_coordinate(self, exprs: Iterable[sp.Expr]) -> bool:
        """Whether any of the expressions holds a coordinate, or a velocity of one that is not a
        velocity of the equations."""
        own = set(self.system.velocities)
        moving = {*self.system.coordinates, *map(velocity, self.system.coordinates)} - own
        return any(sp.sympify(e).has(*moving) for e in exprs)

    def deciding(self, exprs: Sequence[sp.Expr]) -> VectorField:
        """The field on which a claim about these functions is decided: the reduced one, where they
        hold no coordinate and the system descends to its invariants."""
        if not self.system.invariants or self.holds_coordinate(exprs):
            return self.on_coordinates
        try:
            return self.on_invariants
        except (DefinitionError, EngineLimit):
            return self.on_coordinates

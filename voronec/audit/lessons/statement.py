"""A problem as every method finds it: Lagrangian, forces, constraints, velocities in use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.normal import canonical, shortest
from voronec.algebra.symbols import velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.typeset import caret_text
from voronec.declaration.system import System
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError

Vector = list[Any]
LONGEST = 600
"""How many characters a formula has that is printed whole."""


@dataclass(frozen=True)
class Statement:
    """L(q, qdot, t), forces Q, constraints A qdot + a0 = 0, velocities v = W qdot + w0, inside the
    door.  ``qdd`` and ``vd`` are the symbols of accelerations.
    """

    equations: VoronecEquations
    q: tuple[Any, ...]
    qd: tuple[Any, ...]
    qdd: tuple[Any, ...]
    v: tuple[Any, ...]
    vd: tuple[Any, ...]
    time: Any
    lagrangian: Any
    forces: tuple[Any, ...]
    constraint_rows: tuple[tuple[Any, ...], ...]
    constraint_offsets: tuple[Any, ...]
    frame_rows: tuple[tuple[Any, ...], ...]
    frame_offsets: tuple[Any, ...]

    @classmethod
    def of(cls, system: System | VoronecEquations) -> Statement:
        """Read from a system; one with redundant coordinates, on a group, or with forces that hold
        accelerations is refused."""
        equations = system if isinstance(system, VoronecEquations) else derive(system)
        definition, bridge, declared = equations.definition, equations.bridge, equations.system
        if definition.group is not None or definition.relations or definition.added:
            raise DefinitionError(
                f"system '{declared.name}': the methods are compared in independent coordinates, "
                "with forces that hold no acceleration; choose another system"
            )
        count = len(definition.coordinates)
        unit = tuple(
            tuple(se.Integer(int(a == b)) for b in range(count)) for a in range(definition.base)
        )
        frame = definition.frame
        return cls(
            equations=equations,
            q=definition.coordinates,
            qd=definition.dots,
            qdd=tuple(bridge.admit(velocity(velocity(q))) for q in declared.coordinates),
            v=definition.velocities,
            vd=tuple(bridge.admit(velocity(v)) for v in declared.velocities),
            time=definition.time,
            lagrangian=definition.lagrangian,
            forces=definition.forces,
            constraint_rows=definition.constraints.matrix,
            constraint_offsets=definition.constraints.offset,
            frame_rows=unit if frame is None else frame.matrix,
            frame_offsets=(se.Integer(0),) * definition.base if frame is None else frame.offset,
        )

    @property
    def bridge(self) -> SymPyBridge:
        """Between the user's symbols and those inside."""
        return self.equations.bridge

    @property
    def base(self) -> range:
        """Positions of the base coordinates."""
        return range(len(self.v))

    @property
    def fibre(self) -> range:
        """Positions of the fibre coordinates."""
        return range(len(self.v), len(self.q))

    @property
    def hypotheses(self) -> tuple[Any, ...]:
        """What is known of parameters."""
        return self.equations.definition.conditions

    @cached_property
    def forms(self) -> list[Vector]:
        """The rows of W, then those of A."""
        return [*map(list, self.frame_rows), *map(list, self.constraint_rows)]

    @cached_property
    def inverse(self) -> tuple[list[Vector], Vector]:
        """X and x0 of qdot = X omega + x0, where omega are all forms: v, then the constraints."""
        size = range(len(self.q))
        offsets = [*self.frame_offsets, *self.constraint_offsets]
        right = [[*(se.Integer(int(a == b)) for b in size), -offsets[a]] for a in size]
        solved = solve_linear(self.forms, right).values
        flat = canonical([e for row in solved for e in row])
        rows = [flat[k * (len(size) + 1) : (k + 1) * (len(size) + 1)] for k in size]
        return [row[:-1] for row in rows], [row[-1] for row in rows]

    @cached_property
    def rates(self) -> dict[Any, Any]:
        """qdot -> its value in v, on the constraints."""
        matrix, offset = self.inverse
        pairs = zip(self.qd, matrix, offset, strict=True)
        return {
            dot: se.Add(row0, *[row[i] * v for i, v in enumerate(self.v)])
            for dot, row, row0 in pairs
        }

    @cached_property
    def accelerations(self) -> dict[Any, Any]:
        """qddot -> its value in v and vdot."""
        return {a: self.rate(self.rates[dot]) for a, dot in zip(self.qdd, self.qd, strict=True)}

    def rate(self, function: Any) -> Any:
        """d/dt of a function of q, v and t, with vdot."""
        rates = [self.rates[dot] for dot in self.qd]
        return self._derivative(function, (*self.q, *self.v), (*rates, *self.vd))

    def free_rate(self, function: Any) -> Any:
        """d/dt of a function of q, qdot and t, with qddot."""
        return self._derivative(function, (*self.q, *self.qd), (*self.qd, *self.qdd))

    def _derivative(self, function: Any, variables: Sequence[Any], rates: Sequence[Any]) -> Any:
        """d/dt of a function of variables that change at these rates, and of t."""
        terms = [function.diff(x) * rate for x, rate in zip(variables, rates, strict=True)]
        return se.Add(function.diff(self.time), *terms)

    def in_velocities(self, function: Any) -> Any:
        """A function of q, qdot, qddot as one of q, v, vdot."""
        return function.xreplace(self.accelerations).xreplace(self.rates)

    def along(self, index: int, components: Sequence[Any]) -> Any:
        """The sum of components along the coordinates with those of the field X_index."""
        matrix, _ = self.inverse
        return se.Add(*[row[index] * c for row, c in zip(matrix, components, strict=True)])

    def tidy(self, exprs: Sequence[Any]) -> Vector:
        """Normal forms."""
        return canonical(list(exprs))

    def texts(self, exprs: Sequence[Any]) -> list[str]:
        """Formulas for print, in their shortest form."""
        return [self.text(e) for e in shortest(list(exprs), (), self.v)]

    def text(self, expr: Any) -> str:
        """A formula for print as it stands; one too long for a page is told by its length."""
        printed = caret_text(self.bridge.outward(expr))
        return printed if len(printed) <= LONGEST else f"an expression of {len(printed)} characters"

"""Equations in the form that SymPy's mechanics and PyDy know: mass matrices, forcing, speeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.symbols import plain_name, time, velocity
from voronec.equations.derived_equations import DerivedEquations
from voronec.equations.linearisation import linearise
from voronec.equations.vector_field import for_numbers


@dataclass(frozen=True, repr=False)
class MechanicsForm:
    """What ``KanesMethod`` offers after ``kanes_equations``, made of derived equations.

    All names of what moves are functions of the time, as ``dynamicsymbols`` makes them.  The speeds
    ``u`` are the independent velocities alone, n of them; the coordinates ``q`` are all, base then
    fibre, k of them.

        qdot = rates(q, u, t),   mass_matrix * udot = forcing(q, u, t)

    ``mass_matrix`` is n x n, ``forcing`` n x 1; ``mass_matrix_full`` and ``forcing_full``, (k + n)
    x (k + n) and (k + n) x 1, are those of both equations together.  PyDy's ``System`` takes it
    where it takes a ``KanesMethod``.
    """

    equations: DerivedEquations

    @cached_property
    def q(self) -> sp.Matrix:
        """The coordinates, k x 1."""
        return sp.Matrix([self._names[q] for q in self.equations.coordinates])

    @cached_property
    def u(self) -> sp.Matrix:
        """The independent speeds, n x 1."""
        return sp.Matrix([self._names[v] for v in self.equations.velocities])

    @property
    def coordinates(self) -> list[sp.Expr]:
        """The coordinates, as a list."""
        return [*self.q]

    @property
    def speeds(self) -> list[sp.Expr]:
        """The independent speeds, as a list."""
        return [*self.u]

    @property
    def constants(self) -> dict[sp.Symbol, float]:
        """Parameter -> its default value, for those that have one."""
        given = (p for p in self.equations.system.parameters if p.value is not None)
        return {p.symbol: float(p.value) for p in given}

    @cached_property
    def mass_matrix(self) -> sp.Matrix:
        """The mass matrix, n x n."""
        return self._name_rates(self.equations.mass)

    @cached_property
    def forcing(self) -> sp.Matrix:
        """The right side of mass_matrix * udot = forcing, n x 1."""
        return self._name_rates(self.equations.force)

    @property
    def mass_matrix_full(self) -> sp.Matrix:
        """That of the rates of coordinates and speeds together."""
        return sp.diag(sp.eye(len(self.q)), self.mass_matrix)

    @property
    def forcing_full(self) -> sp.Matrix:
        """The right side of mass_matrix_full * (qdot, udot) = forcing_full."""
        return sp.Matrix([self._rates, self.forcing])

    def rhs(self) -> sp.Matrix:
        """(qdot, udot) solved for, (k + n) x 1."""
        equations = self.equations
        solved = [[a] for a in for_numbers(equations).accelerations]
        return sp.Matrix([self._rates, self._name_rates(equations.bridge.outward_matrix(solved))])

    def linearize(
        self,
        op_point: Mapping[sp.Expr, Any] | None = None,
        A_and_B: bool = True,
        new_method: Any = None,
        linear_solver: Any = None,
        simplify: Any = False,
    ) -> tuple[sp.Matrix, ...]:
        """A, B and the inputs of dx/dt = A dx + B dw about a point, x the independent coordinates
        and the speeds; with ``A_and_B`` false a unit matrix before them.

        ``op_point`` gives coordinates and speeds as for ``KanesMethod.linearize``; their rates
        follow from the equations, and are not read; nor are the last three arguments, with which
        SymPy is told how to compute.
        """
        names = {name: x for x, name in self._names.items()}
        given = (op_point or {}).items()
        at = {names.get(x, x): value for x, value in given if not isinstance(x, sp.Derivative)}
        linearisation = linearise(self.equations, at)
        inputs = sp.Matrix([self._names.get(w, w) for w in linearisation.inputs])
        parts = (self._name_rates(linearisation.A), self._name_rates(linearisation.B), inputs)
        return parts if A_and_B else (sp.eye(len(linearisation.state)), *parts)

    def kindiffdict(self) -> dict[sp.Expr, sp.Expr]:
        """The rate of each coordinate -> what it is in terms of the speeds."""
        return dict(zip(self._qdot, self._rates, strict=True))

    @property
    def _qdot(self) -> sp.Matrix:  # PyDy asks for it by this name, as for the next two
        return self.q.diff(time)

    @property
    def _udot(self) -> sp.Matrix:
        return self.u.diff(time)

    @property
    def _uaux(self) -> sp.Matrix:
        return sp.Matrix()

    @cached_property
    def _rates(self) -> sp.Matrix:
        return self._name_rates(self.equations.rates)

    @cached_property
    def _names(self) -> Mapping[sp.Expr, sp.Expr]:
        """Each variable -> a function of the time by its name; inputs are such functions, too."""
        system = self.equations.system
        moving = (*system.coordinates, *system.velocities, *system.inputs)
        named = {x: sp.Function(plain_name(x))(time) for x in moving}
        return {x: x if isinstance(x, AppliedUndef) else f for x, f in named.items()}

    def _name_rates(self, matrix: Any) -> sp.Matrix:
        """A matrix in functions of the time: rates of inputs first, which hold the inputs."""
        inputs = self.equations.system.inputs
        rates = {velocity(i): self._names[i].diff(time) for i in inputs}
        return sp.Matrix(matrix.xreplace(rates).xreplace(dict(self._names)))

    def __repr__(self) -> str:
        return f"MechanicsForm(q={[*self.q]}, u={[*self.u]})"

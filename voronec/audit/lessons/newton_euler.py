"""The method of Newton and Euler: momentum balances of free bodies, with reactions.

m dv/dt = F + R,    dK/dt + turning x K = M + N,    K = I omega         for each body,

and the reactions (R, N) of all bodies together do no work in any motion that the constraints admit:
with J the derivatives of the bodies' velocities by those in use, J^T (R, N) = 0.  A basis of what
J^T annihilates gives each reaction a factor; some of the balances give the factors, and these, put
into the others, leave as many equations as there are velocities.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import determinant
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.rank import independent_rows
from voronec.algebra.tape import Tape
from voronec.audit.lessons.statement import Statement, Vector
from voronec.declaration.bodies import Body
from voronec.errors import DefinitionError

NAMES = ("moment 1", "moment 2", "moment 3", "x", "y", "z")


@dataclass(frozen=True)
class FreeBodies:
    """The balances of all bodies of a problem, six for each: moments, then momenta.

    Those of components in which nothing moves and nothing acts are left out.
    """

    problem: Statement

    @cached_property
    def _components(self) -> list[tuple[str, Any, Any, Any]]:
        """Name, velocity, rate of the momentum, and what acts."""
        components = []
        for body in self.problem.equations.system.bodies:
            omega, moved = self._inward(body.omega), self._inward(body.velocity)
            rates = [*self._moment_rates(body, omega), *self._momentum_rates(body, moved)]
            acting = [*self._inward(body.torque), *self._inward(body.force)]
            parts = zip(NAMES, [*omega, *moved], rates, acting, strict=True)
            components += [(f"{body.title}, {name}", *rest) for name, *rest in parts]
        return [c for c in components if any(e != 0 for e in c[1:])]

    def _inward(self, values: Sequence[Any]) -> Vector:
        """Expressions in the engine's symbols, with the velocities in use for those of
        coordinates."""
        return [self.problem.bridge.inward(e).xreplace(self.problem.rates) for e in values]

    def _moment_rates(self, body: Body, omega: Vector) -> Vector:
        """dK/dt + turning x K."""
        entries = self._inward(tuple(body.inertia))
        moment = [se.Add(*[entries[3 * i + j] * omega[j] for j in range(3)]) for i in range(3)]
        turning = self._inward(body.turning or body.omega)
        pairs = ((1, 2), (2, 0), (0, 1))
        return [
            self.problem.rate(moment[i]) + turning[j] * moment[k] - turning[k] * moment[j]
            for i, (j, k) in enumerate(pairs)
        ]

    def _momentum_rates(self, body: Body, moved: Vector) -> Vector:
        (mass,) = self._inward([body.mass])
        return [self.problem.rate(mass * e) for e in moved]

    @property
    def names(self) -> list[str]:
        """Of the balances: the body, and about or along which axis."""
        return [c[0] for c in self._components]

    @cached_property
    def inertias(self) -> Vector:
        """The rates of momenta and moments, in q, v and vdot."""
        return [c[2] for c in self._components]

    @cached_property
    def active(self) -> Vector:
        """Forces and torques without the reactions."""
        return [c[3] for c in self._components]

    @cached_property
    def partial(self) -> list[Vector]:
        """J: the derivatives of the bodies' velocities by the velocities in use, row by row."""
        rows = [[c[1].diff(v) for v in self.problem.v] for c in self._components]
        flat, width = self.problem.tidy([e for row in rows for e in row]), len(self.problem.v)
        return [flat[i : i + width] for i in range(0, len(flat), width)]

    @cached_property
    def free(self) -> list[int]:
        """Positions of as many balances as there are velocities, whose rows of J determine the
        others'."""
        width, tape = len(self.problem.v), Tape([e for row in self.partial for e in row])
        samples = sample_evaluable(tape, (), GENERIC, count=1)
        values = samples[0][1] if samples else []
        table = [values[i : i + width] for i in range(0, len(values), width)]
        kept = independent_rows(table, GENERIC)
        if len(kept) < width:
            name = self.problem.equations.system.name
            raise DefinitionError(
                f"system '{name}': the bodies rest while a velocity in use does not; declare the "
                "bodies that it moves, or none"
            )
        return kept

    @cached_property
    def bound(self) -> list[int]:
        """Positions of the other balances, each of which gives the factor of one reaction."""
        return [i for i in range(len(self.partial)) if i not in self.free]

    @cached_property
    def shares(self) -> list[Vector]:
        """S: J of the bound balances is S times J of the free ones."""
        if not self.bound:
            return []
        matrix = [[self.partial[f][r] for f in self.free] for r in self.problem.base]
        columns = [[self.partial[b][r] for b in self.bound] for r in self.problem.base]
        solved = solve_linear(matrix, columns).values
        return [self.problem.tidy([row[k] for row in solved]) for k in range(len(self.bound))]

    @cached_property
    def reactions(self) -> Vector:
        """The reaction in each balance, a sum with the factors N1, N2, ...; those of one factor are
        multiplied by the determinant of J of the free balances, so that nothing is divided."""
        sums: Vector = [se.Integer(0)] * len(self.partial)
        scale = determinant([self.partial[f] for f in self.free])
        for k, place in enumerate(self.bound):
            factor = se.Symbol(f"N{k + 1}")
            one = se.Integer(1) if all(e == 0 for e in self.shares[k]) else scale
            whole = self.problem.tidy([one, *[-one * e for e in self.shares[k]]])
            for position, e in zip([place, *self.free], whole, strict=True):
                sums[position] += e * factor
        return sums

    @cached_property
    def residual(self) -> Vector:
        """What the free balances say when the factors are put in, along the velocities in use; it
        vanishes."""
        rest = [a - f for a, f in zip(self.inertias, self.active, strict=True)]
        pairs = [*zip(self.shares, self.bound, strict=True)]
        balances = [
            rest[f] + se.Add(*[s[i] * rest[b] for s, b in pairs]) for i, f in enumerate(self.free)
        ]
        rows = [self.partial[f] for f in self.free]
        return [
            se.Add(*[row[r] * b for row, b in zip(rows, balances, strict=True)])
            for r in self.problem.base
        ]

"""From a definition to equations of motion, inside the exact algebra.

    d/dt dLc/dv^i - h_i(Lc) + (c_ij^k dLc/dv^k + B_ij^A p_A) v^j = E_i^b Q_b + a_i^A Q_A

[Theory, eq. (9)].  One pipeline, run with one of two ways to tidy intermediate results: not at all
(the shared expression graph, made in milliseconds), or by exact normal forms (short equations).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import symengine as se

from voronec.algebra.matrices import change_entries
from voronec.algebra.normal import Budget, canonical, shortest
from voronec.algebra.shape import operations
from voronec.algebra.terms import subexpressions
from voronec.declaration.reading import quote
from voronec.equations.connection import (
    EhresmannConnection,
    FibreSolution,
    UndeterminedVelocities,
    coordinate_lift,
    dual_rows,
    framed_lift,
    shared_slopes,
)
from voronec.equations.definition import Definition
from voronec.equations.relative_angles import RelativeAngles
from voronec.errors import DefinitionError

FEW = 100
"""So many terms are written of any system."""


@dataclass(frozen=True)
class FirstOrderForm:
    """qdot = rates(q, v, t),  mass * vdot = force(q, v, t), all in symengine.

    ``coordinates`` base then fibre; ``definitions`` gives v in terms of q, qdot, t, with
    ``velocity_symbols`` the symbols of qdot, where qdot has any; ``relations`` vanish along the
    motion.  ``stages`` are pairs (name, expression), in order, that rates, mass and force may use;
    ``dependent`` pairs of the other velocities of a group's frame, and named momenta, with what
    they are; ``positive`` are the parameters that are declared to be positive; ``inputs`` functions
    of the time, which stand here with their derivatives.
    """

    coordinates: tuple[Any, ...]
    velocities: tuple[Any, ...]
    parameters: tuple[Any, ...]
    time: Any
    rates: tuple[Any, ...]
    mass: tuple[tuple[Any, ...], ...]
    force: tuple[Any, ...]
    definitions: tuple[Any, ...] = ()
    velocity_symbols: tuple[Any, ...] = ()
    relations: tuple[Any, ...] = ()
    dependent: tuple[tuple[Any, Any], ...] = ()
    stages: tuple[tuple[Any, Any], ...] = ()
    positive: tuple[Any, ...] = ()
    inputs: tuple[Any, ...] = ()

    @property
    def expressions(self) -> tuple[Any, ...]:
        """Rates, force, and mass row by row; stages are left out."""
        return (*self.rates, *self.force, *(e for row in self.mass for e in row))

    @cached_property
    def operations(self) -> int:
        """How many operations it costs, shared subexpressions counted once."""
        return operations([*(e for _, e in self.stages), *self.expressions])

    @property
    def rates_by_velocity(self) -> dict[Any, Any]:
        """What qdot, where it has symbols, and dependent velocities are, by their symbols."""
        dots = self.velocity_symbols
        return dict(zip(dots, self.rates, strict=bool(dots))) | dict(self.dependent)


@dataclass(frozen=True)
class Derivation:
    """The stages of one derivation, each made when it is asked for."""

    definition: Definition
    exact: bool
    raw: Derivation | None = None

    def tidy(self, exprs: Sequence[Any]) -> list[Any]:
        """Bring intermediate results into normal form, or leave them, as this derivation does."""
        d = self.definition
        normalise = partial(canonical, relations=d.relations, budget=self.budget)
        return self._in_differences(exprs, normalise)

    def polish(self, exprs: Sequence[Any]) -> list[Any]:
        """Bring final results into their shortest form, or leave them, as this derivation does."""
        d = self.definition
        shorten = partial(shortest, relations=d.relations, group=d.velocities, budget=self.budget)
        return self._in_differences(exprs, shorten)

    def _in_differences(self, exprs: Sequence[Any], tidy: Callable[..., list[Any]]) -> list[Any]:
        """Expressions tidied in differences of angles, where there are such."""
        if not self.exact:
            return list(exprs)
        angles = self.relative_angles
        if angles is None:
            return tidy(exprs)
        return [angles.show(e) for e in tidy([angles.hide(se.sympify(e)) for e in exprs])]

    @cached_property
    def budget(self) -> Budget:
        """What a stage of it may cost: no more terms than the raw derivation has operations, than
        which it would hardly come out shorter; some two to a part, which are quicker counted."""
        if self.raw is None:
            return Budget()
        parts = sum(1 for part in subexpressions(self.raw.form.expressions) if part.args)
        return Budget(terms=max(FEW, 2 * parts))

    @cached_property
    def relative_angles(self) -> RelativeAngles | None:
        """The differences of angles in which the equations stand."""
        return RelativeAngles.of(self.raw.form) if self.raw is not None else None

    @cached_property
    def fibre(self) -> FibreSolution:
        """sdot = S rdot + s0."""
        d = self.definition
        *rows, offset = change_entries(self.tidy, [*d.fibre.matrix, d.fibre.offset])
        return FibreSolution(tuple(map(tuple, rows)), tuple(offset))

    @cached_property
    def connection(self) -> EhresmannConnection:
        """The connection in the frame of the system."""
        return self._connect(self.definition.frame is not None)

    @cached_property
    def coordinate_connection(self) -> EhresmannConnection:
        """The connection in the frame of the base velocities."""
        if self.definition.frame is None:
            return self.connection
        return self._connect(False)

    def _connect(self, framed: bool) -> EhresmannConnection:
        d = self.definition
        if framed:
            lift = change_entries(self.tidy, self._framed_lift)
        else:
            lift = coordinate_lift(self.fibre, d.base)
        connection = EhresmannConnection(
            coordinates=d.coordinates,
            base=d.base,
            velocities=d.velocities if framed else d.dots[: d.base],
            time=d.time,
            lift=tuple(tuple(row) for row in lift),
            group=d.group,
        )
        lost = (
            connection.broken_relation(d.relations)
            if d.group is not None and not self.exact
            else None
        )
        if lost is not None:
            raise DefinitionError(
                f"system '{d.system.name}': the motion does not keep the relation "
                f"{quote(d.system.fibration.relations[lost])} = 0; correct it, or the rates"
            )
        return connection

    @cached_property
    def _framed_lift(self) -> list[list[Any]]:
        """The lift as constraints and definitions of velocities were solved for it."""
        d = self.definition
        assert d.frame is not None
        try:
            return framed_lift(d.constraints, d.frame, d.differentiated, d.relations, d.near)
        except UndeterminedVelocities as error:
            raise _frame_error(d, error) from None

    @cached_property
    def dual(self) -> list[list[Any]]:
        """dual[k][b]: the velocities v_k in terms of base velocities."""
        d = self.definition
        if d.frame is None:
            return [row[:-1] for row in coordinate_lift(self.fibre, d.base)[: d.base]]
        return change_entries(self.tidy, dual_rows(d.frame, self.fibre, d.base))

    @cached_property
    def dot_rates(self) -> list[Any]:
        """The velocities in which the Lagrangian is written, in terms of q, v, t."""
        return self.tidy(self.connection.rates)

    @cached_property
    def rates(self) -> list[Any]:
        """qdot in terms of q, v, t."""
        group = self.definition.group
        if group is None:
            return self.dot_rates
        return self.tidy(group.coordinate_rates(self.dot_rates))

    @property
    def dependent(self) -> tuple[tuple[Any, Any], ...]:
        """The velocities of a group that are not independent, with what they are."""
        d = self.definition
        return tuple(zip(d.fibre_velocities, self.dot_rates[d.base :], strict=False))

    @property
    def group_terms(self) -> tuple[tuple[Any, ...], ...]:
        """C_ab^k h_i^a w^b of a group, a row for each i; k over the independent velocities."""
        n = self.definition.base
        if self.definition.group is None:
            return ()
        return tuple(tuple(self._group_terms_of(i)[:n]) for i in range(n))

    @property
    def named_momenta(self) -> tuple[tuple[Any, Any], ...]:
        """The momenta dLc/dv that the frame gives a name, with what they are."""
        return tuple(zip(self.definition.momenta, self.quasi_momenta, strict=False))

    @cached_property
    def _on_constraints(self) -> dict[Any, Any]:
        return dict(zip(self.definition.dots, self.dot_rates, strict=True))

    @cached_property
    def constrained_lagrangian(self) -> Any:
        """Lc(q, v, t), the paper's Theta where there is no potential."""
        d = self.definition
        return self.tidy([d.lagrangian.xreplace(self._on_constraints)])[0]

    @cached_property
    def momenta(self) -> list[Any]:
        """dL/dqdot for every coordinate, on the constraints; the fibre part is K_nu."""
        d = self.definition
        raw = [d.lagrangian.diff(v).xreplace(self._on_constraints) for v in d.dots]
        return self.tidy(raw)

    @cached_property
    def quasi_momenta(self) -> list[Any]:
        """dLc/dv."""
        if not self.exact:
            lift = self.connection.lift
            return [
                se.Add(*[p * row[i] for p, row in zip(self.momenta, lift, strict=True)])
                for i in range(self.connection.n)
            ]
        lc = self.constrained_lagrangian
        return self.tidy([lc.diff(v) for v in self.definition.velocities])

    @cached_property
    def mass(self) -> list[list[Any]]:
        """d2Lc/dv2, less what forces hold of the accelerations: mass * vdot = force, shape (n, n)
        [Theory, eq. (11)]."""
        vs = self.definition.velocities
        n = len(vs)
        upper = [(i, j) for i in range(n) for j in range(i, n)]
        masses = [self.quasi_momenta[i].diff(vs[j]) for i, j in upper]
        if self.definition.added:
            masses = [m - self.added_mass[i][j] for (i, j), m in zip(upper, masses, strict=True)]
        entries = self.polish(masses)
        table = dict(zip(upper, entries, strict=True))
        return [[table[min(i, j), max(i, j)] for j in range(n)] for i in range(n)]

    @cached_property
    def inertia_forces(self) -> list[list[Any]]:
        """h_i^a N_ab for forces Q_a + N_ab qddot_b; no rows where they hold no accelerations."""
        lift, size = self.connection.lift, range(self.connection.n if self.definition.added else 0)
        rows = [[e.xreplace(self._on_constraints) for e in row] for row in self.definition.added]
        return [
            [se.Add(*[h[i] * e for h, e in zip(lift, column, strict=True)])
             for column in zip(*rows, strict=True)]
            for i in size
        ]  # fmt: skip

    @cached_property
    def added_mass(self) -> list[list[Any]]:
        """h_i^a N_ab h_j^b: what forces that hold accelerations take from the mass matrix."""
        lift, n = self.connection.lift, self.connection.n
        return [
            [se.Add(*[e * h[j] for e, h in zip(row, lift, strict=True)]) for j in range(n)]
            for row in self.inertia_forces
        ]

    @cached_property
    def inertial(self) -> list[Any]:
        """The part of d/dt dLc/dv that holds no acceleration."""
        flow, slope = self.connection.flow_derivative, self._slope
        return [flow(p, self.rates, slope) for p in self.quasi_momenta]

    @cached_property
    def _slope(self) -> Callable[..., Any]:
        """The derivatives of what is differentiated along the motion, by coordinates and time."""
        lifts = [e for row in self.connection.lift for e in row]
        functions = [self.constrained_lagrangian, *self.dot_rates, *lifts, *self.quasi_momenta]
        return shared_slopes(functions, (*self.definition.coordinates, self.definition.time))

    @cached_property
    def right(self) -> list[Any]:
        """h_i(Lc) - (c_ij^k dLc/dv^k + B_ij^A p_A) v^j + Q_i: all but d/dt dLc/dv, and but
        accelerations in Q_i.

        The bracket term is p_a [h_i, h_j]^a v^j over all coordinates [Theory, eq. (10)].
        """
        d, connection, rates = self.definition, self.connection, self.rates
        applied = [q.xreplace(self._on_constraints) for q in d.forces]
        slope = self._slope
        result = []
        for i in range(connection.n):
            terms = [connection.along(i, self.constrained_lagrangian, slope)]
            for momentum, rate, row, force in zip(
                self.momenta, self.dot_rates, connection.lift, applied, strict=True
            ):
                turned = connection.flow_derivative(row[i], rates, slope)
                turn = connection.along(i, rate, slope) - turned
                terms.append(row[i] * force - momentum * turn)
            terms += [-p * t for p, t in zip(self.momenta, self._group_terms_of(i), strict=False)]
            if d.added:  # at vdot = 0 the accelerations are the drift of the rates
                terms += [
                    e * g for e, g in zip(self.inertia_forces[i], self.dot_drift, strict=True)
                ]
            result.append(se.Add(*terms))
        return result

    def _group_terms_of(self, i: int) -> list[Any]:
        """What the brackets of a group's own frame add to [h_i, h_j]^a v^j; nothing elsewhere."""
        group = self.definition.group
        if group is None:
            return []
        return group.bracket([row[i] for row in self.connection.lift], self.dot_rates)

    @cached_property
    def force(self) -> list[Any]:
        """mass * vdot = force."""
        raw = [r - d for r, d in zip(self.right, self.inertial, strict=True)]
        return self.polish(raw)

    @cached_property
    def rate_drift(self) -> list[Any]:
        """d/dt of the rates at fixed v; qddot is this plus the lift of vdot."""
        return [self.connection.flow_derivative(rate, self.rates) for rate in self.rates]

    @cached_property
    def dot_drift(self) -> list[Any]:
        """d/dt at fixed v of the velocities in which the Lagrangian is written."""
        return [self.connection.flow_derivative(rate, self.rates) for rate in self.dot_rates]

    @property
    def definitions(self) -> tuple[Any, ...]:
        """The velocities v in terms of q, qdot, t; on a group they are themselves."""
        d = self.definition
        return d.dots[: d.base] if d.frame is None else tuple(d.frame.expressions(d.dots))

    @cached_property
    def form(self) -> FirstOrderForm:
        """The first-order form."""
        d = self.definition
        return FirstOrderForm(
            coordinates=d.coordinates,
            velocities=d.velocities,
            parameters=d.parameters,
            time=d.time,
            rates=tuple(self.polish(self.rates)),
            mass=tuple(tuple(row) for row in self.mass),
            force=tuple(self.force),
            definitions=self.definitions,
            velocity_symbols=d.coordinate_velocities,
            relations=d.relations,
            dependent=self.dependent + self.named_momenta,
            positive=d.positive,
            inputs=d.inputs,
        )


def _frame_error(d: Definition, error: UndeterminedVelocities) -> DefinitionError:
    system = d.system
    given = ", ".join(map(str, d.velocities))
    if not error.free:
        return DefinitionError(
            f"system '{system.name}': the quasi-velocities {given} are dependent on the "
            "constraints or the relations; leave out the dependent ones"
        )
    names = ", ".join(str(d.coordinates[j]) for j in error.free)
    return DefinitionError(
        f"system '{system.name}': the quasi-velocities {given} do not determine the velocity of "
        f"{names}; define {len(error.free)} more or other quasi-velocities"
    )

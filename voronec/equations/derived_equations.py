"""What is derived of a system: equations, curvature, kind, growth; raw, exact, and for numbers.

The equations are kept twice: as a shared expression graph (made in milliseconds, good for
numbers) and as exact normal forms (short, made where asked, given up where too large).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from typing import Any

import flint
import symengine as se
import sympy as sp

from voronec.algebra.cardinal import loses_quotients
from voronec.algebra.generators import (
    distance_powers,
    holds_far_multiples,
    splits_curved_angles,
)
from voronec.algebra.memo import Memo
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.symbols import velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.tape import Tape
from voronec.algebra.terms import atoms
from voronec.algebra.verdicts import all_vanish
from voronec.declaration.system import System
from voronec.equations.connection import EhresmannConnection
from voronec.equations.curvature import (
    Brackets,
    Curvature,
    bracket_parts,
    brackets_of,
    curvature_of,
    vertical_parts,
)
from voronec.equations.definition import Definition
from voronec.equations.derivation import FEW, Derivation, FirstOrderForm
from voronec.equations.distribution import Distribution, grow
from voronec.equations.evaluation import acceleration, acceleration_tape
from voronec.equations.integrable import integrate
from voronec.equations.staged_equations import staged_form
from voronec.errors import EngineLimit

SHORT = 1500
"""Normal forms that cost no more operations are taken without looking for a shorter form."""
LARGE = 2000
"""Where there are no invariants to descend to and the raw form costs more operations than this,
normal forms are not tried for numbers: they would take seconds and come out longer; unless there
are relations to reduce by, or angles stand in their differences, or it seems to hold coordinates in
vain, which only a normal form proves."""


@dataclass(frozen=True, repr=False)
class DerivedEquations:
    """Equations mass * vdot = force, with what they are made of; users hold ``VoronecEquations``.

    ``velocities`` v are the quasi-velocities of the frame, else the velocities of the base;
    ``rates`` gives the time derivative of each coordinate.  Matrices are SymPy's, in the user's
    symbols.
    """

    system: System
    definition: Definition
    raw: Derivation
    exact: Derivation

    @cached_property
    def memo(self) -> Memo:
        """What is computed of it once."""
        return Memo()

    @property
    def bridge(self) -> SymPyBridge:
        """Between the user's symbols and those inside."""
        return self.definition.bridge

    @property
    def coordinates(self) -> tuple[sp.Expr, ...]:
        """Base coordinates, then fibre coordinates."""
        return self.system.coordinates

    @property
    def velocities(self) -> tuple[sp.Expr, ...]:
        """The independent velocities v."""
        return self.system.velocities

    @property
    def has_coordinate_frame(self) -> bool:
        """Whether the base velocities are independent; redundant coordinates make them not so."""
        return len(self.velocities) == self.definition.base

    @cached_property
    def best(self) -> Derivation:
        """The exact derivation; the unsimplified one where normal forms are beyond the budget."""
        return self.exact if self.limit is None else self.raw

    @cached_property
    def limit(self) -> str | None:
        """Which budget the normal forms are beyond; None where they are there."""
        try:
            _ = self.exact.form
        except EngineLimit as limit:
            return str(limit)
        return None

    @property
    def in_normal_form(self) -> bool:
        """Whether mass, force and rates are exact normal forms."""
        return self.best is self.exact

    @cached_property
    def is_short(self) -> bool:
        """Whether the normal forms cost no more operations than the raw derivation: what is printed
        else is its program."""
        raw = max(FEW, self.raw.form.operations)
        return self.in_normal_form and self.exact.form.operations <= raw

    @cached_property
    def is_large(self) -> bool:
        """Whether numbers are better computed from the straight-line form."""
        form = self.raw.form
        if self._loses_digits:
            return True
        if self.system.invariants:
            return self._divides_sines
        if self.raw.form.operations > LARGE:
            reducible = form.relations or self.exact.relative_angles is not None
            short = (reducible or _holds_in_vain(form)) and self.in_normal_form
            # not short is large at once: to look for quotients takes long in what costs so much
            return not (short and self.exact.form.operations <= SHORT) or self._divides_sines
        return self._divides_sines or (self.in_normal_form and not self.is_short)

    @cached_property
    def _loses_digits(self) -> bool:
        """Whether terms of normal forms are larger than what they leave."""
        exprs, definition = self.raw.form.expressions, self.definition
        moving = (definition.time, *definition.coordinates, *definition.velocities)
        return (
            holds_far_multiples(exprs)
            or splits_curved_angles(exprs, moving)
            or bool(distance_powers(exprs, moving))
        )

    @cached_property
    def _divides_sines(self) -> bool:
        return loses_quotients(self.raw.form.expressions, lambda: self.best.form.expressions)

    @cached_property
    def form(self) -> FirstOrderForm:
        """The first-order form that costs the fewest operations, in the engine's symbols.

        Where normal forms are beyond the budget, or long, it is a straight-line program.
        """
        if not self.is_large and self.is_short and self.exact.form.operations <= SHORT:
            return self.exact.form
        if self.raw.form.operations <= SHORT and self._divides_sines:
            return self.raw.form  # stages would hide the quotients
        try:
            lean = staged_form(self.raw)
        except EngineLimit:
            long = self.is_large and self.raw.form.operations > LARGE
            return self.raw.form if long or self._loses_digits else self.best.form
        if self.is_large:
            return lean
        forms = (lean, self.exact.form) if self.in_normal_form else (lean,)
        return min(forms, key=attrgetter("operations"))

    @property
    def operations(self) -> int:
        """How many operations ``form`` costs, what is shared counted once."""
        return self.form.operations

    @cached_property
    def mass(self) -> sp.ImmutableMatrix:
        """The mass matrix, n x n: d2Lc/dv2, with what forces linear in accelerations add."""
        return self.bridge.outward_matrix(self.best.mass)

    @cached_property
    def force(self) -> sp.ImmutableMatrix:
        """The right side of mass * vdot = force, n x 1."""
        return self._column(self.best.force)

    @cached_property
    def rates(self) -> sp.ImmutableMatrix:
        """The time derivatives of the coordinates in terms of q, v, t, a column."""
        return self._column(self.best.form.rates)

    @cached_property
    def theta(self) -> sp.Expr:
        """The Lagrangian on the constraints; without a potential, Theta of
        [DragovicGajicJovanovic2020, eq. (v2)]."""
        return self.bridge.outward(self.best.polish([self.best.constrained_lagrangian])[0])

    @cached_property
    def momenta(self) -> sp.ImmutableMatrix:
        """K_nu = dL/d(sdot_nu) on the constraints, a column, for each fibre coordinate (or
        velocity)."""
        return self._column(self.best.polish(self.best.momenta[self.definition.base :]))

    @cached_property
    def left(self) -> sp.ImmutableMatrix:
        """d/dt dLc/dv written out, n x 1: accelerations are ``velocity(v)``."""
        dots = [velocity(v) for v in self.velocities]
        inertial = self._column(self.best.polish(self.best.inertial))
        return sp.ImmutableMatrix(self.mass * sp.Matrix(dots) + inertial)

    @cached_property
    def right(self) -> sp.ImmutableMatrix:
        """h_i(Lc) - (c dLc/dv + B p) v + forces, n x 1: what d/dt dLc/dv equals."""
        return self._column(self.best.polish(self.best.right))

    @cached_property
    def coefficients(self) -> tuple[sp.ImmutableMatrix, sp.ImmutableMatrix]:
        """a_(nu i) and a_nu of sdot = a rdot + a_0 [DragovicGajicJovanovic2020, eq. (v1)]: a matrix
        with a row for each fibre coordinate and a column for each of the base, and a column."""
        fibre = self._exact_or_raw(lambda d: d.fibre)
        rows = [self.best.polish(row) for row in fibre.matrix]
        return self.bridge.outward_matrix(rows), self._column(self.best.polish(fibre.offset))

    @cached_property
    def curvature(self) -> Curvature:
        """A_ij^(nu) and A_i^(nu), always in the coordinate frame."""
        parts = self._vertical_parts
        return curvature_of(parts, self.definition, self.bridge.outward)

    @cached_property
    def _vertical_parts(self) -> dict[tuple[int, int], list[Any]]:
        return self._exact_or_raw(vertical_parts)

    @cached_property
    def _bracket_parts(self) -> dict[tuple[int, int], tuple[list[Any], list[Any]]]:
        return self._exact_or_raw(bracket_parts)

    @cached_property
    def brackets(self) -> Brackets:
        """c_ij^k and B_ij^A of the frame in use."""
        return brackets_of(self._bracket_parts, self.definition, self.bridge.outward)

    @cached_property
    def kind(self) -> str:
        """``holonomic``: every B_ij^A vanishes (proved), or there is no fibre; ``chaplygin``: L,
        constraints and forces are free of the fibre coordinates; ``voronec``: neither."""
        ideal = self.definition.relations
        if self.has_coordinate_frame:
            flat = [x for part in self._vertical_parts.values() for x in part]
        else:
            flat = [x for _, part in self._bracket_parts.values() for x in part]
        if all_vanish(flat, ideal):
            return "holonomic"
        d, raw = self.definition, self.raw.fibre
        rows = (*raw.matrix, *d.added)
        exprs = [d.lagrangian, *d.forces, *raw.offset, *(e for row in rows for e in row)]
        free = d.keeps_vertical and all_vanish(
            [along for e in exprs for along in d.along_fibre(e)], ideal
        )
        return "chaplygin" if free else "voronec"

    def _lift(self, derivation: Derivation) -> EhresmannConnection:
        """The horizontal fields, along the coordinates where that can be."""
        return (
            derivation.coordinate_connection if self.has_coordinate_frame else derivation.connection
        )

    @cached_property
    def distribution(self) -> Distribution:
        """The growth of the distribution that the horizontal fields span."""
        raw = self._lift(self.raw)
        return grow(self.definition, raw, lambda: self._exact_or_raw(self._lift))

    @cached_property
    def _integrable(self) -> tuple[list[Any], list[Any]]:
        distribution = self.distribution
        most = distribution.dimension - distribution.growth[-1]
        return integrate(self.definition, self._lift(self.raw), most)

    @cached_property
    def orders(self) -> dict[str, int]:
        """The highest derivative of each input, by name, that the equations hold."""
        derivatives = atoms(self.raw.form.expressions, se.Derivative)
        functions = [f for f in self.definition.inputs if any(d.args[0] == f for d in derivatives)]
        return {
            f.get_name(): max(len(d.args) - 1 for d in derivatives if d.args[0] == f)
            for f in functions
        }

    @property
    def growth(self) -> tuple[int, ...]:
        """The growth vector of the distribution at a generic point.

        ``EngineLimit`` where it is cut off, for brackets grow too large; its beginning is
        ``distribution.growth``.
        """
        distribution = self.distribution
        if distribution.cut:
            raise EngineLimit(
                f"system '{self.system.name}': brackets grow too large after the "
                f"dimensions {distribution.growth} of {distribution.dimension}; "
                "distribution.growth has these"
            )
        return distribution.growth

    @property
    def integrable(self) -> tuple[sp.Expr, ...]:
        """The combinations of the constraints that integrate, as many as the dimension exceeds that
        of the involutive closure: affine in the velocities of the coordinates (of the frame of a
        group), zero along all motions, a basis that does not depend on how the constraints are
        combined.

        Those that ``leaves`` integrate come first.  Raises ``EngineLimit`` where it is undecided
        what integrates.
        """
        return tuple(map(self.bridge.outward, self._integrable[0]))

    @property
    def leaves(self) -> tuple[sp.Expr, ...]:
        """Functions of coordinates and time that the constraints hold constant: independent, their
        differentials combinations of ``integrable``, of which fewer have one where no closed form
        was found.  They serve as relations and as integrals.

        Raises ``EngineLimit`` as ``integrable`` does.
        """
        return tuple(map(self.bridge.outward, self._integrable[1]))

    def acceleration(self, point: Mapping[Any, Any], digits: int = 30) -> dict[sp.Expr, sp.Float]:
        """Second time derivatives of all coordinates, to ``digits`` digits, by ball arithmetic.

        ``point`` gives coordinates, velocities v, parameters (defaults stand in) and ``time``.
        Raises ``DefinitionError`` for a value that is missing, a name that is unknown, and where
        the equations are not defined or hold an unknown function.
        """
        tape = self.memo.once("accelerations", lambda: acceleration_tape(self.raw))
        return acceleration(self.system, self.raw, tape, point, digits)

    def _column(self, entries: Any) -> sp.ImmutableMatrix:
        return self.bridge.outward_matrix([[e] for e in entries])

    def _exact_or_raw(self, make: Any) -> Any:
        try:
            return make(self.exact)
        except EngineLimit:
            return make(self.raw)


def _holds_in_vain(form: FirstOrderForm) -> bool:
    """Whether mass and force seem not to depend on a coordinate that is written in them: they are
    the same, to many digits, where it is moved."""
    tape = Tape([*form.force, *(e for row in form.mass for e in row)])
    for point, values in sample_evaluable(tape, bits=GENERIC, count=1):
        for q in form.coordinates:
            if q in point:
                moved = tape.arb({**point, q: point[q] + flint.fmpq(1, 7)}, GENERIC)
                if all(a.overlaps(b) for a, b in zip(values, moved, strict=True)):
                    return True
    return False

"""The form of reduced equations after a change of time: Lagrange's, or Hamilton's by a bracket.

With Chaplygin's reducing multiplier N, dtau = N(r) dt and r' = dr/dtau, that is rdot = N r', the
claim is that along the motion

    d/dtau dL*/dr'_i - dL*/dr_i = 0,    L*(r, r') = Lc(r, N r').

In the velocities rdot, with p_i = dLc/drdot_i, it reads

    dp_i/dt + (Ndot/N) p_i - dLc/dr_i - (dN/dr_i) (p . rdot)/N = 0.

On a group, where the independent velocities move the coordinates as a frame h_i of fields on their
space, [h_i, h_j] = c_ij^k h_k there, the equations of that Lagrangian are Hamel's,

    dp_i/dt + (Ndot/N) p_i - h_i(Lc) - h_i(N) (p . v)/N + c_ij^k v^j p_k = 0,    p_i = dLc/dv^i.

A Poisson bracket is skew and meets Jacobi's identity, and x' = clock {x, H}.  The variables z are
functions of the state x; a derivative by z is taken through the inverse of dz/dx.  Where relations
bind x, z are either as many as all of x, and then the bracket must keep the relations, or as many
as are independent, and then the relations are Casimirs by definition.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import dot
from voronec.algebra.rank import generic_rows
from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.declaration.claims import Poisson
from voronec.equations.connection import AffineForms
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.proof.branch_cuts import across_cuts, beside_zeros
from voronec.proof.decision import Decision, all_zero, zero_everywhere
from voronec.proof.nondegeneracy import where_independent, where_nonzero


def decide_multiplier(motions: Motions, multiplier: sp.Expr) -> Decision:
    """Whether N is a reducing multiplier, dtau = N dt."""
    field = motions.on_coordinates
    n = field.read(multiplier)
    verdict = zero_everywhere(n, "the multiplier", field.hypotheses)
    if verdict is None:
        verdict = _verdict(motions, field, n)
        verdict = across_cuts(verdict, field, [("the multiplier", n)], periods=False, beyond=True)
        verdict = where_nonzero(verdict, field, "the multiplier", n)
        verdict = beside_zeros(verdict, field, "the multiplier", n)
    return Decision(verdict, field.level)


def _verdict(motions: Motions, field: VectorField, n: Any) -> Verdict:
    equations = motions.equations
    definition = equations.definition
    if definition.group is not None:
        return _verdict_on_group(motions, field, n)
    if not equations.has_coordinate_frame:
        return Verdict("undecided", "the base coordinates are redundant; choose independent ones")
    base, fibre = (
        definition.coordinates[: definition.base],
        definition.coordinates[definition.base :],
    )
    dots = definition.coordinate_velocities[: definition.base]
    lagrangian = _constrained_lagrangian(motions, dots)
    foreign = _foreign(
        lagrangian, n, (*fibre, definition.time), (*dots, *definition.velocities), field.hypotheses
    )
    if foreign is not None:
        return foreign
    rates = dict(zip(dots, field.rates, strict=False))
    momenta = [lagrangian.diff(dot).xreplace(rates) for dot in dots]
    power = se.Add(*[p * rates[dot] for p, dot in zip(momenta, dots, strict=True)])
    growth = field.derivative(n) / n
    residuals = [
        (
            f"the equation of '{r}'",
            pdot + growth * p - lagrangian.diff(r).xreplace(rates) - n.diff(r) * power / n,
        )
        for r, p, pdot in zip(base, momenta, field.derivatives(momenta), strict=True)
    ]
    return all_zero(residuals, field.hypotheses)


def _verdict_on_group(motions: Motions, field: VectorField, n: Any) -> Verdict:
    """The verdict on a group: the space of the coordinates is the base."""
    derivation = motions.equations.best
    definition, connection = derivation.definition, derivation.connection
    lagrangian, momenta = derivation.constrained_lagrangian, derivation.quasi_momenta
    foreign = _foreign(lagrangian, n, (definition.time,), definition.velocities, field.hypotheses)
    if foreign is not None:
        return foreign
    chosen = _independent_coordinates(
        field, [list(row[: connection.n]) for row in connection.coordinate_lift]
    )
    if any(row[connection.n] != 0 for row in connection.coordinate_lift) or not chosen:
        return Verdict(
            "undecided", "the velocities do not move the coordinates as a frame of their space"
        )
    size, rates = range(connection.n), derivation.rates
    rows = [connection.coordinate_lift[a] for a in chosen]
    columns = [[row[i] for row in rows] for i in size]
    weights = [w[0] for w in solve_linear(columns, [[p] for p in momenta], field.hypotheses).values]
    power = dot(momenta, definition.velocities)
    growth = field.derivative(n) / n
    residuals = []
    for i in size:
        turn = [
            connection.along(i, rates[a]) - connection.flow_derivative(row[i], rates)
            for a, row in zip(chosen, rows, strict=True)
        ]
        residuals.append(
            (
                f"the equation of '{definition.velocities[i]}'",
                se.Add(
                    derivation.right[i],
                    growth * momenta[i],
                    -connection.along(i, lagrangian),
                    -connection.along(i, n) * power / n,
                    *[w * t for w, t in zip(weights, turn, strict=True)],
                ),
            )
        )
    return all_zero(residuals, field.hypotheses)


def _independent_coordinates(field: VectorField, rows: Sequence[Sequence[Any]]) -> list[int]:
    """As many coordinates as velocities, with independent rates; none where there are not."""
    failure = "no point was found on the relations between the coordinates"
    chosen = generic_rows(rows, field.hypotheses, failure=failure)
    return chosen if rows and len(chosen) == len(rows[0]) else []


def _constrained_lagrangian(motions: Motions, dots: Sequence[Any]) -> Any:
    """Lc(r, rdot): the Lagrangian on the constraints, in velocities of the base."""
    definition, fibre = motions.equations.definition, motions.equations.best.fibre
    sdots = definition.coordinate_velocities[definition.base :]
    solved = AffineForms(fibre.matrix, fibre.offset)
    return definition.lagrangian.xreplace(dict(zip(sdots, solved.expressions(dots), strict=True)))


def _foreign(
    lagrangian: Any, n: Any, outside: Sequence[Any], moving: Sequence[Any], relations: Sequence[Any]
) -> Verdict | None:
    """What Lc or N may not depend on, but does."""
    parts = [("Lc", lagrangian, s) for s in outside]
    parts += [("the multiplier", n, s) for s in (*outside, *moving)]
    for name, function, s in parts:
        slope = function.diff(s)
        if slope == 0:
            continue
        verdict = decide_zero(slope, relations)
        if verdict.refuted:
            why = f"{name} depends on '{s}', which is no base coordinate"
            return Verdict("refuted", why, verdict.witness)
        if verdict.undecided:
            return Verdict("undecided", f"whether {name} depends on '{s}': {verdict.method}")
    return None


def decide_poisson(motions: Motions, claim: Poisson) -> Decision:
    """The variables determine the state, Jacobi's identity, kept relations, the equations."""
    functions = [v for k, v in claim.variables.items() if v != k]
    plain = {k for k, v in claim.variables.items() if v == k}
    others = (*claim.bracket.values(), claim.hamiltonian, claim.clock)
    names = {*claim.variables} - plain
    used = [s for e in others for s in e.free_symbols if s not in names]
    field = motions.field_for([*functions, *plain, *used])
    structure = _Structure(field, claim)
    if structure.inverse is None:
        words = f"the {len(claim.variables)} variables do not determine the state"
        why = f"{words} on the {field.level}, of {field.dimension} dimensions"
        return Decision(Verdict("refuted", why), field.level)
    verdict = all_zero(structure.residuals(), field.hypotheses)
    verdict = across_cuts(verdict, field, [*structure.named_variables()])
    verdict = across_cuts(
        verdict, field, [*structure.named_functions()], periods=False, beyond=True
    )
    verdict = where_independent(
        verdict,
        field,
        [*structure.meaning.values()],
        field.variables,
        structure.bound,
        len(structure.symbols),
    )
    clock = structure.read(claim.clock).xreplace(structure.meaning)
    verdict = where_nonzero(verdict, field, "the clock", clock)
    verdict = beside_zeros(verdict, field, "the clock", clock)
    return Decision(verdict, field.level)


@dataclass(frozen=True)
class _Structure:
    """A bracket in the engine's symbols; its variables have symbols of their own."""

    field: VectorField
    claim: Poisson

    @cached_property
    def symbols(self) -> list[Any]:
        """The variables z."""
        return [se.Symbol(f"bracket variable {plain_name(z)}") for z in self.claim.variables]

    @cached_property
    def meaning(self) -> dict[Any, Any]:
        """z as functions of the state."""
        values = [self.field.read(e) for e in self.claim.variables.values()]
        return dict(zip(self.symbols, values, strict=True))

    def read(self, expr: Any) -> Any:
        """A function of z and of the state."""
        inward = self.field.bridge.inward
        names = map(inward, self.claim.variables)
        return self.field.express(
            inward(expr).xreplace(dict(zip(names, self.symbols, strict=True)))
        )

    @cached_property
    def table(self) -> list[list[Any]]:
        """{z_i, z_j}."""
        keys, size = [*self.claim.variables], len(self.claim.variables)
        table = [[se.Integer(0)] * size for _ in range(size)]
        for (a, b), entry in self.claim.bracket.items():
            i, j = keys.index(a), keys.index(b)
            table[i][j] = self.read(entry)
            table[j][i] = -table[i][j]
        return table

    @cached_property
    def bound(self) -> tuple[Any, ...]:
        """The relations, where the variables are as many as are independent."""
        relations = self.field.independent_relations
        count = len(self.symbols) + len(relations)
        return relations if count == len(self.field.variables) else ()

    @cached_property
    def inverse(self) -> list[list[Any]] | None:
        """dx/dz, a row for each state variable; None where z does not determine x."""
        field, functions = self.field, [*self.meaning.values(), *self.bound]
        size = len(field.variables)
        if len(functions) != size:
            return None
        rows = [[f.diff(x) for x in field.variables] for f in functions]
        unit = [[se.Integer(int(i == j)) for j in range(size)] for i in range(size)]
        solved = solve_linear(rows, unit, field.hypotheses)
        return None if solved.free else solved.values

    def slopes(self, function: Any) -> list[Any]:
        """The derivatives of a function of z and x by each z."""
        assert self.inverse is not None
        partials = [function.diff(z) for z in self.symbols]
        for x, row in zip(self.field.variables, self.inverse, strict=True):
            slope = function.diff(x)
            if slope != 0:
                partials = [d + slope * e for d, e in zip(partials, row, strict=False)]
        return partials

    def along(self, i: int, slopes: list[Any]) -> Any:
        """{z_i, F} from the derivatives of F."""
        return dot(self.table[i], slopes)

    def named_variables(self) -> Iterator[tuple[str, Any]]:
        """The variables as functions of the state."""
        names = map(plain_name, self.claim.variables)
        yield from zip(names, self.meaning.values(), strict=True)

    def named_functions(self) -> Iterator[tuple[str, Any]]:
        """The Hamiltonian, the clock and the entries of the bracket as functions of the state."""
        yield "the Hamiltonian", self.read(self.claim.hamiltonian).xreplace(self.meaning)
        yield "the clock", self.read(self.claim.clock).xreplace(self.meaning)
        for (a, b), entry in self.claim.bracket.items():
            name = f"the bracket of {plain_name(a)} with {plain_name(b)}"
            yield name, self.read(entry).xreplace(self.meaning)

    def residuals(self) -> Iterator[tuple[str, Any]]:
        """What has to vanish, with its name."""
        for label, residual in (*self._jacobi(), *self._relation_brackets(), *self._motion()):
            yield label, residual.xreplace(self.meaning)

    def _jacobi(self) -> Iterator[tuple[str, Any]]:
        names = [plain_name(z) for z in self.claim.variables]
        size = range(len(names))
        slopes = {(i, j): self.slopes(self.table[i][j]) for i in size for j in size}
        for i, j, k in combinations(size, 3):
            cycles = ((i, j, k), (j, k, i), (k, i, j))
            total = se.Add(*[self.along(a, slopes[b, c]) for a, b, c in cycles])
            yield f"Jacobi's identity of {names[i]}, {names[j]}, {names[k]}", total

    def _relation_brackets(self) -> Iterator[tuple[str, Any]]:
        """The bracket of each variable with each relation vanishes, as it does by definition where
        the relations are further variables."""
        for relation in self.field.independent_relations:
            slopes = self.slopes(relation)
            for i, z in enumerate(self.claim.variables):
                yield f"the bracket of {plain_name(z)} with {relation}", self.along(i, slopes)

    def _motion(self) -> Iterator[tuple[str, Any]]:
        slopes = self.slopes(self.read(self.claim.hamiltonian))
        clock = self.read(self.claim.clock)
        rates = self.field.derivatives([*self.meaning.values()])
        for i, (z, rate) in enumerate(zip(self.claim.variables, rates, strict=True)):
            yield f"the rate of {plain_name(z)}", rate - clock * self.along(i, slopes)

"""Invariant measures: div(density f) = 0, also where relations bind the variables.

On the zero set of relations R with f(R_a) = C_ab R_b the volume is that of Leray's form, the one
whose product with dR_1 ... dR_k is the volume of all variables, and the condition reads

    div(density f) = density tr C    where R = 0.

C vanishes where the field keeps each relation constant off the zero set too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.arguments import POINT, accepts
from voronec.algebra.elimination import solve_linear
from voronec.algebra.normal import canonical
from voronec.algebra.rank import generic_rank, generic_rows
from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.declaration.claims import Measure
from voronec.declaration.derivatives import derivative
from voronec.declaration.reading import expression, quote
from voronec.equations.motions import Motions
from voronec.equations.vector_field import NO_POINT, VectorField
from voronec.errors import DefinitionError, EngineLimit
from voronec.proof.branch_cuts import across_cuts, flow_across_cuts
from voronec.proof.closure import foreign_rate
from voronec.proof.decision import Decision, all_zero, zero_everywhere
from voronec.proof.nondegeneracy import where_nonzero, where_of_one_sign


@accepts(flow=POINT)
def divergence(density: Any, flow: Mapping[Any, Any]) -> sp.Expr:
    """div(density f) = sum of d(density f_i)/dx_i, where ``flow`` gives the rate f_i of each x_i.

    It vanishes where the density is that of an invariant measure.  Raises ``DefinitionError`` for
    what is no variable, or no expression.
    """
    weight = expression(density, "the density")
    rates = {x: expression(rate, f"the rate of '{quote(x)}'") for x, rate in flow.items()}
    for x in rates:
        plain_name(x)  # refuses what is no variable
    named = {x: sp.Symbol(x) if isinstance(x, str) else x for x in rates}
    return sp.Add(*[derivative(weight * rate, named[x]) for x, rate in rates.items()])


def decide_measure(motions: Motions, measure: Measure) -> Decision:
    """Whether a density is that of an invariant measure in its variables."""
    try:
        field = measured_field(motions, measure)
    except DefinitionError as refusal:
        return Decision(Verdict("refuted", str(refusal)), "invariants")
    chosen = chosen_variables(field, measure)
    if len(chosen) < len(field.variables):
        closed = foreign_rate(field, chosen)
        if not closed.proved:
            return Decision(closed, field.level)
    verdict = zero_everywhere(field.read(measure.density), "the density", field.hypotheses)
    if verdict is None:
        residual = defect(field, field.read_density(measure.density), chosen)
        verdict = all_zero([("", residual)], field.hypotheses)
        inside = [("the density", field.read_branches(measure.density))]
        verdict = across_cuts(verdict, field, inside, periods=False, beyond=True)
        verdict = flow_across_cuts(verdict, field, field.read(measure.density))
        verdict = where_nonzero(verdict, field, "the density", inside[0][1])
        verdict = where_of_one_sign(verdict, field, "the density", inside[0][1])
    return Decision(verdict, field.level)


def measured_field(motions: Motions, measure: Measure) -> VectorField:
    """The field on the level of the variables of a measure."""
    if not measure.variables or motions.holds_coordinate(measure.variables):
        return motions.on_coordinates
    symbols = {*motions.system.invariant_symbols}
    return motions.at("invariants" if symbols & {*measure.variables} else "coordinates")


def chosen_variables(field: VectorField, measure: Measure) -> tuple[Any, ...]:
    """The variables of a measure in the engine's symbols; all of the field where none are given."""
    return tuple(field.bridge.inward(x) for x in measure.variables) or field.variables


def defect(field: VectorField, density: Any, variables: Sequence[Any] = ()) -> Any:
    """div(density f) - density tr C in the variables; zero for an invariant measure."""
    chosen = [*(variables or field.variables)]
    if field.determinant is not None and field.determinant in density.free_symbols:
        if len(chosen) == len(field.variables) and not density.free_symbols & {*field.velocities}:
            return _relative_defect(field, density)
        density = field.express(density)
    if len(chosen) == len(field.variables):
        moving = field.derivative(density)
        stretch = _divergence(field)
    else:
        rates = dict(zip(field.variables, field.components, strict=True))
        moving = se.Add(density.diff(field.time), *[density.diff(x) * rates[x] for x in chosen])
        stretch = se.Add(*[rates[x].diff(x) for x in chosen])
    return moving + density * (stretch - _drift(field, binding(field, chosen)))


def binding(field: VectorField, chosen: Sequence[Any]) -> list[Any]:
    """The independent relations between the chosen variables.

    Relations that hold other variables too must not bind the chosen ones any further; where they
    do, ``EngineLimit``.
    """
    others = {*field.variables} - {*chosen}
    inside = [r for r in field.independent_relations if not r.free_symbols & others]
    if len(inside) == len(field.independent_relations):
        return inside
    slopes = [[r.diff(x) for x in field.variables] for r in field.independent_relations]
    slopes += [[se.Integer(int(x == y)) for x in field.variables] for y in chosen]
    rank = generic_rank(slopes, field.hypotheses)
    if rank != len(field.independent_relations) + len(chosen) - len(inside):
        raise EngineLimit("relations with other variables bind those of the measure")
    return inside


def _relative_defect(field: VectorField, density: Any) -> Any:
    """div(density f) / density - tr C for a density with the determinant of the mass matrix.

    The part with mass^-1 is tr(mass^-1 X), X = d(force)/dv + s d(mass)/dt [Theory, eq. (20)],
    where s is
    d log(density) / d log det(mass).
    """
    name = field.determinant
    if any(e.free_symbols & {*field.velocities} for row in field.mass for e in row):
        raise EngineLimit("the mass matrix holds velocities; write the density out")
    power, still = canonical(
        [density.diff(name) * name / density, field.derivative(density) / density], field.hypotheses
    )
    changes = [
        [
            f.diff(v) + power * field.derivative(m)
            for v, m in zip(field.velocities, row, strict=True)
        ]
        for f, row in zip(field.force, field.mass, strict=True)
    ]
    rest = [rate.diff(q) for rate, q in zip(field.rates, field.positions, strict=True)]
    total = se.Add(still, *rest, _trace(field, changes))
    return field.express(total) - _drift(field, field.independent_relations)


def _trace(field: VectorField, x: Sequence[Sequence[Any]]) -> Any:
    """tr(mass^-1 X), without mass^-1 where X is T mass + a skew matrix, T a multiple of the
    turning of a group: then it is tr T."""
    size = range(len(field.mass))
    options = (0, 1, -1) if field.turning else (0,)
    symmetric: list[Any] = []
    for sign in options:
        turned = [
            [
                sign * se.Add(*[t * field.mass[k][j] for k, t in enumerate(field.turning[i])])
                if sign
                else se.Integer(0)
                for j in size
            ]
            for i in size
        ]
        table = [[x[i][j] - turned[i][j] for j in size] for i in size]
        parts = [(table[i][j] + table[j][i]) / 2 for i in size for j in size if i <= j]
        symmetric = canonical(parts, field.hypotheses)
        if all(e == 0 for e in symmetric):
            return sign * se.Add(*[field.turning[i][i] for i in size]) if sign else se.Integer(0)
    solved = field.solve(x)
    return se.Add(*[solved[i][i] for i in size])


def _divergence(field: VectorField) -> Any:
    """div f = sum of d(rate)/dq and of the trace of mass^-1 (d(force) - d(mass) v')/dv."""
    velocities = field.velocities
    bent = any(e.free_symbols & {*velocities} for row in field.mass for e in row)
    vdot = field.accelerations if bent else (se.Integer(0),) * len(velocities)
    columns = [
        [
            f.diff(v) - se.Add(*[m.diff(v) * a for m, a in zip(row, vdot, strict=True)])
            for v in velocities
        ]
        for f, row in zip(field.force, field.mass, strict=True)
    ]
    jacobian = field.solve(columns) if any(e != 0 for row in columns for e in row) else []
    along = [jacobian[i][i] for i in range(len(jacobian))]
    return se.Add(
        *[rate.diff(q) for rate, q in zip(field.rates, field.positions, strict=True)], *along
    )


def _drift(field: VectorField, relations: Sequence[Any]) -> Any:
    """tr C of f(R_a) = C_ab R_b: with y as many variables as relations, C = d(f(R))/dy (dR/dy)^-1.

    That follows from differentiating by y where R = 0.
    """
    rates = [field.derivative(r) for r in relations]
    if all(decide_zero(rate).proved for rate in rates):
        return se.Integer(0)
    for r, rate in zip(relations, rates, strict=True):
        if not decide_zero(rate, field.hypotheses).proved:
            raise EngineLimit(f"the field was not proved to keep the relation '{r} = 0'")
    y = _transverse(field, relations)
    # The transposed system: (dR/dy)^T X = (d(f(R))/dy)^T, so that X = C^T.
    rows = [[r.diff(x) for r in relations] for x in y]
    right = [[rate.diff(x) for rate in rates] for x in y]
    solved = solve_linear(rows, right, field.hypotheses).values
    return se.Add(*[solved[i][i] for i in range(len(relations))])


def _transverse(field: VectorField, relations: Sequence[Any]) -> list[Any]:
    """Variables along which the relations change independently."""
    slopes = [[r.diff(q) for r in relations] for q in field.positions]
    rows = generic_rows(slopes, field.hypotheses, failure=NO_POINT)
    return [field.positions[i] for i in rows]

"""Chaplygin's reducing multiplier: a change of time that makes the reduced equations Lagrange's.

With dtau = N(r) dt and r' = dr/dtau, that is rdot = N r', the claim is that along the motion

    d/dtau dL*/dr'_i - dL*/dr_i = 0,    L*(r, r') = Lc(r, N r').

In the velocities rdot, with p_i = dLc/drdot_i, it reads

    dp_i/dt + (Ndot/N) p_i - dLc/dr_i - (dN/dr_i) (p . rdot)/N = 0.

On a group, where the independent velocities move the coordinates as a frame h_i of fields on their
space, [h_i, h_j] = c_ij^k h_k there, the equations of that Lagrangian are Hamel's,

    dp_i/dt + (Ndot/N) p_i - h_i(Lc) - h_i(N) (p . v)/N + c_ij^k v^j p_k = 0,    p_i = dLc/dv^i.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import dot
from voronec.algebra.rank import generic_rows
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.equations.connection import AffineForms
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.proof.decision import Decision, all_zero, zero_everywhere
from voronec.proof.walls import across_walls

__all__ = ["decide_multiplier"]


def decide_multiplier(motions: Motions, multiplier: sp.Expr) -> Decision:
    """Whether N is a reducing multiplier, dtau = N dt."""
    field = motions.on_coordinates
    n = field.read(multiplier)
    found = zero_everywhere(n, "the multiplier", field.hypotheses)
    if found is None:
        found = _verdict(motions, field, n)
        found = across_walls(found, field, [("the multiplier", n)], periods=False)
    return Decision(found, field.level)


def _verdict(motions: Motions, field: VectorField, n: Any) -> Verdict:
    equations = motions.equations
    own = equations.definition
    if own.group is not None:
        return _verdict_on_group(motions, field, n)
    if not equations.has_coordinate_frame:
        return Verdict("refuted", "the base coordinates are redundant; choose independent ones")
    base, fibre = own.coordinates[: own.base], own.coordinates[own.base :]
    dots = own.coordinate_velocities[: own.base]
    lagrangian = _constrained_lagrangian(motions, dots)
    foreign = _foreign(
        lagrangian, n, (*fibre, own.time), (*dots, *own.velocities), field.hypotheses
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
    """The same on a group: the space of the coordinates is the base."""
    derivation = motions.equations.best
    own, connection = derivation.definition, derivation.connection
    lagrangian, momenta = derivation.constrained_lagrangian, derivation.quasi_momenta
    foreign = _foreign(lagrangian, n, (own.time,), own.velocities, field.hypotheses)
    if foreign is not None:
        return foreign
    chosen = _independent_coordinates(
        field, [list(row[: connection.n]) for row in connection.coordinate_lift]
    )
    if any(row[connection.n] != 0 for row in connection.coordinate_lift) or not chosen:
        return Verdict(
            "refuted", "the velocities do not move the coordinates as a frame of their space"
        )
    size, rates = range(connection.n), derivation.rates
    rows = [connection.coordinate_lift[a] for a in chosen]
    columns = [[row[i] for row in rows] for i in size]
    weights = [w[0] for w in solve_linear(columns, [[p] for p in momenta], field.hypotheses).values]
    power = dot(momenta, own.velocities)
    growth = field.derivative(n) / n
    residuals = []
    for i in size:
        turn = [
            connection.along(i, rates[a]) - connection.flow_derivative(row[i], rates)
            for a, row in zip(chosen, rows, strict=True)
        ]
        residuals.append(
            (
                f"the equation of '{own.velocities[i]}'",
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
    found = generic_rows(rows, field.hypotheses, failure=failure)
    return found if rows and len(found) == len(rows[0]) else []


def _constrained_lagrangian(motions: Motions, dots: Sequence[Any]) -> Any:
    """Lc(r, rdot): the Lagrangian on the constraints, in velocities of the base."""
    own, fibre = motions.equations.definition, motions.equations.best.fibre
    sdots = own.coordinate_velocities[own.base :]
    solved = AffineForms(fibre.matrix, fibre.offset)
    return own.lagrangian.xreplace(dict(zip(sdots, solved.expressions(dots), strict=True)))


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

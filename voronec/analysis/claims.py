"""Claims of a system, each proved or refuted: integrals, invariant measures, descent."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.derivation import Derivation
from voronec.equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit
from voronec.reduction import descend
from voronec.system import System

__all__ = ["Claim", "check_claims", "measure_defect", "rate_of_change"]


@dataclass(frozen=True)
class Claim:
    """One claim with its verdict; ``kind`` is ``integral``, ``measure`` or ``descent``."""

    kind: str
    name: str
    verdict: Verdict


def check_claims(system: System | VoronecEquations) -> list[Claim]:
    """Prove or refute every claim that a system declares."""
    eqs = derive(system) if isinstance(system, System) else system
    claims = []
    for name, expr in eqs.system.integrals.items():
        claims.append(Claim("integral", name, _vanishes(eqs, rate_of_change, expr)))
    if eqs.system.measure is not None:
        verdict = _vanishes(eqs, measure_defect, eqs.system.measure.density)
        claims.append(Claim("measure", "density", verdict))
    if eqs.system.invariants:
        claims.append(Claim("descent", ", ".join(eqs.system.invariants), _descends(eqs)))
    return claims


def _vanishes(eqs: VoronecEquations, defect: Callable[..., Any], expr: Any) -> Verdict:
    try:
        return decide_zero(defect(eqs, eqs.door.inward(expr)), eqs.definition.relations)
    except EngineLimit as limit:
        return Verdict("undecided", str(limit))


def _descends(eqs: VoronecEquations) -> Verdict:
    try:
        descend(eqs)
    except DefinitionError as refusal:
        return Verdict("refuted", str(refusal))
    except EngineLimit as limit:
        return Verdict("undecided", str(limit))
    return Verdict("proved", "equations closed in the invariants, by elimination")


def _in_velocities(d: Derivation, expr: Any) -> Any:
    """A function of the state, coordinate velocities expressed by v."""
    velocities = d.definition.coordinate_velocities
    own = set(d.definition.velocities)
    rates = dict(zip(velocities, d.rates, strict=True))
    return expr.xreplace({dot: rate for dot, rate in rates.items() if dot not in own})


def _solve_mass(d: Derivation, right: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """mass^-1 times the columns of ``right``."""
    if d.connection.n == 0:
        return []
    return solve_linear(d.mass, right, d.definition.relations).values


def rate_of_change(eqs: VoronecEquations, function: Any) -> Any:
    """d/dt along the motion of a function of q, v, t (all inside the door).

    dF/dv . mass^-1 force is computed as y . force with mass y = dF/dv [Theory, eq. (13)].
    """
    d = eqs.best
    function = _in_velocities(d, function)
    gradient = [[function.diff(v)] for v in d.definition.velocities]
    y = _solve_mass(d, gradient)
    pushed = [row[0] * f for row, f in zip(y, d.force, strict=True)]
    return se.Add(d.connection.flow_derivative(function, d.rates), *pushed)


def measure_defect(eqs: VoronecEquations, density: Any) -> Any:
    """div(density * X) for the first-order field X in the variables (q, v).

    With redundant coordinates the divergence is the ambient one, which is the intrinsic one where
    the field leaves each relation constant; otherwise ``EngineLimit``.
    """
    d = eqs.best
    density = _in_velocities(d, density)
    velocities, connection = d.definition.velocities, d.connection
    for relation in d.definition.relations:
        if not decide_zero(connection.flow_derivative(relation, d.rates)).proved:
            raise EngineLimit("the field does not keep the relations constant off their zero set")
    vdot = [row[0] for row in _solve_mass(d, [[f] for f in d.force])]
    columns = [
        [
            f.diff(v) - se.Add(*[m.diff(v) * a for m, a in zip(row, vdot, strict=True)])
            for v in velocities
        ]
        for f, row in zip(d.force, d.mass, strict=True)
    ]
    jacobian = _solve_mass(d, columns)
    divergence = [rate.diff(q) for rate, q in zip(d.rates, connection.coordinates, strict=True)]
    divergence += [jacobian[i][i] for i in range(len(velocities))]
    along = [density.diff(v) * a for v, a in zip(velocities, vdot, strict=True)]
    moving = connection.flow_derivative(density, d.rates)
    return se.Add(moving, *along) + density * se.Add(*divergence)

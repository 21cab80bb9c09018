"""The theorem of Euler and Jacobi: enough integrals and an invariant measure give quadratures.

A field of dimension n with an invariant measure and n - 2 independent first integrals, neither
depending on the time, is integrated by quadratures.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy as sp

from voronec.algebra.generic import generic_rank
from voronec.algebra.verdicts import Verdict
from voronec.analysis.decision import Decision
from voronec.analysis.measures import (
    binding,
    chosen_variables,
    measured_field,
)
from voronec.claims import Measure
from voronec.vector_field import Motions, VectorField

__all__ = ["decide_integrable"]


def decide_integrable(
    motions: Motions, measure: Measure, measured: Verdict, integrals: Sequence[sp.Expr]
) -> Decision:
    """Whether proved integrals and a measure, of that verdict, suffice for Euler and Jacobi."""
    if not measured.proved:
        return Decision(Verdict(measured.status, f"the measure is {measured.status}"))
    field = measured_field(motions, measure)
    chosen = chosen_variables(field, measure)
    low = field.level == "coordinates"
    inside = [field.read(e) for e in integrals if low or not motions.holds_coordinate([e])]
    functions = [e for e in inside if not e.free_symbols & _outside(motions, field, chosen)]
    return Decision(_counted(field, chosen, functions, field.read(measure.density)), field.level)


def _outside(motions: Motions, field: VectorField, chosen: Sequence[Any]) -> set[Any]:
    """The state variables of either level that are not among the chosen ones."""
    own = motions.equations.definition
    state = {*own.coordinates, *own.coordinate_velocities, *own.velocities, *field.variables}
    return state - {*chosen}


def _counted(
    field: VectorField, chosen: Sequence[Any], functions: Sequence[Any], density: Any
) -> Verdict:
    relations = binding(field, chosen)
    rates = dict(zip(field.variables, field.components, strict=True))
    if any(field.time in e.free_symbols for e in (density, *(rates[x] for x in chosen))):
        return Verdict("refuted", "the time occurs; the theorem is one of autonomous fields")
    functions = [f for f in functions if field.time not in f.free_symbols]
    dimension = len(chosen) - len(relations)
    if len(functions) < dimension - 2:
        count = f"{len(functions)} integrals in {dimension} dimensions"
        return Verdict("refuted", f"{count}; the theorem asks for {dimension - 2}")
    slopes = [[f.diff(x) for x in chosen] for f in (*relations, *functions)]
    rank = generic_rank(slopes, field.hypotheses) if slopes else 0
    independent = rank - len(relations)
    if independent >= dimension - 2:
        why = f"a measure and {independent} independent integrals in {dimension} dimensions"
        return Verdict("proved", f"Euler and Jacobi: {why}")
    return Verdict("undecided", f"at the points tried {independent} integrals are independent")

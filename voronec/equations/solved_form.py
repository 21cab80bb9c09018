"""The first-order form solved for the rates of the velocities, where that is short."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import symengine as se

from voronec.algebra.normal import shortest
from voronec.equations.vector_field import on_coordinates
from voronec.errors import EngineLimit

if TYPE_CHECKING:
    from voronec.equations.derivation import FirstOrderForm
    from voronec.equations.derived_equations import DerivedEquations

__all__ = ["solved_form"]

SHORT = 300
"""Forms that cost more operations are not solved: what comes out is longer, nearly always."""


def solved_form(equations: DerivedEquations) -> FirstOrderForm | None:
    """vdot = mass^-1 force in the shortest form: what mass and force share is gone.

    None where it is not tried, or beyond the budget.
    """
    if equations.is_large or not equations.in_normal_form or equations.operations > SHORT:
        return None
    form = equations.exact.form
    try:
        rates = shortest(on_coordinates(equations).accelerations, form.relations, form.velocities)
    except EngineLimit:
        return None
    size = range(len(rates))
    unit = tuple(tuple(se.Integer(int(i == j)) for j in size) for i in size)
    return replace(form, mass=unit, force=tuple(rates))

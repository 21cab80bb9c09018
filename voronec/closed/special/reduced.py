"""The family against the equations of motion: the field on the essential variables.

Another route than the quartic: nothing here uses it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.normal import shorten
from voronec.algebra.text import sympified
from voronec.algebra.verdicts import Verdict, prove_equal
from voronec.errors import DefinitionError
from voronec.vector_field import Motions

if TYPE_CHECKING:
    from voronec.closed.special.family import Precessions

__all__ = ["at_rest", "essential_rates", "linearised"]


def essential_rates(family: Precessions) -> dict[Any, sp.Expr]:
    """Essential variable -> its rate, by the derived equations."""
    system = family.system
    if not system.essential:
        raise DefinitionError(
            f"system '{system.name}' declares no essential variables; give it essential=(...)"
        )
    field = Motions.of(system).on_coordinates
    outward = field.door.outward
    rates = {outward(v): outward(e) for v, e in zip(field.variables, field.components, strict=True)}
    return {v: rates[v].xreplace(dict(family.values)) for v in system.essential}


def at_rest(family: Precessions) -> Verdict:
    """Whether the rates of all essential variables vanish on the family."""
    for variable, rate in essential_rates(family).items():
        verdict = prove_equal(_on_family(family, rate), 0)
        if not verdict.proved:
            return Verdict(
                verdict.status, f"the rate of {variable}: {verdict.method}", verdict.witness
            )
    return Verdict("proved", "the rates of the essential variables vanish in exact normal form")


def linearised(family: Precessions) -> sp.Matrix:
    """The matrix of the linearised equations on the family, rows and columns as ``essential``."""
    rates = essential_rates(family)
    rows = [[_on_family(family, sp.diff(e, v)) for v in rates] for e in rates.values()]
    return sp.Matrix([shorten(row) for row in rows])


def _on_family(family: Precessions, value: sp.Expr) -> sp.Expr:
    (angle,) = family.quadratures.meaning.free_symbols
    own = family.placed(value.xreplace(dict(family.state)))
    return sympified(own.subs(angle, sp.acos(family.place)))

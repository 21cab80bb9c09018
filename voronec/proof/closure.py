"""Closed subsets of the state: variables whose rates depend on nothing but them.

The parameters and the time are no part of the state: the rates may hold them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from voronec.algebra.normal import canonical
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.rank import proved_rank
from voronec.algebra.symbols import plain_name
from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.proof.decision import Decision


def decide_essential(motions: Motions, variables: Sequence[Any]) -> Decision:
    """Whether the rates of some state variables depend on these, parameters and the time alone."""
    field = motions.field_for([*variables])
    symbols = [field.bridge.inward(x) for x in variables]
    strangers = [x for x, y in zip(variables, symbols, strict=True) if y not in field.variables]
    if strangers:
        why = f"'{plain_name(strangers[0])}' is no variable of the equations on the {field.level}"
        return Decision(Verdict("refuted", why), field.level)
    return Decision(foreign_rate(field, symbols), field.level)


def foreign_rate(field: VectorField, own: Sequence[Any]) -> Verdict:
    """Proved where the rates of ``own`` depend on no other variable of the field."""
    others = {*field.variables} - {*own}
    if not others & _occurring_symbols(field, own):
        return Verdict("proved", "the equations hold no other variable")
    rates = dict(zip(field.variables, field.components, strict=True))
    short = canonical([rates[x] for x in own], field.hypotheses)
    for x, rate in zip(own, short, strict=True):
        met = sorted(rate.free_symbols & others, key=str)
        if met:
            return _refutation(field, own, x, rate, met)
    return Verdict("proved", "the normal forms of the rates hold no other variable")


def _occurring_symbols(field: VectorField, own: Sequence[Any]) -> set[Any]:
    """The symbols in the equations for ``own``; for a velocity in it, all of mass and force."""
    needed = [rate for q, rate in zip(field.positions, field.rates, strict=True) if q in own]
    if {*field.velocities} & {*own}:
        needed += [*field.force, *(e for row in field.mass for e in row)]
        needed += [v for v in field.velocities if v not in own]
    return {s for e in needed for s in e.free_symbols}


def _refutation(
    field: VectorField, own: Sequence[Any], x: Any, rate: Any, met: Sequence[Any]
) -> Verdict:
    """A point at which a rate changes with another variable while ``own`` stay."""
    bound = {s for r in field.relations for s in r.free_symbols}
    for y in met:
        if y not in bound:
            verdict = decide_zero(rate.diff(y), field.hypotheses)
            if verdict.refuted:
                why = f"the rate of '{x}' changes with '{y}': its derivative"
                return Verdict("refuted", why, verdict.witness)
    unit = [[int(a == b) for b in field.variables] for a in own]
    slopes = [e.diff(b) for e in (*field.relations, rate) for b in field.variables]
    width = len(field.variables)
    for _, values in sample_evaluable(Tape(slopes), field.hypotheses, GENERIC):
        rows = [values[i : i + width] for i in range(0, len(values), width)]
        given = [[0 * values[0] + e for e in row] for row in unit] + rows[:-1]
        if proved_rank([*given, rows[-1]], GENERIC) > proved_rank(given, GENERIC):
            why = f"the rate of '{x}' changes with '{met[0]}', by rank at a point"
            return Verdict("refuted", why)
    return Verdict("undecided", f"the rate of '{x}' seems to be free of '{met[0]}' (no proof)")

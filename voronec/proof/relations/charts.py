"""Charts proved: the same motion, in coordinates that go over into one another.

A chart is a relation of a system to itself in other coordinates, DPhi f = g(Phi), together with an
inverse: Psi(Phi(x)) = x where the factors of ``singular`` are positive.  The sheets T of its
double cover give the same state as x: Phi(T(x)) = Phi(x).
"""

from __future__ import annotations

import time as clock
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.angles import Angles
from voronec.algebra.symbols import plain_name
from voronec.algebra.terms import factors_of
from voronec.algebra.verdicts import Verdict
from voronec.declaration.charts import Chart
from voronec.declaration.claims import without_claims
from voronec.declaration.relation import Relation
from voronec.declaration.system import System, system_in
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.proof.branch_cuts import not_vacuous
from voronec.proof.claims import Claim
from voronec.proof.decision import all_zero, verdict_of
from voronec.proof.relations.decision import decided_at_limit
from voronec.proof.relations.parameters import applications
from voronec.proof.relations.statemap import StateMap, is_period


def check_charts(motions: Motions) -> Iterator[Claim]:
    """A claim of kind ``chart`` for every chart of a system."""
    system = motions.system
    for name in system.charts:
        begin = clock.perf_counter()
        verdict = verdict_of(partial(_decide, motions, name))
        seconds, reason = clock.perf_counter() - begin, system.undecided.get(name, "")
        yield Claim("chart", name, verdict, "coordinates", seconds, reason=reason)


def _decide(motions: Motions, name: str) -> Verdict:
    chart, there = motions.system.charts[name], system_in(motions.system, name)
    inverse = _inverse(motions, chart)
    if not inverse.proved:
        return replace(inverse, method=f"there and back: {inverse.method}")
    away = Motions.of(there)
    for sheet in chart.sheet_values(motions.system):
        same = _same_state(motions, away, chart, sheet)
        if not same.proved:
            return replace(same, method=f"double cover: {same.method}")
    home = replace(motions.equations, system=_bare(motions.system))
    known = {home.system.name: Motions(home), there.name: away}
    parameters = {p.symbol: p.symbol for p in motions.system.parameters}
    for function, applied in applications(known[there.name].on_coordinates).items():
        formal = sp.Function(function)(*sp.symbols(f"s1:{len(applied[0].args) + 1}"))
        parameters[formal] = formal
    relation = Relation(
        home.system.name, there.name, state=chart.values(motions.system), parameters=parameters
    )
    verdict = decided_at_limit(StateMap.of(relation, known.__getitem__), beyond=False)[1]
    verdict = not_vacuous(verdict, motions.on_coordinates)
    return replace(verdict, modulo=verdict.modulo or inverse.modulo) if verdict.proved else verdict


def _bare(system: System) -> System:
    """A system without its invariants: charts are maps of coordinates."""
    return replace(system, **without_claims(), invariants={}, scenes={}, charts={})


def _inverse(motions: Motions, chart: Chart) -> Verdict:
    """Whether the way there and back ends where it began; angles of it up to whole turns."""
    field, system = motions.on_coordinates, motions.system
    read = {x: field.bridge.inward(x) for x in (*system.coordinates, *system.velocities)}
    there = {read[x]: field.read(e) for x, e in chart.values(system).items()}
    positive = _factors(field.read(chart.singular))
    angles = Angles(field.relations, positive)
    back = chart.values(system, "back").items()
    pairs = [(x, field.read(e).xreplace(there) - read[x]) for x, e in back]
    known = (*field.hypotheses, *(f > 0 for f in positive if f.free_symbols))
    turned = _up_to_turns(pairs, angles, field)
    verdict = all_zero(turned, known)
    return replace(verdict, modulo="2*pi") if len(turned) > len(pairs) else verdict


def _same_state(
    motions: Motions, there: Motions, chart: Chart, sheet: Mapping[Any, Any]
) -> Verdict:
    """Whether a state on another sheet has the same image; angles there up to whole turns."""
    field, system = motions.on_coordinates, motions.system
    other = {field.bridge.inward(x): field.read(e) for x, e in sheet.items()}
    images = [(x, field.read(e)) for x, e in chart.values(system).items()]
    pairs = [(x, se.expand(e.xreplace(other) - e)) for x, e in images]
    turned = _up_to_turns(pairs, Angles(field.relations), there.on_coordinates)
    return all_zero(turned, field.hypotheses)


def _up_to_turns(
    pairs: Iterable[tuple[Any, Any]], angles: Angles, field: VectorField
) -> list[tuple[str, Any]]:
    """What must vanish where differences do, those of angles of a field up to whole turns."""
    residuals = []
    for x, difference in pairs:
        label, variable, off = plain_name(x), field.bridge.inward(x), angles.resolve(difference)
        turns = (
            bool(off.atoms(se.atan2))
            and variable in field.positions
            and is_period(field.entries, field.relations, variable, 2 * se.pi)
        )
        if turns:
            residuals += [
                (f"sin({label})", angles.resolve(se.sin(off))),
                (f"cos({label})", angles.resolve(se.cos(off)) - 1),
            ]
        else:
            residuals.append((label, off))
    return residuals


def _factors(product: Any) -> tuple[Any, ...]:
    return factors_of(product)

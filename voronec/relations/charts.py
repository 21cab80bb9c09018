"""Charts proved: the same motion, in coordinates that go over into one another.

A chart is a relation of a system to itself in other coordinates, DPhi f = g(Phi), together with an
inverse: Psi(Phi(x)) = x where the factors of ``singular`` are positive.
"""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import symengine as se

from voronec.algebra.angles import Angles
from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import Verdict
from voronec.analysis.claims import Claim
from voronec.analysis.decision import all_zero
from voronec.charts import Chart, system_in
from voronec.errors import EngineLimit
from voronec.relations.checking import decided_at_limit
from voronec.relations.declaration import Relation
from voronec.relations.statemap import StateMap
from voronec.system import System
from voronec.vector_field import Motions

__all__ = ["check_charts"]


def check_charts(motions: Motions) -> Iterator[Claim]:
    """A claim of kind ``chart`` for every chart of a system."""
    own = motions.system
    for name in own.charts:
        begin = clock.perf_counter()
        try:
            verdict = _decided(motions, name)
        except EngineLimit as limit:
            verdict = Verdict("undecided", str(limit))
        yield Claim(
            kind="chart",
            name=name,
            verdict=verdict,
            level="coordinates",
            seconds=clock.perf_counter() - begin,
            reason=own.undecided.get(name, ""),
        )


def _decided(motions: Motions, name: str) -> Verdict:
    chart, there = motions.system.charts[name], system_in(motions.system, name)
    inverse = _inverse(motions, chart)
    if not inverse.proved:
        return replace(inverse, method=f"there and back: {inverse.method}")
    home = replace(motions.equations, system=_bare(motions.system))
    known = {home.system.name: Motions(home), there.name: Motions.of(there)}
    relation = Relation(
        home.system.name,
        there.name,
        state=chart.values(motions.system),
        parameters={p.symbol: p.symbol for p in motions.system.parameters},
    )
    return decided_at_limit(StateMap.of(relation, known.__getitem__))[1]


def _bare(system: System) -> System:
    """A system without its invariants: charts are maps of coordinates."""
    return replace(
        system, invariants={}, integrals={}, equations={}, measure=None, poisson=None, essential=(),
        integrable="", cases={}, undecided={}, scenes={}, charts={}, multiplier=None,
    )  # fmt: skip


def _inverse(motions: Motions, chart: Chart) -> Verdict:
    """Whether the way there and back ends where it began; angles up to whole turns."""
    field, system = motions.on_coordinates, motions.system
    read = {x: field.door.inward(x) for x in (*system.coordinates, *system.velocities)}
    there = {read[x]: field.read(e) for x, e in chart.values(system).items()}
    angles = Angles(field.relations, _factors(field.read(chart.singular)))
    residuals = []
    for x, e in chart.values(system, "back").items():
        off = field.read(e).xreplace(there) - read[x]
        label, off = plain_name(x), angles.resolved(off)
        if off.atoms(se.atan2):
            residuals += [
                (f"sin({label})", angles.resolved(se.sin(off))),
                (f"cos({label})", angles.resolved(se.cos(off)) - 1),
            ]
        else:
            residuals.append((label, off))
    return all_zero(residuals, field.relations)


def _factors(product: Any) -> tuple[Any, ...]:
    return product.args if isinstance(product, se.Mul) else (product,)

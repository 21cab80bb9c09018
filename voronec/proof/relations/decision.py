"""Relations decided in the exact algebra: DPhi f = nu g(Phi), and what it does to claims."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import symengine as se

from voronec.algebra.conditions import split_hypotheses
from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import determinant
from voronec.algebra.rank import generic_rank
from voronec.algebra.typeset import html_table
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.declaration.relation import Relation
from voronec.equations.motions import Motions
from voronec.errors import EngineLimit
from voronec.proof.claims import Claim
from voronec.proof.relations.carried_claims import pulled_claims
from voronec.proof.relations.dependence import moving_parameters, unsound_functions
from voronec.proof.relations.kinds import kinds_of
from voronec.proof.relations.orders import all_at_zero, at_zero, vanishes
from voronec.proof.relations.statemap import StateMap
from voronec.proof.walls import across_walls

__all__ = [
    "CheckedRelation",
    "check_relation",
    "complete_velocities",
    "decided_at_limit",
    "residuals",
]


def residuals(statemap: StateMap) -> Iterator[tuple[str, Any]]:
    """Rates of parameters, relations of the target, rates of its positions, its equations.

    Each comes with what a message calls it [Theory, eq. (15)].
    """
    target, pull, nu = statemap.target, statemap.pull_back, statemap.clock
    yield from moving_parameters(statemap)
    for i, relation in enumerate(target.relations):
        yield f"relation {i + 1} of '{target.system.name}'", pull(relation)
    if _is_timed(statemap):
        yield "the time", statemap.derivative(statemap.state[target.time]) - nu
    for q, rate in zip(target.positions, target.rates, strict=True):
        yield f"d{q}/dt", statemap.derivative(statemap.state[q]) - nu * pull(rate)
    yield from _motion(statemap)


def _motion(statemap: StateMap) -> Iterator[tuple[str, Any]]:
    """mass(Phi) d/dt Phi_v - nu force(Phi) for the velocities of the target.

    The accelerations in a row are slopes . vdot; with y mass = slopes in the source, they are
    y . force.
    """
    target, source, pull = statemap.target, statemap.source, statemap.pull_back
    images = [statemap.state[v] for v in target.velocities]
    at_rest = [statemap.scale(source.at_rest(e)) for e in images]
    forces = [statemap.scale(f) for f in source.force]
    for v, row, force in zip(target.velocities, target.mass, target.force, strict=True):
        mass = [pull(e) for e in row]
        slopes = [
            se.Add(*[m * statemap.scale(e.diff(w)) for m, e in zip(mass, images, strict=True)])
            for w in source.velocities
        ]
        y = _multiples(statemap, slopes)
        moved = [a * f for a, f in zip(y, forces, strict=True)]
        moved += [m * e for m, e in zip(mass, at_rest, strict=True)]
        yield f"the equation of '{v}'", se.Add(*moved) - statemap.clock * pull(force)


def _multiples(statemap: StateMap, slopes: Sequence[Any]) -> list[Any]:
    """y with y mass = slopes: where slopes are a multiple of one row, nothing has to be solved."""
    source = statemap.source
    if all(s == 0 for s in slopes):
        return [se.Integer(0)] * len(slopes)
    for index, row in enumerate(source.mass):
        factor = _factor(statemap, slopes, row)
        if factor is not None:
            return [factor if i == index else se.Integer(0) for i in range(len(slopes))]
    return [statemap.scale(line[0]) for line in source.solve([[s] for s in slopes])]


def _factor(statemap: StateMap, slopes: Sequence[Any], row: Sequence[Any]) -> Any:
    """The factor with slopes = factor * row, proved; ``None`` where there is none."""
    scaled = [statemap.scale(e) for e in row]
    at = next((i for i, e in enumerate(scaled) if e != 0), None)
    if at is None or slopes[at] == 0:
        return None
    factor = se.Integer(1) if slopes[at] == scaled[at] else slopes[at] / scaled[at]
    try:
        for s, e in zip(slopes, scaled, strict=True):
            if not decide_zero(s - factor * e, statemap.hypotheses).proved:
                return None
    except EngineLimit:
        return None
    return factor


def _is_timed(statemap: StateMap) -> bool:
    """Whether the time of the target matters, or is mapped."""
    target = statemap.target
    given = {str(k) for k in statemap.relation.state or {}}
    return str(target.time) in given or any(target.time in e.free_symbols for e in target.entries)


@dataclass(frozen=True, repr=False)
class CheckedRelation:
    """A relation with its verdict.

    ``kinds`` says what it is, as computed from the maps; ``levels`` on which variables of source
    and target it stands, ``coordinates`` or ``invariants``.  ``pulled`` are the claims of the
    target, carried to the source, each with its verdict there.
    """

    relation: Relation
    kinds: tuple[str, ...]
    levels: tuple[str, str]
    verdict: Verdict
    pulled: tuple[Claim, ...]
    seconds: float

    def __repr__(self) -> str:
        ends = f"{self.relation.source!r}, {self.relation.target!r}"
        return f"CheckedRelation({ends}, {', '.join(self.kinds)}: {self.verdict.status})"

    def _repr_html_(self) -> str:
        """For notebooks: the maps, the verdict, and the claims that are carried along."""
        maps = [(str(name), str(value)) for name, value in (self.relation.state or {}).items()]
        rows = [("verdict", self.verdict.status), ("kind", ", ".join(self.kinds)), *maps]
        rows += [(f"{c.kind}: {c.name}", c.standing) for c in self.pulled]
        return html_table(f"{self.relation.source} to {self.relation.target}", rows)


def check_relation(relation: Relation, motions: Callable[[str], Motions]) -> CheckedRelation:
    """Decide a relation and the claims that it carries from the target to the source.

    ``motions`` gives the motions of a system by its name.
    Raises ``DefinitionError`` where the relation maps too little or too much.
    """
    start = clock.perf_counter()
    statemap = complete_velocities(StateMap.of(relation, motions))
    stated, verdict = decided_at_limit(statemap)
    pulled = pulled_claims(stated) if not verdict.refuted else ()
    return CheckedRelation(
        relation=relation,
        kinds=kinds_of(_stated_map(statemap, stated)),
        levels=(statemap.source.level, statemap.target.level),
        verdict=verdict,
        pulled=tuple(pulled),
        seconds=clock.perf_counter() - start,
    )


def decided_at_limit(statemap: StateMap) -> tuple[StateMap, Verdict]:
    """The verdict, and the map on which it was found.

    A limit of first order, where everything has one, is an exact relation of the limits: all that
    is in a residual is continuous there.
    """
    limit = statemap.relation.limit
    if limit is not None and limit.order == 1:
        try:
            there = at_limit(statemap)
            verdict = _decide_map(there)
            if not verdict.undecided:
                return there, verdict
        except EngineLimit:
            pass  # a pole that cancels, say: the residuals are expanded instead
    return statemap, _decide_map(statemap)


def _stated_map(statemap: StateMap, decided: StateMap) -> StateMap:
    """The map that the relation is about: that of the limit, where there is one."""
    if decided.small is None:
        return decided
    try:
        return at_limit(statemap)
    except EngineLimit:
        return statemap


def at_limit(statemap: StateMap) -> StateMap:
    """The relation where the small parameter vanishes; ``EngineLimit`` where that is singular."""
    source, small, rules = statemap.source, statemap.small, statemap.hypotheses

    def there(exprs: Iterable[Any]) -> tuple[Any, ...]:
        return tuple(at_zero(statemap.scale(e), rules, small) for e in exprs)

    field = replace(
        source,
        rates=there(source.rates),
        mass=tuple(map(there, source.mass)),
        force=there(source.force),
        relations=there(source.relations),
        conditions=tuple(c for c in split_hypotheses(rules)[1] if small not in c.free_symbols),
    )
    unit = [[se.Integer(0)] for _ in field.velocities]
    if unit and solve_linear(field.mass, unit, field.hypotheses).free:
        raise EngineLimit(f"the mass matrix is singular where '{small}' vanishes")
    return replace(
        statemap,
        source=field,
        state=dict(zip(statemap.state, there(statemap.state.values()), strict=True)),
        parameters=dict(zip(statemap.parameters, there(statemap.parameters.values()), strict=True)),
        clock=there([statemap.clock])[0],
        small=None,
        scaled={},
    )


def _decide_map(statemap: StateMap) -> Verdict:
    """Whether DPhi f = nu g(Phi), with nu not zero and a target that is determined there."""
    for verdict in (*_grounds(statemap), *unsound_functions(statemap)):
        if not verdict.proved:
            return verdict
    for place, residual in residuals(statemap):
        verdict = _decide(statemap, residual)
        if not verdict.proved:
            return replace(verdict, method=f"{place}: {verdict.method}")
    return _across_walls(statemap, Verdict("proved", "zero in exact normal form"))


def _across_walls(statemap: StateMap, verdict: Verdict) -> Verdict:
    """The proof with the walls of the map: positions and the time may jump by periods; parameters
    that hold state, velocities and the clock may not jump."""
    target, field = statemap.target, statemap.scaled_source
    held = [(f"the parameter '{p}'", e) for p, e in statemap.parameters.items() if p.is_Symbol]
    verdict = across_walls(verdict, field, held, periods=False, constant=True)
    places = [*target.positions, target.time]
    at = [(f"the image '{x}'", statemap.state[x]) for x in places]
    verdict = across_walls(verdict, field, at)
    fast = [(f"the image '{v}'", statemap.state[v]) for v in target.velocities]
    return across_walls(verdict, field, [*fast, ("the clock", statemap.clock)], periods=False)


def _grounds(statemap: StateMap) -> Iterator[Verdict]:
    """Whether the clock runs and the target is determined, at the limit where there is one."""
    small, rules = statemap.small, statemap.hypotheses
    where = "" if small is None else f" where '{small}' vanishes"
    try:
        clock_there = at_zero(statemap.clock, rules, small)
        mass = [
            [at_zero(statemap.pull_back(e), rules, small) for e in row]
            for row in statemap.target.mass
        ]
        there = all_at_zero(rules, small)
    except EngineLimit as limit:
        yield Verdict("undecided", f"the clock or the mass of the target: {limit}")
        return
    stands = decide_zero(clock_there, there)
    if stands.proved:
        yield Verdict("refuted", f"the clock stands still{where}")
    elif stands.undecided:
        yield Verdict("undecided", f"whether the clock runs{where}: {stands.method}")
    yield _is_determined(mass, there, where)


def _is_determined(mass: list[list[Any]], relations: Sequence[Any], where: str) -> Verdict:
    """Whether the target's equations of motion determine its accelerations on the image."""
    try:
        if generic_rank(mass, relations) == len(mass):
            return Verdict("proved", "a point where the mass matrix is regular")
        if decide_zero(determinant(mass), relations).proved:
            why = f"the mass matrix of the target is singular on the image{where}"
            return Verdict("refuted", why)
        reason = "its determinant is not proved to vanish"
    except EngineLimit as limit:
        reason = str(limit)
    return Verdict("undecided", f"whether the mass of the target is regular{where}: {reason}")


def _decide(statemap: StateMap, residual: Any) -> Verdict:
    limit = statemap.relation.limit
    order = 1 if limit is None else limit.order
    try:
        return vanishes(residual, statemap.hypotheses, statemap.small, order)
    except EngineLimit as error:
        return Verdict("undecided", str(error))


def complete_velocities(statemap: StateMap) -> StateMap:
    """The map with the velocities that follow from the positions: v(q', q), q' = q-dot / nu."""
    target = statemap.target
    missing = [v for v in target.velocities if v not in statemap.state]
    if not missing:
        return statemap
    dots = {
        dot: statemap.derivative(statemap.state[q]) / statemap.clock
        for q, dot in zip(target.positions, target.dots, strict=True)
    }
    partial = replace(statemap, state={**statemap.state, **dots})
    found = {v: partial.pull_back(target.definitions[v]) for v in missing}
    return replace(statemap, state={**statemap.state, **found})

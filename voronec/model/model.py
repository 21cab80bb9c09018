"""The smallest model of a scene: what is integrated, what follows from it, what is left out.

On every level of the equations the smallest closed set of variables is taken that the wanted
outputs need; constants and what stays at zero are frozen, first integrals stand in for equations;
and of the levels the one whose program costs least is chosen.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import symengine as se
import sympy as sp

from voronec.algebra.verdicts import all_vanish
from voronec.errors import EngineLimit
from voronec.model.absent import absent
from voronec.model.dependence import cyclic, dependence, needed_variables, restricted
from voronec.model.level import Level, coordinates_level, invariants_level
from voronec.model.momenta import momenta_level
from voronec.model.special import at_zero, by_integrals, constants, without_parameters
from voronec.program import Program
from voronec.system import System
from voronec.vector_field import Motions

if TYPE_CHECKING:
    import networkx as nx

__all__ = ["Candidate", "Model", "Role", "smallest_model"]


@dataclass(frozen=True)
class Role:
    """What became of one variable, and why.

    ``kind`` is ``integrated``, ``quadrature``, ``constant``, ``zero``, ``integral`` (given by a
    first integral), ``read off`` (an angle from invariants), ``replaced`` (the level has other
    variables) or ``dropped``.
    """

    variable: str
    kind: str
    why: str


@dataclass(frozen=True)
class Candidate:
    """One level that was weighed: its number of states, operations, weight; why it was left."""

    level: str
    states: int
    operations: int
    weight: float
    chosen: bool = False


@dataclass(frozen=True)
class Model:
    """The equations that a scene needs.

    ``level`` says in which variables they stand; ``roles`` what became of each variable;
    ``candidates`` which levels were weighed.  ``form`` is what programs are made of, ``outputs``
    and ``integrals`` are expressions on it; ``frozen`` maps symbols that became parameters to what
    they are at the start, in coordinates and velocities, as ``start`` does for the states.
    """

    reduced: Level
    whole: Level
    roles: tuple[Role, ...]
    candidates: tuple[Candidate, ...]
    frozen: Mapping[Any, Any] = field(default_factory=dict)

    @property
    def system(self) -> System:
        """The system."""
        system: System = self.reduced.system
        return system

    @property
    def level(self) -> str:
        """``coordinates``, ``invariants``, or these with momenta."""
        return self.reduced.name

    @property
    def states(self) -> tuple[Any, ...]:
        """The variables that are integrated."""
        return self.reduced.variables

    @property
    def start(self) -> dict[Any, Any]:
        """Each state in terms of coordinates and velocities of the equations."""
        return {x: self.reduced.start[x] for x in self.states}

    @cached_property
    def program(self) -> Program:
        """Right-hand side, outputs and integrals as one straight-line program."""
        return Program.of(self.reduced.form, self.reduced.outputs)

    @property
    def graph(self) -> nx.DiGraph:
        """Which rate holds which variable, on the whole level; nodes carry their ``kind``."""
        graph = dependence(self.whole)
        kinds = {role.variable: role.kind for role in self.roles}
        for node in graph:
            graph.nodes[node]["kind"] = kinds.get(str(node), "dropped")
        return graph

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold of it."""
        return {
            "system": self.system.name,
            "level": self.level,
            "states": [str(x) for x in self.states],
            "variables": [
                {"name": r.variable, "kind": r.kind, "why": r.why} for r in self.roles
            ],
            "integrals": list(self.reduced.integrals),
            "levels": [
                {
                    "name": c.level, "states": c.states, "operations": c.operations,
                    "weight": c.weight, "chosen": c.chosen,
                }
                for c in self.candidates
            ],
            "edges": [[str(a), str(b)] for a, b in self.graph.edges],
        }  # fmt: skip


@dataclass(frozen=True)
class _Particular:
    """What is known of one motion: zero parameters and variables, numbers of expressions."""

    values: Mapping[Any, float]

    def number(self, expr: Any) -> float:
        """The value of an expression of the start; infinite where it has none."""
        try:
            return float(expr.subs(dict(self.values)).n(53, real=True))
        except (RuntimeError, TypeError, ValueError):
            return float("inf")


def smallest_model(
    motions: Motions,
    wanted: Mapping[str, sp.Expr],
    integrals: Mapping[str, sp.Expr],
    start: Mapping[Any, float] | None = None,
    thorough: bool = False,
    followed: Collection[str] = (),
) -> Model:
    """The cheapest model in which the wanted quantities can be computed.

    ``wanted`` and ``integrals`` are expressions in the user's symbols, invariants among them;
    ``start`` gives numbers of coordinates, velocities, parameters and the time, as symbols inside
    the door: with it, what is zero is frozen; without it, the model holds for all starts.  Where
    invariants alone suffice, coordinates are weighed only in a ``thorough`` search: they hold the
    same products, and sines besides.  Outputs that are ``followed`` are not read off as angles.
    """
    levels = _levels(motions, wanted, integrals, thorough, followed)
    models = [_reduced(motions, level, start) for level in levels]
    best = min(models, key=lambda m: (m.candidates[0].weight, m.candidates[0].states))
    weighed = tuple(replace(m.candidates[0], chosen=m is best) for m in models)
    return replace(best, candidates=weighed)


def _levels(
    motions: Motions,
    wanted: Mapping[str, sp.Expr],
    integrals: Mapping[str, sp.Expr],
    thorough: bool,
    followed: Collection[str],
) -> Iterator[Level]:
    """The levels to weigh."""
    reduced = invariants_level(motions, wanted, integrals, followed)
    if reduced is not None:
        yield from _with_momenta(reduced)
        alone = len(reduced.positions) == len(motions.system.invariants)
        if alone and not thorough:
            return
    yield from _with_momenta(coordinates_level(motions, wanted, integrals))


def _with_momenta(level: Level) -> Iterator[Level]:
    yield level
    momenta = momenta_level(level)
    if momenta is not None:
        yield momenta


def _reduced(motions: Motions, whole: Level, start: Mapping[Any, float] | None) -> Model:
    """One level cut down to what its outputs need."""
    roles: dict[Any, Role] = {}

    def note(x: Any, kind: str, why: str) -> None:
        roles[x] = Role(str(x), kind, why)

    level = whole
    known = None if start is None else _Particular(_at_start(whole, start))
    if known is not None:
        zero = {p: se.Integer(0) for p in whole.parameters if known.values.get(p) == 0}
        level = without_parameters(level, zero)
    level = _closed(level, note, "no output depends on it")
    if known is not None:
        zeros = {x for x in level.variables if known.values.get(x) == 0}
        plane = at_zero(level, zeros)
        for x in plane:
            note(x, "zero", "zero at the start, and then for ever: its rate vanishes there")
        left = [x for x in level.variables if x not in plane]
        level = restricted(level.substituted(dict.fromkeys(plane, se.Integer(0))), left)
        level = _closed(level, note, "no output depends on it where the others are zero")
    frozen: dict[Any, Any] = {}
    for x in constants(level):
        note(x, "constant", "its rate vanishes identically")
        frozen[x] = whole.start[x]
    if frozen:
        left = [x for x in level.variables if x not in frozen]
        level = replace(level, parameters=(*level.parameters, *frozen))
        level = _closed(restricted(level, left), note, "")
    level, given = by_integrals(
        level,
        lambda name: _is_integral(whole, name),
        known.number if known is not None else _Particular({}).number,
        set(),
    )
    for x, (name, symbol, integral) in given.items():
        note(x, "integral", f"given by the first integral '{name}'")
        frozen[symbol] = integral.xreplace(dict(whole.start))
    turning = cyclic(dependence(level), level.variables)
    for x in level.variables:
        if x in turning:
            note(x, "integrated", "in a cycle: the rates depend on one another")
        else:
            note(x, "quadrature", "follows from others, which do not depend on it")
    for name, angle in level.angles.items():
        roles.setdefault(name, Role(name, "read off", _angle_words(angle)))
    needed = {x for x in whole.variables if x in roles and roles[x].kind != "dropped"}
    d = motions.equations.definition
    for x, holders in absent(whole, needed, (*d.coordinates, *d.velocities)):
        if str(x) not in level.angles:
            why = f"by {holders}" if holders else "no output depends on it"
            note(x, "replaced" if holders else "dropped", why)
    program = Program.of(level.form)
    summary = Candidate(level.name, len(level.variables), program.operations, _weight(program))
    order = {x: i for i, x in enumerate([*whole.variables, *whole.angles])}
    sorted_roles = sorted(roles.items(), key=lambda item: order.get(item[0], len(order)))
    return Model(level, whole, tuple(r for _, r in sorted_roles), (summary,), frozen)


def _weight(program: Program) -> float:
    return float(getattr(program, "weight", program.operations))


def _angle_words(angle: Any) -> str:
    return f"atan2({angle.sine}, {angle.cosine}), up to the branch"


def _at_start(level: Level, start: Mapping[Any, float]) -> dict[Any, float]:
    """Numbers of the level's own variables, of the parameters and the time."""
    given = _Particular(start)
    own = {x: given.number(meaning) for x, meaning in level.start.items() if x != meaning}
    return {**start, **own}


def _closed(level: Level, note: Any, why: str) -> Level:
    kept = needed_variables(level, dependence(level))
    for x in level.variables:
        if x not in kept:
            note(x, "dropped", why)
    return restricted(level, kept)


def _is_integral(level: Level, name: str) -> bool:
    """Whether a declared integral is proved to be one, on the level."""
    integral = level.integrals[name]
    slopes = [integral.diff(q) * r for q, r in zip(level.positions, level.rates, strict=True)]
    slopes.append(integral.diff(level.time))
    held = [i for i, v in enumerate(level.velocities) if integral.diff(v) != 0]
    for i in held:
        if any(level.mass[i][j] != 0 for j in range(len(level.velocities)) if j != i):
            return False
        slopes.append(integral.diff(level.velocities[i]) * level.force[i] / level.mass[i][i])
    total = se.Add(*slopes)
    stages = dict(level.stages)
    while total.free_symbols & stages.keys():
        total = total.xreplace(stages)
    try:
        return all_vanish([total], level.relations)
    except EngineLimit:
        return False

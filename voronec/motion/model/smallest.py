"""The smallest model of a scene: from levels of the equations to the one that costs least.

On every level of the equations the smallest closed set of variables is taken that the wanted
outputs need; constants and what stays at zero are frozen, first integrals stand in for equations;
and of the levels the one whose program costs least is chosen.

A model says what is integrated, what follows, and what is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import symengine as se
import sympy as sp

from voronec.algebra.memo import Memo
from voronec.algebra.typeset import html_table
from voronec.declaration.system import System
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.motions import Motions
from voronec.equations.program import Program
from voronec.motion.model.level import (
    Level,
    coordinates_level,
    cyclic,
    dependence,
    invariants_level,
    keep_relations,
    needed_variables,
    restrict,
)
from voronec.motion.model.model_cache import ModelCache
from voronec.motion.model.special import (
    at_zero,
    by_integrals,
    constants,
    level_of,
    vanish,
    without_parameters,
)
from voronec.motion.model.variables import momenta_level, relative_level

if TYPE_CHECKING:
    import networkx as nx


def absent(level: Level, needed: set[Any], names: tuple[Any, ...]) -> Iterator[tuple[Any, str]]:
    """Which of the ``names`` are no variables of the level, and in which needed ones each stands.

    The list is empty where nothing that is needed holds it.
    """
    for x in names:
        if x in level.variables:
            continue
        holders = [
            str(y) for y in level.variables if y in needed and x in level.start[y].free_symbols
        ]
        yield x, ", ".join(holders)


MOST = 8
"""For so many sets of outputs equations keep their models."""
MODELS = 32
"""So many models, of starts with other zeros, are kept for one set of outputs."""
AMPLIFICATION = 100.0
"""An integral gives a variable only where it enlarges errors of the others by less than this."""

Note = Callable[[Any, str, str], None]
"""Takes down what became of a variable: the variable, the kind of role, the reason."""


@dataclass
class _Particular:
    """What is known of one motion on a level: numbers of variables, parameters and the time, and
    what was ``asked`` of them so far: slopes of integrals, and whether these are steep enough."""

    values: Mapping[Any, float]
    asked: list[tuple[Any, tuple[Any, ...], bool]] = field(default_factory=list)

    def numbers(self, exprs: tuple[Any, ...]) -> list[float]:
        """The values of expressions of the start; infinite where one has none."""
        function = _function(tuple(self.values), exprs)
        if function is None:
            return [inf] * len(exprs) if len(exprs) == 1 else [self.numbers((e,))[0] for e in exprs]
        found = function([*self.values.values(), 0.0])
        return [x if isfinite(x) else inf for x in found.tolist()]

    def is_steep(self, slope: Any, others: tuple[Any, ...]) -> bool:
        """Whether an integral with this slope gives its variable well, beside its other slopes."""
        size, *beside = map(abs, self.numbers((slope, *others)))
        answer = size > 0 and sum(beside) <= AMPLIFICATION * size
        self.asked.append((slope, others, answer))
        return answer

    def zeros(self, names: Iterable[Any]) -> frozenset[Any]:
        """Which variables and parameters are zero."""
        return frozenset(x for x in names if self.values.get(x) == 0)


@lru_cache(maxsize=1024)  # every start asks for the same
def _function(symbols: tuple[Any, ...], exprs: tuple[Any, ...]) -> Any:
    """Expressions as a function of the values of symbols; None where one of them is none."""
    try:
        # of no symbols there is none, and no name of a user holds spaces
        return se.Lambdify([*symbols, se.Symbol("no symbol")], [*exprs])
    except (RuntimeError, TypeError, ValueError, NotImplementedError):
        return None


@dataclass(frozen=True)
class ModelSearch:
    """A model, and all that was asked of the start that it was made for: zeros and steep slopes,
    level by level.  Another start that gives the same answers has the same model.  It is kept under
    its ``name``, and what is made of it under names that begin so."""

    name: str
    model: Model
    zeros: tuple[frozenset[Any], ...]
    asked: tuple[tuple[tuple[Any, tuple[Any, ...], bool], ...], ...]

    def holds(self, zeros: tuple[frozenset[Any], ...], starts: Sequence[_Particular]) -> bool:
        """Whether the model is that of a start with these zeros."""
        return zeros == self.zeros and all(
            start.is_steep(slope, others) == answer
            for start, questions in zip(starts, self.asked, strict=True)
            for slope, others, answer in questions
        )


class SmallestModels:
    """The smallest models of one set of outputs, by start: the levels that they are chosen from,
    and those that were found so far, in this process or in earlier ones (``packs``)."""

    def __init__(
        self, model_cache: ModelCache, motions: Motions, make: Callable[[], Iterable[Level]]
    ) -> None:
        self.model_cache = model_cache
        self._motions = motions
        self._levels: tuple[Level, ...] = model_cache.once("levels", lambda: tuple(make()))
        self._findings: list[ModelSearch] = []
        while (name := self._next_name) in model_cache:
            self._findings.append(model_cache.value_of(name))

    @classmethod
    def of(
        cls,
        motions: Motions,
        wanted: Mapping[str, sp.Expr],
        integrals: Mapping[str, sp.Expr],
        thorough: bool = False,
        followed: Collection[str] = (),
    ) -> SmallestModels:
        """The models of what is ``wanted``, as ``smallest_model`` takes it."""
        kept: dict[Any, Any] = motions.equations.memo.once("smallest models", dict)
        key = (tuple(wanted.items()), tuple(integrals.items()), thorough, (*sorted(followed),))
        if key not in kept:
            if len(kept) >= MOST:
                kept.clear()
            # constraints are solved so that this is defined at a point, and as well conditioned
            d = motions.equations.definition
            model_cache = ModelCache(motions.system, [key, d.near, d.share])
            levels = partial(_levels, motions, wanted, integrals, thorough, followed)
            kept[key] = cls(model_cache, motions, levels)
        found: SmallestModels = kept[key]
        return found

    @property
    def _next_name(self) -> str:
        return f"model {len(self._findings)}"

    @cached_property
    def general(self) -> Model:
        """The model that holds for all starts."""
        levels = (_cut_down(self._motions, level, level, None) for level in self._levels)
        found = self.model_cache.once("general", lambda: _cheapest([*levels]))
        self.model_cache.keep()
        return found

    @cached_property
    def without_integrals(self) -> Model:
        """The model that holds for all starts, in which no integral stands in for an equation: its
        variables are those of the phase space."""
        levels = (_cut_down(self._motions, e, e, None, False) for e in self._levels)
        found = self.model_cache.once("without integrals", lambda: _cheapest([*levels]))
        self.model_cache.keep()
        return found

    def of_start(self, start: Mapping[Any, float]) -> ModelSearch:
        """The model of a start; starts of which nothing else is known than of another have its."""
        values = [_at_start(level, start) for level in self._levels]
        starts = [_Particular(each) for each in values]
        pairs = zip(self._levels, starts, strict=True)
        zeros = tuple(s.zeros((*level.variables, *level.parameters)) for level, s in pairs)
        for finding in self._findings:
            if finding.holds(zeros, starts):
                return finding
        if len(self._findings) >= MODELS:
            self._findings.clear()
            self.model_cache.forget("model")
        found = self.model_cache.once(self._next_name, lambda: self._find(zeros, values))
        self._findings.append(found)
        return found

    def _find(
        self, zeros: tuple[frozenset[Any], ...], values: Sequence[Mapping[Any, float]]
    ) -> ModelSearch:
        starts = [_Particular(each) for each in values]
        model = _cheapest([
            min((_cut_down(self._motions, full, level, known)
                 for level in _without_zeros(full, known)), key=_cost)
            for full, known in zip(self._levels, starts, strict=True)
        ])  # fmt: skip
        return ModelSearch(self._next_name, model, zeros, tuple(tuple(s.asked) for s in starts))


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
    the engine's symbols: with it, what is zero is frozen; without it, the model holds for all
    starts.  Where invariants alone suffice, coordinates are weighed only in a ``thorough`` search:
    they hold the same products, and sines besides.  Outputs that are ``followed`` are not read off
    as angles.
    """
    models = SmallestModels.of(motions, wanted, integrals, thorough, followed)
    return models.general if start is None else models.of_start(start).model


def _cost(model: Model) -> tuple[float, int]:
    """What a model that is not chosen from others costs."""
    (alone,) = model.candidates
    return alone.weight, alone.states


def _cheapest(models: Sequence[Model]) -> Model:
    best = min(models, key=_cost)
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
    low = invariants_level(motions, wanted, integrals, followed)
    if low is not None:
        yield from _with_momenta(low)
        alone = len(low.positions) == len(motions.system.invariants)
        if alone and not thorough:
            return
    high = coordinates_level(motions, wanted, integrals)
    yield from _with_momenta(high)
    relative = relative_level(high)
    if relative is not None:
        yield from _with_momenta(relative)


def _with_momenta(level: Level) -> Iterator[Level]:
    yield level
    momenta = momenta_level(level)
    if momenta is not None:
        yield momenta


def _without_zeros(full: Level, known: _Particular) -> list[Level]:
    """A level without the parameters that are zero at a start: as it then stands, and in normal
    forms, which may cost less, but write powers of sums out."""
    return without_parameters(full, dict.fromkeys(known.zeros(full.parameters), se.Integer(0)))


def _cut_down(
    motions: Motions, full: Level, level: Level, known: _Particular | None, shorten: bool = True
) -> Model:
    """One ``level``, equal to ``full`` for what is ``known``, cut down to what its outputs need."""
    roles: dict[Any, Role] = {}

    def note(x: Any, kind: str, why: str) -> None:
        roles[x] = Role(str(x), kind, why)

    level = _close(level, note, "no output depends on it")
    if known is not None:
        level = _on_plane(level, known, note)
    level, frozen = _without_constants(level, full, note)
    told = dict[Any, Any]()
    if shorten:
        level, told = _without_integrals(level, full, known or _Particular({}), note)
    _note_cycles(level, note)
    for name, angle in level.angles.items():
        words = f"atan2({angle.sine}, {angle.cosine}), up to the branch"
        roles.setdefault(name, Role(name, "read off", words))
    needed = {x for x in full.variables if x in roles and roles[x].kind != "dropped"}
    d = motions.equations.definition
    for x, holders in absent(full, needed, (*d.coordinates, *d.velocities)):
        if str(x) not in level.angles:
            why = f"by {holders}" if holders else "no output depends on it"
            note(x, "replaced" if holders else "dropped", why)
    level = keep_relations(level)
    program = Program.of(level.form)
    summary = ModelCandidate(level.name, len(level.variables), program.operations, program.weight)
    order = {x: i for i, x in enumerate([*full.variables, *full.angles])}
    ranked = sorted(roles.items(), key=lambda item: order.get(item[0], len(order)))
    return Model(level, full, tuple(r for _, r in ranked), (summary,), frozen | told)


def _on_plane(level: Level, known: _Particular, note: Note) -> Level:
    """The level on the invariant plane of variables that are zero at the start and stay so."""
    plane = at_zero(level, known.zeros(level.variables))
    for x in plane:
        note(x, "zero", "zero at the start, and then for ever: its rate vanishes there")
    left = [x for x in level.variables if x not in plane]
    level = restrict(level.substitute(dict.fromkeys(plane, se.Integer(0))), left)
    return _close(level, note, "no output depends on it where the others are zero")


def _without_constants(level: Level, full: Level, note: Note) -> tuple[Level, dict[Any, Any]]:
    """The level with constant variables as parameters, and what these are at the start."""
    frozen = {x: full.start[x] for x in constants(level)}
    for x in frozen:
        note(x, "constant", "its rate vanishes identically")
    if not frozen:
        return level, frozen
    left = [x for x in level.variables if x not in frozen]
    level = replace(level, parameters=(*level.parameters, *frozen))
    return _close(restrict(level, left), note, ""), frozen


def _without_integrals(
    level: Level, full: Level, known: _Particular, note: Note
) -> tuple[Level, dict[Any, Any]]:
    """The level without the variables that proved first integrals give, and the values of these
    integrals as they are at the start."""
    level, given = by_integrals(level, lambda name: _is_integral(full, name), known.is_steep)
    for x, (name, _, _) in given.items():
        note(x, "integral", f"given by the first integral '{name}'")
    return level, {s: e.xreplace(dict(full.start)) for _, s, e in given.values()}


def _note_cycles(level: Level, note: Note) -> None:
    """Of what is integrated: what takes part in a cycle, and what is a quadrature."""
    turning = cyclic(dependence(level), level.variables)
    for x in level.variables:
        if x in turning:
            note(x, "integrated", "in a cycle: the rates depend on one another")
        else:
            note(x, "quadrature", "follows from others, which do not depend on it")


def _at_start(level: Level, start: Mapping[Any, float]) -> dict[Any, float]:
    """Numbers of the level's own variables, of the parameters and the time."""
    own = {x: meaning for x, meaning in level.start.items() if x != meaning}
    values = _Particular(start).numbers(tuple(own.values())) if own else ()
    return {**start, **dict(zip(own, values, strict=True))}


def _close(level: Level, note: Note, why: str) -> Level:
    kept = needed_variables(level, dependence(level))
    for x in level.variables:
        if x not in kept:
            note(x, "dropped", why)
    return restrict(level, kept)


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
    return vanish([se.Add(*slopes)], level)


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
class ModelCandidate:
    """One level that was weighed, cut down to what the outputs need: its number of states, and
    operations and weight of its right-hand side."""

    level: str
    states: int
    operations: int
    weight: float
    chosen: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """The equations that a scene needs.

    ``level`` says in which variables they stand; ``roles`` what became of each variable;
    ``candidates`` which levels were weighed.  ``form`` is what programs are made of, ``outputs``
    and ``integrals`` are expressions on it; ``frozen`` maps symbols that became parameters to what
    they are at the start, in coordinates and velocities, as ``start`` does for the states.
    ``full`` is the level that was chosen, ``cut`` what is left of it.  ``refuted`` names the
    declared integrals that are proved not to be constant.  ``memo`` holds the programs written for
    it.
    """

    cut: Level
    full: Level
    roles: tuple[Role, ...]
    candidates: tuple[ModelCandidate, ...]
    frozen: Mapping[Any, Any] = field(default_factory=dict)
    refuted: tuple[str, ...] = ()
    memo: Memo = field(default_factory=Memo, init=False)

    def __repr__(self) -> str:
        states = ", ".join(map(str, self.states))
        return f"Model({self.system.name!r}, in {self.level}, states=({states}))"

    def _repr_html_(self) -> str:
        """For notebooks: what became of each variable, and why."""
        rows = [(role.variable, f"{role.kind}: {role.why}") for role in self.roles]
        return html_table(repr(self), rows)

    @property
    def system(self) -> System:
        """The system."""
        system: System = self.cut.system
        return system

    @property
    def level(self) -> str:
        """``coordinates``, maybe with relative angles, ``invariants``, or these with momenta."""
        return self.cut.name

    @property
    def form(self) -> FirstOrderForm:
        """What a ``Program`` is made of."""
        return self.cut.form

    @property
    def outputs(self) -> Mapping[str, Any]:
        """The wanted quantities by name, but those that are angles read off."""
        return self.cut.outputs

    @property
    def integrals(self) -> Mapping[str, Any]:
        """The first integrals that can be followed, by name."""
        return self.cut.integrals

    @property
    def eliminating_integrals(self) -> tuple[str, ...]:
        """The first integrals that stand in for equations."""
        return tuple(name for name in self.system.integrals if level_of(name) in self.frozen)

    @property
    def states(self) -> tuple[Any, ...]:
        """The variables that are integrated."""
        return self.cut.variables

    @property
    def start(self) -> dict[Any, Any]:
        """Each state in terms of coordinates and velocities of the equations."""
        return {x: self.cut.start[x] for x in self.states}

    @cached_property
    def program(self) -> Program:
        """Right-hand side, outputs and integrals as one straight-line program."""
        return Program.of(self.form, self.outputs)

    @property
    def graph(self) -> nx.DiGraph:
        """A networkx graph with an edge x -> y where the rate of y holds x, on the full level;
        nodes carry their ``kind``."""
        import networkx as nx

        graph = nx.DiGraph()
        kinds = {role.variable: role.kind for role in self.roles}
        for x in self.full.variables:
            graph.add_node(x, kind=kinds.get(str(x), "dropped"))
        for y, sources in dependence(self.full).items():
            graph.add_edges_from((x, y) for x in sources)
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
            "integrals": list(self.integrals),
            "refuted": list(self.refuted),
            "levels": [
                {
                    "name": c.level, "states": c.states, "operations": c.operations,
                    "weight": c.weight, "chosen": c.chosen,
                }
                for c in self.candidates
            ],
            "edges": [[str(a), str(b)] for a, b in self.graph.edges],
        }  # fmt: skip

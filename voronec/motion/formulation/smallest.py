"""The smallest model of a scene: from formulations of the equations to the one that costs least.

In every formulation of the equations the smallest closed set of variables is taken that the wanted
outputs need; constants and what stays at zero are frozen, first integrals stand in for equations;
and of the formulations the one whose program costs least is chosen.

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
from voronec.motion.formulation.formulation import (
    Formulation,
    coordinates_formulation,
    cyclic,
    dependence,
    invariants_formulation,
    keep_relations,
    needed_variables,
    restrict,
)
from voronec.motion.formulation.model_cache import ModelCache
from voronec.motion.formulation.special import (
    at_zero,
    by_integrals,
    constants,
    level_of,
    vanish,
    without_parameters,
)
from voronec.motion.formulation.variables import momenta_formulation, relative_formulation

if TYPE_CHECKING:
    import networkx as nx


def absent(
    formulation: Formulation, needed: set[Any], names: tuple[Any, ...]
) -> Iterator[tuple[Any, str]]:
    """Which of the ``names`` are no variables of the formulation, and in which needed ones each
    stands.

    The list is empty where nothing that is needed holds it.
    """
    for x in names:
        if x in formulation.variables:
            continue
        holders = [
            str(y)
            for y in formulation.variables
            if y in needed and x in formulation.start[y].free_symbols
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
    """What is known of one motion in a formulation: numbers of variables, parameters and the time,
    and what was ``asked`` of them so far: slopes of integrals, and whether these are steep
    enough."""

    values: Mapping[Any, float]
    asked: list[tuple[Any, tuple[Any, ...], bool]] = field(default_factory=list)

    def numbers(self, exprs: tuple[Any, ...]) -> list[float]:
        """The values of expressions of the start; infinite where one has none."""
        function = _function(tuple(self.values), exprs)
        if function is None:
            return [inf] * len(exprs) if len(exprs) == 1 else [self.numbers((e,))[0] for e in exprs]
        array = function([*self.values.values(), 0.0])
        return [x if isfinite(x) else inf for x in array.tolist()]

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
    formulation by formulation.  Another start that gives the same answers has the same model.  It
    is kept under its ``name``, and what is made of it under names that begin so."""

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
    """The smallest models of one set of outputs, by start: the formulations that they are chosen
    from, and those that were found so far, in this process or in earlier ones."""

    def __init__(
        self, model_cache: ModelCache, motions: Motions, make: Callable[[], Iterable[Formulation]]
    ) -> None:
        self.model_cache = model_cache
        self._motions = motions
        self._formulations: tuple[Formulation, ...] = model_cache.once(
            "formulations", lambda: tuple(make())
        )
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
            model_cache = ModelCache(motions.system, [key, d.near])
            formulations = partial(_formulations, motions, wanted, integrals, thorough, followed)
            kept[key] = cls(model_cache, motions, formulations)
        models: SmallestModels = kept[key]
        return models

    @property
    def _next_name(self) -> str:
        return f"model {len(self._findings)}"

    @cached_property
    def general(self) -> Model:
        """The model that holds for all starts."""
        formulations = (
            _cut_down(self._motions, formulation, formulation, None)
            for formulation in self._formulations
        )
        model = self.model_cache.once("general", lambda: _cheapest([*formulations]))
        self.model_cache.keep()
        return model

    @cached_property
    def without_integrals(self) -> Model:
        """The model that holds for all starts, in which no integral stands in for an equation: its
        variables are those of the phase space."""
        whole = (_cut_down(self._motions, e, e, None, False) for e in self._formulations)
        model = self.model_cache.once("without integrals", lambda: _cheapest([*whole]))
        self.model_cache.keep()
        return model

    def of_start(self, start: Mapping[Any, float]) -> ModelSearch:
        """The model of a start; starts of which nothing else is known than of another have its."""
        values = [_at_start(formulation, start) for formulation in self._formulations]
        starts = [_Particular(each) for each in values]
        pairs = zip(self._formulations, starts, strict=True)
        zeros = tuple(
            s.zeros((*formulation.variables, *formulation.parameters)) for formulation, s in pairs
        )
        for finding in self._findings:
            if finding.holds(zeros, starts):
                return finding
        if len(self._findings) >= MODELS:
            self._findings.clear()
            self.model_cache.forget("model")
        search = self.model_cache.once(self._next_name, lambda: self._find(zeros, values))
        self._findings.append(search)
        return search

    def _find(
        self, zeros: tuple[frozenset[Any], ...], values: Sequence[Mapping[Any, float]]
    ) -> ModelSearch:
        starts = [_Particular(each) for each in values]
        model = _cheapest([
            min((_cut_down(self._motions, full, formulation, known)
                 for formulation in _without_zeros(full, known)), key=_cost)
            for full, known in zip(self._formulations, starts, strict=True)
        ])  # fmt: skip
        return ModelSearch(self._next_name, model, zeros, tuple(tuple(s.asked) for s in starts))


def smallest_model(
    motions: Motions,
    wanted: Mapping[str, sp.Expr],
    integrals: Mapping[str, sp.Expr],
    start: Mapping[Any, float] | None = None,
    thorough: bool = False,
) -> Model:
    """The cheapest model in which the wanted quantities can be computed.

    ``wanted`` and ``integrals`` are expressions in the user's symbols, invariants among them;
    ``start`` gives numbers of coordinates, velocities, parameters and the time, as symbols inside
    the engine's symbols: with it, what is zero is frozen; without it, the model holds for all
    starts.  Where invariants alone suffice, coordinates are weighed only in a ``thorough`` search:
    they hold the same products, and sines besides.
    """
    models = SmallestModels.of(motions, wanted, integrals, thorough)
    return models.general if start is None else models.of_start(start).model


def _cost(model: Model) -> tuple[float, int]:
    """What a model that is not chosen from others costs."""
    (alone,) = model.candidates
    return alone.weight, alone.states


def _cheapest(models: Sequence[Model]) -> Model:
    best = min(models, key=_cost)
    weighed = tuple(replace(m.candidates[0], chosen=m is best) for m in models)
    return replace(best, candidates=weighed)


def _formulations(
    motions: Motions,
    wanted: Mapping[str, sp.Expr],
    integrals: Mapping[str, sp.Expr],
    thorough: bool,
    followed: Collection[str],
) -> Iterator[Formulation]:
    """The formulations to weigh."""
    low = invariants_formulation(motions, wanted, integrals, followed)
    if low is not None:
        yield from _with_momenta(low)
        alone = len(low.positions) == len(motions.system.invariants)
        if alone and not thorough:
            return
    high = coordinates_formulation(motions, wanted, integrals)
    yield from _with_momenta(high)
    relative = relative_formulation(high)
    if relative is not None:
        yield from _with_momenta(relative)


def _with_momenta(formulation: Formulation) -> Iterator[Formulation]:
    yield formulation
    momenta = momenta_formulation(formulation)
    if momenta is not None:
        yield momenta


def _without_zeros(full: Formulation, known: _Particular) -> list[Formulation]:
    """A formulation without the parameters that are zero at a start: as it then stands, and in
    normal forms, which may cost less, but write powers of sums out."""
    return without_parameters(full, dict.fromkeys(known.zeros(full.parameters), se.Integer(0)))


def _cut_down(
    motions: Motions, full: Formulation, formulation: Formulation, known: _Particular | None,
    shorten: bool = True,
) -> Model:  # fmt: skip
    """One ``formulation``, equal to ``full`` for what is ``known``, cut down to what its outputs
    need; made shorter by integrals where that is asked."""
    roles: dict[Any, Role] = {}

    def note(x: Any, kind: str, why: str) -> None:
        roles[x] = Role(str(x), kind, why)

    formulation = _close(formulation, note, "no output depends on it")
    if known is not None:
        formulation = _on_plane(formulation, known, note)
    formulation, frozen = _without_constants(formulation, full, note)
    told = dict[Any, Any]()
    if shorten:
        formulation, told = _without_integrals(formulation, full, known or _Particular({}), note)
    _note_cycles(formulation, note)
    for name, angle in formulation.angles.items():
        words = f"atan2({angle.sine}, {angle.cosine}), up to the branch"
        roles.setdefault(name, Role(name, "read off", words))
    needed = {x for x in full.variables if x in roles and roles[x].kind != "dropped"}
    d = motions.equations.definition
    for x, holders in absent(full, needed, (*d.coordinates, *d.velocities)):
        if str(x) not in formulation.angles:
            why = f"by {holders}" if holders else "no output depends on it"
            note(x, "replaced" if holders else "dropped", why)
    formulation = keep_relations(formulation)
    program = Program.of(formulation.form)
    summary = ModelCandidate(
        formulation.name, len(formulation.variables), program.operations, program.weight
    )
    order = {x: i for i, x in enumerate([*full.variables, *full.angles])}
    ranked = sorted(roles.items(), key=lambda item: order.get(item[0], len(order)))
    return Model(formulation, full, tuple(r for _, r in ranked), (summary,), frozen | told)


def _on_plane(formulation: Formulation, known: _Particular, note: Note) -> Formulation:
    """The formulation on the invariant plane of variables that are zero at the start and stay
    so."""
    plane = at_zero(formulation, known.zeros(formulation.variables))
    for x in plane:
        note(x, "zero", "zero at the start, and then for ever: its rate vanishes there")
    left = [x for x in formulation.variables if x not in plane]
    formulation = restrict(formulation.substitute(dict.fromkeys(plane, se.Integer(0))), left)
    return _close(formulation, note, "no output depends on it where the others are zero")


def _without_constants(
    formulation: Formulation, full: Formulation, note: Note
) -> tuple[Formulation, dict[Any, Any]]:
    """The formulation with constant variables as parameters, and what these are at the start."""
    frozen = {x: full.start[x] for x in constants(formulation)}
    for x in frozen:
        note(x, "constant", "its rate vanishes identically")
    if not frozen:
        return formulation, frozen
    left = [x for x in formulation.variables if x not in frozen]
    formulation = replace(formulation, parameters=(*formulation.parameters, *frozen))
    return _close(restrict(formulation, left), note, ""), frozen


def _without_integrals(
    formulation: Formulation, full: Formulation, known: _Particular, note: Note
) -> tuple[Formulation, dict[Any, Any]]:
    """The formulation without the variables that proved first integrals give, and the values of
    these integrals as they are at the start."""
    formulation, given = by_integrals(
        formulation, lambda name: _is_integral(full, name), known.is_steep
    )
    for x, (name, _, _) in given.items():
        note(x, "integral", f"given by the first integral '{name}'")
    return formulation, {s: e.xreplace(dict(full.start)) for _, s, e in given.values()}


def _note_cycles(formulation: Formulation, note: Note) -> None:
    """Of what is integrated: what takes part in a cycle, and what is a quadrature."""
    turning = cyclic(dependence(formulation), formulation.variables)
    for x in formulation.variables:
        if x in turning:
            note(x, "integrated", "in a cycle: the rates depend on one another")
        else:
            note(x, "quadrature", "follows from others, which do not depend on it")


def _at_start(formulation: Formulation, start: Mapping[Any, float]) -> dict[Any, float]:
    """Numbers of the formulation's own variables, of the parameters and the time."""
    meanings = {x: meaning for x, meaning in formulation.start.items() if x != meaning}
    values = _Particular(start).numbers(tuple(meanings.values())) if meanings else ()
    return {**start, **dict(zip(meanings, values, strict=True))}


def _close(formulation: Formulation, note: Note, why: str) -> Formulation:
    kept = needed_variables(formulation, dependence(formulation))
    for x in formulation.variables:
        if x not in kept:
            note(x, "dropped", why)
    return restrict(formulation, kept)


def _is_integral(formulation: Formulation, name: str) -> bool:
    """Whether a declared integral is proved to be one, in the formulation."""
    integral = formulation.integrals[name]
    slopes = [
        integral.diff(q) * r for q, r in zip(formulation.positions, formulation.rates, strict=True)
    ]
    slopes.append(integral.diff(formulation.time))
    held = [i for i, v in enumerate(formulation.velocities) if integral.diff(v) != 0]
    for i in held:
        if any(formulation.mass[i][j] != 0 for j in range(len(formulation.velocities)) if j != i):
            return False
        slopes.append(
            integral.diff(formulation.velocities[i]) * formulation.force[i] / formulation.mass[i][i]
        )
    return vanish([se.Add(*slopes)], formulation)


@dataclass(frozen=True)
class Role:
    """What became of one variable, and why.

    ``kind`` is ``integrated``, ``quadrature``, ``constant``, ``zero``, ``integral`` (given by a
    first integral), ``read off`` (an angle from invariants), ``replaced`` (the formulation has
    other variables) or ``dropped``.
    """

    variable: str
    kind: str
    why: str


@dataclass(frozen=True)
class ModelCandidate:
    """One formulation that was weighed, cut down to what the outputs need: its number of states,
    and operations and weight of its right-hand side."""

    formulation: str
    states: int
    operations: int
    weight: float
    chosen: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """The equations that a scene needs.

    ``formulation`` says in which variables they stand; ``roles`` what became of each variable;
    ``candidates`` which formulations were weighed.  ``form`` is what programs are made of,
    ``outputs`` and ``integrals`` are expressions on it; ``frozen`` maps symbols that became
    parameters to what they are at the start, in coordinates and velocities, as ``start`` does for
    the states. ``full`` is the formulation that was chosen, ``cut`` what is left of it.
    ``refuted`` names the declared integrals that are proved not to be constant.  ``memo`` holds the
    programs written for it.
    """

    cut: Formulation
    full: Formulation
    roles: tuple[Role, ...]
    candidates: tuple[ModelCandidate, ...]
    frozen: Mapping[Any, Any] = field(default_factory=dict)
    refuted: tuple[str, ...] = ()
    memo: Memo = field(default_factory=Memo, init=False)

    def __repr__(self) -> str:
        states = ", ".join(map(str, self.states))
        return f"Model({self.system.name!r}, in {self.formulation}, states=({states}))"

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
    def formulation(self) -> str:
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
        """A networkx graph with an edge x -> y where the rate of y holds x, in the full
        formulation; nodes carry their ``kind``."""
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
            "formulation": self.formulation,
            "states": [str(x) for x in self.states],
            "variables": [
                {"name": r.variable, "kind": r.kind, "why": r.why} for r in self.roles
            ],
            "integrals": list(self.integrals),
            "refuted": list(self.refuted),
            "formulations": [
                {
                    "name": c.formulation, "states": c.states, "operations": c.operations,
                    "weight": c.weight, "chosen": c.chosen,
                }
                for c in self.candidates
            ],
            "edges": [[str(a), str(b)] for a, b in self.graph.edges],
        }  # fmt: skip

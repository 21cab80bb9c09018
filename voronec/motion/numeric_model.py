"""From a start in coordinates to the smallest model in numbers: program, state and constants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.algebra.memo import Memo
from voronec.equations.motions import Motions
from voronec.equations.program import Program, compile_program
from voronec.equations.program.python import compiled_digits
from voronec.motion.formulation import Model, SmallestModels
from voronec.motion.observables import AngleBranch, ObservedQuantities, watch_of
from voronec.motion.request import Namespace, OutputTerms
from voronec.motion.state_probe import StateProbe, mass_program, quantities
from voronec.motion.steppers import Signals


@dataclass(frozen=True)
class ProgrammedModel:
    """A model made ready: its program, what is watched on it, the functions of events.

    ``form`` has the mass matrix of the velocities; ``event_functions`` are expressions on the model
    by the event's name; ``below`` computes on the coordinates where the model starts and what it
    takes as constant; ``inertia`` gives the mass matrix (``mass_program``) where it is written.
    ``memo`` holds what is the same for all runs of the model.
    """

    model: Model | None
    program: Program
    watch: ObservedQuantities
    form: Any
    event_functions: Mapping[str, Any]
    below: Program
    inertia: Program | None = None
    memo: Memo = field(default_factory=Memo, repr=False, compare=False)

    @property
    def formulation(self) -> str:
        """The variables in which the model stands."""
        return "coordinates" if self.model is None else self.model.formulation

    @property
    def moving_form(self) -> Any:
        """The form that the program is made of."""
        return self.form if self.model is None else self.model.form

    @property
    def is_rough(self) -> bool:
        """Whether rates or functions of events may hold what is not smooth."""
        events = self.event_program
        return self.program.is_rough or (events is not None and events.is_rough_beside)

    @cached_property
    def event_program(self) -> Program | None:
        """Computes the functions of events; None where there are none."""
        return quantities(self.form, self.event_functions) if self.event_functions else None

    def place(
        self, state: Any, constants: Mapping[str, Any], time: Any
    ) -> tuple[np.ndarray, list[Any]]:
        """The model's state (n,) and the values of its program's parameters, as numbers of the kind
        that the state on the coordinates has."""
        digits = np.asarray(state).dtype == object
        nothing = mpmath.nan if digits else np.nan
        parameters = [constants.get(str(p), nothing) for p in self.below.parameters]
        _, extras = (compiled_digits if digits else compile_program)(self.below)
        with np.errstate(all="ignore"):
            named = dict(zip(self.below.names, extras(time, list(state), parameters), strict=True))
        kind = object if digits else float
        placed = np.array([named[f"start {x}"] for x in self.program.state], dtype=kind)
        values = {**constants, **{n.removeprefix("frozen "): x for n, x in named.items()}}
        return placed, [values.get(str(p), nothing) for p in self.program.parameters]

    def constants(self, values: Sequence[Any]) -> dict[str, Any]:
        """The values of the program's parameters by name."""
        return dict(zip(map(str, self.program.parameters), values, strict=True))

    def probe(
        self, name: str, values: Sequence[float], time: float, changing: Signals | None = None
    ) -> StateProbe:
        """Looks at single states of the model."""
        return StateProbe(name, self.form, self.program, values, time, changing, self.inertia)


def make_model(
    namespace: Namespace,
    outputs: Sequence[Any],
    functions: Mapping[str, Any],
    start: np.ndarray,
    constants: Mapping[str, float],
    time: float,
    followed: bool,
) -> ProgrammedModel:
    """The smallest model of the outputs and of the functions of events.

    ``functions`` gives those of events in the user's symbols; ``start`` (n,) is on the
    coordinates; ``followed`` keeps angles among the states.  Reactions need accelerations, and so
    the coordinates.  What is asked for last is kept with the names.
    """
    wanted, models = namespace.memo.last(
        ("models", followed), _request_key(outputs, functions),
        lambda: _models(namespace, outputs, functions, followed),
    )  # fmt: skip
    if models is None:
        return whole(namespace, outputs, functions)
    known = numbers_at(namespace.equations.raw.form, start, constants, time)
    choice = models.of_start(known)
    model, name = choice.model, f"{choice.name} {[*wanted.names]} {[*functions]}"

    def write() -> ProgrammedModel:
        known_before = name in models.model_cache
        written: ProgrammedModel = models.model_cache.once(
            name, lambda: _write(namespace, wanted, model, functions)
        )
        if not known_before:
            models.model_cache.keep()
        return replace(written, model=model)

    made = model.memo.once(name, write)  # another start that has the same model has it already
    branches = {
        name: AngleBranch(
            f"cosine of {name}", f"sine of {name}", a.signs(known), known[a.coordinate]
        )
        for name, a in model.cut.angles.items()
    }
    return replace(made, watch=replace(made.watch, branches=branches)) if branches else made


def _request_key(outputs: Sequence[Any], functions: Mapping[str, Any]) -> tuple[Any, ...]:
    """What is asked for, told from all else."""
    return tuple(outputs), tuple(map(type, outputs)), tuple(functions.items())


def _models(
    namespace: Namespace, outputs: Sequence[Any], functions: Mapping[str, Any], followed: bool
) -> tuple[OutputTerms, SmallestModels | None]:
    """Outputs spelled out, and where their models come from; None with reactions."""
    wanted, equations = namespace.read_outputs(outputs), namespace.equations
    forces = namespace.holds_reactions((*wanted.terms.values(), *functions.values()))
    if wanted.reactions or forces:
        return wanted, None
    names = {f"event {name}": e for name, e in functions.items()}
    given = {**wanted.terms, **names}
    integrals = {name: namespace.claims[name] for name in equations.system.integrals}
    motions, kept = Motions.of(equations), given if followed else names
    return wanted, SmallestModels.of(motions, given, integrals, followed=kept)


def _write(
    namespace: Namespace, wanted: OutputTerms, model: Model, functions: Mapping[str, Any]
) -> ProgrammedModel:
    """What is the same for every start of a model: all but the branches of its angles, and the
    model itself, which has a place of its own on disk."""
    watch = _watch(namespace, wanted, model)
    form = replace(model.form, mass=model.cut.inertia or model.cut.mass)
    below = {f"start {x}": e for x, e in model.start.items()}
    below |= {f"frozen {x}": e for x, e in model.frozen.items()}
    return ProgrammedModel(
        model=None,
        program=Program.of(model.form, watch.expressions),
        watch=watch,
        form=form,
        event_functions={n: model.outputs[f"event {n}"] for n in functions},
        below=quantities(namespace.equations.raw.form, below),
        inertia=mass_program(form),
    )


def numbers_at(
    form: Any, state: np.ndarray, constants: Mapping[str, float], time: float
) -> dict[Any, float]:
    """Numbers of coordinates, velocities, parameters and the time by their symbols inside."""
    numbers = dict(zip(form.coordinates + form.velocities, map(float, state), strict=True))
    return (
        numbers | {se.Symbol(name): value for name, value in constants.items()} | {form.time: time}
    )


def _watch(namespace: Namespace, wanted: OutputTerms, model: Model) -> ObservedQuantities:
    """The outputs on a model, its angles by their cosines and sines, and the integrals and
    relations that it can express."""
    formulation = model.cut
    parts = {f"cosine of {n}": a.cosine for n, a in formulation.angles.items()}
    parts |= {f"sine of {n}": a.sine for n, a in formulation.angles.items()}
    shown = {n: e for n, e in formulation.outputs.items() if n in wanted.terms}
    usable = {*formulation.variables, *formulation.parameters, formulation.time}
    relations = namespace.equations.system.fibration.relations
    inside = {str(r): namespace.inward(r) for r in relations}
    kept = {name: e for name, e in inside.items() if e.free_symbols <= usable}
    besides = {n: e for n, e in _besides(namespace, model).items() if n not in wanted.names}
    form = model.form
    known = {*form.coordinates, *form.velocities, *form.parameters, form.time}
    meanings = {f"vanishing {r}": r for r in formulation.relations if r.free_symbols <= known}
    expressions = shown | parts | besides | meanings
    watch = ObservedQuantities.of(wanted, expressions, formulation.integrals, kept)
    vanishing = {f"{r} = 0": name for name, r in meanings.items()}
    return replace(watch, besides=tuple(besides), vanishing=vanishing)


def _besides(namespace: Namespace, model: Model) -> dict[str, Any]:
    """Coordinates and velocities that a model knows without integrating them: what it solves for,
    what an integral gives, what is constant or stays at zero."""
    formulation, definition = model.cut, namespace.equations.definition
    known = {name for name, _ in formulation.stages} | set(formulation.parameters)
    zero = {role.variable for role in model.roles if role.kind == "zero"}
    variables = (*definition.coordinates, *definition.velocities)
    expressions = {str(x): x for x in variables if x in known}
    return expressions | {str(x): se.Integer(0) for x in variables if str(x) in zero}


def whole(
    namespace: Namespace, outputs: Sequence[Any], functions: Mapping[str, Any]
) -> ProgrammedModel:
    """The equations as they are, on coordinates and velocities; the last is kept with the names."""
    what = _request_key(outputs, functions)
    return namespace.memo.last("whole", what, lambda: _whole(namespace, outputs, functions))


def _whole(
    namespace: Namespace, outputs: Sequence[Any], functions: Mapping[str, Any]
) -> ProgrammedModel:
    form = namespace.equations.form
    terms = namespace.read_outputs(outputs).terms
    forces = namespace.holds_reactions((*terms.values(), *functions.values()))
    watch = replace(watch_of(namespace, outputs), forces=forces)
    inside = {name: namespace.inward(e) for name, e in functions.items()}
    states = (*form.coordinates, *form.velocities)
    return ProgrammedModel(
        model=None,
        program=Program.of(form, watch.expressions),
        watch=watch,
        form=form,
        event_functions=inside,
        below=quantities(form, {f"start {x}": x for x in states}),
    )

"""What a scene needs of a system's equations: the smallest model, made to be looked at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import sympy as sp

from voronec.algebra.arguments import SEVERAL, VALUES, accepts
from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import decide_zero
from voronec.declaration.claims import right_of
from voronec.declaration.scene import Scene
from voronec.declaration.system import System, require_system
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, VoronecError
from voronec.motion.initial_state import parameter_values, start_of
from voronec.motion.inputs import drive
from voronec.motion.model import Model, smallest_model
from voronec.motion.motion_start import rates_at
from voronec.motion.numeric_model import numbers_at
from voronec.motion.reactions import Multipliers
from voronec.motion.request import StartData, outputs_of, scene_of
from voronec.motion.vocabulary import Vocabulary, number

__all__ = ["explain"]


@accepts(outputs=SEVERAL, parameters=VALUES, inputs=VALUES, initial=VALUES)
def explain(
    system: System | VoronecEquations,
    scene: str | Scene | None = None,
    outputs: Sequence[Any] = (),
    parameters: Mapping[Any, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    inputs: Mapping[Any, Any] | None = None,
) -> Model:
    """The smallest model in which the outputs of a scene can be computed, and why it is that one.

    Arguments are those of ``integrate``, but an input need not have a value: outputs are names,
    symbols or expressions, those of the scene unless told, else all coordinates and velocities.
    Where there is no scene ``default`` and none is named, and nothing is said of the start, the
    model holds for all starts; else what is zero in that one motion is frozen.

    ``model.roles`` says of each variable whether it is integrated, a quadrature, a constant, given
    by a first integral, read off or dropped, and why; ``model.candidates`` which levels of the
    equations were weighed; ``model.states``, ``model.form`` and ``model.outputs`` are what is left;
    ``model.graph`` is a networkx graph of which rate holds which variable.  Raises
    ``DefinitionError`` for input that makes no sense.
    """
    declared = system.system if isinstance(system, VoronecEquations) else require_system(system)
    driven = drive(system, inputs, scene_of(declared, scene, False), unknown=True)
    equations = driven.equations
    vocabulary = Vocabulary.of(equations, driven.meaning)
    usual = initial is None and "default" in equations.system.scenes
    chosen = scene_of(equations.system, scene, usual)
    wanted = _output_expressions(vocabulary, outputs_of(chosen, outputs))
    start = None
    if chosen is not None or initial is not None:
        start = _start(
            vocabulary,
            chosen,
            StartData.of(vocabulary, chosen, parameters, initial),
            driven.constants,
        )
    elif parameters:
        raise DefinitionError(
            f"system '{equations.system.name}': parameters without a start; name a scene, or give "
            "initial={...}"
        )
    motions = Motions.of(equations)
    refuted = _refuted_integrals(motions)
    names = [name for name in equations.system.integrals if name not in refuted]
    integrals = {name: vocabulary.claims[name] for name in names}
    model = smallest_model(motions, wanted, integrals, start, thorough=True)
    return replace(model, refuted=refuted)


def _refuted_integrals(motions: Motions) -> tuple[str, ...]:
    """The declared integrals whose rate along the motion is proved not to vanish."""
    found = []
    for name, integral in motions.system.integrals.items():
        function = right_of(integral)
        try:
            field = motions.field_for([function])
            rate = field.derivative(field.read_with_momenta(function))
            if decide_zero(rate, field.relations).refuted:
                found.append(name)
        except VoronecError:  # beyond the budget: nothing is known of it
            continue
    return tuple(found)


def _output_expressions(vocabulary: Vocabulary, outputs: Sequence[Any]) -> dict[str, sp.Expr]:
    """Outputs in the user's symbols; a reaction is what its multiplier is computed from."""
    spelled = vocabulary.read_outputs(outputs)
    found = dict(spelled.given)
    if spelled.reactions:
        equations = vocabulary.equations
        entries = Multipliers.of(equations.definition).entries.values()
        held = {equations.door.outward(s) for e in entries for s in e.free_symbols}
        # accelerations stand in them too, so every velocity is needed
        own = [q for q in equations.system.coordinates if q in held]
        for x in (*own, *equations.system.velocities):
            found.setdefault(plain_name(x), x)
    return found


def _start(
    vocabulary: Vocabulary, scene: Scene | None, given: StartData, inputs: Mapping[str, Any]
) -> dict[Any, float]:
    """Numbers of coordinates, velocities, parameters, time; what has no value is left out."""
    equations = vocabulary.equations
    constants = parameter_values(vocabulary, {**given.parameters, **inputs}, set())
    time = number(scene.times[0], "the span's start") if scene else 0.0
    form = equations.raw.form
    rates = rates_at(equations, form, constants, time)
    start = start_of(vocabulary, given.scene_initial, given.initial, constants, rates, time)
    return numbers_at(form, start.state, constants, time)

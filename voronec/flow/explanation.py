"""What a scene needs of a system's equations: the smallest model, made to be looked at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.equations import VoronecEquations, derive
from voronec.errors import DefinitionError, did_you_mean
from voronec.flow.probe import Probe, quantities
from voronec.flow.reactions import Multipliers
from voronec.flow.start import named, parameter_values, start_of
from voronec.flow.vocabulary import Vocabulary, number
from voronec.model import Model, smallest_model
from voronec.scene import Scene
from voronec.system import System
from voronec.vector_field import Motions

__all__ = ["explain"]


def explain(
    system: System | VoronecEquations,
    scene: str | Scene | None = None,
    outputs: Sequence[Any] = (),
    parameters: Mapping[Any, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
) -> Model:
    """The smallest model in which the outputs of a scene can be computed, and why it is that one.

    Arguments are those of ``integrate``: outputs are names, symbols or expressions, those of the
    scene unless told, else all coordinates and velocities.  Where there is no scene ``default`` and
    none is named, and nothing is said of the start, the model holds for all starts; else what is
    zero in that one motion is frozen.

    ``model.roles`` says of each variable whether it is integrated, a quadrature, a constant, given
    by a first integral, read off or dropped, and why; ``model.candidates`` which levels of the
    equations were weighed; ``model.states``, ``model.form`` and ``model.outputs`` are what is left;
    ``model.graph`` is a networkx graph of which rate holds which variable.  Raises
    ``DefinitionError`` for input that makes no sense.
    """
    equations = system if isinstance(system, VoronecEquations) else derive(system)
    vocabulary = Vocabulary.of(equations)
    chosen = _scene(equations.system, scene, initial is None)
    asked = (outputs,) if isinstance(outputs, str | sp.Basic) else tuple(outputs)
    wanted = _wanted(vocabulary, asked or (chosen.outputs if chosen else ()))
    start = None
    if chosen is not None or initial is not None:
        start = _start(vocabulary, chosen, parameters or {}, initial or {})
    elif parameters:
        raise DefinitionError(
            f"system '{equations.system.name}': parameters without a start; name a scene, or give "
            "initial={...}"
        )
    integrals = {name: vocabulary.claims[name] for name in equations.system.integrals}
    return smallest_model(Motions.of(equations), wanted, integrals, start, thorough=True)


def _scene(system: System, scene: str | Scene | None, needed: bool) -> Scene | None:
    """The scene meant; where none is named and nothing is said of the start, ``default``."""
    if isinstance(scene, Scene):
        return scene
    if scene is None:
        return system.scenes.get("default") if needed else None
    if scene not in system.scenes:
        raise DefinitionError(
            f"system '{system.name}' has no scene '{scene}'{did_you_mean(scene, system.scenes)}"
        )
    return system.scenes[scene]


def _wanted(vocabulary: Vocabulary, outputs: Sequence[Any]) -> dict[str, sp.Expr]:
    """Outputs in the user's symbols; a reaction is what its multiplier is computed from."""
    spelled = vocabulary.wanted(outputs)
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
    vocabulary: Vocabulary,
    chosen: Scene | None,
    parameters: Mapping[Any, Any],
    initial: Mapping[Any, Any],
) -> dict[Any, float]:
    """Numbers of coordinates, velocities, parameters, time; what has no value is left out."""
    equations = vocabulary.equations
    scene_parameters = named(vocabulary, chosen.parameters if chosen else {}, "parameter")
    given = {**scene_parameters, **named(vocabulary, parameters, "parameter")}
    constants = parameter_values(vocabulary, given, set())
    program = quantities(equations.form, {})
    values = [constants.get(str(p), np.nan) for p in program.parameters]
    time = number(chosen.times[0], "the span's start") if chosen else 0.0
    probe = Probe(equations.system.name, equations.form, program, values, time)
    state = start_of(
        vocabulary,
        named(vocabulary, chosen.initial if chosen else {}, "initial value"),
        named(vocabulary, initial, "initial value"),
        constants,
        probe.rates,
        time,
    ).state
    found = dict(zip(program.state, map(float, state), strict=True))
    found[program.time] = time
    return found | {se.Symbol(name): value for name, value in constants.items()}

"""What is measured: a motion of a scene, from doubles that every method shares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import sympy as sp

from voronec.accuracy.problem import ReferenceProblem
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import as_expression
from voronec.declaration.claims import right_of
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, VoronecError, did_you_mean
from voronec.motion import integrate
from voronec.motion.inputs import drive
from voronec.motion.request import Vocabulary, number

__all__ = ["INSTANTS", "ask"]

INSTANTS = 101
"""How many instants the outputs are compared at."""


def ask(
    system: System | VoronecEquations,
    scene: str | None = None,
    outputs: Sequence[Any] = (),
    time: float | None = None,
    parameters: Mapping[Any, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    instants: int = INSTANTS,
    inputs: Mapping[Any, Any] | None = None,
) -> ReferenceProblem:
    """The question of a scene: ``time`` is its length where the scene's own is not wanted.

    ``inputs`` are numbers and expressions of the time or the state, over those of the scene.

    Without ``outputs`` the invariants and the velocities are compared, where the system descends
    to its invariants, so that methods on the invariants can take part; else what the scene wants.
    Raises ``DefinitionError`` for input that makes no sense, as ``integrate`` does.
    """
    declared = system.system if isinstance(system, VoronecEquations) else system
    chosen = _scene(declared, scene)
    own = declared.scenes[chosen]
    driven = drive(system, inputs, own, steady="a comparison of methods")
    equations, parameters = driven.equations, {**(parameters or {}), **driven.constants}
    grid = _grid(own, time, instants)
    wanted = (outputs,) if isinstance(outputs, str | sp.Basic) else tuple(outputs)
    wanted = wanted or _invariant_state(equations) or own.outputs
    first = integrate(
        equations, replace(own, outputs=(), inputs={}), times=grid[:1], parameters=parameters,
        initial=initial, method="scipy",
    )  # fmt: skip
    symbols = (*equations.system.coordinates, *equations.system.velocities)
    read = Vocabulary.of(equations).read_outputs(wanted or symbols)
    for name in read.reactions:
        raise DefinitionError(f"'{name}' takes no part in a comparison of methods; leave it out")
    integrals = {n: right_of(claim) for n, claim in equations.system.integrals.items()}
    return ReferenceProblem(
        equations=equations,
        scene=chosen,
        expressions=read.terms,
        grid=grid,
        parameters=dict(first.parameters),
        initial={plain_name(s): float(first[plain_name(s)][0]) for s in symbols},
        angles=_angles(equations.system, read.terms),
        integrals=integrals,
    )


def _grid(scene: Scene, time: float | None, instants: int) -> np.ndarray:
    """The instants that are compared: over the span of a scene, or so long a ``time``."""
    start, end = (number(x, "the span's end") for x in scene.times)
    if time is not None:
        end = start + time
    if not (np.isfinite(end) and end != start):
        raise DefinitionError(f"a motion over the time {end - start:g} cannot be measured")
    if instants < 2:
        raise DefinitionError(f"{instants} instants: give 2 or more")
    return np.linspace(start, end, instants)


def _scene(system: System, scene: str | None) -> str:
    scene = system.first_scene if scene is None else scene
    if scene is None:
        raise DefinitionError(f"system '{system.name}' declares no scene to measure; declare one")
    if scene not in system.scenes:
        raise DefinitionError(
            f"system '{system.name}' has no scene '{scene}'{did_you_mean(scene, system.scenes)}"
        )
    return scene


def _invariant_state(equations: VoronecEquations) -> tuple[Any, ...]:
    """Invariants and velocities, where the equations close on them."""
    system = equations.system
    if not system.invariants:
        return ()
    try:
        field = Motions.of(equations).on_invariants
    except VoronecError:
        return ()
    own = [s for s in system.velocities if plain_name(s) in {str(v) for v in field.velocities}]
    return (*system.invariants, *map(plain_name, own))


def _angles(system: System, expressions: Mapping[str, sp.Expr]) -> frozenset[str]:
    """Outputs that are coordinates, and occur in the system as whole multiples under sines only."""
    frame = system.frame.expressions if system.frame is not None else ()
    held = [as_expression(e) for e in (system.lagrangian, *system.constraints, *frame)]
    held += [as_expression(e) for e in system.forces.values()]
    found = set()
    for name, expr in expressions.items():
        if expr in system.coordinates and _is_only_angle(expr, held):
            found.add(name)
    return frozenset(found)


def _is_only_angle(coordinate: Any, exprs: Sequence[sp.Expr]) -> bool:
    seen = False
    for expr in exprs:
        inside = set()
        for call in expr.atoms(sp.sin, sp.cos, sp.tan, sp.cot):
            slope = sp.diff(call.args[0], coordinate)
            if slope.is_Integer and slope != 0:
                inside.add(call)
        seen = seen or bool(inside)
        if expr.xreplace({call: sp.Dummy() for call in inside}).has(coordinate):
            return False
    return seen

"""What is measured: one motion, its outputs and its grid, from numbers that every method shares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.algebra.text import as_expression
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, VoronecError, did_you_mean
from voronec.motion import integrate
from voronec.motion.inputs import drive
from voronec.motion.request import number

__all__ = ["INSTANTS", "BenchMotion", "ask"]

INSTANTS = 101
"""How many instants the outputs are compared at."""


@dataclass(frozen=True, eq=False)
class BenchMotion:
    """One motion to be computed by many methods, and what is wanted of it.

    ``outputs`` are names, ``expressions`` what they mean in the user's symbols; ``angles`` those of
    them that are angles, whose errors are taken modulo 2 pi.  ``parameters`` and ``initial`` (all
    coordinates and velocities) are doubles: the same numbers for every method and for the
    reference, so that no method is blamed for how another rounds its input.
    """

    equations: VoronecEquations
    scene: str
    outputs: tuple[str, ...]
    expressions: Mapping[str, sp.Expr]
    grid: np.ndarray
    parameters: Mapping[str, float]
    initial: Mapping[str, float]
    angles: frozenset[str]

    @property
    def system(self) -> System:
        """The system that moves."""
        return self.equations.system

    @property
    def span(self) -> float:
        """Units of time from the first instant to the last."""
        return float(abs(self.grid[-1] - self.grid[0]))

    @cached_property
    def motions(self) -> Motions:
        """The vector fields of the system, on coordinates and on invariants."""
        return Motions(self.equations)

    @cached_property
    def bare(self) -> Scene:
        """A scene that asks for nothing in particular, so that the whole state is kept."""
        return Scene(initial=dict(self.initial), parameters=dict(self.parameters))

    def until(self, end: float) -> BenchMotion:
        """The same question on the part of the grid up to a time."""
        order = np.sign(self.grid[-1] - self.grid[0])
        return replace(self, grid=self.grid[order * (self.grid - end) <= 0])


def ask(
    system: System | VoronecEquations,
    scene: str | None = None,
    outputs: Sequence[Any] = (),
    time: float | None = None,
    parameters: Mapping[Any, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    instants: int = INSTANTS,
    inputs: Mapping[Any, Any] | None = None,
) -> BenchMotion:
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
    look = partial(
        integrate, equations, replace(own, outputs=(), inputs={}), times=grid[:1],
        parameters=parameters, initial=initial, method="scipy",
    )  # fmt: skip
    first, names = look(), look(outputs=wanted).outputs  # names of outputs are read there
    symbols = (*equations.system.coordinates, *equations.system.velocities)
    expressions = _expressions(equations.system, wanted or symbols, names)
    return BenchMotion(
        equations=equations,
        scene=chosen,
        outputs=tuple(names),
        expressions=expressions,
        grid=grid,
        parameters=dict(first.parameters),
        initial={plain_name(s): float(first[plain_name(s)][0]) for s in symbols},
        angles=_angles(equations.system, expressions),
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
    if scene is None:
        if not system.scenes:
            raise DefinitionError(
                f"system '{system.name}' declares no scene to measure; declare one"
            )
        return "default" if "default" in system.scenes else next(iter(system.scenes))
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
        field = Motions(equations).on_invariants
    except VoronecError:
        return ()
    own = [s for s in system.velocities if plain_name(s) in {str(v) for v in field.velocities}]
    return (*system.invariants, *map(plain_name, own))


def _expressions(system: System, wanted: Sequence[Any], names: Sequence[str]) -> dict[str, sp.Expr]:
    """Outputs by name, in the user's symbols; invariants stay as they are."""
    from voronec.declaration.claims import right_of

    known = {plain_name(s): s for s in system.known_symbols()}
    known |= dict(zip(system.invariants, system.invariant_symbols, strict=True))
    claims = {name: right_of(claim) for name, claim in system.integrals.items()}
    result = {}
    for key, name in zip(wanted, names, strict=True):
        if isinstance(key, str):
            result[name] = known.get(key, claims.get(key, sp.Symbol(key)))
        else:
            result[name] = as_expression(key)
    return result


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

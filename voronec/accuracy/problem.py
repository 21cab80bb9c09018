"""A motion that methods are compared on, and its equations as a program in one formulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from voronec.algebra.graphs import nodes
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import as_expression
from voronec.declaration.claims import right_of
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.motions import Motions
from voronec.equations.program import Block, Program, compile_program
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit, VoronecError
from voronec.motion import integrate
from voronec.motion.inputs import drive
from voronec.motion.request import Namespace, number, scene_of

DIGITS = 60
"""Digits of the initial data of a reference."""
INSTANTS = 101
"""How many instants the outputs of a scene are compared at."""
NOTHING = 1e-9
"""An integral that starts below this is compared absolutely."""


@dataclass(frozen=True, eq=False)
class ReferenceProblem:
    """One motion to be computed by many methods, and what is wanted of it.

    ``expressions`` are the outputs by name, and ``integrals`` what must stay, in the user's
    symbols; ``angles`` are the outputs whose errors are taken modulo 2 pi.  ``parameters`` and
    ``initial`` are numbers by name.  Where speed is measured they are doubles, the same for every
    method and for the reference, so that no method is blamed for how another rounds its input; of
    hard cases they have ``DIGITS``, as there the rounding of the input is part of the question.
    """

    equations: VoronecEquations
    scene: str
    expressions: Mapping[str, sp.Expr]
    grid: np.ndarray
    parameters: Mapping[str, Any]
    initial: Mapping[str, Any]
    angles: frozenset[str] = frozenset()
    integrals: Mapping[str, sp.Expr] = field(default_factory=dict)

    @property
    def system(self) -> System:
        """The system that moves."""
        return self.equations.system

    @property
    def outputs(self) -> tuple[str, ...]:
        """The names of the outputs."""
        return tuple(self.expressions)

    @property
    def span(self) -> float:
        """Units of time from the first instant to the last."""
        return float(abs(self.grid[-1] - self.grid[0]))

    @cached_property
    def bare(self) -> Scene:
        """A scene that asks for nothing in particular, so that the whole state is kept."""
        return Scene(initial=dict(self.initial), parameters=dict(self.parameters))

    def until(self, end: float) -> ReferenceProblem:
        """The motion on the part of the grid up to a time."""
        order = np.sign(self.grid[-1] - self.grid[0])
        return replace(self, grid=self.grid[order * (self.grid - end) <= 0])


@dataclass(frozen=True, eq=False)
class ProblemFormulation:
    """The equations of a problem on ``coordinates`` or on ``invariants``.

    ``program`` computes the derivative of the state (n,), and as extras the outputs, then the
    integrals that have a meaning here.  ``start`` (n,) and ``values``, of all parameters, hold
    mpmath's numbers: on the invariants the start is a function of the numbers given, and a
    reference needs it exactly.
    """

    problem: ReferenceProblem
    name: str
    program: Program
    start: tuple[Any, ...]
    values: tuple[Any, ...]
    integrals: tuple[str, ...] = ()

    @property
    def field(self) -> VectorField:
        """The vector field of this formulation."""
        return Motions.of(self.problem.equations).at(self.name)

    @property
    def state(self) -> np.ndarray:
        """The start as doubles (n,)."""
        return np.array([float(x) for x in self.start])

    @cached_property
    def constants(self) -> tuple[float, ...]:
        """The values of all parameters as doubles."""
        return tuple(map(float, self.values))

    @cached_property
    def places(self) -> tuple[int, ...]:
        """The positions of the states on which outputs depend, through however many others."""
        place = {s: i for i, s in enumerate(self.program.state)}
        rows = _dependence(self.program.derivative, place)
        reached = set().union(*_dependence(self.program.extras, place))
        while True:
            more = reached.union(*(rows[i] for i in reached))
            if more == reached:
                return tuple(sorted(reached))
            reached = more

    @property
    def names(self) -> tuple[str, ...]:
        """The states on which outputs depend."""
        return tuple(str(self.program.state[i]) for i in self.places)

    @cached_property
    def angle_places(self) -> frozenset[int]:
        """The positions of coordinates that occur, by whatever names, under a sine or a cosine."""
        place = {q: i for i, q in enumerate(self.program.coordinates)}
        angular: set[int] = set()
        for block in (self.program.derivative, self.program.extras):
            reach = _reach(block, place)
            for node in nodes(block.expressions):
                if type(node).__name__ in ("sin", "cos", "tan", "cot"):
                    angular = angular.union(*(reach.get(s, set()) for s in node.free_symbols))
        return frozenset(angular)

    def outputs_and_drift(
        self, t: np.ndarray, states: np.ndarray
    ) -> tuple[dict[str, np.ndarray], dict[str, float]]:
        """Outputs, each of shape (k,), and the drift of each integral, at states (k, n)."""
        _, extras = compile_program(self.program)
        with np.errstate(all="ignore"):
            rows = extras(t, list(states.T), list(self.constants))
        arrays = [np.broadcast_to(np.asarray(r, dtype=float), t.shape) for r in rows]
        named = dict(zip(self.program.names, arrays, strict=True))
        drifts = {n: drift(named[f"integral {n}"]) for n in self.integrals}
        return {n: named[n] for n in self.problem.outputs}, drifts


def drift(values: np.ndarray) -> float:
    """The largest change of a constant of the motion, relative to its start where that is not 0."""
    size = abs(values[0]) if abs(values[0]) > NOTHING else 1.0
    return float(np.abs(values - values[0]).max() / size)


def _dependence(block: Block, place: Mapping[Any, int]) -> list[set[int]]:
    """For every result, the positions of the states that occur in it."""
    reach = _reach(block, place)
    return [set().union(*(reach.get(s, set()) for s in r.free_symbols)) for r in block.results]


def _reach(block: Block, place: Mapping[Any, int]) -> dict[Any, set[int]]:
    """For every name in a program, the positions of what it holds, through whatever others."""
    reach: dict[Any, set[int]] = {s: {i} for s, i in place.items()}
    for name, expr in block.assignments:
        reach[name] = set().union(*(reach.get(s, set()) for s in expr.free_symbols))
    return reach


def formulation(
    problem: ReferenceProblem, name: str, form: FirstOrderForm | None = None
) -> ProblemFormulation:
    """The problem in a formulation; ``EngineLimit`` where it or an output has no meaning there.

    On coordinates ``form`` may replace the cheapest form of the equations.
    """
    system, read = problem.system, Namespace.of(problem.equations).inward
    if name == "invariants" and not system.invariants:
        raise EngineLimit(f"system '{system.name}' declares no invariants")
    if name == "invariants":
        motion = Motions.of(problem.equations).at(name)
        form, read = motion.form, motion.read
    form = form or problem.equations.form
    low = dict(system.invariants) if name == "invariants" else {}
    # what is an invariant, or minus one, in the user's words
    alike = {str(s * m): s * sp.Symbol(g) for g, m in low.items() for s in (-1, 1)}
    wanted = {n: read(alike.get(str(e), e)) for n, e in problem.expressions.items()}
    integrals = []
    for key, expr in problem.integrals.items():
        try:
            wanted[f"integral {key}"] = read(expr)
        except VoronecError:
            continue
        integrals.append(key)
    program = Program.of(form, wanted)
    numbers = {**problem.parameters, **problem.initial}
    with mpmath.workdps(DIGITS):
        start = tuple(_initial(str(s), low, numbers) for s in program.state)
        values = tuple(mpmath.mpf(numbers.get(str(p), np.nan)) for p in program.parameters)
    return ProblemFormulation(problem, name, program, start, values, tuple(integrals))


def lowest(problem: ReferenceProblem) -> ProblemFormulation:
    """The problem on the invariants where that works, else on the coordinates."""
    try:
        return formulation(problem, "invariants")
    except VoronecError:
        return formulation(problem, "coordinates")


def _initial(name: str, invariants: Mapping[str, Any], numbers: Mapping[str, Any]) -> Any:
    """A number as given, zero where none is, or an invariant computed from the coordinates."""
    if name not in invariants:
        return mpmath.mpf(numbers.get(name, 0))
    expr = as_expression(invariants[name])
    digits = {s: sp.Float(numbers.get(plain_name(s), 0), DIGITS) for s in expr.free_symbols}
    return precise_number(expr.xreplace(digits))


def precise_number(value: Any) -> Any:
    """A real number in ``DIGITS``; a float is the double that it is."""
    with mpmath.workdps(DIGITS):
        if isinstance(value, float | int):
            return mpmath.mpf(value)
        return mpmath.mpf(sp.Float(as_expression(value).evalf(DIGITS), DIGITS)._mpf_)


def scene_problem(
    system: System | VoronecEquations,
    scene: str | None = None,
    outputs: Sequence[Any] = (),
    time: float | None = None,
    parameters: Mapping[Any, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    instants: int = INSTANTS,
    inputs: Mapping[Any, Any] | None = None,
) -> ReferenceProblem:
    """The motion of a scene, from doubles that every method shares.

    ``time`` is its length where the scene's own is not wanted, ``instants`` how many are compared;
    ``inputs`` are numbers and expressions of the time or the state, over those of the scene.

    Without ``outputs`` the invariants and the velocities are compared, where the system descends
    to its invariants, so that methods on the invariants can take part; else what the scene wants.
    Raises ``DefinitionError`` for input that makes no sense, as ``integrate`` does.
    """
    declared = system.system if isinstance(system, VoronecEquations) else system
    chosen = declared.first_scene if scene is None else scene
    setting = scene_of(declared, chosen, needed=True, instead="a system that declares one")
    assert chosen is not None and setting is not None  # one is needed
    driven = drive(system, inputs, setting, steady="a comparison of methods")
    equations, parameters = driven.equations, {**(parameters or {}), **driven.constants}
    grid = _grid(setting, time, instants)
    wanted = (outputs,) if isinstance(outputs, str | sp.Basic) else tuple(outputs)
    wanted = wanted or _invariant_state(equations) or setting.outputs
    first = integrate(
        equations, replace(setting, outputs=(), inputs={}), times=grid[:1], parameters=parameters,
        initial=initial, method="scipy",
    )  # fmt: skip
    symbols = (*equations.system.coordinates, *equations.system.velocities)
    read = Namespace.of(equations).read_outputs(wanted or symbols)
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
        raise DefinitionError(f"instants = {instants}: give 2 or more")
    return np.linspace(start, end, instants)


def _invariant_state(equations: VoronecEquations) -> tuple[Any, ...]:
    """Invariants and velocities, where the equations close on them."""
    system = equations.system
    if not system.invariants:
        return ()
    try:
        field = Motions.of(equations).on_invariants
    except VoronecError:
        return ()
    velocities = [
        s for s in system.velocities if plain_name(s) in {str(v) for v in field.velocities}
    ]
    return (*system.invariants, *map(plain_name, velocities))


def _angles(system: System, expressions: Mapping[str, sp.Expr]) -> frozenset[str]:
    """Outputs that are coordinates, and occur in the system as whole multiples under sines only."""
    frame = system.frame.expressions if system.frame is not None else ()
    held = [as_expression(e) for e in (system.lagrangian, *system.constraints, *frame)]
    held += [as_expression(e) for e in system.forces.values()]
    angles = set()
    for name, expr in expressions.items():
        if expr in system.coordinates and _is_only_angle(expr, held):
            angles.add(name)
    return frozenset(angles)


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

"""The modes of a problem that is not smooth: the smooth problem on one side of all switching
surfaces, or along some, with what ends it, and the method that integrates it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import mpmath
import numpy as np
import symengine as se

from voronec.algebra.stable import stable_all
from voronec.equations.program import Block, Program
from voronec.equations.program.python import compiled_digits
from voronec.equations.program.switches import Switch
from voronec.motion.methods import choose
from voronec.motion.modes import LevelSurface, Modes, SmoothBranch, is_length, motion_along_surfaces
from voronec.motion.request import Guard
from voronec.motion.solve import DOUBLE, Progress
from voronec.motion.state_probe import quantities
from voronec.motion.steppers import Integrator, Problem, Run, natural_units, restart, with_parts

GUARD = 64
"""Bits beyond those of the tolerance, in high precision."""
RIM = 100.0
"""A length or radicand of velocities that falls below so many times the tolerance, in units of its
value at the start, has vanished: what is left of it is error."""


@dataclass(frozen=True, eq=False)
class Mode:
    """One mode, ready to be integrated in: a ``corner``, or the motion along surfaces next to it.

    ``sides`` has the sign or floor of every switching surface; ``along`` are the surfaces on which
    the motion is held.  ``watch`` maps names of events to the surfaces at which the mode ends
    (none: at a rim), ``turns`` others to the surfaces that the motion may touch.
    """

    corner: SmoothBranch
    program: Program
    levels: Program
    sides: Mapping[Switch, int]
    along: tuple[LevelSurface, ...]
    watch: Mapping[str, tuple[LevelSurface, ...]]
    turns: Mapping[str, LevelSurface]
    problem: Problem
    chosen: Mapping[str, Any]
    solver: Integrator | None

    @property
    def wide_program(self) -> Program:
        """The program of a motion along surfaces with what is integrated beside the state."""
        levels = self.problem.levels
        assert levels is not None  # a mode has events where it ends
        return with_parts(self.problem.program, levels.extras, whole=True)

    def run(self, state: np.ndarray, values: Sequence[Any], times: np.ndarray) -> Run:
        """The motion from a state on."""
        problem, solver = self.problem, self.solver
        if solver is None:
            problem = replace(problem, start=state, parameters=list(values))
            solver = choose(self.chosen["method"], problem, times)[0]
        problem.parameters[:] = values  # type: ignore[index]
        return restart(solver, problem)(state, times)


@dataclass
class ModeSet:
    """All modes of a problem, each made ready when a run first comes to it."""

    method: str
    problem: Problem
    grid: np.ndarray
    modes: Modes
    bits: int
    known_modes: dict[Any, Mode] = field(default_factory=dict)
    known: dict[str, Any] = field(init=False)
    start: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.order = 1 if self.grid[-1] >= self.grid[0] else -1
        self.working = 2 * self.bits + GUARD
        start, parameters = self.problem.start, self.problem.parameters
        if self.bits != DOUBLE and self.problem.exact is not None:
            start, parameters = self.problem.exact(self.bits)
        self.start = np.array([mpmath.mpf(x) for x in start], dtype=object)
        names = map(str, self.problem.program.parameters)
        self.known = dict(zip(names, map(mpmath.mpf, parameters), strict=True))
        self.progress = Progress(self.problem.progress) if self.problem.progress else None

    def elsewhere(self, time: float, start: np.ndarray, parameters: Sequence[Any]) -> Self:
        """The modes for another start and other parameters; what a rim is depends on those."""
        problem = replace(self.problem, start=start.copy(), parameters=list(parameters))
        grid = np.array([time, time + (self.grid[-1] - self.grid[0])])
        kept = {k: p for k, p in self.known_modes.items() if not p.corner.rims}
        with mpmath.workprec(self.working):
            return replace(self, problem=problem, grid=grid, known_modes=kept)

    def name_parameters(self, values: Mapping[Switch, int], time: Any) -> dict[str, Any]:
        """Parameters by name at a time, floors among them."""
        floors = {str(self.modes.floor(w)): mpmath.mpf(n) for w, n in values.items() if w.whole}
        if self.problem.changing is None:
            return self.known | floors
        called = self.problem.changing.values_at(float(time))
        return self.known | floors | {name: mpmath.mpf(x) for name, x in called.items()}

    def values(self, program: Program, sides: Mapping[Switch, int], time: Any) -> list[Any]:
        """The parameters of a mode's program at a time."""
        named = self.name_parameters(sides, time)
        return [named[str(p)] for p in program.parameters]

    def mode(
        self,
        corners: tuple[SmoothBranch, ...],
        sides: Mapping[Switch, int],
        along: tuple[LevelSurface, ...],
    ) -> Any:
        """The mode on ``sides`` of all switching surfaces, or ``along`` surfaces between
        ``corners``; None where none is there."""
        floors = tuple(s for s in along if s.switch.whole)
        key = (corners, along, tuple(sides[s.switch] for s in floors))
        known = self.known_modes.get(key)
        if known is None:
            known = self._make_mode(corners, sides, along)
            if known is None:
                return None
            self.known_modes[key] = known
        return replace(known, sides=sides, watch=self._watched_surfaces(corners[0], sides, along))

    def _switching_ends(
        self, corner: SmoothBranch, sides: Mapping[Switch, int], along: tuple[LevelSurface, ...]
    ) -> dict[str, tuple[LevelSurface, Any]]:
        """The switching surfaces at which a mode ends, with what falls through zero there."""
        ends: dict[str, tuple[LevelSurface, Any]] = {}
        for i, switch in enumerate(corner.switches):
            if switch.fixed or self.modes.is_held(switch, along):
                continue
            name, g = f"switching surface {i}", switch.function
            if switch.whole:
                floor, level = self.modes.floor(switch), sides[switch]
                ends[f"{name} below"] = LevelSurface(switch, level), g - floor
                ends[f"{name} above"] = LevelSurface(switch, level + 1), floor + 1 - g
            else:
                ends[name] = LevelSurface(switch), corner.signs[switch] * g
        return ends

    def _watched_surfaces(
        self, corner: SmoothBranch, sides: Mapping[Switch, int], along: tuple[LevelSurface, ...]
    ) -> dict[str, tuple[LevelSurface, ...]]:
        ends = self._switching_ends(corner, sides, along)
        rims = {f"rim {i}": () for i in range(len(corner.rims))}
        weights = {f"weight {i}": along for i in range(len(along))}
        return {name: (surface,) for name, (surface, _) in ends.items()} | rims | weights

    def _fall(self, base: Any, corner: SmoothBranch, sides: Mapping[Switch, int]) -> Any:
        """What falls through zero where a radicand of velocities has vanished; of a sum of squares,
        which may be beyond doubles, by its root."""
        (root,) = stable_all([se.sqrt(base)])
        measure = root if is_length(root) else base
        program = quantities(corner.form, {"size": measure})
        begin = self.grid[0]
        values = self.values(program, sides, begin)
        size = compiled_digits(program)[1](begin, list(self.start), values)[0]
        small = RIM * self.problem.tol * float(abs(size))
        return measure - se.Rational(*small.as_integer_ratio())

    def _make_mode(
        self,
        corners: tuple[SmoothBranch, ...],
        sides: Mapping[Switch, int],
        along: tuple[LevelSurface, ...],
    ) -> Mode | None:
        """The smooth problem on ``sides`` of all switching surfaces, or along some; None where none
        is there."""
        corner = corners[0]
        ends = self._switching_ends(corner, sides, along)
        functions = {  # of what is held, but for the tolerance, nothing is to be seen
            name: se.Integer(0) if self.modes.stays_zero(e, along) else e
            for name, e in corner.functions.items()
        }
        functions |= {name: level for name, (_, level) in ends.items()}
        functions |= {f"rim {i}": self._fall(e, corner, sides) for i, e in enumerate(corner.rims)}
        program, turns = corner.program, {}
        if along:
            below = [None, *along]
            numbered = [
                self._number_corner(c, s, along) for c, s in zip(corners, below, strict=True)
            ]
            motion = motion_along_surfaces(numbered, along)
            if motion is None:
                return None
            program, weighing = _hold_still(motion[0], along), motion[1]
            kinds = [f"{w} {i}" for w in ("weight", "return") for i in range(len(along))]
            block = Block(weighing.assignments, (*functions.values(), *weighing.results))
            levels = replace(program, names=(*functions, *kinds), extras=block)
        else:
            turns = {f"turn at {name}": surface for name, (surface, _) in ends.items()}
            levels = _with_turns(quantities(corner.form, functions), program, turns, functions)
        problem = self._problem_of_mode(corner, program, levels, sides, along, turns)
        solver, chosen = self._choose_stepper(problem)
        lasting = solver if chosen["method"] == "heyoka" else None
        return Mode(corner, program, levels, sides, along, {}, turns, problem, chosen, lasting)

    def _problem_of_mode(
        self, corner: SmoothBranch, program: Program, levels: Program, sides: Mapping[Switch, int],
        along: tuple[LevelSurface, ...], turns: Mapping[str, Any],
    ) -> Problem:  # fmt: skip
        """What is to be integrated until a surface is met that the mode does not lie along."""
        given, ends = self.problem, [*self._watched_surfaces(corner, sides, along)]
        events = [Guard(name, -self.order, stop=True) for name in ends]
        events += [Guard(name, 1) for name in turns]
        watching = levels if not along else _of_events(levels, [*given.events], ends)
        numbers = [*map(float, self.values(program, sides, self.grid[0]))]
        return replace(
            given, program=program, start=given.start.copy(), levels=watching,
            events=(*given.events, *events), parameters=numbers,
            exact=None, switching_surfaces=frozenset(ends),
            suspect=None if along else given.suspect, progress=self.progress,
            # steps begin anew at each of these; along surfaces they alone tell a time
            apart=frozenset() if along else frozenset((*ends, *turns)),
            whole=bool(along),
            # what has come to rest but for rounding is measured as it was while it moved
            units=natural_units(given) if along else given.units,
        )  # fmt: skip

    def _choose_stepper(self, problem: Problem) -> tuple[Any, dict[str, Any]]:
        """The stepper of a mode, by the method of the first one; in many bits by flint."""
        first = next(iter(self.known_modes.values()), None)
        method = self.method if first is None else first.chosen["method"]
        return choose("flint" if self.bits != DOUBLE else method, problem, self.grid)

    def _number_corner(
        self, corner: SmoothBranch, below: LevelSurface | None, along: Sequence[LevelSurface]
    ) -> SmoothBranch:
        """A corner with numbers for the floors along which the motion is held."""
        floors = {
            self.modes.floor(s.switch): se.Integer(s.value(-1 if s == below else 1))
            for s in along if s.switch.whole
        }  # fmt: skip
        if not floors:
            return corner
        block = corner.program.derivative
        lines = tuple((name, e.xreplace(floors)) for name, e in block.assignments)
        results = tuple(se.sympify(r).xreplace(floors) for r in block.results)
        return replace(corner, program=replace(corner.program, derivative=Block(lines, results)))


def _with_turns(
    levels: Program,
    program: Program,
    turns: Mapping[str, LevelSurface],
    functions: Mapping[str, Any],
) -> Program:
    """The events' quantities, and the rates of those of ``functions`` that turn."""
    lines = program.derivative.assignments
    fresh = {name: se.Symbol(f"level {i}") for i, (name, _) in enumerate(levels.extras.assignments)}
    assignments = tuple((fresh[n], e.xreplace(fresh)) for n, e in levels.extras.assignments)
    results = tuple(se.sympify(r).xreplace(fresh) for r in levels.extras.results)
    moved = [program.rate(functions[name.removeprefix("turn at ")]) for name in turns]
    block = Block((*lines, *assignments), (*results, *moved))
    return replace(levels, names=(*levels.names, *turns), extras=block)


def _hold_still(program: Program, along: Sequence[LevelSurface]) -> Program:
    """The program of a motion along surfaces, whose rates hold what these surfaces say of a state
    in place of it, where that is linear in it: where nothing moves the slope of a root of the
    state may have no value."""
    states, held = frozenset(program.state), dict[Any, Any]()
    for surface in along:
        function = surface.function.xreplace(held)
        for x in sorted(function.free_symbols & states, key=str):
            slope = function.diff(x)
            if slope in (1, -1):
                there = {x: x - function / slope}
                held = {k: e.xreplace(there) for k, e in held.items()} | there
                break
    flow = tuple(se.sympify(r).xreplace(held) for r in program.derivative.results)
    return replace(program, derivative=replace(program.derivative, results=flow))


def _of_events(levels: Program, given: Sequence[Guard], ends: Sequence[str]) -> Program:
    """What the events of a motion along surfaces look at: weights by how far they are from +-1."""
    named = dict(zip(levels.names, levels.extras.results, strict=True))
    results = [named[e.name] for e in given]
    results += [1 - named[n] ** 2 if n.startswith("weight") else named[n] for n in ends]
    names = (*(e.name for e in given), *ends)
    return replace(levels, names=names, extras=replace(levels.extras, results=tuple(results)))

"""From one smooth mode of a right-hand side that is not smooth to another.

A mode ends where a switching surface is reached, as an event does, and ``Crossroads`` tells how the
motion goes on: through, back, or along.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, log, log2
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.equations.program import Program
from voronec.equations.program.python import compiled_digits
from voronec.equations.program.switches import FLAT, SATURATION
from voronec.errors import EngineLimit
from voronec.motion.crossings import crosses
from voronec.motion.input_knots import in_pieces
from voronec.motion.methods import is_exact
from voronec.motion.mode_set import GUARD, Mode
from voronec.motion.mode_transitions import NO_VALUE, PAST, TOUCH, Crossroads
from voronec.motion.modes import Modes, SmoothBranch
from voronec.motion.request import Guard
from voronec.motion.solve import COINCIDENT, DOUBLE, Arrival, Phase, Solver
from voronec.motion.step_defects import program_rates
from voronec.motion.steppers import Integrator, Problem, Rates, Run, Termination, in_kind, until

RIM = "the motion comes to rest where a root of velocities in its equations has no slope"


@dataclass(frozen=True)
class SwitchedIntegrator:
    """The integrator of a problem that is not smooth, and what ``Cost`` says of it.

    ``corner`` are the equations with which it starts, and ``values`` those of its parameters; None
    where no motion starts.
    """

    solver: Integrator
    chosen: dict[str, Any]
    corner: SmoothBranch | None
    values: Sequence[float]
    roads: Crossroads

    @classmethod
    def of(cls, roads: Crossroads) -> SwitchedIntegrator:
        """The way from the start of a problem."""
        problem, grid = roads.problem, roads.grid
        with mpmath.workprec(roads.working):
            first = roads.next_mode(grid[0], roads.start, {}, ())

        def run(times: np.ndarray) -> Run:
            return _Switches(roads).run(times, first)

        if isinstance(first, str):
            words = {"method": roads.method, "reason": "nothing moves", "tolerance": problem.tol}
            return cls(run, words, None, (), roads)
        values = [float(x) for x in roads.values(first.corner.program, first.sides, grid[0])]
        return cls(run, dict(first.chosen), first.corner, values, roads)

    def elsewhere(
        self, time: float, start: np.ndarray, parameters: Sequence[Any]
    ) -> SwitchedIntegrator:
        """This integrator from another start, with what was made ready for the first one."""
        return SwitchedIntegrator.of(self.roads.elsewhere(time, start, parameters))


def through_switching_surfaces(
    method: str,
    problem: Problem,
    grid: np.ndarray,
    form: Any,
    functions: Mapping[str, Any],
) -> SwitchedIntegrator | None:
    """The integrator of a problem that is not smooth; None where it is smooth.

    ``form`` are the equations of the problem's program, ``functions`` those of its events by name,
    in the engine's symbols.  Where parameters change at knots, each piece goes its own way;
    functions of Python's are asked for their values wherever the motion is looked at.
    """
    changing = problem.changing
    if changing is None:
        return _through_switching_surfaces(method, problem, grid, form, functions)
    quiet = replace(
        problem, changing=changing.functional, progress=None
    )  # pieces are told of one by one
    first = _through_switching_surfaces(method, quiet, grid, form, functions)
    if first is None:
        return None

    def make(piece: Problem) -> Integrator:
        def run(times: np.ndarray) -> Run:
            if first.roads.bits == DOUBLE:
                again = first.elsewhere(float(times[0]), piece.start, piece.parameters)
                return again.solver(times)
            switched = _through_switching_surfaces(method, piece, times, form, functions)
            assert switched is not None
            return switched.solver(times)

        return run

    return replace(first, solver=in_pieces(make, problem, anew=True))


def is_switched(method: str, program: Program, form: Any, tol: float) -> bool:
    """Whether the equations ``form`` of a program are smooth piece by piece alone."""
    flat = _saturation(tol, is_exact(method, tol))
    return program.is_rough and Modes.of(form, {}, flat) is not None


def _through_switching_surfaces(
    method: str, problem: Problem, grid: np.ndarray, form: Any, functions: Mapping[str, Any]
) -> SwitchedIntegrator | None:
    if not problem.is_rough:
        return None
    exact = is_exact(method, problem.tol)
    modes = Modes.of(form, functions, _saturation(problem.tol, exact), problem.conditions)
    if modes is None:
        return None
    if modes.cusps and (exact or method == "heyoka"):
        raise EngineLimit(
            f"the root of {min(map(str, modes.cusps))} in the equations has no Taylor series where "
            "it vanishes; use method='scipy'"
        )
    method = "scipy" if modes.cusps and method == "auto" else method
    bits = ceil(-log2(problem.tol)) + GUARD if exact else DOUBLE
    with mpmath.workprec(2 * bits + GUARD):
        roads = Crossroads(method, problem, grid, modes, bits)
    return SwitchedIntegrator.of(roads)


def _saturation(tol: float, exact: bool) -> Any:
    """Where tanh w counts as flat.

    Beyond, exp(-2 w) is to be less than the tolerance; within, the coefficients of a series of
    order N = 0.6 log(1/tol) must be seen while a step takes w by no more than N/4, half the way to
    where they are largest: exp(-2 w) (N/2)^N/N! > tol.
    """
    reach = se.Rational(round(100 * FLAT * -log(tol)), 100)
    return reach if exact else min(reach, SATURATION)


@dataclass
class _Switches:
    """The change from one mode to another where a switching surface is met; ``what`` of a phase is
    its mode."""

    roads: Crossroads
    switched: Any = None
    lingers: int = 0

    def run(self, grid: np.ndarray, first: Mode | str) -> Run:
        """The run on a grid, from the first mode on."""
        roads, problem = self.roads, self.roads.problem
        solver = Solver(grid, problem.events, problem.dense, roads.progress, roads.bits)
        with mpmath.workprec(roads.working):
            home = self.number(roads.start)
            if isinstance(first, str):
                return solver.run(Termination(first, grid[0], home))
            return solver.run(self.phase(first, grid[0], roads.start, home, (*grid[1:2],)))

    def number(self, state: np.ndarray) -> np.ndarray:
        """A state in the numbers of the run."""
        if self.roads.bits == DOUBLE:
            return state.astype(float)
        with mpmath.workprec(self.roads.bits):
            return np.array([+mpmath.mpf(x) for x in state], dtype=object)

    def phase(
        self, mode: Mode, time: Any, state: np.ndarray, home: np.ndarray, ahead: Sequence[Any],
        happened: Sequence[Guard] = (),
    ) -> Phase:  # fmt: skip
        """The motion in a mode from a state on, or from a moment later where that has no rates and
        an instant of the grid is not ``ahead`` of it."""
        roads = self.roads
        begin = roads.begin(mode, time, state)
        if all(roads.order * (begin[0] - t) < 0 for t in ahead):
            time, state = begin

        def integrate(start: np.ndarray, times: np.ndarray) -> Run:
            values = roads.values(mode.program, mode.sides, time)
            if roads.bits == DOUBLE:
                values = list(map(float, values))
            return self.cut(mode, mode.run(start, values, times))

        def to_home(run: Run) -> Run:
            rates = self.rates_of_mode(mode)
            return replace(
                run, t=in_kind(run.t, home.dtype), held=bool(mode.along),
                samples=tuple(replace(sample, rates=rates) for sample in run.samples),
            )  # fmt: skip

        guards = dict.fromkeys(mode.watch, self)
        start = self.number(state)
        return Phase(mode, time, start, home, integrate, guards, to_home, happened=happened)

    def rates_of_mode(self, mode: Mode) -> Rates:
        """The right side in a mode."""
        roads = self.roads

        def at(times: np.ndarray) -> list[Any]:
            moments = times if roads.problem.changing is not None else times[:1]
            rows = [list(map(float, roads.values(mode.program, mode.sides, t))) for t in moments]
            return list(np.array(rows).reshape(len(moments), -1).T)

        return program_rates(mode.program, at)

    def cut(self, mode: Mode, part: Run) -> Run:
        """A stretch up to where it touches a switching surface along which it may have come, or,
        into the future, beyond which it may go on."""
        reason = TOUCH if self.roads.order > 0 else PAST
        for name, surface in mode.turns.items():
            for time, state in zip(*part.crossings[name], strict=True):
                if self.roads.is_open(time, state, surface, mode.sides):
                    kept = [self.roads.order * (t - time) <= 0 for t in part.t]
                    return replace(
                        part, t=part.t[kept], states=part.states[kept], stopped="",
                        crossings=until(part.crossings, part.t[0], time),
                        halt=Termination(reason.format(surface), time, state),
                    )  # fmt: skip
        return part

    def next(self, phase: Phase, here: Arrival) -> Phase | Termination:
        """The mode in which the motion goes on, and what happens just at the change."""
        roads, before, time = self.roads, phase.what, here.time
        state = np.array(list(map(mpmath.mpf, here.state)), dtype=object)
        hit = before.watch[here.guard]
        if not hit:
            return Termination(RIM, time, here.home)
        single = len(hit) == 1 and not before.along
        if (single or roads.order < 0) and roads.is_open(time, state, hit[0], before.sides):
            reason = TOUCH if roads.order > 0 else PAST
            return Termination(reason.format(hit[0]), time, here.home)
        # what held the motion is met still, though the state may be some rounding beside it
        hit = tuple(dict.fromkeys((*hit, *before.along)))
        state = roads.on_surfaces(time, state, hit, before.sides)
        sides = {w: s for w, s in before.sides.items() if w not in {x.switch for x in hit}}
        mode = roads.next_mode(time, state, sides, hit)
        if isinstance(mode, str):
            return Termination(mode, time, self.number(state))
        if mode.along:
            state = roads.on_surfaces(time, state, mode.along, mode.sides)
        events, home = roads.problem.events, self.number(state)
        happened = [e for e in events if self.passes(e, before, mode, time, state)]
        ahead = () if here.ahead is None else (here.ahead,)
        if (mode.along, mode.sides) == (before.along, before.sides) and ahead:
            time, state = self.pass_by(mode, time, state, here.ahead)
        self.switched = here.time
        return self.phase(mode, time, state, home, ahead, happened)

    def pass_by(
        self, mode: Mode, time: Any, state: np.ndarray, ahead: Any
    ) -> tuple[Any, np.ndarray]:
        """Leave a place where a mode ended and goes on, as where a push just reaches what friction
        bears: rounding would end it again and again, so that each time more is passed by.  No
        instant of the grid is."""
        later = self.roads.moment(mode, time, state, 4**self.lingers)
        way = abs(later[0] - time)
        near = self.switched is not None and abs(time - self.switched) <= way
        self.lingers = self.lingers + 1 if near else 0
        return later if near and self.roads.order * (later[0] - ahead) < 0 else (time, state)

    def passes(self, event: Guard, before: Mode, after: Mode, time: Any, state: np.ndarray) -> bool:
        """Whether an event happens just where the mode changes, or its function jumps through zero
        there: neither stretch sees it then."""
        left, right = (self.level(event, mode, time, state, 0) for mode in (before, after))
        if None in (left, right):
            return False
        if abs(left) <= COINCIDENT * max(1, abs(time)):  # else it jumps, or does not pass
            moved = [
                self.level(event, before, time, state, -1),
                self.level(event, after, time, state, 1),
            ]
            if None in moved:
                return False
            left, right = moved[0] - left, moved[1] - right
        return bool(crosses(left, right, event.direction * self.roads.order))

    def level(self, event: Guard, mode: Mode, time: Any, state: np.ndarray, way: int) -> Any:
        """An event's function a moment before (-1) or after (1) a state in a mode."""
        roads = self.roads
        time, state = roads.moment(mode, time, state, way)
        values = roads.values(mode.program, mode.sides, time)
        # others may have no value there
        alone = mode.levels.only([mode.levels.names.index(event.name)])
        try:
            return compiled_digits(alone)[1](time, list(state), values)[0]
        except NO_VALUE:
            return None

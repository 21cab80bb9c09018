"""The stepper for right-hand sides that are not smooth: one smooth stretch after another.

A stretch ends where a switching surface is reached, as an event does, and ``Crossroads`` tells how
the motion goes on: through, back, or along.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, log, log2
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.equations.program.python import compiled_digits
from voronec.equations.program.switches import FLAT, SATURATION
from voronec.errors import EngineLimit
from voronec.motion.methods import is_exact
from voronec.motion.mode_set import DOUBLE, GUARD, Mode
from voronec.motion.mode_transitions import NO_VALUE, PAST, TOUCH, Crossroads
from voronec.motion.modes import LevelSurface, Modes, SmoothBranch
from voronec.motion.request import Guard
from voronec.motion.step_defects import program_rates
from voronec.motion.steppers import Integrator, Problem, Run, Termination
from voronec.motion.steppers.run import (
    crossing_arrays,
    in_parts,
    in_pieces,
    until,
)
from voronec.motion.steppers.samples import Rates, StepSamples

__all__ = ["SwitchedIntegrator", "through_switching_surfaces"]

WINDOW, CRAWL = 200, 1e-8
"""So many switches that cover less than this part of the span lead nowhere."""
ULPS = 16
"""Instants that lie closer together than so many roundings of them are one."""
LOOKS = 16
"""At so many instants of a stretch it is looked at whether a switching surface was missed."""
COINCIDENT = 1e-9
"""An event that is closer to zero than this at a switch, in units of its terms, may pass there."""
RIM = "the motion comes to rest where a root of velocities in its equations has no slope"
ZENO = "switches follow one another ever faster"


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
        if isinstance(first, str):
            words = {"method": roads.method, "reason": "nothing moves", "tolerance": problem.tol}
            return cls(
                lambda times: _run_without_steps(problem, times, first), words, None, (), roads
            )
        values = [float(x) for x in roads.values(first.corner.program, first.sides, grid[0])]

        def run(times: np.ndarray) -> Run:
            return _Passage(roads, times, first).run()

        return cls(run, dict(first.chosen), first.corner, values, roads)

    def elsewhere(
        self, time: float, start: np.ndarray, parameters: Sequence[Any]
    ) -> SwitchedIntegrator:
        """The same from another start, with what was made ready for this one."""
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
    functional = None if changing is None else changing.functional
    first = _through_switching_surfaces(
        method, replace(problem, changing=functional), grid, form, functions
    )
    if changing is None or first is None:
        return first

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


def _through_switching_surfaces(
    method: str, problem: Problem, grid: np.ndarray, form: Any, functions: Mapping[str, Any]
) -> SwitchedIntegrator | None:
    if not problem.is_rough:
        return None
    exact = is_exact(method, problem.tol)
    modes = Modes.of(form, functions, _saturation(problem.tol, exact))
    if modes is None:
        return None
    if modes.cusps and not exact and method == "heyoka":
        raise EngineLimit(
            f"the root of {min(map(str, modes.cusps))} in the equations has no Taylor series where "
            "it vanishes; use method='scipy', or flint"
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


def _run_without_steps(problem: Problem, times: np.ndarray, reason: str) -> Run:
    """The run that ends where it starts."""
    nothing = {e.name: (np.empty(0), np.empty((0, len(problem.start)))) for e in problem.events}
    halt = Termination(reason, times[0], problem.start)
    return Run(times[:1].copy(), problem.start[None, :].copy(), 0, 0, nothing, halt)


@dataclass(frozen=True)
class _ModeSegment:
    """A part of the way in one mode; ``inside``, of dense runs, gives states in it."""

    end: Any
    inside: Any


@dataclass
class _Passage:
    """One run: where it is, and what it has seen."""

    roads: Crossroads
    grid: np.ndarray
    mode: Mode
    done: int = 1
    steps: int = 0
    evaluations: int = 0
    switches: int = 0
    rows: list[np.ndarray] = field(init=False)
    crossings: dict[str, list[tuple[Any, np.ndarray]]] = field(default_factory=dict)
    segments: list[_ModeSegment] = field(default_factory=list)
    recent: list[Any] = field(default_factory=list)
    held: bool = False
    samples: list[StepSamples] = field(default_factory=list)
    lingers: int = 0

    def __post_init__(self) -> None:
        self.order, self.exact = self.roads.order, self.roads.bits != DOUBLE
        self.time, self.state = self.grid[0], self.roads.start
        self.rows = [self.number(self.state)]

    def number(self, state: np.ndarray) -> np.ndarray:
        """A state in the numbers of the run."""
        if not self.exact:
            return state.astype(float)
        with mpmath.workprec(self.roads.bits):
            return np.array([+mpmath.mpf(x) for x in state], dtype=object)

    def run(self) -> Run:
        """Stretch after stretch, up to the end of the grid."""
        with mpmath.workprec(self.roads.working):
            return self.pass_through()

    def pass_through(self) -> Run:
        """The same, in numbers that are long enough."""
        try:
            while self.done < len(self.grid):
                part = self.segment()
                if part.halt or part.interrupted:
                    return self.result(part.halt, part.interrupted)
                if part.stopped and part.stopped not in self.mode.watch:
                    return self.result(stopped=part.stopped)
                if not part.stopped:
                    break
                end = self.switch(self.mode.watch[part.stopped])
                if end is not None:
                    return end
                self.arrive()
        except KeyboardInterrupt:
            return self.result(interrupted=True)
        return self.result()

    def arrive(self) -> None:
        """Enter the instants that rounding alone tells from that of a switch: no step fits between,
        and a switching surface would be met again and again."""
        near = ULPS * 2.0**-self.roads.bits * abs(self.time)
        while self.done < len(self.grid) and abs(self.grid[self.done] - self.time) <= near:
            self.rows.append(self.number(self.state))
            self.done += 1

    def segment(self) -> Run:
        """Go on in a mode until it ends, or the grid does."""
        mode, roads = self.mode, self.roads
        begin = roads.begin(mode, self.time, self.state)
        if self.order * (begin[0] - self.grid[self.done]) < 0:
            self.time, self.state = begin
        kind = object if self.exact else float
        times = np.array([self.time, *self.grid[self.done :]], dtype=kind)
        if roads.progress is not None:
            whole = self.grid[-1] - self.grid[0]
            roads.progress.done = float((self.time - self.grid[0]) / whole)
            roads.progress.part = float((times[-1] - self.time) / whole)
        values = roads.values(mode.program, mode.sides, self.time)
        if not self.exact:
            values = list(map(float, values))
        part = mode.run(self.number(self.state), values, times)
        if mode.solver is not None and self.strays(part):
            part = mode.run_by("scipy", self.number(self.state), values, times)
        part = self.cut(part)
        self.samples += [replace(sample, rates=self.rates_of_mode()) for sample in part.samples]
        self.held = self.held or bool(mode.along)
        self.steps += part.steps
        self.evaluations += part.evaluations
        count = int(sum(self.order * (t - part.t[-1]) <= 0 for t in self.grid[self.done :]))
        where = {float(t): i for i, t in enumerate(part.t)}
        last = len(part.t) - 1
        taken = [where.get(float(t), last) for t in self.grid[self.done : self.done + count]]
        self.rows += [part.states[i] for i in taken]
        self.done += count
        for event in roads.problem.events:
            self.crossings.setdefault(event.name, []).extend(
                zip(*part.crossings[event.name], strict=True)
            )
        if roads.problem.dense:
            self.segments.append(_ModeSegment(part.t[-1], part.inside))
        self.time = part.t[-1]
        self.state = np.array(list(map(mpmath.mpf, part.states[-1])), dtype=object)
        return part

    def rates_of_mode(self) -> Rates:
        """The right side in the mode."""
        roads, mode = self.roads, self.mode

        def at(times: np.ndarray) -> list[Any]:
            moments = times if roads.problem.changing is not None else times[:1]
            rows = [list(map(float, roads.values(mode.program, mode.sides, t))) for t in moments]
            return list(np.array(rows).reshape(len(moments), -1).T)

        return program_rates(mode.program, at)

    def strays(self, part: Run) -> bool:
        """Whether a stretch by heyoka is beyond a switching surface where it was looked at: heyoka
        gives up where zeros of a polynomial are too close together, and goes on as if there were
        none."""
        looks = sorted({(len(part.t) - 1) * k // LOOKS for k in range(1, LOOKS + 1)} - {0})
        beyond, sides = self.roads.is_beyond, self.mode.sides
        return any(
            beyond(switch, part.t[i], part.states[i], sides)
            for switch in self.mode.switches - {s.switch for s in self.mode.along}
            if not beyond(switch, self.time, self.state, sides)
            for i in looks
            if np.isfinite(part.states[i]).all()
        )

    def cut(self, part: Run) -> Run:
        """A stretch up to where it touches a switching surface along which it may have come, or,
        into the future, beyond which it may go on."""
        reason = TOUCH if self.roads.order > 0 else PAST
        for name, surface in self.mode.turns.items():
            for time, state in zip(*part.crossings[name], strict=True):
                if self.roads.is_open(time, state, surface, self.mode.sides):
                    kept = [self.order * (t - time) <= 0 for t in part.t]
                    return replace(
                        part, t=part.t[kept], states=part.states[kept], stopped="",
                        crossings=until(part.crossings, self.time, time),
                        halt=Termination(reason.format(surface), time, state),
                    )  # fmt: skip
        return part

    def switch(self, hit: tuple[LevelSurface, ...]) -> Run | None:
        """Change the mode where one ended; the run, where that ends it."""
        roads, before = self.roads, self.mode
        if not hit:
            return self.result(Termination(RIM, self.time, self.number(self.state)))
        single = len(hit) == 1 and not before.along
        if (single or roads.order < 0) and roads.is_open(
            self.time, self.state, hit[0], before.sides
        ):
            reason = TOUCH if roads.order > 0 else PAST
            return self.result(
                Termination(reason.format(hit[0]), self.time, self.number(self.state))
            )
        # what held the motion is met still, though the state may be some rounding beside it
        hit = tuple(dict.fromkeys((*hit, *before.along)))
        self.state = roads.on_surfaces(self.time, self.state, hit, before.sides)
        self.switches += 1
        self.recent.append(self.time)
        if len(self.recent) > WINDOW:
            moved = abs(self.time - self.recent.pop(0))
            if moved <= CRAWL * float(np.ptp(self.grid)):
                return self.result(Termination(ZENO, self.time, self.number(self.state)))
        sides = {w: s for w, s in before.sides.items() if w not in {x.switch for x in hit}}
        found = roads.next_mode(self.time, self.state, sides, hit)
        if isinstance(found, str):
            return self.result(Termination(found, self.time, self.number(self.state)))
        self.mode = found
        if found.along:
            self.state = roads.on_surfaces(self.time, self.state, found.along, found.sides)
        if (found.along, found.sides) == (before.along, before.sides):
            self.pass_by()
        for event in roads.problem.events:
            if self.passes(event, before, found):
                state = self.number(self.state)
                self.crossings[event.name].append((self.time, state))
                if event.stop:
                    return self.result(stopped=event.name)
        return None

    def pass_by(self) -> None:
        """Leave a place where a mode ended and goes on, as where a push just reaches what friction
        bears: rounding would end it again and again, so that each time more is passed by.  No
        instant of the grid is."""
        time, state = self.roads.moment(self.mode, self.time, self.state, 4**self.lingers)
        near = len(self.recent) > 1 and abs(self.time - self.recent[-2]) <= abs(time - self.time)
        if near and self.order * (time - self.grid[self.done]) < 0:
            self.time, self.state = time, state
        self.lingers = self.lingers + 1 if near else 0

    def passes(self, event: Guard, before: Mode, after: Mode) -> bool:
        """Whether an event happens just where the mode changes, or its function jumps through zero
        there: neither stretch sees it then."""
        seen = self.crossings.get(event.name, [])
        if seen and abs(seen[-1][0] - self.time) <= COINCIDENT * max(1, abs(self.time)):
            return False
        left, right = (self.level(event, mode, 0) for mode in (before, after))
        if None in (left, right):
            return False
        if abs(left) <= COINCIDENT * max(1, abs(self.time)):  # else it jumps, or does not pass
            moved = [self.level(event, before, -1), self.level(event, after, 1)]
            if None in moved:
                return False
            left, right = moved[0] - left, moved[1] - right
        direction = event.direction * self.order
        upwards = left < 0 <= right and direction >= 0
        return bool(upwards or (left > 0 >= right and direction <= 0))

    def level(self, event: Guard, mode: Mode, way: int) -> Any:
        """An event's function a moment before (-1) or after (1) the switch in a mode."""
        roads = self.roads
        time, state = roads.moment(mode, self.time, self.state, way)
        values = roads.values(mode.program, mode.sides, time)
        # others may have no value there
        alone = mode.levels.only([mode.levels.names.index(event.name)])
        try:
            return compiled_digits(alone)[1](time, list(state), values)[0]
        except NO_VALUE:
            return None

    def result(
        self, halt: Termination | None = None, interrupted: bool = False, stopped: str = ""
    ) -> Run:
        t, kind = self.grid[: self.done], object if self.exact else float
        if self.exact:
            t = np.array([mpmath.mpf(x) for x in t], dtype=object)
        rows = list(self.rows)
        if stopped and self.time != t[-1]:
            t, rows = np.append(t, np.array([self.time], kind)), [*rows, self.number(self.state)]
        events, width = self.roads.problem.events, len(self.state)
        crossings = crossing_arrays(self.crossings, events, width, kind)
        return Run(
            t.copy(), np.array(rows, dtype=kind), self.steps, self.evaluations, crossings, halt,
            interrupted, stopped, self.inside if self.roads.problem.dense else None,
            switches=self.switches, held=self.held, samples=tuple(self.samples),
        )  # fmt: skip

    def inside(self, times: np.ndarray) -> np.ndarray:
        """States at any times reached."""
        ends, parts = [s.end for s in self.segments], [s.inside for s in self.segments]
        return in_parts(ends, self.order, parts, times, self.rows[0][None, :])

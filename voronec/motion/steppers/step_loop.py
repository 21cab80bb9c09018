"""One loop for every integrator that goes step by step: grid, events, dense output, guards."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from voronec.equations.program import compile_program
from voronec.motion.crossings import SPECK, Levels, StepCourse, crossings
from voronec.motion.request import Guard
from voronec.motion.steppers.feedback import MEND, ControllerFailure
from voronec.motion.steppers.run import (
    COLLAPSE,
    DISTANT,
    SINGULAR,
    Log,
    Problem,
    Run,
    StallDetector,
    Termination,
    Ticker,
    crossing_arrays,
    in_parts,
    until,
)
from voronec.motion.steppers.samples import StepSampler, StepSamples

TINY = 1e-6
"""The part of a step over which slopes of functions are taken."""
SUSPECTS = 512
"""States whose mass matrices are looked at together: all of most short runs."""
EVERY = 8
"""Of the steps of a compiled loop one in so many is looked at: a matrix that was singular between
two of them has another number of negative eigenvalues at the next."""


class IntegratorFailure(Exception):
    """An integrator cannot go on, for a reason in words."""


@dataclass(frozen=True)
class Stride:
    """One accepted step, or several, with dense output: times (k,) to states (k, n).

    ``slopes`` are the states and rates at both ends, where they are known at no cost.  ``up_to``
    takes a method of stages up to an earlier instant alone: stages of the whole step, and the dense
    output made of them, look beyond it.  Several steps have ``inner`` ends (s - 1,), ``looks`` as a
    ``StepCourse`` has them, and give ``samples`` of so many of them, up to a time in the last.
    """

    start: Any
    end: Any
    state: np.ndarray
    at: Callable[[np.ndarray], np.ndarray]
    slopes: tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]] | None = None
    up_to: Callable[[float], Stride] | None = None
    inner: Sequence[float] = ()
    looks: Callable[[], np.ndarray] | None = None
    samples: Callable[[int, Any], tuple[np.ndarray, np.ndarray] | None] | None = None

    def course(self, before: np.ndarray | None = None) -> StepCourse:
        """The step as events are looked for on it."""
        ends = np.array([self.start, *self.inner, self.end], dtype=self.state.dtype)
        return StepCourse(ends, self.at, before, self.looks)


@dataclass(frozen=True)
class Segment:
    """Accepted ``steps`` in which nothing happens, up to the time ``end`` and a state (n,) there.

    ``rows`` (k, n) are the states at the next points of the grid.  Where a problem asks for ends
    of steps, ``times`` (s,) and ``states`` (s, n), or none of these, are there; where it asks for
    dense output, ``strides`` are the steps; ``samples`` are those that were taken.
    """

    steps: int
    rows: np.ndarray
    end: float
    state: np.ndarray
    times: np.ndarray
    states: np.ndarray
    strides: Sequence[Stride]
    samples: tuple[np.ndarray, np.ndarray] | None = None


class Stepper(Protocol):
    """An integrator under way."""

    def advance(self) -> Stride | Segment:
        """The next step, or several; raises ``IntegratorFailure``."""

    @property
    def evaluations(self) -> int:
        """How often the right-hand side was evaluated so far."""


def level_function(problem: Problem) -> Levels:
    """The events' functions at times (k,) and states (k, n), as an array (k, m)."""
    if problem.levels is None or not problem.levels.names:
        return lambda t, _states: np.empty((len(t), 0))
    _, extras = compile_program(problem.levels)
    asked = problem.changing is not None and problem.changing.python_signal is not None
    at = problem.parameters_at()

    def function(t: np.ndarray, states: np.ndarray) -> np.ndarray:
        rows = [at(x, y) for x, y in zip(t, states, strict=True)] if asked else []
        given = np.array(rows).T if asked else problem.parameters
        values = np.empty((len(problem.events), len(t)), dtype=states.dtype)
        for row, value in zip(values, extras(t, list(states.T), list(given)), strict=True):
            row[:] = value
        return values.T

    return function


def march(
    problem: Problem, grid: np.ndarray, stepper: Stepper, levels: Levels,
    stalled: Callable[[int, Any], str] | None = None,
) -> Run:  # fmt: skip
    """The run over a grid; ``stalled`` tells of so many steps, which came to a time, why they lead
    nowhere, by default as a ``StallDetector`` does."""
    stalled = stalled or StallDetector(grid[0], float(grid[-1])).failure
    return _March(problem, grid, stepper, levels, stalled).run()


@dataclass
class _March:
    problem: Problem
    grid: np.ndarray
    stepper: Stepper
    levels: Levels
    stalled: Callable[[int, Any], str]
    log: Log = field(init=False)
    states: np.ndarray = field(init=False)
    strides: list[Stride] = field(default_factory=list)
    ends: list[float] = field(default_factory=list)
    sampler: StepSampler = field(default_factory=StepSampler)
    recent: list[tuple[np.ndarray, np.ndarray, int]] = field(default_factory=list)
    unseen: int = 0
    done: int = 1
    steps: int = 0
    idle: int = 0
    is_on_switching_surface: bool = True
    last_look: tuple[Any, np.ndarray | None] = (None, None)
    last: Termination = field(init=False)

    def __post_init__(self) -> None:
        grid, start = self.grid, self.problem.start
        self.log = Log(
            grid[0],
            float(np.ptp(grid)),
            switching_surfaces=self.problem.switching_surfaces,
        )
        self.states = np.empty((len(grid), len(start)), dtype=start.dtype)
        self.states[0] = start
        self.order = 1 if grid[-1] >= grid[0] else -1
        self.forward = self.order * grid
        self.last = Termination(COLLAPSE, grid[0], start)
        self.suspect(grid[:1], start[None, :])

    def run(self) -> Run:
        ticker = Ticker(self.problem.progress, float(self.grid[0]), float(self.grid[-1]))
        try:
            while self.done < len(self.grid) and not self.log.stopped:
                try:
                    stride = self.stepper.advance()
                except IntegratorFailure as halted:
                    return self.fail(str(halted))
                if isinstance(stride, Segment):
                    self.pass_over(stride)
                else:
                    self.take(stride)
                ticker(self.last.time)
                if self.unseen >= SUSPECTS and (halt := self.singular()):
                    return self.result(halt)
                if reason := self.stalled(self.steps, self.last.time):
                    return self.fail(reason)
        except ControllerFailure as failure:
            return self.result(replace(self.last, reason=str(failure), mend=MEND))
        except KeyboardInterrupt:
            return self.result(interrupted=True)
        return self.result(self.singular())

    def fail(self, reason: str) -> Run:
        """The run up to where its steps lead no farther, or before the first instant of its grid
        that it can only have reached through a singular mass matrix."""
        done = slice(self.done)
        self.recent = [(self.grid[done], self.states[done], 1)] if self.done > 1 else []
        return self.result(self.singular() or replace(self.last, reason=reason))

    def take(self, stride: Stride) -> None:
        """Enter steps: crossings in them, then points of the grid up to the one that stops."""
        end = stride.end
        near = self.near(stride)
        fine = {
            i: event
            for i, event in enumerate(self.problem.events)
            if event.name not in self.problem.coarse or near[i]
        }
        if fine:
            stride, passages = self.happenings(stride, fine)
            self.log.enter_all(passages, stride.at)
            end = self.log.last[0] if self.log.stopped else stride.end
        reached = self.count_until(end)
        ends = [t for t in stride.inner if self.order * t < self.order * end] + [float(end)]
        ahead, none = self.grid[self.done : reached], self.states[:0]
        rows = stride.at(ahead) if len(ahead) else none
        kept = [stride] if self.problem.dense else []
        samples = None if stride.samples is None else stride.samples(len(ends), end)
        last = stride.end, stride.state
        self.pass_over(Segment(len(ends), rows, *last, np.array(ends), none, kept, samples))
        if stride.samples is None:
            self.sampler.take(stride.start, end, stride.at)
        self.suspect(np.array([stride.end]), stride.state[None, :])

    def count_until(self, time: Any) -> int:
        """How many points of the grid a time is not before; of two that are one as doubles, one of
        many digits tells which is first."""
        return bisect_right(self.forward, self.order * time)

    def happenings(
        self, stride: Stride, events: Mapping[int, Guard]
    ) -> tuple[Stride, list[tuple[Any, Guard]]]:
        """A step up to the first switching surface in it, where its stages look beyond, and what
        happens in it: there other equations hold."""
        switching_surfaces = self.problem.switching_surfaces
        left = switching_surfaces if self.is_on_switching_surface else frozenset()
        known = self.last_look[1] if self.last_look[0] == stride.start else None
        seen = crossings(events, self.levels, stride.course(known), left)
        self.last_look, passages = (stride.end, seen.end), seen.passages
        self.log.touches += seen.touches
        # short first steps may leave a switching surface by less than rounding
        on = [
            abs(seen.end[i]) <= SPECK
            for i, event in events.items()
            if event.name in switching_surfaces
        ]
        self.is_on_switching_surface = self.is_on_switching_surface and any(on)
        switching_surface = next(
            (pair for pair in passages if pair[1].name in switching_surfaces), None
        )
        if (
            switching_surface is None
            or stride.up_to is None
            or switching_surface[0] == stride.start
        ):
            return stride, passages
        shorter = stride.up_to(switching_surface[0])
        others = {i: event for i, event in events.items() if event.name not in switching_surfaces}
        before = crossings(others, self.levels, shorter.course(known)).passages if others else []
        return shorter, [*before, switching_surface]

    def suspect(self, times: np.ndarray, states: np.ndarray, every: int = 1) -> None:
        """Have the mass matrices at times (k,) and states (k, n) looked at, before long: one of so
        many, and all where one of these is singular, or lies beyond one that is."""
        if self.problem.suspect is not None and len(states):
            self.recent.append((times, states, every))
            self.unseen += len(times)

    def pass_over(self, segment: Segment) -> None:
        """Enter steps in which nothing happens."""
        new = slice(self.done, self.done + len(segment.rows))
        self.states[new] = segment.rows
        self.suspect(self.grid[new], segment.rows)
        self.suspect(segment.times, segment.states, EVERY)
        self.done, self.steps = new.stop, self.steps + segment.steps
        self.idle = 0 if len(segment.rows) else self.idle + segment.steps
        self.strides += segment.strides
        if segment.samples is not None:
            self.sampler.rows.append(segment.samples)
        if self.problem.marked:
            self.ends += segment.times.tolist()
        self.last = Termination(COLLAPSE, segment.end, segment.state)

    def near(self, stride: Stride) -> np.ndarray:
        """Which coarse events (m,) may happen in a step, by their functions and the slopes at its
        ends.

        Between ends with values g0, g1 > 0 one is at least (g0 + g1 - V h)/2, V the fastest fall.
        """
        if stride.slopes is None or not self.problem.coarse:
            return np.ones(len(self.problem.events), dtype=bool)
        times = np.array([stride.start, stride.start, stride.end, stride.end])
        shift = TINY * (stride.end - stride.start)
        (first, before), (last, after) = stride.slopes
        states = np.stack([first, first + shift * before, last, last + shift * after])
        g = self.levels(times, states)
        with np.errstate(all="ignore"):
            rises = np.array([g[1] - g[0], g[3] - g[2]]) / TINY
            fastest = np.abs(rises).max(axis=0) + np.abs(rises[1] - rises[0])
            return ~((g[0] > 0) & (g[2] > 0)) | (g[0] + g[2] <= fastest)

    def singular(self) -> Termination | None:
        """The last state before one with a singular mass matrix, if there is one."""
        if not self.recent or self.problem.suspect is None:
            return None
        look, recent, (last, ends, _) = self.problem.suspect, self.recent, self.recent[-1]
        self.recent, self.unseen = [(last[-1:], ends[-1:], 1)], 1
        few = zip(*((t[::k], rows[::k]) for t, rows, k in recent), strict=True)
        if look(*(np.concatenate(part).astype(float) for part in few)) is None:
            return None
        times, states = (np.concatenate([each[i] for each in recent]) for i in (0, 1))
        turn = np.argsort(self.order * times, kind="stable")
        times, states = times[turn], states[turn]
        place = look(times.astype(float), states.astype(float))
        assert place is not None  # some of these were among the few
        time, state = times[max(place - 1, 0)], states[max(place - 1, 0)]
        reached = self.count_until(time)
        self.done = min(self.done, max(reached, 1))
        return Termination(SINGULAR, time, state, singular=True)

    def result(self, halt: Termination | None = None, interrupted: bool = False) -> Run:
        t, states = self.grid[: self.done].copy(), self.states[: self.done].copy()
        end = self.log.last if self.log.stopped else (self.last.time, self.last.state)
        kept = self.log.stopped or (interrupted and self.idle >= DISTANT)
        if kept and self.order * end[0] > self.order * t[-1]:
            t = np.append(t.astype(states.dtype), np.array([end[0]], states.dtype))
            states = np.vstack([states, end[1]])
        crossed = crossing_arrays(self.log.rows, self.problem.events, states.shape[1], states.dtype)
        if halt is not None:
            crossed = until(crossed, t[0], halt.time)
        return Run(
            t, states, self.steps, self.stepper.evaluations, crossed, halt, interrupted,
            self.log.stopped, self.inside if self.problem.dense else None, ends=tuple(self.ends),
            samples=StepSamples.of(self.sampler.rows), notes=self.log.notes,
        )  # fmt: skip

    def inside(self, times: np.ndarray) -> np.ndarray:
        """States at any times reached."""
        ends = [stride.end for stride in self.strides]
        parts = [stride.at for stride in self.strides]
        return in_parts(ends, self.order, parts, times, self.states)

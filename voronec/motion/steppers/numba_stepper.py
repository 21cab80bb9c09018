"""DOP853 and the program compiled together by numba: many steps without Python in between.

The compiled loop comes back where the grid ends, now and then to look at the keyboard, and after a
step within which an event may happen; that one is looked at as the steps of other integrators are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache, partial

import numpy as np

from voronec.equations.program import HoistedProgram, Program, hoist, scalar_source
from voronec.motion.steppers.dop853_source import (
    EVENT,
    FIRST_GROWTH,
    NO_STEP,
    kernel_source,
    stepping_key,
)
from voronec.motion.steppers.held_steps import Leap, LeapEnd
from voronec.motion.steppers.kept_code import kept_function
from voronec.motion.steppers.run import COLLAPSE, INFINITE, Integrator, Problem, Run
from voronec.motion.steppers.samples import NODES, burst
from voronec.motion.steppers.scipy_stepper import up_to
from voronec.motion.steppers.step_loop import (
    IntegratorFailure,
    Segment,
    Stride,
    level_function,
    march,
)
from voronec.motion.steppers.units import natural_units
from voronec.motion.tolerances import dop853_tolerance

CHUNK = 4_000
"""Steps between two looks at the keyboard; what more of them keep leaves the processor's cache."""
DENSE_CHUNK = 1_000
"""Steps between two looks at the keyboard where their dense output is kept."""
PARTS = 7
"""Coefficients of the dense output of a step."""
_LINE, _TABLE, _TABLES = "float64[::1]", "float64[:,::1]", "float64[:,:,::1]"
SIGNATURE = (
    f"int64({_LINE}, {_TABLE}, {_LINE}, int64[::1], {_TABLE}, {_TABLE}, {_TABLE}, {_TABLES}, "
    f"{_TABLES}, {_TABLE}, int64[::1], {_LINE}, {_LINE}, boolean, boolean, int64)"
)


def compiled_dop853(
    problem: Problem, loop: Callable[..., Callable[..., int]] | None = None
) -> Integrator:
    """The Runge-Kutta method of order eight of Dormand and Prince, compiled with the program: by
    ``loop``, or by numba, then ``ImportError`` without it.
    """
    drive = (loop or compiled_loop)(problem.program, problem.levels if problem.events else None)
    # of a short run these would take most of the time
    scales, raised = scales_of(problem), hoist(problem.program)

    def run(grid: np.ndarray) -> Run:
        loop = Loop.of(drive, problem, grid, scales, raised)
        with np.errstate(all="ignore"):
            return march(problem, grid, loop, level_function(problem))

    return run


@contextmanager
def dop853_leap(
    problem: Problem, loop: Callable[..., Callable[..., int]] | None = None
) -> Iterator[Leap]:
    """Steps of DOP853 from a state to an instant, with parameters of their own each time; compiled
    as ``compiled_dop853`` does."""
    drive = (loop or compiled_loop)(problem.program, None)
    scales, raised = scales_of(problem), hoist(problem.program)

    def leap(
        time: float, state: np.ndarray, end: float, given: Sequence[float], wanted: bool
    ) -> LeapEnd:
        problem.start[:] = state
        steps = Loop.of(drive, problem, np.array([time, end]), scales, raised)
        samples = None
        while steps.clock[0] != end:
            segment = steps.advance()
            assert isinstance(segment, Segment)
            samples = segment.samples
        if not np.isfinite(segment.state).all():
            raise IntegratorFailure(INFINITE)
        return LeapEnd(
            segment.state, int(steps.counts[1]), steps.evaluations, samples if wanted else None
        )

    yield leap


def scales_of(problem: Problem) -> np.ndarray:
    """Absolute and relative tolerances of the states (2, n)."""
    finest, held = dop853_tolerance(problem.tol), problem.program.derivative.symbols
    # nothing depends on a quadrature: its size loosens no tolerance
    relative = [finest if s in held else 0.0 for s in problem.program.state]
    return np.array([finest * natural_units(problem), relative])


def between(begin: np.ndarray, bend: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Dense output at the parts x (k, 1) of steps, from their starts (k, n) and what they keep
    (7, k, n), or at parts of one, (n,) and (7, n)."""
    change = np.zeros(())
    for i, part in enumerate(bend[::-1]):
        change = (change + part) * (x if i % 2 == 0 else 1 - x)
    return np.asarray(change + begin)


AT_NODES = np.stack(
    [between(np.zeros(1), row[:, None], NODES[:, None])[:, 0] for row in np.eye(PARTS)], axis=1
)
"""From what steps keep to what the dense output adds to their starts at the nodes of samples."""


@lru_cache(maxsize=32)  # loaded code stays in memory, and to read it takes longer than most runs
def compiled_loop(program: Program, levels: Program | None = None) -> Callable[..., int]:
    """The function ``drive`` of a program, and of functions of events."""
    parts = [scalar_source(hoist(program).program), stepping_key()]
    parts += [scalar_source(levels, extras=True)] if levels is not None else []
    parts.append(str(len(program.state)))
    key = "\n".join(parts)
    return kept_function("drive", SIGNATURE, key, lambda: kernel_source(program, levels))


@dataclass
class Loop:
    """The compiled loop under way.

    clock
        the time, the length of the next step, when the last one began, and by what it could grow.
    counts
        points of the grid that are done, steps, evaluations, whether the last trial was rejected,
        and steps that are kept.
    states (5, n)
        the state and what is to be added to it beyond its digits, its rate; state and rate at the
        start of the last step.
    bend (7, n)
        the dense output of the last step.
    times (k, 2), ends (k, 2, n), bends (k, 7, n)
        of kept steps: when and where they begin and end, and their dense output.
    scales (2, n)
        absolute and relative tolerances.
    """

    drive: Callable[..., int]
    problem: Problem
    grid: np.ndarray
    rows: np.ndarray
    clock: np.ndarray
    counts: np.ndarray
    states: np.ndarray
    bend: np.ndarray
    scales: np.ndarray
    fixed: tuple[np.ndarray, np.ndarray, np.ndarray]
    happening: bool = field(default=False)

    @classmethod
    def of(
        cls, drive: Callable[..., int], problem: Problem, grid: np.ndarray, scales: np.ndarray,
        raised: HoistedProgram,
    ) -> Loop:  # fmt: skip
        """At the start of a problem, whatever went before, with the tolerances ``scales_of`` it and
        its program ``raised``."""
        n, given = len(problem.start), [float(x) for x in problem.parameters]
        states = np.zeros((5, n))
        states[0] = problem.start
        coarse = np.array([e.name in problem.coarse for e in problem.events], dtype=np.int64)
        known, grid = raised.values(given), np.ascontiguousarray(grid, dtype=float)
        return cls(
            drive, problem, grid, np.empty((len(grid), n)),
            np.array([float(grid[0]), 0.0, float(grid[0]), FIRST_GROWTH]),
            np.array([1, 0, 0, 0, 0]), states, np.zeros((PARTS, n)), scales,
            (coarse, np.array(known), np.array(given)),
        )  # fmt: skip

    def advance(self) -> Stride | Segment:
        """The next step, where an event may happen in it, or many others."""
        if self.happening:
            self.happening = False
            return self.stride(self.clock[[2, 0]], self.states[[3, 0]], self.bend.copy())
        problem, n = self.problem, len(self.problem.start)
        ahead, sampled = burst(int(self.counts[1]))
        limit, dense = min(CHUNK, ahead), problem.dense or sampled
        keep = dense or problem.marked or problem.suspect is not None
        bent = min(limit, DENSE_CHUNK) if dense else 1
        room = bent if dense else limit if keep else 1
        times, ends, bends = np.empty((room, 2)), np.empty((room, 2, n)), np.empty((bent, PARTS, n))
        order = np.sign(self.grid[-1] - self.grid[0])
        done = int(np.searchsorted(order * self.grid, order * self.clock[0], side="right"))
        self.counts[0] = done = max(done, 1)
        steps = int(self.counts[1])
        outcome = self.drive(
            self.grid, self.rows, self.clock, self.counts, self.states, self.bend, times, ends,
            bends, self.scales, *self.fixed, dense, keep, limit,
        )  # fmt: skip
        self.happening = outcome == EVENT
        kept, taken = int(self.counts[4]), int(self.counts[1]) - steps - self.happening
        if outcome == NO_STEP and not taken:
            raise IntegratorFailure(COLLAPSE)
        when, where = (2, 3) if self.happening else (0, 0)  # it ends before what may happen
        return Segment(
            taken, self.rows[done : int(self.counts[0])], float(self.clock[when]),
            self.states[where].copy(), times[:kept, 1], ends[:kept, 1],
            [self.stride(times[i], ends[i], bends[i]) for i in range(kept if problem.dense else 0)],
            _samples(times[:kept], ends[:kept], bends[:kept]) if sampled and kept else None,
        )  # fmt: skip

    def stride(self, times: np.ndarray, ends: np.ndarray, bend: np.ndarray) -> Stride:
        """A step from its ends (2,), (2, n) and its dense output."""
        start, begin = float(times[0]), ends[0]
        length = float(times[1]) - start

        def at(moments: np.ndarray) -> np.ndarray:
            return between(begin, bend, ((moments - start) / length)[:, None])

        shorter = partial(up_to, self.problem, start, begin.copy())
        return Stride(start, float(times[1]), ends[1], at, up_to=shorter)

    @property
    def evaluations(self) -> int:
        """How often the right-hand side was evaluated so far."""
        return int(self.counts[2])


def _samples(
    times: np.ndarray, ends: np.ndarray, bends: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Samples of steps, from their ends (k, 2), (k, 2, n) and their dense output (k, 7, n)."""
    start, length = times[:, :1], np.diff(times)
    states = ends[:, :1] + AT_NODES @ bends
    states[:, -1] = ends[:, 1]
    return start + length * NODES, states

"""Steps between the instants at which sampled controllers are asked, many of them at a time.

A ``Leap`` takes a state from one instant to the next, with the values that are held there: as
``knots`` does piece by piece, where nobody looks for events and nobody asks for what lies between.
Each ends at an instant exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from voronec.motion.steppers.feedback import ControllerFailure
from voronec.motion.steppers.run import Integrator, Problem, Run
from voronec.motion.steppers.samples import spread
from voronec.motion.steppers.step_loop import (
    IntegratorFailure,
    Segment,
    level_function,
    march,
)

TOGETHER = 256
"""Instants between two looks at progress and at the keyboard."""
MOST_SAMPLES = 64
"""Leaps of which a step is kept for the check of the run."""


class LeapEnd(NamedTuple):
    """A state (n,) after some steps, and samples of one of them, where they were asked for."""

    state: np.ndarray
    steps: int
    evaluations: int
    samples: tuple[np.ndarray, np.ndarray] | None


Leap = Callable[[float, np.ndarray, float, Sequence[float], bool], LeapEnd]
"""From a time and a state (n,) to another time, with values of the parameters, and whether samples
are wanted."""


def held_integrator(
    leaps: Callable[[Problem], AbstractContextManager[Leap]], problem: Problem
) -> Integrator:
    """The integrator of a problem with sampled controllers."""

    def run(grid: np.ndarray) -> Run:
        fresh = replace(problem, start=problem.start.copy(), parameters=list(problem.parameters))
        with leaps(fresh) as leap, np.errstate(all="ignore"):
            return march(fresh, grid, _HeldSteps(fresh, grid, leap), level_function(fresh))

    return run


@dataclass
class _HeldSteps:
    """The ``leap`` under way: at a ``time`` and in a ``state`` (n,)."""

    problem: Problem
    grid: np.ndarray
    leap: Leap
    evaluations: int = 0
    done: int = 0
    failure: Exception | None = None
    time: float = field(init=False)
    state: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        changing, grid = self.problem.changing, self.grid
        assert changing is not None
        self.signals, self.told = changing, self.problem.state_view()
        self.feedbacks = changing.feedbacks
        self.time, self.state = float(grid[0]), self.problem.start.copy()
        knots = changing.knots(float(grid[0]), float(grid[-1]))
        self.stops = np.union1d(grid[1:], knots)
        self.is_point = np.isin(self.stops, grid).tolist()
        self.is_knot = [True, *np.isin(self.stops, knots).tolist()]
        self.sampled = {*spread(len(self.stops), MOST_SAMPLES).tolist()}
        names = [*map(str, self.problem.program.parameters)]
        self.places = [names.index(n) if n in names else None for n in changing.order]
        for feedback in self.feedbacks:
            feedback.values.clear()

    def advance(self) -> Segment:
        """The leaps to the next instants; what fails on the way is told after these."""
        if self.failure is not None:
            raise self.failure
        first, steps = self.done, 0
        rows, states, samples = [], [], []
        for k in range(first, min(first + TOGETHER, len(self.stops))):
            stop = float(self.stops[k])
            try:
                if self.is_knot[k]:
                    self.change(stop)
                given = self.problem.parameters
                landing = self.leap(self.time, self.state, stop, given, k in self.sampled)
            except (ControllerFailure, IntegratorFailure) as failure:
                self.failure = failure
                break
            self.time, self.state, self.done = stop, landing.state, k + 1
            steps, self.evaluations = steps + landing.steps, self.evaluations + landing.evaluations
            states.append(landing.state)
            if self.is_point[k]:
                rows.append(landing.state)
            if landing.samples is not None:
                samples.append(landing.samples)
        if self.failure is not None and not states:
            raise self.failure
        width = len(self.state)
        times, whole = self.stops[first : self.done], np.array(states)
        return Segment(
            steps, np.array(rows).reshape(-1, width), self.time, self.state, times, whole, (),
            (np.concatenate([t for t, _ in samples]), np.concatenate([x for _, x in samples]))
            if samples else None,
        )  # fmt: skip

    def change(self, ahead: float) -> None:
        """Ask the controllers that are due, and put what is held until the next instant among the
        parameters."""
        given, held = self.problem.parameters, self.signals.on
        assert isinstance(given, list)
        for feedback in self.feedbacks:
            feedback.sample(self.time, lambda: self.told(self.time, self.state.tolist(), given))
        for place, value in zip(self.places, held(self.time, ahead).values(), strict=True):
            if place is not None:
                given[place] = float(value)

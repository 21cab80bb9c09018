"""The stepper that goes through the charts of a system, one stretch after another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.equations import VoronecEquations
from voronec.flow.atlas import HOME, LEAVE, RETURN, Atlas, Place
from voronec.flow.charts import kept_charts
from voronec.flow.steppers import Halt, Problem, Run, Stepper, choose, guarded
from voronec.flow.steppers.choice import EXACT

if TYPE_CHECKING:
    from voronec.derivation import FirstOrderForm

__all__ = ["through_charts"]

SAMPLES, REACH = 8, 32.0
"""In other charts angles are followed at so many points in a unit of the time scale there; and no
stretch is longer than so many units."""


def through_charts(
    method: str,
    problem: Problem,
    grid: np.ndarray,
    equations: VoronecEquations,
    functions: Mapping[str, Any],
    form: FirstOrderForm | None = None,
) -> tuple[Stepper, dict[str, Any]]:
    """The integrator of a problem, and what ``Cost`` says of it, as ``choose`` gives them.

    Near a singularity of the system's own chart it goes on in another.  ``functions`` are those of
    the problem's events, by name, inside the door; ``form`` are the equations that the problem's
    program is made of, by default those of the system.  Where no chart of the system maps the
    variables of the form among themselves, this is what ``choose`` gives.  So it is in high
    precision: the maps are made for doubles, and there steps may be as short as they like.
    """
    form = form or equations.form
    exact = method == "flint" or (method == "auto" and problem.tol < EXACT)
    charts = () if exact else kept_charts(equations, form)
    if not charts:
        stepper, chosen = choose(method, problem, grid)
        return lambda times: guarded(stepper(times), problem), chosen
    atlas = Atlas(method, problem, grid, form, charts, functions)
    own = atlas.place(HOME)
    return lambda times: _Journey(atlas, times).run(), dict(own.chosen)


@dataclass(frozen=True)
class _Stretch:
    """States of the own chart along a part of the way, on the right branches of angles.

    ``inside`` gives states at any times of the part, of dense runs, on any branches.
    """

    times: np.ndarray
    rows: np.ndarray
    angles: np.ndarray
    inside: Callable[[np.ndarray], np.ndarray] | None

    def branched(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """States at times of this part with angles next to those known before them."""
        order = 1.0 if self.times[-1] >= self.times[0] else -1.0
        before = np.searchsorted(order * self.times, order * times, side="right") - 1
        near = self.rows[np.clip(before, 0, len(self.rows) - 1)]
        return np.where(self.angles, states - _turns(states - near), states)


@dataclass
class _Journey:
    """One run: where it is, and what it has seen."""

    atlas: Atlas
    grid: np.ndarray
    done: int = 1
    steps: int = 0
    evaluations: int = 0
    switches: int = 0
    ready: int = 0
    last: np.ndarray = field(init=False)
    standing: tuple[Any, np.ndarray] = field(init=False)
    rows: list[np.ndarray] = field(init=False)
    crossings: dict[str, list[tuple[np.ndarray, np.ndarray]]] = field(default_factory=dict)
    stretches: list[_Stretch] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.last = self.atlas.problem.start
        self.standing = self.grid[0], self.last
        self.rows = [self.last[None, :]]
        self.order = 1.0 if self.grid[-1] >= self.grid[0] else -1.0

    def run(self) -> Run:
        time, self.ready = self.grid[0], len(self.atlas.seconds)
        try:
            name, state = self.atlas.best(time, self.last)
            while self.done < len(self.grid):
                part = self.stretch(name, time, state)
                halt = part.halt and Halt(
                    part.halt.reason, part.halt.time, self.homeward(name, part.halt)
                )
                if part.halt or part.interrupted or part.stopped not in ("", LEAVE, RETURN):
                    return self.result(halt, part.interrupted, part.stopped)
                time, state, before = part.t[-1], part.states[-1], name
                if part.stopped == RETURN:
                    name, state = HOME, self.last
                elif part.stopped == LEAVE:
                    name, there = self.atlas.best(time, self.last)
                    state = state if name == before else there
                self.switches += name != before
        except KeyboardInterrupt:
            return self.result(interrupted=True)
        return self.result()

    def homeward(self, name: str, halt: Halt) -> np.ndarray:
        """The state of a halt in the own chart."""
        rows = self.atlas.place(name).home(np.array([halt.time]), halt.state[None, :])
        return rows[0]

    def stretch(self, name: str, time: Any, state: np.ndarray) -> Run:
        """Go on in a chart until it ends, or the grid does."""
        place = self.atlas.place(name)
        times = np.concatenate([[time], self.grid[self.done :]])
        if name != HOME:
            times = self.finer(times, place.scale(time, state))
        if self.atlas.progress is not None:
            whole = self.grid[-1] - self.grid[0]
            self.atlas.progress.done = float((time - self.grid[0]) / whole)
            self.atlas.progress.part = float((times[-1] - time) / whole)
        part = place.run(state, times)
        self.steps += part.steps
        self.evaluations += part.evaluations
        self.take(place, part)
        return part

    def finer(self, times: np.ndarray, scale: float) -> np.ndarray:
        """Times of a stretch in another chart, close enough to follow the angles."""
        length = min(abs(times[-1] - times[0]), REACH * scale)
        until = times[0] + self.order * length
        if length == abs(times[-1] - times[0]):
            until = times[-1]
        fine = np.linspace(times[0], until, int(SAMPLES * length / scale) + 2)
        kept = times[self.order * times <= self.order * until]
        return np.unique(np.concatenate([kept, fine]))[:: int(self.order)]

    def take(self, place: Place, part: Run) -> None:
        """Enter a stretch: points of the grid, crossings, dense output."""
        angles, own = self.atlas.angles, place.name == HOME
        times, rows = part.t, part.states
        if not own:
            rows = followed(place.home(times, rows), self.last, angles)
        inside = part.inside
        home = None if inside is None else lambda t: place.home(t, inside(t))
        stretch = _Stretch(times, rows, angles, home)
        ahead = self.order * self.grid[self.done :]
        count = int(np.searchsorted(ahead, self.order * times[-1], side="right"))
        self.rows.append(rows[np.searchsorted(self.order * times, ahead[:count])])
        self.done += count
        self.last = rows[-1]
        self.standing = times[-1], self.last
        for event in self.atlas.problem.events:
            t, states = part.crossings[event.name]
            found = states if own else stretch.branched(t, place.home(t, states))
            self.crossings.setdefault(event.name, []).append((t, found))
        if self.atlas.problem.dense:
            self.stretches.append(stretch)

    def result(
        self,
        halt: Halt | None = None,
        interrupted: bool = False,
        stopped: str = "",
    ) -> Run:
        t, states = self.grid[: self.done], np.vstack(self.rows)[: self.done]
        end, state = self.standing
        if (stopped or interrupted) and self.order * end > self.order * t[-1]:
            t, states = np.append(t, end), np.vstack([states, state])
        width = states.shape[1]
        crossings = {
            e.name: (
                np.concatenate([t for t, _ in self.crossings.get(e.name, [])] or [np.empty(0)]),
                np.vstack([s for _, s in self.crossings.get(e.name, [])] or [np.empty((0, width))]),
            )
            for e in self.atlas.problem.events
        }
        return Run(
            t.copy(), states, self.steps, self.evaluations, crossings, halt, interrupted, stopped,
            self.inside if self.atlas.problem.dense else None, switches=self.switches,
            prepared=sum(self.atlas.seconds[self.ready :]),
        )  # fmt: skip

    def inside(self, times: np.ndarray) -> np.ndarray:
        """States at any times reached."""
        ends = np.array([float(self.order * s.times[-1]) for s in self.stretches])
        which = np.searchsorted(ends, self.order * times, side="left")
        which = np.minimum(which, len(ends) - 1)
        found = np.empty((len(times), len(self.last)))
        for i in np.unique(which):
            part, here = self.stretches[i], which == i
            if part.inside is not None:
                found[here] = part.branched(times[here], part.inside(times[here]))
        return found


def followed(rows: np.ndarray, before: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Rows (k, n), each angle on the branch nearest to the row above; ``before`` is the first."""
    steps = np.diff(np.vstack([before, rows]), axis=0)
    return np.where(angles, rows - np.cumsum(_turns(steps), axis=0), rows)


def _turns(steps: np.ndarray) -> np.ndarray:
    """The whole turns in steps."""
    return 2 * np.pi * np.rint(steps / (2 * np.pi))

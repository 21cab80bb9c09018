"""The stepper that goes through the charts of a system, one stretch after another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.equations.voronec_equations import VoronecEquations
from voronec.motion.atlas import (
    APART,
    HOME,
    LEAVE,
    RETURN,
    SIDE,
    Atlas,
    ChartProblem,
    Home,
    kept_charts,
    whole_turns,
)
from voronec.motion.methods import choose_regular, is_exact
from voronec.motion.singular_coordinates import passage_notes
from voronec.motion.steppers import Integrator, Problem, Run, Termination
from voronec.motion.steppers.run import DISTANT, crossing_arrays, part_at
from voronec.motion.steppers.samples import StepSamples

if TYPE_CHECKING:
    from voronec.equations.derivation import FirstOrderForm

__all__ = ["through_charts"]

TOUCH = 1e-12
"""So near to a singularity, doubles do not tell on which side of it a motion passes."""
SOON = 1e-7
"""A motion that sets out from a singularity is looked at after this part of its span."""


def through_charts(
    method: str,
    problem: Problem,
    grid: np.ndarray,
    equations: VoronecEquations,
    functions: Mapping[str, Any],
    form: FirstOrderForm | None = None,
) -> tuple[Integrator, dict[str, Any]]:
    """The integrator of a problem, and what ``Cost`` says of it, as ``choose`` gives them.

    Near a singularity of the system's own chart it goes on in another.  ``functions`` are those of
    the problem's events, by name, in the engine's symbols; ``form`` are the equations that the
    problem's program is made of, by default those of the system.  Where no chart of the system maps
    the variables of the form among themselves, this is what ``choose`` gives.  So it is in high
    precision: the maps are made for doubles, and there steps may be as short as they like.
    """
    form = form or equations.form
    charts = () if is_exact(method, problem.tol) else kept_charts(equations, form)
    if not charts:
        return choose_regular(method, problem, grid)
    atlas = Atlas(method, problem, grid, form, charts, functions)
    own = atlas.place(HOME)
    return lambda times: _Journey(atlas, times).run(), dict(own.chosen)


@dataclass(frozen=True)
class _ChartSegment:
    """States of the own chart along a part of the way, on the right branches of angles.

    ``inside`` gives states at any times of the part, of dense runs, on any branches.
    """

    times: np.ndarray
    rows: np.ndarray
    angles: np.ndarray
    inside: Callable[[np.ndarray], np.ndarray] | None

    def on_branches(self, times: np.ndarray, states: np.ndarray) -> np.ndarray:
        """States at times of this part with angles next to those known before them."""
        order = 1.0 if self.times[-1] >= self.times[0] else -1.0
        before = np.searchsorted(order * self.times, order * times, side="right") - 1
        near = self.rows[np.clip(before, 0, len(self.rows) - 1)]
        return np.where(self.angles, states - whole_turns(states - near), states)


@dataclass
class _Journey:
    """One run: where it is, and what it has seen."""

    atlas: Atlas
    grid: np.ndarray
    done: int = 1
    steps: int = 0
    evaluations: int = 0
    switches: int = 0
    earlier: int = 0
    idle: float = 0.0
    last: np.ndarray = field(init=False)
    standing: tuple[Any, np.ndarray] = field(init=False)
    rows: list[np.ndarray] = field(init=False)
    crossings: dict[str, list[tuple[Any, np.ndarray]]] = field(default_factory=dict)
    segments: list[_ChartSegment] = field(default_factory=list)
    touched: list[float] = field(default_factory=list)
    still: list[str] = field(default_factory=list)
    samples: list[StepSamples] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.last = self.atlas.problem.start
        self.standing = self.grid[0], self.last
        self.rows = [self.last[None, :]]
        self.order = 1.0 if self.grid[-1] >= self.grid[0] else -1.0

    def run(self) -> Run:
        time, self.earlier = self.grid[0], len(self.atlas.seconds)
        try:
            name, state = self.atlas.best(time, self.last)
            while self.done < len(self.grid):
                part = self.segment(name, time, state)
                halt = part.halt and Termination(
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

    def homeward(self, name: str, halt: Termination) -> np.ndarray:
        """The state of a halt in the own chart."""
        rows = self.atlas.place(name).home(np.array([halt.time]), halt.state[None, :])
        return rows[0]

    def segment(self, name: str, time: Any, state: np.ndarray) -> Run:
        """Go on in a chart until it ends, or the grid does."""
        place = self.atlas.place(name, None if name == HOME else state)
        times = np.concatenate([[time], self.grid[self.done :]])
        if name != HOME and self.atlas.distances(times[:1], self.last[None, :])[0] < APART:
            soon = time + SOON * (self.grid[-1] - self.grid[0])
            if self.order * soon < self.order * times[1]:  # else the next instant is soon enough
                times = np.insert(times, 1, soon)
        if self.atlas.progress is not None:
            whole = self.grid[-1] - self.grid[0]
            self.atlas.progress.done = float((time - self.grid[0]) / whole)
            self.atlas.progress.part = float((times[-1] - time) / whole)
        part = place.run(state, times)
        self.steps += part.steps
        self.evaluations += part.evaluations
        self.take(place, part)
        return part

    def take(self, place: ChartProblem, part: Run) -> None:
        """Enter a stretch: points of the grid, crossings, dense output."""
        angles, own = self.atlas.angles, place.name == HOME
        times, rows = part.t, part.states
        home = place.home
        if not own:
            times, rows = self.with_sides(part)
            home = self.on_this_side(place, times[0], rows[0])
            rows = self.beside_pole(place, times, home(times, rows))
            rows[0] = self.last
            rows = follow_angles(rows, self.last, angles)
            self.look(times, rows)
        inside = part.inside
        sampled = None if inside is None else lambda t: home(t, inside(t))
        # in the own chart angles are on their branches as they are
        segment = _ChartSegment(times, rows, angles & (not own), sampled)
        self.samples += [
            replace(sample.through(lambda t, x: segment.on_branches(t, home(t, x))), apart=not own)
            for sample in part.samples
        ]
        ahead = self.order * self.grid[self.done :]
        count = int(np.searchsorted(ahead, self.order * times[-1], side="right"))
        self.rows.append(rows[np.searchsorted(self.order * times, ahead[:count])])
        self.done += count
        self.last = rows[-1]
        self.standing = times[-1], self.last
        left = abs(times[-1] - (self.grid[self.done - 1] if count else times[0]))
        share = left / abs(times[-1] - times[0]) if len(times) > 1 else 0.0
        self.idle = (0.0 if count else self.idle) + share * part.steps
        for event in self.atlas.problem.events:
            t, states = part.crossings[event.name]
            found = segment.on_branches(t, home(t, states))
            self.crossings.setdefault(event.name, []).extend(zip(t, found, strict=True))
        if self.atlas.problem.dense:
            self.segments.append(segment)

    def on_this_side(self, place: ChartProblem, time: Any, state: np.ndarray) -> Home:
        """The way home from a chart; of coordinates that give states twice, on the side on which
        the run has been.  On a pole that is told by all coordinates but those that are free there.
        """
        here, now, without_turns = np.array([time]), state[None, :], self.atlas.without_turns
        polar = self.atlas.distances(here, self.last[None, :])[0] < APART
        blind = self.atlas.blind(place.name, time, self.last) if polar else ()
        seen = len(self.atlas.form.coordinates) if polar else len(state)

        def off(way: Home) -> float:
            gap = without_turns(way(here, now)[0] - self.last)
            for free in filter(np.any, blind):
                which = int(np.argmax(np.abs(free)))
                gap = without_turns(gap - gap[which] / free[which] * free)
            gaps = np.abs(gap[:seen])  # of ways as near, the first
            if not polar:
                return round(float(gaps.max()), 6)
            # the side of a pole is told by a coordinate that is next to nothing, beside large ones
            return round(float((gaps / (1 + np.abs(self.last[:seen]))).sum()), 12)

        return min(place.ways_home, key=off)

    def beside_pole(self, place: ChartProblem, times: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """States at home, where a stretch sets out from a pole, or stays there, as if it had come
        there as it leaves: there one angle of two is free, and stays as it was."""
        begin = self.last[None, :]
        if self.atlas.distances(times[:1], begin)[0] >= APART:
            return rows
        self.still += self.atlas.idle(place.name, times[0], self.last)
        there = self.atlas.distances(times, rows) < TOUCH
        there[0] = True
        left = np.flatnonzero(~there)
        for free in self.atlas.blind(place.name, times[0], self.last):
            if not free.any():
                continue
            which = int(np.argmax(np.abs(free)))
            gap = (self.last[which] - rows[:, which]) / free[which]
            rows = np.where(there[:, None], rows + gap[:, None] * free, rows)
            if len(left):
                ahead = self.atlas.without_turns(rows[left[0]] - self.last)[which] / free[which]
                self.last = np.where(self.atlas.angles, self.last + ahead * free, self.last)
        return rows

    def with_sides(self, part: Run) -> tuple[np.ndarray, np.ndarray]:
        """Times and states of a stretch, with all instants at which an angle of the own chart
        comes from one quadrant into another: between two of them it stays within a right angle."""
        found = [rows for name, rows in part.crossings.items() if name.startswith(SIDE)]
        inner = [(t, states) for t, states in found if len(t)]
        times = np.concatenate([part.t, *(t for t, _ in inner)])
        states = np.vstack([part.states, *(states for _, states in inner)])
        order = self.order * times
        _, first = np.unique(order, return_index=True)
        kept = first[order[first] <= order[len(part.t) - 1]]
        return times[kept], states[kept]

    def look(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Note where a stretch passes through a singularity of the own chart, not where it sets
        out from one."""
        there = self.atlas.distances_apart(times, rows) < TOUCH
        begins = there[:, 1:] & ~there[:, :-1]
        self.touched += times[1:][begins.any(axis=0)].tolist()

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be said of the run."""
        said = tuple(
            f"the motion starts where the coordinates are singular: '{name}' has no meaning there, "
            "and the value given no effect"
            for name in self.still
        )
        return (*said, *passage_notes(self.touched))

    def result(
        self, halt: Termination | None = None, interrupted: bool = False, stopped: str = ""
    ) -> Run:
        t, states = self.grid[: self.done], np.vstack(self.rows)[: self.done]
        end, state = self.standing
        kept = stopped or (interrupted and self.idle >= DISTANT)
        if kept and self.order * end > self.order * t[-1]:
            t, states = np.append(t, end), np.vstack([states, state])
        events, width = self.atlas.problem.events, states.shape[1]
        crossings = crossing_arrays(self.crossings, events, width, float)
        return Run(
            t.copy(), states, self.steps, self.evaluations, crossings, halt, interrupted, stopped,
            self.inside if self.atlas.problem.dense else None, switches=self.switches,
            prepared=sum(self.atlas.seconds[self.earlier :]), notes=self.notes,
            samples=tuple(self.samples),
        )  # fmt: skip

    def inside(self, times: np.ndarray) -> np.ndarray:
        """States at any times reached."""
        which = part_at([s.times[-1] for s in self.segments], self.order, times)
        found = np.empty((len(times), len(self.last)))
        for i in np.unique(which):
            part, here = self.segments[i], which == i
            if part.inside is not None:
                found[here] = part.on_branches(times[here], part.inside(times[here]))
        return found


def follow_angles(rows: np.ndarray, before: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Rows (k, n), each angle on the branch nearest to the row above; ``before`` is the first."""
    steps = np.diff(np.vstack([before, rows]), axis=0)
    return np.where(angles, rows - np.cumsum(whole_turns(steps), axis=0), rows)

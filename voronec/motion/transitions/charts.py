"""From one chart of a system to another."""

from __future__ import annotations

from collections.abc import Mapping
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
from voronec.motion.methods import choose, is_exact
from voronec.motion.singular_coordinates import passage_notes
from voronec.motion.solve import Arrival, Phase, Solver
from voronec.motion.steppers import Integrator, Problem, Run

if TYPE_CHECKING:
    from voronec.equations.derivation import FirstOrderForm

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
        return choose(method, problem, grid)
    atlas = Atlas(method, problem, grid, form, charts, functions)
    place = atlas.place(HOME)
    return lambda times: _Charts(atlas, times).run(), dict(place.chosen)


@dataclass
class _Charts:
    """The change from one chart to another where the one becomes singular, or the own one is
    regular again; ``what`` of a phase is the name of its chart."""

    atlas: Atlas
    grid: np.ndarray
    touched: list[float] = field(default_factory=list)
    still: list[str] = field(default_factory=list)

    def run(self) -> Run:
        """The run on the grid."""
        problem, start = self.atlas.problem, self.atlas.problem.start
        solver = Solver(self.grid, problem.events, problem.dense, self.atlas.progress)
        name, state = self.atlas.best(self.grid[0], start)
        run = solver.run(self.phase(name, self.grid[0], state, start))
        return replace(run, notes=(*run.notes, *self.notes))

    def next(self, phase: Phase, here: Arrival) -> Phase:
        """The chart that is farthest from being singular; the own one as soon as it may be."""
        name, state = HOME, here.home
        if here.guard == LEAVE:
            name, there = self.atlas.best(here.time, here.home)
            state = here.state if name == phase.what else there
        return self.phase(name, here.time, state, here.home, name != phase.what)

    def phase(
        self, name: str, time: Any, state: np.ndarray, home: np.ndarray, is_change: bool = True
    ) -> Phase:
        """The motion in a chart from a state on, which is a state at home."""

        def integrate(state: np.ndarray, times: np.ndarray) -> Run:
            made = len(self.atlas.seconds)
            place = self.atlas.place(name, None if name == HOME else state)
            if name != HOME and self.atlas.distances(times[:1], home[None, :])[0] < APART:
                soon = times[0] + SOON * (self.grid[-1] - self.grid[0])
                # else the next instant is soon enough
                if ((times[1:2] - soon) * (soon - times[0]) > 0).any():
                    times = np.insert(times, 1, soon)
            run = place.run(state, times)
            return replace(run, prepared=run.prepared + sum(self.atlas.seconds[made:]))

        def to_home(run: Run) -> Run:
            return run if name == HOME else self.homeward(self.atlas.place(name), run, home)

        ends = dict.fromkeys((LEAVE, RETURN), self)
        return Phase(name, time, state, home, integrate, ends, to_home, is_change=is_change)

    def homeward(self, place: ChartProblem, run: Run, begin: np.ndarray) -> Run:
        """A run of another chart in the own one, from a state ``begin`` there on, with all instants
        at which an angle comes from one quadrant into another, and on the right branches."""
        angles, inside, halt = self.atlas.angles, run.inside, run.halt
        crossings = [(e.name, run.crossings[e.name]) for e in self.atlas.problem.events]
        times, states = self.with_sides(run)
        home = self.on_this_side(place, times[0], states[0], begin)
        rows, begin = self.beside_pole(place, times, home(times, states), begin)
        rows[0] = begin
        rows = follow_angles(rows, begin, angles)
        self.look(times, rows)
        order = 1.0 if times[-1] >= times[0] else -1.0

        def back(t: np.ndarray, states: np.ndarray) -> np.ndarray:
            """Angles are next to those known before them."""
            mapped = home(t, states)
            before = np.searchsorted(order * times, order * t, side="right") - 1
            near = rows[np.clip(before, 0, len(rows) - 1)]
            return np.where(angles, mapped - whole_turns(mapped - near), mapped)

        return replace(
            run, t=times, states=rows,
            crossings={name: (t, back(t, x)) for name, (t, x) in crossings},
            halt=halt and replace(halt, state=back(np.array([halt.time]), halt.state[None])[0]),
            inside=None if inside is None else lambda t: back(t, inside(t)),
            samples=tuple(replace(sample.through(back), apart=True) for sample in run.samples),
        )  # fmt: skip

    def on_this_side(
        self, place: ChartProblem, time: Any, state: np.ndarray, last: np.ndarray
    ) -> Home:
        """The way home from a chart; of coordinates that give states twice, on the side on which
        the run has been.  On a pole that is told by all coordinates but those that are free there.
        """
        here, now, without_turns = np.array([time]), state[None, :], self.atlas.without_turns
        polar = self.atlas.distances(here, last[None, :])[0] < APART
        blind = self.atlas.blind(place.name, time, last) if polar else ()
        seen = len(self.atlas.form.coordinates) if polar else len(state)

        def off(way: Home) -> float:
            gap = without_turns(way(here, now)[0] - last)
            for free in filter(np.any, blind):
                which = int(np.argmax(np.abs(free)))
                gap = without_turns(gap - gap[which] / free[which] * free)
            gaps = np.abs(gap[:seen])  # of ways as near, the first
            if not polar:
                return round(float(gaps.max()), 6)
            # the side of a pole is told by a coordinate that is next to nothing, beside large ones
            return round(float((gaps / (1 + np.abs(last[:seen]))).sum()), 12)

        return min(place.ways_home, key=off)

    def beside_pole(
        self, place: ChartProblem, times: np.ndarray, rows: np.ndarray, last: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """States at home, and that with which they begin, where a stretch sets out from a pole, or
        stays there, as if it had come there as it leaves: there one angle of two is free, and stays
        as it was."""
        if self.atlas.distances(times[:1], last[None, :])[0] >= APART:
            return rows, last
        self.still += self.atlas.idle(place.name, times[0], last)
        there = self.atlas.distances(times, rows) < TOUCH
        there[0] = True
        left = np.flatnonzero(~there)
        for free in self.atlas.blind(place.name, times[0], last):
            if not free.any():
                continue
            which = int(np.argmax(np.abs(free)))
            gap = (last[which] - rows[:, which]) / free[which]
            rows = np.where(there[:, None], rows + gap[:, None] * free, rows)
            if len(left):
                ahead = self.atlas.without_turns(rows[left[0]] - last)[which] / free[which]
                last = np.where(self.atlas.angles, last + ahead * free, last)
        return rows, last

    def with_sides(self, part: Run) -> tuple[np.ndarray, np.ndarray]:
        """Times and states of a stretch, with all instants at which an angle of the own chart
        comes from one quadrant into another: between two of them it stays within a right angle."""
        crossings = [rows for name, rows in part.crossings.items() if name.startswith(SIDE)]
        inner = [(t, states) for t, states in crossings if len(t)]
        times = np.concatenate([part.t, *(t for t, _ in inner)])
        states = np.vstack([part.states, *(states for _, states in inner)])
        order = times if times[0] <= part.t[-1] else -times
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


def follow_angles(rows: np.ndarray, before: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Rows (k, n), each angle on the branch nearest to the row above; ``before`` is the first."""
    steps = np.diff(np.vstack([before, rows]), axis=0)
    return np.where(angles, rows - np.cumsum(whole_turns(steps), axis=0), rows)

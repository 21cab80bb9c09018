"""From one piece of the inputs to the next, at the instants at which parameters change.

Each piece of a run begins where the last one ended: no step goes over a change, so every method
keeps its order, and a jump is met exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, log2
from typing import Any

import mpmath
import numpy as np

from voronec.equations.program import compile_program
from voronec.motion.crossings import crosses
from voronec.motion.request import Guard
from voronec.motion.solve import DOUBLE, Arrival, Phase, Progress, Solver
from voronec.motion.steppers import (
    MEND,
    ControllerFailure,
    Integrator,
    Problem,
    Run,
    Termination,
    exact_mpf,
)

BESIDE = 1e-9
"""An event that is closer than this part of a piece to its end happens there, or not at all."""


def in_pieces(make: Callable[[Problem], Integrator], problem: Problem, anew: bool) -> Integrator:
    """The stepper of a problem with ``changing`` parameters: made once, or ``anew`` for each piece,
    where it asks for its numbers ``exact`` when it is made."""
    changing, names = problem.changing, [str(p) for p in problem.program.parameters]
    assert changing is not None
    given = list(problem.parameters)
    left = changing if changing.python_signal is not None else None
    progress = None if problem.progress is None else Progress(problem.progress)
    piece = replace(
        problem, start=problem.start.copy(), parameters=given, progress=progress, changing=left
    )
    once, told = None if anew else make(piece), problem.state_view()

    def ask(time: float, state: np.ndarray) -> None:
        for feedback in changing.feedbacks:
            if feedback.is_sampled:
                feedback.sample(time, lambda: told(time, state.astype(float).tolist(), given))

    def on_piece(state: np.ndarray, times: np.ndarray) -> Run:
        times = times.astype(float)
        values = changing.on(float(times[0]), float(times[-1]))
        given[:] = [float(values.get(n, x)) for n, x in zip(names, given, strict=True)]
        piece.start[:] = state.astype(float)
        if once is not None:
            try:
                return once(times)
            except ControllerFailure as failure:  # where it is asked first
                halt = Termination(str(failure), float(times[0]), state, mend=MEND)
                return Solver(times, problem.events, problem.dense).run(halt)

        def exact(bits: int) -> tuple[np.ndarray, Sequence[Any]]:
            first, known = problem.exact(bits) if problem.exact else (state, problem.parameters)
            with mpmath.workprec(bits):
                numbers = [exact_mpf(values.get(n, x)) for n, x in zip(names, known, strict=True)]
            return (first if state is problem.start else state), numbers

        return make(replace(piece, exact=exact))(times)

    def run(grid: np.ndarray) -> Run:
        first, last = float(grid[0]), float(grid[-1])
        for feedback in changing.feedbacks:
            feedback.values.clear()
        knots = _Knots(problem, on_piece, ask, last, iter(changing.knots(first, last)))
        bits = max(DOUBLE, ceil(-log2(problem.tol)))
        solver = Solver(grid, problem.events, problem.dense, progress, bits)
        return solver.run(knots.begin(first, problem.start))

    return run


@dataclass
class _Knots:
    """The change from one piece to the next, up to the ``last`` instant of the grid.

    The integrators of the pieces see the end of a run there, or its start: which events happen at
    the change is told by the ``signs`` of their functions on both sides.  Controllers that are due
    there are asked first.
    """

    problem: Problem
    on_piece: Callable[[np.ndarray, np.ndarray], Run]
    ask: Callable[[float, np.ndarray], None]
    last: float
    knots: Iterator[float]
    signs: dict[str, float] = field(default_factory=dict)

    def begin(
        self, time: float, state: np.ndarray, before: float | None = None
    ) -> Phase | Termination:
        """The piece from a time on, with what happens just there, where another one came
        ``before`` it."""
        try:
            self.ask(time, state)
        except ControllerFailure as failure:
            return Termination(str(failure), time, state, mend=MEND)
        if before is None or self.problem.levels is None:
            return self.phase(time, state)
        return self.phase(time, state, [*self.events_at(state, before, time)])

    def phase(self, time: float, state: np.ndarray, happened: Sequence[Guard] = ()) -> Phase:
        """The piece from a time on.  Between two neighbours among the doubles, where a function of
        Python's jumps, no step is made: it would be at the jump itself."""
        problem, begin, end = self.problem, time, next(self.knots, None)
        asked = problem.changing is not None and problem.changing.python_signal is not None
        while asked and end is not None and np.nextafter(begin, end) == end:
            begin, end = end, next(self.knots, None)

        def to_home(run: Run) -> Run:
            near = BESIDE * abs((self.last if end is None else end) - begin)
            if state is not problem.start:
                run = _without_crossings(run, begin, near)
            if end is None or run.halt or run.interrupted or problem.levels is None:
                return run
            if abs(float(run.t[-1]) - end) > 16 * abs(np.spacing(end)):
                return run
            # where an event stopped the piece that does not happen, rounding before its end
            run = _without_crossings(run, end, near + 4 * abs(np.spacing(end)))
            return replace(run, t=np.append(run.t[:-1], run.t.dtype.type(end)), stopped="")

        return Phase(
            None, begin, state, state, self.on_piece, {}, to_home, end, self, happened, False
        )

    def next(self, phase: Phase, here: Arrival) -> Phase | Termination:
        """The next piece, with what happens just where it begins."""
        if here.halt is not None:
            return here.halt
        return self.begin(phase.end, here.home, float(phase.time))

    def events_at(self, state: np.ndarray, first: float, end: float) -> Iterator[Guard]:
        """The events whose functions change sign at the end of a piece, by a jump or not."""
        before, after = self._levels(state, first, end)
        for event in self.problem.events:
            left = np.sign(before[event.name]) or self.signs.get(event.name, 0.0)
            self.signs[event.name] = right = np.sign(after[event.name]) or left
            if crosses(left, right, event.direction if self.last >= first else -event.direction):
                yield event

    def _levels(self, state: np.ndarray, first: float, end: float) -> Iterator[dict[str, float]]:
        """The functions of events a moment before and after an instant of change."""
        problem, changing = self.problem, self.problem.changing
        assert problem.levels is not None and changing is not None
        ahead = [t for t in changing.knots(end, self.last) if t != end]
        right, extras = compile_program(problem.program)[0], compile_program(problem.levels)[1]
        parameters = dict(
            zip(map(str, problem.program.parameters), problem.parameters, strict=True)
        )
        near = BESIDE * abs(end - first) + 4 * abs(np.spacing(end))
        step = near if end >= first else -near
        sides = (changing.on(first, end), changing.on(end, ahead[0] if ahead else self.last))
        for values, moment in zip(sides, (-step, step), strict=True):
            there = {**parameters, **values, **changing.values_at(end + moment)}
            known = {name: float(x) for name, x in there.items()}
            here = [known[str(name)] for name in problem.program.parameters]
            at = state.astype(float)
            with np.errstate(all="ignore"):
                moved = at + moment * np.array(right(end, at.tolist(), here), dtype=float)
                numbers = [known[str(name)] for name in problem.levels.parameters]
                levels = extras(end + moment, moved.tolist(), numbers)
            yield dict(zip(problem.levels.names, map(float, levels), strict=True))


def _without_crossings(run: Run, instant: float, near: float) -> Run:
    """A run without the crossings next to an instant."""
    kept = {}
    for name, (t, states) in run.crossings.items():
        apart = np.array([abs(float(x) - instant) > near for x in t], dtype=bool)
        kept[name] = t[apart], states[apart]
    return replace(run, crossings=kept)

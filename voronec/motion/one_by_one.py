"""Many motions carried one by one: smooth ones by DOP853, others as ``integrate`` makes them.

Lanes of a batch carry one right side.  Where switching surfaces are reached, inputs change in time,
or equations come near a place at which they are singular, a motion is integrated alone: it goes on
in other modes and charts, or in all velocities.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import count
from typing import Any

import numpy as np
import sympy as sp

from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.equations.program import Program, compile_program
from voronec.errors import IntegrationError, VoronecError
from voronec.motion.angle_cuts import CutWatch
from voronec.motion.batches import (
    COLLAPSE_RATIO,
    SINGULAR_PLACE,
    break_error,
)
from voronec.motion.methods import METHODS
from voronec.motion.motion_pool import Many
from voronec.motion.prepared_problem import integrate
from voronec.motion.request import Event, Starts, label
from voronec.motion.section_passages import (
    FEWER,
    PATIENCE,
    START_SHARE,
    Paths,
    Quantity,
    SectionPassages,
    SectionWatch,
    zeros,
)
from voronec.motion.steppers import INFINITE, Problem, Run
from voronec.motion.trajectory import Cost, Trajectory
from voronec.motion.transitions import is_switched

Passes = Callable[[np.ndarray, np.ndarray], bool]
"""Whether a motion with states (s, n) at times (s,) passes a place that makes it doubtful."""
PLANE = "the plane of the section"
"""The name of a section's event."""


def along_one(
    method: str, program: Program, state: np.ndarray, values: np.ndarray, grid: np.ndarray,
    tol: float, passes: Passes | None = None, dense: bool = False,
) -> tuple[Run, IntegrationError | None, bool]:  # fmt: skip
    """The run of one motion along a grid, the error that ended it, and whether its steps collapsed,
    or what it ``passes`` makes it doubtful."""
    doubts = [False]

    def look(times: np.ndarray, states: np.ndarray) -> None:
        doubts.append(passes is not None and passes(times, states))

    problem = Problem(program, state, values.tolist(), tol, dense=dense, suspect=look, marked=True)
    make = METHODS[method].make
    assert make is not None
    run = make(problem)(grid)
    if run.interrupted:
        raise KeyboardInterrupt
    lengths = np.abs(np.diff([grid[0], *run.ends]))[:-1]  # the last one is cut
    doubts.append(lengths.min(initial=np.inf) < COLLAPSE_RATIO * lengths.max(initial=0.0))
    error = _error_of(run)
    return run, error, error is None and any(doubts)


def states_along(run: Run, grid: np.ndarray) -> np.ndarray:
    """The states of a run along its grid (k, n)."""
    rows = np.full((len(grid), run.states.shape[1]), np.nan)
    if not run.stopped:  # else its last instant is none of the grid
        rows[: len(run.t)] = run.states
    return rows


def _error_of(run: Run) -> IntegrationError | None:
    if run.stopped:
        return break_error(SINGULAR_PLACE, run.t[-1], run.states[-1])
    halt = run.halt
    return None if halt is None else break_error(halt.reason, halt.time, halt.state)


TOGETHER, WHOLE = 128, 4
"""About so many steps are looked at together for crossings; all of them are sampled in so many
first stretches, and fewer and fewer later."""


def pass_one_by_one(
    motions: Many, watch: SectionWatch, passages: SectionPassages, method: str, tol: float
) -> None:
    """Follow the motions one by one with DOP853; crossings are sought on its interpolant."""
    try:
        for i in motions.sound:
            error = _follow(motions, watch, passages, method, tol, i)
            if error is not None:
                state = np.asarray(error.state)[: watch.width]
                passages.errors[i] = motions.error(i, str(error), FEWER, error.time, state.copy())
            passages.tell(motions.sound)
    except KeyboardInterrupt:
        passages.interrupted = True


def _follow(
    motions: Many, watch: SectionWatch, passages: SectionPassages, method: str, tol: float, i: int
) -> IntegrationError | None:  # fmt: skip
    """Follow motion i stretch by stretch to its passages, or to the error that is returned."""
    values, time, state = motions.values[i], motions.time, watch.begin(motions, [i])[0]
    crosses, after = motions.divisor_watch(values, 0.0), -np.inf
    span = FIRST * time_scale(motions, time, motions.states[i], values)

    def plane(t: np.ndarray, states: np.ndarray, _lane: np.ndarray) -> np.ndarray:
        return watch.function(t, states, np.broadcast_to(values, (len(states), len(values))))

    def passes(t: np.ndarray, states: np.ndarray) -> bool:
        return crosses is not None and crosses(t, states[:, : watch.width])

    for stretch in count(1):
        if passages.over(i):
            break
        grid = np.array([time, min(time + span, passages.until)])
        run, error, doubtful = along_one(
            method, watch.program, state, values, grid, tol, passes, dense=True
        )
        if doubtful:
            return break_error(SINGULAR_PLACE, time, state)
        if run.ends:
            paths = _as_polynomials(time, run, plane)
            after = max(after, motions.time + START_SHARE * float(paths.lengths[0, 0]))
            crossings = zeros(paths, passages.direction)
            passages.keep(i, crossings, 0, after)
            seen = crossings.low[0], crossings.high[0], crossings.fastest[0]
            passages.note_range(i, run.ends[-1], len(run.ends), seen)
            some = slice(None, None, max(1, stretch // WHOLE))
            passages.enter_samples(i, [part.pick(some) for part in run.samples])
        passages.steps += len(run.ends)
        time, state = float(run.t[-1]), run.states[-1]
        if error is None and not np.isfinite(state).all():
            error = break_error(INFINITE, time, state)
        if error is not None:
            return None if passages.over(i) else error
        span *= np.clip(TOGETHER / max(1, len(run.ends)), 1 / LONGER, LONGER)
    return None


def _as_polynomials(begin: float, run: Run, plane: Quantity) -> Paths:
    """The interpolants of the steps of a run, polynomials of degree seven, by their values at eight
    points."""
    nodes, times = np.linspace(0.0, 1.0, 8), np.array([begin, *run.ends], dtype=float)
    lengths = np.diff(times)[:, None]
    assert run.inside is not None
    with np.errstate(all="ignore"):  # what is beyond doubles is told elsewhere
        values = run.inside((times[:-1, None] + lengths * nodes).ravel())
        values = values.reshape(len(lengths), len(nodes), -1)
        scaled = np.swapaxes(np.linalg.solve(np.vander(nodes, increasing=True), values), 1, 2)
        series = scaled / lengths[:, :, None] ** np.arange(len(nodes))
    return Paths(times[:, None], series[..., None], plane, np.arange(series.shape[1]))


def time_scale(motions: Many, time: float, state: np.ndarray, values: np.ndarray) -> float:
    """A time in which no variable of a motion changes by more than its size, or by one unit."""
    with np.errstate(all="ignore"):  # at a pole there is none
        rates = compile_program(motions.program)[0](time, list(state), values.tolist())
    pace = np.max(np.abs(np.array(rates, float)) / np.maximum(1.0, np.abs(state)), initial=0.0)
    return float(1.0 / pace) if 0 < pace < np.inf else 1.0


LONGER, SPARE = 4.0, 1.25
"""A motion alone is followed so many times longer until it has made all its passages; where it has
made some, so many times as long as the others need at their pace, if that is less; and never much
beyond the end of its patience."""
FIRST = 16.0
"""It is followed over so many units of its time scale at first, or over twice the time up to where
it failed."""


@dataclass(frozen=True)
class LoneStart:
    """Where a motion starts, by its number among all."""

    number: int
    scene: Scene
    initial: Mapping[Any, Any]
    parameters: Mapping[str, float]


@dataclass(frozen=True)
class LoneMotions:
    """Motions as ``integrate`` makes them, each whole.

    ``starts`` are as they were given, over those of the ``scene``: with these go motions that are
    ``unplaced``, from starts at which the equations of all are singular, or nearly so.  Where
    ``inputs`` change in time they go with the ``declared`` system; else the equations hold them.
    """

    motions: Many
    starts: Starts
    scene: Scene | None
    method: str
    tol: float
    unplaced: frozenset[int]
    declared: System | None = None
    inputs: Mapping[Any, Any] | None = None
    costs: list[Cost] = field(default_factory=list)

    @classmethod
    def of_section(
        cls, motions: Many, starts: Starts, scene: Scene | None, method: str, tol: float
    ) -> LoneMotions:
        """Starts near the zero of a divisor are counted among the wrong ones of ``motions``."""
        for i in map(int, np.flatnonzero(motions.near_divisors)):
            near = break_error(SINGULAR_PLACE, motions.time, motions.states[i])
            motions.wrong.setdefault(i, near)
        return cls(motions, starts, scene, method, tol, frozenset(motions.wrong))

    @cached_property
    def cause(self) -> str:
        """Why each motion goes alone; nothing where many go together."""
        motions = self.motions
        if self.declared is not None:
            return "an input changes in time"
        if is_switched(self.method, motions.program, motions.ground.form, self.tol):
            return "not smooth"
        return "an angle has a cut" if CutWatch.of(motions.namespace).cuts else ""

    def start(self, i: int) -> LoneStart:
        """Where motion i starts."""
        motions, scene, initial = self.motions, Scene({}, (0.0, 1.0)), self.starts[i]
        if i not in self.unplaced:
            initial = motions.start_values(i)
        elif self.scene is not None:
            scene = replace(self.scene, inputs={})
        names = (self.declared or motions.namespace.equations.system).parameter_names
        constants = {name: float(x[i]) for name, x in motions.parameters.items() if name in names}
        return LoneStart(i, scene, initial, constants)

    def run(
        self, start: LoneStart, times: Any, outputs: Sequence[Any], events: Sequence[Event] = (),
        dense: bool = False,
    ) -> Trajectory:  # fmt: skip
        """The motion from a start at the instants, or up to the second of two."""
        return integrate(
            self.declared or self.motions.namespace.equations, start.scene, times, outputs,
            start.parameters, start.initial, self.method, self.tol, inputs=self.inputs,
            events=events, dense=dense,
        )  # fmt: skip


def go_on_alone(
    alone: LoneMotions, passages: SectionPassages, level: sp.Expr, outputs: Sequence[Any],
    every: bool,
) -> None:  # fmt: skip
    """Motions that did not start, or failed on the way, once more, each alone, up to their passages
    through ``level`` = 0; what fails alone, too, on the way keeps its first error.  Where ``every``
    one goes alone that is all of them."""
    motions = alone.motions
    try:
        for i in range(len(motions)) if every else sorted({*motions.wrong, *passages.errors}):
            if passages.interrupted:
                return
            try:
                _pass_alone(alone, passages, level, outputs, i)
            except IntegrationError as error:
                if i in motions.wrong:
                    motions.wrong[i] = error
                elif every:
                    passages.errors[i] = error
            except VoronecError as error:
                if i not in motions.wrong:
                    raise  # what is asked for makes no sense, whatever the start
                motions.wrong[i] = error
            if every:
                passages.tell(range(len(motions)))
    except KeyboardInterrupt:
        passages.interrupted = True


def _steps_since(run: Trajectory) -> int:
    """About how many steps the run has made since its last passage."""
    begin, end = float(run.t[0]), float(run.t[-1])
    last = max([begin, *map(float, run.events[PLANE].t)])
    return int(run.cost.steps * (end - last) / (end - begin)) if end > begin else 0


STEP = 1e-6
"""The step of difference quotients, in units of the time that a motion is followed."""
INSTANTS = 2001
"""Instants at which the range and the largest rate of the plane's quantity are seen."""


def _pass_alone(
    alone: LoneMotions, passages: SectionPassages, level: sp.Expr, outputs: Sequence[Any], i: int
) -> None:
    """Follow motion i to its passages; where it fails on the way and has none yet, to the error."""
    motions, names = alone.motions, [*outputs, level]
    event = Event(level, PLANE, passages.direction)
    unit = time_scale(motions, motions.time, motions.states[i], motions.values[i])
    way = np.nan_to_num(passages.of[i].reached - motions.time, posinf=0.0, neginf=0.0)
    span, idle, run, failed = max(FIRST * unit, 2 * float(way)), 0, None, None
    while run is None or not (
        len(run.events[PLANE]) >= passages.wanted or run.t[-1] >= passages.until or idle > PATIENCE
    ):
        end = min(motions.time + span, passages.until)
        try:
            run = alone.run(alone.start(i), [motions.time, end], names, (event,), dense=True)
        except IntegrationError as error:
            failed, run = error, error.trajectory
            if run is None or PLANE not in run.events:
                raise
            if i in passages.errors and len(run.events[PLANE]) < passages.wanted:
                raise
            break
        if run.interrupted:
            raise KeyboardInterrupt
        idle, pace = _steps_since(run), len(run.events[PLANE]) / passages.wanted
        rest = SPARE * max(1, PATIENCE / max(1, idle))
        span *= min(LONGER, rest, SPARE / pace if pace else LONGER)
    alone.costs.append(run.cost)
    _enter(passages, i, run, level, len(outputs), idle)
    if failed is not None and passages.of[i].count < passages.wanted:
        raise failed
    motions.wrong.pop(i, None)


def _enter(
    passages: SectionPassages, i: int, run: Trajectory, level: sp.Expr, width: int, idle: int
) -> None:
    """Take in what a motion alone shows."""
    passages.errors.pop(i, None)
    if run.notes:
        passages.notes[i] = run.notes
    passed, record = run.events[PLANE], passages.of[i]
    record.parts, record.count, record.idle = [], 0, 0
    passages.steps += run.cost.steps
    # the plane's quantity may be an output itself
    plane = run.outputs[-1] if len(run.outputs) > width else label(level)
    t, begin = np.asarray(passed.t, dtype=float), float(run.t[0])
    # one that fails reaches no instant of its grid after the first, and yet its passages
    end = max(float(run.t[-1]), t.max(initial=begin))
    assert run.within is not None
    fine = np.linspace(begin, end, INSTANTS)
    seen = run.within(fine)[plane]
    points = np.stack([passed[name] for name in run.outputs[:width]], axis=-1)[: passages.wanted]
    record.alone = points.astype(float), run.drift
    if len(t):
        h = STEP * (end - begin)
        sides = [run.within(np.clip(t + s * h, begin, end)) for s in (-1, 1)]
        speeds = (sides[1][plane] - sides[0][plane]) / (sides[1].t - sides[0].t)
        passages.put(i, t, np.full((len(t), passages.width), np.nan), speeds)
    if end > begin:
        fastest = float((np.abs(np.diff(seen)) / np.diff(fine)).max())
        passages.note_range(i, end, idle, (seen.min(), seen.max(), fastest))

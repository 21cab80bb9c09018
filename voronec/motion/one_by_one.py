"""Many motions carried one by one: smooth ones by DOP853, others through their switching surfaces,
or whole.

Lanes of a batch carry one right side; where switching surfaces are reached at different times,
there are many. Motions of a section are integrated whole, as by ``integrate``, where inputs change
in time, and where equations come near a place at which they are singular: it goes on in other
charts and splits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.algebra.text import formula
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.equations.program import Program, compile_program
from voronec.errors import DefinitionError, IntegrationError, VoronecError
from voronec.motion.angle_cuts import CutWatch
from voronec.motion.batches import (
    COLLAPSE_RATIO,
    SINGULAR_PLACE,
    break_error,
    require_method,
)
from voronec.motion.integration import integrate
from voronec.motion.methods import METHODS
from voronec.motion.mode_stepper import SwitchedIntegrator, through_switching_surfaces
from voronec.motion.motion_pool import Many
from voronec.motion.observables import jumps
from voronec.motion.request import Event, Guard, Starts, begin_of, label
from voronec.motion.section_passages import PATIENCE, SectionPassages, SectionWatch
from voronec.motion.singular_denominators import CLEAR, guard_events
from voronec.motion.state_probe import quantities
from voronec.motion.steppers import Problem, Run
from voronec.motion.trajectory import Cost, Trajectory

__all__ = [
    "DrivenPassages",
    "LoneMotions",
    "SwitchedMotions",
    "along_one",
    "crossing_speeds",
    "driven_passages",
    "end_at_cuts",
    "go_on_alone",
    "time_scale",
]

Passes = Callable[[np.ndarray, np.ndarray], bool]
"""Whether a motion with states (s, n) at times (s,) passes a place that makes it doubtful."""
PLANE = "the plane of the section"
"""The name of a section's event."""
STRETCH, GROWTH, LONGEST = 16.0, 2.0, 1e6
"""A section is sought over so many units of time scale at first, then over so many times more; over
more than the last only while the motion rests, held by friction, and costs next to no steps."""
LOOKS = 64
"""Points of a stretch at which the range of the plane's quantity is seen."""
SLOPE = 1e-6
"""The step of difference quotients, in units of the time scale."""


def along_one(
    method: str, program: Program, state: np.ndarray, values: np.ndarray, grid: np.ndarray,
    tol: float, passes: Passes | None = None,
) -> tuple[np.ndarray, IntegrationError | None, Run, bool]:  # fmt: skip
    """One motion along a grid: states (k, n), the error that ended it, its run, and whether its
    steps collapsed, or what it ``passes`` makes it doubtful."""
    doubts = [False]

    def look(times: np.ndarray, states: np.ndarray) -> None:
        doubts.append(passes is not None and passes(times, states))

    problem = Problem(program, state, values.tolist(), tol, suspect=look, marked=True)
    make = METHODS[method].make
    assert make is not None
    run = make(problem)(grid)
    rows, error = _states_along(run, grid)
    lengths = np.abs(np.diff([grid[0], *run.ends]))[:-1]  # the last one is cut
    doubts.append(lengths.min(initial=np.inf) < COLLAPSE_RATIO * lengths.max(initial=0.0))
    return rows, error, run, error is None and any(doubts)


def _states_along(run: Run, grid: np.ndarray) -> tuple[np.ndarray, IntegrationError | None]:
    """The states of a run along its grid (k, n), and the error that ended it."""
    if run.interrupted:
        raise KeyboardInterrupt
    rows = np.full((len(grid), run.states.shape[1]), np.nan)
    if not run.stopped:  # else its last instant is none of the grid
        rows[: len(run.t)] = run.states
    return rows, _error_of(run)


def _error_of(run: Run) -> IntegrationError | None:
    if run.stopped:
        return break_error(SINGULAR_PLACE, run.t[-1], run.states[-1])
    halt = run.halt
    return None if halt is None else break_error(halt.reason, halt.time, halt.state)


@dataclass
class SwitchedMotions:
    """Many motions, one by one; ``switched`` is the way of the latest, with what was made ready."""

    motions: Many
    method: str
    tol: float
    reason: str
    switched: SwitchedIntegrator
    plane: SwitchedIntegrator | None = field(default=None)

    @classmethod
    def of(cls, motions: Many, method: str, tol: float, grid: np.ndarray) -> SwitchedMotions | None:
        """None where the right side is smooth, or no motion goes."""
        if not motions.sound:
            return None
        switched = _switching_stepper(motions, motions.sound[0], method, tol, grid)
        if switched is None:
            return None
        require_method(method)
        for i in motions.sound[1:]:
            if switched.corner is not None:  # else nothing moves, and no method was chosen
                break
            values = motions.values[i].tolist()
            switched = switched.elsewhere(motions.time, motions.states[i], values)
        reason = f"{switched.chosen['reason']}; not smooth, so one by one"
        return cls(motions, str(switched.chosen["method"]), tol, reason, switched)

    @property
    def jumps(self) -> frozenset[str]:
        """The integrals that jump with the forces."""
        integrals = self.motions.ground.integrals.items()
        return frozenset(name for name, e in integrals if jumps(e))

    def along(
        self, i: int, grid: np.ndarray
    ) -> tuple[np.ndarray, IntegrationError | None, Run | None]:
        """Motion i along a grid: states (k, n), the error that ended it, its run."""
        state, values = self.motions.states[i], self.motions.values[i]
        if self._is_near(i, float(grid[0]), state):
            error = break_error(SINGULAR_PLACE, float(grid[0]), state)
            return np.full((len(grid), len(state)), np.nan), error, None
        self.switched = self.switched.elsewhere(float(grid[0]), state, values.tolist())
        run = self.switched.solver(grid)
        return *_states_along(run, grid), run

    def _is_near(self, i: int, time: float, state: np.ndarray) -> bool:
        """Whether motion i is so near to a singular place that it does not pass what is watched."""
        near = self.motions.divisor_watch(self.motions.values[i], CLEAR)
        return near is not None and near(np.array([time]), state[None])

    def passages(
        self, watch: SectionWatch, passages: SectionPassages, name: str, value: float
    ) -> None:
        """The crossings of a plane by all motions."""
        try:
            for i in self.motions.sound:
                self._pass(i, watch, passages, name, value)
                passages.tell(self.motions.sound)
        except KeyboardInterrupt:
            passages.interrupted = True

    def _pass(
        self, i: int, watch: SectionWatch, passages: SectionPassages, name: str, value: float
    ) -> None:
        motions = self.motions
        time, state, values = motions.time, motions.states[i], motions.values[i]
        unit = time_scale(motions, time, state, values)
        length = STRETCH * unit
        if self._is_near(i, time, state):
            passages.errors[i] = break_error(SINGULAR_PLACE, time, state)
        while not passages.over(i) and i not in passages.errors:
            grid = np.linspace(time, min(time + length, passages.until), LOOKS)
            way = self._to_plane(i, grid, state, name, value, passages.direction)
            run = way.solver(grid)
            if run.interrupted:
                raise KeyboardInterrupt
            t, states = run.crossings[PLANE]
            speeds = crossing_speeds(motions, watch, t, states, values, unit)
            passages.put(i, t, states, speeds)
            passages.enter_samples(i, run.samples, len(motions.states[i]))
            seen = watch.function(
                run.t, run.states, np.broadcast_to(values, (len(run.t), len(values)))
            )
            rates = np.abs(np.diff(seen)) / np.diff(run.t) if len(run.t) > 1 else np.zeros(1)
            passages.steps += run.steps
            passages.note_range(
                i, float(run.t[-1]), run.steps, (seen.min(), seen.max(), rates.max())
            )
            error = _error_of(run)
            if error is not None:
                passages.errors[i] = error
                return
            time, state = float(run.t[-1]), run.states[-1]
            longest = LONGEST * unit if run.steps > LOOKS else np.inf
            length = min(GROWTH * length, longest)

    def _to_plane(
        self, i: int, grid: np.ndarray, state: np.ndarray, name: str, value: float, direction: int
    ) -> SwitchedIntegrator:
        """The way of motion i from a state on, with the plane as an event."""
        values = self.motions.values[i].tolist()
        if self.plane is None:
            exact = se.Rational(*float(value).as_integer_ratio())
            functions = {PLANE: self.motions.ground.quantities[name] - exact}
            event = Guard(PLANE, direction)
            made = _switching_stepper(
                self.motions, i, self.method, self.tol, grid, (event,), functions, state
            )
            if made is None:
                raise DefinitionError("the right side is smooth after all")
            self.plane = made
        self.plane = self.plane.elsewhere(float(grid[0]), state, values)
        return self.plane


def time_scale(motions: Many, time: float, state: np.ndarray, values: np.ndarray) -> float:
    """A time in which no variable of a motion changes by more than its size, or by one unit."""
    with np.errstate(all="ignore"):  # at a pole there is none
        rates = compile_program(motions.program)[0](time, list(state), values.tolist())
    pace = np.max(np.abs(np.array(rates, float)) / np.maximum(1.0, np.abs(state)), initial=0.0)
    return float(1.0 / pace) if 0 < pace < np.inf else 1.0


def crossing_speeds(
    motions: Many, watch: SectionWatch, t: np.ndarray, states: np.ndarray, values: np.ndarray,
    unit: float,
) -> np.ndarray:  # fmt: skip
    """How fast the plane's quantity changes at crossings t (k,), by differences over a small part
    of the time scale ``unit``."""
    if not len(t):
        return np.empty(0)
    rates = compile_program(motions.program)[0](t, list(states.T), values.tolist())
    along = np.stack([np.broadcast_to(r, t.shape) for r in rates], axis=-1)
    given, h = np.broadcast_to(values, (len(t), len(values))), SLOPE * unit
    ends = [watch.function(t + s * h, states + s * h * along, given) for s in (1, -1)]
    return np.asarray((ends[0] - ends[1]) / (2 * h))


def _switching_stepper(
    motions: Many, i: int, method: str, tol: float, grid: np.ndarray,
    events: tuple[Guard, ...] = (), functions: dict[str, Any] | None = None,
    state: np.ndarray | None = None,
) -> SwitchedIntegrator | None:  # fmt: skip
    guards, watched = guard_events(motions.divisors)
    form, given = motions.ground.form, {**(functions or {}), **watched}
    levels = quantities(form, given) if given else None
    start = motions.states[i] if state is None else state
    bare = replace(
        motions.program,
        names=(),
        extras=replace(motions.program.extras, assignments=(), results=()),
    )
    problem = Problem(
        bare, start.copy(), motions.values[i].tolist(), tol, (*events, *guards),
        levels, coarse=frozenset(watched),
    )  # fmt: skip
    return through_switching_surfaces(method, problem, grid, form, given)


STEP = 1e-6
"""The step of difference quotients, in units of the time that a motion is followed."""
INSTANTS = 2001
"""Instants at which the largest rate of the plane's quantity is seen."""


@dataclass
class DrivenPassages:
    """What was found of several motions: rows (start, t, outputs, speed), in their order, the
    largest rate of the plane's quantity, how each ended, and what went wrong."""

    rows: list[tuple[int, float, np.ndarray, float]] = field(default_factory=list)
    fastest: list[float] = field(default_factory=list)
    ends: list[str] = field(default_factory=list)
    errors: dict[int, VoronecError] = field(default_factory=dict)
    notes: dict[int, tuple[str, ...]] = field(default_factory=dict)
    drift: dict[str, list[float]] = field(default_factory=dict)
    cost: Cost | None = None
    steps: int = 0
    interrupted: bool = False


def driven_passages(
    system: System, plane: Any, value: float, direction: int, outputs: Sequence[str],
    starts: Starts, parameters: Mapping[Any, Any], crossings: int, until: float | None,
    progress: Callable[[float], Any] | None, **options: Any,
) -> DrivenPassages:  # fmt: skip
    """The passages of motions from several starts, up to the time ``until``."""
    if until is None:
        raise DefinitionError(
            f"system '{system.name}': inputs that change in time by a table or a function are "
            "followed up to an instant; give until="
        )
    known = {plain_name(s): s for s in system.known_symbols()}
    quantity = formula(plane, "the plane", known) if isinstance(plane, str) else plane
    level = quantity - sp.Rational(value)
    event = Event(level, PLANE, direction)
    own = label(level)
    found = DrivenPassages()
    for i, start in enumerate(starts):
        chosen = {k: x[i] if isinstance(x, np.ndarray) else x for k, x in parameters.items()}
        try:
            run = integrate(
                system,
                times=[begin_of(options.get("scene")), until],
                initial=start,
                parameters=chosen,
                outputs=[*outputs, level],
                events=(event,),
                dense=True,
                **options,
            )
        except KeyboardInterrupt:
            found.interrupted = True
            break
        except IntegrationError as error:
            found.errors[i] = error
            _note(found, i, error.trajectory, crossings, "failed", len(outputs), own)
            continue
        end = f"no more crossings up to t = {until:.6g}"
        _note(found, i, run, crossings, end, len(outputs), own)
        if progress is not None:
            progress((i + 1) / len(starts))
    return found


def _note(
    found: DrivenPassages, i: int, run: Trajectory | None, crossings: int, end: str, width: int,
    own: str,
) -> None:  # fmt: skip
    """Take in what one motion shows; the plane's quantity, where it is among the outputs, is
    called ``own``."""
    if run is None or PLANE not in run.events:
        found.ends.append(end)
        found.fastest.append(np.inf)
        return
    names = run.outputs[:width]
    level = run.outputs[-1] if len(run.outputs) > width else own  # it is an output itself
    passed = run.events[PLANE]
    count = min(len(passed), crossings)
    h = STEP * abs(float(run.t[-1]) - float(run.t[0]))
    fine = np.linspace(float(run.t[0]), float(run.t[-1]), INSTANTS)
    rates = np.abs(np.diff(run.at(fine)[level])) / np.diff(fine)
    points = np.stack([passed[name] for name in names], axis=-1)
    for k in range(count):
        t = float(passed.t[k])
        sides = run.at([max(t - h, fine[0]), min(t + h, fine[-1])])
        speed = float(np.diff(sides[level])[0] / np.diff(sides.t)[0])
        found.rows.append((i, t, points[k], speed))
    found.fastest.append(float(rates.max()))
    found.ends.append("complete" if count == crossings else end)
    found.cost = run.cost
    found.steps += run.cost.steps
    if run.notes:
        found.notes[i] = run.notes
    for name, drift in run.drift.items():
        found.drift.setdefault(name, []).append(float(drift))


LONGER, SPARE = 4.0, 1.25
"""A motion alone is followed so many times longer until it has made all its passages; where it has
made some, so many times as long as the others need at their pace, if that is less; and never much
beyond the end of its patience."""
FIRST = 16.0
"""It is followed over so many units of its time scale at first, or over twice the time up to where
it failed."""


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

    def motion(
        self, i: int, times: Any, outputs: Sequence[Any], events: Sequence[Event] = ()
    ) -> Trajectory:
        """Motion i at the instants, or up to the second of two."""
        motions, scene, start = self.motions, Scene({}, (0.0, 1.0)), self.starts[i]
        if i not in self.unplaced:
            start = motions.start_values(i)
        elif self.scene is not None:
            scene = replace(self.scene, inputs={})
        equations = motions.namespace.equations
        own = (self.declared or equations.system).parameter_names
        constants = {name: float(x[i]) for name, x in motions.parameters.items() if name in own}
        return integrate(
            self.declared or equations, scene, times, outputs, constants, start, self.method,
            self.tol, inputs=self.inputs, events=events,
        )  # fmt: skip

    @property
    def outputs(self) -> list[sp.Expr]:
        """All coordinates and velocities."""
        system = self.motions.namespace.equations.system
        return [*system.coordinates, *system.velocities]

    def place(self, i: int, run: Trajectory) -> None:
        """Count motion i among the sound ones, with the start that it turned out to have."""
        motions = self.motions
        del motions.wrong[i]
        full = np.array([[float(run[plain_name(x)][0]) for x in self.outputs]])
        motions.full[i], motions.states[i] = full[0], motions.on_ground(i, run.t[:1], full)[0]


def go_on_alone(
    alone: LoneMotions, watch: SectionWatch, passages: SectionPassages, level: sp.Expr
) -> None:
    """Motions that did not start, or failed on the way, once more, each alone, up to their passages
    through ``level`` = 0; what fails alone, too, on the way keeps its first error."""
    wrong = alone.motions.wrong
    try:
        for i in sorted({*wrong, *passages.errors}):
            if passages.interrupted:
                return
            try:
                _pass_alone(alone, watch, passages, level, i)
            except VoronecError as error:
                if i in wrong:
                    wrong[i] = error
    except KeyboardInterrupt:
        passages.interrupted = True


def end_at_cuts(alone: LoneMotions, passages: SectionPassages) -> None:
    """Of motions that reach the cut of an angle keep the passages before that, and say so."""
    if not CutWatch.of(alone.motions.namespace).cuts:
        return
    for i in (i for i in alone.motions.sound if passages.parts[i]):
        end = float(passages.parts[i][-1][0][-1])
        try:
            alone.motion(i, [alone.motions.time, end], alone.outputs)
        except IntegrationError as error:
            t = np.concatenate([part[0] for part in passages.parts[i]])
            passages.cut(i, int((t < float(end if error.time is None else error.time)).sum()))
            passages.errors[i] = error


def _steps_since(run: Trajectory) -> int:
    """About how many steps the run has made since its last passage."""
    begin, end = float(run.t[0]), float(run.t[-1])
    last = max([begin, *map(float, run.events[PLANE].t)])
    return int(run.cost.steps * (end - last) / (end - begin)) if end > begin else 0


def _pass_alone(
    alone: LoneMotions, watch: SectionWatch, passages: SectionPassages, level: sp.Expr, i: int
) -> None:
    motions, names = alone.motions, alone.outputs
    event = Event(level, PLANE, passages.direction)
    unit = time_scale(motions, motions.time, motions.states[i], motions.values[i])
    way = np.nan_to_num(passages.reached[i] - motions.time, posinf=0.0, neginf=0.0)
    span, idle, run = max(FIRST * unit, 2 * float(way)), 0, None
    while run is None or not (
        len(run.events[PLANE]) >= passages.wanted or run.t[-1] >= passages.until or idle > PATIENCE
    ):
        try:
            end = min(motions.time + span, passages.until)
            run = alone.motion(i, [motions.time, end], names, (event,))
        except IntegrationError as error:
            run = error.trajectory
            if run is None or len(run.events[PLANE]) < passages.wanted:
                raise
        if run.interrupted:
            raise KeyboardInterrupt
        idle, pace = _steps_since(run), len(run.events[PLANE]) / passages.wanted
        rest = SPARE * max(1, PATIENCE / max(1, idle))
        span *= min(LONGER, rest, SPARE / pace if pace else LONGER)
    alone.costs.append(run.cost)
    if i in motions.wrong:
        alone.place(i, run)
    passages.errors.pop(i, None)
    if run.notes:
        passages.notes[i] = run.notes
    passed, passages.parts[i] = run.events[PLANE], []
    passages.count[i], passages.idle[i] = 0, 0
    t = np.asarray(passed.t, dtype=float)
    full = np.stack([np.asarray(passed[plain_name(x)], dtype=float) for x in names], axis=-1)
    states = motions.on_ground(i, t, full)
    speeds = crossing_speeds(motions, watch, t, states, motions.values[i], unit)
    passages.put(i, t, states, speeds)
    largest = np.abs(speeds).max(initial=0.0)
    passages.note_range(i, float(run.t[-1]), idle, (np.nan, np.nan, largest))
    passages.steps += run.cost.steps

"""heyoka's Taylor integrator: long steps whose dense output is as accurate as their ends.

What it compiles is kept in a folder that stays small: on its first use in a process heyoka sums up
the sizes of all programs that it keeps on disk, which takes 0.4 s where they are 1.2 GB (2500
programs); by default it lets them grow to 20 GB.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import symengine as se

from voronec.declaration.whole_files import make_private, user_cache
from voronec.equations.program import Program, hoist, taylor_extras, taylor_system
from voronec.motion.crossings import NODES
from voronec.motion.steppers.held_steps import Leap, LeapEnd
from voronec.motion.steppers.run import (
    COLLAPSE,
    INFINITE,
    WINDOW,
    Integrator,
    Problem,
    Run,
    StallDetector,
)
from voronec.motion.steppers.samples import burst, series_samples, series_states
from voronec.motion.steppers.series_reach import (
    BRIEF,
    BRIEF_STRIDE,
    GROWTH,
    MANY,
    PARTS,
    STRIDE,
    Field,
    LongSteps,
    blind_reach,
    blind_steps,
    field_of,
    reach,
)
from voronec.motion.steppers.step_loop import (
    IntegratorFailure,
    Segment,
    Stride,
    level_function,
    march,
)
from voronec.motion.steppers.units import CHUNK, LEAST, SHORT, TurnCount, natural_units

AHEAD = 100_000
"""Points of the grid that are handed over at a time, at most."""
FEW = 1_000
"""Points that are handed over where chunks are short."""
FIRST_LOOK = 4
"""Steps that may be too long are looked at so many at a time, at first."""
LONG, WEIGHT = 250_000, 20.0
"""After four times so many steps, seconds of work, a run is asked whether it ends at all; after
fewer, by as much as its program weighs more than the other."""
CRAWL = 1e-9
"""A chunk of steps that covers less than this part of the span leads nowhere."""
COMPACT = 60.0
"""Above this weight heyoka compiles in its compact mode: seconds sooner, then half as fast."""
IDLE = 16
"""So many integrators wait for another run; one of a large system takes some megabytes."""

_idle: dict[Any, list[_Machine]] = {}
"""Integrators that nobody uses, by all that they are made of: a run takes one out, sets start and
parameters, and brings it back, one of a kind.  To make one anew takes longer than most runs."""


@dataclass
class _Machine:
    """heyoka's integrator; ``hints``, times about which an event may have stopped it; what is taken
    out of states and their units; and the ``parameters`` that it was given last, at first none."""

    integrator: Any
    hints: list[float]
    winding: TurnCount
    constants: Any
    parameters: list[float] | None = None

    @classmethod
    def of(cls, problem: Problem, winding: TurnCount, hy: Any) -> _Machine:
        """One for problems that differ in start, units and parameters."""
        hints: list[float] = []
        integrator = _integrator(problem, hints, winding, hy)
        return cls(integrator, hints, winding, hoist(problem.program))

    def place(self, problem: Problem, grid: np.ndarray) -> None:
        """Go to the start of a problem, whatever went before."""
        ta = self.integrator
        if self.winding.scaled:
            self.winding.measure(natural_units(problem))
        ta.time, ta.state[:] = float(grid[0]), problem.start / self.winding.units
        given = list(map(float, problem.parameters))
        if given != self.parameters:
            self.parameters = given
            constants = self.constants.values(given)[: len(ta.pars)]
            ta.pars[: len(constants)] = constants
        self.winding.reset()
        self.fit_units(anew=True)

    def fit_units(self, anew: bool = False) -> None:
        """Measure states that left their units in others; units are parameters, behind those of the
        program, so that nothing is compiled anew."""
        if self.winding.renew(self.integrator.state) or anew:
            first = len(self.constants.program.parameters)
            pars = self.integrator.pars[first:]
            pars[:] = self.winding.units[: len(pars)]


def taylor(problem: Problem) -> Integrator:
    """The integrator, compiled; ``EngineLimit`` for a function that heyoka does not know."""
    hy = heyoka()
    pool = _Pool.of(problem, bool((natural_units(problem) != 1).any()), hy)
    machines = [pool.take()]
    share = min(1.0, WEIGHT / (problem.program.weight or 1.0))

    def drive(pool: _Pool, machine: _Machine, grid: np.ndarray) -> Run | None:
        machine.place(problem, grid)
        stall = StallDetector(grid[0], float(grid[-1]), max(int(share * LONG), WINDOW))
        try:
            stepper = _TaylorStepper(hy, machine, problem, grid, stall)
            # steps that were too long, and are taken again, count too
            course = march(
                problem, grid, stepper, level_function(problem),
                lambda _, time: stall.distance(stepper.evaluations, time),
            )  # fmt: skip
        finally:
            pool.at_rest[:] = [machine]
        return None if stepper.has_outgrown else course

    def run(grid: np.ndarray) -> Run:
        # a stepper may run again, from what start and parameters of its problem are then
        nonlocal pool
        course = drive(pool, machines.pop() if machines else pool.take(), grid)
        if course is None:
            pool = _Pool.of(problem, True, hy)
            course = drive(pool, pool.take(), grid)
        assert course is not None  # only a motion without units outgrows them
        return course

    return run


@contextmanager
def taylor_leap(problem: Problem) -> Iterator[Leap]:
    """Taylor steps from a state to an instant, with parameters of their own each time."""
    hy = heyoka()
    pool = _Pool.of(problem, bool((natural_units(problem) != 1).any()), hy)
    machine = pool.take()
    machine.place(problem, np.zeros(1))
    ta, units, constants = machine.integrator, machine.winding.units.copy(), machine.constants
    well, machine.parameters = hy.taylor_outcome.time_limit, None

    def leap(
        time: float, state: np.ndarray, end: float, given: Sequence[float], wanted: bool
    ) -> LeapEnd:
        numbers = constants.values(given)[: len(ta.pars)]
        ta.pars[: len(numbers)] = numbers
        ta.time, ta.state[:] = time, state / units
        outcome, _, _, steps, _, _ = ta.propagate_until(end, max_steps=CHUNK, write_tc=wanted)
        if outcome != well:
            broken = outcome == hy.taylor_outcome.err_nf_state
            raise IntegratorFailure(INFINITE if broken else COLLAPSE)
        samples = None
        if wanted:
            ends, lengths = np.array([end]), np.array([ta.last_h])
            times, states = series_samples(ends, lengths, ta.tc[None])
            samples = times, states * units
        return LeapEnd(ta.state * units, steps, steps, samples)

    try:
        yield leap
    finally:
        pool.at_rest.append(machine)


@dataclass
class _Pool:
    """Where integrators for problems of one kind stay ``at_rest``, and new ones are made."""

    problem: Problem
    scaled: bool
    hy: Any
    at_rest: list[_Machine]

    @classmethod
    def of(cls, problem: Problem, scaled: bool, hy: Any) -> _Pool:
        """That of a problem, which is ``scaled`` where some unit is not 1; what was longest in no
        use gives way to it."""
        events = tuple((e.name, e.direction, e.stop) for e in problem.events)
        watched = events, problem.levels if events else None
        key = problem.program, scaled, problem.tol, watched
        # a program is hashed here, and not in runs
        at_rest = _idle[key] = _idle.pop(key, [])
        while len(_idle) > IDLE:
            _idle.pop(next(iter(_idle)), None)
        return cls(problem, scaled, hy, at_rest)

    def take(self) -> _Machine:
        """An integrator that nobody else uses."""
        with suppress(IndexError):  # another thread may have taken it meanwhile
            return self.at_rest.pop()
        problem = self.problem
        units = natural_units(problem)
        winding = TurnCount.of(problem.program, problem.levels, units, self.scaled)
        return _Machine.of(problem, winding, self.hy)


def _integrator(problem: Problem, hints: list[float], winding: TurnCount, hy: Any) -> Any:
    """heyoka's integrator, to be given start and parameters.

    With functions of events among its own its steps are as short as their series ask for.  What
    heyoka finds of their zeros is a hint, at which a chunk of steps ends, where they stop a run: of
    two of them, one where a bisection cuts a step, it finds one.
    """
    program, levels = hoist(problem.program).program, problem.levels
    units = unit_parameters(winding, len(program.parameters), hy)
    functions = taylor_extras(levels, units) if levels is not None else {}
    moving = _moving_extras(levels) if levels is not None else set()
    watched, events = list[Any](), list[Any]()

    def hint(_: Any, time: float, __: int) -> None:
        hints.append(time)

    for event in problem.events:
        if event.name not in moving:
            continue  # a constant passes through nothing, and heyoka takes none
        watched.append(functions[event.name])
        callback = hint if event.stop else lambda *_: None
        events.append(hy.nt_event(watched[-1], callback))
    system = taylor_system(program, units)
    count = parameter_count([e for _, e in system] + watched, hy)
    beside = levels.extras.weight(levels.parameters) if levels is not None else 0.0
    return hy.taylor_adaptive(
        system,
        (problem.start / winding.units).tolist(),
        pars=[1.0] * count,
        tol=winding.tolerance(problem.tol),
        compact_mode=program.weight + beside > COMPACT,
        **({"nt_events": events} if events else {}),
    )


def unit_parameters(winding: TurnCount, first: int, hy: Any) -> list[Any]:
    """The units of the states as they stand in equations: parameters, from the ``first`` on, where
    some are not 1, so that they can be set anew; those of angles are not."""
    if not winding.scaled:
        return [1.0] * len(winding.units)
    return [1.0 if i in winding.angles else hy.par[first + i] for i in range(len(winding.units))]


def parameter_count(expressions: list[Any], hy: Any) -> int:
    """How many parameters heyoka wants: no more than the expressions contain."""
    return max((int(str(p)[1:]) for p in hy.get_params(expressions)), default=-1) + 1


def _moving_extras(levels: Program) -> set[str]:
    """Which of the extra quantities of a program move."""
    moving = {*levels.state, levels.time}
    for name, expr in levels.extras.assignments:
        if expr.free_symbols & moving:
            moving.add(name)
    pairs = zip(levels.names, levels.extras.results, strict=True)
    return {name for name, expr in pairs if se.sympify(expr).free_symbols & moving}


@dataclass
class _TaylorStepper:
    """heyoka's integrator under way, chunk by chunk: ``step()`` from Python takes 4 us a step, and
    a chunk of them 0.3."""

    hy: Any
    machine: _Machine
    problem: Problem
    grid: np.ndarray
    stall: StallDetector
    series: list[tuple[float, float, np.ndarray | None]] = field(default_factory=list)
    is_sampled: bool = False
    done: int = 1
    steps: int = 0
    evaluations: int = 0
    ahead: int = AHEAD
    size: int = field(default_factory=lambda: CHUNK)
    has_outgrown: bool = False
    failure: str = ""
    longest: float = 0.0
    usual: float = np.inf
    output: _TaylorSteps | None = None

    def __post_init__(self) -> None:
        self.integrator, self.winding = self.machine.integrator, self.machine.winding
        self.end = float(self.grid[-1])
        self.span = abs(self.end - float(self.grid[0]))
        self.opening = self.first_step()
        self.stride = STRIDE if self.opening == np.inf else 1.0
        self.has_roots = self.problem.program.has_moving_roots
        if self.winding.is_needed or self.has_roots:
            self.size, self.ahead = min(SHORT, CHUNK), FEW

    def first_step(self) -> float:
        """The length of the first step where heyoka's own would be too long, else infinite."""
        ta = self.integrator
        moment, state = ta.dtime, ta.state.copy()
        span = self.end - float(self.grid[0])
        taken = ta.step(max_delta_t=span, write_tc=True)[1] if span else 0.0
        # where the right side is not defined no step is taken, and the run says so
        well = np.isfinite(taken)
        parts = PARTS if abs(taken) >= abs(span) else 1
        length = reach(ta, self.right_side, taken, parts) if well else np.inf
        self.return_to(moment, state)
        return length

    def return_to(self, moment: tuple[float, float], state: np.ndarray) -> None:
        """Take the integrator back to a moment, as if it had not gone on."""
        self.integrator.dtime, self.integrator.state[:] = moment, state

    def advance(self) -> Stride | Segment:
        """The next chunk of steps; what ends the motion in it is told after it.

        States without units of their own that outgrow ordinary size end it, too: they loosen the
        steps of all others.
        """
        if self.failure:
            raise IntegratorFailure(self.failure)
        ta, outcomes = self.integrator, self.hy.taylor_outcome
        self.machine.fit_units()
        self.winding.take(ta.state)
        before, moment, state = ta.time, ta.dtime, ta.state.copy()
        limit = self.opening
        size = self.size if limit == np.inf else 1
        ahead, self.is_sampled = burst(self.steps)
        outcome, taken, rows = self.go_on(min(size, ahead))
        self.evaluations += taken
        self.opening = np.inf
        overlong = self.overlong(moment, state, taken) if limit == np.inf else None
        self.usual = min(self.usual, limit)
        if overlong is not None:
            good, length = overlong
            self.opening = np.inf if good else length
            outcome, taken, rows = self.go_on(good or 1)
            self.opening = length if good else np.inf
        large = rows if self.output is None else self.output.tcs[:, :, 0]
        self.has_outgrown = bool(self.winding.outgrown(ta.state) or self.winding.outgrown(large))
        if self.has_outgrown:
            raise IntegratorFailure(INFINITE)
        self.steps, self.done = self.steps + taken, self.done + len(rows)
        self.set_pace(taken, len(rows))
        if outcome == outcomes.err_nf_state:  # it stands beyond the last step that was good
            self.failure = INFINITE
            self.return_to(moment, state)
            self.go_on_while_finite(taken)
        moved = abs(ta.time - before) / max(taken, 1)
        # heyoka does not count steps of length zero among those that it took
        if outcome == outcomes.step_limit and moved <= CRAWL / CHUNK * self.span:
            self.failure = self.stall.reason(moved)
        return self.segment(taken, rows)

    def go_on_while_finite(self, most: int) -> None:
        """Take steps, at most so many, up to the last whose end is finite."""
        ta = self.integrator
        for _ in range(most):
            moment, state = ta.dtime, ta.state.copy()
            ta.step(max_delta_t=self.end - ta.time)
            if not (np.isfinite(ta.state).all() and np.isfinite(ta.time)):
                self.return_to(moment, state)
                break

    def segment(self, taken: int, rows: np.ndarray) -> Stride | Segment:
        """What was done in a chunk."""
        ta, whole = self.integrator, self.winding.whole
        state = whole(ta.state)
        if (output := self.output) is not None:
            begin, *inner, end = output.times.tolist()
            return Stride(
                begin, end, state, output, inner=inner, looks=output.looks,
                samples=output.samples if self.is_sampled else lambda *_: None,
            )  # fmt: skip
        ends, samples = np.array([time for time, _, _ in self.series]), None
        if self.is_sampled and self.series:
            times, states = series_samples(*self.last_steps())
            samples = times, whole(states)
        none = np.empty((0, len(state)))
        return Segment(taken, whole(rows), ta.time, state, ends, none, (), samples)

    def overlong(
        self, moment: tuple[float, float], state: np.ndarray, taken: int
    ) -> tuple[int, float] | None:
        """Of the chunk from a moment on, how many steps go before one that was made too long, and
        how long that may be; the integrator is taken back to the moment.  None where there is no
        such step."""
        if self.has_roots:
            return self.blind(moment, state)
        ta, span = self.integrator, abs(self.integrator.time - sum(moment))
        longest = max(self.longest, abs(ta.last_h))
        if taken > 1:
            self.usual = (span - longest) / (taken - 1)
        usual = self.usual * (self.stride if taken > BRIEF else min(self.stride, BRIEF_STRIDE))
        if not taken or not longest > usual:
            return None
        end, there = ta.dtime, ta.state.copy()
        self.return_to(moment, state)
        limit = self.first_overlong(taken, usual)
        self.return_to(*((moment, state) if limit else (end, there)))
        return limit

    def first_overlong(self, taken: int, usual: float) -> tuple[int, float] | None:
        """The first step that was too long, of so many from where the integrator stands; those that
        are longer than the ``usual``, or grow fast, are looked at, more and more of them at a
        time."""
        ta, most = self.integrator, FIRST_LOOK
        before, held = 0.0, dict[int, tuple[float, float, np.ndarray]]()
        for k in range(taken):
            begin = ta.time
            length = ta.step(max_delta_t=self.end - begin, write_tc=True)[1]
            if abs(length) > min(GROWTH * before, usual):
                held[k] = length, begin, ta.tc.copy()
            before = abs(length)
            broken = not np.isfinite(ta.time)  # by the look itself, where coefficients overflow
            if held and (len(held) == most or k == taken - 1 or broken):
                lengths, begins, series = map(np.array, zip(*held.values(), strict=True))
                which, ordinary = np.array([*held]), np.full(len(held), usual)
                steps = LongSteps(which, lengths, begins, np.moveaxis(series, 0, 2), ordinary)
                reaches = steps.reach(lambda _: self.right_side, ta.tol)
                for place, allowed in zip(held, reaches.tolist(), strict=True):
                    if allowed < np.inf:
                        return place, allowed
                held, most = {}, min(4 * most, MANY)
            if broken:
                break
        return None

    def blind(self, moment: tuple[float, float], state: np.ndarray) -> tuple[int, float] | None:
        """The first step that went over a corner, where roots in the equations may have corners so
        little rounded that no series sees it: by the defect at the end of each step."""
        ta, output, limit = self.integrator, self.output, None
        if output is None or not np.isfinite(ta.state).all():
            return None
        blind = np.flatnonzero(blind_steps(ta, output)).tolist()
        for k in blind:
            allowed = float(blind_reach(ta, self.right_side, output, k)[0])
            if allowed < np.inf:
                limit = k, allowed
                self.size = LEAST
                self.return_to(moment, state)
                break
        return limit

    def set_pace(self, taken: int, points: int) -> None:
        """How many steps, and points of the grid, the next chunk takes."""
        if taken < self.size // 2 or not (self.winding.is_needed or self.has_roots):
            self.ahead = min(4 * self.ahead, AHEAD)
            return
        most = MANY if self.has_roots else CHUNK
        self.size = self.winding.pace(self.size, self.integrator.state, most)
        # points cost when they are handed over, and again when they are passed
        self.ahead = min(max(4 * points, FEW), AHEAD)

    def go_on(self, size: int) -> tuple[Any, int, np.ndarray]:
        """One chunk of steps towards the end, with ``output`` where the motion within each is asked
        for, else along the rest of the grid: new rows of it."""
        ta, standing, done = self.integrator, self.integrator.time, self.done
        self.machine.hints.clear()
        self.series.clear()
        self.output, none = None, np.empty((0, len(self.problem.start)))
        limits = {"max_steps": size, "max_delta_t": self.opening} | self.callback
        if self.is_followed:
            outcome, _, self.longest, taken, _, _ = ta.propagate_until(
                self.end, write_tc=True, **limits
            )
            if self.series:
                ends, lengths, series = self.last_steps()
                times, winding = np.array([standing, *ends]), self.winding.now()
                self.output = _TaylorSteps(times, lengths, series, winding)
            return outcome, taken, none
        # the integrator wants its grid to begin where it stands
        if standing == self.grid[done]:
            points, known = self.grid[done : done + self.ahead], 0
        else:
            points, known = self.grid[done - 1 : done + self.ahead].copy(), 1
            points[0] = standing
        outcome, _, self.longest, taken, _, rows = ta.propagate_grid(points, **limits)
        return outcome, taken, rows[known:]

    def last_steps(self) -> tuple[np.ndarray, ...]:
        """Ends (s,), lengths (s,) and coefficients (s, n, order + 1) of steps."""
        return tuple(map(np.array, zip(*self.series, strict=True)))

    @property
    def is_followed(self) -> bool:
        """Whether the motion within each step is asked for."""
        return bool(self.problem.dense or self.has_roots or self.problem.events)

    @cached_property
    def right_side(self) -> Field:
        """The right side in the integrator's units."""
        return field_of(self.problem.program, self.problem.parameters, self.winding.units)

    @property
    def callback(self) -> dict[str, Any]:
        """What heyoka calls after each step: nothing, unless the steps are sampled or followed,
        their ends are asked for, or states may leave their units; where events may stop the run,
        the chunk ends."""
        hints, kept = self.machine.hints, self.is_sampled or self.is_followed
        listed = kept or self.problem.marked

        def has_ended(ta: Any) -> bool:
            if listed:
                self.series.append((ta.time, ta.last_h, ta.tc.copy() if kept else None))
            return not hints and (not self.winding.scaled or self.winding.fits(ta.state))

        return {"callback": has_ended} if self.winding.scaled or listed else {}


@dataclass(frozen=True)
class _TaylorSteps:
    """Dense output of steps: the ``times`` (s + 1,) at which they begin and end, their ``lengths``
    (s,), Taylor coefficients ``tcs`` (s, n, order + 1), and what was taken out of the states.  That
    of heyoka is compiled anew for each chunk of steps, which takes as long as to keep these of a
    thousand."""

    times: np.ndarray
    lengths: np.ndarray
    tcs: np.ndarray
    winding: TurnCount

    def __call__(self, times: np.ndarray) -> np.ndarray:
        order = 1.0 if self.times[-1] >= self.times[0] else -1.0
        step = np.searchsorted(order * self.times[1:-1], order * np.asarray(times), side="right")
        powers = (times - self.times[step])[:, None] ** np.arange(self.tcs.shape[2])
        return self.winding.whole((self.tcs[step] @ powers[:, :, None])[:, :, 0])

    def looks(self) -> np.ndarray:
        """The states at the ``times`` of a ``StepCourse``."""
        states = series_states(np.diff(self.times), self.tcs, NODES)
        inner = states[:, :-1].reshape(-1, states.shape[2])
        return self.winding.whole(np.concatenate([inner, states[-1, -1:]]))

    def samples(self, count: int, last: float) -> tuple[np.ndarray, np.ndarray]:
        """Samples of so many steps, up to a time in the last one."""
        ends, lengths = self.times[1 : count + 1].copy(), self.lengths[:count].copy()
        lengths[-1] -= ends[-1] - last
        ends[-1] = last
        times, states = series_samples(ends, lengths, self.tcs[:count])
        return times, self.winding.whole(states)


ROOM = 24 * 2**20
"""So many bytes of compiled programs stay on disk, those of some 80 models; what nobody used for
longest gives way.  heyoka adds up all that is there when it opens it: 64 MiB take 20 ms."""


def heyoka() -> Any:
    """The module; ``ImportError`` where it is not installed, or cannot be loaded.

    Who loads heyoka before has it keep its programs where and as long as that one likes.
    """
    is_ours = "heyoka" not in sys.modules
    try:
        import heyoka as hy
    except OSError as error:  # a library of its own that the machine refuses
        raise ImportError(error) from error

    if is_ours:
        folder, state = user_cache("heyoka"), hy.llvm_state
        try:
            make_private(folder, *folder.iterdir())
            state.set_diskcache_path(folder)
            state.set_diskcache_limit(ROOM)
        except (OSError, RuntimeError):  # nobody can write there, or others can
            state.set_diskcache_enabled(False)
    return hy

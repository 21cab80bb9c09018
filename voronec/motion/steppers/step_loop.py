"""One loop for every integrator that goes step by step: grid, events, dense output, guards."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from voronec.equations.program import compile_program
from voronec.motion.request import Guard
from voronec.motion.steppers.run import (
    COLLAPSE,
    DISTANT,
    SINGULAR,
    Halt,
    Headway,
    Log,
    Problem,
    Run,
    Ticker,
    in_parts,
    until,
)

__all__ = [
    "IntegratorFailure",
    "Stretch",
    "Stride",
    "Walker",
    "crosses",
    "crossings",
    "early_looks",
    "early_returns",
    "level_function",
    "march",
    "root",
    "rounding",
]


Levels = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Times (k,) and states (k, n) to the events' functions (k, m)."""

LOOKS = 8
"""Parts of a step at whose ends the functions are looked at."""
TOUCH = 0.1
"""Where a parabola predicts a least value below this part of what is seen, the least value between
two looks is computed: there may be two zeros there."""
GRAIN = 1e-26
"""What stands for the function of a wall on it: a motion may leave it and come back at once."""
RATIO, RATIOS, ROUNDINGS = 4.0, 26, 2e-15
"""Where a function is zero at the start of a run, it is looked at after so many spans, each so many
times longer than the one before, too: it may be zero again soon. Less than the last, in units of
the states, is rounding."""
ROUNDOFF = 1e-15
"""What rounding makes of a state, in units of its size: where a function goes beyond zero and comes
back by less than that makes of it, it touches zero."""
BESIDE, TALL = 1e-6, 100.0
"""A pole is told by values so many times larger than at this part of a span from it."""
TRIES = 200
"""Of secants and bisections for a root: one of four halves what is left; doubles need no more."""
NARROWINGS = 40
"""Of a golden section: to 1e-8 of the step, below which an extremum is flat in doubles."""
GOLDEN = 0.381966
"""The smaller part of a golden section, 1 - 1/phi."""


def early_looks(start: Any, length: Any) -> np.ndarray:
    """Times (k,): a start, and others soon after it, the last after some length."""
    later = [start + length * RATIO**-k for k in range(RATIOS, -1, -1)]
    return np.array([start, *later])


def early_returns(values: np.ndarray, states: np.ndarray) -> dict[int, tuple[int, int]]:
    """Column -> the two looks between which a function is zero again, of those of functions that
    are zero at the first: ``values`` (k, m) at ``states`` (k, n), a start and what comes soon after
    it."""
    numbers = values.astype(float)
    size = np.abs(states.astype(float)).max(axis=1, keepdims=True, initial=1.0)
    rounding = 0.0 if values.dtype == object else ROUNDINGS * size
    signs = np.where(np.abs(numbers) > rounding, np.sign(numbers), 0.0)
    found = {}
    for column in np.flatnonzero(signs[0] == 0):
        moved = np.flatnonzero(signs[:, column])
        turns = np.flatnonzero(np.diff(signs[moved, column]))
        if len(turns):
            before, after = moved[turns[0] : turns[0] + 2].tolist()
            found[int(column)] = before, after
    return found


def rounding(levels: Levels, time: np.ndarray, states: np.ndarray) -> np.ndarray:
    """By how much rounding may change functions (m,) at a time (1,): ``states`` (k, n) are that,
    then others on the way, which tell how large each is; of many digits it does not count."""
    here = states[:1]
    if states.dtype == object:
        return np.zeros(levels(time, here).shape[1])
    rows = np.vstack([here, here + ROUNDOFF * np.diag(np.abs(states).max(axis=0))])
    with np.errstate(all="ignore"):
        values = levels(np.repeat(time, len(rows)), rows)
        return np.asarray(np.nansum(np.abs(values[1:] - values[:1]), axis=0))


def crossings(
    events: Mapping[int, Guard], levels: Callable[..., np.ndarray], stride: Stride,
    walls: frozenset[str] = frozenset(), first: bool = False,
) -> list[tuple[Any, Guard]]:  # fmt: skip
    """Times at which events happen within a step, in the order of the motion.

    ``events`` are given by the columns of their ``levels``.  Those named in ``walls`` fall from
    what is not negative where the step starts, but for rounding: it may start on a wall.  In the
    ``first`` step of a run others may be zero at its start, and again soon after it.
    """
    start, end = stride.start, stride.end
    times, states, values = _look_along(events, levels, stride, walls)
    on_wall = values[0] == GRAIN
    touches, found = _may_touch(values), []
    brackets = _early_brackets(levels, stride, times[1], walls, events) if first else []
    for i, column in np.argwhere(touches | crosses(values[:-1], values[1:])).tolist():
        pair = [(times[i], values[i, column]), (times[i + 1], values[i + 1, column])]
        brackets.append((column, pair, bool(touches[i, column])))
    for column, bracket, is_touch in brackets:
        if column not in events:
            continue
        event = events[column]

        def level(time: Any, column: int = column) -> Any:
            moment = np.array([time], dtype=times.dtype)
            return levels(moment, stride.at(moment))[0, column]

        is_wall, begin = event.name in walls, bracket[0][0]
        leaves = bool(on_wall[column]) and begin == start
        depth: Any = 0.0
        if is_touch and leaves and states.dtype != object:
            # beside the wall that a step leaves, values are the rounding of its dense output, too
            depth = 2 * rounding(levels, times[:1], states[:1])[column]
            depth += ROUNDINGS * np.nanmax(np.abs(values[:, column]))
        elif is_touch and not is_wall:
            middle = np.array([begin + (bracket[1][0] - begin) / 2], times.dtype)
            depth = rounding(levels, middle, np.vstack([stride.at(middle), states]))[column]
        if is_touch and (turn := _turn(level, bracket, is_wall, depth)):
            bracket.insert(1, turn)
        for (a, before), (b, after) in pairwise(bracket):
            if crosses(before, after, event.direction if end > start else -event.direction):
                time = root(level, a, before, b, after)
                if event.name in walls or not _is_pole(level, (a, before), time, (b, after)):
                    found.append((time, event))
    return sorted(found, key=lambda pair: abs(pair[0] - start))


def _look_along(
    events: Mapping[int, Guard], levels: Levels, stride: Stride, walls: frozenset[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (k,) along a step, the states and the functions there (k, m): a wall on which it starts
    is beyond none, and zeros where others touch it are no passages."""
    start, end = stride.start, stride.end
    times = np.array([start + (end - start) * i / LOOKS for i in range(LOOKS)] + [end])
    states = stride.at(times)
    values = levels(times, states)
    for column, event in events.items():
        if event.name in walls and values[0, column] <= 0:
            values[0, column] = GRAIN
            # what stays at zero, as a push that is just what friction bears, does not fall
            values[values[:, column] == 0, column] = GRAIN
        elif event.name not in walls:
            _leave_touches(values[:, column])
    return times, states, values


def _is_pole(
    level: Callable[[Any], Any], begin: tuple[Any, Any], time: Any, end: tuple[Any, Any]
) -> bool:
    """Whether a function that changes its sign at a ``time`` between two is infinite there.

    It is larger than at both, or, where one of them is beside the pole, than a little way off: on
    the side of its own sign, since it may also jump, be it beyond that one.
    """
    (a, before), (b, after), value = begin, end, level(time)
    height, sizes = abs(value), (abs(before), abs(after))
    if not height < float("inf") or height > max(sizes):
        return True
    way = (b - a if (value > 0) == (after > 0) else a - b) * BESIDE
    return bool(height > min(sizes) and height > TALL * abs(level(time + way)))


Bracket = tuple[int, list[tuple[Any, Any]], bool]
"""A column, times with the values of its function there, and whether it may touch zero between."""


def _early_brackets(
    levels: Callable[..., np.ndarray], stride: Stride, until: Any, walls: frozenset[str],
    events: Mapping[int, Guard],
) -> list[Bracket]:  # fmt: skip
    """Where functions that are zero where the step starts, walls aside, are zero again before its
    first look."""
    times = early_looks(stride.start, until - stride.start)
    states = stride.at(times)
    values = levels(times, states)
    own = {i for i, event in events.items() if event.name not in walls}
    return [
        (column, [(times[i], values[i, column]), (times[k], values[k, column])], False)
        for column, (i, k) in early_returns(values, states).items()
        if column in own
    ]


def crosses(before: Any, after: Any, direction: int = 0) -> Any:
    """Whether functions pass zero between looks, numbers or arrays of them, in a direction, or in
    any: a zero counts for the part of a step that it ends."""
    upwards, downwards = (before < 0) & (after >= 0), (before > 0) & (after <= 0)
    return upwards | downwards if direction == 0 else upwards if direction > 0 else downwards


def _may_touch(values: np.ndarray) -> np.ndarray:
    """Whether functions (k + 1, m) of one sign may reach zero between looks (k, m): the parabola
    through three looks has its least value there, close to zero or beyond."""
    left, right = values[:-1], values[1:]
    positive = (left > 0) & (right > 0)
    sign = np.where(positive, 1.0, -1.0)
    rest = positive | ((left < 0) & (right < 0))
    numbers, touches = values.astype(float), np.zeros(left.shape, dtype=bool)
    a, b, c = numbers[:-2], numbers[1:-1], numbers[2:]
    bend, slope = (a - 2 * b + c) / 2, (c - a) / 2
    with np.errstate(all="ignore"):
        place, least = slope / (2 * bend), b - slope**2 / (4 * bend)
    looks = np.arange(len(left))
    for k in (np.maximum(looks - 1, 0), np.minimum(looks, len(a) - 1)):
        there = k[:, None] + 1 - place[k] - looks[:, None]
        near = rest & (sign * bend[k] > 0) & (there >= -TOUCH) & (there <= 1 + TOUCH)
        most = np.maximum.reduce([sign * a[k], sign * b[k], sign * c[k]])
        touches |= near & (sign * least[k] < TOUCH * most)
        rest &= ~near
    return touches


def _leave_touches(values: np.ndarray) -> None:
    """Give zeros at looks (k + 1,) between values of one sign that sign: there may be no passage,
    or two."""
    before, here, after = values[:-2], values[1:-1], values[2:]
    for i in np.flatnonzero((here == 0) & (before * after > 0)).tolist():
        here[i] = GRAIN if before[i] > 0 else -GRAIN


def _turn(
    function: Callable[[Any], Any], bracket: Sequence[tuple[Any, Any]], or_zero: bool, depth: Any
) -> tuple[Any, Any] | None:
    """A point between two, and the value there, where the function has the other sign, beyond a
    ``depth``, or else is zero, ``or_zero``; None where it keeps its own."""
    (a, value), (b, _) = bracket
    sign = 1 if value > 0 else -1
    c, d = a + (b - a) * GOLDEN, b - (b - a) * GOLDEN
    low, high = function(c), function(d)
    for _ in range(NARROWINGS):
        for place, level in ((c, low), (d, high)):
            if sign * level < -depth or (or_zero and level == depth == 0):
                return place, level
        if sign * low < sign * high:
            b, d, high = d, c, low
            c = a + (b - a) * GOLDEN
            low = function(c)
        else:
            a, c, low = c, d, high
            d = b - (b - a) * GOLDEN
            high = function(d)
    return None


def root(function: Callable[[Any], Any], a: Any, left: Any, b: Any, right: Any) -> Any:
    """A zero between a and b, where the function has values of different signs, to the last digits
    of the numbers in use: secants from the latest point b, the value at an end that stays halved
    (Illinois), which give way to bisection where three of them do not halve what is left."""
    wide, slow = abs(b - a), 0
    for count in range(TRIES):
        if right == 0 or a == b:
            return b
        middle = b - right * (b - a) / (right - left)
        if count % 3 == 2:
            if slow > 1 or 2 * abs(b - a) > wide:
                middle, slow = a + (b - a) / 2, slow + 1
            wide = abs(b - a)
        if not min(a, b) < middle < max(a, b):
            middle = a + (b - a) / 2
        if middle in (a, b):
            return middle
        value = function(middle)
        if (value > 0) == (right > 0):
            left = left / 2
        else:
            a, left = b, right
        b, right = middle, value
    return b


TINY = 1e-6
"""The part of a step over which slopes of functions are taken."""
SUSPECTS = 64
"""States whose mass matrices are looked at together."""
EVERY = 8
"""Of the steps of a compiled loop one in so many is looked at: a matrix that was singular between
two of them has another number of negative eigenvalues at the next."""


class IntegratorFailure(Exception):
    """An integrator cannot go on, for a reason in words."""


@dataclass(frozen=True)
class Stride:
    """One accepted step, with its dense output: times (k,) to states (k, n).

    ``slopes`` are the states and rates at both ends, where they are known at no cost.  ``up_to``
    takes a method of stages up to an earlier instant alone: stages of the whole step, and the dense
    output made of them, look beyond it.
    """

    start: Any
    end: Any
    state: np.ndarray
    at: Callable[[np.ndarray], np.ndarray]
    slopes: tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]] | None = None
    up_to: Callable[[float], Stride] | None = None


@dataclass(frozen=True)
class Stretch:
    """Accepted ``steps`` in which nothing happens, up to the time ``end`` and a state (n,) there.

    ``rows`` (k, n) are the states at the next points of the grid.  Where a problem asks for ends
    of steps, ``times`` (s,) and ``states`` (s, n) are these; where it asks for dense output,
    ``strides`` are the steps.
    """

    steps: int
    rows: np.ndarray
    end: float
    state: np.ndarray
    times: np.ndarray
    states: np.ndarray
    strides: Sequence[Stride]


class Walker(Protocol):
    """An integrator under way."""

    def advance(self) -> Stride | Stretch:
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
        given = np.array([at(x) for x in t]).T if asked else problem.parameters
        results = extras(t, list(states.T), list(given))
        return np.stack([np.broadcast_to(r, t.shape) for r in results], axis=1)

    return function


def march(problem: Problem, grid: np.ndarray, walker: Walker, levels: Levels) -> Run:
    """The run over a grid."""
    return _March(problem, grid, walker, levels).run()


@dataclass
class _March:
    problem: Problem
    grid: np.ndarray
    walker: Walker
    levels: Levels
    log: Log = field(init=False)
    states: np.ndarray = field(init=False)
    strides: list[Stride] = field(default_factory=list)
    ends: list[float] = field(default_factory=list)
    recent: list[tuple[np.ndarray, np.ndarray, int]] = field(default_factory=list)
    unseen: int = 0
    done: int = 1
    steps: int = 0
    idle: int = 0
    is_on_wall: bool = True
    last: Halt = field(init=False)

    def __post_init__(self) -> None:
        grid, start = self.grid, self.problem.start
        self.log = Log(grid[0], float(np.ptp(grid)), len(start), walls=self.problem.walls)
        self.states = np.empty((len(grid), len(start)), dtype=start.dtype)
        self.states[0] = start
        self.order = 1 if grid[-1] >= grid[0] else -1
        self.forward = self.order * grid
        self.last = Halt(COLLAPSE, grid[0], start)
        self.suspect(grid[:1], start[None, :])

    def run(self) -> Run:
        ticker = Ticker(self.problem.progress, float(self.grid[0]), float(self.grid[-1]))
        headway = Headway(self.grid[0], float(self.grid[-1]))
        try:
            while self.done < len(self.grid) and not self.log.stopped:
                try:
                    stride = self.walker.advance()
                except IntegratorFailure as halted:
                    good = self.last
                    return self.result(Halt(str(halted), good.time, good.state))
                if isinstance(stride, Stretch):
                    self.pass_over(stride)
                else:
                    self.steps += 1
                    self.take(stride)
                ticker(self.last.time)
                if self.unseen >= SUSPECTS and (halt := self.singular()):
                    return self.result(halt)
                if reason := headway.failure(self.steps, self.last.time):
                    return self.result(replace(self.last, reason=reason))
        except KeyboardInterrupt:
            return self.result(interrupted=True)
        return self.result(self.singular())

    def take(self, stride: Stride) -> None:
        """Enter a step: crossings in it, then points of the grid up to the one that stops."""
        end = stride.end
        near = self.near(stride)
        fine = {
            i: event
            for i, event in enumerate(self.problem.events)
            if event.name not in self.problem.coarse or near[i]
        }
        if fine:
            left = self.problem.walls if self.is_on_wall else frozenset()
            found = crossings(fine, self.levels, stride, left, self.steps <= 1)
            self.is_on_wall = self.is_on_wall and self.stays(stride, fine)
            stride, found = self.cut(stride, found, fine)
            for time, event in found:
                if self.log.stopped and not self.log.is_at_end(time):
                    break
                if not self.log.stopped:
                    end, state = time, stride.at(np.array([time], dtype=self.states.dtype))[0]
                self.log.enter(event, end, state)
            end = end if self.log.stopped else stride.end
        reached = self.count_until(end)
        self.idle += 1
        if reached > self.done:
            self.idle = 0
            new = slice(self.done, reached)
            self.states[new] = stride.at(self.grid[new])
            self.suspect(self.grid[new], self.states[new])
            self.done = reached
        if self.problem.dense:
            self.strides.append(stride)
        if self.problem.marked:
            self.ends.append(float(stride.end))
        self.last = Halt(COLLAPSE, stride.end, stride.state)
        self.suspect(np.array([stride.end]), stride.state[None, :])

    def count_until(self, time: Any) -> int:
        """How many points of the grid a time is not before; of two that are one as doubles, one of
        many digits tells which is first."""
        return bisect_right(self.forward, self.order * time)

    def stays(self, stride: Stride, events: Mapping[int, Guard]) -> bool:
        """Whether the function of a wall is zero where a step ends: short first steps may leave it
        by less than rounding."""
        walls = [i for i, event in events.items() if event.name in self.problem.walls]
        if not walls:
            return False
        end = np.array([stride.end], dtype=self.states.dtype)
        return bool((self.levels(end, stride.at(end))[0, walls] == 0).any())

    def cut(
        self, stride: Stride, found: list[tuple[Any, Guard]], events: Mapping[int, Guard]
    ) -> tuple[Stride, list[tuple[Any, Guard]]]:
        """A step up to the first wall in it, where its stages look beyond, and what happens in it:
        there other equations hold."""
        walls = self.problem.walls
        wall = next((pair for pair in found if pair[1].name in walls), None)
        if wall is None or stride.up_to is None or wall[0] == stride.start:
            return stride, found
        shorter = stride.up_to(wall[0])
        others = {i: event for i, event in events.items() if event.name not in walls}
        before = crossings(others, self.levels, shorter, frozenset(), self.steps <= 1)
        return shorter, [*before, wall]

    def suspect(self, times: np.ndarray, states: np.ndarray, every: int = 1) -> None:
        """Have the mass matrices at times (k,) and states (k, n) looked at, before long: one of so
        many, and all where one of these is singular, or lies beyond one that is."""
        if self.problem.suspect is not None and len(times):
            self.recent.append((times, states, every))
            self.unseen += len(times)

    def pass_over(self, stretch: Stretch) -> None:
        """Enter steps in which nothing happens."""
        new = slice(self.done, self.done + len(stretch.rows))
        self.states[new] = stretch.rows
        self.suspect(self.grid[new], stretch.rows)
        self.suspect(stretch.times, stretch.states, EVERY)
        self.done, self.steps = new.stop, self.steps + stretch.steps
        self.idle = 0 if len(stretch.rows) else self.idle + stretch.steps
        self.strides += stretch.strides
        if self.problem.marked:
            self.ends += stretch.times.tolist()
        self.last = Halt(COLLAPSE, stretch.end, stretch.state)

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

    def singular(self) -> Halt | None:
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
        found = look(times.astype(float), states.astype(float))
        assert found is not None  # some of these were among the few
        time, state = times[max(found - 1, 0)], states[max(found - 1, 0)]
        reached = self.count_until(time)
        self.done = min(self.done, max(reached, 1))
        return Halt(SINGULAR, time, state, singular=True)

    def result(self, halt: Halt | None = None, interrupted: bool = False) -> Run:
        t, states = self.grid[: self.done].copy(), self.states[: self.done].copy()
        end = self.log.last if self.log.stopped else (self.last.time, self.last.state)
        kept = self.log.stopped or (interrupted and self.idle >= DISTANT)
        if kept and self.order * end[0] > self.order * t[-1]:
            t = np.append(t.astype(states.dtype), np.array([end[0]], states.dtype))
            states = np.vstack([states, end[1]])
        found = self.log.arrays(self.problem.events, states.dtype)
        if halt is not None:
            found = until(found, t[0], halt.time)
        return Run(
            t, states, self.steps, self.walker.evaluations, found, halt, interrupted,
            self.log.stopped, self.inside if self.problem.dense else None, ends=tuple(self.ends),
        )  # fmt: skip

    def inside(self, times: np.ndarray) -> np.ndarray:
        """States at any times reached."""
        ends = [stride.end for stride in self.strides]
        parts = [stride.at for stride in self.strides]
        return in_parts(ends, self.order, parts, times, self.states)

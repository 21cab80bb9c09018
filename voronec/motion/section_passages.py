"""Following motions from one passage through a surface to the next.

A Taylor step is a small part (about e^-2) of the radius of convergence, so over one step all but
the first few terms are small, and ``crossings`` needs few looks; of a polynomial in the time steps
are as long as the motion, and it cuts them in pieces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.equations.program import Program
from voronec.errors import IntegrationError, VoronecError
from voronec.motion.batches import (
    COLLAPSE_RATIO,
    SINGULAR_PLACE,
    Lanes,
    break_error,
    carry,
)
from voronec.motion.crossings import NODES, Pieces, find_crossings, roots
from voronec.motion.steppers import (
    INFINITE,
    Place,
    StepSamples,
    series_samples,
)

if TYPE_CHECKING:
    from voronec.motion.motion_pool import Many

TOUCH = 1e-12
"""An extremum touches zero where states changed by this part of their size bring it there."""
BESIDE = 1e-2
"""Touches nearer to each other than this part of a step are one."""
POLE = 1e3
"""What is larger than this part of its size at both ends of a bracket has a pole there."""
FEWER = "ask for fewer crossings"

Quantity = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""``(t, states (m, n), lane (m,))`` to values (m,)."""


@dataclass(frozen=True, eq=False)
class SectionWatch:
    """The plane's quantity: ``function(t, states (m, n), values (m, p))``, and which entries of
    the state it holds.

    Where it is no sum of states, it may pass zero more often than a step that these allow tells:
    then the ``program`` of the motion has what bends in it as more states behind the others,
    ``width`` of them, and steps are as long as the series of all allow.
    """

    function: Callable[[Any, np.ndarray, np.ndarray], np.ndarray]
    needed: np.ndarray
    program: Program
    width: int

    def begin(self, motions: Many, which: Any) -> np.ndarray:
        """The states (k, n) from which some motions (k,) set out, in the program."""
        states = motions.states[which]
        more = len(self.program.state) - self.width
        return np.concatenate([states, np.ones((len(states), more))], axis=1)


@dataclass(frozen=True, eq=False)
class Paths:
    """Motions in several lanes, each a sequence of polynomials, and a ``quantity`` that is looked
    at on the way, which holds the ``needed`` entries of the state.

    ``times`` (s + 1, lanes) are the ends of the steps; ``series`` (s, n, order + 1, lanes) are the
    coefficients in the time since the beginning of the step.  Step i of lane k has the number
    i lanes + k.
    """

    times: np.ndarray
    series: np.ndarray
    quantity: Quantity
    needed: np.ndarray

    @property
    def lengths(self) -> np.ndarray:
        """Lengths of the steps (s, lanes)."""
        return np.diff(self.times, axis=0)

    def looks(self) -> tuple[np.ndarray, np.ndarray]:
        """Times and values of the quantity (8 s + 1, lanes) at the nodes of all steps."""
        steps, size, _, lanes = self.series.shape
        lane, each = np.tile(np.arange(lanes), steps), len(NODES) - 1
        times, values = np.empty((2, each * steps + 1, lanes))
        # term by term in memory, so that sums over them run along it
        terms = np.ascontiguousarray(self.series[:, self.needed].transpose(2, 1, 0, 3))
        for k, part in enumerate(NODES):
            within = part * self.lengths
            t = self.times[:-1] + within if k < each else self.times[1:]
            states = np.zeros((size, steps, lanes))
            states[self.needed] = _horner(terms, within)
            levels = self.quantity(t.ravel(), states.reshape(size, -1).T, lane).reshape(t.shape)
            rows = slice(k, -1 if k < each else None, each)  # what ends a step begins the next
            times[rows], values[rows] = t, levels
        return times, values

    def states(self, tau: np.ndarray, number: np.ndarray, entries: np.ndarray) -> np.ndarray:
        """Some entries of the states (n, m) at times tau (m,) into steps (m,)."""
        step, lane = np.divmod(number, self.times.shape[1])
        picked = self.series[step[:, None], entries[None, :], :, lane[:, None]]
        states = np.zeros((self.series.shape[1], len(tau)))
        states[entries] = _horner(np.ascontiguousarray(picked.transpose(2, 1, 0)), tau)
        return states

    def value(self, tau: np.ndarray, number: np.ndarray) -> np.ndarray:
        """The quantity (m,) there."""
        return self._of(self.states(tau, number, self.needed), tau, number)

    def _of(self, states: np.ndarray, tau: np.ndarray, number: np.ndarray) -> np.ndarray:
        lane = number % self.times.shape[1]
        return self.quantity(self.times.ravel()[number] + tau, states.T, lane)

    def depth(self, tau: np.ndarray, number: np.ndarray) -> np.ndarray:
        """By how much the quantity changes where states do by what may be an error."""
        sizes = np.fmax.reduce(np.abs(self.series[:, self.needed, 0]), axis=0)
        states = self.states(tau, number, self.needed)
        looks = [self._of(states, tau, number)]
        for entry, size in zip(self.needed, sizes[:, number % sizes.shape[1]], strict=True):
            states[entry] += TOUCH * size
            looks.append(self._of(states, tau, number))
        return np.asarray(np.abs(np.diff(looks, axis=0)).sum(axis=0))

    def speed(self, tau: np.ndarray, number: np.ndarray) -> np.ndarray:
        """The rate of the quantity, by a difference."""
        d = 1e-4 * self.lengths.ravel()[number]
        return np.asarray((self.value(tau + d, number) - self.value(tau - d, number)) / (2 * d))

    def first_step(self, lane: int) -> StepSamples:
        """A sample of the first step of a lane."""
        ends, lengths = self.times[1:2, lane], self.lengths[:1, lane]
        return StepSamples(*series_samples(ends, lengths, self.series[:1, :, :, lane]))


def _horner(terms: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """Polynomials with coefficients along the first axis."""
    value = terms[-1].copy()
    for term in terms[-2::-1]:
        value *= tau
        value += term
    return np.asarray(value)


@dataclass(frozen=True, eq=False)
class Zeros:
    """Zeros in order of the lane, then of the time: ``lane``, ``t`` (m,), ``states`` (m, n), and
    ``speed`` (m,), the rate of the quantity there.  ``touches`` (lane, t) come to zero and turn
    back; ``low``, ``high`` are the quantity's range and ``fastest`` its largest rate (lanes,)."""

    lane: np.ndarray
    t: np.ndarray
    states: np.ndarray
    speed: np.ndarray
    touches: tuple[tuple[int, float], ...]
    low: np.ndarray
    high: np.ndarray
    fastest: np.ndarray


def zeros(paths: Paths, direction: int) -> Zeros:
    """All zeros of the quantity, to rounding; ``direction`` is that of its change, or 0 for
    both."""
    lanes, (times, values) = paths.times.shape[1], paths.looks()
    with np.errstate(all="ignore"):  # a lane that idles takes steps of no length
        rates = np.abs(np.diff(values, axis=0)) / np.diff(times, axis=0)
        length = paths.lengths.ravel()
        pieces = Pieces.along(np.zeros(len(length)), length, values)
        crossings, touches = find_crossings(paths.value, pieces, paths.depth)
        crossings = crossings.where(
            (direction == 0) | ((crossings.after > crossings.before) == (direction > 0))
        )
        begin = paths.times.ravel()[crossings.number]
        crossings = crossings.where(np.lexsort((begin + crossings.start, crossings.number % lanes)))
        number = crossings.number
        tau = roots(lambda tau, i: paths.value(tau, number[i]), *crossings.parts[:4])
        # what is larger than at both ends is a pole; beside a jump a quantity stays of its size
        ends = np.maximum(np.abs(crossings.before), np.abs(crossings.after))
        true = np.abs(paths.value(tau, number)) <= POLE * ends
        tau, number = tau[true], number[true]
    return Zeros(
        lane=number % lanes,
        t=paths.times.ravel()[number] + tau,
        states=paths.states(tau, number, np.arange(paths.series.shape[1])).T.copy(),
        speed=paths.speed(tau, number),
        touches=tuple(_touches(paths, touches)),
        low=np.fmin.reduce(values, axis=0),
        high=np.fmax.reduce(values, axis=0),
        fastest=np.fmax.reduce(rates, axis=0),
    )


def _touches(paths: Paths, found: Sequence[tuple[int, float]]) -> Iterator[tuple[int, float]]:
    """Lanes and times of touches, from numbers of steps and times in these: each once."""
    lanes, last = paths.times.shape[1], (-1, 0.0)
    for lane, time, length in sorted(
        (n % lanes, float(paths.times.flat[n] + tau), float(paths.lengths.flat[n]))
        for n, tau in found
    ):
        if last[0] != lane or time - last[1] > BESIDE * length:
            yield lane, time
        last = lane, time


PATIENCE = 50_000
"""Steps without a crossing after which a motion is given up."""
FEWEST, MOST = 256, 16_384
"""Steps of a motion between two looks for crossings: each look costs as much as some hundreds."""
ROOM = 3 * 2**20
"""Coefficients of all motions between two looks, 24 MiB: up to 32 the memory of the last ones is
used again, and what takes more is twice as slow."""
START_SHARE = 1e-9
"""A crossing sooner than this part of the first step is the start itself."""
FOREVER = 1e12
"""How long a motion is followed where nobody says it."""


@dataclass(eq=False)
class MotionPassages:
    """What is known of one motion: ``parts`` of its crossings, ``count`` in all, times (k,), states
    (k, n) and speeds (k,); ``samples`` of its steps; how many of these it is ``idle`` since the
    last crossing; how far it came, the range of the plane's quantity and its largest rate.  Of one
    that goes ``alone`` there are outputs (k, m) instead of states, and drifts."""

    parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=list)
    samples: list[StepSamples] = field(default_factory=list)
    count: int = 0
    idle: int = 0
    reached: float = np.nan
    low: float = np.nan
    high: float = np.nan
    fastest: float = np.nan
    alone: tuple[np.ndarray, Mapping[str, Any]] | None = None


@dataclass(eq=False)
class SectionPassages:
    """Crossings as they are found, start by start ``of`` each; states are ``width`` wide."""

    of: list[MotionPassages]
    width: int
    wanted: int
    direction: int
    until: float
    progress: Callable[[float], Any] | None
    strict: bool = True
    touches: list[tuple[int, float]] = field(default_factory=list)
    errors: dict[int, VoronecError] = field(default_factory=dict)
    notes: dict[int, tuple[str, ...]] = field(default_factory=dict)
    steps: int = 0
    interrupted: bool = False

    def put(self, i: int, t: np.ndarray, states: np.ndarray, speed: np.ndarray) -> None:
        """Further crossings of start i, no more than are wanted."""
        record = self.of[i]
        room = self.wanted - record.count
        t, states, speed = t[:room], states[:room, : self.width], speed[:room]
        if len(t):
            record.parts.append((t, states, speed))
            record.count += len(t)
            record.idle = 0

    def keep(
        self, i: int, found: Zeros, lane: int, after: float, until: float = np.inf
    ) -> None:  # fmt: skip
        """Take in what was ``found`` in a lane between two times as crossings and touches of start
        i."""
        take, record = (found.lane == lane) & (found.t > after) & (found.t < until), self.of[i]
        t, room = found.t[take], self.wanted - record.count
        last = t[room - 1] if len(t) >= room else np.inf
        self.touches.extend((i, t) for k, t in found.touches if k == lane and after < t <= last)
        self.put(i, t, found.states[take], found.speed[take])

    def enter_samples(self, i: int, samples: Iterable[StepSamples]) -> None:
        """Samples of steps of start i, whose states are the first entries of theirs."""
        self.of[i].samples.extend(part.narrow(self.width) for part in samples)

    def cut(self, i: int, count: int) -> None:
        """Keep the first crossings of start i alone."""
        record = self.of[i]
        t, states, speed = (np.concatenate(column) for column in zip(*record.parts, strict=True))
        record.parts, record.count = [(t[:count], states[:count], speed[:count])], count

    def note_range(self, i: int, time: float, steps: int, found: Sequence[float]) -> None:
        """How far start i came; the range of the quantity on the way and its largest rate."""
        record, (low, high, fastest) = self.of[i], found
        record.reached = float(time)
        record.idle += steps
        record.low, record.high = float(np.fmin(record.low, low)), float(np.fmax(record.high, high))
        record.fastest = float(np.fmax(record.fastest, fastest))

    def over(self, i: int) -> bool:
        """Whether start i has all it needs, failed, or is given up."""
        record = self.of[i]
        full = record.count >= self.wanted or record.idle > PATIENCE
        return bool(full or i in self.errors or record.reached >= self.until)

    def tell(self, sound: Sequence[int]) -> None:
        """Report the fraction that is done."""
        if self.progress is not None:
            shares = [1.0 if self.over(i) else self.of[i].count / self.wanted for i in sound]
            self.progress(float(np.mean(shares)))

    def ends(self, i: int, wrong: Mapping[int, VoronecError]) -> str:
        """How start i ended, in words."""
        if i in wrong or i in self.errors:
            return "failed"
        if self.of[i].count >= self.wanted:
            return "complete"
        if not self.over(i):
            return "stopped by hand"
        return f"no more crossings up to t = {self.of[i].reached:.6g}"

    def join(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Start, t, states, speed of all crossings."""
        start = np.repeat(np.arange(len(self.of)), [record.count for record in self.of])
        none = np.empty(0), np.empty((0, self.width)), np.empty(0)
        parts = [none, *(part for record in self.of for part in record.parts)]
        t, states, speed = (np.concatenate(column) for column in zip(*parts, strict=True))
        return start, t, states, speed


def pass_lanes(motions: Many, watch: SectionWatch, passages: SectionPassages, lanes: Lanes) -> None:
    """Follow the motions in heyoka's lanes, those together that take about as many steps."""
    sound = np.array(motions.sound, dtype=int)
    sound = sound[np.argsort(motions.paces[sound], kind="stable")]
    try:
        for i in range(0, len(sound), lanes.width):
            _LanePassages(motions, watch, passages, lanes, sound[i : i + lanes.width]).run()
    except KeyboardInterrupt:
        passages.interrupted = True


@dataclass(eq=False)
class _LanePassages:
    """Motions under way in the first of heyoka's lanes, by their ``numbers``; ``rows`` (width,) are
    those of all lanes, and ``ends`` (width,) the times to which these go: where they are over,
    where they stand."""

    motions: Many
    watch: SectionWatch
    passages: SectionPassages
    lanes: Lanes
    numbers: np.ndarray
    rows: np.ndarray = field(init=False)
    ends: np.ndarray = field(init=False)

    def run(self) -> None:
        """Chunk after chunk, until no motion is left."""
        lanes, motions, count = self.lanes, self.motions, len(self.numbers)
        # lanes without a motion of their own idle at the start of the last one
        self.rows = self.numbers[np.minimum(np.arange(lanes.width), count - 1)]
        begin = self.watch.begin(motions, self.rows)
        lanes.load(slice(None), begin, motions.values[self.rows], motions.time)
        lanes.reset_size()
        self.ends = np.full(lanes.width, motions.time)
        self.ends[:count] = self.passages.until
        first = lanes.first_steps(self.ends - motions.time)
        errors, _ = carry(lanes, self.ends, first, lambda: False, self.look, self.steps_ahead)
        for k, error in errors.items():
            i, state = int(self.rows[k]), np.asarray(error.state)[: self.watch.width]
            self.passages.errors[i] = motions.error(i, str(error), FEWER, error.time, state.copy())

    def under_way(self, place: Place) -> dict[int, int]:
        """Which motions are not yet at their ends where the lanes stand, by their lanes."""
        going = (self.ends != place[0]) & np.isfinite(place[2]).all(axis=0)
        return {k: int(i) for k, i in enumerate(self.numbers) if going[k]}

    def steps_ahead(self) -> int:
        """So many steps that the motion nearest to its end is not carried far beyond it."""
        passages, ta = self.passages, self.lanes.integrator
        left = [passages.wanted - passages.of[i].count for i in self.under_way(ta.place).values()]
        done = sum(record.count for record in passages.of)
        each = passages.steps / done if done else FEWEST
        room = max(ROOM // (ta.state.size * (ta.batch.order + 1)), FEWEST)
        most = min(MOST, 1 << (room.bit_length() - 1))  # memory grows by doubling
        return int(np.clip(1.1 * each * min(left) + 16, FEWEST, most))

    def look(self, begin: Place) -> dict[int, IntegrationError]:
        """Take in the crossings in a chunk; the motions that cannot go on in lanes."""
        lanes, passages, ta = self.lanes, self.passages, self.lanes.integrator
        output, errors, busy = lanes.output, dict[int, IntegrationError](), self.under_way(begin)
        passages.steps += int(ta.latest.taken[[*busy]].sum())
        if output is not None:
            series = lanes.winding.whole_series(output.tcs)
            self.collect(busy, Paths(output.times, series, self.plane, self.watch.needed))
        for k, i in busy.items():
            if output is None:
                passages.note_range(i, ta.high[k], max(int(ta.latest.taken[k]), 1), (np.nan,) * 3)
            broken = not ta.alive[k]
            if broken or lanes.steps.doubtful[k]:
                why = INFINITE if broken else SINGULAR_PLACE
                errors[k] = break_error(why, passages.of[i].reached, lanes.states[k])
            elif passages.over(i):
                self.ends[k] = ta.high[k]
        passages.tell(self.motions.sound)
        return errors

    def plane(self, t: np.ndarray, states: np.ndarray, lane: np.ndarray) -> np.ndarray:
        """The plane's quantity (m,) on lanes (m,)."""
        constants = self.motions.values[self.rows[lane]]
        return self.watch.function(t, states, constants)

    def collect(self, busy: Mapping[int, int], paths: Paths) -> None:
        """Take in the crossings of the lanes that carry motions, each as far as it is trusted."""
        passages, collapsed = self.passages, self.lanes.steps.has_collapsed
        crossings, start = zeros(paths, passages.direction), self.motions.time
        first = np.where(paths.times[0] == start, START_SHARE * paths.lengths[0], -np.inf)
        for k, i in busy.items():
            until = _trusted_until(paths.times[:, k]) if collapsed[k] else np.inf
            passages.keep(i, crossings, k, start + first[k], until)
            seen = (crossings.low[k], crossings.high[k], crossings.fastest[k])
            passages.note_range(i, paths.times[-1, k], len(paths.lengths), seen)
            passages.enter_samples(i, [paths.first_step(k)])


def _trusted_until(times: np.ndarray) -> float:
    """The time at which a motion, by the ends of its steps, comes to a singular place."""
    lengths = np.abs(np.diff(times))
    short = lengths < COLLAPSE_RATIO * np.maximum.accumulate(lengths)
    return float(times[int(np.argmax(short))]) if short.any() else float(times[0])

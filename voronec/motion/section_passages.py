"""Following motions from one passage through a surface to the next.

A Taylor step is a small part (about e^-2) of the radius of convergence, so over one step all but
the first few terms are small, and ``crossings`` needs few looks; of a polynomial in the time steps
are as long as the motion, and it cuts them in pieces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.equations.program import Program, hoist
from voronec.errors import IntegrationError, VoronecError
from voronec.motion.batches import (
    COLLAPSE_RATIO,
    SINGULAR_PLACE,
    Lanes,
    StepSizes,
    break_error,
    carry,
)
from voronec.motion.crossings import NODES, Pieces, find_crossings, roots
from voronec.motion.methods import METHODS
from voronec.motion.request import number
from voronec.motion.steppers import (
    INFINITE,
    IntegratorFailure,
    Place,
    Problem,
    Segment,
    StepSampler,
    StepSamples,
    Stride,
    dop853_steps,
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
    """Motions in several lanes, each a sequence of polynomials.

    ``times`` (s + 1, lanes) are the ends of the steps; ``series`` (s, n, order + 1, lanes) are the
    coefficients in the time since the beginning of the step.
    """

    times: np.ndarray
    series: np.ndarray

    @property
    def lengths(self) -> np.ndarray:
        """Lengths of the steps (s, lanes)."""
        return np.diff(self.times, axis=0)

    def sample(self, needed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Times (m, lanes) and states (n, lanes, m), m = 8 s + 1; only needed entries."""
        steps, size, order, lanes = self.series.shape
        h, parts, looks = self.lengths, NODES[:-1, None], len(NODES) - 1
        times = np.empty((looks * steps + 1, lanes))
        within = times[:-1].reshape(steps, looks, lanes)
        np.add(self.times[:-1, None], h[:, None] * parts, out=within)
        times[-1] = self.times[-1]
        # term by term in memory, so that sums over them run along it
        terms = np.empty((order, len(needed), lanes, steps))
        power, along = np.ones((lanes, steps)), np.ascontiguousarray(h.T)
        for own, term in zip(self.series[:, needed].transpose(2, 1, 3, 0), terms, strict=True):
            np.multiply(own, power, out=term)
            power *= along
        # no BLAS: a second thread of it would cost more than it gains
        later = np.einsum("jk,km->jm", parts[1:] ** np.arange(order), terms.reshape(order, -1))
        later = later.reshape(looks - 1, *terms.shape[1:])
        states = np.zeros((size, lanes, looks * steps + 1))
        for i, entry in enumerate(needed):
            for k, samples in enumerate((terms[0, i], *later[:, i])):
                states[entry, :, k:-1:looks] = samples
        states[needed, :, -1] = terms[..., -1].sum(axis=0)
        return times, states

    def first_step(self, lane: int) -> StepSamples:
        """A sample of the first step of a lane."""
        ends, lengths = self.times[1:2, lane], self.lengths[:1, lane]
        return StepSamples(*series_samples(ends, lengths, self.series[:1, :, :, lane]))

    def terms(self, step: np.ndarray, lane: np.ndarray, needed: np.ndarray) -> np.ndarray:
        """Coefficients (order + 1, needed, m) of some steps (m,) of lanes (m,)."""
        picked = self.series[step[:, None], needed[None, :], :, lane[:, None]]
        return np.ascontiguousarray(picked.transpose(2, 1, 0))


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


def zeros(paths: Paths, quantity: Quantity, needed: np.ndarray, direction: int) -> Zeros:
    """All zeros of a quantity, to rounding; ``direction`` is that of its change, or 0 for both.

    ``needed`` are the entries of the state that the quantity holds.
    """
    times, states = paths.sample(needed)
    lanes = times.shape[1]
    which = np.arange(lanes)
    # lane by lane in memory, as they are gone through below
    values = np.stack([quantity(times[:, i], states[:, i].T, which[i]) for i in range(lanes)]).T
    sizes = np.fmax.reduce(np.abs(states[needed]), axis=2)

    with np.errstate(all="ignore"):  # a lane that idles takes steps of no length
        rates = np.abs(np.diff(values, axis=0)) / np.diff(times, axis=0)
        low, high = np.fmin.reduce(values, axis=0), np.fmax.reduce(values, axis=0)
        length = paths.lengths.ravel()
        pieces = Pieces.along(np.zeros(len(length)), length, values)

        def close(number: np.ndarray) -> _Close:
            return _Close.of(paths, quantity, needed, *np.divmod(number, lanes))

        def depth(tau: np.ndarray, number: np.ndarray) -> np.ndarray:
            """By how much the quantity changes where states do by what may be an error."""
            look = close(number)
            looks = [look.value(tau)]
            for term, size in zip(look.terms[0], sizes[:, look.lane], strict=True):
                term += TOUCH * size
                looks.append(look.value(tau))
            return np.asarray(np.abs(np.diff(looks, axis=0)).sum(axis=0))

        found, touches = find_crossings(lambda tau, i: close(i).value(tau), pieces, depth)
        found = found.where((direction == 0) | ((found.after > found.before) == (direction > 0)))
        step, lane = np.divmod(found.number, lanes)
        found = found.where(np.lexsort((paths.times[step, lane] + found.start, lane)))
        look = close(found.number)
        tau = roots(lambda tau, i: look.where(i).value(tau), *found.parts[:4])
        # what is larger than at both ends is a pole; beside a jump a quantity stays of its size
        ends = np.maximum(np.abs(found.before), np.abs(found.after))
        true = np.abs(look.value(tau)) <= POLE * ends
        tau, look = tau[true], look.where(true)
        step, lane = np.divmod(found.number[true], lanes)
    return Zeros(
        lane=lane,
        t=look.begin + tau,
        states=_horner(paths.terms(step, lane, np.arange(look.size)), tau).T.copy(),
        speed=look.speed(tau),
        touches=tuple(_touches(paths, touches)),
        low=low,
        high=high,
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


@dataclass(frozen=True, eq=False)
class _Close:
    """A close look at some steps, all at once: only the entries that the quantity holds."""

    quantity: Quantity
    needed: np.ndarray
    size: int
    lane: np.ndarray
    begin: np.ndarray
    length: np.ndarray
    terms: np.ndarray

    @classmethod
    def of(
        cls, paths: Paths, quantity: Quantity, needed: np.ndarray, step: np.ndarray,
        lane: np.ndarray,
    ) -> _Close:  # fmt: skip
        terms = paths.terms(step, lane, needed)
        begin, length = paths.times[step, lane], paths.lengths[step, lane]
        return cls(quantity, needed, paths.series.shape[1], lane, begin, length, terms)

    def value(self, tau: np.ndarray) -> np.ndarray:
        """The quantity at times tau (m,) into the steps."""
        states = np.zeros((self.size, len(tau)))
        states[self.needed] = _horner(self.terms, tau)
        return self.quantity(self.begin + tau, states.T, self.lane)

    def where(self, which: np.ndarray) -> _Close:
        """At some of them."""
        lane, begin, length = self.lane[which], self.begin[which], self.length[which]
        terms = self.terms[:, :, which]
        return _Close(self.quantity, self.needed, self.size, lane, begin, length, terms)

    def speed(self, tau: np.ndarray) -> np.ndarray:
        """The rate of the quantity, by a difference."""
        d = 1e-4 * self.length
        return np.asarray((self.value(tau + d) - self.value(tau - d)) / (2 * d))


PATIENCE = 50_000
"""Steps without a crossing after which a motion is given up."""
FEWEST, MOST = 256, 16_384
"""Steps of a motion between two looks for crossings: each look costs as much as a thousand."""
ROOM = 3 * 2**20
"""Coefficients of all motions between two looks, 24 MiB: up to 32 the memory of the last ones is
used again, and what takes more is twice as slow."""
START_SHARE = 1e-9
"""A crossing sooner than this part of the first step is the start itself."""
FOREVER = 1e12
"""How long a motion is followed where nobody says it."""


@dataclass(eq=False)
class SectionPassages:
    """Crossings as they are found, start by start; its arrays and lists are filled in.  States are
    ``width`` wide; of motions ``alone`` there are outputs (k, m) instead, and drifts."""

    wanted: int
    direction: int
    until: float
    progress: Callable[[float], Any] | None
    count: np.ndarray
    idle: np.ndarray
    reached: np.ndarray
    low: np.ndarray
    high: np.ndarray
    fastest: np.ndarray
    parts: dict[int, list[tuple[np.ndarray, np.ndarray, np.ndarray]]]
    width: int
    alone: dict[int, tuple[np.ndarray, Mapping[str, Any]]] = field(default_factory=dict)
    touches: list[tuple[int, float]] = field(default_factory=list)
    errors: dict[int, VoronecError] = field(default_factory=dict)
    notes: dict[int, tuple[str, ...]] = field(default_factory=dict)
    samples: dict[int, list[StepSamples]] = field(default_factory=dict)
    steps: int = 0
    interrupted: bool = False
    strict: bool = True

    @classmethod
    def empty(
        cls, motions: Many, wanted: int, direction: int, until: float | None, progress: Any
    ) -> SectionPassages:
        """Nothing passed yet."""
        starts = len(motions)

        def nothing() -> np.ndarray:
            return np.full(starts, np.nan)

        return cls(
            wanted=wanted,
            direction=direction,
            until=FOREVER if until is None else number(until, "until"),
            progress=progress,
            count=np.zeros(starts, dtype=int),
            idle=np.zeros(starts, dtype=int),
            reached=nothing(),
            low=nothing(),
            high=nothing(),
            fastest=nothing(),
            parts={i: [] for i in range(starts)},
            width=motions.states.shape[1],
        )

    def put(self, i: int, t: np.ndarray, states: np.ndarray, speed: np.ndarray) -> None:
        """Further crossings of start i, no more than are wanted."""
        room = self.wanted - int(self.count[i])
        t, states, speed = t[:room], states[:room], speed[:room]
        if len(t):
            self.parts[i].append((t, states, speed))
            self.count[i] += len(t)
            self.idle[i] = 0

    def enter_samples(self, i: int, samples: Sequence[StepSamples], width: int) -> None:
        """Samples of steps of start i, whose states are the first entries of theirs."""
        self.samples.setdefault(i, []).extend(part.narrow(width) for part in samples)

    def cut(self, i: int, count: int) -> None:
        """Keep the first crossings of start i alone."""
        t, states, speed = (np.concatenate(column) for column in zip(*self.parts[i], strict=True))
        self.parts[i] = [(t[:count], states[:count], speed[:count])]
        self.count[i] = count

    def note_range(self, i: int, time: float, steps: int, found: Sequence[float]) -> None:
        """How far start i came; the range of the quantity on the way and its largest rate."""
        low, high, fastest = found
        self.reached[i] = time
        self.idle[i] += steps
        self.low[i], self.high[i] = np.fmin(self.low[i], low), np.fmax(self.high[i], high)
        self.fastest[i] = np.fmax(self.fastest[i], fastest)

    def over(self, i: int) -> bool:
        """Whether start i has all it needs, failed, or is given up."""
        full = self.count[i] >= self.wanted or self.idle[i] > PATIENCE
        return bool(full or i in self.errors or self.reached[i] >= self.until)

    def tell(self, sound: Sequence[int]) -> None:
        """Report the fraction that is done."""
        if self.progress is not None:
            shares = [1.0 if self.over(i) else self.count[i] / self.wanted for i in sound]
            self.progress(float(np.mean(shares)))

    def ends(self, i: int, wrong: Mapping[int, VoronecError]) -> str:
        """How start i ended, in words."""
        if i in wrong or i in self.errors:
            return "failed"
        if self.count[i] >= self.wanted:
            return "complete"
        if not self.over(i):
            return "stopped by hand"
        return f"no more crossings up to t = {self.reached[i]:.6g}"

    def join(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Start, t, states, speed of all crossings."""
        start = np.repeat(np.arange(len(self.count)), self.count)
        parts = [part for i in range(len(self.count)) for part in self.parts[i]]
        t = np.concatenate([np.empty(0), *(p[0] for p in parts)])
        states = np.concatenate([np.empty((0, self.width)), *(p[1] for p in parts)])
        speed = np.concatenate([np.empty(0), *(p[2] for p in parts)])
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
        left = [passages.wanted - passages.count[i] for i in self.under_way(ta.place).values()]
        done = int(passages.count.sum())
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
            paths = Paths(output.times, lanes.winding.whole_series(output.tcs))
            collapsed = np.flatnonzero(lanes.steps.has_collapsed).tolist()
            trusted = {k: _trusted_until(output.times[:, k]) for k in collapsed}
            self.collect(busy, paths, trusted)
        for k, i in busy.items():
            if output is None:
                passages.note_range(i, ta.high[k], max(int(ta.latest.taken[k]), 1), (np.nan,) * 3)
            broken = not ta.alive[k]
            if broken or lanes.steps.doubtful[k]:
                why = INFINITE if broken else SINGULAR_PLACE
                errors[k] = break_error(why, passages.reached[i], lanes.states[k])
            elif passages.over(i):
                self.ends[k] = ta.high[k]
        passages.tell(self.motions.sound)
        return errors

    def collect(self, busy: Mapping[int, int], paths: Paths, trusted: Mapping[int, float]) -> None:
        """Take in the crossings of the lanes that carry motions, each as far as it is trusted."""
        motions, watch, passages = self.motions, self.watch, self.passages

        def plane(t: np.ndarray, states: np.ndarray, lane: np.ndarray) -> np.ndarray:
            own = motions.values[self.rows[lane]]
            return watch.function(t, states, np.broadcast_to(own, (len(states), own.shape[-1])))

        found = zeros(paths, plane, watch.needed, passages.direction)
        begins = paths.times[0] == motions.time
        after = np.where(begins, motions.time + START_SHARE * paths.lengths[0], -np.inf)
        for k, i in busy.items():
            _keep(passages, watch.width, found, k, i, after[k], trusted.get(k, np.inf))
            seen = (found.low[k], found.high[k], found.fastest[k])
            passages.note_range(i, paths.times[-1, k], len(paths.lengths), seen)
            passages.enter_samples(i, [paths.first_step(k)], watch.width)


def _trusted_until(times: np.ndarray) -> float:
    """The time at which a motion, by the ends of its steps, comes to a singular place."""
    lengths = np.abs(np.diff(times))
    short = lengths < COLLAPSE_RATIO * np.maximum.accumulate(lengths)
    return float(times[int(np.argmax(short))]) if short.any() else float(times[0])


def _keep(
    passages: SectionPassages, width: int, found: Zeros, lane: int, i: int, after: float,
    until: float = np.inf,
) -> None:  # fmt: skip
    take = (found.lane == lane) & (found.t > after) & (found.t < until)
    room = passages.wanted - int(passages.count[i])
    last = found.t[take][:room][-1] if len(found.t[take]) >= room else np.inf
    passages.touches.extend((i, t) for k, t in found.touches if k == lane and after < t <= last)
    passages.put(i, found.t[take], found.states[take][:, :width], found.speed[take])


def pass_one_by_one(
    motions: Many, watch: SectionWatch, passages: SectionPassages, method: str, tol: float
) -> None:
    """Follow the motions one by one with DOP853; crossings are sought on its interpolant."""
    try:
        for i in motions.sound:
            _follow(motions, watch, passages, method, tol, i)
            passages.tell(motions.sound)
    except KeyboardInterrupt:
        passages.interrupted = True


def _follow(
    motions: Many, watch: SectionWatch, passages: SectionPassages, method: str, tol: float, i: int
) -> None:
    values, end = motions.values[i], passages.until

    def plane(t: np.ndarray, states: np.ndarray, _lane: np.ndarray) -> np.ndarray:
        return watch.function(t, states, np.broadcast_to(values, (len(states), len(values))))

    begin, after = watch.begin(motions, [i])[0], np.inf
    everything, sampler = np.arange(len(begin)), StepSampler()
    sizes, crosses = StepSizes.of(1), motions.divisor_watch(values, 0.0)
    try:
        for steps in _stretches(method, watch.program, begin, values, (motions.time, end), tol):
            good = list[Stride]()
            for step in steps:
                if step.end != end:  # the last one is cut
                    sizes.note(0, step.end - step.start, step.end - step.start)
                sampler.take(step.start, step.end, step.at)
                states = np.stack([begin, step.state])[:, : watch.width]
                ends = np.array([step.start, step.end]), states
                if sizes.has_collapsed[0] or (crosses is not None and crosses(*ends)):
                    break
                good.append(step)
                begin = step.state
            if good:
                paths = _as_polynomials(good)
                after = min(after, motions.time + START_SHARE * float(paths.lengths[0, 0]))
                found = zeros(paths, plane, everything, passages.direction)
                _keep(passages, watch.width, found, 0, i, after)
                passages.steps += len(good)
                seen = found.low[0], found.high[0], found.fastest[0]
                passages.note_range(i, good[-1].end, len(good), seen)
            if passages.over(i):
                return
            if len(good) < len(steps):
                raise break_error(SINGULAR_PLACE, steps[len(good)].start, begin)
    except IntegrationError as error:
        reason, time = str(error).partition(" after")[0], float(error.time or 0.0)
        state = np.array(np.asarray(error.state)[: watch.width])
        what = f"{reason} after t = {time:.12g}"
        passages.errors[i] = motions.error(i, what, FEWER, time, state)
    finally:
        passages.enter_samples(i, StepSamples.of(sampler.rows), watch.width)


TOGETHER = 32
"""So many steps of scipy are looked at together."""


def _stretches(
    method: str, program: Program, state: np.ndarray, values: np.ndarray, span: tuple[float, float],
    tol: float,
) -> Iterator[Sequence[Stride]]:  # fmt: skip
    """The steps of DOP853, some together; ``IntegrationError`` where it cannot go on."""
    from voronec.motion.steppers import Loop, scales_of

    loop, grid = METHODS[method].loop, np.array(span)
    problem = Problem(program, state, values.tolist(), tol, dense=True)
    if loop is None:
        stepper = dop853_steps(problem, grid)
    else:
        stepper = Loop.of(loop(program), problem, grid, scales_of(problem), hoist(program))
    time, good, held, failure = span[0], state, list[Stride](), ""
    while time != span[1] and not failure:
        try:
            with np.errstate(all="ignore"):
                found = stepper.advance()
        except IntegratorFailure as halted:
            failure = str(halted)
        else:
            held += found.strides if isinstance(found, Segment) else [found]
            time, good = found.end, found.state
        if len(held) >= TOGETHER or failure or time == span[1]:
            yield held
            held = []
    if failure:
        raise break_error(failure, time, good)


def _as_polynomials(steps: Sequence[Stride]) -> Paths:
    """The interpolants of steps, polynomials of degree seven, by their values at eight points."""
    nodes = np.linspace(0.0, 1.0, 8)
    times = np.array([steps[0].start, *(step.end for step in steps)], dtype=float)
    lengths = np.diff(times)
    powers = np.vander(nodes, increasing=True)
    with np.errstate(all="ignore"):  # what is beyond doubles is told elsewhere
        values = [step.at(step.start + h * nodes) for step, h in zip(steps, lengths, strict=True)]
        scaled = np.swapaxes(np.linalg.solve(powers, np.array(values)), 1, 2)
        series = scaled / lengths[:, None, None] ** np.arange(8)
    return Paths(times[:, None], series[..., None])

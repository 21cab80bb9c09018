"""Following motions from one passage through a surface to the next."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.errors import IntegrationError, VoronecError
from voronec.flow.batches import (
    PASSED,
    SINGULAR,
    Lanes,
    StepSizes,
    note_step,
    strides,
)
from voronec.flow.steppers.run import COLLAPSE, INFINITE
from voronec.flow.vocabulary import number
from voronec.flow.zeros import Paths, Zeros, zeros

if TYPE_CHECKING:
    from voronec.flow.many import Many
    from voronec.flow.sections import Watch

__all__ = ["Passages", "pass_lanes", "pass_scipy"]

PATIENCE = 50_000
"""Steps without a crossing after which a motion is given up."""
FEWEST, MOST = 256, 4096
"""Steps between two looks for crossings: each look costs as much as some hundred steps."""
STARTING = 1e-9
"""A crossing sooner than this part of the first step is the start itself."""
FOREVER = 1e300


@dataclass(frozen=True, eq=False)
class Passages:
    """Crossings as they are found, start by start; its arrays and lists are filled in."""

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
    touches: list[tuple[int, float]] = field(default_factory=list)
    errors: dict[int, VoronecError] = field(default_factory=dict)
    steps: list[int] = field(default_factory=lambda: [0])
    interrupted: list[bool] = field(default_factory=lambda: [False])

    @classmethod
    def empty(
        cls, starts: int, wanted: int, direction: int, until: float | None, progress: Any
    ) -> Passages:
        """Nothing passed yet."""

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
        )

    def put(self, i: int, t: np.ndarray, states: np.ndarray, speed: np.ndarray) -> None:
        """Further crossings of start i, no more than are wanted."""
        room = self.wanted - int(self.count[i])
        t, states, speed = t[:room], states[:room], speed[:room]
        if len(t):
            self.parts[i].append((t, states, speed))
            self.count[i] += len(t)
            self.idle[i] = 0

    def cut(self, i: int, count: int) -> None:
        """Keep the first crossings of start i alone."""
        t, states, speed = (np.concatenate(column) for column in zip(*self.parts[i], strict=True))
        self.parts[i] = [(t[:count], states[:count], speed[:count])]
        self.count[i] = count

    def seen(self, i: int, time: float, steps: int, found: Sequence[float]) -> None:
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

    def tell(self, sound: list[int]) -> None:
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

    def joined(self, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Start, t, states, speed of all crossings."""
        start = np.repeat(np.arange(len(self.count)), self.count)
        parts = [part for i in range(len(self.count)) for part in self.parts[i]]
        t = np.concatenate([np.empty(0), *(p[0] for p in parts)])
        states = np.concatenate([np.empty((0, size)), *(p[1] for p in parts)])
        speed = np.concatenate([np.empty(0), *(p[2] for p in parts)])
        return start, t, states, speed


def pass_lanes(motions: Many, watch: Watch, passages: Passages, lanes: Lanes) -> None:
    """Follow the motions in heyoka's lanes; a lane whose motion is over takes the next one."""
    waiting = iter(motions.sound)
    holds: list[int | None] = [_load(lanes, k, waiting, motions) for k in range(lanes.width)]
    origin = lanes.integrator.time.copy()
    try:
        while any(i is not None for i in holds):
            _stretch(motions, watch, passages, lanes, holds, origin)
            for k, i in enumerate(holds):
                if i is not None and passages.over(i):
                    holds[k] = _load(lanes, k, waiting, motions)
                    origin[k] = motions.time
            passages.tell(motions.sound)
    except KeyboardInterrupt:
        passages.interrupted[0] = True


def _load(lanes: Lanes, lane: int, waiting: Iterator[int], motions: Many) -> int | None:
    """Put the next motion on a lane; where there is none, any sound one idles there."""
    i = next(waiting, None)
    k = motions.sound[0] if i is None else i
    lanes.load(lane, motions.states[k], motions.values[k], motions.time)
    return i


def _stretch(
    motions: Many,
    watch: Watch,
    passages: Passages,
    lanes: Lanes,
    holds: list[int | None],
    origin: np.ndarray,
    careful: bool = False,
) -> None:
    """Some hundreds or thousands of steps of all lanes, and the crossings in them; or, where steps
    are made too long by coefficients that vanish, ``careful`` ones, each looked at before."""
    ta = lanes.integrator
    begin, state = tuple(part.copy() for part in ta.dtime), ta.state.copy()
    before, limit = ta.time.copy(), 1 if careful else _steps_ahead(passages, holds)
    idle = np.array([i is None for i in holds])
    # a lane that idles stays where it is as far as possible
    ends = np.where(idle, before + 1e-300, passages.until)
    ends = np.maximum(ends, before)
    longest = np.full(lanes.width, np.inf)
    if (fresh := ~idle & (careful | (before == origin))).any():
        longest = np.where(fresh, lanes.first_steps(ends - before), np.inf)
        limit = 1 if np.isfinite(longest).any() else limit
    output = ta.propagate_until(
        ends.tolist(), max_steps=limit, max_delta_t=longest.tolist(), c_output=True
    )[0]
    taken = [r[3] for r in ta.propagate_res]
    if not careful and lanes.look_back(begin, state).any():
        ta.set_dtime(*begin)
        ta.state[:] = state
        for _ in range(max(taken)):
            if not any(i is not None and passages.over(i) for i in holds):
                _stretch(motions, watch, passages, lanes, holds, origin, careful=True)
        return
    lanes.note_steps()
    passages.steps[0] += sum(n for n, i in zip(taken, holds, strict=True) if i is not None)
    busy = [k for k, i in enumerate(holds) if i is not None]
    broken = [k for k in busy if not np.isfinite(ta.state[:, k]).all()]
    stuck = [k for k in busy if taken[k] == limit and _stuck(ta.time[k], before[k], origin[k])]
    passed = [k for k in busy if lanes.steps.collapsed(k, SINGULAR)]
    if output is not None:
        series = output.tcs * lanes.units[:, None] if lanes.scaled else output.tcs
        trusted = [
            _trusted(output.times[:, k]) if k in passed else np.inf for k in range(len(holds))
        ]
        _collect(motions, watch, passages, Paths(output.times, series), holds, origin, trusted)
    for k in busy:
        if k in passed and k not in broken:
            _fail(motions, passages, holds[k], lanes, k, PASSED)
        elif k in broken or k in stuck:
            _fail(motions, passages, holds[k], lanes, k, INFINITE if k in broken else COLLAPSE)
        elif output is None and (i := holds[k]) is not None:
            passages.seen(i, ta.time[k], max(taken[k], 1), (np.nan,) * 3)


def _stuck(now: float, before: float, origin: float) -> bool:
    return bool(now - before <= 1e-13 * max(abs(now - origin), 1e-3))


def _steps_ahead(passages: Passages, holds: list[int | None]) -> int:
    """So many steps that the motion nearest to its end is not carried far beyond it."""
    left = [passages.wanted - passages.count[i] for i in holds if i is not None]
    done = int(passages.count.sum())
    each = passages.steps[0] / done if done else FEWEST
    return int(np.clip(1.1 * each * min(left) + 16, FEWEST, MOST))


def _collect(
    motions: Many,
    watch: Watch,
    passages: Passages,
    paths: Paths,
    holds: list[int | None],
    origin: np.ndarray,
    trusted: Sequence[float],
) -> None:
    rows = np.array([motions.sound[0] if i is None else i for i in holds])

    def plane(t: np.ndarray, states: np.ndarray, lane: np.ndarray) -> np.ndarray:
        values = np.broadcast_to(motions.values[rows[lane]], (*states.shape[:1], _width(motions)))
        return watch.function(t, states, values)

    found = zeros(paths, plane, watch.needed, passages.direction)
    first = STARTING * paths.lengths[0]
    for k, i in enumerate(holds):
        if i is not None:
            _keep(passages, found, k, i, origin[k] + first[k], trusted[k])
            seen = (found.low[k], found.high[k], found.fastest[k])
            passages.seen(i, paths.times[-1, k], len(paths.lengths), seen)


def _width(motions: Many) -> int:
    return motions.values.shape[1]


def _trusted(times: np.ndarray) -> float:
    """The time at which a motion, by the ends of its steps, comes to a singular place."""
    lengths = np.abs(np.diff(times))
    short = lengths < SINGULAR * np.maximum.accumulate(lengths)
    return float(times[int(np.argmax(short))]) if short.any() else float(times[0])


def _keep(
    passages: Passages, found: Zeros, lane: int, i: int, after: float, until: float = np.inf
) -> None:
    take = (found.lane == lane) & (found.t > after) & (found.t < until)
    room = passages.wanted - int(passages.count[i])
    last = found.t[take][:room][-1] if len(found.t[take]) >= room else np.inf
    passages.touches.extend((i, t) for k, t in found.touches if k == lane and after < t <= last)
    passages.put(i, found.t[take], found.states[take], found.speed[take])


def _fail(
    motions: Many, passages: Passages, i: int | None, lanes: Lanes, lane: int, reason: str
) -> None:
    if i is None:
        return
    time = passages.reached[i] if np.isfinite(passages.reached[i]) else motions.time
    passages.errors[i] = _told(motions, i, reason, float(time), lanes.states[lane])
    # a lane that is not finite would stop all others
    lanes.load(lane, motions.states[i], motions.values[i], motions.time)


def _told(motions: Many, i: int, reason: str, time: float, state: np.ndarray) -> IntegrationError:
    name = motions.vocabulary.equations.system.name
    return IntegrationError(
        f"system '{name}', start {i}: {reason} after t = {time:.12g}; ask for fewer crossings, or "
        "use another chart",
        time,
        np.array(state),
    )


def pass_scipy(motions: Many, watch: Watch, passages: Passages, tol: float) -> None:
    """Follow the motions one by one with DOP853; crossings are sought on its interpolant."""
    try:
        for i in motions.sound:
            _follow(motions, watch, passages, tol, i)
            passages.tell(motions.sound)
    except KeyboardInterrupt:
        passages.interrupted[0] = True


def _follow(motions: Many, watch: Watch, passages: Passages, tol: float, i: int) -> None:
    values = motions.values[i]

    def plane(t: np.ndarray, states: np.ndarray, _lane: np.ndarray) -> np.ndarray:
        return watch.function(t, states, np.broadcast_to(values, (len(states), len(values))))

    end = passages.until if passages.until < FOREVER else motions.time + 1e12
    size, after, rise = len(motions.states[i]), None, np.inf
    everything, lane = np.arange(size), np.zeros(1, dtype=int)
    last = float(plane(np.array([motions.time]), motions.states[i : i + 1], lane)[0])
    sizes = StepSizes.of(1)
    try:
        run = strides(motions.program, motions.states[i], values, motions.time, end, tol)
        for method in run:
            passages.steps[0] += 1
            note_step(sizes, method)
            if sizes.collapsed(0, SINGULAR):
                raise IntegrationError(
                    f"{PASSED} after t = {method.t_old:.12g}", method.t_old, method.y
                )
            now = float(plane(np.array([method.t]), method.y[None], lane)[0])
            if after is None:
                after = motions.time + STARTING * (method.t - motions.time)
            # no look where the quantity could not come to zero at twice its latest rate
            near = min(abs(last), abs(now)) <= 2 * max(abs(now - last), rise)
            rise = abs(now - last)
            rate = rise / (method.t - method.t_old)
            if near or last * now <= 0:
                found = zeros(_as_polynomial(method), plane, everything, passages.direction)
                _keep(passages, found, 0, i, after)
            passages.seen(i, method.t, 1, (min(last, now), max(last, now), rate))
            last = now
            if passages.over(i):
                return
    except IntegrationError as error:
        reason = str(error).partition(" after")[0]
        passages.errors[i] = _told(
            motions, i, reason, float(error.time or 0.0), np.asarray(error.state)
        )


def _as_polynomial(method: Any) -> Paths:
    """The step's own interpolant, a polynomial of degree seven, by its values at eight points."""
    dense = method.dense_output()
    h = method.t - method.t_old
    nodes = np.linspace(0.0, 1.0, 8)
    values = dense(method.t_old + h * nodes)
    coefficients = np.linalg.solve(np.vander(nodes, increasing=True), values.T).T
    scaled = coefficients / h ** np.arange(8)
    times = np.array([[method.t_old], [method.t]])
    return Paths(times, scaled[None, :, :, None])

"""Where a quantity vanishes along motions that are known as polynomials in the time.

A Taylor step is a small part (about e^-2) of the radius of convergence, so over one step all but
the first few terms are small; a few samples a step see every change of sign that lies further
apart than the step resolves.  What touches zero between samples is looked for at the extrema.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

__all__ = ["Paths", "Zeros", "zeros"]

SAMPLES = 4
"""Looks at each polynomial."""
NEAR = 0.25
"""An extremum whose parabola comes nearer to zero than this part of its rise is looked into."""
TOUCH = 1e-10
"""An extremum this near to zero, relative to the largest value seen, touches it."""
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)

Quantity = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""``(t, states (m, n), lane (m,))`` to values (m,)."""


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

    def sampled(self, needed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Times (m, lanes) and states (n, lanes, m), m = SAMPLES s + 1; only needed entries."""
        steps, size, order, lanes = self.series.shape
        h = self.lengths
        powers = np.ones((steps, order, lanes))
        np.cumprod(np.broadcast_to(h[:, None], (steps, order - 1, lanes)), 1, out=powers[:, 1:])
        terms = self.series[:, needed] * powers[:, None]
        parts = np.arange(SAMPLES)[:, None] / SAMPLES
        values = parts ** np.arange(order) @ terms
        states = np.zeros((size, lanes, SAMPLES * steps + 1))
        states[needed, :, :-1] = values.transpose(1, 3, 0, 2).reshape(
            len(needed), lanes, SAMPLES * steps
        )
        states[needed, :, -1] = terms[-1].sum(axis=1)
        times = self.times[:-1, None] + h[:, None] * parts
        return np.concatenate([times.reshape(-1, lanes), self.times[-1:]]), states

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
    times, states = paths.sampled(needed)
    lanes = times.shape[1]
    which = np.arange(lanes)
    values = np.stack([quantity(times[:, i], states[:, i].T, which[i]) for i in range(lanes)], 1)
    size = float(np.nanmax(np.abs(values), initial=0.0)) or 1.0

    def close(step: np.ndarray, lane: np.ndarray) -> _Close:
        return _Close.of(paths, quantity, needed, step, lane)

    a, b = values[:-1], values[1:]
    with np.errstate(all="ignore"):  # a lane that idles takes steps of no length
        rates = np.abs(b - a) / np.diff(times, axis=0)
    change = _crossed(a, b, direction)
    row, lane = np.nonzero(change)
    step, left = row // SAMPLES, (row % SAMPLES) / SAMPLES
    h = paths.lengths[step, lane]
    brackets = [(step, lane, left * h, (left + 1 / SAMPLES) * h)]
    more, touches = _turns(close, paths, values, direction, size)
    brackets += more
    step, lane, lower, upper = (np.concatenate(x) for x in zip(*brackets, strict=True))
    order = np.lexsort((paths.times[step, lane] + lower, lane))
    step, lane = step[order], lane[order]
    look = close(step, lane)
    tau = look.root(lower[order], upper[order])
    return Zeros(
        lane=lane,
        t=look.begin + tau,
        states=_horner(paths.terms(step, lane, np.arange(look.size)), tau).T.copy(),
        speed=look.speed(tau),
        touches=touches,
        low=np.fmin.reduce(values, axis=0),
        high=np.fmax.reduce(values, axis=0),
        fastest=np.fmax.reduce(rates, axis=0),
    )


def _crossed(a: np.ndarray, b: np.ndarray, direction: int) -> np.ndarray:
    """Where a quantity passes zero from a to b; a zero at b counts, one at a does not."""
    up, down = (a < 0) & (b >= 0), (a > 0) & (b <= 0)
    return np.asarray(up | down if direction == 0 else (up if direction > 0 else down))


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

    def root(self, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        """The zero in each bracket: regula falsi (Illinois), bisection where that is slow."""
        a, b = lower, upper
        if not len(a):
            return a
        fa, fb = self.value(a), self.value(b)
        before = np.abs(b - a)
        for k in range(100):
            with np.errstate(all="ignore"):
                c = np.where(fb == fa, 0.5 * (a + b), b - fb * (b - a) / (fb - fa))
            outside = ~((c - a) * (c - b) <= 0)
            slow = np.zeros(len(a), dtype=bool)
            if k % 4 == 3:
                slow, before = np.abs(b - a) > 0.25 * before, np.abs(b - a)
            c = np.where((slow | outside) & (fb != 0), 0.5 * (a + b), np.where(fb == 0, b, c))
            fc = self.value(c)
            swap = fc * fb < 0
            done = (np.abs(c - b) <= 4e-16 * np.abs(upper)) | (fc == 0)
            # the end that stays loses half its weight, so that both ends move
            a, fa = np.where(swap, b, a), np.where(swap, fb, 0.5 * fa)
            b, fb = c, fc
            if done.all():
                break
        return np.asarray(b)

    def speed(self, tau: np.ndarray) -> np.ndarray:
        """The rate of the quantity, by a difference."""
        d = 1e-4 * self.length
        return np.asarray((self.value(tau + d) - self.value(tau - d)) / (2 * d))

    def lowest(
        self, lower: np.ndarray, upper: np.ndarray, sign: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Where sign * quantity is least between bounds, and its value: by the golden section."""
        a, b = lower, upper
        for _ in range(44):
            c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
            left = sign * self.value(c) < sign * self.value(d)
            a, b = np.where(left, a, c), np.where(left, d, b)
        best = 0.5 * (a + b)
        return best, sign * self.value(best)


Bracket = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def _turns(
    close: Callable[[np.ndarray, np.ndarray], _Close],
    paths: Paths,
    values: np.ndarray,
    direction: int,
    size: float,
) -> tuple[list[Bracket], tuple[tuple[int, float], ...]]:
    """Pairs of zeros between samples, where the quantity comes near to zero and turns back.

    The extremum lies between the neighbours of its least sample; these may belong to two steps, so
    each half is looked into by itself.
    """
    sign = np.sign(values[1:-1])
    a, m, b = (sign * x for x in (values[:-2], values[1:-1], values[2:]))
    bend = a - 2 * m + b
    turning = (sign != 0) & (a >= m) & (b >= m) & (a > 0) & (b > 0) & (bend > 0)
    with np.errstate(all="ignore"):
        depth = (a - b) ** 2 / (8 * bend)
    row, lane = np.nonzero(turning & (m - depth < NEAR * np.maximum(a - m, b - m)))
    brackets: list[Bracket] = []
    touches: dict[tuple[int, int], float] = {}
    nothing = TOUCH * size
    for half in (0, 1):
        place = row + half
        step, h = place // SAMPLES, paths.lengths[place // SAMPLES, lane]
        lower = (place % SAMPLES) / SAMPLES * h
        upper = lower + h / SAMPLES
        if not len(row):
            break
        s = sign[row, lane]
        best, least = close(step, lane).lowest(lower, upper, s)
        times = paths.times[step, lane] + best
        for k in np.nonzero(np.abs(least) <= nothing)[0]:
            touches.setdefault((int(lane[k]), int(row[k])), float(times[k]))
        through = least < -nothing
        # towards zero first, away from it afterwards
        for first, want in ((lower, -s), (best, s)):
            second = best if first is lower else upper
            take = through & ((direction == 0) | (want == direction))
            brackets.append((step[take], lane[take], first[take], second[take]))
    return brackets, tuple((k[0], t) for k, t in touches.items())

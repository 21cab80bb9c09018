"""Samples of the steps of a run, for its check: states at nodes of a step, from what the integrator
itself says of them between its ends.

The nodes are those of Gauss, Legendre and Lobatto, by which polynomials up to degree 15 are
integrated exactly.  Of a long run some steps are taken, spread over it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

_RIGHT = (0.3631174638261782, 0.6771862795107377, 0.8997579954114602, 1.0)
NODES = (np.array([*(-x for x in reversed(_RIGHT)), 0.0, *_RIGHT]) + 1) / 2
"""Where states are looked at in a step, as parts of it; both ends are among them."""
WIDTH = len(NODES)
MOST = 128
"""Samples that are kept of a run that goes step by step."""
FIRST, LATER, WIDER = 64, 16, 4
"""Of many steps in a compiled loop the first are sampled, and some whenever there are so many times
as many of them."""

Rates = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Times (k,) and states (k, n) to the rates (k, n) of the variables; nan where undefined."""


def spread(size: int, most: int) -> np.ndarray:
    """As many of so many indices as may be, evenly spread, each once."""
    return np.arange(size) if size <= most else np.arange(most) * (size - 1) // max(most - 1, 1)


@dataclass(frozen=True)
class StepSamples:
    """Some steps of a run: ``times`` (s, WIDTH) at the nodes of each, and ``states`` (s, WIDTH, n).

    ``rates`` are those that were integrated, where the run does not say so as a whole.  Those that
    are ``apart`` are of several motions, or may have other branches of angles than the run.
    """

    times: np.ndarray
    states: np.ndarray
    rates: Rates | None = None
    apart: bool = False

    @classmethod
    def of(cls, parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[StepSamples, ...]:
        """Those of several parts of a run; none where there are no steps."""
        if not parts:
            return ()
        return (cls(np.concatenate([t for t, _ in parts]), np.concatenate([x for _, x in parts])),)

    @classmethod
    def of_pieces(cls, parts: Iterable[StepSamples]) -> tuple[StepSamples, ...]:
        """Those of the pieces of a run, no more than ``MOST`` of them where one right side holds
        for all."""
        parts = tuple(parts)
        if len(parts) < 2 or any(part.rates or part.apart for part in parts):
            return parts
        (whole,) = cls.of([(part.times, part.states) for part in parts])
        return (whole.pick(spread(len(whole.times), MOST)),)

    def narrow(self, width: int) -> StepSamples:
        """The samples without what stands behind the first entries of their states."""
        return replace(self, states=self.states[..., :width])

    def through(self, change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> StepSamples:
        """In other variables: ``change`` takes times (k,) and states (k, n) to states (k, m)."""
        flat = change(self.times.ravel(), self.states.reshape(self.times.size, -1))
        states = flat.reshape(*self.times.shape, -1)
        return StepSamples(self.times, states, self.rates, self.apart)

    def within(
        self, first: float, last: float, jumps: Sequence[tuple[float, float]] = ()
    ) -> StepSamples:
        """Those from one instant to another that meet none of some spans.

        Of the ends of a step the later one is moved into it by a rounding: parameters that change
        there have the value that they had in the step.
        """
        one, two = self.times[:, 0], self.times[:, -1]
        low, high = np.minimum(one, two), np.maximum(one, two)
        near = 4 * np.spacing(max(abs(first), abs(last)))
        kept = (low >= min(first, last) - near) & (high <= max(first, last) + near)
        for a, b in jumps:
            kept &= (a > high) | (b < low)
        inner = np.minimum(self.times, np.nextafter(high, -np.inf)[:, None])
        trimmed = StepSamples(inner, self.states, self.rates, self.apart)
        return trimmed if kept.all() else trimmed.pick(kept)

    def pick(self, which: Any) -> StepSamples:
        """Some of them."""
        return StepSamples(self.times[which], self.states[which], self.rates, self.apart)


OwnedSamples = tuple[np.ndarray, StepSamples]
"""Samples (s, ...) and whose they are (s,), by its position among many motions."""


def by_owner(parts: Iterable[StepSamples]) -> list[OwnedSamples]:
    """The samples of one motion, as those of the first of many."""
    return [(np.zeros(len(part.times), dtype=int), part) for part in parts]


@dataclass
class StepSampler:
    """What takes samples step by step, ``rows`` of them: each, until there are too many; then every
    second one is dropped, and taken from there on."""

    rows: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    every: int = 1
    count: int = 0

    def take(self, start: Any, end: Any, at: Callable[[np.ndarray], np.ndarray]) -> None:
        """A step, whose states at times (k,) ``at`` gives (k, n)."""
        self.count += 1
        if self.count % self.every:
            return
        begin = float(start)
        times = begin + (float(end) - begin) * NODES
        with np.errstate(all="ignore"):  # what is beyond doubles is told elsewhere
            self.rows.append((times[None], at(times).astype(float)[None]))
        if len(self.rows) > MOST:
            del self.rows[::2]
            self.every *= 2


def burst(steps: int) -> tuple[int, bool]:
    """How many steps of a compiled loop come next, after so many, and whether they are sampled."""
    if steps < FIRST:
        return FIRST - steps, True
    mark = FIRST
    while steps >= WIDER * mark:
        mark *= WIDER
    sampled = steps < mark + LATER and mark > FIRST
    return (mark + LATER if sampled else WIDER * mark) - steps, sampled


def series_samples(
    ends: np.ndarray, lengths: np.ndarray, series: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Samples of Taylor steps (s,) to the times ``ends``, with coefficients (s, n, order + 1)."""
    times = ends[:, None] + lengths[:, None] * (NODES - 1)
    return times, series_states(lengths, series, NODES)


def series_states(lengths: np.ndarray, series: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """The states (s, k, n) of Taylor steps of some lengths (s,), with coefficients
    (s, n, order + 1), after ``parts`` (k,) of them."""
    numbers = np.arange(series.shape[-1])
    with np.errstate(all="ignore"):
        scaled = series * lengths[:, None, None] ** numbers
        return np.asarray((scaled @ parts ** numbers[:, None]).transpose(0, 2, 1))

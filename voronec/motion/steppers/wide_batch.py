"""heyoka's batch integrator made wider: any number of motions, in loads of its lanes.

What Python does before and after steps it does for hundreds of motions at once then, at next to no
cost for each.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Place = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Where motions stand: the time, a sum of two doubles (width,) each, and the states (n, width)."""


@dataclass(frozen=True, eq=False)
class LatestSteps:
    """The latest steps of each motion (width,): how many were ``taken``, the ``shortest`` and the
    ``longest`` of those that were not cut, how long the ``last`` was, and which motions came to the
    ``end`` that they were given."""

    taken: np.ndarray
    shortest: np.ndarray
    longest: np.ndarray
    last: np.ndarray
    end: np.ndarray

    @classmethod
    def none(cls, width: int) -> LatestSteps:
        """No steps."""
        taken, end = np.zeros(width, dtype=int), np.zeros(width, dtype=bool)
        return cls(taken, np.full(width, np.inf), np.zeros(width), np.zeros(width), end)


@dataclass(eq=False)
class WideBatch:
    """Motions with states (n, width) and parameters ``pars`` (p, width), at times ``high + low``
    (width,), carried by a compiled ``batch``, of whose lanes ``width`` is a multiple.

    A motion whose state is no longer finite stays where it is and disturbs no other: what was with
    it in a load, where heyoka stops then, goes again without it.
    """

    batch: Any
    state: np.ndarray
    pars: np.ndarray
    high: np.ndarray = field(init=False)
    low: np.ndarray = field(init=False)
    latest: LatestSteps = field(init=False)

    def __post_init__(self) -> None:
        self.high, self.low = np.zeros(self.width), np.zeros(self.width)
        self.latest = LatestSteps.none(self.width)

    @classmethod
    def of(cls, batch: Any, width: int) -> WideBatch:
        """So many motions, not yet loaded."""
        return cls(batch, *(np.ones((len(part), width)) for part in (batch.state, batch.pars)))

    @property
    def width(self) -> int:
        """How many motions there are."""
        return self.state.shape[1]

    @property
    def alive(self) -> np.ndarray:
        """Which motions (width,) have a finite state."""
        return np.asarray(np.isfinite(self.state).all(axis=0))

    @property
    def place(self) -> Place:
        """Where all motions stand, to ``return_to``."""
        return self.high.copy(), self.low.copy(), self.state.copy()

    def return_to(self, place: Place, which: Any = slice(None)) -> None:
        """Go back, with some motions."""
        high, low, state = place
        self.high[which], self.low[which] = high[which], low[which]
        self.state[:, which] = state[:, which]

    def set_time(self, time: float, which: Any = slice(None)) -> None:
        """The time of some motions."""
        self.high[which], self.low[which] = time, 0.0

    def loads(self, which: np.ndarray) -> Iterator[Any]:
        """Load the batch with some of the motions (width,), a few after others, as they stand: the
        positions of those in its lanes, where one takes the places of others that do not go."""
        batch, lanes = self.batch, self.batch.batch_size
        alike, times = (self.pars == self.pars[:, :1]).all(), self.high[which]
        together = not self.low[which].any() and (times == times[:1]).all()
        state, pars, begin = batch.state, batch.pars, times[:1].tolist()
        if alike:
            pars[:] = self.pars[:, :lanes]
        rows = which.reshape(-1, lanes)
        every = np.asarray(rows.all(axis=1)).tolist()
        for k in np.flatnonzero(rows.any(axis=1)).tolist():
            columns: Any = slice(lanes * k, lanes * (k + 1))
            if not every[k]:
                columns = lanes * k + np.where(rows[k], np.arange(lanes), int(np.argmax(rows[k])))
            if together:
                batch.set_time(*begin)
            else:
                batch.set_dtime(self.high[columns], self.low[columns])
            state[:] = self.state[:, columns]
            if not alike:
                pars[:] = self.pars[:, columns]
            yield columns

    def first_steps(self, spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The lengths (width,) of next steps, which lead no further than ``spans`` (width,), and
        their Taylor coefficients (n, order + 1, width); nothing moves."""
        series = np.full((len(self.state), self.batch.order + 1, self.width), np.nan)
        taken, limits = np.zeros(self.width), spans.tolist()
        for columns in self.loads(self.alive):
            own_limits = limits[columns] if isinstance(columns, slice) else spans[columns].tolist()
            self.batch.step(max_delta_t=own_limits, write_tc=True)
            series[:, :, columns] = self.batch.tc
            taken[columns] = self.batch.last_h
        return taken, series

    def along_grid(self, times: np.ndarray, longest: np.ndarray, **options: Any) -> np.ndarray:
        """Go along times (k,), from the first, at which all stand, by steps that are no longer than
        the ``longest`` (width,): states (k, n, width), no numbers where a motion does not come."""
        each = np.repeat(times[:, None], self.batch.batch_size, axis=1)
        rows = np.full((len(times), *self.state.shape), np.nan)
        for columns, limits in self._take_steps(np.full(self.width, times[-1]), longest):
            path = self.batch.propagate_grid(each, **limits, **options)
            rows[:, :, columns] = path[1] if isinstance(path, tuple) else path
        return rows

    def go_to(
        self, ends: np.ndarray, longest: np.ndarray, c_output: bool = False, **options: Any
    ) -> Any:
        """Go to times (width,); the continuous output, which there is of a single load alone: its
        motions stop where one of them breaks down."""
        output = None
        for columns, limits in self._take_steps(ends, longest, again=not c_output):
            output = self.batch.propagate_until(
                ends[columns].tolist(), c_output=c_output, **limits, **options
            )[0]
        return output

    def _take_steps(
        self, ends: np.ndarray, longest: np.ndarray, again: bool = True
    ) -> Iterator[tuple[Any, dict[str, Any]]]:
        """Load those that are not yet at their ends (width,): positions, and limits of the steps
        that are to be taken; where one breaks down the others of its load ``again``, or else all
        keep their lanes."""
        begin, lanes = self.place, self.batch.batch_size
        which = self.alive & ((self.high != ends) | (not again))
        self.latest, bounded = LatestSteps.none(self.width), bool(np.isfinite(longest).any())
        while which.any():
            notes: list[tuple[Any, Any, Any]] = []
            for columns in self.loads(which):
                yield columns, {"max_delta_t": longest[columns].tolist()} if bounded else {}
                notes.append((columns, self.batch.propagate_res, self.batch.last_h))
                self.state[:, columns] = self.batch.state
                self.high[columns], self.low[columns] = self.batch.dtime
            self._note(notes)
            broken = which & ~self.alive
            self.state[:, broken] = np.nan
            beside = np.repeat(broken.reshape(-1, lanes).any(axis=1), lanes)
            which = which & beside & ~broken & again
            self.return_to(begin, which)
        # a way along a grid may end an ulp beside it
        ulp = np.spacing(np.maximum(np.abs(begin[0]), np.abs(ends)))
        self.latest.end[:] = self.alive & (np.abs(self.high - ends) <= 4 * ulp)
        self.high = np.where(self.latest.end, ends, self.high)
        self.low[self.latest.end] = 0.0

    def _note(self, notes: list[tuple[Any, Any, Any]]) -> None:
        """Take down what heyoka says of steps."""
        every = np.arange(self.width)
        which = np.concatenate([every[columns] for columns, _, _ in notes])
        lengths = np.array([each[1:] for _, outcomes, _ in notes for each in outcomes])
        latest = self.latest
        latest.shortest[which], latest.longest[which] = np.abs(lengths[:, :2]).T
        latest.taken[which] = lengths[:, 2]
        latest.last[which] = np.concatenate([last for _, _, last in notes])

"""What is taken out of states that may be kept small, and units of those that may not.

A step of Taylor's method is as long as the largest state allows: one angle of 1e5 radians loosens
the tolerance of all the others by 1e5.  But where the right-hand side does not hold a state at all
(a quadrature), or holds it under sines and cosines only (an angle), what has grown can be taken
out of it between steps and added to the results: the motion of the others is the same.  What they
grow by until then is made up for by a finer tolerance.

For the same reason a state that sets out near an equilibrium, in a tiny unit of its own, must not
stay in that while it grows to ordinary size: where some unit is not 1, each step is looked at, and
units are set anew where states left them.  Where all are 1 at first, and a state grows far beyond
ordinary size, the motion is begun anew in units.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from voronec.equations.program import Program
from voronec.motion.steppers.units import ORDINARY, angles_among, units_next_to
from voronec.motion.tolerances import taylor_tolerance

__all__ = ["CHUNK", "LEAST", "SHORT", "TurnCount"]

CHUNK = 20_000
"""Steps between two looks at the keyboard."""
SHORT, LEAST, LARGE = 64, 32, 8.0
"""So many steps are taken at first where states wind; fewer, down to the least, where in these they
grow to more than so many times the others, and more, up to CHUNK, where they hardly grow."""
TURN = 2 * np.pi
COARSE = float(np.ldexp(np.round(np.ldexp(TURN, 30)), -30))
"""A turn in 33 bits, whose small multiples are exact; FINE is the rest of it."""
FINE = 2 * (float(np.float64(np.pi) - COARSE / 2)) + 2.4492935982947064e-16


@dataclass
class TurnCount:
    """What was taken out of the states: turns of ``angles``, all of ``quadratures`` (positions).

    The states that are kept ``small``, by their positions, and the ``others`` are in ``units``
    (n,), or (n, lanes), of their own; those of angles are 1.  Where the motion is ``scaled``, some
    unit is not 1: states beyond ``bounds`` have outgrown theirs, and ``peaks`` are the largest
    ones in so many ``looks``.
    A quadrature is kept as the sum of two doubles, so nothing is lost when small steps are added
    to a large sum.
    """

    quadratures: np.ndarray
    angles: np.ndarray
    units: np.ndarray
    scaled: bool = False
    high: np.ndarray = field(init=False)
    low: np.ndarray = field(init=False)
    small: np.ndarray = field(init=False)
    others: np.ndarray = field(init=False)
    bounds: np.ndarray = field(init=False)
    peaks: np.ndarray = field(init=False)
    looks: int = 0

    def __post_init__(self) -> None:
        self.high, self.low = np.zeros(self.units.shape), np.zeros(self.units.shape)
        self.small = np.union1d(self.quadratures, self.angles)
        self.others = np.setdiff1d(np.arange(len(self.units)), self.small)
        self.bounds, self.peaks = np.ones(self.units.shape), np.ones(self.units.shape)
        self.measure(self.units.copy())

    @classmethod
    def of(
        cls, program: Program, levels: Program | None, units: np.ndarray, scaled: bool
    ) -> TurnCount:
        """The states that may be kept small, though ``levels`` are looked at on the way."""
        blocks = (program.derivative, *([levels.extras] if levels is not None else []))
        held = set().union(*(b.symbols for b in blocks))
        angles = angles_among(program.state, blocks)
        return cls(
            np.array([i for i, s in enumerate(program.state) if s not in held], dtype=int),
            np.array(angles, dtype=int),
            units.copy(),
            scaled,
        )

    @property
    def is_needed(self) -> bool:
        """Whether there is a state that may be kept small."""
        return len(self.small) > 0

    def tolerance(self, tol: float) -> float:
        """The one of steps, for one of a run: finer by a term, and by another for what states that
        are kept small, or have units, loosen it by while they grow, LARGE at most."""
        return taylor_tolerance(tol, 2 if self.is_needed or self.scaled else 1)

    def reset(self, which: Any = slice(None)) -> None:
        """Nothing is taken out, or nothing of some lanes."""
        self.high[..., which] = self.low[..., which] = 0.0

    def measure(self, units: np.ndarray, which: Any = slice(None)) -> None:
        """Measure states, or those of some lanes, in other units."""
        for sums in (self.high, self.low):
            sums[..., which] = sums[..., which] * self.units[..., which] / units
        self.units[..., which], self.peaks[..., which] = units, 1.0
        bounds = LARGE * np.where(units == 1, ORDINARY, 1.0)
        # quadratures are taken out now and then: they may grow until then
        bounds[self.quadratures] *= LEAST
        bounds[self.angles] = np.inf
        self.bounds[..., which] = bounds

    def outgrown(self, states: np.ndarray) -> np.ndarray:
        """Which motions, whose units are all 1, have a state (..., n), or (..., n, lanes), that is
        far beyond ordinary size."""
        leading = states.ndim - self.units.ndim + 1
        if self.scaled:
            return np.zeros(states.shape[leading:], dtype=bool)
        beyond = (np.abs(states) > self.bounds) & np.isfinite(states)
        return np.asarray(beyond.any(axis=tuple(range(leading))))

    def fits(self, state: np.ndarray) -> bool:
        """Whether states (n,), or (n, lanes), after a step, are still those of their units."""
        size = np.abs(state)
        if (size > self.bounds).any():
            return False
        if self.looks >= SHORT:
            self.peaks[:], self.looks = 0.0, 0
        np.fmax(self.peaks, size, out=self.peaks)
        self.looks += 1
        return self.looks < SHORT or not self._slack.any()

    @property
    def _slack(self) -> np.ndarray:
        """Which states were far below units above 1 in all of the last steps."""
        found = (self.units > 1) & (LARGE * self.peaks < 1) & (self.looks >= SHORT)
        found[self.small] = False
        return np.asarray(found)

    def renew(self, state: np.ndarray) -> bool:
        """Set units anew where they do not fit, and states (n,), or (n, lanes), in place; whether
        there were such."""
        size, slack = np.abs(state), self._slack
        left = (size > self.bounds) | slack
        if not self.scaled or not left.any():
            return False
        before = self.units.copy()
        units = units_next_to(np.fmax(size, self.peaks) * before)
        units = np.where(slack, np.fmax(units, 1.0), units)
        self.measure(np.where(left, units, before))
        state[:] = state * before / self.units
        return True

    def take(self, state: np.ndarray) -> None:
        """Take what has grown out of a state (n,), or of those of lanes (n, lanes), in place."""
        if len(self.angles):
            at = self.angles
            turns = np.rint(state[at] / TURN)
            state[at] = (state[at] - turns * COARSE) - turns * FINE
            self.high[at] += turns  # whole numbers: exact
        if len(self.quadratures):
            at = self.quadratures
            before, more = self.high[at], state[at] + self.low[at]
            total = before + more
            back = total - before
            self.high[at], self.low[at] = total, (before - (total - back)) + (more - back)
            state[at] = 0.0

    def whole(self, states: np.ndarray) -> np.ndarray:
        """States (..., n), or (..., n, lanes), as they are, from those kept small."""
        if not self.is_needed:
            with np.errstate(over="ignore"):  # what is no longer finite is told elsewhere
                return np.asarray(states * self.units)
        small, large, at = self.low.copy(), self.high.copy(), self.angles
        small[at], large[at] = self.high[at] * FINE, self.high[at] * COARSE
        return np.asarray(((states + small) + large) * self.units)

    def now(self) -> TurnCount:
        """What is taken out at present, for states that are looked at later."""
        return copy.deepcopy(self)

    def growth(self, state: np.ndarray) -> float:
        """The largest state that may be kept small, in units of the largest other (at least 1); of
        lanes, where that is largest."""
        others = np.abs(state[self.others]).max(axis=0, initial=1.0)
        return float(np.max(np.abs(state[self.small]).max(axis=0, initial=0.0) / others))

    def pace(self, size: int, state: np.ndarray, most: int) -> int:
        """How many steps go before the next look, where states grew to these in ``size`` steps; no
        more than the ``most``."""
        grown = self.growth(state)
        if grown > LARGE:
            return max(size // 2, min(LEAST, most))
        return min(2 * size, most) if grown < LARGE / 4 else size

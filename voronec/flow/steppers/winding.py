"""States that grow while nothing depends on their size, kept small during the steps.

A step of Taylor's method is as long as the largest state allows: one angle of 1e5 radians loosens
the tolerance of all the others by 1e5.  But where the right-hand side does not hold a state at all
(a quadrature), or holds it under sines and cosines only (an angle), what has grown can be taken
out of it between steps and added to the results: the motion of the others is the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from voronec.flow.steppers.angles import angles_among
from voronec.flow.steppers.run import Problem
from voronec.flow.steppers.units import natural_units

__all__ = ["Winding"]

TURN = 2 * np.pi
COARSE = float(np.ldexp(np.round(np.ldexp(TURN, 30)), -30))
"""A turn in 33 bits, whose small multiples are exact; FINE is the rest of it."""
FINE = 2 * (float(np.float64(np.pi) - COARSE / 2)) + 2.4492935982947064e-16


@dataclass
class Winding:
    """What was taken out of the states: turns of ``angles``, all of ``quadratures`` (positions).

    The states that are kept small are in ``units`` of their own; those of angles are 1.
    A quadrature is kept as the sum of two doubles, so nothing is lost when small steps are added
    to a large sum.
    """

    quadratures: np.ndarray
    angles: np.ndarray
    width: int
    units: np.ndarray
    high: np.ndarray = field(init=False)
    low: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.reset()

    @classmethod
    def of(cls, problem: Problem) -> Winding:
        """The states of a problem that may be kept small."""
        program, levels = problem.program, problem.levels
        blocks = [program.derivative, *([levels.extras] if levels is not None else [])]
        held = set().union(*(b.symbols for b in blocks))
        angles = angles_among(program.state, blocks)
        return cls(
            np.array([i for i, s in enumerate(program.state) if s not in held], dtype=int),
            np.array(angles, dtype=int),
            len(program.state),
            natural_units(problem),
        )

    @property
    def needed(self) -> bool:
        """Whether there is a state that may be kept small."""
        return bool(len(self.quadratures) or len(self.angles))

    def reset(self) -> None:
        """Nothing is taken out."""
        self.high, self.low = np.zeros(self.width), np.zeros(self.width)

    def take(self, state: np.ndarray) -> None:
        """Take what has grown out of a state (n,), in place."""
        at = self.angles
        turns = np.rint(state[at] / TURN)
        state[at] = (state[at] - turns * COARSE) - turns * FINE
        self.high[at] += turns  # whole numbers: exact
        at = self.quadratures
        total, more = self.high[at], state[at] + self.low[at]
        self.high[at] = total + more
        back = self.high[at] - total
        self.low[at] = (total - (self.high[at] - back)) + (more - back)
        state[at] = 0.0

    def whole(self, states: np.ndarray) -> np.ndarray:
        """States (..., n) as they are, from those kept small."""
        result = np.array(states, dtype=float)
        at = self.angles
        result[..., at] = (result[..., at] + self.high[at] * FINE) + self.high[at] * COARSE
        at = self.quadratures
        result[..., at] = (result[..., at] + self.low[at]) + self.high[at]
        return result * self.units

    def now(self) -> Winding:
        """What is taken out at present, for states that are looked at later."""
        result = Winding(self.quadratures, self.angles, self.width, self.units)
        result.high, result.low = self.high.copy(), self.low.copy()
        return result

    def grown(self, state: np.ndarray) -> float:
        """The largest state that may be kept small, in units of the largest other (at least 1)."""
        mine = np.zeros(self.width, dtype=bool)
        mine[self.quadratures] = mine[self.angles] = True
        others = np.abs(state[~mine]).max(initial=1.0)
        return float(np.abs(state[mine]).max(initial=0.0) / others)

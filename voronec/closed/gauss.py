"""Integrals along a motion summed by Gauss' rule, where their closed terms cancel in doubles.

With a pair of poles far away, as of Bobylev's ball that is nearly round, the partial fractions of a
rate are large and nearly opposite, though the rate is not.  The rate itself is smooth: sixteen
digits of its integral cost eight values on every short step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.closed.bernstein import Bernstein, evaluated
from voronec.closed.ratio import Polynomial

if TYPE_CHECKING:
    from voronec.closed.form import ClosedForm

__all__ = ["Summed"]

STEP = 0.125
"""In z, of whose sine and cosine x is a quickly converging series."""
POINTS = 8
LARGE = 16.0
"""A factor of a logarithm or an angle beyond which the closed terms are not used."""
BITS = 64


@dataclass(frozen=True, eq=False)
class Summed:
    """Integral ``j`` of one motion."""

    form: ClosedForm
    j: int

    @cached_property
    def needed(self) -> bool:
        """Whether closed terms cancel: the factor of a logarithm or an angle is large."""
        constants = self.form.solution.constants(BITS)
        sizes = [abs(complex(one.logs[self.j])) for one in constants.strains]
        sizes += [abs(float(one.shares[self.j])) for one in constants.phases]
        return constants.half is not None and max(sizes, default=0.0) > LARGE

    @cached_property
    def _parts(self) -> list[tuple[Bernstein, Bernstein]]:
        own = self.form.problem.prepared
        pairs = [sp.fraction(e) for e in sp.Add.make_args(own.rates[self.j])]
        return [(Polynomial.of(p, own).bernstein(self.form),
                 Polynomial.of(q, own).bernstein(self.form)) for p, q in pairs]  # fmt: skip

    def _rate(self, taus: np.ndarray) -> np.ndarray:
        sample = self.form.solution.sample(taus)
        near, far = sample.affine(1.0, 0.0), sample.affine(0.0, 1.0)
        total: Any = 0 * near
        for above, below in self._parts:
            total = total + evaluated(above, near, far) / evaluated(below, near, far)
        return np.asarray(total)

    @cached_property
    def _step(self) -> float:
        return STEP / float(self.form.solution.constants(BITS).scale)

    def _between(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        nodes, weights = np.polynomial.legendre.leggauss(POINTS)
        middle, half = (low + high) / 2, (high - low) / 2
        rates = self._rate(middle[:, None] + half[:, None] * nodes)
        return np.asarray((rates @ weights) * half)

    def at(self, taus: np.ndarray) -> np.ndarray:
        """The integral since 0."""
        place = np.rint(taus / self._step).astype(int)
        most = int(np.abs(place).max(initial=0))
        grid = np.arange(-most, most + 1) * self._step
        steps = self._between(grid[:-1], grid[1:])
        known = np.concatenate([-np.cumsum(steps[:most][::-1])[::-1], [0.0],
                                np.cumsum(steps[most:])])  # fmt: skip
        return np.asarray(known[place + most] + self._between(grid[place + most], taus))

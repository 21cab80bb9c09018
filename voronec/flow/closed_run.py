"""``integrate(method="closed-form")``: a motion evaluated on a grid, and what is watched on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, log2, log10
from time import perf_counter, process_time
from typing import Any

import mpmath
import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.closed import ClosedForm
from voronec.errors import DefinitionError, EngineLimit
from voronec.flow.closed_form import closed_from
from voronec.flow.given import Given
from voronec.flow.modelling import whole
from voronec.flow.observing import Watch, observed, watched
from voronec.flow.outset import Outset
from voronec.flow.probe import quantities
from voronec.flow.trajectory import Cost, Trajectory
from voronec.flow.vocabulary import Vocabulary, Wanted
from voronec.program import Program

__all__ = ["evaluated_motion"]

EXACT = 1e-16
"""Doubles have nothing to offer below this tolerance."""
REASONS = {"closed-form": "asked for", "auto": "auto: the way is long, and nothing adds up"}
MARGIN = 32
"""Bits beyond those of the tolerance in which outputs are computed."""
OFTEN = 20
"""So many instants in balls pass between two reports of progress."""


def evaluated_motion(
    vocabulary: Vocabulary,
    asked: Sequence[Any],
    given: Given,
    outset: Outset,
    grid: np.ndarray,
    tol: float,
    dense: bool,
    progress: Callable[[float], Any] | None,
    began: float,
    method: str,
) -> Trajectory:
    """The trajectory of a motion in closed form.

    A tolerance below 1e-16 gives mpmath's numbers, from enclosures that are narrower than it.  For
    ``auto`` angles must be continuous, else ``EngineLimit``.
    """
    if not 0 < tol < 1:
        raise DefinitionError(f"tol = {tol} must lie between 0 and 1, such as 1e-13")
    equations = vocabulary.equations
    form = closed_from(vocabulary, given, outset)
    watch = watched(vocabulary, asked)
    program = (
        whole(vocabulary, asked, {}).program
        if watch.multipliers is not None
        else quantities(equations.raw.form, watch.expressions)
    )
    sight = _Sight(vocabulary, form, watch, program, outset, float(grid[0]), tol)
    if method == "auto":
        _require_continuous(form, vocabulary.wanted(asked))
    if tol >= EXACT:
        form.at(0.0, sight.names)
    elif not form.rests:
        form.solution.constants(64)
    ready, busy = perf_counter(), process_time()
    t, states = sight.states(grid, progress)
    cost = Cost(
        "closed-form", REASONS[method], tol, ready - began, perf_counter() - ready, 0, 0,
        cpu=process_time() - busy,
    )  # fmt: skip
    if not len(t):
        raise KeyboardInterrupt
    trajectory = sight.seen(t, states, cost, len(t) < len(grid))
    return replace(
        trajectory,
        notes=outset.notes,
        within=(lambda times: sight.seen(*sight.states(times, None), cost)) if dense else None,
    )


def _require_continuous(form: ClosedForm, wanted: Wanted) -> None:
    """Angles of a motion that is turned in space are known up to whole turns."""
    attitude = form.attitude
    if attitude is None or attitude.upright:
        return
    angles = {plain_name(q) for q in attitude.coordinates}
    if any(angles & {str(s) for s in e.free_symbols} for e in wanted.expressions.values()):
        raise EngineLimit("between distant instants these angles are known up to whole turns")


@dataclass(frozen=True)
class _Sight:
    """How instants become states, and states a trajectory."""

    vocabulary: Vocabulary
    form: ClosedForm
    watch: Watch
    program: Program
    outset: Outset
    start: float
    tol: float

    @property
    def names(self) -> list[str]:
        """Of the states, in their order."""
        system = self.vocabulary.equations.system
        return [plain_name(q) for q in (*system.coordinates, *system.velocities)]

    @property
    def bits(self) -> int:
        """In which outputs are computed."""
        return max(53, ceil(-log2(self.tol)) + MARGIN)

    def states(
        self, grid: np.ndarray, progress: Callable[[float], Any] | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """The instants, as far as the keyboard let them come, and the states there."""
        if self.tol >= EXACT:
            found = self.form.at(grid - self.start, self.names)
            return grid.copy(), np.stack([found[n] for n in self.names]).T
        rows = []
        try:
            for i, t in enumerate(grid):
                rows.append(self._row(t))
                if progress is not None and i % OFTEN == 0:
                    progress(i / len(grid))
        except KeyboardInterrupt:
            pass
        table = np.array(rows, dtype=object).reshape(len(rows), len(self.names))
        own = self.form.attitude
        if own is not None and not own.upright:
            for q in own.coordinates:
                column = self.names.index(plain_name(q))
                table[:, column] = _unwrapped(table[:, column], self.bits)
        return np.array([mpmath.mpf(t) for t in grid[: len(rows)]], dtype=object), table

    def _row(self, t: Any) -> list[Any]:
        digits = ceil(-log10(self.tol)) + 1
        found = self.form.enclose(Fraction(float(t)) - Fraction(self.start), digits)
        with mpmath.workprec(self.bits):
            return [_number(found[name]) for name in self.names]

    def seen(
        self, t: np.ndarray, states: np.ndarray, cost: Cost, interrupted: bool = False
    ) -> Trajectory:
        """Everything watched at some states."""
        constants = dict(self.outset.constants)
        if states.dtype == object:
            constants = self.outset.exactly.constants(self.bits)
        with mpmath.workprec(self.bits):
            return observed(
                self.vocabulary, self.watch, self.program, t, states, constants, cost, interrupted
            )


def _number(ball: Any) -> Any:
    """The middle of a ball as mpmath's number, rounded to the precision in force."""
    mantissa, exponent = ball.mid().man_exp()
    return mpmath.ldexp(mpmath.mpf(int(mantissa)), int(exponent))


def _unwrapped(angles: np.ndarray, bits: int) -> np.ndarray:
    rough = angles.astype(float)
    turns = np.round((np.unwrap(rough) - rough) / (2 * np.pi))
    with mpmath.workprec(bits):
        return np.array([a + 2 * mpmath.pi * int(k) for a, k in zip(angles, turns, strict=True)])

"""``integrate(method="closed-form")``: a motion evaluated on a grid, and what is watched on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import ceil, log2, log10
from time import perf_counter, process_time
from types import MappingProxyType
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from voronec.algebra.memo import Memo
from voronec.algebra.symbols import plain_name
from voronec.closed import ClosedForm
from voronec.closed.winding import NoWholeTurns, passed_poles, turnless_message
from voronec.equations.program import Program
from voronec.motion.closed_form import closed_form_of_start
from voronec.motion.motion_start import InitialState
from voronec.motion.numeric_model import whole
from voronec.motion.observables import ObservedQuantities, watch_of
from voronec.motion.request import Namespace, StartData, state_names
from voronec.motion.state_probe import quantities
from voronec.motion.tolerances import EXACT
from voronec.motion.trajectory import Cost, LateTrajectory, Trajectory, make_trajectory

REASONS = {
    "closed-form": "asked for",
    "auto": "auto: less work than so many steps, and no errors add up",
}
MARGIN = 32
"""Bits beyond those of the tolerance in which outputs are computed."""
OFTEN = 20
"""So many instants in balls pass between two reports of progress."""


def evaluated_motion(
    namespace: Namespace,
    asked: Sequence[Any],
    given: StartData,
    outset: InitialState,
    grid: np.ndarray,
    tol: float,
    dense: bool,
    progress: Callable[[float], Any] | None,
    began: float,
    method: str,
) -> Trajectory:
    """The trajectory of a motion in closed form.

    A tolerance below 1e-16 gives mpmath's numbers, from enclosures that are narrower than it.
    Where a pole of coordinates in space is passed, its angles come modulo a turn, with a note.
    Where coordinates and velocities alone are asked for in doubles, the others and the integrals
    are evaluated when they are first read; not by ``auto``, which goes another way where one of
    them cannot be.
    """
    form = outset.memo.once("closed form", lambda: closed_form_of_start(namespace, given, outset))
    watch, program = _watch_program(namespace, asked, outset.memo)
    sight = _ClosedSight(namespace, form, watch, program, outset, float(grid[0]), tol)
    if tol >= EXACT:
        outset.memo.once("closed form at the start", lambda: form.modulo(0.0, sight.names))
    elif not form.rests:
        form.solution.constants(64)
    ready, busy = perf_counter(), process_time()

    def cost_of_run() -> Cost:
        return Cost(
            "closed-form", REASONS[method], tol, ready - began, perf_counter() - ready, 0, 0,
            cpu=process_time() - busy,
        )  # fmt: skip

    if method == "closed-form" and not dense and tol >= EXACT and watch.outputs and sight.is_plain:
        with suppress(NoWholeTurns):
            return sight.late(grid.copy(), cost_of_run)
    t, states, notes = sight.states(grid, progress)
    cost = cost_of_run()
    if not len(t):
        raise KeyboardInterrupt
    trajectory = sight.observe(t, states, cost, len(t) < len(grid))
    return replace(
        trajectory,
        notes=(*outset.notes, *notes),
        within=(lambda times: sight.observe(*sight.states(times, None)[:2], cost))
        if dense
        else None,
    )


def _watch_program(
    namespace: Namespace, asked: Sequence[Any], memo: Memo
) -> tuple[ObservedQuantities, Program]:
    """What is watched, and the program for it, once for the same outputs."""

    def make() -> tuple[ObservedQuantities, Program]:
        watch = watch_of(namespace, asked)
        if watch.multipliers is not None:
            return watch, whole(namespace, asked, {}).program
        return watch, quantities(namespace.equations.raw.form, watch.expressions)

    if not all(isinstance(x, str | sp.Basic) for x in asked):
        return make()
    return memo.once(("watched", tuple(asked)), make)


@dataclass(frozen=True)
class _ClosedSight:
    """How instants become states, and states a trajectory."""

    namespace: Namespace
    form: ClosedForm
    watch: ObservedQuantities
    program: Program
    outset: InitialState
    start: float
    tol: float

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the states, in their order."""
        return state_names(self.namespace.equations.system)

    @property
    def is_plain(self) -> bool:
        """Whether every output is a coordinate or a velocity."""
        return {*self.watch.outputs} <= {*self.names}

    def late(self, t: np.ndarray, cost_of_run: Callable[[], Cost]) -> Trajectory:
        """The outputs now, all else when it is first read.

        Raises:
            NoWholeTurns: an angle among the outputs has no number of whole turns.
        """
        series = self.form.at(t - self.start, self.watch.outputs)
        cost, system = cost_of_run(), self.namespace.equations.system
        for array in (t, *series.values()):
            array.flags.writeable = False
        held = self.outset.constants
        known = {p.name: held[p.name] for p in system.parameters if p.name in held}

        def everything() -> Trajectory:
            _, states, notes = self.states(t, None)
            return replace(self.observe(t, states, cost), notes=(*self.outset.notes, *notes))

        return LateTrajectory.of(
            everything, system=system, t=t, names=self.names, outputs=self.watch.outputs,
            series=MappingProxyType(series), events={}, cost=cost,
            parameters=MappingProxyType(known),
        )  # fmt: skip

    @property
    def bits(self) -> int:
        """In which outputs are computed."""
        return max(53, ceil(-log2(self.tol)) + MARGIN)

    def states(
        self, grid: np.ndarray, progress: Callable[[float], Any] | None
    ) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
        """The instants, as far as the keyboard let them come, the states there, and what is to be
        said of them."""
        told = tuple(
            f"{turnless_message(names, time, self.start)}; half a turn is counted there"
            for time, names in passed_poles(self.form, grid - self.start).items()
        )
        try:
            return *self._states(grid, progress, ()), told
        except NoWholeTurns as error:
            lost = turnless_message(error.names, error.time, self.start)
            turnless = [*map(plain_name, error.names)]
            told = (f"{lost}; they are given modulo a turn", *told)
            return *self._states(grid, progress, turnless), told

    def _states(
        self, grid: np.ndarray, progress: Callable[[float], Any] | None, turnless: Sequence[str]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Instants and states, those angles modulo a turn and all others continuous."""
        if self.tol >= EXACT:
            times = grid - self.start
            series = self.form.at(times, [n for n in self.names if n not in turnless])
            if turnless:
                series |= self.form.modulo(times, turnless)
            return grid.copy(), np.stack([series[n] for n in self.names]).T
        rows = []
        try:
            for i, t in enumerate(grid):
                rows.append(self._row(t, not turnless))
                if progress is not None and i % OFTEN == 0:
                    progress(i / len(grid))
        except KeyboardInterrupt:
            pass
        table = np.array(rows, dtype=object).reshape(len(rows), len(self.names))
        return np.array([mpmath.mpf(t) for t in grid[: len(rows)]], dtype=object), table

    def _row(self, t: Any, whole: bool) -> list[Any]:
        digits = ceil(-log10(self.tol)) + 1
        balls = self.form.enclose(Fraction(float(t)) - Fraction(self.start), digits, whole)
        with mpmath.workprec(self.bits):
            return [_number(balls[name]) for name in self.names]

    def observe(
        self, t: np.ndarray, states: np.ndarray, cost: Cost, interrupted: bool = False
    ) -> Trajectory:
        """Everything watched at some states."""
        constants = dict(self.outset.constants)
        if states.dtype == object:
            constants = self.outset.exactly.constants(self.bits)
        with mpmath.workprec(self.bits):
            return make_trajectory(
                self.namespace, self.watch, self.program, t, states, constants, cost,
                interrupted=interrupted,
            )  # fmt: skip


def _number(ball: Any) -> Any:
    """The middle of a ball as mpmath's number, rounded to the precision in force."""
    mantissa, exponent = ball.mid().man_exp()
    return mpmath.ldexp(mpmath.mpf(int(mantissa)), int(exponent))

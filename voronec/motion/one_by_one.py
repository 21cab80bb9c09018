"""Many motions carried one by one: by scipy, or by a compiled loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from voronec.equations.program import Program, compile_program, hoist
from voronec.errors import DefinitionError, IntegrationError
from voronec.motion.methods import METHODS
from voronec.motion.steppers.choice import COMPILATION, STAGES
from voronec.motion.steppers.dop853_source import SHARE
from voronec.motion.steppers.run import COLLAPSE, INFINITE, Problem
from voronec.motion.steppers.scipy_stepper import Pace, estimated_steps
from voronec.motion.steppers.series_reach import STRIDE
from voronec.motion.steppers.step_loop import Headway, IntegratorFailure, Stretch, Stride
from voronec.motion.steppers.units import units_of_many
from voronec.motion.tolerances import FINEST

__all__ = [
    "Look",
    "Passes",
    "StepSizes",
    "StopRequest",
    "along_one",
    "break_error",
    "compile_method",
    "is_lasting",
    "note_step",
    "strides",
]

COLLAPSE_RATIO = 1e-3
"""Steps are about as long as the way to the next singularity of a motion in complex time, so that
this share of the longest one tells how near it passed, and how many digits were lost."""

WINDOW = 1000
"""So many steps, or stretches of the compiled loop, are looked at together."""

Look = Callable[[], bool]
"""Whether somebody asked to stop."""
Passes = Callable[[np.ndarray, np.ndarray], bool]
"""Whether a motion with states (s, n) at times (s,) passes a place that makes it doubtful."""


class StopRequest(Exception):
    """Somebody asked to stop; what a batch had begun is not finished."""


@dataclass(frozen=True, eq=False)
class StepSizes:
    """The shortest and the longest step of each of some motions, and which of these took one that
    was made too long by coefficients that vanish; ``stride`` is how long one is looked at."""

    shortest: np.ndarray
    longest: np.ndarray
    overlong: np.ndarray
    stride: np.ndarray

    @classmethod
    def of(cls, count: int) -> StepSizes:
        """No steps yet."""
        none = np.zeros(count, dtype=bool)
        return cls(np.full(count, np.inf), np.zeros(count), none, np.full(count, STRIDE))

    def begin(self, which: Any) -> None:
        """Forget the steps of some motions: others take their places."""
        self.shortest[which], self.longest[which] = np.inf, 0.0
        self.overlong[which], self.stride[which] = False, STRIDE

    def note(self, which: int, shortest: float, longest: float) -> None:
        """Further steps of one motion."""
        self.shortest[which] = min(self.shortest[which], shortest)
        self.longest[which] = max(self.longest[which], longest)

    def has_collapsed(self, which: int, share: float = COLLAPSE_RATIO) -> bool:
        """Whether the steps of a motion became so short that it must have passed a place where its
        equations are singular, or nearly: a pole of coordinates, a zero of a divisor."""
        return bool(self.shortest[which] < share * self.longest[which])


def compile_method(method: str, program: Program) -> str:
    """The method, after what it needs is compiled; ``DefinitionError`` where nothing compiles."""
    loop = METHODS[method].loop
    if loop is not None:
        try:
            loop(program)
        except ImportError:
            raise DefinitionError(
                "numba is not installed; 'pip install numba', or use method='scipy'"
            ) from None
    return method


def is_lasting(
    program: Program, tol: float, states: np.ndarray, values: np.ndarray, grid: np.ndarray | None
) -> bool:
    """Whether scipy would take longer than it takes to compile; sections are, of no known span."""
    if grid is None:
        return True
    steps = estimated_steps(Problem(program, states[0], values[0].tolist(), tol), grid)
    return (steps or 0) * len(states) * STAGES * (program.operations + 1) > COMPILATION


def break_error(reason: str, time: float, state: np.ndarray) -> IntegrationError:
    """The error of a motion that cannot go on, with the last that was good."""
    return IntegrationError(f"{reason} after t = {time:.12g}", float(time), state)


@dataclass(frozen=True)
class _Step:
    """A step of the compiled loop, with the names that scipy gives."""

    stride: Stride
    status: str

    @property
    def t_old(self) -> float:
        return float(self.stride.start)

    @property
    def t(self) -> float:
        return float(self.stride.end)

    @property
    def y(self) -> np.ndarray:
        return self.stride.state

    def dense_output(self) -> Callable[[Any], np.ndarray]:
        return lambda times: self.stride.at(np.atleast_1d(times)).T


def strides(
    method: str, program: Program, state: np.ndarray, values: np.ndarray, span: tuple[float, float],
    tol: float,
) -> Iterator[Any]:  # fmt: skip
    """DOP853 after each of its steps; ``IntegrationError`` where it cannot go on."""
    if METHODS[method].loop is not None:
        yield from _compiled_strides(method, program, state, values, span, tol)
        return
    from scipy.integrate import DOP853

    rhs, constants = compile_program(program, scalar=True)[0], values.tolist()

    def derivative(t: float, y: np.ndarray) -> Any:
        try:
            return rhs(t, y.tolist(), constants)
        except (ZeroDivisionError, ValueError, OverflowError):
            # a trial step left the domain: the method then tries a shorter one
            return np.full(len(y), np.nan)

    finest, pace = max(SHARE * tol, FINEST), Pace()
    least = finest * units_of_many(program, state[None], values[None])[0]
    solver = DOP853(derivative, span[0], state, span[1], rtol=finest, atol=least)
    while solver.status == "running":
        good, reached = solver.y.copy(), float(solver.t)
        with np.errstate(all="ignore"):
            pace.step(solver)
        if solver.status == "failed":
            raise break_error(COLLAPSE, reached, good)
        if not np.isfinite(solver.y).all():
            raise break_error(INFINITE, reached, good)
        yield solver


def _compiled_strides(
    method: str,
    program: Program,
    state: np.ndarray,
    values: np.ndarray,
    span: tuple[float, float],
    tol: float,
) -> Iterator[_Step]:
    for stretch in _stretches(method, program, state, values, np.array(span), tol, dense=True):
        for stride in stretch.strides:
            yield _Step(stride, "finished" if stride.end == span[1] else "running")


def _stretches(
    method: str, program: Program, state: np.ndarray, values: np.ndarray, grid: np.ndarray,
    tol: float, dense: bool,
) -> Iterator[Stretch]:  # fmt: skip
    """Stretches of the compiled loop, up to the end of a grid."""
    from voronec.motion.steppers.numba_stepper import Loop, scales_of

    problem = Problem(program, state, values.tolist(), tol, dense=dense, marked=True)
    scales, raised = scales_of(problem), hoist(program)
    compile_loop = METHODS[method].loop
    assert compile_loop is not None
    loop = Loop.of(compile_loop(program), problem, grid, scales, raised)
    time, good = float(grid[0]), state
    while time != grid[-1]:
        try:
            stretch = loop.advance()
        except IntegratorFailure as halted:
            raise break_error(str(halted), time, good) from None
        assert isinstance(stretch, Stretch)
        yield stretch
        time, good = stretch.end, stretch.state


def along_one(
    method: str, program: Program, state: np.ndarray, values: np.ndarray, grid: np.ndarray,
    tol: float, stopped: Look, passes: Passes | None = None,
) -> tuple[np.ndarray, IntegrationError | None, int, bool]:  # fmt: skip
    """One motion along a grid: states (k, n), the error that ended it, steps, and whether these
    collapsed, or what it ``passes`` between their ends makes it doubtful."""
    rows = np.full((len(grid), len(state)), np.nan)
    rows[0], steps, sizes, doubtful = state, 0, StepSizes.of(1), False
    if len(grid) == 1:
        return rows, None, 0, False
    fill = _fill if METHODS[method].loop is None else partial(_fill_by_loop, method)
    path = [(grid[:1], state[None])]

    def look() -> bool:
        times, states = (np.concatenate(parts) for parts in zip(*path, strict=True))
        del path[:-1]
        return passes is not None and passes(times, states)

    try:
        for times, states in fill(program, state, values, grid, tol, rows, sizes):
            steps += len(times)
            path.append((times, states))
            if len(path) > WINDOW:
                doubtful |= look()
            if stopped():
                raise StopRequest
    except IntegrationError as error:
        return rows, error, steps, False
    return rows, None, steps, look() or doubtful or sizes.has_collapsed(0)


def _fill(
    program: Program, state: np.ndarray, values: np.ndarray, grid: np.ndarray, tol: float,
    rows: np.ndarray, sizes: StepSizes,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:  # fmt: skip
    """Fill in the rows of a motion by scipy; yields times (s,) and states (s, n) at the ends of
    steps."""
    order, done, headway = np.sign(grid[-1] - grid[0]), 1, Headway(grid[0], float(grid[-1]))
    span = (float(grid[0]), float(grid[-1]))
    for steps, solver in enumerate(strides("scipy", program, state, values, span, tol), 1):
        note_step(sizes, solver)
        if headway.is_lost(steps, solver.t):
            raise break_error(COLLAPSE, solver.t, solver.y)
        reached = int(np.searchsorted(order * grid, order * solver.t, side="right"))
        if reached > done:
            rows[done:reached] = solver.dense_output()(grid[done:reached]).T
            done = reached
        yield np.array([solver.t]), solver.y[None].copy()


def _fill_by_loop(
    method: str, program: Program, state: np.ndarray, values: np.ndarray, grid: np.ndarray,
    tol: float, rows: np.ndarray, sizes: StepSizes,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:  # fmt: skip
    """The same in the compiled loop."""
    done, steps, begin, headway = 1, 0, float(grid[0]), Headway(grid[0], float(grid[-1]))
    for stretch in _stretches(method, program, state, values, grid, tol, dense=False):
        rows[done : done + len(stretch.rows)] = stretch.rows
        done += len(stretch.rows)
        lengths = np.abs(np.diff([begin, *stretch.times]))
        begin = stretch.end
        whole = lengths[: len(lengths) - (stretch.end == grid[-1])]  # the last one is cut
        if len(whole):
            sizes.note(0, whole.min(), whole.max())
        steps += stretch.steps
        if headway.is_lost(steps, stretch.end):
            raise break_error(COLLAPSE, stretch.end, stretch.state)
        yield stretch.times, stretch.states


def note_step(sizes: StepSizes, method: Any) -> None:
    """Take down a step of one motion; the last one is cut."""
    if method.status == "running":
        length = abs(method.t - method.t_old)
        sizes.note(0, length, length)

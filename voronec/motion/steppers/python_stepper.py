"""DOP853 in Python's own floats: a short run that is over before a faster method is loaded.

The source is the one that numba compiles; for arrays of numpy, whose entries Python reads slowly,
it has tables here.  Points of the grid are read off the dense output of the steps, all at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from voronec.equations.program import Program, hoist
from voronec.equations.program.dialect import code
from voronec.motion.steppers.dop853_source import STAGES, growth, kernel_source
from voronec.motion.steppers.numba_stepper import PARTS, Loop, between, scales_of
from voronec.motion.steppers.run import INFINITE, Integrator, Problem, Run
from voronec.motion.steppers.step_loop import IntegratorFailure, level_function, march

CHUNK = 200
"""Trials between two looks at the keyboard."""
TRIAL = 12
"""Steps after which the rest is estimated; the first ones are shorter than those that follow."""
SUMS = 100
"""Operations on each component of the state in the sums of a step."""


def python_dop853(problem: Problem) -> Integrator:
    """The Runge-Kutta method of order eight of Dormand and Prince, by Python alone."""

    def run(grid: np.ndarray) -> Run:
        with np.errstate(all="ignore"):
            return march(problem, grid, _loop(problem, grid), level_function(problem))

    return run


def operations_of_run(problem: Problem, grid: np.ndarray, most: float) -> float:
    """About how many operations a run takes; infinite where these are more than ``most``, or where
    it does not get under way.

    A few steps are taken, and the rest is counted with the last of them.
    """
    size = len(problem.start)
    step = STAGES * problem.program.operations + SUMS * size
    if TRIAL * step > most or len(grid) == 1:
        return math.inf
    loop = _loop(problem, grid)
    try:
        with np.errstate(all="ignore"):
            loop.advance(TRIAL)
    except IntegratorFailure:
        return math.inf
    taken, length = int(loop.counts[1]), abs(float(loop.clock[1]))
    left = abs(float(grid[-1]) - float(loop.clock[0]))
    count = taken + left / length if left else taken
    return step * count if step * count <= most else math.inf


def _loop(problem: Problem, grid: np.ndarray) -> Loop:
    drive = _drive_in_python(problem.program, problem.levels if problem.events else None)
    return Loop.of(drive, problem, grid, scales_of(problem), hoist(problem.program))


@lru_cache(maxsize=32)
def _drive_in_python(program: Program, levels: Program | None) -> Callable[..., int]:
    """The function ``drive`` of a program, and of functions of events, as ``Loop`` calls it."""
    sizes = {"rhs": len(program.state), "extras": len(levels.names) if levels else 0}
    known: dict[str, Any] = {"sqrt": math.sqrt, "growth": growth}
    namespace = {"np": _Arrays, "jit": _with_nan(sizes), **known}
    exec(code(kernel_source(program, levels, whole=False), "<DOP853>"), namespace)
    drive = namespace["drive"]

    def advance(
        grid: np.ndarray, rows: np.ndarray, clock: np.ndarray, counts: np.ndarray,
        states: np.ndarray, bend: np.ndarray, times: np.ndarray, ends: np.ndarray,
        bends: np.ndarray, scales: np.ndarray, coarse: np.ndarray, parameters: np.ndarray,
        given: np.ndarray, dense: bool, keep: bool, limit: int,
    ) -> int:  # fmt: skip
        size, done, limit = states.shape[1], int(counts[0]), min(limit, CHUNK)
        steps = np.empty((limit, 2)), np.empty((limit, 2, size)), np.empty((limit, PARTS, size))
        known = clock.tolist(), [1, *counts.tolist()[1:]], _Table(states), _Table(bend)
        try:
            outcome = drive(
                [float(grid[0]), float(grid[-1])], np.empty((2, size)), *known, *steps,
                _Table(scales), coarse.tolist(), parameters.tolist(), given.tolist(), True, True,
                limit,
            )  # fmt: skip
        except ArithmeticError:
            raise IntegratorFailure(INFINITE) from None
        clock[:], counts[:], states[:], bend[:] = map(np.asarray, known)
        kept = int(counts[4])
        found = _read_off(grid[done:], *(part[:kept] for part in steps))
        rows[done : done + len(found)] = found
        counts[0], counts[4] = done + len(found), kept if keep else 0
        for target, part in zip((times, ends, bends), steps, strict=True):
            room = min(kept, len(target))
            target[:room] = part[:room]
        return int(outcome)

    return advance


def _read_off(
    grid: np.ndarray, times: np.ndarray, ends: np.ndarray, bends: np.ndarray
) -> np.ndarray:
    """The states at those points of a grid that lie within steps, as ``Loop`` keeps them."""
    if not len(times):
        return np.empty((0, ends.shape[2]))
    order = 1 if times[-1, 1] >= times[0, 0] else -1
    count = np.searchsorted(order * grid, order * times[-1, 1], side="right")
    moments = grid[:count]
    which = np.searchsorted(order * times[:, 1], order * moments)
    start, end = times[which].T
    parts = ((moments - start) / (end - start))[:, None]
    return between(ends[which, 0], np.moveaxis(bends[which], 1, 0), parts)


class _Table(dict[Any, Any]):
    """Numbers by their places, i or (i, j), and rows of them, as arrays have them."""

    def __init__(self, values: np.ndarray | None = None) -> None:
        rows = [] if values is None else values.tolist()
        super().__init__(((i, j), x) for i, row in enumerate(rows) for j, x in enumerate(row))
        self._width = len(rows[0]) if rows else 0

    def __missing__(self, row: int) -> list[float]:
        return [self[row, j] for j in range(self._width)]

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        """The array of what the table was made of."""
        return np.array([self[i] for i in range(len(self) // self._width)], dtype=dtype)

    def any(self) -> bool:
        """Whether one of the numbers is not zero."""
        return any(self.values())


class _Arrays:
    """What the source asks numpy for."""

    inf, bool_ = math.inf, bool
    nextafter = staticmethod(math.nextafter)

    @staticmethod
    def empty(_: Any) -> _Table:
        """Room for numbers."""
        return _Table()

    zeros = staticmethod(lambda _size, _kind: _Table())


def _with_nan(sizes: dict[str, int]) -> Callable[..., Any]:
    """A decorator of functions of the source: those with so many results by name give nan where
    Python would raise, so that a trial step which left the domain is rejected."""

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        nothing = [math.nan] * sizes.get(function.__name__, 0)

        def guard(*given: Any) -> Any:
            try:
                return function(*given)
            except (ZeroDivisionError, ValueError, OverflowError):
                return nothing

        return guard if function.__name__ in sizes else function

    return decorate

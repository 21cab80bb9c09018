"""What steps of the methods cost, counted, not timed: the same call always makes the same choice.

Taylor's method of order p = 1 - log(tol)/2 takes steps of a length that hardly depends on the
tolerance [JorbaZou2005]; each costs the ``weight`` of a program times p, since at such orders what
grows as p^2 is the smaller part.  DOP853 takes twelve evaluations a step, and the steps are as long
as tol^(1/8) [HairerNorsettWanner1993].  At the same tolerance Taylor's method errs less, so that at
equal error it may have a coarser one.  The constants are fitted to the catalogue by
``python tools/bench.py costs``.

What decays far faster than a motion changes makes every explicit method take short steps, though
nothing is to be seen of it: such a motion is stiff.
"""

from __future__ import annotations

from math import log

import numpy as np

from voronec.equations.program import Program, compile_program
from voronec.motion.steppers import Problem

TAYLOR_STEP, TAYLOR = 0.5, 0.0088
"""Microseconds of a step of heyoka, which Python looks at now and then, and of each order of it and
each product of moving quantities."""
DOP853_STEP, EVALUATION = 0.15, 0.005
"""Microseconds of a step of DOP853, and of each unit of the ``evaluation_weight`` of a program."""
PYTHON = 300.0
"""Microseconds of a step of scipy's."""
STEPS = 0.087
"""Steps of DOP853 for one of heyoka, times tol^(1/8): within a third for all of the catalogue."""
FINER = 100.0
"""At equal error heyoka's tolerance may be so many times coarser than that of DOP853 or LSODA: what
``auto`` gives to these in its place has one so much finer, and loses no digits."""
REACH = 1e-11
"""At finer tolerances rounding keeps DOP853 from the errors of Taylor's method."""
STABLE = 0.15
"""Steps of an explicit method in the time in which the fastest state decays by e."""
WORTH = 1e5
"""Microseconds of explicit steps for the sake of what decays that are worth another method, whose
steps are Python's: LSODA takes some hundreds."""
MOVE = 1e-7
"""The part of their sizes, at least of one, by which states are moved to see slopes."""


def order_of(tol: float) -> float:
    """The order of Taylor's method at a tolerance."""
    return 1 - log(tol) / 2


def _taylor_step(program: Program, tol: float) -> float:
    return TAYLOR_STEP + TAYLOR * program.weight * order_of(tol)


def step_cost(method: str, program: Program, tol: float) -> float:
    """About how many microseconds a step takes; of lanes, one of all of them."""
    if method == "heyoka":
        return _taylor_step(program, tol)
    return PYTHON if method == "scipy" else DOP853_STEP + EVALUATION * program.evaluation_weight


def dop853_gain(program: Program, tol: float) -> float:
    """How many times less DOP853 costs than Taylor's method at equal error."""
    step = DOP853_STEP + EVALUATION * program.evaluation_weight
    return _taylor_step(program, FINER * tol) / (STEPS * tol**-0.125 * step)


def dop853_is_cheaper(program: Program, tol: float) -> bool:
    """Whether compiled DOP853 is the better choice."""
    return tol >= REACH and dop853_gain(program, tol) > 1


def is_stiff(problem: Problem, grid: np.ndarray) -> bool:
    """Whether it would cost too much to follow what decays, and does not oscillate as fast, from
    where a motion starts: by the eigenvalues of the slopes of its rates."""
    time, span = float(grid[0]), float(grid[-1] - grid[0])
    most = WORTH / (STABLE * _taylor_step(problem.program, problem.tol))
    right = compile_program(problem.program, scalar=True)[0]
    values = [*map(float, problem.parameters)]

    def rates(state: np.ndarray) -> np.ndarray:
        return np.array(right(time, state.tolist(), values))

    try:
        state = problem.start.astype(float)
        steps = MOVE * np.maximum(1.0, np.abs(state))
        here = rates(state)
        # a move of all states at once tells of most motions that nothing is so fast
        with np.errstate(all="ignore"):  # where there is no end, there is no slope
            slope = np.abs((rates(state + steps) - here) / steps).max(initial=0.0)
            if slope * abs(span) < most / 100:
                return False
            moved = [rates(state + way) - here for way in np.diag(steps)]
    except (ArithmeticError, ValueError):
        return False
    slopes = np.array(moved).T / steps
    if not np.isfinite(slopes).all():
        return False
    eigenvalues = np.linalg.eigvals(slopes)
    fastest = eigenvalues[np.argmax(np.abs(eigenvalues))] * span
    return bool(-fastest.real > max(most, abs(fastest.imag)))

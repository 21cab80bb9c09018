"""scipy's integrators, one step at a time, on the compiled right-hand side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from voronec.equations.program import compile_program
from voronec.motion.steppers.dop853_source import FIRST_GROWTH, growth
from voronec.motion.steppers.run import COLLAPSE, INFINITE, Integrator, Problem, Run
from voronec.motion.steppers.step_loop import (
    IntegratorFailure,
    Stride,
    level_function,
    march,
)
from voronec.motion.steppers.units import natural_units
from voronec.motion.tolerances import FINEST, dop853_tolerance

PATIENCE = 300
"""So many evaluations in turn without a value lead nowhere; scipy would go on for ever."""
SHORT = 0.95
"""A step shorter than this part of what was tried first was rejected, or ends the run."""
LOOKS = 4
"""Places along a step of LSODA at which it is held against the equations."""
MISS = 1e-3
"""A step of LSODA whose slope misses more of the right side than this, in units of the states, has
lost the motion; stiff equations miss what the tolerance makes of their stiffness."""
ASTRAY = "the steps of lsoda do not follow the equations"
SHORTER = 8
"""A step of LSODA that has lost the motion is taken again, and none so long is taken after it;
this is what the length is divided by, ``ATTEMPTS`` times in turn."""
ATTEMPTS = 6
ANY = 1e6
"""A tolerance that every step keeps."""
TRIAL = 12
"""Steps after which the rest is estimated; the first ones are shorter than those that follow."""


def dop853(problem: Problem) -> Integrator:
    """The Runge-Kutta method of order eight of Dormand and Prince."""
    from scipy.integrate import DOP853

    return _stepper(replace(problem, tol=dop853_tolerance(problem.tol)), DOP853)


def lsoda(problem: Problem) -> Integrator:
    """Adams' and Gear's methods by turns, as stiffness asks for."""
    from scipy.integrate import LSODA

    return _stepper(problem, LSODA)


def estimated_steps(problem: Problem, grid: np.ndarray) -> int | None:
    """How many steps of DOP853 a run will take, or None where it does not get under way.

    A few steps are taken, and the rest is counted with the last of them.
    """
    from scipy.integrate import DOP853

    if len(grid) == 1:
        return 0
    with np.errstate(all="ignore"):
        try:
            solver = _solver(problem, DOP853, grid)()
            for count in range(TRIAL):
                solver.step()
                if solver.status == "finished":
                    return count + 1
                if solver.status == "failed" or not np.isfinite(solver.y).all():
                    return None
        except IntegratorFailure:
            return None
    left = abs(float(grid[-1] - solver.t))
    return TRIAL + int(left / solver.step_size)


def _solver(problem: Problem, method: Callable[..., Any], grid: np.ndarray) -> Callable[..., Any]:
    """What makes a solver of scipy, at the start or at another ``t`` and ``state``, with steps not
    longer than ``longest``."""
    rhs, _ = compile_program(problem.program, scalar=True)
    at = problem.parameters_at()
    finest = max(problem.tol, FINEST)
    without = 0

    def derivative(t: float, y: np.ndarray) -> Any:
        nonlocal without
        try:
            rates = rhs(t, y.tolist(), at(t, y))
        except (ZeroDivisionError, ValueError, OverflowError):
            # a trial step left the domain: the method then tries a shorter one
            rates = [np.nan] * len(y)
        without = without + 1 if any(x != x for x in rates) else 0
        if without > PATIENCE:
            raise IntegratorFailure(INFINITE)
        return np.array(rates)

    units = natural_units(problem)
    least = finest if (units == 1).all() else finest * units
    # the dense output of the first step keeps its start, which a later run overwrites
    begin = problem.start.copy()

    def make(
        t: float = grid[0], state: np.ndarray = begin, longest: float = np.inf,
        first: float | None = None,
    ) -> Any:  # fmt: skip
        return method(
            derivative,
            t,
            state,
            grid[-1],
            rtol=finest,
            atol=least,
            max_step=longest,
            first_step=first,
        )

    return make


def up_to(problem: Problem, start: float, begin: np.ndarray, end: float) -> Stride:
    """One step of DOP853 from a state just to an instant, part of a step that was accepted."""
    from scipy.integrate import DOP853

    grid = np.array([start, end])
    solver = _solver(replace(problem, tol=ANY), DOP853, grid)(start, begin, first=abs(end - start))
    solver.step()
    inside = solver.dense_output()
    return Stride(start, solver.t, solver.y, lambda times: np.asarray(inside(times).T))


def _stepper(problem: Problem, method: Callable[..., Any]) -> Integrator:
    def run(grid: np.ndarray) -> Run:
        with np.errstate(all="ignore"):
            solver = _Solver(problem, _solver(problem, method, grid))
            levels = level_function(problem)
            return march(problem, grid, solver, levels)

    return run


@dataclass
class _Solver:
    """One of scipy's solvers under way, which ``make`` makes, and anew for shorter steps.

    Steps of Runge-Kutta methods are smoothed by ``growth``: ``last`` is by how much longer than the
    last step the next one could be.
    """

    problem: Problem
    make: Callable[..., Any]
    last: float = FIRST_GROWTH
    spent: int = 0
    solver: Any = field(init=False)

    def __post_init__(self) -> None:
        self.solver = self.make()

    def advance(self) -> Stride:
        solver = self.solver
        start, begin, slope = solver.t, solver.y.copy(), getattr(solver, "f", None)
        self._step()
        if slope is None:
            self._follow(start, begin)
            solver = self.solver
        kept = [solver.dense_output()] if self.problem.dense else []

        def at(times: np.ndarray) -> np.ndarray:
            # dense output costs evaluations, and exists until the next step
            if not kept:
                kept.append(solver.dense_output())
            return np.asarray(kept[0](times).T)

        if slope is None:
            return Stride(start, solver.t, solver.y.copy(), at)
        slopes = (begin, slope), (solver.y, solver.f)
        shorter = partial(up_to, self.problem, start, begin)
        return Stride(start, solver.t, solver.y.copy(), at, slopes, shorter)

    def _step(self) -> None:
        solver = self.solver
        tried = getattr(solver, "h_abs", None)  # others have none, and stay as scipy has them
        solver.step()
        if solver.status == "failed":
            raise IntegratorFailure(COLLAPSE)
        if not np.isfinite(solver.y).all():
            raise IntegratorFailure(INFINITE)
        if tried is not None:
            length = solver.step_size
            factor = solver.h_abs / length
            solver.h_abs = length * growth(factor, self.last, length < SHORT * tried)
            self.last = factor

    def _follow(self, start: float, begin: np.ndarray) -> None:
        """Take a step of LSODA again, shorter, as long as it does not follow the equations."""
        for _ in range(ATTEMPTS):
            if self.follows():
                return
            self.spent += int(self.solver.nfev)
            longest = abs(self.solver.t - start) / SHORTER
            self.solver = self.make(start, begin, longest)
            self._step()
        raise IntegratorFailure(ASTRAY)

    def follows(self) -> bool:
        """Whether LSODA's polynomial has about the slope of the right side along its step.

        Where nothing has changed for long its steps grow over all that is to come, and with a
        derivative that is out of date its corrections are small however wrong they are.
        """
        solver = self.solver
        if solver.t == solver.t_old or not solver.n:
            return True  # nothing has moved, and there is no polynomial
        inside = solver.dense_output()
        numbers, h = np.arange(1, inside.yh.shape[1]), inside.h
        for part in np.arange(1, LOOKS + 1) / LOOKS:
            t = inside.t_old + part * (solver.t - inside.t_old)
            slopes = inside.yh[:, 1:] @ (numbers * ((t - solver.t) / h) ** (numbers - 1)) / h
            missed = np.abs(slopes - solver.fun(t, inside(t))) * abs(solver.t - inside.t_old)
            if (missed > MISS * np.maximum(1.0, np.abs(solver.y))).any():
                return False
        return True

    @property
    def evaluations(self) -> int:
        return self.spent + int(self.solver.nfev)

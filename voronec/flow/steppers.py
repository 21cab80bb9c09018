"""The two integrators behind one shape: a grid in, states on it out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.program import Program, compiled, taylor_system

__all__ = ["Halt", "Run", "Stepper", "dop853", "taylor"]

CHUNK = 20_000
"""Taylor steps between two looks at the keyboard."""
COMPACT = 150
"""Above this many operations heyoka compiles in its compact mode: seconds sooner, then slower."""
FINEST = 2.3e-14
"""scipy's DOP853 refuses finer relative tolerances."""
COLLAPSE = "the step size collapsed"
INFINITE = "the state is no longer finite"


@dataclass(frozen=True)
class Halt:
    """Why and where an integrator could not go on: the last state that was good."""

    reason: str
    time: float
    state: np.ndarray


@dataclass(frozen=True)
class Run:
    """States on the first ``len(states)`` points of the grid; ``halt`` where it stopped short."""

    states: np.ndarray
    steps: int
    evaluations: int
    halt: Halt | None = None
    interrupted: bool = False


Stepper = Callable[[np.ndarray], Run]


def taylor(program: Program, state: np.ndarray, parameters: Sequence[float], tol: float) -> Stepper:
    """heyoka's Taylor integrator; its dense output is as accurate as its steps."""
    import heyoka as hy

    # heyoka wants no more parameters than the equations contain
    used = [i for i, p in enumerate(program.parameters) if p in program.derivative.symbols]
    integrator = hy.taylor_adaptive(
        taylor_system(program),
        state.tolist(),
        pars=list(parameters[: max(used, default=-1) + 1]),
        tol=tol,
        compact_mode=program.operations > COMPACT,
    )

    def advance(grid: np.ndarray) -> tuple[Any, int, np.ndarray]:
        """One chunk towards, or along, the rest of the grid."""
        if integrator.time != grid[0]:
            outcome, _, _, steps, *_ = integrator.propagate_until(grid[0], max_steps=CHUNK)
            return outcome, steps, np.empty((0, len(state)))
        outcome, _, _, steps, _, rows = integrator.propagate_grid(grid, max_steps=CHUNK)
        return outcome, steps, rows

    def run(grid: np.ndarray) -> Run:
        integrator.time = float(grid[0])
        rows, steps, done = [state[None, :]], 0, 1
        try:
            while done < len(grid):
                before = integrator.time
                # the integrator wants its grid to begin where it stands
                start = done - 1 if before == grid[done - 1] else done
                outcome, taken, new = advance(grid[start:])
                steps += taken
                rows.append(new[done - start :])
                done += len(rows[-1])
                moved = abs(integrator.time - before)
                stuck = taken == CHUNK and moved <= 1e-13 * np.ptp(grid)
                if stuck:
                    halt = Halt(COLLAPSE, integrator.time, integrator.state.copy())
                    return Run(np.vstack(rows), steps, steps, halt)
                if outcome == hy.taylor_outcome.err_nf_state:
                    halt = _last_good(integrator, grid, done, np.vstack(rows)[-1], taken)
                    return Run(np.vstack(rows), steps, steps, halt)
        except KeyboardInterrupt:
            return Run(np.vstack(rows), steps, steps, interrupted=True)
        return Run(np.vstack(rows), steps, steps)

    return run


def _last_good(integrator: Any, grid: np.ndarray, done: int, state: np.ndarray, taken: int) -> Halt:
    """The last step before the state broke, found by going over the last stretch step by step."""
    integrator.time = float(grid[done - 1])
    integrator.state[:] = state
    step = integrator.step if grid[-1] >= grid[0] else integrator.step_backward
    halt = Halt(INFINITE, integrator.time, state)
    for _ in range(taken + 1):
        step()
        if not (np.isfinite(integrator.state).all() and np.isfinite(integrator.time)):
            break
        halt = Halt(INFINITE, integrator.time, integrator.state.copy())
    return halt


def dop853(program: Program, state: np.ndarray, parameters: Sequence[float], tol: float) -> Stepper:
    """scipy's Runge-Kutta method of order eight, on the compiled right-hand side."""
    from scipy.integrate import DOP853

    rhs, _ = compiled(program, scalar=True)
    constants = list(parameters)

    def derivative(t: float, y: np.ndarray) -> Any:
        try:
            return rhs(t, y.tolist(), constants)
        except (ZeroDivisionError, ValueError, OverflowError):
            # a trial step left the domain: the method then tries a shorter one
            return np.full(len(y), np.nan)

    def run(grid: np.ndarray) -> Run:
        states = np.empty((len(grid), len(state)))
        states[0], done, steps = state, 1, 0
        if len(grid) == 1:
            return Run(states, 0, 0)
        finest = max(tol, FINEST)
        method = DOP853(derivative, grid[0], state, grid[-1], rtol=finest, atol=finest)
        order = np.sign(grid[-1] - grid[0])
        halt, interrupted = None, False
        try:
            while done < len(grid) and halt is None:
                good = Halt(COLLAPSE, float(method.t), method.y.copy())
                with np.errstate(all="ignore"):
                    method.step()
                steps += 1
                if method.status == "failed":
                    halt = good
                elif not np.isfinite(method.y).all():
                    halt = Halt(INFINITE, good.time, good.state)
                else:
                    reached = int(np.searchsorted(order * grid, order * method.t, side="right"))
                    if reached > done:
                        states[done:reached] = method.dense_output()(grid[done:reached]).T
                        done = reached
        except KeyboardInterrupt:
            interrupted = True
        return Run(states[:done].copy(), steps, int(method.nfev), halt, interrupted)

    return run

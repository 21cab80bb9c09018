"""Our own integrators as contenders: through ``integrate``, as a user calls it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from voronec.bench.contender import Contender, NotHere, Outcome, Run
from voronec.bench.question import Question
from voronec.errors import DefinitionError, EngineLimit
from voronec.flow import Trajectory, integrate

__all__ = ["OWN"]

ENOUGH = 0.25
"""Seconds of running after which a run is not repeated."""
MOST = 5
"""So often at most: every repetition sets up again."""
EXACT = 1e-20
"""The tolerance of the arbitrary-precision method."""
LONGEST = 30.0
"""Seconds beyond which it is left out."""

COARSE_TO_FINE = (1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16)
ROUNDED = (1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12, 2.3e-14)


def _prepare(question: Question, method: str, full: bool) -> Run:
    """A method of ours on the smallest model of the outputs, or on the full one."""
    wanted = tuple(question.expressions[n] for n in question.outputs)
    asked = (*wanted, *question.initial) if full else wanted

    def once(grid: np.ndarray, tol: float) -> Trajectory:
        return integrate(
            question.equations, question.bare, times=grid, outputs=asked, method=method, tol=tol
        )

    try:
        once(question.grid[:1], 1e-6)
        if method == "flint":
            _refuse_long(question, once(question.grid[:2], EXACT).cost.run)
    except (DefinitionError, EngineLimit) as refusal:
        raise NotHere(str(refusal)) from None

    def run(tol: float) -> Outcome:
        best, spent, count = np.inf, 0.0, 0
        while count == 0 or (spent < ENOUGH and count < MOST):
            trajectory = once(question.grid, tol)
            seconds = float(getattr(trajectory.cost, "cpu", trajectory.cost.run))
            best, spent, count = min(best, seconds), spent + seconds, count + 1
        return _outcome(question, trajectory, best)

    return run


def _refuse_long(question: Question, first: float) -> None:
    """Raise ``NotHere`` where arbitrary precision would keep everybody waiting."""
    seconds = first * (len(question.grid) - 1)
    if seconds > LONGEST:
        raise NotHere(f"would take about {seconds:.0f} s a run; take a shorter time")


def _outcome(question: Question, trajectory: Trajectory, seconds: float) -> Outcome:
    if trajectory.interrupted:
        raise KeyboardInterrupt
    values: Mapping[str, np.ndarray] = {
        n: np.asarray(trajectory[n], dtype=float) for n in question.outputs
    }
    cost = trajectory.cost
    drift = {name: float(x) for name, x in trajectory.drift.items()}
    return Outcome(values, seconds, cost.evaluations, cost.steps, drift)


def _own(name: str, about: str, method: str, tols: tuple[float, ...], full: bool) -> Contender:
    return Contender(name, about, tols, partial(_prepare, method=method, full=full))


OWN = (
    _own("heyoka", "ours: Taylor method, smallest model", "heyoka", COARSE_TO_FINE, False),
    _own("heyoka-full", "ours: Taylor method, all coordinates", "heyoka", COARSE_TO_FINE, True),
    _own("scipy", "ours: scipy's DOP853, smallest model", "scipy", ROUNDED, False),
    _own("lsoda", "ours: scipy's LSODA, smallest model", "lsoda", ROUNDED[:-1], False),
    _own("flint", "ours: Taylor method in any precision", "flint", (EXACT,), False),
)

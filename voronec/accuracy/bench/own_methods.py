"""Our own integrators as contenders: the motion through ``integrate``, as a user calls it; its time
by running the same prepared integrator again and again, as the peers do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from voronec.accuracy.bench.contender import Contender, NotHere, Outcome, Run, timed
from voronec.accuracy.bench.question import BenchMotion
from voronec.algebra.symbols import plain_name
from voronec.errors import DefinitionError, EngineLimit
from voronec.motion import Trajectory, integrate
from voronec.motion.chart_stepper import through_charts
from voronec.motion.closed_form import closed_form
from voronec.motion.numeric_model import modelled
from voronec.motion.steppers import Problem, Stepper
from voronec.motion.steppers.choice import CLOSED
from voronec.motion.vocabulary import Vocabulary

__all__ = ["OWN"]

EXACT = 1e-20
"""The tolerance of the arbitrary-precision method."""
LONGEST = 30.0
"""Seconds beyond which it is left out."""

COARSE_TO_FINE = (1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16)
ROUNDED = (1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12, 2.3e-14)


def _prepare(question: BenchMotion, method: str, full: bool) -> Run:
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

    made: dict[float, Stepper | None] = {}

    def run(tol: float) -> Outcome:
        trajectory = once(question.grid, tol)
        seconds = float(trajectory.cost.cpu)
        if method == CLOSED:
            seconds = _evaluated(question)
        elif method != "flint" and not trajectory.interrupted:
            if tol not in made:
                made[tol] = _again(question, asked, trajectory)
            stepper = made[tol]
            if stepper is not None:
                seconds = timed(lambda: stepper(question.grid))[1]
        return _outcome(question, trajectory, seconds)

    return run


def _evaluated(question: BenchMotion) -> float:
    """CPU time of evaluating the coordinates and velocities that the outputs hold."""
    system = question.system
    form = closed_form(question.equations, question.bare)
    meaning = dict(zip(system.invariant_symbols, system.invariants.values(), strict=True))
    held = {s for e in question.expressions.values() for s in e.xreplace(meaning).free_symbols}
    names = [plain_name(q) for q in (*system.coordinates, *system.velocities) if q in held]
    elapsed = question.grid - question.grid[0]
    return timed(lambda: form.at(elapsed, names))[1]


def _again(question: BenchMotion, asked: Sequence[Any], seen: Trajectory) -> Stepper | None:
    """The integrator of a motion that was seen, made once more, to be run many times; None where
    what it makes is not the same motion."""
    form, cost = question.equations.raw.form, seen.cost
    grid, time = question.grid, float(question.grid[0])
    start = np.array([question.initial[str(s)] for s in (*form.coordinates, *form.velocities)])
    vocabulary = Vocabulary.of(question.equations)
    for followed in (False, True):
        made = modelled(vocabulary, asked, {}, start, question.parameters, time, followed)
        state, values = made.place(start, question.parameters, time)
        probe = made.probe(question.system.name, values, time)
        problem = Problem(made.program, state, values, cost.tolerance, suspect=probe.suspect(state))
        stepper, _ = through_charts(
            cost.method, problem, grid, question.equations, made.event_functions, made.form
        )
        if made.level == cost.level and stepper(grid).steps == cost.steps:
            return stepper
    return None


def _refuse_long(question: BenchMotion, first: float) -> None:
    """Raise ``NotHere`` where arbitrary precision would keep everybody waiting."""
    seconds = first * (len(question.grid) - 1)
    if seconds > LONGEST:
        raise NotHere(f"would take about {seconds:.0f} s a run; take a shorter time")


def _outcome(question: BenchMotion, trajectory: Trajectory, seconds: float) -> Outcome:
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
    _own(CLOSED, "ours: the motion in closed form, evaluated", CLOSED, (1e-16,), False),
    _own("flint", "ours: Taylor method in any precision", "flint", (EXACT,), False),
)

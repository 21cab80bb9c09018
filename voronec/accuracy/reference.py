"""A motion of proved accuracy: two independent runs in many digits that agree.

One run is made on the coordinates, one on the invariants where the outputs have a meaning there:
equations derived apart, with other cancellations.  Where it can be, the two are also different
integrators.  Their difference is the accuracy that is stated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np

from voronec.accuracy.precise_motion import precise_integrator
from voronec.accuracy.problem import ProblemFormulation, ReferenceProblem, formulation
from voronec.accuracy.solution import UNIT, ReferenceSolution, agreement
from voronec.errors import DefinitionError, EngineLimit, IntegrationError, VoronecError
from voronec.motion import integrate
from voronec.motion.methods import METHODS

ACCURACY = 1e-13
"""The accuracy that a reference must have, relative to the size of each output."""
DIGITS = (24, 32, 50)
"""The digits of the runs; the next number is tried where one does not suffice."""
CROSS_SPAN = 60.0
"""Over so many units of time a closed form is held against an integration."""
CROSS_INSTANTS = 41
"""At so many instants."""
LONG = 60.0
"""Beyond this span, in units of time, flint is left out where heyoka can run both."""

Values = Mapping[str, np.ndarray]
Run = tuple[str, Callable[[], Values]]
"""What a run is called, and the run: output to values on the grid."""


def reference(problem: ReferenceProblem, needed: float = ACCURACY) -> ReferenceSolution:
    """The motion of a problem, to ``needed`` or better on the part of its grid that is returned.

    Where the system declares its motion in closed form, that is the reference, on any grid, and
    another run of many digits agrees with it over the first ``CROSS_SPAN`` units of time.  Raises
    ``EngineLimit`` where no two independent runs can be made, and ``IntegrationError`` where
    two agree on no part of the grid.
    """
    best = closed_form_reference(problem, needed)
    for digits in () if best is not None else DIGITS:
        runs = [(name, run()) for name, run in _two_runs(problem, digits)]
        agreed = agreement(problem.grid, runs, needed, problem.angles)
        if agreed is not None and (best is None or len(agreed.t) > len(best.t)):
            best = agreed
        if best is not None and len(best.t) == len(problem.grid):
            break
    if best is None:
        raise IntegrationError(
            f"system '{problem.system.name}': two runs of {DIGITS[-1]} digits agree to {needed:g} "
            "on no part of the grid, so there is no reference; take a shorter time"
        )
    return replace(best, accuracy=max(best.accuracy, UNIT))


def closed_form_reference(problem: ReferenceProblem, needed: float) -> ReferenceSolution | None:
    """The enclosed motion, where there is one and an independent run agrees with it."""
    if problem.system.motion is None:
        return None
    start, end = float(problem.grid[0]), float(problem.grid[-1])
    crossed = problem
    if problem.span > CROSS_SPAN:
        last = start + CROSS_SPAN * (1 if end > start else -1)
        crossed = replace(problem, grid=np.linspace(start, last, CROSS_INSTANTS))
    try:
        name, run = _two_runs(crossed, DIGITS[0])[0]
        said = f"the closed form, enclosed to {DIGITS[0] + 5} digits"
        runs = [(said, closed_form_values(crossed)), (name, run())]
        agreed = agreement(crossed.grid, runs, needed, problem.angles)
        if agreed is None or len(agreed.t) < len(crossed.grid):
            return None
        if crossed is problem:
            return agreed
        values = {n: np.asarray(x, dtype=float) for n, x in closed_form_values(problem).items()}
    except (DefinitionError, EngineLimit, IntegrationError):
        return None
    note = f"the two agree up to t = {last:g}; later there is the closed form alone, enclosed"
    return replace(agreed, t=problem.grid, values=values, note=note)


def closed_form_values(problem: ReferenceProblem) -> Values:
    """The outputs as the declared motion gives them, enclosed to more digits than doubles hold."""
    return _values_by(problem, "closed-form", DIGITS[0] + 5)


def taylor_values(at: ProblemFormulation, tol: float) -> Values:
    """The outputs by heyoka's Taylor method in an arithmetic that holds a tolerance; raises
    ``EngineLimit`` without heyoka, ``IntegrationError`` where steps shrink to nothing."""
    passage = precise_integrator(at, tol, varied=False).follow(at.problem.grid)
    named = dict(zip(at.program.names, passage.outputs.T, strict=True))
    return {n: named[n] for n in at.problem.outputs}


def _values_by(
    problem: ReferenceProblem, method: str, digits: int, besides: Sequence[str] = ()
) -> Values:
    """The outputs by a method of ours to so many digits, in a model that has others ``besides``."""
    trajectory = integrate(
        problem.equations, problem.bare, times=problem.grid, method=method,
        outputs=[*(problem.expressions[n] for n in problem.outputs), *besides],
        tol=10.0**-digits,
    )  # fmt: skip
    if trajectory.interrupted:
        raise KeyboardInterrupt
    return {n: trajectory[n] for n in problem.outputs}


def _two_runs(problem: ReferenceProblem, digits: int) -> Sequence[Run]:
    """The two most different runs there are."""
    taylor = [] if METHODS["heyoka"].absence else _taylor_runs(problem, digits)
    exact = _flint_runs(problem, digits)
    if exact and taylor and (problem.span <= LONG or len(taylor) == 1):
        return exact[-1], taylor[0]
    for runs in (taylor, exact):
        if len(runs) == 2:
            return runs
    raise EngineLimit(
        f"system '{problem.system.name}': no two independent high-precision runs are possible "
        "here, so there is no reference; install heyoka, or give outputs on the invariants"
    )


def _taylor_runs(problem: ReferenceProblem, digits: int) -> list[Run]:
    """heyoka on the coordinates, and on the invariants where the equations close on them."""
    formulations = [formulation(problem, "coordinates")]
    with suppress(VoronecError):
        formulations.append(formulation(problem, "invariants"))
    say = "heyoka's Taylor method with {} digits, on the {}"
    return [
        (say.format(digits, at.name), partial(taylor_values, at, 10.0**-digits))
        for at in formulations
    ]


def _flint_runs(problem: ReferenceProblem, digits: int) -> list[Run]:
    """Runs by our own arbitrary-precision integrator: of the full model, of the smallest one."""
    try:
        _values_by(replace(problem, grid=problem.grid[:1]), "flint", 20)
    except (DefinitionError, EngineLimit):
        return []
    say, state = "our Taylor method 'flint' with {} digits, on the {}", tuple(problem.initial)
    full = partial(_values_by, problem, "flint", digits, state)
    small = partial(_values_by, problem, "flint", digits + 5)
    return [
        (say.format(digits, "coordinates"), full),
        (say.format(digits + 5, "smallest model"), small),
    ]

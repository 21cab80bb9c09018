"""Measuring: every method and tolerance on one problem, against one reference.

Our methods take part as a user calls them, through ``integrate``; their time is what ``cost.cpu``
says of the run, the least of several calls.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from time import perf_counter
from typing import Any

import numpy as np

from voronec.accuracy.bench.call_time import SetupTime
from voronec.accuracy.bench.contender import Contender, NotHere, Outcome, Run, repeat
from voronec.accuracy.bench.measurement import Bench, Measured, Point
from voronec.accuracy.problem import ReferenceProblem
from voronec.accuracy.reference import ACCURACY, reference
from voronec.accuracy.solution import ReferenceSolution
from voronec.errors import DefinitionError, EngineLimit, VoronecError, did_you_mean
from voronec.motion import Trajectory, integrate
from voronec.motion.methods import CLOSED_FORM, METHODS

LONGEST = 30.0
"""Seconds beyond which the method of many digits is left out."""
TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12, 1e-14)
"""What methods are asked for, and the tolerance of each that shows it at its best."""
BUDGET = 20.0
"""Seconds that one run may take; a method goes no finer where the next would take longer."""
PACKAGES = "voronec heyoka scipy numba mujoco numpy sympy symengine python-flint".split()

Say = Callable[[str], None]


def _prepare(problem: ReferenceProblem, method: str, full: bool) -> Run:
    """A method of ours on the smallest model of the outputs, or on the ``full`` one."""
    outputs = [problem.expressions[n] for n in problem.outputs]
    if full:
        outputs += problem.initial

    def once(grid: np.ndarray, tol: float) -> Trajectory:
        return integrate(
            problem.equations, problem.bare, times=grid, outputs=outputs, method=method, tol=tol
        )

    try:
        once(problem.grid[:1], 1e-6)
        if METHODS[method].exact:
            first = once(problem.grid[:2], METHODS[method].best or 0.0).cost.run
            seconds = first * (len(problem.grid) - 1)
            if seconds > LONGEST:
                raise NotHere(f"would take about {seconds:.0f} s a run; take a shorter time")
    except (DefinitionError, EngineLimit) as refusal:
        raise NotHere(str(refusal)) from None

    def run(tol: float) -> Outcome:
        if not METHODS[method].exact:  # what compiles does so in the first run
            _require_end(once(problem.grid, tol))
        done = [one for one, _ in repeat(lambda: _require_end(once(problem.grid, tol)))]
        values = {n: np.asarray(done[-1][n], dtype=float) for n in problem.outputs}
        cost, drift = done[-1].cost, {n: float(x) for n, x in done[-1].drift.items()}
        seconds = min(float(one.cost.cpu) for one in done)
        return Outcome(values, seconds, cost.evaluations, cost.steps, drift)

    return run


def _require_end(trajectory: Trajectory) -> Trajectory:
    """The trajectory; ``KeyboardInterrupt`` where a hand stopped it."""
    if trajectory.interrupted:
        raise KeyboardInterrupt
    return trajectory


def _own(method: str, about: str, full: bool = False) -> Contender:
    """A method of ours at the tolerances that mean something to it, its best one last."""
    known = METHODS[method]
    best = known.finest if known.best is None else known.best
    coarser = () if known.exact or known.make is None else TOLERANCES
    tolerances = (*(tol for tol in coarser if tol > best), best)
    name = f"{method}-full" if full else method
    return Contender(
        name, f"ours: {about}", tolerances, partial(_prepare, method=method, full=full)
    )


OWN = (
    _own("heyoka", "Taylor method, smallest model"),
    _own("heyoka", "Taylor method, all coordinates", full=True),
    _own("scipy", "scipy's DOP853, smallest model"),
    _own("numba", "DOP853 compiled, smallest model"),
    _own("c", "the same by the C compiler"),
    _own("lsoda", "scipy's LSODA, smallest model"),
    _own(CLOSED_FORM, "the motion in closed form, evaluated"),
    _own("flint", "Taylor method in any precision"),
)
"""Our methods; peers, measured beside them by ``tools/bench.py``, are no part of the package."""


def contenders(
    names: Sequence[str] = (), among: Sequence[Contender] = OWN
) -> tuple[Contender, ...]:
    """The methods of these names, all by default; ``DefinitionError`` for one that is not."""
    known = {c.name: c for c in among}
    for name in names:
        if name not in known:
            raise DefinitionError(f"there is no method '{name}'{did_you_mean(name, known)}")
    return tuple(known[n] for n in dict.fromkeys(names)) if names else tuple(among)


def measure(
    problem: ReferenceProblem,
    methods: Sequence[str] = (),
    tolerances: Sequence[float] = (),
    needed: float = ACCURACY,
    budget: float = BUDGET,
    setup: Callable[[], SetupTime | None] | None = None,
    say: Say | None = None,
    against: ReferenceSolution | None = None,
    among: Sequence[Contender] = OWN,
) -> Bench:
    """Every method at every tolerance, against a reference accurate to ``needed``.

    ``tolerances`` replaces those of each method that has some; ``budget`` is the CPU time that one
    run may take.  ``setup`` measures the set-up; ``say`` is told what is going on; ``against`` is
    a reference that is known already; ``among`` are all methods that there are.  Ctrl-C keeps what
    is done and marks it.  Raises as ``reference`` does, and ``DefinitionError`` for a method or
    tolerance that makes no sense.
    """
    chosen = contenders(methods, among)
    for tol in tolerances:
        if not 0 < tol < 1:
            raise DefinitionError(f"the tolerance {tol:g} must lie between 0 and 1")
    tell = say or (lambda _text: None)
    ready = None
    if setup is not None:
        tell("set-up in fresh processes")
        ready = setup()
    tell("reference")
    exact = against or reference(problem, needed)
    seen = problem.until(float(exact.t[-1]))
    measurements: list[Measured] = []
    interrupted = False
    for contender in chosen:
        points: list[Point] = []
        try:
            tell(contender.name)
            measurements.append(_measure(contender, seen, exact, tolerances, budget, points, tell))
        except KeyboardInterrupt:
            interrupted = True
            if points:
                measurements.append(
                    Measured(contender.name, contender.about, contender.knob, points=tuple(points))
                )
            break
    return Bench(problem, exact, tuple(measurements), _machine(), ready, interrupted)


def _measure(
    contender: Contender,
    problem: ReferenceProblem,
    exact: ReferenceSolution,
    tolerances: Sequence[float],
    budget: float,
    points: list[Point],
    tell: Say,
) -> Measured:
    """One method; its runs are put into ``points`` as they are done, so that Ctrl-C keeps them."""
    said = (contender.name, contender.about, contender.knob)
    began = perf_counter()
    try:
        run = contender.prepare(problem)
    except NotHere as absence:
        return Measured(*said, absent=str(absence))
    ready, note = perf_counter() - began, ""
    preset = contender.knob != "tolerance" or not tolerances
    settings = contender.tolerances if preset else sorted(tolerances, reverse=True)
    for setting in settings:
        predicted = _next_cost(points, problem.span, setting)
        if predicted > budget:
            note = f"{contender.knob} {setting:g} and finer left out: over {budget:g} s a run"
            break
        tell(f"{contender.name} at {contender.knob} {setting:g}")
        points.append(_point(run, setting, problem, exact))
    return Measured(*said, setup=ready, points=tuple(points), note=note)


def _next_cost(points: Sequence[Point], span: float, setting: float) -> float:
    """What a run may be expected to take: as the last, times the ratio of the steps at worst."""
    done = [p for p in points if not p.failed]
    if not done:
        return 0.0
    growth = min(done[-1].setting / setting, 3.0)
    return done[-1].per_unit * span * growth


def _point(run: Run, setting: float, problem: ReferenceProblem, exact: ReferenceSolution) -> Point:
    try:
        outcome = run(setting)
    except VoronecError as failure:
        return Point(setting, failed=str(failure))
    except (ArithmeticError, ValueError, RuntimeError) as failure:
        return Point(setting, failed=f"{type(failure).__name__}: {failure}")
    apart = exact.errors(outcome.values, problem.angles)
    errors = {n: float(e.max()) for n, e in apart.items()}
    worst = max(errors.values())
    if not np.isfinite(worst):
        return Point(setting, failed="the outputs are not finite")
    return Point(
        setting=setting,
        error=max(worst, exact.accuracy),
        per_unit=outcome.seconds / problem.span,
        evaluations=outcome.evaluations,
        steps=outcome.steps,
        errors=errors,
        drift=dict(outcome.drift),
    )


def _machine() -> Mapping[str, str]:
    machine: dict[str, Any] = {
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
    }
    for package in PACKAGES:
        try:
            machine[package] = version(package)
        except PackageNotFoundError:
            continue
    return machine

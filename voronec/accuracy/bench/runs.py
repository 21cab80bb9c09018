"""Measuring: every method and tolerance on one question, against one reference.

Our own integrators take part as a user calls them, through ``integrate``; their time is that of the
same prepared integrator run again and again, as the peers' is.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from time import perf_counter
from typing import Any

import numpy as np

from voronec.accuracy.bench.agreement import ACCURACY, reference
from voronec.accuracy.bench.call_time import SetupTime
from voronec.accuracy.bench.contender import Contender, NotHere, Outcome, Run, time_fastest
from voronec.accuracy.bench.measurement import Bench, Measured, Point
from voronec.accuracy.bench.peers import PEERS
from voronec.accuracy.problem import ReferenceProblem
from voronec.accuracy.reference import ReferenceSolution
from voronec.algebra.symbols import plain_name
from voronec.errors import DefinitionError, EngineLimit, VoronecError, did_you_mean
from voronec.motion import Trajectory, integrate
from voronec.motion.chart_stepper import through_charts
from voronec.motion.closed_form import closed_form
from voronec.motion.methods import CLOSED_FORM
from voronec.motion.numeric_model import make_model
from voronec.motion.request import Vocabulary
from voronec.motion.steppers import Problem, Stepper

__all__ = ["CONTENDERS", "contenders", "measure", "outcome_of", "repetition"]

EXACT = 1e-20
"""The tolerance of the arbitrary-precision method."""
LONGEST = 30.0
"""Seconds beyond which it is left out."""

COARSE_TO_FINE = (1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16)
DOUBLE_TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12, 2.3e-14)
"""What is asked of Taylor's method, and of those whose finest is scipy's."""


def _prepare(question: ReferenceProblem, method: str, full: bool) -> Run:
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
        if method == CLOSED_FORM:
            seconds = _evaluation_time(question)
        elif method != "flint" and not trajectory.interrupted:
            if tol not in made:
                made[tol] = repetition(question, asked, trajectory)
            stepper = made[tol]
            if stepper is not None:
                seconds = time_fastest(lambda: stepper(question.grid))[1]
        return outcome_of(question, trajectory, seconds)

    return run


def _evaluation_time(question: ReferenceProblem) -> float:
    """CPU time of evaluating the coordinates and velocities that the outputs hold."""
    system = question.system
    form = closed_form(question.equations, question.bare)
    meaning = dict(zip(system.invariant_symbols, system.invariants.values(), strict=True))
    held = {s for e in question.expressions.values() for s in e.xreplace(meaning).free_symbols}
    names = [plain_name(q) for q in (*system.coordinates, *system.velocities) if q in held]
    elapsed = question.grid - question.grid[0]
    return time_fastest(lambda: form.at(elapsed, names))[1]


def repetition(
    question: ReferenceProblem, asked: Sequence[Any], seen: Trajectory
) -> Stepper | None:
    """The integrator of a motion that was seen, made once more, to be run many times; None where
    what it makes is not the same motion."""
    form, cost = question.equations.raw.form, seen.cost
    grid, time = question.grid, float(question.grid[0])
    start = np.array([question.initial[str(s)] for s in (*form.coordinates, *form.velocities)])
    vocabulary = Vocabulary.of(question.equations)
    for followed in (False, True):
        made = make_model(vocabulary, asked, {}, start, question.parameters, time, followed)
        state, values = made.place(start, question.parameters, time)
        probe = made.probe(question.system.name, values, time)
        problem = Problem(made.program, state, values, cost.tolerance, suspect=probe.suspect(state))
        stepper, _ = through_charts(
            cost.method, problem, grid, question.equations, made.event_functions, made.form
        )
        if made.level == cost.level and stepper(grid).steps == cost.steps:
            return stepper
    return None


def _refuse_long(question: ReferenceProblem, first: float) -> None:
    """Raise ``NotHere`` where arbitrary precision would keep everybody waiting."""
    seconds = first * (len(question.grid) - 1)
    if seconds > LONGEST:
        raise NotHere(f"would take about {seconds:.0f} s a run; take a shorter time")


def outcome_of(question: ReferenceProblem, trajectory: Trajectory, seconds: float) -> Outcome:
    """What a run gave, cost and drifts with it; ``KeyboardInterrupt`` where a hand stopped it."""
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
    _own("scipy", "ours: scipy's DOP853, smallest model", "scipy", DOUBLE_TOLERANCES, False),
    _own("numba", "ours: DOP853 compiled, smallest model", "numba", DOUBLE_TOLERANCES, False),
    _own("c", "ours: the same by the C compiler", "c", DOUBLE_TOLERANCES, False),
    _own("python", "ours: the same in Python alone", "python", DOUBLE_TOLERANCES, False),
    _own("lsoda", "ours: scipy's LSODA, smallest model", "lsoda", DOUBLE_TOLERANCES[:-1], False),
    _own(CLOSED_FORM, "ours: the motion in closed form, evaluated", CLOSED_FORM, (1e-16,), False),
    _own("flint", "ours: Taylor method in any precision", "flint", (EXACT,), False),
)


CONTENDERS = (*OWN, *PEERS)
"""Everything that can be measured."""
BUDGET = 20.0
"""Seconds that one run may take; a method goes no finer where the next would take longer."""
PACKAGES = "voronec heyoka scipy numba mujoco numpy sympy symengine python-flint".split()

Say = Callable[[str], None]


def contenders(names: Sequence[str] = ()) -> tuple[Contender, ...]:
    """The methods of these names, all by default; ``DefinitionError`` for one that is not."""
    known = {c.name: c for c in CONTENDERS}
    for name in names:
        if name not in known:
            raise DefinitionError(f"there is no method '{name}'{did_you_mean(name, known)}")
    return tuple(known[n] for n in dict.fromkeys(names)) if names else CONTENDERS


def measure(
    question: ReferenceProblem,
    methods: Sequence[str] = (),
    tolerances: Sequence[float] = (),
    needed: float = ACCURACY,
    budget: float = BUDGET,
    setup: Callable[[], SetupTime | None] | None = None,
    say: Say | None = None,
    against: ReferenceSolution | None = None,
) -> Bench:
    """Every method at every tolerance, against a reference accurate to ``needed``.

    ``tolerances`` replaces those of each method that has some; ``budget`` is the CPU time that one
    run may take.  ``setup`` measures the set-up; ``say`` is told what is going on; ``against`` is
    a reference that is known already.  Ctrl-C keeps what is done and marks it.  Raises as
    ``reference`` does, and ``DefinitionError`` for a method or tolerance that makes no sense.
    """
    chosen = contenders(methods)
    for tol in tolerances:
        if not 0 < tol < 1:
            raise DefinitionError(f"the tolerance {tol:g} must lie between 0 and 1")
    tell = say or (lambda _text: None)
    ready = None
    if setup is not None:
        tell("set-up in fresh processes")
        ready = setup()
    tell("reference")
    exact = against or reference(question, needed)
    seen = question.until(float(exact.t[-1]))
    found: list[Measured] = []
    interrupted = False
    for contender in chosen:
        points: list[Point] = []
        try:
            tell(contender.name)
            found.append(_measure(contender, seen, exact, tolerances, budget, points, tell))
        except KeyboardInterrupt:
            interrupted = True
            if points:
                found.append(
                    Measured(contender.name, contender.about, contender.knob, points=tuple(points))
                )
            break
    return Bench(question, exact, tuple(found), _machine(), ready, interrupted)


def _measure(
    contender: Contender,
    question: ReferenceProblem,
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
        run = contender.prepare(question)
    except NotHere as absence:
        return Measured(*said, absent=str(absence))
    ready, note = perf_counter() - began, ""
    own = contender.knob != "tolerance" or not tolerances
    settings = contender.tolerances if own else sorted(tolerances, reverse=True)
    for setting in settings:
        predicted = _next_cost(points, question.span, setting)
        if predicted > budget:
            note = f"{contender.knob} {setting:g} and finer left out: over {budget:g} s a run"
            break
        tell(f"{contender.name} at {contender.knob} {setting:g}")
        points.append(_point(run, setting, question, exact))
    return Measured(*said, setup=ready, points=tuple(points), note=note)


def _next_cost(points: Sequence[Point], span: float, setting: float) -> float:
    """What a run may be expected to take: as the last, times the ratio of the steps at worst."""
    done = [p for p in points if not p.failed]
    if not done:
        return 0.0
    growth = min(done[-1].setting / setting, 3.0)
    return done[-1].per_unit * span * growth


def _point(run: Run, setting: float, question: ReferenceProblem, exact: ReferenceSolution) -> Point:
    try:
        outcome = run(setting)
    except VoronecError as failure:
        return Point(setting, failed=str(failure))
    except (ArithmeticError, ValueError, RuntimeError) as failure:
        return Point(setting, failed=f"{type(failure).__name__}: {failure}")
    apart = exact.errors(outcome.values, question.angles)
    errors = {n: float(e.max()) for n, e in apart.items()}
    worst = max(errors.values())
    if not np.isfinite(worst):
        return Point(setting, failed="the outputs are not finite")
    return Point(
        setting=setting,
        error=max(worst, exact.accuracy),
        per_unit=outcome.seconds / question.span,
        evaluations=outcome.evaluations,
        steps=outcome.steps,
        errors=errors,
        drift=dict(outcome.drift),
    )


def _machine() -> Mapping[str, str]:
    found: dict[str, Any] = {
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
    }
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found

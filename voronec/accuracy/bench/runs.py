"""Measuring: every method and tolerance on one question, against one reference."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from time import perf_counter
from typing import Any

import numpy as np

from voronec.accuracy.bench.agreement import NEEDED, Reference, difference, reference
from voronec.accuracy.bench.contender import Contender, NotHere, Outcome, Run
from voronec.accuracy.bench.own_methods import OWN
from voronec.accuracy.bench.peers import PEERS
from voronec.accuracy.bench.question import BenchMotion
from voronec.accuracy.bench.record import Bench, Measured, Point
from voronec.accuracy.bench.setup_time import SetupTime
from voronec.errors import DefinitionError, VoronecError, did_you_mean

__all__ = ["CONTENDERS", "contenders", "measure"]

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
    question: BenchMotion,
    methods: Sequence[str] = (),
    tolerances: Sequence[float] = (),
    needed: float = NEEDED,
    budget: float = BUDGET,
    setup: Callable[[], SetupTime | None] | None = None,
    say: Say | None = None,
    against: Reference | None = None,
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
            found.append(_measured(contender, seen, exact, tolerances, budget, points, tell))
        except KeyboardInterrupt:
            interrupted = True
            if points:
                found.append(
                    Measured(contender.name, contender.about, contender.knob, points=tuple(points))
                )
            break
    return Bench(question, exact, tuple(found), _machine(), ready, interrupted)


def _measured(
    contender: Contender,
    question: BenchMotion,
    exact: Reference,
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


def _point(run: Run, setting: float, question: BenchMotion, exact: Reference) -> Point:
    try:
        outcome = run(setting)
    except VoronecError as failure:
        return Point(setting, failed=str(failure))
    except (ArithmeticError, ValueError, RuntimeError) as failure:
        return Point(setting, failed=f"{type(failure).__name__}: {failure}")
    errors = _errors(outcome, question, exact)
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


def _errors(outcome: Outcome, question: BenchMotion, exact: Reference) -> dict[str, float]:
    return {
        n: float(difference(outcome.values[n], exact.values[n], n in question.angles).max())
        for n in question.outputs
    }


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

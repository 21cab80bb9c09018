"""The problems that methods and peers are measured on, and what they cost at equal error."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache

import voronec as vo
from figures.chain import SYSTEM
from figures.peers import PEERS
from figures.race import OneRun, Race, clock, race
from voronec.accuracy.bench import (
    OWN,
    Measured,
    ReferenceProblem,
    ReferenceSolution,
    contenders,
    measure,
    reference,
    scene_problem,
)
from voronec.motion.methods import METHODS


@dataclass(frozen=True)
class Extent:
    """How far measurements go: a factor on all spans of time, numbers of starts, repetitions."""

    spans: float = 1.0
    starts: Sequence[int] = (1, 10, 100, 1000, 10_000)
    rounds: int = 5


FULL = Extent()
SHORT = Extent(0.02, (1, 8), 1)
"""So far only that everything is called; figures mean nothing then."""

BALL = "ball on a sphere"
PROBLEMS: dict[str, Callable[[float], ReferenceProblem]] = {
    BALL: lambda span: scene_problem(vo.load("ball-on-sphere"), time=span, instants=51),
    "Demchenko's ball": lambda span: scene_problem(
        vo.load("demchenko"), time=span, outputs=("u",), instants=51
    ),
    "rattleback": lambda span: scene_problem(vo.load("rattleback"), time=span, instants=51),
    "Chaplygin's ball": lambda span: scene_problem(
        vo.load("chaplygin-ball"), time=span, instants=11
    ),
    "chain of seven bodies": lambda span: scene_problem(SYSTEM, time=span, instants=2),
    "bicycle": lambda span: scene_problem(vo.load("bicycle"), time=span, instants=2),
}
FEW = (1e-10, 1e-11, 1e-13, 3e-14)
"""Of a slow method: where DOP853's errors over long spans lie around 1e-6 and 1e-9."""


@cache
def problem(name: str, span: float) -> ReferenceProblem:
    """A problem of the table over a span of time."""
    return PROBLEMS[name](span)


@cache
def exact(name: str, span: float) -> ReferenceSolution:
    """Its motion by two independent runs."""
    return reference(problem(name, span), 1e-12)


@cache
def auto_method(name: str, span: float) -> str:
    """The method that ``auto`` takes for it."""
    asked = problem(name, span)
    outputs = [asked.expressions[n] for n in asked.outputs]
    run = vo.integrate(asked.equations, asked.bare, times=asked.grid, outputs=outputs, tol=1e-9)
    return run.cost.method


@cache
def measurement(name: str, method: str, span: float) -> Measured:
    """One method or peer on a problem."""
    tolerances = FEW if "lambdify" in method else ()
    bench = measure(
        problem(name, span), [method], tolerances, budget=60.0, against=exact(name, span),
        among=(*OWN, *PEERS),
    )  # fmt: skip
    return bench[method]


def around(
    name: str, methods: Iterable[str], errors: Iterable[float], span: float, rounds: int
) -> Race:
    """Methods on a problem in turn, at the errors; ours in whole calls too."""
    known = {method: measurement(name, method, span) for method in methods}
    first = {
        method: {p.setting: OneRun(p.error, {"run": p.per_unit * span}) for p in one.good}
        for method, one in known.items()
    }
    runs = {m: _runs(problem(name, span), one) for m, one in known.items() if not one.absent}
    return race(runs, first, errors, rounds)


def _runs(asked: ReferenceProblem, one: Measured) -> Callable[[float], OneRun]:
    """One method, run again at settings whose errors are known."""
    (contender,) = contenders([one.name], (*OWN, *PEERS))
    run, errors = contender.prepare(asked), {p.setting: p.error for p in one.good}
    outputs = [asked.expressions[n] for n in asked.outputs]

    def once(tol: float) -> OneRun:
        seconds = {"run": run(tol).seconds}
        if one.name in METHODS:
            seconds["whole"] = clock(
                lambda: vo.integrate(
                    asked.equations, asked.bare, times=asked.grid, outputs=outputs,
                    method=one.name, tol=tol,
                )
            )[1]  # fmt: skip
        return OneRun(errors[tol], seconds)

    return once

"""The problems that methods and peers are measured on, and what they cost at equal error."""

from __future__ import annotations

from collections.abc import Callable, Iterable
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

__all__ = ["FULL", "SHORT", "Extent", "around", "exact", "measurement", "problem"]


@dataclass(frozen=True)
class Extent:
    """How far measurements go: units of time of one motion, of many and of long ones; starts,
    crossings, repetitions, processes."""

    span: float = 1000.0
    many: float = 100.0
    long: float = 1e5
    starts: int = 1000
    crossings: int = 8000
    turns: int = 30
    rounds: int = 5
    processes: int = 3


FULL = Extent()
SHORT = Extent(20.0, 5.0, 200.0, 32, 4000, 2, 1, 1)
"""So far only that everything is called; figures mean nothing then."""

PROBLEMS: dict[str, Callable[[Extent], ReferenceProblem]] = {
    "ball on a sphere": lambda far: scene_problem(vo.load("ball-on-sphere"), time=far.span),
    "ball on a plane": lambda far: scene_problem(
        vo.load("chaplygin-ball"), time=far.many, instants=11
    ),
    "Demchenko": lambda far: scene_problem(vo.load("demchenko"), time=far.span, outputs=("u", "v")),
    "chain": lambda _: scene_problem(SYSTEM, instants=2),
    "bicycle": lambda _: scene_problem(vo.load("bicycle"), instants=2),
}
FEW = (1e-10, 1e-11, 1e-13, 3e-14)
"""Of a slow method: where DOP853's errors at T = 1000 lie around 1e-6 and 1e-9."""


@cache
def problem(name: str, extent: Extent) -> ReferenceProblem:
    """A problem of the table."""
    return PROBLEMS[name](extent)


@cache
def exact(name: str, extent: Extent) -> ReferenceSolution:
    """Its motion by two independent runs."""
    return reference(problem(name, extent), 1e-12)


@cache
def measurement(name: str, method: str, extent: Extent) -> Measured:
    """One method or peer on a problem."""
    tolerances = FEW if "lambdify" in method else ()
    bench = measure(
        problem(name, extent), [method], tolerances, budget=60.0, against=exact(name, extent),
        among=(*OWN, *PEERS),
    )  # fmt: skip
    return bench[method]


def around(name: str, methods: Iterable[str], errors: Iterable[float], extent: Extent) -> Race:
    """Methods on a problem in turn, at the errors; ours in whole calls too."""
    known = {method: measurement(name, method, extent) for method in methods}
    span = problem(name, extent).span
    first = {
        method: {p.setting: OneRun(p.error, {"run": p.per_unit * span}) for p in one.good}
        for method, one in known.items()
    }
    runs = {m: _runs(problem(name, extent), one) for m, one in known.items() if not one.absent}
    return race(runs, first, errors, extent.rounds)


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

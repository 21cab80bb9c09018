"""A method that takes part: how it is prepared, what one run of it gives, how it is timed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import process_time
from typing import Any

import numpy as np

from voronec.accuracy.problem import ProblemLevel, ReferenceProblem, level, lowest
from voronec.errors import VoronecError

__all__ = ["Contender", "NotHere", "Outcome", "time_fastest", "without"]

ENOUGH = 0.25
"""Seconds of CPU over which a run is repeated; the best of the repetitions counts."""
MOST = 25
"""So often at most."""


class NotHere(VoronecError):
    """A method that cannot take part: what is not installed, or what it cannot compute."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """One run: outputs on the grid, each of shape (k,), and its cost.

    ``seconds`` is CPU time without set-up; ``evaluations`` of the right-hand side (the Taylor
    method expands it once a step), 0 where the method does not say.
    """

    values: Mapping[str, np.ndarray]
    seconds: float
    evaluations: int
    steps: int
    drift: Mapping[str, float] = field(default_factory=dict)


Run = Callable[[float], Outcome]
"""One run at a tolerance."""


@dataclass(frozen=True)
class Contender:
    """A method by name; ``about`` says in a line what it is.

    ``prepare`` compiles what a question needs, and raises ``NotHere`` where it cannot.
    ``tolerances`` are what it runs at by default, in the order of rising cost; ``knob`` says what
    they are where they are no tolerances, and then nobody else's are taken.
    """

    name: str
    about: str
    tolerances: tuple[float, ...]
    prepare: Callable[[ReferenceProblem], Run]
    knob: str = "tolerance"


def time_fastest(run: Callable[[], Any]) -> tuple[Any, float]:
    """The result of the last repetition of a run, and the CPU time of the fastest."""
    best, spent, count, result = np.inf, 0.0, 0, None
    while count == 0 or (spent < ENOUGH and count < MOST):
        began = process_time()
        result = run()
        seconds = process_time() - began
        best, spent, count = min(best, seconds), spent + seconds, count + 1
    return result, best


def without(package: str) -> NotHere:
    """What is said where a package is missing."""
    return NotHere(f"not installed: {package}")


def level_for(question: ReferenceProblem, own: str = "") -> ProblemLevel:
    """The question on a level of its own, or on the lowest there is; ``NotHere`` without one."""
    try:
        return level(question, own) if own else lowest(question)
    except VoronecError as refusal:
        raise NotHere(str(refusal)) from None


def require_outputs(outputs: Sequence[str], offered: Sequence[str]) -> None:
    """Raise ``NotHere`` for outputs that a method does not compute."""
    absent = [name for name in outputs if name not in offered]
    if absent:
        raise NotHere(f"does not compute {', '.join(absent)}")

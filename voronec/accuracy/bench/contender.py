"""A method that takes part: how it is prepared, what one run of it gives, how it is timed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from time import process_time
from typing import Any

import numpy as np

from voronec.accuracy.problem import ReferenceProblem
from voronec.errors import VoronecError

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

    ``prepare`` compiles what a problem needs, and raises ``NotHere`` where it cannot.
    ``tolerances`` are what it runs at by default, in the order of rising cost; ``knob`` says what
    they are where they are no tolerances, and then nobody else's are taken.
    """

    name: str
    about: str
    tolerances: tuple[float, ...]
    prepare: Callable[[ReferenceProblem], Run]
    knob: str = "tolerance"


def repeat(run: Callable[[], Any]) -> list[tuple[Any, float]]:
    """The results of a run that is repeated, each with its CPU time."""
    done: list[tuple[Any, float]] = []
    while not done or (sum(seconds for _, seconds in done) < ENOUGH and len(done) < MOST):
        began = process_time()
        result = run()
        done.append((result, process_time() - began))
    return done


def time_fastest(run: Callable[[], Any]) -> tuple[Any, float]:
    """The result of the last repetition of a run, and the CPU time of the fastest."""
    done = repeat(run)
    return done[-1][0], min(seconds for _, seconds in done)

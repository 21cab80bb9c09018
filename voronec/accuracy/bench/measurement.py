"""What a measurement found, as values: for tables, for JSON, for the plot.

Methods are compared at equal error: what each costs where its error is the one asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from math import exp, isfinite, log
from typing import Any

import numpy as np

from voronec.accuracy.bench.call_time import SetupTime
from voronec.accuracy.problem import ReferenceProblem
from voronec.accuracy.solution import ReferenceSolution

AT = (1e-6, 1e-9)
"""The errors at which methods are compared."""


@dataclass(frozen=True)
class Point:
    """One run of one method.

    ``setting`` is the tolerance, or the step of a method that has none.  ``error`` is the largest
    of ``errors``, which are by output, over the whole grid, relative to the output's size; it is
    never given as less than the accuracy of the reference.  ``per_unit`` is CPU time in seconds
    per unit of time, without set-up.  ``failed`` says why there are no numbers.
    """

    setting: float
    error: float = float("nan")
    per_unit: float = float("nan")
    evaluations: int = 0
    steps: int = 0
    errors: Mapping[str, float] | None = None
    drift: Mapping[str, float] | None = None
    failed: str = ""


@dataclass(frozen=True)
class Measured:
    """One method: its runs, or in ``absent`` why there are none; ``setup`` in seconds."""

    name: str
    about: str
    knob: str = "tolerance"
    setup: float = 0.0
    points: tuple[Point, ...] = ()
    absent: str = ""
    note: str = ""

    @property
    def good(self) -> list[Point]:
        """The runs that succeeded."""
        return [p for p in self.points if not p.failed]

    @property
    def has_order(self) -> bool:
        """Whether its error falls as a power of its step, so that it may be extrapolated."""
        return self.knob != "tolerance"

    def at(self, error: float, extrapolate: bool = False) -> At:
        """CPU seconds per unit of time at an error."""
        return at_error([(p.error, p.per_unit) for p in self.good], error, extrapolate)


@dataclass(frozen=True, eq=False)
class Bench:
    """Every method and tolerance measured on one problem, against its reference."""

    problem: ReferenceProblem
    reference: ReferenceSolution
    methods: tuple[Measured, ...]
    machine: Mapping[str, str]
    setup: SetupTime | None = None
    interrupted: bool = False

    def __getitem__(self, name: str) -> Measured:
        return next(m for m in self.methods if m.name == name)

    def as_dict(self) -> dict[str, Any]:
        """All of it as plain data, for ``bench.json``."""
        problem, reference = self.problem, self.reference
        return {
            "system": problem.system.name,
            "scene": problem.scene,
            "times": [float(problem.grid[0]), float(problem.grid[-1])],
            "instants": len(problem.grid),
            "outputs": list(problem.outputs),
            "angles": sorted(problem.angles),
            "parameters": dict(problem.parameters),
            "initial": dict(problem.initial),
            "machine": dict(self.machine),
            "reference": {
                "accuracy": reference.accuracy,
                "how": list(reference.how),
                "until": float(reference.t[-1]),
                "note": reference.note,
            },
            "setup_seconds": None if self.setup is None else asdict(self.setup),
            "methods": [_method(m) for m in self.methods],
            "at_equal_error": [_equal(self, error) for error in AT],
            "interrupted": self.interrupted,
        }


def _method(measured: Measured) -> dict[str, Any]:
    return {
        "name": measured.name,
        "about": measured.about,
        "knob": measured.knob,
        "absent": measured.absent,
        "note": measured.note,
        "setup_seconds": measured.setup,
        "points": [_point(p) for p in measured.points],
    }


def _point(point: Point) -> dict[str, Any]:
    """A run; what is not a number becomes null, which JSON has."""
    record = asdict(point)
    record["seconds_per_unit"] = record.pop("per_unit")
    return {k: _finite(v) for k, v in record.items()}


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {k: _finite(v) for k, v in value.items()}
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _equal(bench: Bench, error: float) -> dict[str, Any]:
    rows = {}
    for measured in bench.methods:
        if not measured.absent:
            cost = measured.at(error, extrapolate=measured.has_order)
            rows[measured.name] = {"seconds_per_unit": cost.seconds, "kind": cost.kind}
    return {"error": error, "methods": rows}


@dataclass(frozen=True)
class At:
    """A cost at an error, and how it is known.

    ``kind`` is ``interpolated`` between two runs; ``at most`` where every run is better than asked,
    so that the cheapest is an upper bound; ``extrapolated`` along the observed order where no run
    is good enough and this was allowed; ``not reached``, with no ``seconds``, where it was not.
    """

    seconds: float | None
    kind: str


Pairs = Sequence[tuple[float, float]]
"""(error, seconds) of the runs of one method, from coarse to fine."""


def at_error(runs: Pairs, error: float, extrapolate: bool = False) -> At:
    """The cost of one method at an error, on straight lines between its runs in the logarithms.

    Never goes beyond the runs unless ``extrapolate`` is said, and then the answer says so.
    """
    known = [(e, s) for e, s in runs if isfinite(e) and isfinite(s) and e > 0 and s > 0]
    between = [
        _line(one, two, error) for one, two in pairwise(known) if _brackets(one[0], two[0], error)
    ]
    good = [s for e, s in known if e <= error]
    if between:
        # a run that is better and no dearer is an answer too
        return At(min([*between, *good]), "interpolated")
    if good:
        return At(min(good), "at most")
    order = observed_order(known)
    if extrapolate and order is not None:
        nearest = min(known)
        return At(nearest[1] * (nearest[0] / error) ** (1 / order), "extrapolated")
    return At(None, "not reached")


def observed_order(runs: Pairs) -> float | None:
    """p in error ~ cost^-p over the two best runs; None where it cannot be told."""
    ranked = sorted(runs)[:2]
    if len(ranked) < 2 or ranked[0][0] == ranked[1][0] or ranked[0][1] <= ranked[1][1]:
        return None
    (fine, dear), (coarse, cheap) = ranked
    return log(coarse / fine) / log(dear / cheap)


def _brackets(one: float, two: float, error: float) -> bool:
    return min(one, two) <= error <= max(one, two) and one != two


def _line(one: tuple[float, float], two: tuple[float, float], error: float) -> float:
    part = log(error / one[0]) / log(two[0] / one[0])
    return exp(log(one[1]) + part * log(two[1] / one[1]))

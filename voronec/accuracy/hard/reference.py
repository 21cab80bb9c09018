"""What the outputs of a case truly are, and its condition numbers.

The cases of this package have their references beside them in ``references.json``, each under a
digest of its declaration, so that nobody waits for them; others are computed on the spot.  A
reference is computed twice: by two forms of the equations, or on one at two tolerances, in many
digits; the larger difference of the two runs is kept as ``agreed``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from voronec.accuracy.hard.case import ARITHMETICS, HardCase
from voronec.accuracy.hard.closed import PreciseProblem, problem
from voronec.accuracy.hard.conditioning import condition_numbers, output_sizes
from voronec.accuracy.hard.multiprecision import reel
from voronec.accuracy.hard.periodic import folded, period
from voronec.accuracy.hard.perturbed import perturbed
from voronec.declaration.catalogue import load
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit, IntegrationError
from voronec.motion import integrate
from voronec.motion.closed_form import closed_form

__all__ = ["STORE", "Reference", "compute", "reference"]

STORE = Path(__file__).with_name("references.json")
TOLERANCES = {"quadruple": (1e-30, 1e-27), "extended": (3e-19, 1e-17)}
"""Of the first run, and of the second."""
IN_A_PERIOD = 20
"""At so many instants of a period an angle is looked at, to follow it."""
FOLLOWABLE = 4000
"""At so many instants at most."""
FOLLOWED = 2e5
"""A periodic motion is followed to the end, as a check of its period, up to this span."""


@dataclass(frozen=True, eq=False)
class Reference:
    """True outputs on the grid of a case, and how much they magnify relative changes.

    ``values`` and ``condition`` map the name of every output to arrays of shape (points,);
    ``agreed`` is the largest difference of two independent runs, relative to the largest value of
    an output; ``made`` says how they were made.
    """

    t: np.ndarray
    values: Mapping[str, np.ndarray]
    condition: Mapping[str, np.ndarray]
    agreed: float
    made: str

    @property
    def largest_condition(self) -> float:
        """The largest condition number of any output at any instant."""
        return max(float(c.max()) for c in self.condition.values())

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON; condition numbers to three digits."""
        return {
            "t": self.t.tolist(),
            "values": {n: x.tolist() for n, x in self.values.items()},
            "condition": {n: [float(f"{c:.3g}") for c in x] for n, x in self.condition.items()},
            "agreed": float(f"{self.agreed:.2g}"),
            "made": self.made,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Reference:
        """From plain data."""
        values, condition = (
            {n: np.array(x) for n, x in data[k].items()} for k in ("values", "condition")
        )
        agreed, made = float(data["agreed"]), str(data["made"])
        return cls(np.array(data["t"]), values, condition, agreed, made)


def reference(case: HardCase, equations: VoronecEquations | None = None) -> Reference:
    """The stored reference of a case; computed now where none is stored for its declaration.

    Raises ``EngineLimit`` where it must be computed and heyoka is not installed.
    """
    stored = _stored().get(case.name)
    if stored is not None and stored["digest"] == case.digest:
        return Reference.from_dict(stored)
    return compute(case, equations)


@cache
def _stored() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(STORE.read_text("utf-8")) if STORE.exists() else {}
    return found


def compute(case: HardCase, equations: VoronecEquations | None = None) -> Reference:
    """The reference of a case by two runs in many digits, and its condition numbers."""
    own = equations or derive(load(case.system))
    asked = problem(case, own)
    try:
        outputs, condition = _run(case, asked)
        again, how = _again(case, own, asked)
    except ImportError:
        values, slopes, agreed = perturbed(case, own)
        how = "25 digits on coordinates; against 21 digits, data changed in place of variations"
        return Reference(case.grid, values, slopes, agreed, how)
    apart = np.abs((outputs - again).astype(float)) / output_sizes(outputs)
    names = asked.program.names
    return Reference(
        case.grid,
        dict(zip(names, outputs.astype(float).T, strict=True)),
        dict(zip(names, condition.T, strict=True)),
        float(apart.max()),
        f"{ARITHMETICS[case.arithmetic]} digits on {case.level}; {how}",
    )


def _run(case: HardCase, asked: PreciseProblem) -> tuple[np.ndarray, np.ndarray]:
    """Outputs (k, m) and condition numbers (k, m)."""
    tol = TOLERANCES[case.arithmetic][0]
    machine = reel(asked, case.arithmetic, tol)
    if not case.period:
        passage = machine.follow(case.grid)
        return passage.outputs, condition_numbers(asked, passage)
    single = reel(asked, case.arithmetic, tol, varied=False)
    length = period(single, asked.names, case.period, float(case.scene.times[1]) / 100)
    whole = folded(machine, length, case.grid)
    return whole.outputs, whole.condition_numbers(asked)


def _again(case: HardCase, own: VoronecEquations, asked: PreciseProblem) -> tuple[np.ndarray, str]:
    """The outputs once more, as independently as may be, and how."""
    if case.period and float(case.scene.times[1]) > FOLLOWED:
        tol = TOLERANCES[case.arithmetic][1]
        single = reel(asked, case.arithmetic, tol, varied=False)
        length = period(single, asked.names, case.period, float(case.scene.times[1]) / 100)
        return folded(single, length, case.grid).outputs, "one period at two tolerances"
    if case.period:
        whole = reel(asked, "extended", TOLERANCES["extended"][0], varied=False)
        return whole.follow(case.grid).outputs, "one period against the whole span"
    found = _in_closed_form(case, own, asked)
    if found is not None:
        return found, "against the closed form"
    tol = TOLERANCES[case.arithmetic][1]
    try:
        raw = case.level == "coordinates"
        other = problem(replace(case, level="coordinates"), own, raw)
        found = reel(other, case.arithmetic, tol, varied=False).follow(case.grid).outputs
        if np.isfinite(found.astype(float)).all():
            return found, f"against the {'unsimplified ' if raw else ''}equations on coordinates"
    except IntegrationError:
        pass  # a pole on the way: then at another tolerance
    found = reel(asked, case.arithmetic, tol, varied=False).follow(case.grid).outputs
    return found, "against another tolerance"


def _in_closed_form(
    case: HardCase, own: VoronecEquations, asked: PreciseProblem
) -> np.ndarray | None:
    """The outputs by the declared motion, where there is one that can be followed: where the vector
    in space is not upright, angles are continuous only on a fine grid."""
    if own.system.motion is None:
        return None
    try:
        form = closed_form(own, case.scene)
    except EngineLimit:
        return None
    finer = 1
    if form.attitude is not None and not form.attitude.upright:
        finer = ceil(IN_A_PERIOD * abs(case.grid[1] - case.grid[0]) / min(form.period, 1.0))
    if finer * len(case.grid) > FOLLOWABLE:
        return None
    steps = np.arange(finer * (len(case.grid) - 1) + 1)
    grid = np.interp(steps / finer, np.arange(len(case.grid)), case.grid)
    grid[::finer] = case.grid
    tol = TOLERANCES[case.arithmetic][0]
    seen = integrate(own, case.scene, times=grid, method="closed-form", tol=tol)
    return np.stack([seen[name][::finer] for name in asked.program.names], axis=-1)

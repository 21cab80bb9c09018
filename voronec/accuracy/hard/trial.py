"""One method on one case: error, drift and time, or a refusal; and what to make of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from voronec.accuracy.hard.case import HardCase
from voronec.accuracy.hard.conditioning import UNIT, output_sizes
from voronec.accuracy.hard.reference import Reference
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit, IntegrationError
from voronec.motion import Trajectory, integrate
from voronec.motion.methods import METHODS
from voronec.motion.tolerances import EXACT

__all__ = ["FLOOR", "ROUNDINGS", "Trial", "attempt", "bound"]

FLOOR = 1e-10
"""An error below this is good, whatever the condition."""
ROUNDINGS = 100
"""How many roundings, each magnified by the condition, are allowed."""
TOLERANCES = {"auto": EXACT, "default": 1e-13}
"""What the tool's own choice is asked for: the finest that doubles allow, so that its best is
shown, as that of each method is; and ``default``, the tolerance of who gives none."""
KEPT = 1e-12
"""The drift of integrals that is allowed where the motion itself cannot be had."""


@dataclass(frozen=True)
class Trial:
    """A method on a case.

    ``error`` is the largest difference from the reference over outputs and instants, relative to
    the largest value of the output; ``condition`` is the largest condition number; ``roundings``
    is the largest error divided by u and the condition number at its instant: the error made, with
    the error grown taken away; ``drift`` is the largest drift of an integral.  ``verdict`` is
    ``met``, ``missed``, ``refused`` (``reason`` says why), ``lost`` (past the horizon, where no
    double determines the motion, and integrals drift), ``kept`` (there, and they hold) or
    ``unjudged`` (no reference can be had here).
    """

    case: str
    method: str
    verdict: str
    chosen: str = ""
    error: float = np.nan
    condition: float = np.nan
    roundings: float = np.nan
    worst: str = ""
    drift: float = np.nan
    seconds: float = np.nan
    reason: str = ""
    automatic: bool = False

    @property
    def good(self) -> bool:
        """Whether nothing is silently wrong."""
        return self.verdict in ("met", "kept", "refused")

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON; what is not known is None."""
        return {k: None if x != x else x for k, x in vars(self).items()}


def bound(reference: Reference) -> Mapping[str, np.ndarray]:
    """The error that every output is allowed at every instant: max(1e-10, 100 u kappa)."""
    return {n: np.maximum(FLOOR, ROUNDINGS * UNIT * c) for n, c in reference.condition.items()}


def _tolerance(method: str) -> float:
    if method in TOLERANCES:
        return TOLERANCES[method]
    asked = METHODS[method]
    return asked.finest if asked.best is None else asked.best


def attempt(
    case: HardCase, equations: VoronecEquations, method: str, reference: Reference | None
) -> Trial:
    """Integrate a case by a method, and judge it by its reference.

    Without a reference (a case that no motion starts in) only a refusal is right.
    """
    began = perf_counter()
    try:
        trajectory = integrate(
            equations, scene=case.scene, times=case.grid,
            method="auto" if method == "default" else method, tol=_tolerance(method),
        )  # fmt: skip
    except (IntegrationError, EngineLimit, DefinitionError) as refusal:
        return Trial(
            case.name, method, "refused", reason=str(refusal), seconds=perf_counter() - began,
            automatic=method == "auto",
        )  # fmt: skip
    if trajectory.interrupted:
        raise KeyboardInterrupt
    return judge(case, method, trajectory, reference)


def judge(
    case: HardCase, method: str, trajectory: Trajectory, reference: Reference | None
) -> Trial:
    """What to make of a trajectory."""
    drift = max(trajectory.drift.values(), default=np.nan)
    told: dict[str, Any] = {
        "chosen": trajectory.cost.method, "drift": float(drift),
        "seconds": trajectory.cost.run, "automatic": method == "auto",
    }  # fmt: skip
    if reference is None:
        why = "a motion was computed where none starts"
        return Trial(case.name, method, "missed", reason=why, **told)
    allowed = bound(reference)
    errors = {n: _error(trajectory[n], x) for n, x in reference.values.items()}
    worst = max(errors, key=lambda n: _largest(errors[n] / allowed[n]))
    made = {n: errors[n] / (UNIT * c) for n, c in reference.condition.items()}
    met = all((errors[n] <= allowed[n]).all() for n in errors)
    verdict = "met" if met else "missed"
    if min(x.max() for x in allowed.values()) > 1:
        verdict = "kept" if drift <= KEPT else "lost"
    return Trial(
        case.name, method, verdict, error=max(map(_largest, errors.values())),
        condition=reference.largest_condition, roundings=max(map(_largest, made.values())),
        worst=worst, **told,
    )  # fmt: skip


def _error(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """The difference relative to the largest true value; infinite where no number came out."""
    (size,) = output_sizes(true[:, None])
    apart = np.abs((found - true).astype(float)) / size
    return np.where(np.isfinite(apart), apart, np.inf)


def _largest(values: np.ndarray) -> float:
    return float(values.max())

"""One method on one case: error, drift and time, or a refusal; and what to make of it.

``trials`` runs all methods on all cases, one after another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from voronec.accuracy.hard.case import HardCase
from voronec.accuracy.hard.reference import reference
from voronec.accuracy.solution import UNIT, ReferenceSolution
from voronec.declaration.catalogue import load
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit, IntegrationError
from voronec.motion import Trajectory, integrate
from voronec.motion.methods import METHODS
from voronec.motion.tolerances import EXACT

FLOOR = 1e-10
"""An error below this is good, whatever the condition."""
ROUNDINGS = 100
"""How many roundings, each magnified by the condition, are allowed."""
TOLERANCES = {"auto": EXACT, "default": 1e-13}
"""What the tool's own choice is asked for: the finest that doubles allow, so that its best is
shown, as that of each method is; and ``default``, the tolerance of who gives none."""
DRIFT = 1e-12
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


def bound(reference: ReferenceSolution) -> Mapping[str, np.ndarray]:
    """The error that every output is allowed at every instant: max(1e-10, 100 u kappa)."""
    return {n: np.maximum(FLOOR, ROUNDINGS * UNIT * c) for n, c in reference.condition.items()}


def _tolerance(method: str) -> float:
    if method in TOLERANCES:
        return TOLERANCES[method]
    asked = METHODS[method]
    return asked.finest if asked.best is None else asked.best


def attempt(
    case: HardCase, equations: VoronecEquations, method: str, reference: ReferenceSolution | None
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
    case: HardCase, method: str, trajectory: Trajectory, reference: ReferenceSolution | None
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
    apart = reference.errors({n: trajectory[n] for n in reference.values})
    errors = {n: np.where(np.isfinite(e), e, np.inf) for n, e in apart.items()}
    worst = max(errors, key=lambda n: _largest(errors[n] / allowed[n]))
    made = {n: errors[n] / (UNIT * c) for n, c in reference.condition.items()}
    met = all((errors[n] <= allowed[n]).all() for n in errors)
    verdict = "met" if met else "missed"
    if min(x.max() for x in allowed.values()) > 1:
        verdict = "kept" if drift <= DRIFT else "lost"
    return Trial(
        case.name, method, verdict, error=max(map(_largest, errors.values())),
        condition=reference.largest_condition, roundings=max(map(_largest, made.values())),
        worst=worst, **told,
    )  # fmt: skip


def _largest(values: np.ndarray) -> float:
    return float(values.max())


@dataclass(frozen=True, eq=False)
class CaseResult:
    """A case, its reference (None where no motion starts) and what every method made of it."""

    case: HardCase
    reference: ReferenceSolution | None
    trials: tuple[Trial, ...]

    @property
    def good(self) -> bool:
        """Whether the tool's own choice is never silently wrong."""
        return all(t.good for t in self.trials if t.automatic)


def trials(
    cases: Sequence[HardCase],
    methods: Sequence[str] = (),
    progress: Callable[[str], None] | None = None,
) -> Iterator[CaseResult]:
    """The findings case by case, each as soon as it is there.

    ``methods`` are those wanted, ``auto`` and ``default`` among them or not; by default these two
    (the tool's own choice at its finest, and at the tolerance of ``integrate``), whatever the case
    says is worth waiting for, and the closed form where the system declares one.  Where ``auto``
    takes a method that is tried as well, it is tried once and marked.  A case without a reference
    that can be had here is ``unjudged``.
    """
    derived: dict[str, VoronecEquations] = {}
    for position, case in enumerate(cases):
        say = progress or (lambda _: None)
        say(f"{position + 1}/{len(cases)} {case.name}: reference ...")
        if case.system not in derived:
            derived[case.system] = derive(load(case.system))
        equations = derived[case.system]
        attempts: list[Trial] = []
        try:
            known = reference(case, equations) if case.formulation else None
        except EngineLimit as limit:
            yield CaseResult(case, None, (Trial(case.name, "-", "unjudged", reason=str(limit)),))
            continue
        closed = (
            ("closed-form",) if case.formulation and equations.system.motion is not None else ()
        )
        there = [m for m in case.methods if not METHODS[m].absence]
        for method in methods or ("auto", "default", *there, *closed):
            if any(t.automatic and t.chosen == method for t in attempts):
                continue
            say(f"{position + 1}/{len(cases)} {case.name}: {method} ...")
            attempts.append(attempt(case, equations, method, known))
        yield CaseResult(case, known, tuple(attempts))

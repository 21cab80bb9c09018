"""What fails falls back before it refuses: other methods and models, one after another."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from math import isfinite

from voronec.errors import DefinitionError, EngineLimit, IntegrationError
from voronec.motion.methods import METHODS
from voronec.motion.trajectory import Trajectory

__all__ = ["Way", "first_success", "other_method"]

Way = Callable[[IntegrationError | None], Trajectory | None]
"""From the first error, where there was one, to a trajectory, or to None where the way is of no
use after that."""


def other_method(error: IntegrationError) -> str:
    """The method that may go on where the one of an error could not; empty where there is none.

    A singular mass matrix stops them all: a method that does not notice would be worse.
    """
    if error.singular or error.trajectory is None:
        return ""
    used = METHODS.get(error.trajectory.cost.method)
    return used.other if used is not None else ""


def first_success(ways: Iterable[Way], begin: float) -> Trajectory:
    """The trajectory of the first way that goes well; its ``cost`` says what did not.

    Where none does, the error of the one that came farthest from the time ``begin`` is raised.
    """
    errors: list[IntegrationError] = []
    for way in ways:
        try:
            found = way(errors[0] if errors else None)
            if found is not None:
                return _with_failures(found, errors)
        except IntegrationError as error:
            errors.append(error)
        except (DefinitionError, EngineLimit):
            if not errors:
                raise
    raise max(errors, key=lambda error: _reach(error, begin)) from None


def _reach(error: IntegrationError, begin: float) -> float:
    """How far a run came."""
    reach = abs(float(error.time) - begin) if error.time is not None else 0.0
    return reach if isfinite(reach) else 0.0


def _with_failures(trajectory: Trajectory, errors: list[IntegrationError]) -> Trajectory:
    """The trajectory, with what failed before it."""
    failed = [e.trajectory.cost for e in errors if e.trajectory is not None]
    if not failed:
        return trajectory
    times = [float(e.time) for e in errors if e.trajectory is not None]
    words = "; ".join(
        f"{c.method} in {c.level} fails after t = {t:.6g}"
        for c, t in zip(failed, times, strict=True)
    )
    cost = trajectory.cost
    own = cost.reason if cost.method == failed[0].method else "auto"
    return replace(trajectory, cost=replace(cost, reason=f"{own}: {words}"))

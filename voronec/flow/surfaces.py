"""A surface for a Poincare section where nobody names one: something that comes and goes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.equations import VoronecEquations
from voronec.errors import DefinitionError
from voronec.flow.ensembles import ensemble
from voronec.flow.given import scene_of
from voronec.flow.vocabulary import number

__all__ = ["Surface", "suggested"]

INSTANTS = 4001
RETURNS = 3
"""How often a quantity must come back within the trial."""
STILL = 1e-9
"""A quantity whose range is below this part of its size does not move."""
LONGER = 5.0
"""The trial, in spans of the scene."""


@dataclass(frozen=True)
class Surface:
    """plane = value, and what is worth recording there."""

    plane: str
    value: float
    outputs: tuple[str, ...]


def suggested(
    equations: VoronecEquations,
    scene: Any = None,
    initial: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    plane: str | None = None,
) -> Surface:
    """The first position or velocity that oscillates along the scene's motion, at zero or else at
    the middle of its range; and a further position and velocity that move.  Where ``plane`` names
    the surface, only the outputs are suggested.

    Positions are the invariants where the system descends to them.  ``DefinitionError`` with the
    names there are where nothing oscillates.
    """
    system = equations.system
    chosen = scene_of(system, scene, True)
    assert chosen is not None
    positions = [*system.invariants] or [plain_name(q) for q in system.coordinates]
    velocities = [plain_name(v) for v in system.velocities]
    start, end = (number(x, "the span's end") for x in chosen.times)
    grid = np.linspace(start, start + LONGER * (end - start), INSTANTS)
    names = [*positions, *velocities]
    trial = ensemble(
        equations, [dict(initial or {})], parameters, grid, names, scene=chosen, tol=1e-9
    )  # fmt: skip
    series = {name: x[0][np.isfinite(x[0])] for name, x in trial.series.items()}
    if plane is not None:
        return Surface(plane, 0.0, _others(series, plane, positions, velocities))
    for name in names:
        value = _passed(series[name])
        if value is not None:
            return Surface(name, value, _others(series, name, positions, velocities))
    raise DefinitionError(
        f"system '{system.name}': nothing oscillates along its motion, so no plane suggests "
        f"itself; name one with plane EXPR=VALUE in {', '.join(names)}"
    )


def _passed(x: np.ndarray) -> float | None:
    """A value that x passes upwards again and again: zero, or the middle of its range."""
    if len(x) < 2 or _still(x):
        return None
    middle = 0.5 * (x.min() + x.max())
    for value in (0.0, float(f"{middle:.3g}")):
        if np.sum((x[:-1] < value) & (x[1:] >= value)) >= RETURNS:
            return value
    return None


def _still(x: np.ndarray) -> bool:
    return bool(len(x) < 2 or np.ptp(x) <= STILL * max(1.0, np.abs(x).max()))


def _others(
    series: Mapping[str, np.ndarray], plane: str, positions: list[str], velocities: list[str]
) -> tuple[str, ...]:
    """A position and a velocity that move, or two of one kind."""
    moving = [n for n in (*positions, *velocities) if n != plane and not _still(series[n])]
    first = [n for n in moving if n in positions][:1]
    second = [n for n in moving if n in velocities][:1]
    rest = [n for n in moving if n not in (*first, *second)]
    return tuple([*first, *second, *rest][:2])

"""Starts that are alike: motions on which all integrals of a system have the same values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.equations import VoronecEquations
from voronec.errors import DefinitionError
from voronec.flow.many import Many, at_each, many
from voronec.program import Program, compiled
from voronec.scene import Scene

__all__ = ["starts_alike"]

EQUAL = 1e-12
"""How far the integrals may differ, relative to their size."""
TRIES = 40
"""Directions tried for each start that is wanted."""

Integrals = Callable[[np.ndarray], np.ndarray]
"""States (s, n) to the values (s, k) that all starts are to share."""


def starts_alike(
    equations: VoronecEquations,
    scene: Scene | None,
    initial: Mapping[Any, Any],
    parameters: Mapping[Any, Any],
    count: int,
) -> list[dict[str, float]]:
    """The start of the scene, and others in all directions about it with the same integrals.

    Velocities are turned and stretched at random (the same way every time), coordinates moved a
    little; Newton steps of least length then lead back to these values.  ``DefinitionError`` where
    the system declares no integral, or no other start is found.
    """
    system = equations.system
    if not system.integrals:
        raise DefinitionError(
            f"system '{system.name}' declares no integral, so no starts alike are known; "
            "give starts as arrays of initial values"
        )
    motions = many(equations, scene, [initial], parameters, {}, 0.0)
    if motions.wrong:
        raise motions.wrong[0]
    names = [plain_name(x) for x in (*system.coordinates, *system.velocities)]
    base, integrals = motions.full[0], _integrals(motions)
    random = np.random.default_rng(1)
    states, width = [base], len(system.velocities)
    target = integrals(base[None])[0]
    for _ in range(TRIES * count):
        if len(states) == count:
            break
        led = _led_back(integrals, _aside(base, width, random), target)
        if led is not None:
            states.append(led)
    if len(states) < count:
        raise DefinitionError(
            f"system '{system.name}': only {len(states)} starts with the same integrals were "
            "found; give starts as arrays of initial values"
        )
    return [dict(zip(names, x.tolist(), strict=True)) for x in states]


def _integrals(motions: Many) -> Integrals:
    """All integrals, and the relations between redundant coordinates, at states (s, n)."""
    quantities = dict(motions.ground.integrals)
    relations = motions.vocabulary.equations.form.relations
    quantities |= {f"relation {k}": e for k, e in enumerate(relations)}
    program = Program.of(motions.ground.form, quantities)
    extras = compiled(program)[1]

    def integrals(states: np.ndarray) -> np.ndarray:
        rows = np.broadcast_to(motions.values[:1], (len(states), motions.values.shape[1]))
        found = at_each(extras, program.names, motions.time, states, rows)
        return np.stack(list(found.values()), axis=-1)

    return integrals


def _aside(base: np.ndarray, width: int, random: np.random.Generator) -> np.ndarray:
    """A state near another: its ``width`` velocities turned, its coordinates moved a little."""
    guess = base.copy()
    turn = random.normal(size=width)
    speed = np.linalg.norm(base[-width:]) if width else 0.0
    guess[-width:] = turn / np.linalg.norm(turn) * (speed or 1.0)
    guess[:-width] += 0.3 * random.normal(size=len(base) - width)
    return guess


def _led_back(integrals: Integrals, guess: np.ndarray, target: np.ndarray) -> np.ndarray | None:
    """The nearest state with these integrals, by Newton steps of least length; None where they
    fail."""
    x, size = guess, 1.0 + np.abs(target)
    step = 1e-6 * (1.0 + np.abs(guess))
    for _ in range(30):
        shifts = np.diag(step)
        around = integrals(np.vstack([x[None], x + shifts, x - shifts]))
        off, n = around[0] - target, len(x)
        if not np.isfinite(around).all():
            return None
        if (np.abs(off) <= EQUAL * size).all():
            return np.asarray(x)
        slopes = ((around[1 : n + 1] - around[n + 1 :]) / (2 * step[:, None])).T
        change = np.linalg.lstsq(slopes, off, rcond=1e-10)[0]
        # a long step would leave the place where the slopes hold
        x = x - change * min(1.0, 1.0 / (np.linalg.norm(change) + 1e-300))
    return None

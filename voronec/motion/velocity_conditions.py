"""Velocities at the start: conditions on the velocities v that they must meet."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from voronec.algebra.symbols import plain_name, velocity
from voronec.errors import DefinitionError
from voronec.motion.vocabulary import Vocabulary

__all__ = ["CONSISTENT", "NoFrame", "Rates", "changes", "independent", "meet_conditions"]

CONSISTENT = 1e-9
"""How far initial data may lie off the constraints, relative to their size."""
ROUNDING = 1e-13
"""A smaller relative change is none."""
UNDEFINED = "system '{}': the velocities are not defined at the initial point"


class NoFrame(DefinitionError):
    """The velocities v of the equations determine nothing at the initial point."""


Rates = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Coordinates (n,) and velocities (m, k) to the velocities of all coordinates (n, k)."""


def meet_conditions(
    vocabulary: Vocabulary,
    q: np.ndarray,
    v: np.ndarray,
    conditions: Mapping[str, float],
    rates: Rates,
    project: bool,
) -> tuple[np.ndarray, list[str]]:
    """The velocities that meet the conditions, and what is to be said of them; those that no
    condition involves stay."""
    if not conditions:
        return v, []
    own = [plain_name(x) for x in vocabulary.equations.system.velocities]
    order, rows, right = _pose_conditions(vocabulary, q, conditions, rates)
    chosen = independent(rows)
    involved = np.abs(rows).max(axis=0) > CONSISTENT * np.abs(rows).max(initial=0.0)
    if len(chosen) > involved.sum():  # beside rates that are as good as infinite
        raise NoFrame(UNDEFINED.format(vocabulary.equations.system.name))
    if len(chosen) < involved.sum():
        names = [name for name, i in zip(own, involved, strict=True) if i]
        raise DefinitionError(
            f"system '{vocabulary.equations.system.name}': the initial velocities do not determine "
            f"{', '.join(names)}; give more velocities, or these themselves"
        )
    result = v.copy()
    result[involved] = np.linalg.solve(rows[chosen][:, involved], right[chosen])
    for name in set(own) & set(order):
        result[own.index(name)] = conditions[name]
    excess = rows @ result - right
    if np.abs(excess).max() <= CONSISTENT * (1.0 + max(map(abs, conditions.values()))):
        return result, []
    if not project:
        raise _inconsistent(vocabulary, order, conditions, excess)
    result[involved] = np.linalg.lstsq(rows[:, involved], right, rcond=None)[0]
    for name in set(own) & set(order):  # what was met but for rounding is met
        if abs(result[own.index(name)] - conditions[name]) <= ROUNDING * abs(conditions[name]):
            result[own.index(name)] = conditions[name]
    wanted, excess = np.array([conditions[name] for name in order]), rows @ result - right
    return result, [
        f"the initial velocities were moved by {np.linalg.norm(excess):.3g} onto the constraints "
        f"({changes(order, wanted, wanted + excess)})"
    ]


def _pose_conditions(
    vocabulary: Vocabulary, q: np.ndarray, conditions: Mapping[str, float], rates: Rates
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """The conditions in order: their names, and rows @ v = right."""
    system = vocabulary.equations.system
    own = [plain_name(x) for x in system.velocities]
    dots = [plain_name(velocity(x)) for x in system.coordinates]
    n = len(own)
    order = list(dict.fromkeys(name for name in (*own, *dots) if name in conditions))
    if set(order) <= set(own):
        rows = np.eye(n)[[own.index(name) for name in order]]
        return order, rows, np.array([conditions[name] for name in order])
    # rates are affine in v: their values at 0 and at the unit vectors tell them
    values = rates(q, np.hstack([np.zeros((n, 1)), np.eye(n)]))
    linear, offset = values[:, 1:] - values[:, :1], values[:, 0]
    if not np.isfinite(values).all():
        raise NoFrame(UNDEFINED.format(system.name))
    posed = [np.eye(n)[own.index(k)] if k in own else linear[dots.index(k)] for k in order]
    right = [conditions[k] - (0.0 if k in own else offset[dots.index(k)]) for k in order]
    return order, np.array(posed), np.array(right)


def changes(names: Iterable[str], old: np.ndarray, new: np.ndarray) -> str:
    """What was moved, from where to where."""
    triples = zip(names, old.tolist(), new.tolist(), strict=True)
    return ", ".join(
        f"{name} from {a:.6g} to {b:.6g}"
        for name, a, b in triples
        if abs(a - b) > ROUNDING * (abs(a) + abs(b))
    )


def independent(rows: np.ndarray) -> list[int]:
    """Positions of the first rows that are linearly independent."""
    chosen: list[int] = []
    for i in range(len(rows)):
        scaled = [rows[j] / (np.linalg.norm(rows[j]) or 1.0) for j in (*chosen, i)]
        if np.linalg.matrix_rank(np.array(scaled), tol=CONSISTENT) == len(scaled):
            chosen.append(i)
    return chosen


def _inconsistent(
    vocabulary: Vocabulary, order: list[str], conditions: Mapping[str, float], excess: np.ndarray
) -> DefinitionError:
    worst = int(np.argmax(np.abs(excess)))
    name = order[worst]
    value = float(conditions[name])
    return DefinitionError(
        f"system '{vocabulary.equations.system.name}': the initial velocities are off the "
        f"constraints: '{name}' = {value:.12g}, where the others give {value + excess[worst]:.12g} "
        f"(residual {abs(excess[worst]):.3g}); correct '{name}', leave it out, or give project=True"
    )

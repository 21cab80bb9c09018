"""Many starts read at once: the steps of ``start_of`` on arrays.

What needs more than numbers - texts and expressions, starts that give different things, redundant
coordinates - and starts that do not fit are left to ``start_of``, one by one, which says what is
wrong with them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from voronec.algebra.symbols import plain_name, velocity
from voronec.errors import DefinitionError
from voronec.motion.initial_state import name_values, numbers_of
from voronec.motion.velocity_conditions import CONSISTENT, independent
from voronec.motion.vocabulary import Vocabulary

__all__ = ["starts_in_arrays"]

RatesOfMany = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Coordinates (s, n) and velocities (m, k) to the velocities of all coordinates (s, n, k)."""


def starts_in_arrays(
    vocabulary: Vocabulary,
    scene: Mapping[str, Any],
    starts: Sequence[Mapping[Any, Any]],
    parameters: Mapping[str, np.ndarray],
    rates: RatesOfMany,
) -> np.ndarray:
    """Coordinates, then velocities v, of each start (s, n + m); rows of nan where it is left over.

    ``scene`` has initial values by plain name, ``parameters`` arrays (s,).
    """
    system = vocabulary.equations.system
    names = [plain_name(q) for q in system.coordinates]
    left = np.full((len(starts), len(names) + len(system.velocities)), np.nan)
    if system.fibration.relations or not starts:
        return left
    still = {name: float(x[0]) for name, x in parameters.items() if (x == x[0]).all()}
    try:
        known = list(name_values(vocabulary, starts[0], "initial value"))
        columns = dict(zip(known, _columns(starts), strict=True))
        before = numbers_of(vocabulary, scene, still)
    except (DefinitionError, ValueError, TypeError, OverflowError):
        return left
    old = {name: np.full(len(starts), x) for name, x in before.items()}
    nothing = np.zeros(len(starts))
    q = np.stack([{**old, **columns}.get(name, nothing) for name in names], axis=-1)
    v = np.zeros((len(starts), len(system.velocities)))
    good = np.isfinite(q).all(axis=1)
    for part in (old, columns):
        conditions = {name: x for name, x in part.items() if name not in names}
        if conditions and good.any():
            v = _meet_conditions(vocabulary, q, v, conditions, rates, good)
    left[good] = np.hstack([q, v])[good]
    return left


def _columns(starts: Sequence[Mapping[Any, Any]]) -> list[np.ndarray]:
    """What starts give, key by key (s,); ``ValueError`` where that are not the same numbers."""
    keys = list(starts[0])
    if any(list(given) != keys for given in starts):
        raise ValueError
    rows = [[given[key] for given in starts] for key in keys]
    if not all(isinstance(x, float | int) for row in rows for x in row):
        raise ValueError
    return [np.array(row, dtype=float) for row in rows]


def _meet_conditions(
    vocabulary: Vocabulary,
    q: np.ndarray,
    v: np.ndarray,
    conditions: Mapping[str, np.ndarray],
    rates: RatesOfMany,
    good: np.ndarray,
) -> np.ndarray:
    """Velocities (s, m) that meet conditions, as ``met`` finds them; starts for which it would do
    something else than for the first, or refuse them, are no longer ``good``."""
    own = [plain_name(x) for x in vocabulary.equations.system.velocities]
    order, rows, right = _pose_conditions(vocabulary, q, conditions, rates)
    good &= np.isfinite(rows).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    if not good.any():
        return v
    rows, right = np.where(good[:, None, None], rows, 0.0), np.where(good[:, None], right, 0.0)
    first = int(np.argmax(good))
    chosen = independent(rows[first])
    good &= _as_independent(rows, chosen)
    sizes = np.abs(rows).max(axis=1)
    involved = sizes > CONSISTENT * sizes.max(axis=1, keepdims=True, initial=0.0)
    good &= (involved == involved[first]).all(axis=1)
    which = involved[first]
    if len(chosen) != which.sum():
        good[:] = False
        return v
    found, at = v.copy(), np.flatnonzero(good)
    solved = np.linalg.solve(rows[at][:, chosen][:, :, which], right[at][:, chosen, None])[..., 0]
    found[np.ix_(at, which)] = solved
    for name in set(own) & set(order):
        found[:, own.index(name)] = conditions[name]
    excess = np.abs(np.einsum("skn,sn->sk", rows, found) - right).max(axis=1)
    size = 1.0 + np.max([np.abs(x) for x in conditions.values()], axis=0)
    good &= excess <= CONSISTENT * size
    return found


def _as_independent(rows: np.ndarray, chosen: list[int]) -> np.ndarray:
    """For which of some sets of rows (s, k, n) the same ones are chosen as independent."""
    lengths = np.linalg.norm(rows, axis=2, keepdims=True)
    scaled = rows / np.where(lengths == 0, 1.0, lengths)
    if len(chosen) == rows.shape[1]:  # then those before each one are independent, too
        return np.asarray(np.linalg.matrix_rank(scaled, tol=CONSISTENT) == len(chosen))
    same = np.ones(len(rows), dtype=bool)
    for i in range(rows.shape[1]):
        before = [j for j in chosen if j < i]
        rank = np.linalg.matrix_rank(scaled[:, [*before, i]], tol=CONSISTENT)
        same &= (rank == len(before) + 1) == (i in chosen)
    return same


def _pose_conditions(
    vocabulary: Vocabulary,
    q: np.ndarray,
    conditions: Mapping[str, np.ndarray],
    rates: RatesOfMany,
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """The conditions in order: their names, and rows (s, k, n) @ v = right (s, k)."""
    system = vocabulary.equations.system
    own = [plain_name(x) for x in system.velocities]
    dots = [plain_name(velocity(x)) for x in system.coordinates]
    order = list(dict.fromkeys(name for name in (*own, *dots) if name in conditions))
    unit, right = np.eye(len(own)), np.stack([conditions[k] for k in order], axis=-1)
    if set(order) <= set(own):
        rows = unit[[own.index(k) for k in order]]
        return order, np.broadcast_to(rows, (len(q), *rows.shape)), right
    values = rates(q, np.hstack([np.zeros((len(own), 1)), unit]))
    linear, offset = values[:, :, 1:] - values[:, :, :1], values[:, :, 0]
    posed = [
        np.broadcast_to(unit[own.index(k)], (len(q), len(own)))
        if k in own
        else linear[:, dots.index(k)]
        for k in order
    ]
    for i, k in enumerate(order):
        if k not in own:
            right[:, i] -= offset[:, dots.index(k)]
    # a rate that has no value spoils the start, whether it is asked for or not
    right[~np.isfinite(values).all(axis=(1, 2))] = np.nan
    return order, np.stack(posed, axis=1), right

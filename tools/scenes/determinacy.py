"""Whether velocities given at a singular place determine a motion, as the referee finds beside it.

At places beside it, to several sides and nearer and nearer, the velocities are given as they are
there.  Compared are functions of places and motions that know of no coordinates: both energies,
the invariants that are declared, how strong the reactions are, in the metric of the kinetic
energy,

    R^2 = (A^T lambda)^T M^-1 (A^T lambda),

and the rate of R^2.  Where the kinetic energy grows without bound, such velocities belong to no
motion through the place; where energies or invariants depend on the side, they do not determine
one.  Where these agree, and the reactions or their rate grow without bound or depend on the side,
the motion is not defined there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random
from typing import Any

import mpmath as mp
import numpy as np
import sympy as sp

from scenes.reference import NoReferee, Referee

DISTANCES = (1e-4, 1e-6, 1e-8)
"""So far beside the place, one after the other."""
DIGITS = 120
"""Enough for differences over times below, in coordinates that are singular so near."""
MASSLESS = mp.mpf("1e-30")
"""Part of the largest moment of inertia below which there is none: at the nearest place what
vanishes as the square of the distance is 1e-16."""
SIDES = 3
"""So many directions, and the opposite ones."""
GROWTH = 30
"""What grows by more for a hundredth of the distance has no bound: an inverse grows by 100."""
LATER = mp.mpf("1e-8")
"""A rate is that over so much time, in units of the fourth power of the distance: at two poles at
once angles have rates as the inverse of its square, and these change as the square of that."""
DIFFERENT = 1e-4
"""Limits are different where they are apart by more than this part of their size."""
STEADY = 1e-2
"""What changes by less than this part of what limits are apart is one."""
Beside = Callable[[Sequence[Any]], list[Any]]
"""The state (q, w) at coordinates, with the velocities given."""


def find_defect(
    referee: Referee, begin: Beside, q: Sequence[float], p: Sequence[float], further: Any
) -> tuple[str, str]:
    """Why no motion begins with velocities at coordinates q, in a word and more of them; both are
    empty where one does, or that cannot be told.  ``further`` are expressions in the referee's
    symbols that know of no coordinates."""
    if referee.switches.functions:
        return "", ""
    try:
        looks = _Looks(referee, p, further)
        with mp.workdps(DIGITS):
            ways = np.array([
                [looks.beside(begin, q, side, distance) for distance in DISTANCES]
                for side in _sides(len(q))
            ])  # fmt: skip
    except (NoReferee, ArithmeticError, ValueError):
        return "", ""
    if _grows(ways[..., 0]):
        return "undetermined", "beside the place the energy of such velocities has no bound"
    if _part(ways[..., :-2]):
        return "undetermined", "such velocities mean different ones on different sides of the place"
    for name, values in (("are", ways[..., -2]), ("change by", ways[..., -1])):
        if _grows(np.abs(values)):
            return "undefined", f"the reactions {name} more than any bound beside the place"
        if _part(values[..., None]):
            return "undefined", f"the reactions {name} different ones on different sides"
    return "", ""


def _sides(size: int) -> list[np.ndarray]:
    dice = Random(size)
    ways = [
        np.array([dice.uniform(0.5, 1) * dice.choice((1, -1)) for _ in range(size)])
        for _ in range(SIDES)
    ]
    return [sign * way for way in ways for sign in (1, -1)]


class _Looks:
    """What is looked at in states (q, w): kinetic energy, L, what else is given, R^2 and its
    rate."""

    def __init__(self, referee: Referee, p: Sequence[float], further: Sequence[sp.Expr]) -> None:
        m = referee.mechanics
        rest = m.lagrangian.xreplace(dict.fromkeys(m.w, sp.Integer(0)))
        self._p = p
        self._own = referee.reader([m.lagrangian - rest, m.lagrangian, *further])
        self._rates = referee.reader(m.rates)
        self._equations = referee.equations

    def beside(
        self, begin: Beside, q: Sequence[float], side: np.ndarray, distance: float
    ) -> list[float]:
        """The numbers at a distance from the place."""
        state = begin([mp.mpf(x) + distance * s for x, s in zip(q, side, strict=True)])
        strength, slopes = self._reaction(state)
        moved = [*self._rates(0.0, state, self._p), *slopes]
        step = LATER * distance**4
        later, _ = self._reaction([x + step * d for x, d in zip(state, moved, strict=True)])
        own = self._own(0.0, state, self._p)
        return [*map(float, own), float(strength), float((later - strength) / step)]

    def _reaction(self, state: Sequence[Any]) -> tuple[Any, list[Any]]:
        """R^2 and wdot of M wdot = f + A^T lambda, A wdot = b."""
        mass, force, rows, right = self._equations(state, self._p, 0.0)
        kept = _independent(rows)
        rows, right = (mp.matrix([part[i, :].tolist()[0] for i in kept]) for part in (rows, right))
        n, m = mass.rows, len(kept)
        K = mp.zeros(n + m)
        K[:n, :n] = mass
        if m:
            K[n:, :n], K[:n, n:] = rows, -rows.T
        found = [*mp.lu_solve(K, mp.matrix([*force, *right]))]
        if not m:
            return mp.mpf(0), found
        sizes, axes = mp.eigsy(mass)
        along = axes.T * (rows.T * mp.matrix(found[n:]))
        least = MASSLESS * max(sizes)
        parts = (x**2 / size for x, size in zip(along, sizes, strict=True) if size > least)
        return mp.fsum(parts), found[:n]


def _independent(rows: Any) -> list[int]:
    """Positions of rows that do not follow from those before them, to half of all digits."""
    kept, basis = list[int](), list[Any]()
    for i in range(rows.rows):
        row = rows[i, :].T
        size = mp.norm(row)
        for unit in basis:
            row -= (unit.T * row)[0] * unit
        if mp.norm(row) > size * mp.sqrt(mp.eps):
            kept.append(i)
            basis.append(row / mp.norm(row))
    return kept


def _grows(values: np.ndarray) -> bool:
    """Whether positive values (sides, k) have no bound at places nearer and nearer."""
    return bool((values[:, 1:] > GROWTH * values[:, :-1]).all(axis=1).any())


def _part(values: np.ndarray) -> bool:
    """Whether values (sides, k, n) have limits on all sides, and different ones."""
    late = np.abs(values[:, -1] - values[:, -2]).max(axis=0)
    last = values[:, -1]
    gaps, size = np.ptp(last, axis=0), np.maximum(1.0, np.abs(last).max(axis=0))
    return bool(((gaps > DIFFERENT * size) & (late < STEADY * gaps)).any())

"""What is defined at a place where coordinates are singular.

At a pole two angles turn about one axis: of each alone nothing can be said there, of their sum or
difference it can.  Such directions are those in which neither the kinetic energy nor the conditions
see a rate.  Sums of coordinates across them are defined, and functions that do not change along
them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from random import Random

import mpmath as mp
import numpy as np
import sympy as sp

from scenes.reference import Referee

BESIDE = 1e-7
"""So far beside a place rates are looked at: there all are finite."""
UNSEEN = 1e-5
"""A rate that is seen by less than this part moves nothing."""
SHIFTS = (0.4, -0.9)
"""So far along a blind direction functions must not change."""
SAME = 1e-9


@dataclass(frozen=True)
class Value:
    """An expression in the referee's symbols, what it is at the place, and whether that may be off
    by whole turns."""

    expression: sp.Expr
    here: float
    turns: bool = False


def _blind_directions(referee: Referee, q: list[float], p: list[float]) -> np.ndarray:
    """Directions (k, n) in which coordinates may change at a place while nothing moves;
    k is zero for velocities of a group."""
    m = referee.mechanics
    if m.w != m.rates:
        return np.zeros((0, len(q)))
    dice = Random(len(q))
    beside = [mp.mpf(x) + BESIDE * dice.uniform(0.5, 1) for x in q]
    rows = referee.rate_rows([*beside, *[mp.mpf(0)] * len(m.w)], p)
    rows = rows / np.maximum(np.abs(rows).max(axis=1, keepdims=True), BESIDE)
    _, sizes, basis = np.linalg.svd(rows)
    return np.asarray(basis[sizes < UNSEEN * sizes[0]])


def _echelon(rows: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """A basis of the same space, its pivots 1 and alone in their columns, and these columns."""
    rows, pivots = rows.copy(), []
    for i in range(len(rows)):
        row, column = divmod(int(np.abs(rows[i:]).argmax()), rows.shape[1])
        rows[[i, i + row]] = rows[[i + row, i]]
        rows[i] /= rows[i, column]
        pivots.append(column)
        others = np.arange(len(rows)) != i
        rows[others] -= np.outer(rows[others, column], rows[i])
    return np.round(rows, 5), pivots


def find_values(
    referee: Referee, functions: Mapping[str, sp.Expr], q: list[float], p: list[float]
) -> dict[str, Value]:
    """Sums of coordinates, and those of the functions of coordinates, that are defined at a place,
    by name."""
    blind, pivots = _echelon(_blind_directions(referee, q, p))
    found = dict(_find_sums(referee, blind, pivots, q))
    still = [mp.mpf(0)] * len(referee.mechanics.w)
    for name, function in functions.items():
        reader = referee.reader([function])
        places = [np.array(q), *(q + s * direction for direction in blind for s in SHIFTS)]
        try:
            values = [float(reader(0.0, [*map(mp.mpf, x), *still], p)[0]) for x in places]
        except (ArithmeticError, TypeError, ValueError):
            continue  # no number there
        if max(values) - min(values) < SAME:
            found[name] = Value(function, values[0])
    return found


def _find_sums(
    referee: Referee, blind: np.ndarray, pivots: list[int], q: list[float]
) -> Iterator[tuple[str, Value]]:
    """Sums of coordinates with whole coefficients that are the same along blind directions."""
    m = referee.mechanics
    for j in range(len(q)):
        if j in pivots:
            continue
        row = np.eye(len(q))[j]
        row[pivots] = -blind[:, j]
        if np.any(row != np.rint(row)):
            continue
        expression = sp.Add(*[int(c) * x for c, x in zip(row, m.q, strict=True)])
        terms = [f"{int(c):+d} {n}" for c, n in zip(row, m.coordinates, strict=True) if c]
        yield " ".join(terms), Value(expression, math.fsum(row * q), turns=True)

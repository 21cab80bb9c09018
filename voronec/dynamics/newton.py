"""Points of F(y) = 0 where the solutions form a family: Newton's method, rank, tangents, digits.

Equations may be dependent and solutions need not be isolated.  Far from a solution steps are those
of Levenberg and Marquardt with the weight |F|^2, which converge quadratically to a family
[YamashitaFukushima2001]; near it the Jacobian has the rank n - d where the family has d dimensions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import flint
import numpy as np

from voronec.errors import EngineLimit

Function = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""F (m,) and its Jacobian (m, n) at y (n,)."""

STEPS = 60
"""Newton's method ends or has failed after so many steps."""
RANK = 1e-7
"""Singular values below this share of the largest belong to the directions of a family: solutions
are known to 1e-12, and the Jacobian no better than that."""


def solve(
    function: Function, y: np.ndarray, units: np.ndarray,
    close: float = 1e-13, singular: float = 1e-14,
) -> np.ndarray | None:  # fmt: skip
    """A solution near y (n,), whose entries are of the sizes ``units`` (n,); None where Newton's
    method finds none.

    Rows of the Jacobian are scaled to length one.  Where |F| is below ``close`` and falls no
    further it is solved; singular values below ``singular`` are taken for zero.
    """
    y, damping = np.array(y, dtype=float), 1.0
    value, slopes = function(y)
    if not np.isfinite(value).all() or not np.isfinite(slopes).all():
        return None
    rows = _row_sizes(slopes * units)
    for _ in range(STEPS):
        matrix, rest = slopes * units / rows[:, None], value / rows
        size = float(np.linalg.norm(rest))
        step = units * _weighted_step(matrix, rest, damping * min(size, 1.0) ** 2, singular)
        ahead = y - step
        new_value, new_slopes = function(ahead)
        new = np.linalg.norm(new_value / rows)
        if np.isfinite(new) and np.isfinite(new_slopes).all() and (new < size or new < 1e-13):
            y, value, slopes, damping = ahead, new_value, new_slopes, damping / 5
            if np.abs(step / units).max(initial=0.0) < 1e-11 and new < 1e-11:
                return y
        elif size < close:
            return y
        else:
            damping = 4 * damping
            if damping > 1e12:
                return None
    return None


def solve_across(
    function: Function, y: np.ndarray, across: np.ndarray, units: np.ndarray, **accuracy: float
) -> np.ndarray | None:
    """The solution in the plane through y across a direction (n,), as ``solve`` finds it."""
    row = across / units**2

    def joint(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        value, slopes = function(z)
        return np.append(value, row @ (z - y)), np.vstack([slopes, row])

    return solve(joint, y, units, **accuracy)


def _row_sizes(matrix: np.ndarray) -> np.ndarray:
    """The lengths of rows, those far below the longest raised."""
    sizes: np.ndarray = np.linalg.norm(matrix, axis=1)
    longest = float(sizes.max(initial=0.0)) or 1.0
    return np.maximum(sizes, 1e-3 * longest)


def _weighted_step(
    matrix: np.ndarray, rest: np.ndarray, weight: float, singular: float
) -> np.ndarray:
    left, sizes, right = np.linalg.svd(matrix, full_matrices=False)
    share = sizes / np.maximum(sizes**2 + weight, 1e-300)
    share[sizes < singular] = 0.0
    return right.T @ (share * (left.T @ rest))


def null_space(slopes: np.ndarray, units: np.ndarray, dimension: int | None = None) -> np.ndarray:
    """Directions (n, d), orthonormal in the units, in which a family goes on."""
    matrix = slopes * units
    _, sizes, right = np.linalg.svd(matrix / _row_sizes(matrix)[:, None])
    largest = sizes.max(initial=0.0)
    rank = int((sizes > RANK * largest).sum()) if dimension is None else len(units) - dimension
    return units[:, None] * right[rank:].T


def polish(equations: Any, y: np.ndarray, bits: int) -> list[Any]:
    """A solution to ``bits``, as balls without radius, from one in doubles.

    Each step with the pseudo-inverse in doubles gains some twelve digits.
    """
    _, slopes = equations.at(y)
    sizes = _row_sizes(slopes)
    inverse = np.linalg.pinv(slopes / sizes[:, None], rcond=RANK) / sizes
    with flint.ctx.workprec(bits):
        exact = flint.arb_mat(len(y), len(sizes), inverse.ravel().tolist())
        solution = flint.arb_mat(len(y), 1, y.tolist())
        last = float("inf")
        for _ in range(2 + bits // 20):
            values = equations.balls(solution.entries(), bits)
            if not all(v.is_finite() for v in values):
                raise EngineLimit("the right side has no finite value there")
            step = (exact * flint.arb_mat(len(values), 1, values)).mid()
            size = max(float(abs(e)) for e in step.entries())
            solution = (solution - step).mid()
            if size == 0 or (size >= 0.1 * last and size < 2.0 ** (-0.6 * bits)):
                break
            last = size
        if size > 2.0 ** (-0.5 * bits):
            raise EngineLimit(
                "the steady motion has no more digits than doubles: its equations are degenerate "
                "there"
            )
        return solution.entries()


def pivots(directions: np.ndarray) -> list[int]:
    """As many rows as there are columns, in which the columns are well independent."""
    if not directions.shape[1]:
        return []
    from scipy.linalg import qr

    order = qr(directions.T, pivoting=True, mode="r")[1]
    return sorted(int(i) for i in order[: directions.shape[1]])

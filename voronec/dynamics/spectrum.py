"""Eigenvalues of a steady motion, those that integrals and families make zero told from the others.

    dx' = A dx,   A = df/dx

Directions of the family, and what relations and integrals hold, give zeros, as many for all motions
of a family.  They are taken out one null space after another, so that the matrix that is left is
regular, and chains of Jordan do no harm to its eigenvalues.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import flint
import mpmath as mp
import numpy as np

SMALL = 1e-7
"""Singular values, and real parts, below this share of the largest are taken for zero: a chain of
two eigenvalues is known to the root of the rounding."""

EVEN = 1e-10
"""Odd coefficients below this, of a matrix of norm one, vanish."""


@dataclass(frozen=True)
class Deflation:
    """The zero eigenvalues that are taken out of a matrix, one null space after another: ``counts``
    are the dimensions of these."""

    counts: tuple[int, ...]

    @property
    def zeros(self) -> int:
        """How many zeros there are in all."""
        return sum(self.counts)

    @classmethod
    def of(cls, matrix: np.ndarray) -> Deflation:
        """All zero eigenvalues of a matrix (n, n), by its rank and those of its remainders."""
        counts: list[int] = []
        scale = float(np.linalg.norm(matrix, 2)) if matrix.size else 0.0
        while matrix.size:
            _, sizes, right = np.linalg.svd(matrix)
            zeros = int((sizes <= SMALL * scale).sum())
            if not zeros:
                break
            counts.append(zeros)
            kept = right[: len(sizes) - zeros]
            matrix = kept @ matrix @ kept.T
        return cls(tuple(counts))

    @classmethod
    def of_family(cls, matrices: Sequence[np.ndarray]) -> Deflation:
        """The zero eigenvalues that all motions of a family have: the fewest that one has."""
        return min(map(cls.of, matrices), key=lambda d: d.zeros, default=cls(()))

    def remainder(self, matrix: np.ndarray) -> np.ndarray:
        """The matrix on the complements of the null spaces, from which they are taken out."""
        for zeros in self.counts:
            _, sizes, right = np.linalg.svd(matrix)
            kept = right[: len(sizes) - zeros]
            matrix = kept @ matrix @ kept.T
        return matrix

    def eigenvalues(self, matrix: np.ndarray) -> np.ndarray:
        """The eigenvalues of a matrix (n, n) without so many zeros, of the balanced remainder, by
        real part, then imaginary part, both up to rounding."""
        from scipy.linalg import matrix_balance

        values = np.linalg.eigvals(matrix_balance(self.remainder(matrix), permute=False)[0])
        size = float(np.abs(values).max(initial=1.0))
        keys = np.round(values.imag / size, 9), np.round(values.real / size, 9)
        ordered: np.ndarray = values[np.lexsort(keys)]
        return ordered


def characteristic(slopes: Any, size: int, zeros: int) -> list[Any]:
    """The coefficients of the characteristic polynomial of the leading block of an ``arb_mat``,
    from the constant on, without the factor lambda^zeros."""
    block = [slopes[i, j] for i in range(size) for j in range(size)]
    coefficients: list[Any] = flint.arb_mat(size, size, block).charpoly().coeffs()
    return coefficients[zeros:]


def has_opposites(matrix: np.ndarray) -> bool:
    """Whether with each eigenvalue its negative is one."""
    scale = float(np.linalg.norm(matrix, 2)) if matrix.size else 1.0
    odd = np.poly(matrix / (scale or 1.0))[1::2]
    return len(matrix) % 2 == 0 and bool(np.abs(odd).max(initial=0.0) < EVEN)


def conditions_in_doubles(matrix: np.ndarray, opposites: bool) -> dict[str, float]:
    """What changes its sign where an eigenvalue passes through zero (``real``), where a pair
    crosses the imaginary axis (``pair``), or, where with each eigenvalue its negative is one all
    along (``opposites``), where two pairs meet on it (``meeting``), scaled."""
    scale = float(np.linalg.norm(matrix, 2)) if matrix.size else 1.0
    values = np.linalg.eigvals(matrix / (scale or 1.0))
    conditions = {"real": float(np.prod(values).real)}
    if opposites:
        squares = np.roots(np.poly(matrix / (scale or 1.0))[::2])
        gaps = [(a - b) ** 2 for a, b in combinations(squares, 2)]
        return conditions | {"meeting": float(np.prod(gaps).real)}
    return conditions | {"pair": float(np.prod([a + b for a, b in combinations(values, 2)]).real)}


def hurwitz_matrix(coefficients: Sequence[Any]) -> list[list[Any]]:
    """The Hurwitz matrix of order n - 1 of a polynomial, whose coefficients are given from the
    constant on.  By Orlando's formula its determinant is, up to its sign, the product of all sums
    of two roots [Gantmacher1959, ch. XV]; it vanishes where a pair crosses the imaginary axis."""
    n = len(coefficients) - 1
    places = [[n - 2 * (j + 1) + (i + 1) for j in range(n - 1)] for i in range(n - 1)]
    return [[coefficients[k] if 0 <= k <= n else 0 for k in row] for row in places]


def hurwitz(coefficients: Sequence[Any]) -> Any:
    """The determinant of the Hurwitz matrix in balls."""
    return _determinant(hurwitz_matrix(coefficients))


def discriminant(coefficients: Sequence[Any]) -> Any:
    """That of a polynomial, up to its sign, which is one for all of a degree: it vanishes where two
    roots meet."""
    n = len(coefficients) - 1
    slopes = [k * c for k, c in enumerate(coefficients)][1:]
    zero, rows = flint.arb(0), []
    for poly, count in ((coefficients, n - 1), (slopes, n)):
        down = [*reversed(poly)]
        for i in range(count):
            rows.append([zero] * i + down + [zero] * (2 * n - 1 - i - len(down)))
    return _determinant(rows) if n > 1 else flint.arb(1)


def _determinant(rows: Sequence[Sequence[Any]]) -> Any:
    n = len(rows)
    if n == 0:
        return flint.arb(1)
    return flint.arb_mat(n, n, [e for row in rows for e in row]).det()


def root_on_right(coefficients: Sequence[Any], near: complex, bits: int) -> Any | None:
    """A ball, an ``acb``, in which every polynomial of the enclosed family has one root, if that
    is proved by Newton's interval method and lies right of the imaginary axis; else None."""
    with flint.ctx.workprec(bits):
        poly = flint.acb_poly([flint.acb(c) for c in coefficients])
        slope = poly.derivative()
        middle = flint.acb(near.real, near.imag)
        for _ in range(8):
            below = slope(middle)
            if below.contains(0):
                return None
            middle = (middle - poly(middle) / below).mid()
        step = abs(poly(middle) / slope(middle)).upper() if slope(middle).is_finite() else None
        if step is None or not step.is_finite():
            return None
        reach = float(step) * 4 + abs(near) * 2.0 ** (-bits // 2)
        ball = middle + flint.acb(flint.arb(0, reach), flint.arb(0, reach))
        if slope(ball).contains(0):
            return None
        image = middle - poly(middle) / slope(ball)
        return image if ball.contains(image) and image.real > 0 else None


def number_text(z: complex) -> str:
    """A complex number in nine digits; parts that are rounding are left out."""
    real, imaginary = (x if abs(x) > 1e-9 * abs(z) else 0.0 for x in (z.real, z.imag))
    return f"{real:.9g}" + (f"{imaginary:+.9g}i" if imaginary else "")


def unstable_count(values: np.ndarray) -> int:
    """How many eigenvalues lie right of the imaginary axis, beyond rounding."""
    size = float(np.abs(values).max(initial=0.0))
    return int((values.real > SMALL * size).sum())


def to_mpf(ball: Any) -> mp.mpf:
    """The middle of a ball, exactly."""
    mantissa, exponent = (int(part) for part in ball.mid().man_exp())
    with mp.workprec(max(53, mantissa.bit_length() + 1)):
        return mp.ldexp(mp.mpf(mantissa), exponent)

"""Arithmetic and linear algebra modulo a prime, in whole arrays.

The primes are safe, p = 2 q + 1 with q prime, and 3 modulo 4: so every number has exactly one n-th
root for odd n, and a number that has a square root has one that has a square root itself.
"""

from __future__ import annotations

from math import isqrt
from typing import Any

import flint
import numpy as np

PRIMES = (
    2147483579, 2147483123, 2147482763, 2147481563, 2147481143, 2147480927, 2147480327,
    2147479823, 2147479787, 2147478899, 2147478083, 2147477807, 2147477687, 2147477159,
)  # fmt: skip
"""Below 2^31, so that products of residues fit into 64 bits."""

Array = np.ndarray[Any, Any]


def _power(base: Array, exponent: int, p: int) -> Array:
    result, square = np.ones_like(base), base % p
    while exponent:
        if exponent & 1:
            result = result * square % p
        square = square * square % p
        exponent >>= 1
    return result


def inverse(values: Array, p: int) -> Array:
    """1/values; 0 where a value is 0."""
    return _power(values, p - 2, p)


def root(values: Array, degree: int, p: int) -> tuple[Array, Array]:
    """A root of each value, and where there is one."""
    exists = np.ones(values.shape, dtype=bool)
    while degree % 2 == 0:
        exists &= _power(values, (p - 1) // 2, p) != p - 1
        values = _power(values, (p + 1) // 4, p)
        degree //= 2
    if degree > 1:
        values = _power(values, pow(degree, -1, p - 1), p)
    return values, exists


def as_residue(number: Any, p: int) -> int:
    """A rational number modulo p; ZeroDivisionError where p divides its denominator."""
    below = int(number.q) % p
    if not below:
        raise ZeroDivisionError
    return int(number.p) * pow(below, -1, p) % p


def free_columns(matrix: Array, p: int) -> tuple[Array, list[int]]:
    """The reduced echelon form, without rows of zeros, and the columns of its pivots."""
    rows, columns = matrix.shape
    if not rows or not columns:
        return np.zeros((0, columns), dtype=np.int64), []
    reduced, rank = flint.nmod_mat(rows, columns, matrix.ravel().tolist(), p).rref()
    entries = reduced.tolist()[:rank]
    echelon = np.array([[int(x) for x in row] for row in entries], dtype=np.int64)
    echelon = echelon.reshape(rank, columns)
    return echelon, [int(np.flatnonzero(row)[0]) for row in echelon]


def kernel(matrix: Array, p: int) -> tuple[Array, list[int]]:
    """The vectors that a matrix takes to zero, one for each column without a pivot.

    Each is 1 in its own free column and 0 in the others.
    """
    echelon, pivots = free_columns(matrix, p)
    free = [j for j in range(matrix.shape[1]) if j not in set(pivots)]
    vectors = np.zeros((len(free), matrix.shape[1]), dtype=np.int64)
    for row, j in zip(vectors, free, strict=True):
        row[j] = 1
        row[pivots] = -echelon[:, j] % p
    return vectors, free


def fraction_of(residue: int, modulus: int) -> tuple[int, int] | None:
    """The only fraction with numerator and denominator below sqrt(modulus/2), if there is one."""
    bound = isqrt(modulus // 2)
    before, now, s, t = modulus, residue % modulus, 0, 1
    while now > bound:
        quotient = before // now
        before, now, s, t = now, before - quotient * now, t, s - quotient * t
    if t == 0 or abs(t) > bound:
        return None
    return (now, t) if t > 0 else (-now, -t)

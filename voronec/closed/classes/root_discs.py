"""Roots of many real polynomials at once, each in a disc that is proved to hold it.

For approximations z_i of the roots of a polynomial with leading coefficient a and degree n, the
discs about z_i of radius n |p(z_i)/(a prod_{j != i} (z_i - z_j))| hold all roots, and as many of
them as discs where some hang together (B. T. Smith's form of Gerschgorin's theorem).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.closed.classes.error_bounds import UNIT, BoundedNumber

__all__ = ["Discs", "degrees", "discs"]


@dataclass(frozen=True)
class Discs:
    """Roots of n polynomials of one degree d, in rows: ``centre`` (complex) and ``radius``, (n, d).

    ``kind`` is 1 where the disc holds one root, a real one, and its centre is real; -1 where it
    does not meet the real axis; 0 where that is not known.
    """

    centre: np.ndarray
    radius: np.ndarray
    kind: np.ndarray

    @property
    def real(self) -> np.ndarray:
        """The real roots; nan in place of others."""
        return np.where(self.kind == 1, self.centre.real, np.nan)

    @property
    def known(self) -> np.ndarray:
        """Which polynomials have all their roots told apart."""
        return np.all(self.kind != 0, axis=1)


def degrees(coefficients: Sequence[BoundedNumber]) -> np.ndarray:
    """The degree of each polynomial, -1 of zero, -2 where that is not certain."""
    count = len(coefficients[0].mid)
    found = np.full(count, -1)
    for power, c in enumerate(coefficients):
        found = np.where(c.sign != 0, power, np.where(c.zero, found, -2))
    return found


def discs(coefficients: Sequence[BoundedNumber]) -> Discs:
    """The roots of polynomials whose leading coefficients are certainly not zero."""
    n = len(coefficients) - 1
    mids = np.stack([c.mid for c in coefficients], axis=1)
    errs = np.stack([c.err for c in coefficients], axis=1)
    if n == 0:
        empty = np.zeros((len(mids), 0))
        return Discs(empty.astype(complex), empty, empty.astype(int))
    centre = _weierstrass_correction(mids, _companion_eigenvalues(mids))
    radius = _radii(mids, errs, centre)
    # where a disc meets the real axis and is alone, so is the one about its projection
    near = np.abs(centre.imag) <= radius
    straight = np.where(near, centre.real, centre)
    wide = np.where(near, radius + np.abs(centre.imag), radius)
    apart = np.abs(straight[:, :, None] - straight[:, None, :])
    free = (apart > (wide[:, :, None] + wide[:, None, :]) * (1 + 4 * UNIT)) | np.eye(n, dtype=bool)
    alone = np.all(free, axis=2) & np.isfinite(wide)
    kind = np.where(near, np.where(alone, 1, 0), np.where(np.isfinite(wide), -1, 0))
    return Discs(straight.astype(complex), wide, kind)


def _companion_eigenvalues(mids: np.ndarray) -> np.ndarray:
    """Eigenvalues of the companion matrices."""
    n = mids.shape[1] - 1
    matrix = np.zeros((len(mids), n, n))
    matrix[:, :, n - 1] = -mids[:, :n] / mids[:, n:]
    if n > 1:
        matrix[:, np.arange(1, n), np.arange(n - 1)] = 1
    return np.linalg.eigvals(matrix).astype(complex)


def _weierstrass_correction(mids: np.ndarray, roots: np.ndarray) -> np.ndarray:
    """Two rounds of Weierstrass' correction: the eigenvalues are not quite as good as doubles."""
    for _ in range(2):
        step = _value(mids, roots) / (mids[:, -1:] * _products(roots))
        roots = roots - np.where(np.isfinite(step), step, 0)
    return roots


def _radii(mids: np.ndarray, errs: np.ndarray, roots: np.ndarray) -> np.ndarray:
    n = mids.shape[1] - 1
    size = np.abs(roots)
    rounding = 16 * (n + 2) * UNIT * _value(np.abs(mids), size) + _value(errs, size)
    value = np.abs(_value(mids, roots)) + rounding.real
    leading = np.abs(mids[:, -1:]) - errs[:, -1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = n * value * (1 + 64 * UNIT) / (leading * np.abs(_products(roots)))
    return np.where(np.isfinite(radius), radius, np.inf)


def _value(mids: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The polynomials at several places each."""
    total = np.zeros_like(at)
    for column in mids.T[::-1]:
        total = total * at + column[:, None]
    return total


def _products(roots: np.ndarray) -> Any:
    """prod over j != i of (z_i - z_j)."""
    apart = roots[:, :, None] - roots[:, None, :]
    diagonal = np.arange(roots.shape[1])
    apart[:, diagonal, diagonal] = 1
    found = np.prod(apart, axis=2)
    return np.where(found == 0, np.nan, found)

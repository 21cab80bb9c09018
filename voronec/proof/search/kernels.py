"""One class of monomials: which of their sums are integrals, and which of these are new."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from voronec.proof.search.probe import Values
from voronec.proof.search.residues import Array, free_columns, kernel

__all__ = ["SURPLUS", "Candidate", "Kernel", "KnownFunction", "investigate", "products", "rank_of"]

SURPLUS = 25
"""Points beyond the number of unknowns, at which a dependence would have to hold by chance."""
PRODUCT_LIMIT = 300
"""How many products of known integrals are set off at most."""


@dataclass(frozen=True)
class KnownFunction:
    """An integral that is known: its degrees in velocities and positions, and, where it was
    found, its monomials and their coefficients; else its place among the declared ones."""

    degree: int
    positions: int
    place: int = -1
    exponents: Array | None = None
    vector: Array | None = None

    def values(self, at: Values) -> Array:
        """Its values at the points."""
        if self.exponents is None or self.vector is None:
            return np.asarray(at.known[self.place])
        return combine(at.monomials(self.exponents), self.vector, at.p)

    def gradient(self, at: Values) -> Array:
        """Its gradient, (variable, point)."""
        if self.exponents is None or self.vector is None:
            return np.asarray(at.known_slopes[self.place])
        return at.gradient(self.exponents, at.monomials(self.exponents), self.vector)


@dataclass(frozen=True)
class Candidate:
    """An integral modulo p: a sum of independent monomials, one of which has coefficient 1.

    ``free`` is the place of that one.
    """

    exponents: Array
    vector: Array
    free: int


@dataclass(frozen=True)
class Kernel:
    """Of ``independent`` functions of a class, a space of ``dimension`` consists of integrals, of
    which ``known`` are sums of products of known ones."""

    independent: int
    dimension: int
    known: int
    new: tuple[Candidate, ...]


def combine(values: Array, vector: Array, p: int) -> Array:
    """values . vector modulo p."""
    return np.asarray((values * vector % p).sum(axis=1) % p)


def products(known: Sequence[KnownFunction], degree: int, positions: int) -> list[tuple[int, ...]]:
    """Exponents of the products of known integrals within the degrees, 1 first."""
    found = []
    for row in _within(known, degree, positions):
        found.append(row)
        if len(found) == PRODUCT_LIMIT:
            break
    return found


def _within(
    known: Sequence[KnownFunction], degree: int, positions: int
) -> Iterator[tuple[int, ...]]:
    if not known:
        yield ()
        return
    first = known[0]
    dv = max(first.degree, 0)
    dq = max(first.positions, 1) if dv == 0 else 0
    power = 0
    while power * dv <= degree and power * dq <= positions:
        for rest in _within(known[1:], degree - power * dv, positions - power * dq):
            yield (power, *rest)
        power += 1


def product_values(
    known: Sequence[KnownFunction], powers: Sequence[tuple[int, ...]], at: Values
) -> Array:
    """The values of products of known integrals, (point, product)."""
    factors = [k.values(at) for k in known]
    columns = []
    for row in powers:
        value = np.ones(at.points, dtype=np.int64)
        for factor, e in zip(factors, row, strict=True):
            for _ in range(e):
                value = value * factor % at.p
        columns.append(value)
    return np.array(columns, dtype=np.int64).T


def investigate(exponents: Array, at: Values, known: Array) -> Kernel:
    """The integrals among sums of monomials; ``known``: values of known ones, (point, integral)."""
    values = at.monomials(exponents)
    _, independent = free_columns(values, at.p)
    exponents, values = exponents[independent], values[:, independent]
    rates = at.rates(exponents, values)
    vectors, free = _sparse_kernel(rates, at.p)
    if not free:
        return Kernel(len(independent), 0, 0, ())
    # Known ones inside the class: sums of products that are sums of its monomials.
    together, _ = kernel(np.concatenate([values, known], axis=1), at.p)
    inside, pivots = free_columns(together[:, : len(independent)][:, free], at.p)
    new = [_candidate(exponents, vectors[i], j) for i, j in enumerate(free) if i not in set(pivots)]
    return Kernel(len(independent), len(free), len(inside), tuple(new))


def _sparse_kernel(rates: Array, p: int) -> tuple[Array, list[int]]:
    """The kernel in echelon form, by the order of the columns or its reverse: the sparser one."""
    vectors, free = kernel(rates, p)
    if not free:
        return vectors, free
    turned, ends = kernel(rates[:, ::-1], p)
    turned, ends = turned[:, ::-1], [rates.shape[1] - 1 - j for j in ends]
    if np.count_nonzero(turned) < np.count_nonzero(vectors):
        return turned, ends
    return vectors, free


def _candidate(exponents: Array, vector: Array, free: int) -> Candidate:
    support = np.flatnonzero(vector)
    place = int(np.flatnonzero(support == free)[0])
    return Candidate(exponents[support], vector[support], place)


def rank_of(gradients: Sequence[Array], at: Values) -> int:
    """The rank of the gradients of functions at one point: so many are independent there."""
    rows = [*(g[:, 0] for g in at.relation_slopes), *(g[:, 0] for g in gradients)]
    if not rows:
        return 0
    _, pivots = free_columns(np.array(rows, dtype=np.int64), at.p)
    return len(pivots)

"""Rotations and motions of R^n without coordinates: angular velocities as skew matrices.

A body of R^n turns by g in SO(n); Omega = g^T dg/dt is its angular velocity along the body's axes,
and W = g^T dx/dt the velocity of its centre x.  The entries of Omega and W are velocities along the
left-invariant fields of SO(n) and SE(n), whose brackets are those of the matrices,

    [E_ij, E_kl] = d_jk E_il - d_ik E_jl - d_jl E_ik + d_il E_jk,
    [E_ij, F_k] = d_jk F_i - d_ik F_j,

with E_ij = e_i e_j^T - e_j e_i^T.  Take them to ``voronec.Frame.group``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import sympy as sp

from voronec.algebra.arguments import COUNT, MATRIX, SEQUENCE, accepts, require
from voronec.algebra.text import as_expression
from voronec.declaration.reading import expression
from voronec.errors import DefinitionError, quote

Pair = tuple[int, int]
DIMENSIONS = range(2, 10)
"""Of spaces in which bodies turn: with one digit, so that names such as w12 are read one way."""


@dataclass(frozen=True)
class BodyVelocity:
    """The velocity of a body in R^n along its own axes; ``dimension`` is n, from 2 to 9.

    Omega, n x n and skew, is the angular velocity, dR/dt = R Omega, W that of the origin, n
    components; ``DefinitionError`` for another n.
    For n = 3 and omega with Omega x = omega x x: Omega12 = -omega3, Omega13 = omega2,
    Omega23 = -omega1.
    """

    dimension: int

    def __post_init__(self) -> None:
        require("a body in R^n", "dimension", self.dimension, COUNT)
        if self.dimension not in DIMENSIONS:
            raise DefinitionError(
                f"a body in R^n with n = {self.dimension}; names of entries such as Omega12 allow "
                f"n from {DIMENSIONS[0]} to {DIMENSIONS[-1]}"
            )

    @cached_property
    def pairs(self) -> tuple[Pair, ...]:
        """The pairs i < j, counted from 1."""
        return tuple(combinations(range(1, self.dimension + 1), 2))

    @cached_property
    def angular(self) -> tuple[sp.Symbol, ...]:
        """The entries Omega_ij, i < j, of Omega."""
        return self.skew_symbols("Omega")

    @cached_property
    def linear(self) -> tuple[sp.Symbol, ...]:
        """W1, ..., Wn, the entries of W."""
        return tuple(sp.Symbol(f"W{i + 1}") for i in range(self.dimension))

    @cached_property
    def normal(self) -> tuple[sp.Symbol, ...]:
        """gamma, a unit vector seen from the body."""
        return tuple(sp.Symbol(f"gamma{i + 1}") for i in range(self.dimension))

    def skew_symbols(self, letter: str) -> tuple[sp.Symbol, ...]:
        """Symbols for the entries i < j of a skew matrix."""
        return tuple(sp.Symbol(f"{letter}{i}{j}") for i, j in self.pairs)

    @cached_property
    def matrix(self) -> sp.ImmutableMatrix:
        """Omega, n x n, with Omega_ji = -Omega_ij."""
        return skew(self.angular, self.dimension)

    def apparent_rate(
        self, vector: Sequence[Any], moving: Sequence[Any] | None = None
    ) -> sp.ImmutableMatrix:
        """The rate, along the body's axes, of a vector that is fixed in space: -Omega gamma; of one
        that moves with the velocity ``moving`` there, which is added."""
        rate = -self.matrix * sp.Matrix(vector)
        return sp.ImmutableMatrix(rate if moving is None else rate + sp.Matrix(moving))

    def energy(self, moments: Sequence[Any], mass: Any = 0) -> sp.Expr:
        """sum J_ij Omega_ij^2 / 2 + mass |W|^2 / 2, for moments J_ij in the planes i < j.

        There are n (n - 1)/2 moments, in the order of ``pairs``.  A rigid body with the second
        moments a_i of its mass has J_ij = a_i + a_j."""
        turning = sum(j * w**2 for j, w in zip(moments, self.angular, strict=True))
        return as_expression(turning + mass * sum(w**2 for w in self.linear)) / 2

    @property
    def last(self) -> tuple[sp.Symbol, ...]:
        """Omega_in, i < n."""
        return tuple(w for w, p in zip(self.angular, self.pairs, strict=True) if self._ends(p))

    @property
    def others(self) -> tuple[sp.Symbol, ...]:
        """Omega_ij, i < j < n."""
        return tuple(w for w, p in zip(self.angular, self.pairs, strict=True) if not self._ends(p))

    def _ends(self, pair: Pair) -> bool:
        return pair[1] == self.dimension

    def twist(self, normal: Sequence[Any]) -> tuple[sp.Expr, ...]:
        """gamma_n Omega_ij - gamma_j Omega_in + gamma_i Omega_jn, i < j < n: they vanish where the
        body does not turn in planes at right angles to gamma, Omega = gamma u^T - u gamma^T; for
        n = 3, where (omega, gamma) = 0.  They are independent where gamma_n is not 0."""
        g, w, n = normal, self.matrix, self.dimension - 1
        return tuple(
            g[n] * w[i, j] - g[j] * w[i, n] + g[i] * w[j, n] for i, j in combinations(range(n), 2)
        )

    def normal_momentum(self, momenta: Sequence[Any]) -> sp.ImmutableMatrix:
        """G gamma of a body without twist: gamma_n P_i and -(P, gamma), P_i those of Omega_in.

        P_i is dL/dOmega_in with the other Omega_ij as functions of these; G is dL/dOmega."""
        *others, last = self.normal
        final = -sum(p * g for p, g in zip(momenta, others, strict=True))
        return sp.ImmutableMatrix([*(last * p for p in momenta), final])

    @cached_property
    def rotations(self) -> Mapping[tuple[sp.Symbol, sp.Symbol], Mapping[sp.Symbol, int]]:
        """The brackets of SO(n), by the names of the velocities."""
        name = dict(zip(self.pairs, self.angular, strict=True))
        brackets: dict[tuple[sp.Symbol, sp.Symbol], Mapping[sp.Symbol, int]] = {}
        for p, q in combinations(self.pairs, 2):
            shared = {*p} & {*q}
            if len(shared) != 1:
                continue
            k = shared.pop()
            (i,), (j,) = {*p} - {k}, {*q} - {k}  # [E_ik, E_kj] = E_ij
            sign = (1 if p == (i, k) else -1) * (1 if q == (k, j) else -1)
            brackets[name[p], name[q]] = {name[min(i, j), max(i, j)]: sign if i < j else -sign}
        return brackets

    @cached_property
    def motions(self) -> Mapping[tuple[sp.Symbol, sp.Symbol], Mapping[sp.Symbol, int]]:
        """The brackets of SE(n)."""
        brackets = dict(self.rotations)
        for (i, j), omega in zip(self.pairs, self.angular, strict=True):
            at, to = self.linear[i - 1], self.linear[j - 1]
            brackets[omega, to] = {at: 1}
            brackets[omega, at] = {to: -1}
        return brackets


def _check_count(entries: Sequence[Any], dimension: int) -> list[sp.Expr]:
    """As many expressions as there are pairs of axes."""
    above = [expression(entry, "an entry") for entry in entries]
    if dimension not in DIMENSIONS or len(above) != dimension * (dimension - 1) // 2:
        raise DefinitionError(
            f"{len(above)} entries for {quote(dimension)} dimensions; give n (n - 1) / 2 of them, "
            f"with n from {DIMENSIONS[0]} to {DIMENSIONS[-1]}"
        )
    return above


@accepts(entries=SEQUENCE, dimension=COUNT)
def skew(entries: Sequence[Any], dimension: int) -> sp.ImmutableMatrix:
    """The skew matrix, n x n for n = ``dimension``, with these n (n - 1)/2 entries above the
    diagonal, row by row; another number of them raises ``DefinitionError``."""
    above = _check_count(entries, dimension)
    table = sp.zeros(dimension, dimension)
    for (i, j), entry in zip(combinations(range(dimension), 2), above, strict=True):
        table[i, j], table[j, i] = entry, -entry
    return sp.ImmutableMatrix(table)


@accepts(moments=SEQUENCE, dimension=COUNT)
def product_moments(moments: Sequence[Any], dimension: int) -> dict[Pair, sp.Expr]:
    """The moments J_ij, 1 < i < j, but J_23, where all moments are products, J_ij = a_i a_j.

        J_ij = J_1i J_1j J_23/(J_12 J_13)

    ``moments`` are all n (n - 1)/2 of them for n = ``dimension``, in the order of the pairs
    (1, 2), (1, 3), ..., (n - 1, n); the result is {(i, j): its value}, to be put in as parameters
    of a case.  ``DefinitionError`` where their number is another.
    """
    pairs = combinations(range(1, dimension + 1), 2)
    given = dict(zip(pairs, _check_count(moments, dimension), strict=True))
    scale = given[2, 3] / (given[1, 2] * given[1, 3])
    others = [pair for pair in given if pair[0] > 1 and pair != (2, 3)]
    return {(i, j): scale * given[1, i] * given[1, j] for i, j in others}


@accepts(moments=SEQUENCE, vector=SEQUENCE)
def product_form(moments: Sequence[Any], vector: Sequence[Any]) -> sp.Expr:
    """a_1 sum a_i gamma_i^2 for moments J_ij = a_i a_j, ``vector`` being gamma, of n entries.

    It is J_12 J_13/J_23 gamma_1^2 + sum J_1i gamma_i^2, so that no root occurs; ``moments`` are as
    for ``product_moments``.
    """
    vector = [expression(entry, "an entry of a vector") for entry in vector]
    size = len(vector)
    pairs = combinations(range(1, size + 1), 2)
    given = dict(zip(pairs, _check_count(moments, size), strict=True))
    form = given[1, 2] * given[1, 3] / given[2, 3] * vector[0] ** 2
    return as_expression(form + sum(given[1, j] * vector[j - 1] ** 2 for j in range(2, size + 1)))


@accepts(matrix=MATRIX)
def wedge_square(matrix: sp.MatrixBase) -> sp.ImmutableMatrix:
    """The bivector of a skew matrix times itself: a number for n = 4, for n = 5 a vector, which
    turns with the axes as the matrix does; nothing for n = 3.

    The entries are Pfaffians, M_ab M_cd - M_ac M_bd + M_ad M_bc, with the sign of the axis that is
    left out, in a column.  Raises ``DefinitionError`` for what is no square matrix.
    """
    m, size = matrix, range(matrix.rows)
    entries = [
        (-1) ** sum({*size} - {a, b, c, d})
        * (m[a, b] * m[c, d] - m[a, c] * m[b, d] + m[a, d] * m[b, c])
        for a, b, c, d in combinations(size, 4)
    ]
    return sp.ImmutableMatrix(len(entries), 1, entries[::-1])


@accepts(matrix=MATRIX)
def skew_entries(matrix: sp.MatrixBase) -> tuple[sp.Expr, ...]:
    """The n (n - 1)/2 entries of an n x n matrix above the diagonal, row by row;
    ``DefinitionError`` for what is no square matrix."""
    return tuple(matrix[i, j] for i, j in combinations(range(matrix.rows), 2))

"""Gradings of a field: scalings and changes of sign that take motions to motions.

A weight w of each generator and tau of the time such that every equation is homogeneous.  Over Q
these are scalings, modulo 2 changes of sign.  Either way the homogeneous parts of an integral are
integrals, so that an ansatz falls apart into its classes, exactly.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations
from typing import Any

import flint
import numpy as np
import symengine as se

from voronec.algebra.field import Fraction
from voronec.algebra.ring import Ring, sparse_terms
from voronec.equations.vector_field import VectorField
from voronec.errors import EngineLimit
from voronec.proof.search.residues import Array, kernel

JETS = 5
"""How often slopes of functions may bring in new functions."""


class Gradings:
    """All gradings of a field for which the ``letters`` of an ansatz are homogeneous.

    The symbols ``free`` are parameters that may be scaled too; the others keep their values.
    """

    def __init__(
        self, field: VectorField, letters: Sequence[Any], free: Iterable[Any] = ()
    ) -> None:
        scanned = [*field.entries, *letters, *field.relations, *field.variables, *field.parameters]
        self.field, self.moving = field, {*field.variables, *free}
        self.ring, scanned, self.jets = _with_jets(scanned, field)
        fractions = {e: self.ring.fraction(e) for e in scanned}
        self.generators = len(self.ring.meaning)
        self.size = self.generators + 1 + len(field.force)  # weights, tau, one for each row
        self.rows: list[Array] = []
        self._equations(fractions)
        tops = [self._homogeneous(fractions[e]) for e in letters]
        self._bases = self._solve()
        self.letters = np.array(tops, dtype=np.int64).reshape(len(letters), self.size)

    def classes(self, exponents: Array) -> list[tuple[int, ...]]:
        """The class of each monomial, given by its exponents in the letters."""
        scalings, signs = self._bases
        rows = exponents @ self.letters
        parts = np.concatenate([rows @ scalings.T, rows @ signs.T % 2], axis=1)
        return [tuple(map(int, row)) for row in parts]

    def normalization(self, parameters: Sequence[Any]) -> tuple[list[int], Array, Array]:
        """Parameters that scalings make 1, by place; for each a scaling that multiplies it alone
        of them, as weights of all parameters and of the letters."""
        scalings, _ = self._bases
        places = [self.ring.index(s) if self.ring.has(s) else -1 for s in parameters]
        weights = np.zeros((len(scalings), len(parameters)), dtype=np.int64)
        for column, i in enumerate(places):
            if i >= 0:
                weights[:, column] = scalings[:, i]
        table = np.concatenate([weights, scalings @ self.letters.T], axis=1)
        best: tuple[int, list[int], Array] | None = None
        rank = int(flint.fmpz_mat(weights.tolist()).rank()) if weights.size else 0
        for chosen in combinations(range(len(parameters)), rank):
            combined = _solve_scalings(table, chosen)
            if combined is not None and (best is None or int(abs(combined).sum()) < best[0]):
                best = (int(abs(combined).sum()), list(chosen), combined)
        if best is None or not rank:
            return [], table[:0, : len(parameters)], table[:0, len(parameters) :]
        return best[1], best[2][:, : len(parameters)], best[2][:, len(parameters) :]

    def _unit(self, index: int) -> Array:
        row = np.zeros(self.size, dtype=np.int64)
        row[index] = 1
        return row

    def _weight(self, monomial: Iterable[tuple[int, int]]) -> Array:
        row = np.zeros(self.size, dtype=np.int64)
        for g, e in monomial:
            row[g] = e
        return row

    def _same(self, poly: Any) -> Array:
        """The weight of a polynomial, all of whose terms must agree."""
        weights = [self._weight(m) for m in sparse_terms(poly)]
        self.rows += [w - weights[0] for w in weights[1:]]
        return weights[0] if weights else np.zeros(self.size, dtype=np.int64)

    def _homogeneous(self, f: Fraction) -> Array:
        weight = self._same(f.num)
        for factor, power in self.ring.field.factors(f.den):
            weight = weight - power * self._same(factor)
        return weight

    def _equations(self, fractions: dict[Any, Fraction]) -> None:
        field, tau = self.field, self._unit(self.generators)
        for e in field.relations:
            self._homogeneous(fractions[e])
        for generator, degree, rule in self.ring.field.rules:
            rest = self.ring.field.gens[generator] ** degree - rule
            self.rows.append(self._same(rest) - degree * self._unit(generator))
        self._freeze()
        for q, rate in zip(field.positions, field.rates, strict=True):
            if fractions[rate].num != 0:
                self._constrain_position(q, self._homogeneous(fractions[rate]) - tau)
        for i, (row, force) in enumerate(zip(field.mass, field.force, strict=True)):
            common = self._unit(self.generators + 1 + i)
            if fractions[force].num != 0:
                self.rows.append(self._homogeneous(fractions[force]) - common)
            for v, entry in zip(field.velocities, row, strict=True):
                if fractions[entry].num != 0:
                    weight = self._homogeneous(fractions[entry]) + self._unit(self.ring.index(v))
                    self.rows.append(weight + tau - common)

    def _constrain_position(self, position: Any, weight: Array) -> None:
        """The weight of a position is that of its rate without tau, by symbol and by angle."""
        self.rows.append(weight - self._unit(self.ring.index(position)))
        if position in self.ring.pairs:
            c, s = (self._unit(self.ring.index(x)) for x in self.ring.pairs[position])
            self.rows.append(weight - s + c)

    def _freeze(self) -> None:
        """Parameters, and what enters otherwise than by products and powers, keep their values."""
        ring, moving = self.ring, self.moving
        plain = _plain(ring, moving, self.field)
        for i, meaning in enumerate(ring.meaning):
            if i not in plain or not meaning.free_symbols & moving:
                self.rows.append(self._unit(i))
            if i not in plain:
                held = [x for x in meaning.free_symbols & moving if ring.has(x)]
                self.rows += [self._unit(ring.index(x)) for x in held]
            if meaning == self.field.time:
                self.rows.append(self._unit(self.generators))
        for slope in self.jets:  # what keeps its value, keeps its slopes
            self.rows.append(self._homogeneous(ring.fraction(slope)))

    def _solve(self) -> tuple[Array, Array]:
        """Bases of the weights over Q, as integers, and modulo 2."""
        table = np.array(self.rows or [np.zeros(self.size)], dtype=np.int64)
        unique = np.unique(table, axis=0)
        whole = flint.fmpz_mat(unique.tolist())
        nullspace, count = whole.nullspace()
        scalings = [[int(nullspace[i, j]) for i in range(self.size)] for j in range(count)]
        signs, _ = kernel(unique % 2, 2)
        return np.array(scalings, dtype=np.int64).reshape(count, self.size), signs


def _plain(ring: Ring, moving: set[Any], field: VectorField) -> set[int]:
    """The generators that may change by a factor: what moves, radicals, and sines and cosines of
    positions."""
    generators = {ring.index(x) for x in moving if ring.has(x)} | {
        g for g, _, _ in ring.field.rules
    }
    for angle, pair in ring.pairs.items():
        if angle in field.positions:
            generators |= {ring.index(x) for x in pair}
    return generators


def _with_jets(exprs: Sequence[Any], field: VectorField) -> tuple[Ring, list[Any], list[Any]]:
    """The ring of expressions and of the slopes of every generator that is no product or power,
    with these slopes."""
    scanned, jets, moving = list(exprs), [], {*field.variables}
    for _ in range(JETS):
        ring = Ring(scanned)
        for e in scanned:
            ring.fraction(e)  # radicals are declared when they are met
        plain = _plain(ring, moving, field)
        others = [e for i, e in enumerate(ring.meaning) if i not in plain and not _unknown(e)]
        jets = [e.diff(x) for e in others for x in moving & e.free_symbols]
        if all(jet in scanned for jet in jets):
            return ring, scanned, jets
        scanned += [jet for jet in jets if jet not in scanned]
    raise EngineLimit("the functions of an ansatz have slopes without end")


def _solve_scalings(table: Array, chosen: Sequence[int]) -> Array | None:
    """Combinations of scalings, the rows, that are 1 on one of the chosen columns and 0 on the
    others, where their weights are whole."""
    size, rank = len(table), len(chosen)
    square = table[:, list(chosen)]
    beside = np.concatenate([square, np.eye(size, dtype=np.int64)], axis=1)
    echelon, _ = flint.fmpq_mat(flint.fmpz_mat(beside.tolist())).rref()
    rows = echelon.tolist()[:rank]
    if any(rows[i][j] != int(i == j) for i in range(rank) for j in range(rank)):
        return None
    factors = flint.fmpq_mat(rank, size, [x for row in rows for x in row[rank:]])
    combined = (factors * flint.fmpq_mat(flint.fmpz_mat(table.tolist()))).tolist()
    if any(x.q != 1 for row in combined for x in row):
        return None
    return np.array([[int(x.p) for x in row] for row in combined], dtype=np.int64)


def _unknown(expr: Any) -> bool:
    """Whether an expression is an unknown function of symbols, or a derivative of one: its slopes
    are generators of their own, and keep their values as it does."""
    function = expr.args[0] if isinstance(expr, se.Derivative) else expr
    return isinstance(function, se.FunctionSymbol) and all(
        isinstance(a, se.Symbol) for a in function.args
    )

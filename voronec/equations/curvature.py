"""The curvature of the constraint connection and the brackets of a frame, as tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import sympy as sp
from sympy.utilities.iterables import flatten

from voronec.algebra.text import as_expression
from voronec.algebra.typeset import caret_text, html_table
from voronec.equations.definition import Definition
from voronec.equations.derivation import Derivation

Outward = Callable[[Any], sp.Expr]
LONGEST = 200
"""How many characters of a formula a notebook shows."""


@dataclass(frozen=True)
class Curvature:
    """The curvature of the constraint connection in the coordinate frame, in the paper's sign.

    ``curvature[nu, i, j]`` is A_ij^(nu) and ``curvature.time[nu, i]`` is A_i^(nu), with nu over the
    fibre and i, j over the base, from 0; A = -B of the Ehresmann connection
    [DragovicGajicJovanovic2020, after eq. (v4)].  On a group, nu is over the velocities in the
    fibre of its frame, and i, j over the independent ones.
    """

    space: sp.ImmutableDenseNDimArray
    time: sp.ImmutableDenseNDimArray

    def __getitem__(self, index: tuple[int, int, int]) -> sp.Expr:
        return self.space[index]

    def __repr__(self) -> str:
        return f"Curvature({_sizes(space=self.space, time=self.time)})"

    def _repr_html_(self) -> str:
        """For notebooks: the entries that are not zero, of each pair one."""
        return html_table(
            repr(self), [*_entries("A", self.space, True), *_entries("A", self.time, False)]
        )


@dataclass(frozen=True)
class Brackets:
    """[h_i, h_j] = c_ij^k h_k + B_ij^A d_A in the frame in use; X_A for d_A on a group.

    ``c[k, i, j]`` and ``B[A, i, j]``; the index n of i or j, after the velocities, is the time.
    """

    c: sp.ImmutableDenseNDimArray
    B: sp.ImmutableDenseNDimArray

    def __repr__(self) -> str:
        return f"Brackets({_sizes(c=self.c, B=self.B)})"

    def _repr_html_(self) -> str:
        """For notebooks: the entries that are not zero, of each pair one."""
        return html_table(repr(self), [*_entries("c", self.c, True), *_entries("B", self.B, True)])


def _sizes(**tables: sp.ImmutableDenseNDimArray) -> str:
    """The shape of each table, and how many of its entries are not zero."""
    return ", ".join(
        f"{name} {' x '.join(map(str, table.shape))}: {sum(e != 0 for e in flatten(table))} nonzero"
        for name, table in tables.items()
    )


def _entries(
    letter: str, table: sp.ImmutableDenseNDimArray, skew: bool
) -> Iterator[tuple[str, str]]:
    """Indices and formulas of entries that are not zero; a long one is told by its size alone."""
    for index in product(*map(range, table.shape)):
        entry = table[index]
        if entry == 0 or (skew and index[1] > index[2]):
            continue
        text = caret_text(entry)
        length = f"{len(text)} characters"
        yield f"{letter}[{', '.join(map(str, index))}]", text if len(text) <= LONGEST else length


def vertical_parts(d: Derivation) -> dict[tuple[int, int], list[Any]]:
    """B_ij^A in the coordinate frame for i < j, the time last; in the engine's symbols."""
    if d.definition.group is not None:
        return {pair: b for pair, (_, b) in bracket_parts(d).items()}
    connection, n = d.coordinate_connection, d.definition.base
    pairs = [(i, j) for j in range(n + 1) for i in range(j)]
    fibre = len(connection.coordinates) - n
    flat = d.polish([x for i, j in pairs for x in connection.bracket(i, j)[n:]])
    return {p: flat[m * fibre : (m + 1) * fibre] for m, p in enumerate(pairs)}


def bracket_parts(d: Derivation) -> dict[tuple[int, int], tuple[list[Any], list[Any]]]:
    """c_ij^k and B_ij^A in the frame in use for i < j, the time last; in the engine's symbols."""
    connection = d.connection
    pairs = [(i, j) for j in range(connection.n + 1) for i in range(j)]
    result = {p: connection.decompose(*p, d.dual, d.tidy) for p in pairs}
    return {p: (d.polish(c), d.polish(b)) for p, (c, b) in result.items()}


def curvature_of(
    b: Mapping[tuple[int, int], list[Any]], d: Definition, outward: Outward
) -> Curvature:
    """The curvature from its parts B_ij^A, with A = -B [Theory, eqs. (7), (8)]."""
    n, fibre = d.base, len(d.dots) - d.base

    def a(nu: int, i: int, j: int) -> Any:
        return outward(-b[i, j][nu]) if i < j else outward(b[j, i][nu]) if j < i else 0

    space = [a(nu, i, j) for nu in range(fibre) for i in range(n) for j in range(n)]
    time = [a(nu, i, n) for nu in range(fibre) for i in range(n)]
    return Curvature(_array(space, (fibre, n, n)), _array(time, (fibre, n)))


def brackets_of(
    table: Mapping[tuple[int, int], tuple[list[Any], list[Any]]], d: Definition, outward: Outward
) -> Brackets:
    """The brackets of a frame from the parts for i < j."""
    n = len(d.velocities)

    def entry(part: int, k: int, i: int, j: int) -> Any:
        if i == j:
            return 0
        return outward(table[i, j][part][k]) if i < j else -outward(table[j, i][part][k])

    arrays = []
    for part, size in ((0, n), (1, len(d.dots) - d.base)):
        m = range(n + 1)
        entries = [entry(part, k, i, j) for k in range(size) for i in m for j in m]
        arrays.append(_array(entries, (size, n + 1, n + 1)))
    return Brackets(*arrays)


def _array(entries: list[Any], shape: tuple[int, ...]) -> sp.ImmutableDenseNDimArray:
    return sp.ImmutableDenseNDimArray([as_expression(e) for e in entries], shape)

"""Subspaces, each given by the columns of one matrix: the reduced echelon form of what spans it."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy as sp

import voronec as vo


def span(columns: sp.Matrix) -> sp.Matrix:
    """The one matrix of the subspace that some columns span."""
    return _echelon(columns.T)[0].T


def leading_places(space: sp.Matrix) -> tuple[int, ...]:
    """The components by which a vector of the subspace is known."""
    places: tuple[int, ...] = _echelon(space.T)[1]
    return places


def direct_sum(first: sp.Matrix, second: sp.Matrix) -> sp.Matrix:
    """The sum of two subspaces; zero where they are not independent."""
    both = sp.Matrix.hstack(first, second)
    rank = both.rank(iszerofunc=_vanishes, simplify=False)
    return span(both) if rank == both.cols else sp.zeros(*both.shape)


def null_space(rows: sp.Matrix) -> sp.Matrix:
    """The vectors on which all rows vanish."""
    return span(sp.Matrix.hstack(*rows.nullspace(simplify=False, iszerofunc=_vanishes)))


def _echelon(rows: sp.Matrix) -> Any:
    return _echelon_form(rows.as_immutable())


@cache  # a dictionary names the same few subspaces again and again
def _echelon_form(rows: sp.ImmutableMatrix) -> Any:
    return rows.rref(iszerofunc=_vanishes, simplify=False)


def _vanishes(entry: Any) -> bool:
    """Whether an entry is proved to be zero: a pivot is what is not."""
    return vo.prove_equal(entry).proved

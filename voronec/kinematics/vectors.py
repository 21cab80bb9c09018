"""Vectors of three expressions, for SymPy and symengine alike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import sympy as sp

from voronec.algebra.text import as_expression
from voronec.errors import DefinitionError, quote

__all__ = ["Vector", "apply_matrix", "column", "cross", "dot", "matrix_product", "three"]

Vector = tuple[Any, Any, Any]


def dot(a: Iterable[Any], b: Iterable[Any]) -> Any:
    """The scalar product a . b = sum of a_i b_i in an orthonormal frame, of two vectors of one
    length, which nobody checks."""
    return sum(map(_product, a, b))


def cross(a: Sequence[Any], b: Sequence[Any]) -> Vector:
    """The vector product a x b = (a2 b3 - a3 b2, a3 b1 - a1 b3, a1 b2 - a2 b1) of two vectors of
    three components, a tuple of three, in a right-handed orthonormal frame."""
    return (
        _product(a[1], b[2]) - _product(a[2], b[1]),
        _product(a[2], b[0]) - _product(a[0], b[2]),
        _product(a[0], b[1]) - _product(a[1], b[0]),
    )


def apply_matrix(matrix: Any, vector: Sequence[Any]) -> Vector:
    """A 3 x 3 matrix times a vector."""
    entries = [*vector]
    x, y, z = (dot(row, entries) for row in _rows(matrix))
    return x, y, z


def matrix_product(first: Any, *others: Any) -> sp.ImmutableMatrix:
    """The product of matrices, or lists of rows, and of a column, or a list of expressions: m x n
    times n x p is m x p.

    Equal to SymPy's, which asks of every entry whether it is finite before it takes 0 x for 0.
    Raises ``DefinitionError`` for factors that do not fit.
    """
    rows = _rows(first)
    for other in others:
        factor = _rows(other)
        if any(len(row) != len(factor) for row in rows):
            raise DefinitionError(
                f"in a product of matrices {len(rows[0])} columns meet {len(factor)} rows; "
                "give as many of each"
            )
        columns = [*zip(*factor, strict=True)]
        rows = [[dot(row, column) for column in columns] for row in rows]
    return sp.ImmutableMatrix(rows)


def _rows(matrix: Any) -> Sequence[Sequence[Any]]:
    """The rows of a matrix, and of what stands for a column."""
    if isinstance(matrix, sp.MatrixBase):
        entries, width = matrix.flat(), matrix.cols
        return [entries[i : i + width] for i in range(0, len(entries), width)]
    return [x if isinstance(x, (list, tuple)) else (x,) for x in matrix]


def _product(x: Any, y: Any) -> Any:
    """x y; SymPy asks whether y is finite before it takes 0 y for 0, which costs more than all."""
    if not x:  # as Python asks whether it is zero, which no expression but zero is
        return x
    return _square(x) if x is y else x * y if y else y


def _square(x: Any) -> Any:
    """x^2; SymPy asks whether a term of a sum is infinite, which costs more than all."""
    if isinstance(x, sp.Add) and x.free_symbols:
        return sp.Pow(x, 2, evaluate=False)
    return x**2


def three(things: Any, what: str) -> Vector:
    """Three SymPy expressions out of a sequence or a matrix; ``what`` names them in errors."""
    try:
        entries = tuple(as_expression(thing) for thing in things)
    except (TypeError, DefinitionError):
        entries = ()
    if len(entries) != 3 or not all(is_scalar(e) for e in entries):
        raise DefinitionError(f"{what} must be three expressions, got '{quote(things)}'")
    return entries[0], entries[1], entries[2]


def is_scalar(entry: Any) -> bool:
    """Whether an entry is an expression, and no matrix."""
    return isinstance(entry, sp.Expr) and not isinstance(entry, sp.MatrixExpr)


def column(entries: Sequence[sp.Expr]) -> sp.ImmutableMatrix:
    """A SymPy column matrix."""
    return sp.ImmutableMatrix(len(entries), 1, list(entries))

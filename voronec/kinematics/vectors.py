"""Vectors of three expressions, for SymPy and symengine alike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.text import as_expression
from voronec.errors import DefinitionError, quote

Vector = tuple[Any, Any, Any]
EXPRESSIONS = (sp.Expr, se.Basic, int)
"""What vectors may have for entries as it stands."""


def dot(a: Iterable[Any], b: Iterable[Any]) -> Any:
    """The scalar product a . b = sum of a_i b_i in an orthonormal frame, of two vectors of one
    length.  Raises ``DefinitionError`` for what are no such vectors."""
    first, second = _entries(a), _entries(b)
    if len(first) != len(second):
        raise DefinitionError(
            f"dot: a vector of {len(first)} components meets one of {len(second)}; give as many"
        )
    return _sum_of_products(first, second)


def _sum_of_products(a: Iterable[Any], b: Iterable[Any]) -> Any:
    return sum(map(_product, a, b))


def cross(a: Iterable[Any], b: Iterable[Any]) -> Vector:
    """The vector product a x b = (a2 b3 - a3 b2, a3 b1 - a1 b3, a1 b2 - a2 b1) of two vectors of
    three components, a tuple of three, in a right-handed orthonormal frame.  Raises
    ``DefinitionError`` for what are no such vectors."""
    first, second = _entries(a), _entries(b)
    for vector in (first, second):
        if len(vector) != 3:
            raise DefinitionError(f"cross: a vector has {len(vector)} components; give three")
    return (
        _product(first[1], second[2]) - _product(first[2], second[1]),
        _product(first[2], second[0]) - _product(first[0], second[2]),
        _product(first[0], second[1]) - _product(first[1], second[0]),
    )


def apply_matrix(matrix: Any, vector: Iterable[Any]) -> Vector:
    """A 3 x 3 matrix times a vector."""
    entries = [*vector]
    x, y, z = (_sum_of_products(row, entries) for row in _rows(matrix))
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
        rows = [[_sum_of_products(row, column) for column in columns] for row in rows]
    return sp.ImmutableMatrix(rows)


def _rows(matrix: Any) -> Sequence[Sequence[Any]]:
    """The rows of a matrix, and of what stands for a column."""
    if isinstance(matrix, sp.MatrixBase):
        entries, width = matrix.flat(), matrix.cols
        return [entries[i : i + width] for i in range(0, len(entries), width)]
    rows = [x if isinstance(x, (list, tuple)) else (x,) for x in _list_of(matrix)]
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        raise DefinitionError(
            f"the rows of a matrix are not as long as one another: '{quote(matrix)}'; mend them"
        )
    return [_entries(row) for row in rows]


def _list_of(things: Any) -> list[Any]:
    try:
        return [*things]
    except TypeError:
        raise DefinitionError(
            f"'{quote(things)}' is neither a vector nor a matrix; give a list of expressions"
        ) from None


def _entries(vector: Any) -> list[Any]:
    """The entries of a vector: expressions as they stand, what else there is read as one."""
    return [e if isinstance(e, EXPRESSIONS) else as_expression(e) for e in _list_of(vector)]


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

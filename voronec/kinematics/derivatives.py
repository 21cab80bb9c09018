"""Partial derivatives as SymPy takes them, without the questions that it asks on the way.

``sympy.diff`` asks of every term whether it vanishes, and of every factor beside a derivative that
does whether it is finite; for the formulas of a body that rolls this takes more than all else.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.symbols import is_symbolic_name
from voronec.declaration.reading import expression
from voronec.errors import DefinitionError, quote

__all__ = ["derivative"]


def derivative(function: Any, variable: sp.Symbol) -> sp.Expr:
    """d function/d variable, with respect to a symbol; equal to ``sympy.diff``, term by term.

    Raises ``DefinitionError`` for what is no expression, and a variable that is no symbol.
    """
    if not is_symbolic_name(variable):
        raise DefinitionError(f"derivative: '{quote(variable)}' is no symbol; give one")
    return _Derivatives(variable).of(expression(function, "the function of a derivative"))


class _Derivatives(dict[sp.Basic, sp.Expr]):
    """Expressions with their derivatives by one symbol."""

    def __init__(self, variable: sp.Symbol) -> None:
        super().__init__({variable: sp.Integer(1)})
        self.variable = variable

    def of(self, node: Any) -> Any:
        """The derivative of an expression, found once."""
        if node not in self:
            self[node] = self._find(node) if node.args else sp.Integer(0)
        return self[node]

    def _find(self, node: Any) -> Any:
        if isinstance(node, sp.Add):
            return sp.Add(*filter(None, map(self.of, node.args)))
        if isinstance(node, sp.Mul):
            parts = [(i, self.of(factor)) for i, factor in enumerate(node.args)]
            return sp.Add(*[_with_factor(node.args, i, part) for i, part in parts if part])
        if isinstance(node, sp.Pow) and not self.of(node.exp):
            inner = self.of(node.base)
            return node * (inner * node.exp / node.base) if inner else inner
        known = isinstance(node, sp.Function) and not isinstance(node, AppliedUndef)
        if known and len(node.args) == 1:
            inner = self.of(node.args[0])
            return node.fdiff(1) * inner if inner else inner
        return node.diff(self.variable)


def _with_factor(factors: tuple[Any, ...], i: int, part: Any) -> Any:
    """A product with another factor in the place of one."""
    return sp.Mul(*factors[:i], part, *factors[i + 1 :])

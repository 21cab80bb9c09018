"""Partial derivatives as SymPy takes them of real variables, without the questions that it asks.

All symbols are real here: |x| has the slope x/|x|, where ``sympy.diff`` speaks of re(x)
and im(x); and a sign or a floor has none off its cut, as in ``algebra/piecewise_functions.py``.

``sympy.diff`` asks of every term whether it vanishes, and of every factor beside a derivative that
does whether it is finite; for the formulas of a body that rolls this takes more than all else.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.piecewise_functions import IN_PIECES, written_with_signs
from voronec.algebra.symbols import names_in
from voronec.declaration.reading import expression
from voronec.errors import DefinitionError, quote

_REAL_ONLY = (sp.Abs, sp.sign, sp.floor)


def derivative(function: Any, variable: sp.Expr) -> sp.Expr:
    """d function/d variable, with respect to a symbol, x(t) or its velocity; all of them are real.

    Equal to ``sympy.diff``, term by term, where that does not ask whether they are.  Raises
    ``DefinitionError`` for what is no expression, and a variable that is no symbol.
    """
    if not isinstance(variable, sp.Expr) or names_in(variable) != {variable}:
        raise DefinitionError(f"derivative: '{quote(variable)}' is no symbol; give one")
    return _Derivatives(variable).of(expression(function, "the function of a derivative"))


class _Derivatives(dict[sp.Basic, sp.Expr]):
    """Expressions with their derivatives by one symbol."""

    def __init__(self, variable: sp.Expr) -> None:
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
        if isinstance(node, sp.Abs):  # as of the root that it is inside, lest forms are mixed
            return self.of(node.args[0]) * node.args[0] / node
        if isinstance(node, sp.sign | sp.floor):
            return sp.Integer(0)
        if isinstance(node, sp.Piecewise):
            return sp.Piecewise(*[(self.of(value), where) for value, where in node.args])
        if isinstance(node, IN_PIECES):
            return self.of(written_with_signs(node))
        known = isinstance(node, sp.Function) and not isinstance(node, AppliedUndef)
        if (known and len(node.args) == 1) or node.has(*_REAL_ONLY, *IN_PIECES):
            return self._chain(node)
        return node.diff(self.variable)

    def _chain(self, node: Any) -> Any:
        """The chain rule over arguments, which SymPy would differentiate as complex ones."""
        if isinstance(node, sp.Pow):
            exponent = self.of(node.exp) * sp.log(node.base)
            return node * (exponent + self.of(node.base) * node.exp / node.base)
        if isinstance(node, sp.Subs):  # a slope of an unknown function at a place
            inner, bound, places = node.expr, node.variables, node.point
            slopes = [(inner.diff(v), self.of(p)) for v, p in zip(bound, places, strict=True)]
            slopes.append((self.of(inner), sp.Integer(1)))
            return sp.Add(*[sp.Subs(e, bound, places) * part for e, part in slopes if e and part])
        if not isinstance(node, sp.Function):
            return node.diff(self.variable)
        inner = [(i, self.of(a)) for i, a in enumerate(node.args, 1)]
        return sp.Add(*[node.fdiff(i) * part for i, part in inner if part])


def _with_factor(factors: tuple[Any, ...], i: int, part: Any) -> Any:
    """A product with another factor in the place of one."""
    return sp.Mul(*factors[:i], part, *factors[i + 1 :])

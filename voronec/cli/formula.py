"""A formula as somebody types it on the command line, read as a SymPy expression.

Names are symbols, whatever they are called (``I1``, ``E``, ``gamma``); nothing is executed.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from voronec.errors import DefinitionError

__all__ = ["formula"]

_FUNCTIONS = (
    "sin cos tan cot asin acos atan sinh cosh tanh asinh acosh atanh exp log sqrt"
).split()
_OPERATIONS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}


def formula(text: str, place: str) -> Any:
    """The expression; ``DefinitionError`` names the place where it cannot be read."""
    try:
        return _read(ast.parse(text.strip().replace("^", "**"), mode="eval").body, text)
    except (SyntaxError, ValueError, KeyError, RecursionError, MemoryError):
        raise DefinitionError(
            f"{place}: '{text}' is not a formula; write one such as 2*a*sin(x)/3, with the "
            f"functions {', '.join(_FUNCTIONS)}"
        ) from None


def _read(node: ast.expr, text: str) -> Any:
    import sympy as sp

    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        written = ast.get_source_segment(text.strip().replace("^", "**"), node)
        return sp.Rational(written or repr(node.value))
    if isinstance(node, ast.Name):
        return sp.pi if node.id == "pi" else sp.Symbol(node.id)
    if isinstance(node, ast.BinOp):
        left, right = _read(node.left, text), _read(node.right, text)
        return _OPERATIONS[type(node.op)](left, right)
    if isinstance(node, ast.UnaryOp):
        return _OPERATIONS[type(node.op)](_read(node.operand, text))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        if node.func.id not in _FUNCTIONS or len(node.args) != 1:
            raise ValueError
        return getattr(sp, node.func.id)(_read(node.args[0], text))
    raise ValueError

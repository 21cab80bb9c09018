"""Expressions read back from their text, without running it as code."""

from __future__ import annotations

import ast
import keyword
import re
from typing import Any

import sympy as sp

from voronec.errors import DefinitionError
from voronec.reading import shown

__all__ = ["read_expression"]

FUNCTIONS = (
    "sin cos tan cot sec csc asin acos atan atan2 acot sinh cosh tanh coth asinh acosh atanh "
    "exp log sqrt Abs sign"
).split()
OPERATIONS: dict[type, Any] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Pow: lambda a, b: a**b,
}


def read_expression(text: Any) -> sp.Expr:
    """What ``plain_text`` wrote; every name is a symbol but ``pi``, an unknown function a function.

    Raises ``DefinitionError`` for anything that is no expression.
    """
    if not isinstance(text, str):
        raise DefinitionError(f"'{shown(text)}' is no text of an expression")
    try:
        guarded = re.sub(r"[A-Za-z_]\w*", lambda m: _guarded(m[0]), text)
        return _value(ast.parse(guarded, mode="eval").body)
    except (SyntaxError, ValueError, TypeError, RecursionError, MemoryError):
        raise DefinitionError(f"'{shown(text)}' is no expression; correct it") from None


MARK = "_word_"
"""Put before names that Python keeps for itself, as ``lambda``."""


def _guarded(name: str) -> str:
    return MARK + name if keyword.iskeyword(name) else name


def _value(node: ast.expr) -> sp.Expr:
    if isinstance(node, ast.Constant) and type(node.value) is int:
        return sp.Integer(node.value)
    if isinstance(node, ast.Constant) and type(node.value) is float:
        return sp.Rational(repr(node.value))
    if isinstance(node, ast.Name):
        return sp.pi if node.id == "pi" else sp.Symbol(node.id.removeprefix(MARK))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        inner = _value(node.operand)
        return -inner if isinstance(node.op, ast.USub) else inner
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATIONS:
        return OPERATIONS[type(node.op)](_value(node.left), _value(node.right))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        return _call(node.func.id, node.args)
    raise ValueError


def _call(name: str, arguments: list[ast.expr]) -> sp.Expr:
    if name == "Derivative":
        return sp.Derivative(_value(arguments[0]), *map(_order, arguments[1:]))
    values = [_value(a) for a in arguments]
    if name in FUNCTIONS:
        return getattr(sp, name)(*values)
    return sp.Function(name)(*values)


def _order(node: ast.expr) -> Any:
    """A variable of a derivative, or a pair of one and how often."""
    return tuple(map(_value, node.elts)) if isinstance(node, ast.Tuple) else _value(node)

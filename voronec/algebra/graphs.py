"""Expression graphs of symengine: their nodes, and which of these are taken as they stand."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import symengine as se

from voronec.algebra.numeric_functions import numeric_name
from voronec.algebra.terms import subexpressions
from voronec.errors import EngineLimit


def is_flat(expr: Any) -> bool:
    """Whether an expression is a derivative of a sign or a floor, zero where it exists."""
    if isinstance(expr, se.Subs):
        return is_flat(expr.expr)
    return isinstance(expr, se.Derivative) and isinstance(expr.args[0], (se.sign, se.floor))


def is_atom(expr: Any) -> bool:
    """Whether a symengine expression is a symbol, an unknown function or a derivative of one."""
    kinds = (se.Symbol, se.FunctionSymbol, se.Derivative, se.Subs)
    return isinstance(expr, kinds) and not is_flat(expr) and numeric_name(expr) is None


def nodes(exprs: Iterable[Any]) -> Iterator[Any]:
    """Every node of expression graphs once; unknown functions as they stand."""
    return subexpressions(exprs, is_atom)


def bases(exprs: Iterable[Any]) -> Iterator[Any]:
    """The bases of negative powers, and what tangents divide by."""
    for node in nodes(map(se.sympify, exprs)):
        if isinstance(node, se.Pow):
            base, exponent = node.args
            if exponent.is_Number and exponent.is_negative:
                yield base
        elif isinstance(node, se.tan):
            yield se.cos(node.args[0])
        elif isinstance(node, se.cot):
            yield se.sin(node.args[0])


def rebuild(node: Any, arguments: Sequence[Any]) -> Any:
    """A node with other arguments; with those of f'(xi) at a place ``func`` makes another node."""
    if not isinstance(node, se.Subs):
        return node.func(*arguments)
    derivative, *rest = arguments
    count = len(node.variables)
    return derivative_at(derivative, dict(zip(rest[:count], rest[count:], strict=True)))


def derivative_at(derivative: Any, at: Mapping[Any, Any]) -> Any:
    """f'(b) at b = p, as the derivative of f(p + w) by w at w = 0.

    symengine's own substitution into a derivative loses track of what it depends on.
    """
    function, *variables = derivative.args
    shifts = {b: se.Symbol(f"shift {i + 1}") for i, b in enumerate(at)}
    arguments = [at[a] + shifts[a] if a in at else a for a in function.args]
    if any(v not in at or v not in function.args for v in variables):
        raise EngineLimit(f"the derivative '{derivative}' is not one of a plain function")
    moved = se.Function(function.get_name())(*arguments)
    for variable in variables:
        moved = moved.diff(shifts[variable])
    if any(p.is_Number for p in at.values()):
        raise EngineLimit(f"the derivative of '{function}' at a number; use a parameter for it")
    return moved.xreplace({shift: se.Integer(0) for shift in shifts.values()})

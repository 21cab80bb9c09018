"""Expression graphs of symengine: their nodes, and which of these are taken as they stand."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import symengine as se

from voronec.algebra.numeric_functions import numeric_name

__all__ = ["is_atom", "is_flat", "nodes"]


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
    seen, waiting = set[Any](), list(exprs)
    while waiting:
        node = waiting.pop()
        if node not in seen:
            seen.add(node)
            yield node
            waiting += () if is_atom(node) else node.args

"""Substitution into expression graphs that notices infinite values.

symengine takes 0 * (1 + 1/0) for 0; here every node is looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import symengine as se

from voronec.errors import EngineLimit

__all__ = ["Infinite", "substituted"]

_INFINITE = {se.zoo, se.nan, se.oo, -se.oo}


class Infinite(EngineLimit):
    """A value is infinite, or was not proved to be finite."""


def substituted(
    expr: Any, mapping: Mapping[Any, Any], check: Callable[[Any], None] | None = None
) -> Any:
    """An expression with symbols replaced, all at once; ``Infinite`` where a part has no value.

    ``check`` is called with every base, after the replacement, whose power has a denominator.
    """
    known: dict[Any, Any] = dict(mapping)
    wanted = set(mapping)

    def put(node: Any) -> Any:
        found = known.get(node)
        if found is None:
            found = known[node] = rebuilt(node) if node.free_symbols & wanted else node
        return found

    def rebuilt(node: Any) -> Any:
        arguments = [put(a) for a in node.args]
        if check is not None and isinstance(node, se.Pow):
            base, exponent = arguments
            if not (exponent.is_Number and exponent > 0):
                check(base)
        try:
            value = node.func(*arguments)
        except RuntimeError as error:  # a function of an infinite argument
            raise Infinite(f"a part of the expression is infinite: {error}") from None
        if value in _INFINITE:
            raise Infinite("a denominator in the expression vanishes")
        return value

    return put(expr)

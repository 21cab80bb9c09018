"""Substitution into expression graphs that notices infinite values.

symengine takes 0 * (1 + 1/0) for 0; here every node is looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import symengine as se

from voronec.errors import EngineLimit

__all__ = ["Infinite", "substitute"]

_STEPS = {"sign", "abs", "floor", "ceiling"}
_INFINITE = {se.zoo, se.nan, se.oo, -se.oo}


class Infinite(EngineLimit):
    """A value is infinite, or was not proved to be finite."""


def substitute(
    expr: Any, mapping: Mapping[Any, Any], check: Callable[[Any], None] | None = None
) -> Any:
    """An expression with symbols replaced, all at once; ``Infinite`` where a part has no value.

    ``check`` is called with everything, after the replacement, at zeros of which a part of the
    expression is infinite or not smooth: denominators, radicands, arguments of signs.
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
        if check is not None:
            for critical in _critical(node, arguments):
                check(critical)
        if isinstance(node, se.Derivative) and arguments[1:] != list(node.args[1:]):
            return _derivative(node, put)
        try:
            value = node.func(*arguments)
        except RuntimeError as error:  # a function of an infinite argument
            raise Infinite(f"a part of the expression is infinite: {error}") from None
        if value in _INFINITE:
            raise Infinite("a denominator in the expression vanishes")
        return value

    return put(expr)


def _critical(node: Any, arguments: Sequence[Any]) -> Sequence[Any]:
    """Where they vanish, a function of these arguments is infinite or not smooth."""
    if isinstance(node, se.Pow):
        base, exponent = arguments
        return () if isinstance(exponent, se.Integer) and exponent > 0 else (base,)
    return arguments if type(node).__name__.lower() in _STEPS else ()


def _derivative(node: Any, put: Callable[[Any], Any]) -> Any:
    """A derivative of an unknown function by variables for which other symbols are put in."""
    function, *variables = node.args
    places = list(dict.fromkeys(variables))
    moved = [put(v) for v in places]
    kept = [put(a) for a in function.args]
    still = [a for v, a in zip(function.args, kept, strict=True) if v not in places]
    taken = set().union(*(a.free_symbols for a in still)) & {*moved}
    if taken or len({*moved}) < len(moved) or not all(isinstance(p, se.Symbol) for p in moved):
        raise EngineLimit(f"'{node}' was not moved to a place that is no variable")
    return se.Derivative(function.func(*kept), *[put(v) for v in variables])

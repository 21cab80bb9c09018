"""Substitution of what a target leaves open: constants, and unknown functions with derivatives.

Infinite values are noticed: symengine takes 0 * (1 + 1/0) for 0; here every node is looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se

from voronec.algebra.graphs import derivative_at, rebuild
from voronec.algebra.memo import remember
from voronec.algebra.terms import subexpressions
from voronec.errors import DefinitionError, EngineLimit


def unknown_functions(exprs: Iterable[Any]) -> set[Any]:
    """The unknown functions, such as E(u, v), that expressions hold, also under derivatives."""
    return {node for node in subexpressions(exprs) if isinstance(node, se.FunctionSymbol)}


def formal(name: str, applied: Iterable[Any]) -> Any:
    """An unknown function of formal arguments, whose symbols nobody else has."""
    counts = {len(f.args) for f in applied}
    if len(counts) > 1:
        raise DefinitionError(
            f"the unknown function '{name}' is taken of different numbers of arguments; give the "
            "functions different names"
        )
    slots = [se.Symbol(f"argument {i + 1} of {name}") for i in range(*counts)]
    return se.Function(name)(*slots)


@dataclass(frozen=True)
class Functions:
    """Values of parameters: of symbols, and of unknown functions by their formal arguments.

    In the value of f(x) every symbol but the formal x is the source's.
    """

    values: Mapping[Any, Any]

    @property
    def plain(self) -> dict[Any, Any]:
        """The values of symbols."""
        return {p: e for p, e in self.values.items() if isinstance(p, se.Symbol)}

    @cached_property
    def _open(self) -> dict[str, tuple[tuple[Any, ...], Any]]:
        """Formal arguments and values of functions by name, with the source's symbols under names
        that nobody else has."""
        opened = {}
        for function, value in self.values.items():
            if isinstance(function, se.Symbol):
                continue
            foreign = value.free_symbols - function.free_symbols
            marked = {s: se.Symbol(f"source {s.name}") for s in foreign}
            opened[function.get_name()] = (function.args, value.xreplace(marked))
            self._names.update({mark: s for s, mark in marked.items()})
        return opened

    @cached_property
    def _names(self) -> dict[Any, Any]:
        return {}

    def replace(self, expr: Any, mapping: Mapping[Any, Any]) -> Any:
        """``expr`` with functions by their values, then symbols by ``mapping``, all at once.

        Raises ``EngineLimit`` where that makes a part infinite.
        """
        if self._open:
            expr = self._fill(expr)
            mapping = {**mapping, **self._names}
        return substitute(expr, mapping)

    @cached_property
    def _known(self) -> dict[Any, Any]:
        return {}

    @remember("_known")
    def _fill(self, node: Any) -> Any:
        """An expression with the values of functions in their places, each node once."""
        if not node.args:
            return node
        if isinstance(node, se.Derivative):
            inner, *variables = node.args
            value = self._fill(inner)
            for variable in variables:
                value = value.diff(variable)
            return value
        if isinstance(node, se.Subs):
            at = zip(node.variables, map(self._fill, node.point), strict=True)
            return substitute(self._fill(node.expr), dict(at))
        arguments = [self._fill(a) for a in node.args]
        if isinstance(node, se.FunctionSymbol) and node.get_name() in self._open:
            slots, value = self._open[node.get_name()]
            return substitute(value, dict(zip(slots, arguments, strict=True)))
        return node if arguments == [*node.args] else node.func(*arguments)


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
        image = known.get(node)
        if image is None:
            image = known[node] = rebuilt(node) if node.free_symbols & wanted else node
        return image

    def rebuilt(node: Any) -> Any:
        arguments = [put(a) for a in node.args]
        if check is not None:
            for critical in _critical(node, arguments):
                check(critical)
        if isinstance(node, se.Derivative) and arguments[1:] != list(node.args[1:]):
            return _derivative(node, put)
        try:
            value = rebuild(node, arguments)
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
    if taken or len({*moved}) < len(moved):
        raise EngineLimit(f"'{node}' was not moved to a place where its arguments are no others")
    if all(isinstance(p, se.Symbol) for p in moved):
        return se.Derivative(function.func(*kept), *[put(v) for v in variables])
    slots = {v: se.Symbol(f"slot {i}") for i, v in enumerate(places)}
    inner = function.func(*(slots.get(v, a) for v, a in zip(function.args, kept, strict=True)))
    inner = se.Derivative(inner, *[slots[v] for v in variables])
    return derivative_at(inner, dict(zip(slots.values(), moved, strict=True)))

"""Substitution of what a target leaves open: constants, and unknown functions with derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se

from voronec.errors import DefinitionError
from voronec.proof.relations.substitution import substitute

__all__ = ["Functions", "formal", "unknown_functions"]


def unknown_functions(exprs: Iterable[Any]) -> set[Any]:
    """The unknown functions, such as E(u, v), that expressions hold, also under derivatives."""
    found: set[Any] = set()
    for expr in exprs:
        found |= expr.atoms(se.FunctionSymbol)
    return found


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
        found = {}
        for function, value in self.values.items():
            if isinstance(function, se.Symbol):
                continue
            foreign = value.free_symbols - function.free_symbols
            marked = {s: se.Symbol(f"source {s.name}") for s in foreign}
            found[function.get_name()] = (function.args, value.xreplace(marked))
            self._names.update({mark: s for s, mark in marked.items()})
        return found

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

    def _fill(self, node: Any) -> Any:
        """An expression with the values of functions in their places."""
        if not any(f.get_name() in self._open for f in node.atoms(se.FunctionSymbol)):
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
        return node.func(*arguments)

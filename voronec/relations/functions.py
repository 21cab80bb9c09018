"""Substitution of what a target leaves open: constants, and unknown functions with derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se

from voronec.relations.substitution import substituted

__all__ = ["Functions", "unknown_functions"]


def unknown_functions(exprs: Any) -> set[Any]:
    """The unknown functions, such as E(u, v), that expressions hold, also under derivatives."""
    found: set[Any] = set()
    for expr in exprs:
        found |= expr.atoms(se.FunctionSymbol)
    return found


@dataclass(frozen=True)
class Functions:
    """Values of parameters: of symbols, and of unknown functions by their own arguments.

    The value of f(x) holds x as the argument of f; every other symbol in it is the source's.
    """

    values: Mapping[Any, Any]

    @property
    def plain(self) -> dict[Any, Any]:
        """The values of symbols."""
        return {p: e for p, e in self.values.items() if isinstance(p, se.Symbol)}

    @cached_property
    def _open(self) -> dict[Any, Any]:
        """Values of functions, with the source's symbols under names that nobody else has."""
        found = {}
        for function, value in self.values.items():
            if isinstance(function, se.Symbol):
                continue
            foreign = value.free_symbols - function.free_symbols
            marked = {s: se.Symbol(f"source {s.name}") for s in foreign}
            found[function] = value.xreplace(marked)
            self._names.update({mark: s for s, mark in marked.items()})
        return found

    @cached_property
    def _names(self) -> dict[Any, Any]:
        return {}

    def replaced(self, expr: Any, mapping: Mapping[Any, Any]) -> Any:
        """``expr`` with functions by their values, then symbols by ``mapping``, all at once.

        Raises ``EngineLimit`` where that makes a part infinite.
        """
        functions = self._open
        if functions:
            derivatives = {
                d: _differentiated(functions[d.args[0]], d.args[1:])
                for d in expr.atoms(se.Derivative)
                if d.args[0] in functions
            }
            expr = expr.xreplace(derivatives).xreplace(functions)
            mapping = {**mapping, **self._names}
        return substituted(expr, mapping)


def _differentiated(value: Any, variables: Any) -> Any:
    for variable in variables:
        value = value.diff(variable)
    return value

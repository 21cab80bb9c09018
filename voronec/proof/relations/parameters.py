"""What a relation gives for the parameters and the unknown functions of its target."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.symbols import plain_name
from voronec.declaration.reading import quote
from voronec.declaration.relation import Relation
from voronec.equations.vector_field import VectorField
from voronec.errors import DefinitionError, did_you_mean
from voronec.proof.relations.functions import formal, unknown_functions


class ParameterReader(Protocol):
    """Reads expressions in the symbols of the source."""

    def read(self, expr: sp.Expr, place: str, formals: Mapping[str, Any] = ...) -> Any:
        """The expression in the engine's symbols."""


def read_parameters(
    relation: Relation, reader: ParameterReader, target: VectorField
) -> dict[Any, Any]:
    """The value of every parameter, and of every unknown function, of the target."""
    given = by_name(relation.parameters)
    symbols = {p.name: target.bridge.inward(p.symbol) for p in target.system.parameters}
    functions = applications(target)
    known = {**symbols, **functions}
    for name, value in given.items():
        if name not in known and str(value) == name:
            raise DefinitionError(
                f"relation '{relation.label}': '{name}' goes over by its own name, and "
                f"'{relation.target}' has no such parameter; write Relation(...) with parameters= "
                "for those of the target alone"
            )
    refuse_unknown(relation, "parameters", given, known, target.system.name)
    missing = sorted({*known} - {*given})
    if missing:
        raise DefinitionError(
            f"relation '{relation.label}' leaves the parameter '{missing[0]}' of "
            f"'{target.system.name}' unmapped; add it to parameters="
        )
    values = {s: reader.read(given[name], f"'{name}'") for name, s in symbols.items()}
    for name, applied in functions.items():
        function = formal(name, applied)
        names = _arguments(relation, name, applied)
        formals = dict(zip(names, function.args, strict=True))
        values[function] = reader.read(given[name], f"'{name}'", formals)
    return values


def applications(field: VectorField) -> dict[str, list[Any]]:
    """The unknown functions of a field by name, each with the arguments of which it is taken."""
    calls: dict[str, list[Any]] = {}
    for applied in sorted(unknown_functions([*field.entries, *field.relations]), key=str):
        calls.setdefault(applied.get_name(), []).append(applied)
    return calls


def _arguments(relation: Relation, name: str, applied: list[Any]) -> list[str]:
    """What the arguments of a function are called in its value.

    They are those of a key f(s), else those of which the target takes the function.
    """
    count = len(applied[0].args)
    for key in relation.parameters:
        if isinstance(key, AppliedUndef) and plain_name(key) == name:
            names = [str(a) for a in key.args]
            if len({*names}) == count and all(isinstance(a, sp.Symbol) for a in key.args):
                return names
    names = [str(a) for a in applied[0].args]
    if len(applied) > 1 or len({*names}) < count or not all(a.is_Symbol for a in applied[0].args):
        slots = ", ".join(f"s{i + 1}" for i in range(count))
        raise DefinitionError(
            f"relation '{relation.label}': '{relation.target}' takes '{name}' of "
            f"{', '.join(map(str, applied))}; name its arguments, as in {{{name}({slots}): value}}"
        )
    return names


def by_name(mapping: Mapping[Any, Any]) -> dict[str, Any]:
    """A mapping by names."""
    return {k if isinstance(k, str) else plain_name(k): v for k, v in mapping.items()}


def refuse_unknown(
    relation: Relation, part: str, given: Mapping[str, Any], known: Iterable[str], target: str
) -> None:
    """Raise ``DefinitionError`` where something is mapped that the target does not have."""
    known = list(known)
    for name in given:
        if name not in known:
            raise DefinitionError(
                f"relation '{relation.label}': {part} maps '{quote(name)}', which '{target}' does "
                "not have" + did_you_mean(name, known)
            )

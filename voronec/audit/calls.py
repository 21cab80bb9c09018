"""What a name with a list of arguments means."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import sympy as sp

from voronec.algebra.symbols import time
from voronec.audit.latex.nodes import Call, Dot, Dots, Name, Node, Variation, walk
from voronec.audit.latex.tokens import Misprint
from voronec.audit.latex.vocabulary import APPLIED
from voronec.audit.structure import free_indices
from voronec.audit.study import Study, key_of
from voronec.errors import DefinitionError

__all__ = ["ELEMENTARY", "call", "called", "is_named", "listed_values"]

Where = Mapping[str, int]
Evaluate = Callable[[Node, Study, Where], Any]


ELEMENTARY: dict[str, Callable[[Any], Any]] = {
    "ln": sp.log,
    "arcsin": sp.asin,
    "arccos": sp.acos,
    **{
        n: getattr(sp, n)
        for n in ("sin", "cos", "tan", "cot", "log", "exp", "sinh", "cosh", "tanh")
    },
}
"""The functions that are commands of LaTeX, by their names without the backslash."""


def call(node: Call, study: Study, where: Where, evaluate: Evaluate) -> Any:
    """The value of a function of the dictionary, or of an expression that lists what it holds."""
    inner = (part for argument in node.arguments for part in walk(argument))
    if node.function in inner and not _is_quantity_too(node.function, study):
        raise Misprint(f"'{called(node.function)}' stands among its own arguments")
    function = _function(node.function, study)
    value: Any = evaluate(node.function, study, where) if function is None else None
    if callable(value) and not isinstance(value, sp.Basic):
        function = value  # a member of a family of functions
    if function is not None:
        return function(*[evaluate(a, study, where) for a in node.arguments])
    variables = _variables(study)
    if not value.free_symbols & variables:
        vectors = _two_vectors(node.arguments, study, where, evaluate)
        if vectors is not None:
            return value * vectors[0].dot(vectors[1])  # a constant before a scalar product
    listed = _listed_symbols(node.arguments, study, where, evaluate)
    missing = (value.free_symbols & variables) - listed
    if missing:
        raise Misprint(
            f"'{called(node.function)}' depends on '{sorted(map(str, missing))[0]}', which its "
            "list of arguments leaves out"
        )
    return value


def _variables(study: Study) -> set[sp.Expr]:
    """What moves, and the time."""
    return {*study.motion.rates, *study.motion.constrained, time}


_MATRICES: dict[str, Callable[..., Any]] = {
    "\\diag": sp.diag,
    "\\det": sp.det,
    "\\tr": sp.trace,
}
"""Functions of matrices, unless the dictionary has its own."""


def _function(node: Node, study: Study) -> Callable[..., Any] | None:
    """The dictionary's function of that name; families and expressions are none."""
    if not isinstance(node, Name):
        return None
    for key in (key_of(node) + APPLIED, key_of(node)):
        found = study.table.get(key)
        if callable(found) and not isinstance(found, sp.Basic):
            return found
    return _MATRICES.get(node.head)


def _two_vectors(
    items: tuple[Node, ...], study: Study, where: Where, evaluate: Evaluate
) -> tuple[sp.MatrixBase, sp.MatrixBase] | None:
    """The values of two items, if both are vectors; a list of coordinates has none."""
    try:
        values = [evaluate(item, study, where) for item in items]
    except DefinitionError:
        return None
    if len(values) != 2 or not all(isinstance(value, sp.MatrixBase) for value in values):
        return None
    return values[0], values[1]


def _is_quantity_too(node: Node, study: Study) -> bool:
    """Whether a letter of a function is, by itself, that of something else."""
    return isinstance(node, Name) and {key_of(node), key_of(node) + APPLIED} <= {*study.table}


def _listed_symbols(
    items: tuple[Node, ...], study: Study, where: Where, evaluate: Evaluate
) -> set[sp.Expr]:
    """The symbols that a list of arguments names."""
    for item in items:
        if isinstance(item, Dots):
            continue
        if items.count(item) > 1:
            raise Misprint(f"a list of arguments has '{called(item)}' twice")
        if not is_named(item):
            what = f"a list of arguments holds a {called(item).lower()}, which is no variable"
            raise Misprint(what)
        if isinstance(item, Name) and item.head in study.functions:
            raise Misprint(f"a list of arguments holds '{called(item)}', which is a function")
    values = listed_values(items, study, where, evaluate)
    variables = _variables(study)
    for value in values:
        if isinstance(value, sp.Expr) and len(value.free_symbols & variables) > 1:
            raise Misprint("a list of arguments holds what depends on several variables itself")
    return set[sp.Expr]().union(*(value.free_symbols for value in values))


def listed_values(
    items: tuple[Node, ...], study: Study, where: Where, evaluate: Evaluate
) -> list[Any]:
    """The values of what is listed, in order; dots and bare families are filled in."""
    found: list[Any] = []
    for position, item in enumerate(items):
        if isinstance(item, Dots):
            if not 0 < position < len(items) - 1:
                raise Misprint("dots stand at an end of a list of arguments")
            found += _between(items[position - 1], items[position + 1], study, where, evaluate)
            continue
        letters = [x for x in free_indices(item, study) if x not in where]
        if letters:
            for value in range(1, study.indices[letters[0]] + 1):
                found.append(evaluate(item, study, {**where, letters[0]: value}))
        elif is_named(item) and f"{called(item)}_#" in study.table:
            top = max(study.indices.values())
            found += [study.table[f"{called(item)}_#"](i) for i in range(1, top + 1)]
        else:
            found.append(evaluate(item, study, where))
    return found


def _between(first: Node, last: Node, study: Study, where: Where, evaluate: Evaluate) -> list[Any]:
    """What dots between two members of a family stand for."""
    one, other = (key_of(x, lambda _: "#") for x in (first, last))
    if one != other:
        raise Misprint(f"a list of arguments begins as '{one}' and ends as '{other}'")
    low, high = (int(evaluate(_innermost(x).sub[0], study, where)) for x in (first, last))
    family = study.table[one]
    return [family(i) for i in range(low + 1, high)]


def _innermost(node: Node) -> Node:
    while isinstance(node, (Dot, Variation)):
        node = node.body
    return node


def is_named(node: Node) -> bool:
    """Whether a node is a name, its velocity or its variation."""
    return isinstance(_innermost(node), Name)


def called(node: Node) -> str:
    """The key of a name, or the kind of any other node."""
    return key_of(node) if is_named(node) else type(node).__name__

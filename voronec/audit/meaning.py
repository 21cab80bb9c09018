"""From the tree of a formula to SymPy, under the dictionary of a study."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import sympy as sp

from voronec.algebra.symbols import time, velocity
from voronec.audit.nodes import (
    Bound,
    Call,
    Cross,
    Derivative,
    Dot,
    Dots,
    Elementary,
    Listing,
    Name,
    Node,
    Number,
    Partial,
    Power,
    Product,
    Quotient,
    Root,
    Sum,
    Variation,
)
from voronec.audit.structure import free_indices
from voronec.audit.study import Study, key_of, spell
from voronec.errors import DefinitionError

__all__ = ["UnknownName", "evaluate"]

Where = Mapping[str, int]


class UnknownName(DefinitionError):
    """A name that the dictionary does not hold."""

    def __init__(self, name: str) -> None:
        super().__init__(f"the name '{name}' is not in the dictionary; add it")
        self.name = name


def evaluate(node: Node, study: Study, where: Where | None = None) -> Any:
    """The SymPy value of a tree; ``where`` gives the values of its free indices."""
    try:
        rule = _RULES[type(node)]
    except KeyError:
        raise DefinitionError(
            f"a {type(node).__name__.lower()} has no value by itself (characters {node.at})"
        ) from None
    return rule(node, study, where or {})


# -- names --------------------------------------------------------------------------------


def _lookup(node: Node, study: Study, where: Where) -> Any:
    """The value of a name: first as it is spelled, then with the values of its indices."""
    exact = key_of(node)
    if exact in study.table:
        return study.table[exact]
    defined = study.defined.get(exact)
    if defined is not None:
        return evaluate(defined, study, where)
    inner = node
    while isinstance(inner, (Dot, Variation)):
        inner = inner.body
    if not (inner.sub or inner.sup):
        return _index_value(inner, study, where, node)
    values = [_integer(i, study, where) for i in (*inner.sub, *inner.sup)]
    numbers = iter(values)
    literal = key_of(node, lambda _: str(next(numbers)))
    if literal in study.table:
        return study.table[literal]
    family = key_of(node, lambda _: "#")
    if family in study.table:
        return _member(study.table[family], values, exact)
    raise UnknownName(exact)


def _member(family: Any, values: list[int], name: str) -> Any:
    if min(values) >= 1:
        try:
            return family(*values)
        except (IndexError, KeyError):
            pass
    raise DefinitionError(f"'{name}' has no member with the indices {values}")


def _index_value(name: Name, study: Study, where: Where, node: Node) -> Any:
    if node is name and name.head in where:
        return sp.Integer(where[name.head])
    raise UnknownName(key_of(node))


def _integer(node: Node, study: Study, where: Where) -> int:
    try:
        value = evaluate(node, study, where)
    except UnknownName:
        raise UnknownName(spell(node)) from None
    if not getattr(value, "is_Integer", False):
        raise DefinitionError(f"the index '{spell(node)}' has no integer value")
    return int(value)


def _known(node: Node, study: Study, where: Where) -> Any | None:
    """The dictionary's value of a dotted or varied name, if it has one."""
    try:
        return _lookup(node, study, where)
    except DefinitionError:
        return None


def _named(node: Node) -> bool:
    while isinstance(node, (Dot, Variation)):
        node = node.body
    return isinstance(node, Name)


# -- rules --------------------------------------------------------------------------------


def _dot(node: Dot, study: Study, where: Where) -> Any:
    known = _known(node, study, where) if _named(node) else None
    if known is not None:
        return known
    value = evaluate(node.body, study, where)
    for step in range(node.order):
        first = step == 0 and isinstance(value, sp.Symbol)
        if first and velocity(value) in study.motion.constrained:
            value = velocity(value)
        else:
            value = study.motion.derivative(value)
    return value


def _variation(node: Variation, study: Study, where: Where) -> Any:
    known = _known(node, study, where) if _named(node) else None
    if known is not None:
        return known
    value = study.motion.restrict(evaluate(node.body, study, where))
    return sp.Add(*[sp.diff(value, x) * d for x, d in study.variations.items() if value.has(x)])


def _partial(node: Partial, study: Study, where: Where) -> Any:
    if node.body is None:
        raise DefinitionError("a partial derivative of nothing has no value")
    value = evaluate(node.body, study, where)
    for variable in node.variables:
        symbol = evaluate(variable, study, where)
        if not isinstance(symbol, sp.Symbol):
            raise DefinitionError(f"'{_called(variable)}' is not a variable to differentiate by")
        value = sp.diff(value, symbol)
    return value


def _called(node: Node) -> str:
    """The key of a name, or the kind of any other node."""
    return key_of(node) if _named(node) else type(node).__name__


def _derivative(node: Derivative, study: Study, where: Where) -> Any:
    value = evaluate(node.body, study, where)
    variable = evaluate(node.variable, study, where)
    for _ in range(node.order):
        value = study.motion.derivative(value) if variable == time else sp.diff(value, variable)
    return value


def _bound(node: Bound, study: Study, where: Where) -> Any:
    lower = _integer(node.lower, study, where)
    upper = _integer(node.upper, study, where)
    values = (
        evaluate(node.body, study, {**where, node.index.head: i}) for i in range(lower, upper + 1)
    )
    return _add(list(values))


def _call(node: Call, study: Study, where: Where) -> Any:
    if isinstance(node.function, Name) and not node.function.sub:
        function = study.table.get(key_of(node.function))
        if callable(function) and not isinstance(function, sp.Basic):
            return function(*[evaluate(a, study, where) for a in node.arguments])
    value = evaluate(node.function, study, where)
    listed = _listed_symbols(node.arguments, study, where)
    variables = set(study.motion.rates) | set(study.motion.constrained) | {time}
    missing = (value.free_symbols & variables) - listed
    if missing:
        raise DefinitionError(
            f"'{_called(node.function)}' depends on '{sorted(map(str, missing))[0]}', which its "
            "list of arguments leaves out"
        )
    return value


def _listed_symbols(items: tuple[Node, ...], study: Study, where: Where) -> set[sp.Expr]:
    """The symbols that a list of arguments names; dots and bare families are filled in."""
    found: set[sp.Expr] = set()
    for position, item in enumerate(items):
        if isinstance(item, Dots):
            found |= _between(items[position - 1], items[position + 1], study, where)
            continue
        letters = [x for x in free_indices(item, study) if x not in where]
        if letters:
            for value in range(1, study.indices[letters[0]] + 1):
                found |= evaluate(item, study, {**where, letters[0]: value}).free_symbols
        elif isinstance(item, Name) and f"{item.head}_#" in study.table and not item.sub:
            top = max(study.indices.values())
            found |= {study.table[f"{item.head}_#"](i) for i in range(1, top + 1)}
        else:
            found |= evaluate(item, study, where).free_symbols
    return found


def _between(first: Node, last: Node, study: Study, where: Where) -> set[sp.Expr]:
    inner_first, inner_last = first, last
    while isinstance(inner_first, Dot):
        inner_first, inner_last = inner_first.body, inner_last.body
    low = _integer(inner_first.sub[0], study, where)
    high = _integer(inner_last.sub[0], study, where)
    family = study.table[key_of(first, lambda _: "#")]
    return {family(i) for i in range(low, high + 1)}


def _power(node: Power, study: Study, where: Where) -> Any:
    base = evaluate(node.base, study, where)
    exponent = evaluate(node.exponent, study, where)
    if isinstance(base, sp.MatrixBase):
        if exponent != 2:
            raise DefinitionError("a vector has a square, but no other power")
        return base.dot(base)
    return base**exponent


def _product(node: Product, study: Study, where: Where) -> Any:
    value: Any = sp.Integer(1)
    for factor in node.factors:
        value = value * evaluate(factor, study, where)
    return value


def _add(values: list[Any]) -> Any:
    if any(isinstance(v, sp.MatrixBase) for v in values):
        return sum(values[1:], values[0])
    return sp.Add(*values)


def _listing(node: Listing, study: Study, where: Where) -> Any:
    left, right = (evaluate(item, study, where) for item in node.items)
    return left.cross(right) if node.bracket == "[" else left.dot(right)


_ELEMENTARY: dict[str, Callable[[Any], Any]] = {
    "ln": sp.log,
    "arcsin": sp.asin,
    "arccos": sp.acos,
    **{
        n: getattr(sp, n)
        for n in ("sin", "cos", "tan", "cot", "log", "exp", "sinh", "cosh", "tanh")
    },
}

_RULES: dict[type, Callable[[Any, Study, Where], Any]] = {
    Number: lambda n, s, w: sp.Rational(n.text),
    Name: _lookup,
    Dot: _dot,
    Variation: _variation,
    Sum: lambda n, s, w: _add([sign * evaluate(t, s, w) for sign, t in n.terms]),
    Product: _product,
    Quotient: lambda n, s, w: evaluate(n.top, s, w) / evaluate(n.bottom, s, w),
    Power: _power,
    Root: lambda n, s, w: sp.root(
        evaluate(n.body, s, w), 2 if n.index is None else evaluate(n.index, s, w)
    ),
    Elementary: lambda n, s, w: _ELEMENTARY[n.function](evaluate(n.argument, s, w)),
    Call: _call,
    Cross: lambda n, s, w: evaluate(n.left, s, w).cross(evaluate(n.right, s, w)),
    Listing: _listing,
    Partial: _partial,
    Derivative: _derivative,
    Bound: _bound,
}

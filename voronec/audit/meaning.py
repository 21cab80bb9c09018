r"""From the tree of a formula to SymPy, under the dictionary of a study.

Differentials, forms and vector fields have values by these rules:

* ``dx`` is the time derivative of x (the differential over dt), so that an equality of
  differentials, or of integrals without limits, compares rates, and a one-form is linear in the
  velocities;
* ``\partial x`` outside a derivative is a number of which nothing is known;
* ``\alpha\wedge\beta`` is the value of the two-form on the velocities and the variations:
  alpha(velocity) beta(variation) - alpha(variation) beta(velocity);
* ``\frac{\partial}{\partial x}`` with nothing behind it is ``direction(x)``, a formal symbol, in
  which vector fields are linear;
* ``\pm`` is a name of the dictionary, a factor of what follows it; ``\oplus`` and ``\ker`` are
  functions of the dictionary.

``\frac{\partial f}{\partial x^I}``, where ``I`` is a label, is the derivative by x taken at x^I.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import sympy as sp

from voronec.algebra.symbols import plain_name, time, velocity
from voronec.audit.latex.nodes import (
    POINT,
    TRANSPOSE,
    Bound,
    Call,
    Cases,
    Cross,
    Derivative,
    Differential,
    Dot,
    Dots,
    Elementary,
    Integral,
    Listing,
    Matrix,
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
    Wedge,
    walk,
)
from voronec.audit.latex.tables import links
from voronec.audit.latex.tokens import Misprint, Unfamiliar
from voronec.audit.latex.vocabulary import CALL
from voronec.audit.structure import free_indices
from voronec.audit.study import Study, UnknownRate, key_of, spell
from voronec.errors import DefinitionError, VoronecError

Where = Mapping[str, int]


ELEMENTARY: dict[str, Callable[[Any], Any]] = {
    "ln": sp.log,
    "arcsin": sp.asin,
    "arccos": sp.acos,
    "arctan": sp.atan,
    **{n: getattr(sp, n) for n in "sin cos tan cot sec csc log exp sinh cosh tanh".split()},
}
"""The functions that are commands of LaTeX, by their names without the backslash."""


def _call(node: Call, study: Study, where: Where) -> Any:
    """The value of a function of the dictionary, or of an expression that lists what it holds."""
    function = _function(node.function, study)
    inner = [part for argument in node.arguments for part in walk(argument)]
    named = inner.count(node.function)
    if function is not None:  # f(f(x))
        named -= [part.function for part in inner if isinstance(part, Call)].count(node.function)
    if named and not _is_quantity_too(node.function, study):
        raise Misprint(f"'{_kind_or_key(node.function)}' stands among its own arguments")
    value: Any = evaluate(node.function, study, where) if function is None else None
    if callable(value) and not isinstance(value, sp.Basic):
        function = value  # a member of a family of functions
    if function is not None:
        return function(*[evaluate(a, study, where) for a in node.arguments])
    variables = _variables(study)
    applied = getattr(node.function, "head", "") in study.functions
    moving = variables | {rate for rate in study.motion.rates.values() if rate.is_Symbol}
    if node.arguments == (Name("t"),) and not applied:
        if value.free_symbols & moving:
            return value  # x(t): what moves is a function of the time
        raise DefinitionError(
            f"'{_kind_or_key(node.function)}' is constant, and (t) stands behind it"
        )
    if not value.free_symbols & variables:
        vectors = _two_vectors(node.arguments, study, where)
        if vectors is not None:
            return value * vectors[0].dot(vectors[1])  # a constant before a scalar product
    listed = _listed_symbols(node.arguments, study, where)
    if isinstance(value, sp.MatrixBase):
        return value  # M(q), where M may be constant for this system
    missing = (value.free_symbols & variables) - listed
    if missing:
        raise Misprint(
            f"'{_kind_or_key(node.function)}' depends on '{sorted(map(str, missing))[0]}', which "
            "its list of arguments leaves out"
        )
    if listed and value.free_symbols and not listed & value.free_symbols:
        kind = Misprint if isinstance(node.function, Name) else Unfamiliar  # no rate: its value
        raise kind(f"'{_kind_or_key(node.function)}' depends on none of its arguments")
    return value


def _variables(study: Study) -> set[sp.Expr]:
    """What moves, and the time."""
    return {*study.motion.rates, *study.motion.constrained, time}


def _size(value: Any) -> Any:
    if isinstance(value, sp.MatrixBase) and value.is_square:
        return value.det()
    if isinstance(value, sp.MatrixBase):
        raise DefinitionError("the size of a vector is not read; write it with a scalar product")
    return sp.Abs(value)


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "\\diag": sp.diag, "\\det": sp.det, "\\tr": sp.trace, "abs": _size, "sgn": sp.sign,
    **{name: getattr(sp, name) for name in ("atan2", "floor", "ceiling", "Heaviside")},
}  # fmt: skip
"""Functions by name, unless the dictionary has its own."""


def _function(node: Node, study: Study) -> Callable[..., Any] | None:
    """The dictionary's function of that name; families and expressions are none."""
    if not isinstance(node, Name):
        return None
    for key in (key_of(node) + CALL, key_of(node)):
        function = study.table.get(key)
        if callable(function) and not isinstance(function, sp.Basic):
            return function
    return _FUNCTIONS.get(node.head)


def _two_vectors(
    items: tuple[Node, ...], study: Study, where: Where
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
    return isinstance(node, Name) and {key_of(node), key_of(node) + CALL} <= {*study.table}


def _listed_symbols(items: tuple[Node, ...], study: Study, where: Where) -> set[sp.Expr]:
    """The symbols that a list of arguments names."""
    for item in items:
        if isinstance(item, Dots):
            continue
        if items.count(item) > 1:
            raise Misprint(f"a list of arguments has '{_kind_or_key(item)}' twice")
        if not is_named(item):
            what = f"a list of arguments holds a {_kind_or_key(item).lower()}, which is no variable"
            raise Unfamiliar(what)
        if isinstance(item, Name) and item.head in study.functions:
            raise Misprint(f"a list of arguments holds '{_kind_or_key(item)}', which is a function")
    values = _listed_values(items, study, where)
    variables = _variables(study)
    for value in values:
        if isinstance(value, sp.Expr) and len(value.free_symbols & variables) > 1:
            raise Misprint("a list of arguments holds what depends on several variables itself")
    return set[sp.Expr]().union(*(value.free_symbols for value in values))


def _listed_values(items: tuple[Node, ...], study: Study, where: Where) -> list[Any]:
    """The values of what is listed, in order; dots and bare families are filled in."""
    values: list[Any] = []
    for position, item in enumerate(items):
        if isinstance(item, Dots):
            if not 0 < position < len(items) - 1:
                raise Misprint("dots stand at an end of a list of arguments")
            values += _between(items[position - 1], items[position + 1], study, where)
            continue
        letters = [x for x in free_indices(item, study) if x not in where]
        if letters:
            for value in range(1, study.indices[letters[0]] + 1):
                values.append(evaluate(item, study, {**where, letters[0]: value}))
        elif is_named(item) and f"{_kind_or_key(item)}_#" in study.table:
            top = max(study.indices.values())
            values += [study.table[f"{_kind_or_key(item)}_#"](i) for i in range(1, top + 1)]
        else:
            values.append(evaluate(item, study, where))
    return values


def _between(first: Node, last: Node, study: Study, where: Where) -> list[Any]:
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


def _kind_or_key(node: Node) -> str:
    """The key of a name, or the kind of any other node."""
    return key_of(node) if is_named(node) else type(node).__name__


SENSELESS = (
    VoronecError,
    ArithmeticError,
    AttributeError,
    LookupError,
    NotImplementedError,  # SymPy's answer to a matrix in the exponent
    TypeError,
    ValueError,
)
"""What comes of a formula that makes no sense, such as the sum of a vector and a number."""


class UnknownName(DefinitionError):
    """A name that the dictionary does not hold; ``index`` says that it stands as an index."""

    def __init__(self, name: str, index: bool = False) -> None:
        super().__init__(f"the name '{name}' is not in the dictionary; add it")
        self.name, self.index = name, index


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
    """The value of a name: first as it is latex_of, then with the values of its indices."""
    exact = key_of(node)
    if exact in study.table:
        return study.table[exact]
    defined = study.defined.get(exact)
    if defined is not None:
        return evaluate(defined, study, where)
    inner = _innermost(node)
    if not (inner.sub or inner.sup):
        if inner is node and node.head in where:
            return sp.Integer(where[node.head])
        raise UnknownName(exact)
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
    raise Unfamiliar(f"'{name}' has no member with the indices {values}")


def _integer(node: Node, study: Study, where: Where) -> int:
    try:
        value = evaluate(node, study, where)
    except UnknownName:
        raise UnknownName(spell(node), index=True) from None
    if not getattr(value, "is_Integer", False):
        raise Unfamiliar(f"the index '{spell(node)}' has no integer value")
    return int(value)


def _known(node: Node, study: Study, where: Where) -> Any | None:
    """The dictionary's value of a dotted or varied name, if it has one."""
    try:
        return _lookup(node, study, where)
    except DefinitionError:
        return None


# -- rules --------------------------------------------------------------------------------


def _dot(node: Dot, study: Study, where: Where) -> Any:
    known = _known(node, study, where) if is_named(node) else None
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


def _require_variations(study: Study) -> None:
    if not study.variations:
        raise Unfamiliar("variations are not read here; write what holds along the motion")


def _variation(node: Variation, study: Study, where: Where) -> Any:
    known = _known(node, study, where) if is_named(node) else None
    if known is not None:
        return known
    _require_variations(study)
    value = study.motion.restrict(evaluate(node.body, study, where))
    return sp.Add(*[sp.diff(value, x) * d for x, d in study.variations.items() if value.has(x)])


def direction(coordinate: sp.Expr) -> sp.Symbol:
    """The vector field d/dq of a coordinate q, as a formal symbol."""
    return sp.Symbol(f"{{\\partial_{{{plain_name(coordinate)}}}}}")


def rate(node: Node, study: Study, where: Where | None = None) -> Any:
    """The time derivative of a value; of an integral without limits, its integrand.

    Such an integral has no value, but an equality with it compares rates.
    """
    if isinstance(node, Integral) and node.upper is None:
        return evaluate(node.body, study, where)
    return study.motion.derivative(evaluate(node, study, where))


def _differential(node: Differential, study: Study, where: Where) -> Any:
    if node.sign != "d":
        return sp.Symbol(f"{{\\partial {_kind_or_key(node.body)}}}")
    value = _dot(Dot(node.body), study, where)
    if value == 0:
        raise UnknownRate(f"'d{_kind_or_key(node.body)}' has no value: its rate is not known")
    return value


def _wedge(node: Wedge, study: Study, where: Where) -> Any:
    _require_variations(study)
    left, right = evaluate(node.left, study, where), evaluate(node.right, study, where)
    varied = {study.motion.rates.get(x, velocity(x)): d for x, d in study.variations.items()}
    return left * right.xreplace(varied) - left.xreplace(varied) * right


def _partial(node: Partial, study: Study, where: Where) -> Any:
    if node.body is None:
        fields = [direction(_variable(v, study, where)) for v in node.variables]
        return sp.Mul(*fields)
    value = evaluate(node.body, study, where)
    places: dict[sp.Expr, Any] = {}
    for variable in node.variables:
        symbol = _variable(variable, study, where)
        if isinstance(variable, Name) and variable.sup and not value.has(symbol):
            place, symbol = symbol, _variable(Name(variable.head, variable.sub), study, where)
            places[symbol] = place
        _refuse_doubtful(value, symbol, study)
        value = sp.diff(value, symbol)
    return value.xreplace(places)


def _refuse_doubtful(value: Any, symbol: sp.Symbol, study: Study) -> None:
    """A derivative by a velocity that a function does not hold, which holds those of another frame,
    or of what moves by t: one book takes it on the motion, and another with everything else held.
    """
    quasi, dots = study.motion.quasi, study.motion.constrained.keys()
    held = getattr(value, "free_symbols", {symbol})
    mixed = (symbol in quasi and held & dots) or (symbol in dots and held & quasi)
    if symbol not in held and mixed:
        raise Unfamiliar("no velocities of a frame stand in this; take those of the coordinates")
    if symbol == time and value in study.motion.rates:
        raise Unfamiliar("this may be a rate, or zero; a derivative along the motion has d")


def _variable(node: Node, study: Study, where: Where) -> sp.Symbol:
    symbol = evaluate(node, study, where)
    if not isinstance(symbol, sp.Symbol):
        raise Unfamiliar(f"'{_kind_or_key(node)}' is not a variable to differentiate by")
    return symbol


def _is_velocity(node: Node, value: Any, study: Study) -> bool:
    """Whether a name stands for what is linear in the velocities, as a component of omega is:
    energies, whose derivatives by velocities are partial ones, do not."""
    rates = study.motion.rates
    moving = {rate for rate in rates.values() if rate.is_Symbol} | study.motion.quasi
    held = sorted(value.free_symbols & moving, key=str)
    return (
        isinstance(node, Name)
        and bool(held)
        and all(value.diff(a, b) == 0 for a in held for b in held)
    )


def _derivative(node: Derivative, study: Study, where: Where) -> Any:
    value = evaluate(node.body, study, where)
    variable = evaluate(node.variable, study, where)
    if variable != time and (value.free_symbols & _variables(study)) - {variable}:
        symbols = isinstance(value, sp.Symbol) or _is_velocity(node.body, value, study)
        symbols = symbols and isinstance(variable, sp.Symbol)
        below = _dot(Dot(node.variable), study, where) if symbols and node.order == 1 else 0
        if below == 0:
            what = "a derivative with d is by t; write \\partial, or rates: \\dot y/\\dot x"
            raise DefinitionError(what)
        return _dot(Dot(node.body), study, where) / below  # along the motion
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


def _power(node: Power, study: Study, where: Where) -> Any:
    transposed = node.exponent in TRANSPOSE
    if transposed and isinstance(node.base, Listing):
        return sp.Matrix(_listed_values(node.base.items, study, where))
    base = evaluate(node.base, study, where)
    if transposed and isinstance(base, sp.MatrixBase):
        return base.T
    exponent = evaluate(node.exponent, study, where)
    if isinstance(base, sp.MatrixBase) and not base.is_square:
        if exponent != 2:
            raise Unfamiliar("a vector has a square, but no other power")
        return base.dot(base)
    if isinstance(base, sp.MatrixBase) and not exponent.is_Integer:
        raise Unfamiliar("the power of a matrix must be an integer")
    if base == 0 and exponent.is_negative:
        raise _division_by_zero(node.base, study, where)
    return base**exponent


def _quotient(node: Quotient, study: Study, where: Where) -> Any:
    top, bottom = (evaluate(part, study, where) for part in (node.top, node.bottom))
    if bottom == 0:
        raise _division_by_zero(node.bottom, study, where)
    return top / bottom


def _division_by_zero(node: Node, study: Study, where: Where) -> Misprint:
    return Misprint(f"a denominator is zero{_which_is_zero(node, study, where)}")


def _which_is_zero(node: Node, study: Study, where: Where) -> str:
    """The first name in a tree whose value is zero, in brackets; else nothing."""
    names = (part for part in walk(node) if isinstance(part, Name))
    zero = next((name for name in names if _known(name, study, where) == 0), None)
    return "" if zero is None else f" ('{key_of(zero)}' is zero)"


def _product(node: Product, study: Study, where: Where) -> Any:
    value: Any = sp.Integer(1)
    for factor in node.factors:
        value = value * evaluate(factor, study, where)
        if isinstance(value, sp.MatrixBase) and value.shape == (1, 1):
            value = value[0]  # x^T M x
    return value


_CONDITIONS: dict[str, Any] = {
    "=": sp.Eq, "<": sp.Lt, ">": sp.Gt, "\\ne": sp.Ne, "\\neq": sp.Ne, "\\le": sp.Le,
    "\\leq": sp.Le, "\\ge": sp.Ge, "\\geq": sp.Ge,
}  # fmt: skip


def _cases(node: Cases, study: Study, where: Where) -> Any:
    """The first value whose condition holds; the last one wherever no other does."""
    branches = []
    for value, *conditions in node.cases:
        said = [
            _CONDITIONS[sign](evaluate(a, study, where), evaluate(b, study, where))
            for chain in conditions
            for a, sign, b in links(chain)
        ]
        branches.append((evaluate(value, study, where), sp.And(*said)))
    return sp.Piecewise(*branches[:-1], (branches[-1][0], True))


def _cross(node: Cross, study: Study, where: Where) -> Any:
    """The product of two vectors; of two numbers, their product."""
    left, right = evaluate(node.left, study, where), evaluate(node.right, study, where)
    numbers = not isinstance(left, sp.MatrixBase) and not isinstance(right, sp.MatrixBase)
    return left * right if numbers else left.cross(right)


def _add(values: list[Any]) -> Any:
    if any(isinstance(v, sp.MatrixBase) for v in values):
        values = [v for v in values if v != 0]  # an empty sum may stand beside vectors
        return sum(values[1:], values[0])
    return sp.Add(*values)


def _listing(node: Listing, study: Study, where: Where) -> Any:
    if node.bracket == POINT:
        return sp.Matrix(_listed_values(node.items, study, where))
    left, right = (evaluate(item, study, where) for item in node.items)
    return left.cross(right) if node.bracket == "[" else left.dot(right)


_RULES: dict[type, Callable[[Any, Study, Where], Any]] = {
    Number: lambda n, s, w: sp.Rational(n.text),
    Name: _lookup,
    Dot: _dot,
    Variation: _variation,
    Sum: lambda n, s, w: _add([sign * evaluate(t, s, w) for sign, t in n.terms]),
    Product: _product,
    Quotient: _quotient,
    Power: _power,
    Root: lambda n, s, w: sp.root(
        evaluate(n.body, s, w), 2 if n.index is None else evaluate(n.index, s, w)
    ),
    Elementary: lambda n, s, w: ELEMENTARY[n.function](evaluate(n.argument, s, w)),
    Call: _call,
    Cross: _cross,
    Matrix: lambda n, s, w: sp.Matrix([[evaluate(cell, s, w) for cell in row] for row in n.rows]),
    Cases: _cases,
    Listing: _listing,
    Partial: _partial,
    Derivative: _derivative,
    Differential: _differential,
    Wedge: _wedge,
    Bound: _bound,
}

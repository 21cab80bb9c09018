"""Fractions, derivatives, roots, sums and integrals: what a command with arguments reads as."""

from __future__ import annotations

from typing import TYPE_CHECKING

from voronec.audit.latex.nodes import (
    Bound,
    Derivative,
    Integral,
    Name,
    Node,
    Number,
    Partial,
    Power,
    Quotient,
    Root,
    Sum,
)
from voronec.audit.latex.tokens import Misprint, Token

if TYPE_CHECKING:
    from voronec.audit.latex.reader import Reader

__all__ = ["bound", "fraction", "integral", "root"]


def root(reader: Reader, token: Token) -> Node:
    r"""``\sqrt{a}``, ``\sqrt[n]{a}``."""
    index = None
    if reader.peek() == "[":
        reader.take()
        index = reader.sum()
        reader.take("]")
    return Root(reader.argument(), index, reader.since(token.start))


def integral(reader: Reader, token: Token) -> Node:
    r"""``\int_a^b f dx``: the sign reaches over the next term."""
    lower, upper = _limits(reader)
    return Integral(reader.term(), lower, upper, reader.since(token.start))


def bound(reader: Reader, token: Token) -> Node:
    r"""``\sum_{i=1}^n f``, ``\sum_{1\le i<j\le n} f``."""
    reader.take("_")
    reader.take("{")
    first = reader.sum()
    if reader.peek() in _ORDERS:
        return _ordered_sum(reader, token, first)
    reader.take("=")
    lower = reader.sum()
    reader.take("}")
    reader.take("^")
    upper = reader.argument()
    if not isinstance(first, Name):
        reader.fail("a sum runs over an index")
    return Bound(first, lower, upper, _summand(reader), reader.since(token.start))


_ORDERS = {"<": 1, "\\le": 0, "\\leq": 0}
"""What is to be added to the left side of an order, to reach the smallest right side."""


def _ordered_sum(reader: Reader, token: Token, first: Node) -> Node:
    """Sums inside one another: the last index runs up to the end, each other up to the next."""
    parts, steps = [first], []
    while reader.peek() in _ORDERS:
        steps.append(_ORDERS[reader.take().text])
        parts.append(reader.sum())
    reader.take("}")
    lower, *indices, upper = parts
    if not indices or not all(isinstance(i, Name) for i in indices):
        reader.fail("a sum runs over indices between bounds")
    body = _summand(reader)
    at = reader.since(token.start)
    least = _shifted(lower, sum(steps[:1]))
    for position, index in enumerate(indices):
        most = _shifted(([*indices, upper])[position + 1], -steps[position + 1])
        body = Bound(index, least, most, body, at)
    return body


def _shifted(node: Node, step: int) -> Node:
    if step == 0:
        return node
    return Sum(((1, node), (1 if step > 0 else -1, Number("1"))), node.at)


def _summand(reader: Reader) -> Node:
    return reader.sum() if reader.vocabulary.wide_sums else reader.term()


def _limits(reader: Reader) -> tuple[Node | None, Node | None]:
    lower = upper = None
    while reader.peek() in ("_", "^"):
        if reader.take().text == "_":
            lower = reader.argument()
        else:
            upper = reader.argument()
    return lower, upper


def fraction(reader: Reader, token: Token) -> Node:
    r"""``\frac{a}{b}``, also ``\frac12`` and the signs of differentiation."""
    derivative = _partial_fraction(reader, token) or _total_fraction(reader, token)
    if derivative is not None:
        return derivative
    top = reader.argument()
    return Quotient(top, reader.argument(), reader.since(token.start))


def _partial_fraction(reader: Reader, token: Token) -> Node | None:
    r"""``\frac{\partial^2 f}{\partial x^2}``; f may also follow, or be missing altogether."""
    if (reader.peek(), reader.peek(1)) != ("{", "\\partial"):
        return None
    reader.position += 2
    order = _order(reader)
    body = None if reader.peek() == "}" else _differentiated(reader)
    reader.take("}")
    reader.take("{")
    variables: list[Node] = []
    while reader.peek() == "\\partial":
        reader.take()
        variables.extend(_repeated(reader.factor()))
    if reader.peek() != "}":
        reader.fail("below the line of a derivative stand variables alone", Misprint)
    reader.take()
    if not variables:
        reader.fail("a partial derivative needs a variable")
    _same_order(reader, order, len(variables))
    if body is None and not reader.ends_term():
        body = reader.term()
    return Partial(body, tuple(variables), reader.since(token.start))


def _differentiated(reader: Reader) -> Node:
    r"""What stands above the line behind a sign of differentiation: ``f``, ``f+\partial g``."""
    start, terms = reader.begin(), [(1, reader.term())]
    while reader.peek() in ("+", "-") and reader.peek(1) == "\\partial":
        sign = 1 if reader.take().text == "+" else -1
        reader.take()
        terms.append((sign, reader.term()))
    return terms[0][1] if len(terms) == 1 else Sum(tuple(terms), reader.since(start))


def _total_fraction(reader: Reader, token: Token) -> Node | None:
    r"""``\frac{d}{dt} f``, ``\frac{dx}{dt}``, ``\frac{d^2x}{dt^2}``."""
    if (reader.peek(), reader.peek(1)) != ("{", "d") or not _denominator_is_differential(reader):
        return None
    reader.position += 2
    order = _order(reader)
    body = None if reader.peek() == "}" else reader.term()
    reader.take("}")
    reader.take("{")
    reader.take("d")
    variables = _repeated(reader.factor())
    reader.take("}")
    _same_order(reader, order, len(variables))
    if body is None:
        body = reader.term()
    return Derivative(body, variables[0], order, reader.since(token.start))


def _same_order(reader: Reader, above: int, below: int) -> None:
    """Above and below its line a derivative is of one order."""
    if above != below:
        what = f"a derivative of order {above} above its line is of order {below} below"
        reader.fail(what, Misprint)


def _order(reader: Reader) -> int:
    """The exponent of a sign of differentiation."""
    if reader.peek() != "^":
        return 1
    reader.take()
    order = reader.argument()
    if not isinstance(order, Number):
        reader.fail("the order of a derivative must be a number", Misprint)
    return int(order.text)


def _denominator_is_differential(reader: Reader) -> bool:
    depth = 0
    for i in range(reader.position, len(reader.tokens)):
        depth += (reader.tokens[i].text == "{") - (reader.tokens[i].text == "}")
        if depth == 0:
            words = [t.text for t in reader.tokens[i + 1 : i + 3]]
            return words == ["{", "d"]
    return False


def _repeated(variable: Node) -> list[Node]:
    """``x^2`` in the denominator of a partial derivative is x twice."""
    if isinstance(variable, Power) and isinstance(variable.exponent, Number):
        return [variable.base] * int(variable.exponent.text)
    return [variable]

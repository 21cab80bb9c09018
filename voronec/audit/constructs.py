"""Fractions, derivatives, roots, sums and integrals: what a command with arguments reads as."""

from __future__ import annotations

from typing import TYPE_CHECKING

from voronec.audit.nodes import (
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
)
from voronec.audit.tokens import Token

if TYPE_CHECKING:
    from voronec.audit.reader import Reader

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
    r"""``\sum_{i=1}^n f``."""
    reader.take("_")
    reader.take("{")
    index = reader.factor()
    reader.take("=")
    lower = reader.sum()
    reader.take("}")
    reader.take("^")
    upper = reader.argument()
    if not isinstance(index, Name):
        reader.fail("a sum runs over an index")
    body = reader.sum() if reader.vocabulary.wide_sums else reader.term()
    return Bound(index, lower, upper, body, reader.since(token.start))


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
    r"""``\frac{\partial^2 f}{\partial x^2}``; the numerator may hold nothing but the sign."""
    if (reader.peek(), reader.peek(1)) != ("{", "\\partial"):
        return None
    reader.position += 2
    if reader.peek() == "^":
        reader.take()
        reader.argument()
    body = None if reader.peek() == "}" else reader.term()
    reader.take("}")
    reader.take("{")
    variables: list[Node] = []
    while reader.peek() == "\\partial":
        reader.take()
        variables.extend(_repeated(reader.factor()))
    reader.take("}")
    if not variables:
        reader.fail("a partial derivative needs a variable")
    return Partial(body, tuple(variables), reader.since(token.start))


def _total_fraction(reader: Reader, token: Token) -> Node | None:
    r"""``\frac{d}{dt} f`` and ``\frac{dx}{dt}``."""
    if (reader.peek(), reader.peek(1)) != ("{", "d") or not _denominator_is_differential(reader):
        return None
    reader.position += 2
    body = None if reader.peek() == "}" else reader.term()
    reader.take("}")
    reader.take("{")
    reader.take("d")
    variable = reader.factor()
    reader.take("}")
    if body is None:
        body = reader.term()
    return Derivative(body, variable, 1, reader.since(token.start))


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

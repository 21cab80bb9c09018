"""Subscripts, superscripts and primes: indices, labels and exponents."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from voronec.audit.latex.nodes import Dot, Name, Node, Power, Product, Variation

if TYPE_CHECKING:
    from voronec.audit.latex.reader import Reader

__all__ = ["scripts"]


def scripts(reader: Reader, node: Node, start: int) -> Node:
    """Read what stands below and above ``node``, in any order; ``start`` is where it begins."""
    primes, exponent = 0, None
    sub: tuple[Node, ...] = ()
    sup: tuple[Node, ...] = ()
    while reader.peek() in ("_", "^", "'", '"'):
        mark = reader.take().text
        if mark in ("'", '"'):
            primes += 1 if mark == "'" else 2
        elif mark == "_":
            sub = _indices(reader)
        elif _is_numeral(reader, node):
            sup, exponent = _numeral(reader)
        elif _labels(reader, node):
            sup = _indices(reader)
        else:
            exponent = reader.argument()
    if primes or sub or sup:
        node = _attach(reader, node, primes, sub, sup, start)
    return node if exponent is None else Power(node, exponent, reader.since(start))


def _attach(
    reader: Reader,
    node: Node,
    primes: int,
    sub: tuple[Node, ...],
    sup: tuple[Node, ...],
    start: int,
) -> Node:
    """Indices after an accent or a brace belong to the name inside."""
    if isinstance(node, (Dot, Variation)):
        inner = _attach(reader, node.body, primes, sub, sup, start)
        return replace(node, body=inner, at=reader.since(start))
    if not isinstance(node, Name):
        reader.fail("an index must belong to a name")
    head = node.head + "'" * primes
    return Name(head, node.sub + sub, node.sup + sup, reader.since(start))


def _labels(reader: Reader, node: Node) -> bool:
    """Whether the superscript ahead is a label: ``(\\nu)``, or what the vocabulary names."""
    while isinstance(node, (Dot, Variation)):
        node = node.body
    if not isinstance(node, Name):
        return False
    if reader.all_labels or node.head in reader.vocabulary.labelled:
        return True
    return (reader.peek(), reader.peek(1)) == ("{", "(") and _lone_parenthesis(reader)


def _is_numeral(reader: Reader, node: Node) -> bool:
    r"""Whether the superscript ahead is a Roman numeral: ``x^{II}``, ``x^I``, ``x^{I2}``."""
    if not isinstance(node, Name) or node.head not in reader.vocabulary.numbered:
        return False
    letters = _inside(reader).rstrip("0123456789")
    return letters != "" and set(letters) <= set("IV")


def _inside(reader: Reader) -> str:
    """The words of the group, or the single word, ahead."""
    if reader.peek() != "{":
        return reader.peek()
    ahead = 1
    while reader.peek(ahead) not in ("}", ""):
        ahead += 1
    return "".join(reader.peek(i) for i in range(1, ahead))


def _numeral(reader: Reader) -> tuple[tuple[Node, ...], Node | None]:
    """A Roman numeral is a label; a number after it is an exponent."""
    braced = reader.peek() == "{"
    if braced:
        reader.take()
    letters = [reader.take()]
    while braced and reader.kind() == "letter":
        letters.append(reader.take())
    label = Name("".join(t.text for t in letters), at=(letters[0].start, letters[-1].end))
    exponent = reader.atom() if braced and reader.kind() == "number" else None
    if braced:
        reader.take("}")
    return (label,), exponent


def _lone_parenthesis(reader: Reader) -> bool:
    texts = [reader.peek(i) for i in range(5)]
    return texts[3:5] == [")", "}"]


def _indices(reader: Reader) -> tuple[Node, ...]:
    """``i``, ``{\\nu i}``, ``{n+\\nu}``, ``{(\\nu)}``: indices side by side."""
    if reader.peek() != "{":
        return (reader.argument(),)
    reader.take()
    parenthesis = reader.peek() == "("
    if parenthesis:
        reader.take()
    found: list[Node] = []
    while reader.peek() not in ("}", ")"):
        if reader.peek() == ",":
            reader.take()
            continue
        node = reader.sum()
        found.extend(node.factors if isinstance(node, Product) else (node,))
    if parenthesis:
        reader.take(")")
    reader.take("}")
    return tuple(found)

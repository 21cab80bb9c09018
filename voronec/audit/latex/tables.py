r"""Matrices that are written out, and values by cases.

``pmatrix`` and its like, and ``array`` in brackets, are matrices; ``vmatrix`` is a determinant.
``cases`` holds values, each with the condition behind ``&``, in words such as "if" or without.
"""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Any

from voronec.audit.latex.displays import RELATIONS
from voronec.audit.latex.nodes import Call, Cases, Chain, Matrix, Name, Node
from voronec.audit.latex.tokens import Token, Unfamiliar, complain, tokenize

_DETERMINANTS = ("vmatrix", "Vmatrix")
_MATRICES = ("matrix", "pmatrix", "bmatrix", "Bmatrix", "smallmatrix", "array", *_DETERMINANTS)
_CASES = ("cases", "dcases")
BEGINNINGS = {f"\\begin{{{name}}}": name for name in (*_MATRICES, *_CASES)}
ENDS = {"&", "\\\\", *(f"\\end{{{name}}}" for name in (*_MATRICES, *_CASES))}
"""What ends a cell."""
_OTHERWISE = re.compile(r"otherwise|else|in (?:all )?other cases?|elsewhere")


def read_table(reader: Any, token: Token) -> Node:
    r"""What a ``\begin{...}``, already taken, begins."""
    name = BEGINNINGS[token.text]
    outside, reader.in_bars = reader.in_bars, False
    rows: list[tuple[Node, ...]] = []
    while reader.peek() != f"\\end{{{name}}}":
        rows.append(_case(reader) if name in _CASES else _row(reader))
        if reader.peek() != "\\\\":
            break
        reader.take()
    reader.take(f"\\end{{{name}}}")
    reader.in_bars = outside
    at = reader.since(token.start)
    if name in _CASES:
        return Cases(tuple(rows), at)
    if not rows or len({*map(len, rows)}) != 1:
        what = "the rows of this matrix are not equally long"
        raise complain(reader.source, token.start, what, Unfamiliar)
    matrix = Matrix(tuple(rows), at)
    return Call(Name("\\det", at=at), (matrix,), at) if name in _DETERMINANTS else matrix


def _row(reader: Any) -> tuple[Node, ...]:
    cells = [_cell(reader)]
    while reader.peek() == "&":
        reader.take()
        cells.append(_cell(reader))
    return tuple(cells)


def _cell(reader: Any) -> Node:
    value = None if reader.peek() in RELATIONS | ENDS else reader.sum()
    if value is None or reader.peek() in RELATIONS:
        reader.fail("equations in a table, and empty places, are not read", Unfamiliar)
    return value


_SPACES = {",", ";", ".", "\\quad", "\\qquad", "&"}


def _case(reader: Any) -> tuple[Node, ...]:
    """A value with its condition; the value alone, where it holds in all other cases."""
    value = _cell(reader)
    words = ""
    while reader.peek() in _SPACES or reader.kind() in ("text", "name"):
        token = reader.take()
        words += "" if token.text in _SPACES else token.text
    inside = re.search(r"\$(.+)\$", words)
    if inside is not None:  # \text{if $x>0$}
        inner = type(reader)(tokenize(inside[1]), inside[1], reader.vocabulary, reader.construct)
        return value, inner.formula()
    if reader.peek() in ENDS:
        if words and not _OTHERWISE.search(words):
            reader.fail(f"'{words}' is not read as a condition", Unfamiliar)
        return (value,)
    condition = _relation(reader)
    while reader.peek() in _SPACES - {"&"}:
        reader.take()
    return value, condition


def _relation(reader: Any) -> Chain:
    start, parts, relations = reader.begin(), [reader.sum()], list[str]()
    while reader.peek() in RELATIONS:
        relations.append(reader.take().text)
        parts.append(reader.sum())
    if not relations:
        reader.fail("a condition has no sign of relation", Unfamiliar)
    return Chain(tuple(parts), tuple(relations), reader.since(start))


def links(chain: Chain) -> list[tuple[Node, str, Node]]:
    """The pairs of a chain with the sign between them."""
    return [
        (a, sign, b) for (a, b), sign in zip(pairwise(chain.parts), chain.relations, strict=True)
    ]

"""The smallest parts of a formula: names, groups, accents, what a command by itself reads as."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from voronec.audit.latex.constructs import bound, fraction, integral, root
from voronec.audit.latex.nodes import (
    Call,
    Differential,
    Dot,
    Elementary,
    Listing,
    Name,
    Node,
    Number,
    Power,
    Product,
    Variation,
)
from voronec.audit.latex.scripts import scripts
from voronec.audit.latex.tokens import (
    ACCENTS,
    ELEMENTARY,
    FUNCTIONS,
    GREEK,
    Misprint,
    Token,
    complain,
)

if TYPE_CHECKING:
    from voronec.audit.latex.reader import Reader

__all__ = ["atom"]


def atom(reader: Reader, token: Token) -> Node:
    """What ``token``, already taken, begins; scripts after it are not read."""
    text, at = token.text, (token.start, token.end)
    if token.kind == "number":
        return Number(text, at)
    if text == "d" and _starts_name(reader):
        return Differential(reader.factor(), "d", reader.since(token.start))
    if token.kind in ("letter", "text") or text in FUNCTIONS | GREEK - {"\\delta"}:
        return Name(text, at=at)
    if text in ("(", "[", "{"):
        return _group(reader, token)
    if text in _COMMANDS:
        return _COMMANDS[text](reader, token)
    if text in ELEMENTARY:
        return _elementary(reader, token)
    if text in ACCENTS:
        return _accented(reader, token)
    before = reader.tokens[reader.position - 2].text if reader.position > 1 else ""
    if text in (")", "]", "}") and before != "{":  # braces around nothing bear an index
        what = f"something before '{text}' is missing"
        raise complain(reader.source, token.start, what, Misprint)
    raise complain(reader.source, token.start, f"'{text}' is not understood")


def _starts_name(reader: Reader) -> bool:
    return reader.kind() == "letter" or reader.peek() in GREEK | ACCENTS | {"\\dot"}


def _group(reader: Reader, token: Token) -> Node:
    items = reader.group(token)
    if len(items) == 1:
        return items[0]
    if token.text == "{":
        raise complain(reader.source, token.start, "a comma between braces is not understood")
    return Listing(items, token.text, reader.since(token.start))


def _elementary(reader: Reader, token: Token) -> Node:
    power = None
    if reader.peek() == "^":
        reader.take()
        power = reader.argument()
    start = reader.begin()
    if reader.kind() == "number":
        argument = Product((reader.factor(), reader.factor()), reader.since(start))
    else:
        argument = scripts(reader, reader.atom(), start)
    node: Node = Elementary(token.text[1:], argument, reader.since(token.start))
    return node if power is None else Power(node, power, reader.since(token.start))


def _accented(reader: Reader, token: Token) -> Node:
    inner = reader.argument()
    if isinstance(inner, Dot):  # \bar{\dot U}: a name of its own
        inner = Name(f"\\dot{{{inner.body.head}}}", inner.body.sub, inner.body.sup)
    if not isinstance(inner, Name):
        reader.fail(f"'{token.text}' must stand over a name")
    return replace(inner, head=f"{token.text}{{{inner.head}}}", at=reader.since(token.start))


def _arrow(reader: Reader, token: Token) -> Node:
    r"""``\overrightarrow{O_1O}``: one name, spelled as what stands under the arrow."""
    reader.take("{")
    words = []
    while reader.peek() not in ("}", ""):
        words.append(reader.take().text)
    reader.take("}")
    return Name(f"{token.text}{{{''.join(words)}}}", at=reader.since(token.start))


def _dotted(reader: Reader, token: Token) -> Node:
    order = len(token.text) - len("\\ot")
    body = reader.argument()
    if isinstance(body, Number):
        raise complain(reader.source, token.start, f"'{token.text}' must not stand over a number")
    return Dot(body, order, reader.since(token.start))


def _variation(reader: Reader, token: Token) -> Node:
    return Variation(reader.factor(), reader.since(token.start))


def _lone_partial(reader: Reader, token: Token) -> Node:
    return Differential(reader.factor(), "\\partial", reader.since(token.start))


def _operator(reader: Reader, token: Token) -> Node:
    r"""``\ker f``: applied to the rest of the term, by a function of the dictionary."""
    name = Name(token.text, at=(token.start, token.end))
    return Call(name, (reader.term(),), reader.since(token.start))


_COMMANDS: dict[str, Callable[[Reader, Token], Node]] = {
    "\\frac": fraction,
    "\\dfrac": fraction,
    "\\tfrac": fraction,
    "\\sqrt": root,
    "\\sum": bound,
    "\\int": integral,
    "\\delta": _variation,
    "\\partial": _lone_partial,
    "\\dot": _dotted,
    "\\ddot": _dotted,
    "\\overrightarrow": _arrow,
    "\\ker": _operator,
}

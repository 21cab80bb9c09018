r"""Reads LaTeX mathematics into a tree, in the dialect of papers on mechanics.

Products are written side by side; ``\sin u\cos v`` is (sin u)(cos v); ``\frac12`` and ``\dot u_1``
need no braces; a name followed by a parenthesis is applied where the vocabulary says that it is a
function, or where the parenthesis holds a list.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NoReturn

from voronec.audit.constructs import bound, fraction, integral, root
from voronec.audit.displays import RELATIONS
from voronec.audit.nodes import (
    Call,
    Chain,
    Cross,
    Differential,
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
    Sum,
    Variation,
)
from voronec.audit.scripts import scripts
from voronec.audit.tokens import ACCENTS, ELEMENTARY, GREEK, Token, complain, tokenize
from voronec.audit.vocabulary import Vocabulary

__all__ = ["read", "read_name", "read_tokens"]

_CLOSERS = {")": "(", "]": "[", "}": "{"}
_STOP = {")", "]", "}", ",", "+", "-", "\\quad", "\\qquad"} | RELATIONS


def read(source: str, vocabulary: Vocabulary | None = None) -> Chain:
    """The tree of one formula; ``DefinitionError`` names the place of what is not understood."""
    return read_tokens(tokenize(source), source, vocabulary or Vocabulary())


def read_tokens(tokens: Sequence[Token], source: str, vocabulary: Vocabulary) -> Chain:
    """The tree of the formula that the given words of ``source`` make."""
    return Reader(list(tokens), source, vocabulary).formula()


def read_name(source: str) -> Node:
    """The tree of a single name, as dictionaries spell their keys; any superscript is a label."""
    reader = Reader(tokenize(source), source, Vocabulary(), all_labels=True)
    node = reader.factor()
    reader.expect_end()
    return node


class Reader:
    """Recursive descent over the words; one method for each construct."""

    def __init__(
        self, tokens: list[Token], source: str, vocabulary: Vocabulary, all_labels: bool = False
    ) -> None:
        self.tokens, self.source, self.vocabulary = tokens, source, vocabulary
        self.all_labels = all_labels
        self.position = 0

    # -- words ----------------------------------------------------------------------------

    def peek(self, ahead: int = 0) -> str:
        index = self.position + ahead
        return self.tokens[index].text if index < len(self.tokens) else ""

    def kind(self) -> str:
        return self.tokens[self.position].kind if self.position < len(self.tokens) else ""

    def take(self, wanted: str | None = None) -> Token:
        if self.position >= len(self.tokens):
            self.fail(
                f"the formula ends where '{wanted}' is missing" if wanted else "it ends early"
            )
        token = self.tokens[self.position]
        if wanted is not None and token.text != wanted:
            self.fail(f"'{wanted}' is missing")
        self.position += 1
        return token

    def fail(self, what: str) -> NoReturn:
        last = self.position >= len(self.tokens)
        token = self.tokens[-1 if last else self.position] if self.tokens else Token("", "", 0, 0)
        raise complain(self.source, token.end if last else token.start, what)

    def expect_end(self) -> None:
        if self.position < len(self.tokens):
            self.fail(f"'{self.peek()}' is not understood here")

    def begin(self) -> int:
        return self.tokens[min(self.position, len(self.tokens) - 1)].start if self.tokens else 0

    def since(self, start: int) -> tuple[int, int]:
        return start, self.tokens[self.position - 1].end if self.position else start

    # -- formulas and sums ----------------------------------------------------------------

    def formula(self) -> Chain:
        start, parts, relations = self.begin(), [self.sum()], []
        while self.peek() in RELATIONS:
            relations.append(self.take().text)
            parts.append(self.sum())
        self.expect_end()
        return Chain(tuple(parts), tuple(relations), self.since(start))

    def sum(self) -> Node:
        start, terms = self.begin(), []
        sign = self._sign(first=True)
        while sign is not None:
            terms.append((sign, self.term()))
            sign = self._sign(first=False)
        if len(terms) == 1 and terms[0][0] == 1:
            return terms[0][1]
        return Sum(tuple(terms), self.since(start))

    def _sign(self, first: bool) -> int | None:
        if self.peek() in ("+", "-"):
            return 1 if self.take().text == "+" else -1
        return 1 if first else None

    def term(self) -> Node:
        start = self.begin()
        factors: list[Node] = []
        while True:
            text = self.peek()
            if text == "" or text in _STOP:
                break
            if text == "\\cdot":
                self.take()
            elif text == "\\times":
                self.take()
                left = _product(factors, self.since(start))
                factors = [Cross(left, self.factor(), self.since(start))]
            elif text == "/":
                self.take()
                left = _product(factors, self.since(start))
                factors = [Quotient(left, self.factor(), self.since(start))]
            else:
                factors.append(self.factor())
        if not factors:
            self.fail("a term is missing")
        return _product(factors, self.since(start))

    # -- factors --------------------------------------------------------------------------

    def factor(self) -> Node:
        start = self.begin()
        node = scripts(self, self.atom(), start)
        if self.peek() == "(" and self._applies(node):
            self.take()
            node = Call(node, self._list(")"), self.since(start))
        return scripts(self, node, start) if self.peek() in ("^", "_", "'") else node

    def _applies(self, node: Node) -> bool:
        if isinstance(node, Partial):
            return self._holds_list()
        if not isinstance(node, Name):
            return False
        return node.head in self.vocabulary.functions or self._holds_list()

    def _holds_list(self) -> bool:
        """Whether the parenthesis ahead holds a comma of its own."""
        depth = 0
        for token in self.tokens[self.position :]:
            depth += (token.text in _CLOSERS.values()) - (token.text in _CLOSERS)
            if depth == 0:
                return False
            if depth == 1 and token.text == ",":
                return True
        return False

    def _list(self, closer: str) -> tuple[Node, ...]:
        items = [self._item()]
        while self.peek() == ",":
            self.take()
            items.append(self._item())
        self.take(closer)
        return tuple(items)

    def _item(self) -> Node:
        if self.peek() in ("\\dots", "\\ldots", "\\cdots"):
            token = self.take()
            return Dots((token.start, token.end))
        return self.sum()

    def atom(self) -> Node:
        token = self.take()
        text, at = token.text, (token.start, token.end)
        if token.kind == "number":
            return Number(text, at)
        if text == "d" and self._starts_name():
            return Differential(self.factor(), "d", self.since(token.start))
        if token.kind == "letter" or text in GREEK - {"\\delta"}:
            return Name(text, at=at)
        if token.kind == "text":
            return Name(text, at=at)
        if text in ("(", "[", "{"):
            return self._group(token)
        special: dict[str, Callable[[Token], Node]] = {
            "\\frac": partial(fraction, self),
            "\\dfrac": partial(fraction, self),
            "\\tfrac": partial(fraction, self),
            "\\sqrt": partial(root, self),
            "\\sum": partial(bound, self),
            "\\int": partial(integral, self),
            "\\delta": self._variation,
            "\\partial": self._lone_partial,
        }
        if text in special:
            return special[text](token)
        if text in ("\\dot", "\\ddot"):
            return self._dotted(token)
        if text in ELEMENTARY:
            return self._elementary(token)
        if text in ACCENTS:
            return self._accented(token)
        raise complain(self.source, token.start, f"'{text}' is not understood")

    def _starts_name(self) -> bool:
        following = self.peek()
        return self.kind() == "letter" or following in GREEK | ACCENTS | {"\\dot"}

    def _group(self, token: Token) -> Node:
        closer = {"(": ")", "[": "]", "{": "}"}[token.text]
        items = self._list(closer)
        if len(items) == 1:
            return items[0]
        if token.text == "{":
            self.fail("a comma between braces is not understood")
        return Listing(items, token.text, self.since(token.start))

    def argument(self) -> Node:
        """The argument of a command: a group in braces, or the next single word."""
        if self.peek() == "{":
            self.take()
            node = self.sum()
            self.take("}")
            return node
        token = self.tokens[self.position] if self.position < len(self.tokens) else None
        if token is not None and token.kind == "number" and len(token.text) > 1:
            self._split_number(token)
        return self.atom()

    def _split_number(self, token: Token) -> None:
        """``\\frac12`` takes one digit at a time."""
        head = Token("number", token.text[0], token.start, token.start + 1)
        tail = Token("number", token.text[1:], token.start + 1, token.end)
        self.tokens[self.position : self.position + 1] = [head, tail]

    def _elementary(self, token: Token) -> Node:
        power = None
        if self.peek() == "^":
            self.take()
            power = self.argument()
        start = self.begin()
        if self.kind() == "number":
            argument = Product((self.factor(), self.factor()), self.since(start))
        else:
            argument = scripts(self, self.atom(), start)
        node: Node = Elementary(token.text[1:], argument, self.since(token.start))
        return node if power is None else Power(node, power, self.since(token.start))

    def _accented(self, token: Token) -> Node:
        inner = self.argument()
        if isinstance(inner, Dot):  # \bar{\dot U}: a name of its own
            inner = Name(f"\\dot{{{inner.body.head}}}", inner.body.sub, inner.body.sup)
        if not isinstance(inner, Name):
            self.fail(f"'{token.text}' must stand over a name")
        return replace(inner, head=f"{token.text}{{{inner.head}}}", at=self.since(token.start))

    def _dotted(self, token: Token) -> Node:
        order = len(token.text) - len("\\ot")
        body = self.argument()
        return Dot(body, order, self.since(token.start))

    def _variation(self, token: Token) -> Node:
        return Variation(self.factor(), self.since(token.start))

    def _lone_partial(self, token: Token) -> Node:
        return Differential(self.factor(), "\\partial", self.since(token.start))


def _product(factors: list[Node], at: tuple[int, int]) -> Node:
    return factors[0] if len(factors) == 1 else Product(tuple(factors), at)

r"""Reads LaTeX mathematics into a tree, in the dialect of papers on mechanics.

Products are written side by side; ``\sin u\cos v`` is (sin u)(cos v); ``\frac12`` and ``\dot u_1``
need no braces; a name followed by a parenthesis is applied where the vocabulary says that it is a
function, or where the parenthesis holds a list.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NoReturn

from voronec.audit.latex.atoms import atom
from voronec.audit.latex.displays import RELATIONS
from voronec.audit.latex.nodes import (
    POINT,
    Call,
    Chain,
    Cross,
    Differential,
    Dots,
    Listing,
    Name,
    Node,
    Partial,
    Product,
    Quotient,
    Sum,
    Wedge,
)
from voronec.audit.latex.scripts import scripts
from voronec.audit.latex.tokens import ELLIPSES, Misprint, Token, complain, tokenize
from voronec.audit.latex.vocabulary import APPLIED, Vocabulary
from voronec.errors import DefinitionError

__all__ = ["read", "read_name", "read_tokens"]

_CLOSERS = {")": "(", "]": "[", "}": "{"}
_SIGNS = {"+": 1, "-": -1, "\\pm": 1, "\\mp": -1}
_STOP = {")", "]", "}", ",", "\\quad", "\\qquad"} | RELATIONS | set(_SIGNS)
_ARROWS = (["\\mapsto"], ["\\longmapsto"])
_SIGN_NAMES = {"\\pm", "\\oplus", "\\ker", "\\in"}
_BETWEEN: dict[str, Callable[[Node, Node, tuple[int, int]], Node]] = {
    "\\times": Cross,
    "/": Quotient,
    "\\wedge": Wedge,
}


def read(source: str, vocabulary: Vocabulary | None = None) -> Chain:
    """The tree of one formula; ``DefinitionError`` names the place of what is not understood."""
    return read_tokens(tokenize(source), source, vocabulary or Vocabulary())


def read_tokens(tokens: Sequence[Token], source: str, vocabulary: Vocabulary) -> Chain:
    """The tree of the formula that the given words of ``source`` make."""
    return Reader(list(tokens), source, vocabulary).formula()


def read_name(source: str, vocabulary: Vocabulary | None = None) -> Node:
    r"""The tree of a single name, as dictionaries spell their keys; any superscript is a label.

    ``\zeta(\cdot)`` is the function ``\zeta`` beside a variable of the same name.
    """
    applied = source.endswith(APPLIED)
    bare = source.removesuffix(APPLIED)
    if bare in _SIGN_NAMES:
        return Name(bare)
    reader = Reader(tokenize(bare), bare, vocabulary or Vocabulary(), all_labels=True)
    node = reader.factor()
    reader.expect_end()
    return replace(node, head=node.head + APPLIED) if applied else node


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
            what = f"the formula ends where '{wanted}' is missing" if wanted else "it ends early"
            self.fail(what, Misprint)
        token = self.tokens[self.position]
        if wanted is not None and token.text != wanted:
            self.fail(f"'{wanted}' is missing")
        self.position += 1
        return token

    def fail(self, what: str, kind: type[DefinitionError] = DefinitionError) -> NoReturn:
        last = self.position >= len(self.tokens)
        token = self.tokens[-1 if last else self.position] if self.tokens else Token("", "", 0, 0)
        raise complain(self.source, token.end if last else token.start, what, kind)

    def expect_end(self) -> None:
        if self.position < len(self.tokens):
            self.fail(f"'{self.peek()}' is not understood here")

    def begin(self) -> int:
        return self.tokens[min(self.position, len(self.tokens) - 1)].start if self.tokens else 0

    def since(self, start: int) -> tuple[int, int]:
        return start, self.tokens[self.position - 1].end if self.position else start

    # -- formulas and sums ----------------------------------------------------------------

    def formula(self) -> Chain:
        r"""Parts with relations; ``x\in D`` is x = ``\in``(x, D), the part of x that lies in D.

        ``f\colon (a, b)\mapsto (c, d)`` is an equality of points, f(a, b) = (c, d).
        """
        start, parts, relations = self.begin(), [self.sum()], []
        while self.peek() in RELATIONS:
            token = self.take()
            part = self.sum()
            if token.text == "\\in":
                name = Name(token.text, at=(token.start, token.end))
                part = Call(name, (parts[-1], part), self.since(start))
            parts.append(part)
            relations.append("=" if token.text == "\\in" else token.text)
        self.expect_end()
        points = [replace(p, bracket=POINT) for p in parts if isinstance(p, Listing)]
        if relations[:1] == ["\\colon"] and relations[1:] in _ARROWS and len(points) == 2:
            parts, relations = [Call(parts[0], (points[0],), self.since(start)), points[1]], ["="]
        return Chain(tuple(parts), tuple(relations), self.since(start))

    def sum(self) -> Node:
        r"""Terms with signs; ``a \pm b`` is a plus a name ``\pm`` times b."""
        start = self.begin()
        terms: list[tuple[int, Node]] = []
        while self.peek() in _SIGNS or not terms:
            mark = self.take() if self.peek() in _SIGNS else None
            term = self.term()
            if mark is not None and mark.text in ("\\pm", "\\mp"):
                term = Product((Name("\\pm", at=(mark.start, mark.end)), term), term.at)
            terms.append((1 if mark is None else _SIGNS[mark.text], term))
        if len(terms) == 1 and terms[0][0] == 1:
            return terms[0][1]
        return Sum(tuple(terms), self.since(start))

    def term(self) -> Node:
        start = self.begin()
        factors: list[Node] = []
        while not self.ends_term():
            text = self.peek()
            if text == "\\cdot":
                self.take()
            elif text in _BETWEEN or text == "\\oplus":
                factors = self._joined(text, factors, start)
            else:
                factors.append(self.factor())
        if not factors:
            self.fail("a term is missing", Misprint)
        return _product(factors, self.since(start))

    def ends_term(self) -> bool:
        """Whether no further factor follows."""
        return self.peek() == "" or self.peek() in _STOP

    def _joined(self, sign: str, factors: list[Node], start: int) -> list[Node]:
        r"""A sign between all factors before it and the one behind it.

        ``\partial f/\partial x`` is a derivative, and only the factor before it belongs to it.
        """
        if not factors:
            self.fail(f"a factor before '{sign}' is missing", Misprint)
        left = _product(factors, self.since(start))
        token = self.take()
        right = self.factor()
        if sign == "/" and _is_partial(factors[-1]) and _is_partial(right):
            at = self.since(factors[-1].at[0])
            return [*factors[:-1], Partial(factors[-1].body, (right.body,), at)]
        if sign in _BETWEEN:
            return [_BETWEEN[sign](left, right, self.since(start))]
        name = Name(sign, at=(token.start, token.end))
        return [Call(name, (left, right), self.since(start))]

    # -- factors --------------------------------------------------------------------------

    def factor(self) -> Node:
        start = self.begin()
        node = scripts(self, self.atom(), start)
        if self.peek() == "(" and self._applies(node):
            node = Call(node, self.group(self.take()), self.since(start))
        return scripts(self, node, start) if self.peek() in ("^", "_", "'") else node

    def _applies(self, node: Node) -> bool:
        if isinstance(node, Partial):
            return self._holds_list()
        if not isinstance(node, Name):
            return False
        return self.vocabulary.applies(node.head) or self._holds_list()

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

    def group(self, opening: Token) -> tuple[Node, ...]:
        """What stands between the bracket ``opening``, already taken, and its counterpart."""
        closer = next(c for c, o in _CLOSERS.items() if o == opening.text)
        items = [self._item()]
        while self.peek() == ",":
            self.take()
            items.append(self._item())
        if self.peek() != closer and (self.peek() in (*_CLOSERS, "") or not self._balanced()):
            what = f"the '{opening.text}' here is not closed: '{closer}' is missing"
            raise complain(self.source, opening.start, what, Misprint)
        self.take(closer)
        return tuple(items)

    def _balanced(self) -> bool:
        """Whether as many brackets close in the formula as open."""
        texts = [token.text for token in self.tokens]
        return sum(t in _CLOSERS for t in texts) == sum(t in _CLOSERS.values() for t in texts)

    def _item(self) -> Node:
        if self.peek() in ELLIPSES:
            token = self.take()
            return Dots((token.start, token.end))
        return self.sum()

    def atom(self) -> Node:
        return atom(self, self.take())

    def argument(self) -> Node:
        """The argument of a command: a group in braces, or the next single word."""
        if self.peek() == "{":
            opening = self.take()
            items = self.group(opening)
            if len(items) > 1:
                raise complain(
                    self.source, opening.start, "a comma between braces is not understood"
                )
            return items[0]
        token = self.tokens[self.position] if self.position < len(self.tokens) else None
        if token is not None and token.kind == "number" and len(token.text) > 1:
            self._split_number(token)
        return self.atom()

    def _split_number(self, token: Token) -> None:
        """``\\frac12`` takes one digit at a time."""
        head = Token("number", token.text[0], token.start, token.start + 1)
        tail = Token("number", token.text[1:], token.start + 1, token.end)
        self.tokens[self.position : self.position + 1] = [head, tail]


def _is_partial(node: Node) -> bool:
    return isinstance(node, Differential) and node.sign == "\\partial"


def _product(factors: list[Node], at: tuple[int, int]) -> Node:
    return factors[0] if len(factors) == 1 else Product(tuple(factors), at)

r"""Reads LaTeX mathematics into a tree, in the dialect of papers on mechanics.

Products are written side by side; ``\sin u\cos v`` is (sin u)(cos v); ``\frac12`` and ``\dot u_1``
need no braces; a name followed by a parenthesis is applied where the vocabulary says that it is a
function, or where the parenthesis holds a list.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NoReturn

from voronec.audit.displays import RELATIONS
from voronec.audit.nodes import (
    Bound,
    Call,
    Chain,
    Cross,
    Derivative,
    Differential,
    Dot,
    Dots,
    Elementary,
    Integral,
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
from voronec.audit.tokens import Token, complain, tokenize

__all__ = ["Vocabulary", "read", "read_name", "read_tokens"]

ELEMENTARY = set("\\sin \\cos \\tan \\cot \\ln \\log \\exp \\sinh \\cosh \\tanh \\arcsin \\arccos".split())
ACCENTS = set("\\tilde \\bar \\hat \\vec \\mathbf \\mathrm \\mathfrak \\mathcal \\mathbb \\boldsymbol".split())
GREEK = set(
    "\\alpha \\beta \\gamma \\delta \\epsilon \\varepsilon \\zeta \\eta \\theta \\vartheta \\iota"
    " \\kappa \\lambda \\mu \\nu \\xi \\pi \\rho \\sigma \\tau \\phi \\varphi \\chi \\psi \\omega"
    " \\Gamma \\Delta \\Theta \\Lambda \\Xi \\Pi \\Sigma \\Phi \\Psi \\Omega \\wp \\ell".split()
)
_CLOSERS = {")": "(", "]": "[", "}": "{"}
_STOP = {")", "]", "}", ",", "+", "-", "\\quad", "\\qquad"} | RELATIONS


@dataclass(frozen=True)
class Vocabulary:
    """What the reader must know beforehand about a paper's names.

    ``functions``: heads that a parenthesis applies.  ``labelled``: heads whose superscript is a
    label, not an exponent.  ``wide_sums``: a sum sign reaches to the end of its group, not only
    over the next term.
    """

    functions: frozenset[str] = frozenset()
    labelled: frozenset[str] = frozenset()
    wide_sums: bool = False


def read(source: str, vocabulary: Vocabulary | None = None) -> Chain:
    """The tree of one formula; ``DefinitionError`` names the place of what is not understood."""
    return read_tokens(tokenize(source), source, vocabulary or Vocabulary())


def read_tokens(tokens: Sequence[Token], source: str, vocabulary: Vocabulary) -> Chain:
    """The tree of the formula that the given words of ``source`` make."""
    return _Reader(list(tokens), source, vocabulary).formula()


def read_name(source: str) -> Node:
    """The tree of a single name, as dictionaries spell their keys; any superscript is a label."""
    reader = _Reader(tokenize(source), source, Vocabulary(), all_labels=True)
    node = reader.factor()
    reader.expect_end()
    return node


class _Reader:
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
            self.fail(f"the formula ends where '{wanted}' is missing" if wanted else "it ends early")
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
        start, factors = self.begin(), []
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
        node = self._scripts(self.atom(), start)
        if self.peek() == "(" and self._applies(node):
            self.take()
            node = Call(node, self._list(")"), self.since(start))
        return self._scripts(node, start) if self.peek() in ("^", "_", "'") else node

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
        special = {
            "\\frac": self._fraction,
            "\\dfrac": self._fraction,
            "\\tfrac": self._fraction,
            "\\sqrt": self._root,
            "\\sum": self._bound,
            "\\int": self._integral,
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
        self.position -= 1
        self.fail(f"'{text}' is not understood")

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

    def _braced(self) -> Node:
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
            power = self._braced()
        start = self.begin()
        if self.kind() == "number":
            argument = Product((self.factor(), self.factor()), self.since(start))
        else:
            argument = self._scripts(self.atom(), start)
        node: Node = Elementary(token.text[1:], argument, self.since(token.start))
        return node if power is None else Power(node, power, self.since(token.start))

    def _accented(self, token: Token) -> Node:
        inner = self._braced()
        if isinstance(inner, Dot):  # \bar{\dot U}: a name of its own
            inner = Name(f"\\dot{{{inner.body.head}}}", inner.body.sub, inner.body.sup)
        if not isinstance(inner, Name):
            self.fail(f"'{token.text}' must stand over a name")
        return replace(inner, head=f"{token.text}{{{inner.head}}}", at=self.since(token.start))

    def _dotted(self, token: Token) -> Node:
        order = len(token.text) - len("\\ot")
        body = self._braced()
        return Dot(body, order, self.since(token.start))

    def _variation(self, token: Token) -> Node:
        return Variation(self.factor(), self.since(token.start))

    def _lone_partial(self, token: Token) -> Node:
        return Differential(self.factor(), "\\partial", self.since(token.start))

    def _root(self, token: Token) -> Node:
        index = None
        if self.peek() == "[":
            self.take()
            index = self.sum()
            self.take("]")
        return Root(self._braced(), index, self.since(token.start))

    def _integral(self, token: Token) -> Node:
        lower, upper = self._limits()
        return Integral(self.term(), lower, upper, self.since(token.start))

    def _bound(self, token: Token) -> Node:
        self.take("_")
        self.take("{")
        index = self.factor()
        self.take("=")
        lower = self.sum()
        self.take("}")
        self.take("^")
        upper = self._braced()
        if not isinstance(index, Name):
            self.fail("a sum runs over an index")
        body = self.sum() if self.vocabulary.wide_sums else self.term()
        return Bound(index, lower, upper, body, self.since(token.start))

    def _limits(self) -> tuple[Node | None, Node | None]:
        lower = upper = None
        while self.peek() in ("_", "^"):
            if self.take().text == "_":
                lower = self._script()
            else:
                upper = self._script()
        return lower, upper

    # -- fractions ------------------------------------------------------------------------

    def _fraction(self, token: Token) -> Node:
        derivative = self._partial_fraction(token) or self._total_fraction(token)
        if derivative is not None:
            return derivative
        top = self._braced()
        return Quotient(top, self._braced(), self.since(token.start))

    def _partial_fraction(self, token: Token) -> Node | None:
        r"""``\frac{\partial^2 f}{\partial x^2}``; the numerator may hold nothing but the sign."""
        if (self.peek(), self.peek(1)) != ("{", "\\partial"):
            return None
        self.position += 2
        if self.peek() == "^":
            self.take()
            self._braced()
        body = None if self.peek() == "}" else self.term()
        self.take("}")
        self.take("{")
        variables: list[Node] = []
        while self.peek() == "\\partial":
            self.take()
            variables.extend(_repeated(self.factor()))
        self.take("}")
        if not variables:
            self.fail("a partial derivative needs a variable")
        return Partial(body, tuple(variables), self.since(token.start))

    def _total_fraction(self, token: Token) -> Node | None:
        r"""``\frac{d}{dt} f`` and ``\frac{dx}{dt}``."""
        if (self.peek(), self.peek(1)) != ("{", "d") or not self._denominator_is_differential():
            return None
        self.position += 2
        body = None if self.peek() == "}" else self.term()
        self.take("}")
        self.take("{")
        self.take("d")
        variable = self.factor()
        self.take("}")
        if body is None:
            body = self.term()
        return Derivative(body, variable, 1, self.since(token.start))

    def _denominator_is_differential(self) -> bool:
        depth = 0
        for i in range(self.position, len(self.tokens)):
            depth += (self.tokens[i].text == "{") - (self.tokens[i].text == "}")
            if depth == 0:
                words = [t.text for t in self.tokens[i + 1 : i + 3]]
                return words == ["{", "d"]
        return False

    # -- scripts --------------------------------------------------------------------------

    def _scripts(self, node: Node, start: int) -> Node:
        primes, sub, sup, exponent = 0, (), (), None
        while self.peek() in ("_", "^", "'", '"'):
            mark = self.take().text
            if mark in ("'", '"'):
                primes += 1 if mark == "'" else 2
            elif mark == "_":
                sub = self._indices()
            elif self._labels(node):
                sup = self._indices()
            else:
                exponent = self._script()
        if primes or sub or sup:
            node = self._attach(node, primes, sub, sup, start)
        return node if exponent is None else Power(node, exponent, self.since(start))

    def _attach(
        self, node: Node, primes: int, sub: tuple[Node, ...], sup: tuple[Node, ...], start: int
    ) -> Node:
        """Indices after an accent or a brace belong to the name inside."""
        if isinstance(node, (Dot, Variation)):
            inner = self._attach(node.body, primes, sub, sup, start)
            return replace(node, body=inner, at=self.since(start))
        if not isinstance(node, Name):
            self.fail("an index must belong to a name")
        head = node.head + "'" * primes
        return Name(head, node.sub + sub, node.sup + sup, self.since(start))

    def _labels(self, node: Node) -> bool:
        """Whether the superscript ahead is a label: ``(\\nu)``, or what the vocabulary names."""
        while isinstance(node, (Dot, Variation)):
            node = node.body
        if not isinstance(node, Name):
            return False
        if self.all_labels or node.head in self.vocabulary.labelled:
            return True
        return (self.peek(), self.peek(1)) == ("{", "(") and self._lone_parenthesis()

    def _lone_parenthesis(self) -> bool:
        texts = [self.peek(i) for i in range(5)]
        return texts[3:5] == [")", "}"]

    def _indices(self) -> tuple[Node, ...]:
        """``i``, ``{\\nu i}``, ``{n+\\nu}``, ``{(\\nu)}``: indices side by side."""
        if self.peek() != "{":
            return (self._script(),)
        self.take()
        parenthesis = self.peek() == "("
        if parenthesis:
            self.take()
        found: list[Node] = []
        while self.peek() not in ("}", ")"):
            if self.peek() == ",":
                self.take()
                continue
            node = self.sum()
            found.extend(node.factors if isinstance(node, Product) else (node,))
        if parenthesis:
            self.take(")")
        self.take("}")
        return tuple(found)

    def _script(self) -> Node:
        return self._braced()


def _product(factors: list[Node], at: tuple[int, int]) -> Node:
    return factors[0] if len(factors) == 1 else Product(tuple(factors), at)


def _repeated(variable: Node) -> list[Node]:
    """``x^2`` in the denominator of a partial derivative is x twice."""
    if isinstance(variable, Power) and isinstance(variable.exponent, Number):
        return [variable.base] * int(variable.exponent.text)
    return [variable]

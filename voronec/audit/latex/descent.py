r"""Formulas as sums of terms, terms as products of factors with what stands below and above them.

A name followed by a parenthesis is applied where the vocabulary says that it is a function, or
where the parenthesis holds a list.  What a single word begins is read by ``reader``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import NoReturn

from voronec.audit.latex.displays import RELATIONS
from voronec.audit.latex.doubts import (
    fraction_of_numbers,
    function_without_backslash,
    instant,
    open_argument,
    single_name,
)
from voronec.audit.latex.nodes import (
    POINT,
    TRANSPOSE,
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
    Wedge,
)
from voronec.audit.latex.tables import ENDS
from voronec.audit.latex.tokens import (
    ELEMENTARY,
    ELLIPSES,
    FUNCTION_NAMES,
    Ambiguous,
    Misprint,
    Token,
    Unfamiliar,
    complain,
)
from voronec.audit.latex.vocabulary import LatexVocabulary
from voronec.errors import DefinitionError

CLOSERS = {")": "(", "]": "[", "}": "{", "\\}": "\\{"}
_SIGNS = {"+": 1, "-": -1, "\\pm": 1, "\\mp": -1}
STOP = {*CLOSERS, ",", "\\quad", "\\qquad"} | RELATIONS | set(_SIGNS) | ENDS
_ARROWS = (["\\mapsto"], ["\\longmapsto"])
BETWEEN: dict[str, Callable[[Node, Node, tuple[int, int]], Node]] = {
    "\\times": Cross,
    "/": Quotient,
    "\\wedge": Wedge,
}
BREAKS = {*CLOSERS.values(), *_SIGNS, *BETWEEN, ",", "\\cdot", "^", "_"} | RELATIONS | ELEMENTARY
"""What a bar opens behind."""
DIRECTIONS = re.compile(r"(\\left|\\lvert|\\[bB]igg?l)|\\right|\\rvert|\\[bB]igg?r")
"""Bars of which the print says whether they open."""


class Reader:
    """Recursive descent over the words.

    ``construct`` reads what a word begins, already taken: a name, a bracket, a command with its
    arguments.
    """

    def __init__(
        self,
        tokens: list[Token],
        source: str,
        vocabulary: LatexVocabulary,
        construct: Callable[[Reader, Token], Node],
        all_labels: bool = False,
    ) -> None:
        self.tokens, self.source, self.vocabulary = tokens, source, vocabulary
        self.construct = construct
        self.in_index = self.in_bars = False
        self.opened = 0  # where the words inside the last bar begin
        self.all_labels = all_labels
        self.position = 0

    # -- words ----------------------------------------------------------------------------

    def peek(self, ahead: int = 0) -> str:
        """The text of the word so many words ahead; nothing behind the end."""
        index = self.position + ahead
        return self.tokens[index].text if index < len(self.tokens) else ""

    @property
    def place(self) -> tuple[list[Token], int]:
        """The words, and how far they are read."""
        return self.tokens, self.position

    def kind(self, ahead: int = 0) -> str:
        """The kind of the word so many words ahead; nothing behind the end."""
        index = self.position + ahead
        return self.tokens[index].kind if index < len(self.tokens) else ""

    def take(self, wanted: str | None = None) -> Token:
        """The next word, which has to be ``wanted``; the position moves behind it."""
        if self.position >= len(self.tokens):
            what = f"the formula ends where '{wanted}' is missing" if wanted else "it ends early"
            self.fail(what, Misprint)
        token = self.tokens[self.position]
        if wanted is not None and token.text != wanted:
            self.fail(f"'{wanted}' is missing")
        self.position += 1
        return token

    def fail(self, what: str, kind: type[DefinitionError] = DefinitionError) -> NoReturn:
        """Raise an error of a kind, with the place that is reached."""
        last = self.position >= len(self.tokens)
        token = self.tokens[-1 if last else self.position] if self.tokens else Token("", "", 0, 0)
        raise complain(self.source, token.end if last else token.start, what, kind)

    def expect_end(self) -> None:
        """``DefinitionError`` where words are left."""
        if self.position < len(self.tokens):
            self.fail(f"'{self.peek()}' is not understood here")

    def begin(self) -> int:
        """The character at which the next word starts."""
        return self.tokens[min(self.position, len(self.tokens) - 1)].start if self.tokens else 0

    def since(self, start: int) -> tuple[int, int]:
        """The range of characters from ``start`` to the end of the last word."""
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
        parts = [_as_point(part) for part in parts]
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
        """Factors side by side, or with the signs of products between them."""
        start = self.begin()
        factors: list[Node] = []
        while not self.ends_term():
            text = self.peek()
            if text == "\\cdot":
                self.take()
                if self.ends_term():
                    self.fail("a factor is missing; a sign behind a product wants parentheses")
            elif text in BETWEEN or text == "\\oplus":
                factors = self._join(text, factors, start)
            else:
                self._refuse_number_in_doubt(factors)
                factors.append(self.factor())
        if not factors:
            before = self.tokens[self.position - 1].text if self.position else "\\{"
            unusual = before in ("\\{", self.peek()) or self.peek() in ("}", "]", "\\colon")
            # \left\{, a - - b across two lines, v^{-}, ]a, b], a =: b
            self.fail("a term is missing", Unfamiliar if unusual else Misprint)
        return _product(factors, self.since(start))

    def _refuse_number_in_doubt(self, factors: list[Node]) -> None:
        r"""``1\frac12`` may be one and a half, ``10\,000`` one number, ``x2`` a square; indices
        stand so."""
        if self.in_index or not factors:
            return
        before, word = self.tokens[self.position - 1 : self.position + 1]
        if word.kind == "number" != before.kind and factors[-1].at[1] == word.start:
            what = "this number may be an index, a power or a factor; write x_2, x^2, 2 x"
            self.fail(what, Ambiguous)
        if before.kind != "number" or not isinstance(factors[-1], Number):
            return
        if fraction_of_numbers(*self.place):
            what = "this may be a mixed number or a product; write one fraction, or \\cdot between"
            self.fail(what, Ambiguous)
        if self.kind() == "number":
            what = "two numbers stand side by side; write one number, or \\cdot between"
            self.fail(what, Ambiguous)

    def ends_term(self) -> bool:
        """Whether no further factor follows."""
        return self.peek() == "" or self.peek() in STOP or self._closes_bar()

    def _closes_bar(self) -> bool:
        """Whether the word ahead closes the bar that is open."""
        if not self.in_bars or self.peek() != "|" or self.position == self.opened:
            return False
        printed = DIRECTIONS.match(self.source, self.tokens[self.position].start)
        opens = printed is not None and printed[1] is not None
        return not opens and self.tokens[self.position - 1].text not in BREAKS

    def _join(self, sign: str, factors: list[Node], start: int) -> list[Node]:
        r"""A sign between all factors before it and the one behind it.

        ``\partial f/\partial x`` is a derivative, and only the factor before it belongs to it.
        """
        if not factors:
            self.fail(f"a factor before '{sign}' is missing", Misprint)
        left = _product(factors, self.since(start))
        token = self.take()
        opening = self.peek()
        right = self.factor()
        if sign == "/":
            self._refuse_open_divisor(factors, right, opening)
        if sign == "/" and _is_partial(factors[-1]) and _is_partial(right):
            at = self.since(factors[-1].at[0])
            return [*factors[:-1], Partial(factors[-1].body, (right.body,), at)]
        if sign in BETWEEN:
            return [BETWEEN[sign](left, right, self.since(start))]
        name = Name(sign, at=(token.start, token.end))
        return [Call(name, (left, right), self.since(start))]

    def _refuse_open_divisor(self, factors: list[Node], right: Node, opening: str) -> None:
        r"""``a/2b`` may be (a/2) b or a/(2 b); ``a/(2)b``, ``1/2 b`` and ``dx/dt b`` are none."""
        if self.ends_term() or self.peek() in ("\\cdot", "\\oplus", *BETWEEN):
            return
        whole = len(factors) == 1 and isinstance(factors[0], Number) and isinstance(right, Number)
        whole = whole and self.tokens[self.position].start > self.tokens[self.position - 1].end
        rate = isinstance(factors[-1], Differential) and isinstance(right, Differential)
        if not (whole or rate or opening in CLOSERS.values()):
            what = "this quotient can be read in two ways; write (a/b) c or a/(b c)"
            self.fail(what, Ambiguous)

    # -- factors --------------------------------------------------------------------------

    def factor(self) -> Node:
        """What a word begins, with its scripts and the arguments to which it is applied."""
        start = self.begin()
        node = _scripts(self, self.atom(), start)
        if self.peek() == "(" and self._applies(node):
            node = Call(node, self.group(self.take()), self.since(start))
        elif self.peek() == "(" and _transposes(node) and self._applies(node.base):
            call = Call(node.base, self.group(self.take()), self.since(start))
            node = replace(node, base=call)  # A^T(q)
        elif isinstance(node, Name) and node.head in ("\\det", "\\tr") and self.kind() == "command":
            node = Call(node, (self.atom(),), self.since(start))
        elif isinstance(node, Name) and node.head in FUNCTION_NAMES and not self.ends_term():
            node = self._named_function(node, start)
        elif (applied := self.at_time(node)) is not node:
            node = applied
        elif self.peek() == "(" and self.takes_instant(node):
            what = "this may be a value at an instant or a product; only the product is read,"
            self.fail(f"{what} written with \\cdot", Ambiguous)
        elif self.peek() == "(" and self._takes_name(node):
            what = f"this may be a function of {self.peek(1)}, or a product; write the name alone,"
            self.fail(f"{what} or \\cdot between", Unfamiliar)
        return _scripts(self, node, start) if self.peek() in ("^", "_", "'") else node

    def _named_function(self, name: Name, start: int) -> Node:
        r"""``\operatorname{sgn} v``."""
        bare, argument = self.peek() != "|", function_argument(self, self.begin())
        doubt = open_argument(name.head, *self.place, self.vocabulary) if bare else ""
        if doubt:
            raise complain(self.source, start, doubt, Ambiguous)
        return Call(name, (argument,), self.since(start))

    def at_time(self, node: Node) -> Node:
        r"""``x(t)``, ``\dot x(t)``, ``x^2(t)``: the name before it is applied to the time."""
        base = node.base if isinstance(node, Power) else node
        texts = [self.peek(k) for k in range(3)]
        if texts != ["(", "t", ")"] or not isinstance(base, (Name, Dot)) or base == Name("d"):
            return node
        self.position += 3
        call = Call(base, (Name("t"),), self.since(base.at[0]))
        return replace(node, base=call) if isinstance(node, Power) else call

    def _applies(self, node: Node) -> bool:
        if isinstance(node, Partial):
            return self._holds_list()
        if not isinstance(node, Name):
            return False
        return self.vocabulary.applies(node.head) or self._holds_list()

    def takes_instant(self, node: Node) -> bool:
        r"""Whether the parenthesis ahead may hold an instant: ``x(0)``, ``\sin x(t + 1)``; behind
        a number it does not, and behind a bracket only ``(t)``."""
        inside, base = instant(*self.place), node.base if isinstance(node, Power) else node
        named = isinstance(base, (Name, Dot, Elementary))
        return inside != "" and not isinstance(base, Number) and (named or inside == "t")

    def _takes_name(self, node: Node) -> bool:
        """Whether a name stands before a single name in parentheses, as in ``v(x)``; ``cos(x)``
        without its backslash is another fault."""
        named = isinstance(node, (Name, Dot)) and single_name(*self.place) != ""
        return named and not function_without_backslash(*self.place)

    def _holds_list(self) -> bool:
        """Whether the parenthesis ahead holds a comma of its own."""
        depth = 0
        for token in self.tokens[self.position :]:
            depth += (token.text in CLOSERS.values()) - (token.text in CLOSERS)
            if depth == 0:
                return False
            if depth == 1 and token.text == ",":
                return True
        return False

    def group(self, opening: Token) -> tuple[Node, ...]:
        """What stands between the bracket ``opening``, already taken, and its counterpart."""
        closer = next(c for c, o in CLOSERS.items() if o == opening.text)
        outside, self.in_bars = self.in_bars, False
        items = [self._item()]
        while self.peek() == ",":
            self.take()
            items.append(self._item())
        if self.peek() != closer and (self.peek() in (*CLOSERS, "") or not self._is_balanced()):
            what = f"the '{opening.text}' here is not closed: '{closer}' is missing"
            known = opening.text != "\\{" and not self._is_balanced()  # no [a, b), no open brace
            raise complain(self.source, opening.start, what, Misprint if known else Unfamiliar)
        self.take(closer)
        self.in_bars = outside
        return tuple(items)

    def _is_balanced(self) -> bool:
        """Whether as many brackets close in the formula as open."""
        texts = [token.text for token in self.tokens]
        return sum(t in CLOSERS for t in texts) == sum(t in CLOSERS.values() for t in texts)

    def _item(self) -> Node:
        if self.peek() in ELLIPSES:
            token = self.take()
            return Dots((token.start, token.end))
        return self.sum()

    def atom(self) -> Node:
        """What the next word begins, without scripts."""
        return self.construct(self, self.take())

    def argument(self) -> Node:
        """The argument of a command: a group in braces, or the next single word."""
        token = self.tokens[self.position] if self.position < len(self.tokens) else None
        if token is not None and token.kind == "number" and len(token.text) > 1:
            self._split_number(token)
        return self.atom()

    def put_in_braces(self) -> None:
        r"""``\frac d{dt}`` is ``\frac{d}{dt}``."""
        word = self.tokens[self.position]
        braces = [replace(word, kind="sign", text=text) for text in "{}"]
        self.tokens[self.position : self.position + 1] = [braces[0], word, braces[1]]

    def _split_number(self, token: Token) -> None:
        """``\\frac12`` takes one digit at a time."""
        head = Token("number", token.text[0], token.start, token.start + 1)
        tail = Token("number", token.text[1:], token.start + 1, token.end)
        self.tokens[self.position : self.position + 1] = [head, tail]


def _as_point(part: Node) -> Node:
    """A side of a formula; three or more things in parentheses are a column."""
    several = isinstance(part, Listing) and part.bracket == "(" and len(part.items) > 2
    return replace(part, bracket=POINT) if several else part


def _transposes(node: Node) -> bool:
    return isinstance(node, Power) and node.exponent in TRANSPOSE


def _is_partial(node: Node) -> bool:
    return isinstance(node, Differential) and node.sign == "\\partial"


def _product(factors: list[Node], at: tuple[int, int]) -> Node:
    return factors[0] if len(factors) == 1 else Product(tuple(factors), at)


def function_argument(reader: Reader, start: int) -> Node:
    r"""``\sin 2u`` is the sine of 2u; ``\sin x^2`` may be a square, or the sine of one."""
    if reader.kind() == "number":
        number = reader.factor()
        more = not reader.ends_term() and reader.peek() not in ("\\cdot", *BETWEEN)
        return Product((number, reader.factor()), reader.since(start)) if more else number
    opening = reader.peek()
    if opening in CLOSERS.values() and opening != "{":
        return reader.atom()
    argument = reader.atom() if opening == "|" else _scripts(reader, reader.atom(), start)
    argument = reader.at_time(argument)
    if isinstance(argument, Power) or (opening == "|" and reader.peek() == "^"):
        what = "this is the power of a function or of its argument; write one with parentheses"
        raise complain(reader.source, start, what, Ambiguous)
    return argument


def _scripts(reader: Reader, node: Node, start: int) -> Node:
    """Read what stands below and above ``node``, in any order; ``start`` is where it begins."""
    primes, exponent = 0, None
    sub: tuple[Node, ...] = ()
    sup: tuple[Node, ...] = ()
    while reader.peek() in ("_", "^", "'", '"'):
        mark = reader.take().text
        if mark in ("'", '"'):
            if exponent is not None and reader.vocabulary.primes:
                what = "this may be the rate of a power or a power of the rate; write parentheses"
                reader.fail(what, Ambiguous)
            primes += 1 if mark == "'" else 2
        elif mark == "_":
            sub = _indices(reader)
        elif "'" in (reader.peek(), reader.peek(1)) and _inside(reader).strip("'") == "":
            primes += len(_inside(reader))
            reader.position += len(_inside(reader)) + 2 * (reader.peek() == "{")
        elif "\\cdot" in (reader.peek(), reader.peek(reader.peek() == "{")):
            if _inside(reader) != "\\cdot" or not isinstance(node, (Name, Dot)):
                reader.fail("a star above must stand alone, behind a name")
            reader.position += 1 + 2 * (reader.peek() == "{")
            sup = (Name("*", at=reader.since(start)),)
        elif _is_numeral(reader, node) and exponent is None:
            sup, exponent = _numeral(reader)
        elif _labels(reader, node):
            sup = _indices(reader)
        elif exponent is not None:
            reader.fail("two exponents stand above one another; write a^{b^c}")
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
    if primes and reader.vocabulary.primes:
        body = _attach(reader, node, 0, sub, sup, start) if sub or sup else node
        return Dot(body, primes, reader.since(start))
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
    outside, reader.in_index = reader.in_index, True
    parenthesis = reader.peek() == "("
    if parenthesis:
        reader.take()
    indices: list[Node] = []
    while reader.peek() not in ("}", ")"):
        if reader.peek() == ",":
            reader.take()
            continue
        node = reader.sum()
        indices.extend(node.factors if isinstance(node, Product) else (node,))
    if parenthesis:
        reader.take(")")
    reader.take("}")
    reader.in_index = outside
    return tuple(indices)

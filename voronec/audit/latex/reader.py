r"""Reads LaTeX mathematics into a tree, in the dialect of papers on mechanics.

Products are written side by side; ``\sin u\cos v`` is (sin u)(cos v), and ``\sin u v``, which may
be the sine of uv, is refused, unless the vocabulary or braces say what is meant: ``\sin{uv}``;
``\frac12`` and ``\dot u_1`` need no braces; a name followed by a parenthesis is applied where the
vocabulary says that it is a function, or where the parenthesis holds a list.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NoReturn

from voronec.audit.latex.displays import RELATIONS, group_end
from voronec.audit.latex.doubts import (
    fraction_of_numbers,
    function_without_backslash,
    instant,
    open_argument,
    single_name,
    starts_name,
)
from voronec.audit.latex.nodes import (
    POINT,
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
    Wedge,
)
from voronec.audit.latex.tokens import (
    ACCENTS,
    ELEMENTARY,
    ELLIPSES,
    FUNCTION_NAMES,
    FUNCTIONS,
    GREEK,
    Ambiguous,
    Misprint,
    Token,
    Unfamiliar,
    complain,
    tokenize,
)
from voronec.audit.latex.vocabulary import CALL, LatexVocabulary
from voronec.errors import DefinitionError

__all__ = ["read", "read_name", "read_tokens"]


def read(source: str, vocabulary: LatexVocabulary | None = None) -> Chain:
    """The tree of one formula; ``DefinitionError`` names the place of what is not understood."""
    return read_tokens(tokenize(source), source, vocabulary or LatexVocabulary())


def read_tokens(tokens: Sequence[Token], source: str, vocabulary: LatexVocabulary) -> Chain:
    """The tree of the formula that the given words of ``source`` make."""
    try:
        return Reader(list(tokens), source, vocabulary).formula()
    except RecursionError:
        raise DefinitionError("it is nested too deeply; leave out parentheses") from None


def read_name(source: str, vocabulary: LatexVocabulary | None = None) -> Node:
    r"""The tree of a single name, as dictionaries spell their keys; any superscript is a label.

    ``\zeta(\cdot)`` is the function ``\zeta`` beside a variable of the same name.
    """
    applied = source.endswith(CALL)
    bare = source.removesuffix(CALL)
    if bare in _SIGN_NAMES:
        return Name(bare)
    reader = Reader(tokenize(bare), bare, vocabulary or LatexVocabulary(), all_labels=True)
    node = reader.factor()
    reader.expect_end()
    return replace(node, head=node.head + CALL) if applied else node


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
    least = _shift(lower, sum(steps[:1]))
    for position, index in enumerate(indices):
        most = _shift(([*indices, upper])[position + 1], -steps[position + 1])
        body = Bound(index, least, most, body, at)
    return body


def _shift(node: Node, step: int) -> Node:
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
    if reader.peek() in ("d", "\\partial"):
        reader.put_in_braces()
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
    body = None if reader.peek() == "}" else _numerator(reader)
    reader.take("}")
    reader.take("{")
    variables: list[Node] = []
    while reader.peek() == "\\partial":
        reader.take()
        variables.extend(_repeat(reader.factor()))
    if reader.peek() != "}":
        reader.fail("below the line of a derivative stand variables alone", Unfamiliar)
    reader.take()
    if not variables:
        reader.fail("a partial derivative needs a variable")
    _same_order(reader, order, len(variables))
    if body is None and not reader.ends_term():
        body = reader.term()
    return Partial(body, tuple(variables), reader.since(token.start))


def _numerator(reader: Reader) -> Node:
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
    variables = _repeat(reader.factor())
    reader.take("}")
    _same_order(reader, order, len(variables))
    body = _operand(reader) if body is None else body
    return Derivative(body, variables[0], order, reader.since(token.start))


def _operand(reader: Reader) -> Node:
    r"""What stands behind ``\frac{d}{dt}``: braces, or the whole term; a bracket before further
    factors may be all of it or not."""
    if reader.ends_term():
        reader.fail("what is differentiated is missing", Unfamiliar)
    if reader.peek() == "{":
        return reader.factor()
    if reader.peek() not in _CLOSERS.values():
        return reader.term()
    body = reader.factor()
    if not reader.ends_term():
        what = "this may be a factor of what is differentiated, or of its rate; write it first, or"
        reader.fail(f"{what} put all that is differentiated in one bracket", Ambiguous)
    return body


def _rate(reader: Reader, token: Token) -> Node | None:
    r"""``d/dt f``, ``d(f)/dt``, ``d^2x/dt^2``; nothing, where the ``d`` begins none of these."""
    start, order, body = reader.position, 1, None
    own = not reader.vocabulary.differentials
    if own and "/" not in map(reader.peek, range(6)):
        return None
    if reader.peek() == "^" and "number" in (reader.kind(1), reader.kind(2)):
        order = _order(reader)
    if reader.peek() != "/" and (order > 1 or reader.peek() == "(" or own):
        body = reader.factor()
    if [reader.peek(k) for k in range(3)] != ["/", "d", "t"]:
        if own or (body is None and order == 1):
            reader.position = start
            return None
        if order > 1:
            reader.fail(f"'/dt^{order}' is missing")
        return Differential(body, "d", reader.since(token.start))
    reader.position += 3
    _same_order(reader, order, _order(reader))
    body = _operand(reader) if body is None else body
    return Derivative(body, Name("t"), order, reader.since(token.start))


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
        reader.fail("the order of a derivative must be a number", Unfamiliar)
    return int(order.text)


def _denominator_is_differential(reader: Reader) -> bool:
    end = group_end(reader.tokens, reader.position)
    words = [token.text for token in reader.tokens[end : end + 3]]
    return words[:2] == ["{", "d"] and (reader.vocabulary.differentials or "t" in words)


def _repeat(variable: Node) -> list[Node]:
    """``x^2`` in the denominator of a partial derivative is x twice."""
    if isinstance(variable, Power) and isinstance(variable.exponent, Number):
        return [variable.base] * int(variable.exponent.text)
    return [variable]


def atom(reader: Reader, token: Token) -> Node:
    """What ``token``, already taken, begins; scripts after it are not read."""
    text, at = token.text, (token.start, token.end)
    if token.kind == "number":
        if "," in text:
            what = "this comma may stand before decimals or part thousands; write a point, or none"
            raise complain(reader.source, token.start, what, Ambiguous)
        return Number(text, at)
    if text == "d":
        found = _rate(reader, token)
        if found is not None:
            return found
        if reader.vocabulary.differentials and starts_name(*reader.place):
            return Differential(reader.factor(), "d", reader.since(token.start))
    if text == "\\delta" and reader.vocabulary.variations and reader.peek() not in ("", "_", "^"):
        return Variation(reader.factor(), reader.since(token.start))
    if token.kind in ("letter", "text", "name") or text in FUNCTIONS | GREEK:
        return Name(text, at=at)
    if text in _CLOSERS.values():
        return _group(reader, token)
    if text == "|":
        return _size(reader, token)
    if text in _COMMANDS:
        return _COMMANDS[text](reader, token)
    if text in ELEMENTARY:
        return _elementary(reader, token)
    if text in ACCENTS:
        return _read_accent(reader, token)
    before = reader.tokens[reader.position - 2].text if reader.position > 1 else ""
    if text in (")", "]", "}") and before != "{":  # braces around nothing bear an index
        what = f"something before '{text}' is missing"
        raise complain(reader.source, token.start, what, Unfamiliar)
    if text == "\\begin":
        text += reader.source[token.end :].partition("}")[0] + "}"
    raise complain(reader.source, token.start, f"'{text}' is not understood")


def _group(reader: Reader, token: Token) -> Node:
    single = reader.kind() in ("number", "letter") and reader.peek(1) == ")"
    if reader.position == 1 and single and reader.peek(2) not in {*_STOP, "", "^", "_", "'"}:
        what = "this may be a factor, or the number of the formula; write no parentheses, or \\tag"
        raise complain(reader.source, token.start, what, Ambiguous)
    items = reader.group(token)
    if len(items) == 1:
        return items[0]
    if token.text == "{":
        raise complain(reader.source, token.start, "a comma between braces is not understood")
    return Listing(items, token.text, reader.since(token.start))


_DIRECTIONS = re.compile(r"(\\left|\\lvert|\\[bB]igg?l)|\\right|\\rvert|\\[bB]igg?r")
"""Bars of which the print says whether they open."""


def _size(reader: Reader, token: Token) -> Node:
    r"""``|v|``, ``\left|v\right|`` is the function ``abs``, applied.

    A bar closes where it can, unless the print says that it opens.
    """
    printed = _DIRECTIONS.match(reader.source, token.start)
    before = reader.tokens[reader.position - 2].text if reader.position > 1 else "="
    if printed is None and reader.peek() == "-" and before not in _BREAKS:
        what = "these bars can be read in two ways; write \\left|...\\right|"
        raise complain(reader.source, token.start, what, Ambiguous)
    outside, reader.in_bars, reader.opened = reader.in_bars, True, reader.position
    body = None if printed is not None and printed[1] is None else reader.sum()
    reader.in_bars = outside
    if body is None or reader.peek() != "|":
        what = "this bar has no partner; write |v|, or \\left|...\\right| where bars are nested"
        raise complain(reader.source, token.start, what)
    reader.take()
    return Call(Name("abs"), (body,), reader.since(token.start))


_MINUS_ONE = Sum(((-1, Number("1")),))


def _elementary(reader: Reader, token: Token) -> Node:
    power = None
    if reader.peek() == "^":
        reader.take()
        power = reader.argument()
    start, bare = reader.begin(), reader.peek() not in ("|", *_CLOSERS.values())
    argument = _function_argument(reader, start)
    if power == _MINUS_ONE:
        what = f"this may be 1/{token.text[1:]} or the inverse function; write one of these"
        raise complain(reader.source, token.start, what, Ambiguous)
    if bare and not reader.vocabulary.narrow_functions:
        doubt = open_argument(token.text[1:], *reader.place, reader.vocabulary)
        if doubt:
            raise complain(reader.source, token.start, doubt, Ambiguous)
        if token.text in _LOGARITHMS and isinstance(argument, Product):
            _refuse_gap(reader, token, argument)
    node: Node = Elementary(token.text[1:], argument, reader.since(token.start))
    return node if power is None else Power(node, power, reader.since(token.start))


def _function_argument(reader: Reader, start: int) -> Node:
    r"""``\sin 2u`` is the sine of 2u; ``\sin x^2`` may be a square, or the sine of one."""
    if reader.kind() == "number":
        number = reader.factor()
        more = not reader.ends_term() and reader.peek() not in ("\\cdot", *_BETWEEN)
        return Product((number, reader.factor()), reader.since(start)) if more else number
    opening = reader.peek()
    if opening in _CLOSERS.values() and opening != "{":
        return reader.atom()
    argument = reader.atom() if opening == "|" else scripts(reader, reader.atom(), start)
    argument = reader.at_time(argument)
    if isinstance(argument, Power) or (opening == "|" and reader.peek() == "^"):
        what = "this is the power of a function or of its argument; write one with parentheses"
        raise complain(reader.source, start, what, Ambiguous)
    return argument


_LOGARITHMS = ("\\ln", "\\log", "\\exp")


def _refuse_gap(reader: Reader, token: Token, argument: Product) -> None:
    r"""``\ln 2\,v`` may be (ln 2) v; ``\ln 2v`` is not, and a sine is never one of a number."""
    number, factor = argument.factors
    if number.at[1] != factor.at[0]:
        name = token.text[1:]
        what = f"this may be the {name} of a product, or of the number alone; write parentheses"
        raise complain(reader.source, token.start, what, Ambiguous)


def _read_accent(reader: Reader, token: Token) -> Node:
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


def _read_dots(reader: Reader, token: Token) -> Node:
    order = len(token.text) - len("\\ot")
    body = reader.argument()
    if isinstance(body, Number):
        raise complain(reader.source, token.start, f"'{token.text}' must not stand over a number")
    return Dot(body, order, reader.since(token.start))


def _lone_partial(reader: Reader, token: Token) -> Node:
    return Differential(reader.factor(), "\\partial", reader.since(token.start))


def _operator(reader: Reader, token: Token) -> Node:
    r"""``\ker f``: applied to the rest of the term, by a function of the dictionary."""
    name = Name(token.text, at=(token.start, token.end))
    return Call(name, (reader.term(),), reader.since(token.start))


_COMMANDS: dict[str, Callable[[Reader, Token], Node]] = {
    "\\frac": fraction,
    "\\sqrt": root,
    "\\sum": bound,
    "\\int": integral,
    "\\partial": _lone_partial,
    "\\dot": _read_dots,
    "\\ddot": _read_dots,
    "\\dddot": _read_dots,
    "\\overrightarrow": _arrow,
    "\\ker": _operator,
}


def scripts(reader: Reader, node: Node, start: int) -> Node:
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
    reader.in_index = outside
    return tuple(found)


_CLOSERS = {")": "(", "]": "[", "}": "{", "\\}": "\\{"}
_SIGNS = {"+": 1, "-": -1, "\\pm": 1, "\\mp": -1}
_STOP = {*_CLOSERS, ",", "\\quad", "\\qquad"} | RELATIONS | set(_SIGNS)
_ARROWS = (["\\mapsto"], ["\\longmapsto"])
_SIGN_NAMES = {"\\pm", "\\oplus", "\\ker", "\\in"}
_BETWEEN: dict[str, Callable[[Node, Node, tuple[int, int]], Node]] = {
    "\\times": Cross,
    "/": Quotient,
    "\\wedge": Wedge,
}
_BREAKS = {*_CLOSERS.values(), *_SIGNS, *_BETWEEN, ",", "\\cdot", "^", "_"} | RELATIONS | ELEMENTARY
"""What a bar opens behind."""


class Reader:
    """Recursive descent over the words; one method for each construct."""

    def __init__(
        self,
        tokens: list[Token],
        source: str,
        vocabulary: LatexVocabulary,
        all_labels: bool = False,
    ) -> None:
        self.tokens, self.source, self.vocabulary = tokens, source, vocabulary
        self.in_index = self.in_bars = False
        self.opened = 0  # where the words inside the last bar begin
        self.all_labels = all_labels
        self.position = 0

    # -- words ----------------------------------------------------------------------------

    def peek(self, ahead: int = 0) -> str:
        index = self.position + ahead
        return self.tokens[index].text if index < len(self.tokens) else ""

    @property
    def place(self) -> tuple[list[Token], int]:
        """The words, and how far they are read."""
        return self.tokens, self.position

    def kind(self, ahead: int = 0) -> str:
        index = self.position + ahead
        return self.tokens[index].kind if index < len(self.tokens) else ""

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
                if self.ends_term():
                    self.fail("a factor is missing; a sign behind a product wants parentheses")
            elif text in _BETWEEN or text == "\\oplus":
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
        return self.peek() == "" or self.peek() in _STOP or self._closes_bar()

    def _closes_bar(self) -> bool:
        """Whether the word ahead closes the bar that is open."""
        if not self.in_bars or self.peek() != "|" or self.position == self.opened:
            return False
        printed = _DIRECTIONS.match(self.source, self.tokens[self.position].start)
        opens = printed is not None and printed[1] is not None
        return not opens and self.tokens[self.position - 1].text not in _BREAKS

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
        if sign in _BETWEEN:
            return [_BETWEEN[sign](left, right, self.since(start))]
        name = Name(sign, at=(token.start, token.end))
        return [Call(name, (left, right), self.since(start))]

    def _refuse_open_divisor(self, factors: list[Node], right: Node, opening: str) -> None:
        r"""``a/2b`` may be (a/2) b or a/(2 b); ``a/(2)b``, ``1/2 b`` and ``dx/dt b`` are none."""
        if self.ends_term() or self.peek() in ("\\cdot", "\\oplus", *_BETWEEN):
            return
        whole = len(factors) == 1 and isinstance(factors[0], Number) and isinstance(right, Number)
        whole = whole and self.tokens[self.position].start > self.tokens[self.position - 1].end
        rate = isinstance(factors[-1], Differential) and isinstance(right, Differential)
        if not (whole or rate or opening in _CLOSERS.values()):
            what = "this quotient can be read in two ways; write (a/b) c or a/(b c)"
            self.fail(what, Ambiguous)

    # -- factors --------------------------------------------------------------------------

    def factor(self) -> Node:
        start = self.begin()
        node = scripts(self, self.atom(), start)
        if self.peek() == "(" and self._applies(node):
            node = Call(node, self.group(self.take()), self.since(start))
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
        return scripts(self, node, start) if self.peek() in ("^", "_", "'") else node

    def _named_function(self, name: Name, start: int) -> Node:
        r"""``\operatorname{sgn} v``."""
        bare, argument = self.peek() != "|", _function_argument(self, self.begin())
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
            depth += (token.text in _CLOSERS.values()) - (token.text in _CLOSERS)
            if depth == 0:
                return False
            if depth == 1 and token.text == ",":
                return True
        return False

    def group(self, opening: Token) -> tuple[Node, ...]:
        """What stands between the bracket ``opening``, already taken, and its counterpart."""
        closer = next(c for c, o in _CLOSERS.items() if o == opening.text)
        outside, self.in_bars = self.in_bars, False
        items = [self._item()]
        while self.peek() == ",":
            self.take()
            items.append(self._item())
        if self.peek() != closer and (self.peek() in (*_CLOSERS, "") or not self._is_balanced()):
            what = f"the '{opening.text}' here is not closed: '{closer}' is missing"
            known = opening.text != "\\{" and not self._is_balanced()  # no [a, b), no open brace
            raise complain(self.source, opening.start, what, Misprint if known else Unfamiliar)
        self.take(closer)
        self.in_bars = outside
        return tuple(items)

    def _is_balanced(self) -> bool:
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


def _is_partial(node: Node) -> bool:
    return isinstance(node, Differential) and node.sign == "\\partial"


def _product(factors: list[Node], at: tuple[int, int]) -> Node:
    return factors[0] if len(factors) == 1 else Product(tuple(factors), at)

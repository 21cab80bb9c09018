r"""Reads LaTeX mathematics into a tree, in the dialect of papers on mechanics.

Products are written side by side; ``\sin u\cos v`` is (sin u)(cos v), and ``\sin u v``, which may
be the sine of uv, is refused, unless the vocabulary or braces say what is meant: ``\sin{uv}``;
``\frac12`` and ``\dot u_1`` need no braces.  Here stand the constructs that a word begins; sums,
products and factors are read by the ``Reader`` of ``descent``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from voronec.audit.latex.descent import (
    BREAKS,
    CLOSERS,
    DIRECTIONS,
    STOP,
    Reader,
    function_argument,
)
from voronec.audit.latex.displays import group_end
from voronec.audit.latex.doubts import (
    open_argument,
    starts_name,
)
from voronec.audit.latex.nodes import (
    Bound,
    Call,
    Chain,
    Derivative,
    Differential,
    Dot,
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
from voronec.audit.latex.tables import BEGINNINGS, read_table
from voronec.audit.latex.tokens import (
    ACCENTS,
    ELEMENTARY,
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


def read(source: str, vocabulary: LatexVocabulary | None = None) -> Chain:
    """The tree of one formula; ``DefinitionError`` names the place of what is not understood."""
    return read_tokens(tokenize(source), source, vocabulary or LatexVocabulary())


def read_tokens(tokens: Sequence[Token], source: str, vocabulary: LatexVocabulary) -> Chain:
    """The tree of the formula that the given words of ``source`` make."""
    try:
        return Reader(list(tokens), source, vocabulary, atom).formula()
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
    reader = Reader(tokenize(bare), bare, vocabulary or LatexVocabulary(), atom, all_labels=True)
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
    if reader.peek() not in CLOSERS.values():
        return reader.term()
    body = reader.factor()
    if not reader.ends_term():
        what = "this may be a factor of what is differentiated, or of its rate; write it first, or"
        reader.fail(f"{what} put all that is differentiated in one bracket", Ambiguous)
    return body


def _rate(reader: Reader, token: Token) -> Node | None:
    r"""``d/dt f``, ``d(f)/dt``, ``d^2x/dt^2``; nothing, where the ``d`` begins none of these."""
    start, order, body = reader.position, 1, None
    rates_only = not reader.vocabulary.differentials
    if rates_only and "/" not in map(reader.peek, range(6)):
        return None
    if reader.peek() == "^" and "number" in (reader.kind(1), reader.kind(2)):
        order = _order(reader)
    if reader.peek() != "/" and (order > 1 or reader.peek() == "(" or rates_only):
        body = reader.factor()
    if [reader.peek(k) for k in range(3)] != ["/", "d", "t"]:
        if rates_only or (body is None and order == 1):
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
        rate = _rate(reader, token)
        if rate is not None:
            return rate
        if reader.vocabulary.differentials and starts_name(*reader.place):
            return Differential(reader.factor(), "d", reader.since(token.start))
    if text == "\\delta" and reader.vocabulary.variations and reader.peek() not in ("", "_", "^"):
        return Variation(reader.factor(), reader.since(token.start))
    if token.kind in ("letter", "text", "name") or text in FUNCTIONS | GREEK:
        return Name(text, at=at)
    if text in CLOSERS.values():
        return _group(reader, token)
    if text == "|":
        return _size(reader, token)
    if text in BEGINNINGS:
        return read_table(reader, token)
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
    raise complain(reader.source, token.start, f"'{text}' is not understood")


def _group(reader: Reader, token: Token) -> Node:
    single = reader.kind() in ("number", "letter") and reader.peek(1) == ")"
    if reader.position == 1 and single and reader.peek(2) not in {*STOP, "", "^", "_", "'"}:
        what = "this may be a factor, or the number of the formula; write no parentheses, or \\tag"
        raise complain(reader.source, token.start, what, Ambiguous)
    items = reader.group(token)
    if len(items) == 1:
        return items[0]
    if token.text == "{":
        raise complain(reader.source, token.start, "a comma between braces is not understood")
    return Listing(items, token.text, reader.since(token.start))


def _size(reader: Reader, token: Token) -> Node:
    r"""``|v|``, ``\left|v\right|`` is the function ``abs``, applied.

    A bar closes where it can, unless the print says that it opens.
    """
    printed = DIRECTIONS.match(reader.source, token.start)
    before = reader.tokens[reader.position - 2].text if reader.position > 1 else "="
    if printed is None and reader.peek() == "-" and before not in BREAKS:
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


_SIGN_NAMES = {"\\pm", "\\oplus", "\\ker", "\\in"}
_MINUS_ONE = Sum(((-1, Number("1")),))


def _elementary(reader: Reader, token: Token) -> Node:
    power = None
    if reader.peek() == "^":
        reader.take()
        power = reader.argument()
    start, bare = reader.begin(), reader.peek() not in ("|", *CLOSERS.values())
    argument = function_argument(reader, start)
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
    if inner == Number("0"):
        return inner
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

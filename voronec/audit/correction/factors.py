r"""Factors, terms and words that are too many, and factors that are missing.

These changes follow the tree of the formula; inside derivatives, integrals and functions nothing
is put in or left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from voronec.audit.correction.changes import Change, without
from voronec.audit.latex.displays import RELATIONS
from voronec.audit.latex.nodes import (
    Bound,
    Call,
    Chain,
    Cross,
    Dot,
    Elementary,
    Listing,
    Name,
    Node,
    Number,
    Power,
    Product,
    Quotient,
    Root,
    Sum,
    walk,
)
from voronec.audit.latex.tokens import Token
from voronec.audit.study import Study

__all__ = ["NUMBERS", "omit_parts", "omit_words", "own_factors", "put_in"]

Place = tuple[int, int]
NUMBERS = ("\\frac12", "2")
_BRACKETS = {"(": ")", "[": "]"}
_GROUPS = {**_BRACKETS, "{": "}"}


def own_factors(printed: str, chain: Chain, study: Study) -> tuple[str, ...]:
    """What a formula is made of: its names, then what else it multiplies, then squares of names."""
    called = {part.function for part in walk(chain) if isinstance(part, Call)}
    found: dict[int, dict[str, None]] = {0: {}, 1: {}, 2: {}}
    for part in walk(chain):
        text = printed[slice(*part.at)]
        if isinstance(part, (Name, Dot)):
            inner = part.body if isinstance(part, Dot) else part
            if isinstance(inner, Name) and not (study.is_index(inner) or inner in called):
                found[0][text] = None
                found[2][text + "^2"] = None
        elif isinstance(part, Power) and isinstance(part.exponent, Number):
            if isinstance(part.base, Name):
                found[1][text] = None
        elif isinstance(part, Elementary):
            found[1][text] = None
    return tuple(text for kind in found.values() for text in kind)


def omit_words(words: Sequence[Token]) -> Iterator[Change]:
    """The formula without one of its words; brackets, marks of scripts and relations stay."""
    kept = {*_GROUPS, *_GROUPS.values(), "^", "_", ",", *RELATIONS}
    for word in words:
        if word.text not in kept:
            yield replace(without(word, words), paired=False)


def omit_parts(printed: str, chain: Chain, words: Sequence[Token]) -> Iterator[Change]:
    """The formula without a factor, then without a denominator, then without a term."""
    parts = list(_parts(chain))
    for part in parts:
        if isinstance(part, Product):
            for factor in part.factors:
                start, end = _widen(factor.at, words, _GROUPS)
                if part.at[0] <= start < end <= part.at[1]:
                    yield _alone(((start, end, ""),), part.at)
    for part in parts:
        if isinstance(part, Quotient) and printed.startswith("\\", part.at[0]):
            top = _widen(part.top.at, words, _BRACKETS)
            if part.at[0] < top[0] < top[1] < part.at[1]:
                pieces = ((part.at[0], top[0], ""), (top[1], part.at[1], ""))
                yield _alone(pieces, part.at)
            if not isinstance(part.top, (Product, Sum)):
                yield _alone(((*top, "1"),), part.at)
    for part in parts:
        if isinstance(part, Sum) and len(part.terms) > 1:
            yield from _omit_terms(part, words)


def _omit_terms(node: Sum, words: Sequence[Token]) -> Iterator[Change]:
    signs = [_sign_before(term, words) for _, term in node.terms]
    ends = [*(sign.start for sign in signs[1:] if sign is not None), node.at[1]]
    if len(ends) != len(signs):
        return
    for i, end in enumerate(ends):
        first = signs[i + 1] if i == 0 else None
        start = node.at[0] if i == 0 else ends[i - 1]
        if first is not None and first.text == "+":
            end = first.end
        yield _alone(((start, end, ""),), node.at)


def _sign_before(term: Node, words: Sequence[Token]) -> Token | None:
    start = _widen(term.at, words, _GROUPS)[0]
    before = [w for w in words if w.end <= start]
    return before[-1] if before and before[-1].text in ("+", "-", "\\pm", "\\mp") else None


def put_in(
    printed: str, chain: Chain, words: Sequence[Token], texts: Sequence[str]
) -> Iterator[Change]:
    """A factor more in a term: a power behind what it multiplies first, all else before it."""
    places = list(_terms(printed, chain, words))
    for text in texts:
        for node, (start, end) in places:
            number = text in NUMBERS
            start = start if number else _behind_number(node, start)
            about = (min(start, node.at[0]), end)
            spots = [] if number and printed[start : start + 1].isdigit() else [start]
            if not number and _ends_plainly(node, printed[:end]):
                spots = [end, *spots] if "^" in text else [*spots, end]
            for spot in spots:
                yield _alone(((spot, spot, _apart(printed, spot, text)),), about)


def _ends_plainly(node: Node, printed: str) -> bool:
    """Whether a letter behind a term is not read, or mistaken, as the argument of a function."""
    last = node.factors[-1] if isinstance(node, Product) else node
    return isinstance(last, (Name, Power, Dot)) or printed[-1:] in (")", "]")


def _apart(printed: str, place: int, text: str) -> str:
    """The text, kept apart from the command that it follows and the letter that follows it."""
    before = printed[:place].rpartition("\\")
    if before[1] and before[2].isalpha() and text[:1].isalpha():
        text = " " + text
    after = text.rpartition("\\")
    return text + " " if after[1] and after[2].isalpha() else text


def _alone(pieces: tuple[tuple[int, int, str], ...], about: Place) -> Change:
    return Change(pieces, (about[0], about[1]), paired=False)


def _parts(node: Node) -> Iterator[Node]:
    """All parts that are not inside a derivative, an integral or a function."""
    yield node
    for part in _children(node):
        yield from _parts(part)


def _children(node: Node) -> Sequence[Node]:
    if isinstance(node, Chain):
        return node.parts
    if isinstance(node, Sum):
        return [term for _, term in node.terms]
    if isinstance(node, Product):
        return node.factors
    if isinstance(node, Quotient):
        return (node.top, node.bottom)
    if isinstance(node, (Root, Bound)):
        return (node.body,)
    if isinstance(node, Power):
        return (node.base,)
    if isinstance(node, Cross):
        return (node.left, node.right)
    return node.items if isinstance(node, Listing) else ()


def _terms(printed: str, chain: Chain, words: Sequence[Token]) -> Iterator[tuple[Node, Place]]:
    """The parts that a further factor can multiply, with what stands around them in brackets."""
    for part in _parts(chain):
        if isinstance(part, (Product, Power)):
            continue  # their factors and bases are no terms
        for node in _children(part):
            start, end = _widen(node.at, words, _BRACKETS)
            bare = (start, end) == tuple(node.at)
            unbraced = isinstance(part, Quotient) and printed[start - 1 : start] != "{"
            if not unbraced and not (isinstance(node, Sum) and bare):
                yield node, (start, end)


def _behind_number(node: Node, start: int) -> int:
    """Where letters begin: ``2xy`` becomes ``2mxy``."""
    first = node.factors[0] if isinstance(node, Product) else node
    numeral = isinstance(first, Number) or (
        isinstance(first, Quotient)
        and isinstance(first.top, Number)
        and isinstance(first.bottom, Number)
    )
    return int(first.at[1]) if numeral and node is not first else start


def _widen(at: Place, words: Sequence[Token], groups: dict[str, str]) -> Place:
    """The place with the brackets that enclose just it."""
    start, end = at
    while True:
        before = [w for w in words if w.end <= start][-1:]
        after = [w for w in words if w.start >= end][:1]
        if not (before and after and groups.get(before[0].text) == after[0].text):
            return start, end
        start, end = before[0].start, after[0].end

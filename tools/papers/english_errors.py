r"""The errors that a typesetter or an author makes in a sentence, made on its text one at a time.

Words that decide are exchanged for their companions; formulas in the sentence are changed as those
of displays are.  Nothing here knows how an audit reads the sentence.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

from papers.latex_errors import Slip, slips

_ORDERS = (
    "larger smaller,greater less,bigger smaller,increases decreases,positive negative,above below,"
    "inside outside,inner outer,before after,left right,upper lower,first second,second third,"
    "fast slow,minimal maximal,minimum maximum,necessary sufficient,stable unstable,"
    "linear quadratic,parallel orthogonal,symmetric antisymmetric,dependent independent,"
    "generalized ordinary,vertical horizontal,kinetic potential,internal external,even odd,"
    "and or,real complex,simple double,regular singular,finite infinite,equal different,"
    "homogeneous nonhomogeneous,holonomic nonholonomic,degree order,contained excluded,"
    "respectively conversely,constant variable,bounded unbounded,with without,where unless"
)
_NUMBERS = "one two three four five six seven eight"
_QUANTIFIERS = "all some,every no,each some,always never,any some,only also,generic every,a no"
_NEGATIONS = "is,are,can,has,have,does,do,was,were,will"


def _exchanges() -> dict[str, list[tuple[str, str]]]:
    found: dict[str, list[tuple[str, str]]] = {}
    for kind, pairs in (("order", _ORDERS), ("quantifier", _QUANTIFIERS)):
        for pair in pairs.split(","):
            one, two = pair.split()
            found.setdefault(one, []).append((kind, two))
            found.setdefault(two, []).append((kind, one))
    words = _NUMBERS.split()
    for one, two in pairwise(words):
        found.setdefault(one, []).append(("number", two))
        found.setdefault(two, []).append(("number", one))
    return found


_EXCHANGES = _exchanges()
_FORMULA = re.compile(r"\$[^$]*\$")
_REFERENCE = re.compile(r"\\(?:eq)?ref\{([^}]*)\}")
_CLAUSE = re.compile(r",?\s\b(?:if|where|when|for|with|while|provided|under)\b[^,.;:]*")
MOST = 6
"""Errors in each formula of a sentence."""
OTHERS = 2
"""Other labels that take the place of each reference."""


def sentence_slips(text: str, labels: Sequence[str]) -> list[Slip]:
    """Every error in a sentence, each once; ``labels`` are those that the paper has."""
    found: dict[str, Slip] = {}
    for slip in (
        *_words(text),
        *_denials(text),
        *_clauses(text),
        *_references(text, labels),
        *_formulas(text),
    ):
        if slip.latex != text:
            found.setdefault(slip.latex, slip)
    return list(found.values())


def _plain(text: str, start: int) -> bool:
    """Whether a place is outside of formulas and commands."""
    inside = any(m.start() <= start < m.end() for m in _FORMULA.finditer(text))
    return not inside and not re.search(r"\\[a-zA-Z]*\{?[^{}\s]*$", text[:start])


def _words(text: str) -> Iterator[Slip]:
    for match in re.finditer(r"[A-Za-z]+", text):
        word = match.group()
        if not _plain(text, match.start()):
            continue
        for kind, other in _EXCHANGES.get(word.lower(), ()):
            new = other.capitalize() if word[0].isupper() else other
            yield Slip(kind, text[: match.start()] + new + text[match.end() :], match.start())


def _denials(text: str) -> Iterator[Slip]:
    for match in re.finditer(r"\s\bnot\b", text):
        if _plain(text, match.start()):
            yield Slip("negation", text[: match.start()] + text[match.end() :], match.start())
    for match in re.finditer(rf"\b(?:{_NEGATIONS.replace(',', '|')})\b(?! not)", text):
        if _plain(text, match.start()):
            yield Slip("negation", text[: match.end()] + " not" + text[match.end() :], match.end())


def _clauses(text: str) -> Iterator[Slip]:
    """A condition left out."""
    for match in _CLAUSE.finditer(text):
        even = match.group().count("$") % 2 == 0 and match.group().count(
            "{"
        ) == match.group().count("}")
        if even and _plain(text, match.start()):
            yield Slip("condition", text[: match.start()] + text[match.end() :], match.start())


def _references(text: str, labels: Sequence[str]) -> Iterator[Slip]:
    for match in _REFERENCE.finditer(text):
        here = labels.index(match[1]) if match[1] in labels else 0
        for step in range(1, OTHERS + 1):
            other = labels[(here + step) % len(labels)]
            start, end = match.span(1)
            yield Slip("reference", text[:start] + other + text[end:], start)


def _formulas(text: str) -> Iterator[Slip]:
    for match in _FORMULA.finditer(text):
        every = slips(match.group())
        for slip in every[:: max(1, len(every) // MOST)][:MOST]:
            changed = text[: match.start()] + slip.latex + text[match.end() :]
            yield Slip(slip.kind, changed, match.start() + slip.at)

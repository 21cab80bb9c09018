"""The small changes that a formula may need, in the order in which they are believed.

A change is a few replacements in the printed text: at one place, or of one name at all its places.

off, an index that no letter fits, an argument left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

from voronec.audit.correction.changes import Change, Piece, Spare, insert, replace_word, without
from voronec.audit.correction.factors import NUMBERS, omit_parts, omit_words, own_factors, put_in
from voronec.audit.correction.fonts import Letter, is_letter, known_fonts, letters_of, space_after
from voronec.audit.correction.omissions import differentials, relations
from voronec.audit.latex.displays import RELATIONS, script_ranges
from voronec.audit.latex.nodes import Chain
from voronec.audit.latex.reader import read
from voronec.audit.latex.tokens import ELEMENTARY, Token, tokenize
from voronec.audit.latex.vocabulary import APPLIED
from voronec.audit.study import Study
from voronec.errors import DefinitionError

__all__ = [
    "keyboard_slips",
    "letter_exponents",
    "number_edits",
    "numbers_for_letters",
    "script_edits",
    "single_changes",
]


_CLOSING = frozenset(")]}")
_TAKING = frozenset(("\\partial", "\\dot", "\\ddot", "\\sqrt", "\\delta", *ELEMENTARY))
"""Words that something must follow."""
LONGEST = 40
"""How many words may be said twice."""


def keyboard_slips(
    words: Sequence[Token], study: Study, spare: Spare, letters: Sequence[str]
) -> Iterator[Change]:
    """Every change of this kind; they are not tried in pairs."""
    for change in (
        *_transpositions(words),
        *_twice(words),
        *_brackets(words),
        *_indices(words, study, spare),
        *_arguments(words, letters),
    ):
        yield replace(change, paired=False)


def _transpositions(words: Sequence[Token]) -> Iterator[Change]:
    """Two letters that follow each other exchanged, without their fonts and with them."""
    plain = [w for w in words if is_letter(w)]
    for one, two in pairwise(plain):
        if one.text != two.text:
            pieces = (
                (one.start, one.end, space_after(two.text)),
                (two.start, two.end, space_after(one.text)),
            )
            yield Change(pieces, (one.start, two.end))
    for first, second in pairwise(letters_of(words)):
        if (first.accent or second.accent) and first.text != second.text:
            whole = (
                (first.start, first.end, second.text),
                (second.start, second.end, first.text),
            )
            yield Change(whole, (first.start, second.end))


def _twice(words: Sequence[Token]) -> Iterator[Change]:
    """Words that are followed by the same words, or by a sign and the same words, said once."""
    texts = [word.text for word in words]
    for start in range(len(words)):
        for size in range(1, min(LONGEST, (len(words) - start) // 2) + 1):
            for gap in (0, 1):
                again, end = start + size + gap, start + 2 * size + gap
                signed = gap == 0 or texts[again - 1] in ("+", "-")
                if end <= len(words) and signed and texts[start : again - gap] == texts[again:end]:
                    a, b = words[again - gap].start, words[end - 1].end
                    yield Change(((a, b, ""),), (words[start].start, b))


def _brackets(words: Sequence[Token]) -> Iterator[Change]:
    """A bracket that closes one word earlier, or one later."""
    for before, word in pairwise(words):
        if word.text in (")", "]") and before.text not in _CLOSING:
            pieces = ((before.start, before.start, word.text), (word.start, word.end, ""))
            yield Change(pieces, (before.start, word.end))
        if before.text in (")", "]") and word.text not in _CLOSING:
            pieces = ((before.start, before.end, ""), (word.end, word.end, before.text))
            yield Change(pieces, (before.start, word.end))


def _indices(words: Sequence[Token], study: Study, spare: Spare) -> Iterator[Change]:
    """Another index, for one that holds a letter of which no index is made."""
    for start, end in script_ranges(words):
        inside = words[start:end]
        a, b = inside[0].start, inside[-1].end
        about = (words[max(start - 2, 0)].start, b)
        odd = [w for w in inside if is_letter(w) and w.text not in study.indices]
        if not odd or words[start - 1].text != "_":
            continue
        for other in spare.indices:
            yield Change(((a, b, other),), about)
        for word in odd:
            for letter in study.indices:
                yield Change(((word.start, word.end, space_after(letter)),), about)


def _arguments(words: Sequence[Token], letters: Sequence[str]) -> Iterator[Change]:
    """A letter after a word that something must follow, where nothing does."""
    for word, after in zip(words, (*words[1:], None), strict=True):
        ends = after is None or after.text in {*_CLOSING, *RELATIONS, "+", "-", ","}
        if word.text in _TAKING and ends:
            for letter in dict.fromkeys(letters):
                place = (word.end, word.end, space_after(" " + letter))
                yield Change((place,), (word.start, word.end))


_DIGITS = "2345678910"
"""All digits, in the order in which they are tried."""


def letter_exponents(words: Sequence[Token]) -> Iterator[Change]:
    """A number for a letter in the exponent."""
    for start, end in script_ranges(words):
        inside = words[start:end]
        if words[start - 1].text == "^" and [w.kind for w in inside] in _LETTER:
            word = next(w for w in inside if w.kind == "letter")
            about = (words[max(start - 2, 0)].start, words[end - 1].end)
            for digit in "234":
                yield Change(((word.start, word.end, digit),), about)


_LETTER = (["letter"], ["sign", "letter", "sign"])


def number_edits(words: Sequence[Token], letters: Sequence[str]) -> Iterator[Change]:
    """Another digit, none, or a letter of the formula; a factor 2 more."""
    for before, word, after in zip((None, *words), words, (*words[1:], None), strict=False):
        if word.kind == "number":
            raised = before is not None and before.text == "^"
            factor = after is not None and (is_letter(after) or after.text in ("(", "["))
            if len(word.text) == 1 and (raised or factor):
                yield replace_word(word, "")
            yield from _other_digits(word, raised or factor)
        elif is_letter(word):
            yield insert(word, "2")
    yield from numbers_for_letters(words, letters)


def _other_digits(word: Token, strong: bool) -> Iterator[Change]:
    """One digit for another; a number that is all of an exponent or factor is not 1 or 0."""
    alone = len(word.text) == 1
    for position, old in enumerate(word.text):
        for digit in _DIGITS:
            if old.isdigit() and not (alone and strong and digit in "10"):
                place = word.start + position
                yield Change(((place, place + 1, digit),), (word.start, word.end))


def numbers_for_letters(words: Sequence[Token], letters: Sequence[str]) -> Iterator[Change]:
    """A letter where a number is printed."""
    for word in words:
        if word.kind == "number":
            for letter in dict.fromkeys(letters):
                yield replace_word(word, space_after(letter))


def script_edits(words: Sequence[Token]) -> Iterator[Change]:
    """An index 1, or a square, more or less; a letter left out."""
    for word in words:
        if is_letter(word):
            yield insert(word, "_1", after=True)
            yield insert(word, "^2", after=True)
            yield insert(word, "^3", after=True)
            yield without(word, words)
        elif word.text in (")", "]"):
            yield insert(word, "^2", after=True)
    for start, end in script_ranges(words):
        a, b = words[start - 1].start, words[end - 1].end
        base = words[max(start - 2, 0)].start
        if words[start].kind == "number" or words[start - 1].text == "_":
            yield Change(((a, b, ""),), (base, b))
        elif words[start - 1].text == "^":
            yield Change(((a, b, "^2"),), (base, b))
        if words[start - 1].text == "_":
            yield Change(((b, b, "^2"),), (base, b))


def single_changes(printed: str, study: Study, spare: Spare) -> list[Change]:
    """Every change that is tried by itself, the believable ones first."""
    words = tokenize(printed)
    own = [w.text for w in words if is_letter(w)]
    chain = _tree(printed, study)
    kinds = (
        (*differentials(words), *letter_exponents(words), *relations(words)),
        _exchanges(words),
        _index_edits(printed, words, study, spare.indices),
        _mark_edits(words, [printed, *spare.formulas]),
        _name_edits(words, study, own),
        number_edits(words, own),
        script_edits(words),
        (*omit_words(words), *omit_parts(printed, chain, words)),
        put_in(printed, chain, words, (*NUMBERS, *own_factors(printed, chain, study))),
        _font_edits(words, study),
        _letter_edits(words, list(letters_of(words))),
        _name_edits(words, study, spare.letters),
        _letter_edits(words, spare.names),
        numbers_for_letters(words, spare.letters),
        put_in(printed, chain, words, _other_names(spare, study)),
        _name_edits(words, study, _known_letters(study)),
        keyboard_slips(words, study, spare, (*own, *spare.letters)),
    )
    found: dict[tuple[Piece, ...], Change] = {}
    for rank, kind in enumerate(kinds):
        for change in kind:
            pieces = tuple(p for p in change.pieces if printed[p[0] : p[1]] != p[2])
            if pieces:
                found.setdefault(pieces, replace(change, pieces=pieces, rank=rank))
    return list(found.values())


def _tree(printed: str, study: Study) -> Chain:
    """The tree of a formula; an empty one where it cannot be read."""
    try:
        return read(printed, study.vocabulary)
    except DefinitionError:
        return Chain(())


def _other_names(spare: Spare, study: Study) -> list[str]:
    """The names that the section prints, then those of the dictionary; then their squares."""
    known = [name for name, value in study.names.items() if not callable(value)]
    names = [n for n in dict.fromkeys((*spare.factors, *known)) if n not in study.indices]
    return [*names, *(f"{name}^2" for name in names)]


def _known_letters(study: Study) -> list[str]:
    """The letters of the dictionary."""
    keys = (key.removesuffix(APPLIED).replace("#", "") for key in study.table)
    return [word.text for key in keys for word in tokenize(key) if is_letter(word)]


_COMPANIONS = {"+": "-", "-": "+", "<": ">", ">": "<", "\\sin": "\\cos", "\\cos": "\\sin"}


def _exchanges(words: Sequence[Token]) -> Iterator[Change]:
    """Signs, sine and cosine; a sign at the head of a side, but not of what is defined."""
    for before, word in zip((None, *words), words, strict=False):
        heads = before is not None and (before.text in RELATIONS or before.text in ("(", "["))
        if heads and word.text not in ("+", "-"):
            yield insert(word, "-")
        other = _COMPANIONS.get(word.text)
        if other is not None:
            yield replace_word(word, other)


def _index_edits(
    printed: str, words: Sequence[Token], study: Study, spare: Sequence[str]
) -> Iterator[Change]:
    """Another index: a letter for a letter, then a whole index expression."""
    letters = [w for w in dict.fromkeys(t.text for t in words) if w in study.indices]
    for start, end in script_ranges(words):
        for word in words[start:end]:
            if word.text in study.indices:
                for other in letters:
                    yield replace_word(word, other)
    for start, end in script_ranges(words):
        a, b = words[start].start, words[end - 1].end
        inside = {w.text for w in words[start:end]} & set(study.indices)
        for other in spare:
            if inside and inside == {t.text for t in tokenize(other)} & set(study.indices):
                yield Change(((a, b, other),), (words[max(start - 2, 0)].start, b))


def _mark_edits(words: Sequence[Token], texts: Sequence[str]) -> Iterator[Change]:
    r"""A prime or a dot more or less; a dot only on letters that have one elsewhere."""
    dotted = {m for text in texts for m in re.findall(r"\\dot\s*\{?\s*(\\?[a-zA-Z]+)", text)}
    for word in words:
        if word.text in ("'", "\\dot"):
            yield replace_word(word, "")
        elif is_letter(word):
            yield insert(word, "'", after=True)
            if word.text in dotted:
                yield insert(word, "\\dot ")


def _name_edits(words: Sequence[Token], study: Study, letters: Sequence[str]) -> Iterator[Change]:
    """A letter for another one of ``letters``."""
    letters = [x for x in dict.fromkeys(letters) if x not in study.indices]
    for word in words:
        if is_letter(word):
            for other in letters:
                yield replace_word(word, space_after(other))


def _font_edits(words: Sequence[Token], study: Study) -> Iterator[Change]:
    """Another font or accent of a letter, at one place, then at all its places."""
    known = known_fonts(study)
    everywhere: dict[tuple[str, str, str], list[Piece]] = {}
    for place in letters_of(words):
        for accent in ("", *known.get(place.letter, ())):
            if accent != place.accent:
                piece = (place.start, place.end, replace(place, accent=accent).text)
                yield Change((piece,), (place.start, place.end))
                everywhere.setdefault((place.accent, place.letter, accent), []).append(piece)
    for pieces in everywhere.values():
        if len(pieces) > 1:
            yield Change(tuple(pieces), (pieces[0][0], pieces[-1][1]))


def _letter_edits(words: Sequence[Token], others: Sequence[Letter]) -> Iterator[Change]:
    """A letter with its font for another one, where one of them has a font."""
    texts = {other.text: other for other in others}
    for place in letters_of(words):
        for text, other in texts.items():
            if place.accent or other.accent:
                yield Change(((place.start, place.end, text),), (place.start, place.end))

"""The small changes that a formula may need, in the order in which they are believed.

A change is a few replacements in the printed text: at one place, or of one name at all its places.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from voronec.audit.correction.fonts import Letter, is_letter, known_fonts, letters_of, spaced
from voronec.audit.latex.displays import RELATIONS, script_ranges
from voronec.audit.latex.tokens import Token, tokenize
from voronec.audit.latex.vocabulary import APPLIED
from voronec.audit.study import Study
from voronec.audit.transcript import Transcript

__all__ = ["Change", "Spare", "applied", "repairs", "single_changes"]

Piece = tuple[int, int, str]
"""Replace the characters from, to by a text."""


@dataclass(frozen=True)
class Change:
    """Replacements; ``about`` is the range of the words they concern, ``rank`` orders changes."""

    pieces: tuple[Piece, ...]
    about: tuple[int, int]
    rank: int = 0


@dataclass(frozen=True)
class Spare:
    """What a section prints elsewhere: index expressions as ``{n+\\nu}``, letters, letters with
    their fonts, whole formulas.

    A formula is given as its words without spacing, to compare neighbours with.
    """

    indices: tuple[str, ...] = ()
    letters: tuple[str, ...] = ()
    names: tuple[Letter, ...] = ()
    formulas: tuple[str, ...] = ()

    @classmethod
    def of(cls, transcript: Transcript, study: Study) -> Spare:
        """Collect them."""
        formulas = list(transcript.formulas())
        words = [w for f in formulas for w in f.piece.tokens]
        letters = dict.fromkeys(w.text for w in words if is_letter(w))
        texts = tuple("".join(f.printed.split()) for f in formulas)
        names = {name.text: name for f in formulas for name in letters_of(f.piece.tokens)}
        return cls(transcript.indices(study), tuple(letters), tuple(names.values()), texts)


def applied(printed: str, pieces: Sequence[Piece]) -> tuple[str, tuple[tuple[int, int], ...]]:
    """The changed text, and where the new words stand in it."""
    text, last, marks = "", 0, []
    for start, end, new in sorted(pieces):
        if new.endswith(" ") and not printed[end : end + 1].isalpha():
            new = new.rstrip()
        text += printed[last:start]
        marks.append((len(text), len(text) + len(new)))
        text, last = text + new, end
    return text + printed[last:], tuple(marks)


def single_changes(printed: str, study: Study, spare: Spare) -> list[Change]:
    """Every change that is tried by itself, the believable ones first."""
    words = tokenize(printed)
    own = [w.text for w in words if is_letter(w)]
    kinds = (
        _missing_signs(printed, words),
        _exchanges(words),
        _index_edits(printed, words, study, spare.indices),
        _mark_edits(words, [printed, *spare.formulas]),
        _name_edits(words, study, own),
        _number_edits(words, own),
        _script_edits(printed, words),
        _font_edits(words, study),
        _letter_edits(words, list(letters_of(words))),
        _name_edits(words, study, spare.letters),
        _letter_edits(words, spare.names),
        _number_letters(words, spare.letters),
        _name_edits(words, study, _known_letters(study)),
    )
    found: dict[tuple[Piece, ...], Change] = {}
    for rank, kind in enumerate(kinds):
        for change in kind:
            pieces = tuple(p for p in change.pieces if printed[p[0] : p[1]] != p[2])
            if pieces:
                found.setdefault(pieces, Change(pieces, change.about, rank))
    return list(found.values())


def repairs(printed: str) -> list[Change]:
    """What may close a bracket that is open: at the end first, then at each place before."""
    words = tokenize(printed)
    opened: list[Token] = []
    for word in words:
        if word.text in _CLOSED_BY:
            opened.append(word)
        elif opened and word.text == _CLOSED_BY[opened[-1].text]:
            opened.pop()
    if not opened:
        return []
    closer = _CLOSED_BY[opened[-1].text]
    places = [w for w in reversed(words) if w.start >= opened[-1].end]
    return [_insert(w, closer, after=True) for w in places]


_CLOSED_BY = {"(": ")", "[": "]", "{": "}"}


def _replace(word: Token, text: str) -> Change:
    return Change(((word.start, word.end, text),), (word.start, word.end))


def _insert(word: Token, text: str, after: bool = False) -> Change:
    place = word.end if after else word.start
    return Change(((place, place, text),), (word.start, word.end))


def _known_letters(study: Study) -> list[str]:
    """The letters of the dictionary."""
    keys = (key.removesuffix(APPLIED).replace("#", "") for key in study.table)
    return [word.text for key in keys for word in tokenize(key) if is_letter(word)]


def _missing_signs(printed: str, words: Sequence[Token]) -> Iterator[Change]:
    r"""``\partial`` over ``\partial``, a number for a letter exponent, ``=0`` at the end."""
    for i, word in enumerate(words):
        if word.text == "\\frac" and words[i + 1].text == "{":
            end = _group_end(words, i + 1)
            below = [w.text for w in words[end : end + 2]]
            if below == ["{", "\\partial"] and words[i + 2].text != "\\partial":
                yield Change(
                    ((words[i + 2].start, words[i + 2].start, "\\partial "),),
                    (word.start, words[end - 1].end),
                )
    for start, end in script_ranges(words):
        if words[start - 1].text == "^" and end == start + 1 and words[start].kind == "letter":
            yield Change(
                ((words[start].start, words[start].end, "2"),),
                (words[max(start - 2, 0)].start, words[start].end),
            )
    if not any(w.text in RELATIONS for w in words):
        yield _insert(words[-1], "=0", after=True)


def _group_end(words: Sequence[Token], position: int) -> int:
    depth = 0
    while position < len(words):
        depth += (words[position].text == "{") - (words[position].text == "}")
        position += 1
        if depth == 0:
            break
    return position


_COMPANIONS = {"+": "-", "-": "+", "<": ">", ">": "<", "\\sin": "\\cos", "\\cos": "\\sin"}


def _exchanges(words: Sequence[Token]) -> Iterator[Change]:
    """Signs, sine and cosine; a sign at the head of a side."""
    for before, word in zip((None, *words), words, strict=False):
        heads = before is None or before.text in RELATIONS or before.text in ("(", "[")
        if heads and word.text not in ("+", "-"):
            yield _insert(word, "-")
        other = _COMPANIONS.get(word.text)
        if other is not None:
            yield _replace(word, other)


def _index_edits(
    printed: str, words: Sequence[Token], study: Study, spare: Sequence[str]
) -> Iterator[Change]:
    """Another index: a letter for a letter, then a whole index expression."""
    letters = [w for w in dict.fromkeys(t.text for t in words) if w in study.indices]
    for start, end in script_ranges(words):
        for word in words[start:end]:
            if word.text in study.indices:
                for other in letters:
                    yield _replace(word, other)
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
            yield _replace(word, "")
        elif is_letter(word):
            yield _insert(word, "'", after=True)
            if word.text in dotted:
                yield _insert(word, "\\dot ")


def _name_edits(words: Sequence[Token], study: Study, letters: Sequence[str]) -> Iterator[Change]:
    """A letter for another one of ``letters``."""
    letters = [x for x in dict.fromkeys(letters) if x not in study.indices]
    for word in words:
        if is_letter(word):
            for other in letters:
                yield _replace(word, spaced(other))


def _number_edits(words: Sequence[Token], letters: Sequence[str]) -> Iterator[Change]:
    """Another digit, none, or a letter of the formula; a factor 2 more."""
    for before, word, after in zip((None, *words), words, (*words[1:], None), strict=False):
        if word.kind == "number" and len(word.text) == 1:
            raised = before is not None and before.text == "^"
            factor = after is not None and (is_letter(after) or after.text in ("(", "["))
            if raised or factor:
                yield _replace(word, "")
            for digit in "23456" if raised or factor else "1234560":
                yield _replace(word, digit)
        elif is_letter(word):
            yield _insert(word, "2")
    yield from _number_letters(words, letters)


def _number_letters(words: Sequence[Token], letters: Sequence[str]) -> Iterator[Change]:
    for word in words:
        if word.kind == "number":
            for letter in dict.fromkeys(letters):
                yield _replace(word, spaced(letter))


def _script_edits(printed: str, words: Sequence[Token]) -> Iterator[Change]:
    """An index 1, or a square, more or less; a letter left out."""
    for word in words:
        if is_letter(word):
            yield _insert(word, "_1", after=True)
            yield _insert(word, "^2", after=True)
            yield _insert(word, "^3", after=True)
            yield _replace(word, "")
        elif word.text in (")", "]"):
            yield _insert(word, "^2", after=True)
    for start, end in script_ranges(words):
        a, b = words[start - 1].start, words[end - 1].end
        base = words[max(start - 2, 0)].start
        if words[start].kind == "number" or words[start - 1].text == "_":
            yield Change(((a, b, ""),), (base, b))
        elif words[start - 1].text == "^":
            yield Change(((a, b, "^2"),), (base, b))
        if words[start - 1].text == "_":
            yield Change(((b, b, "^2"),), (base, b))


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

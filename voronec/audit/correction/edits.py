"""The small changes that a formula may need, in the order in which they are believed.

A change is a few replacements in the printed text: at one place, or of one name at all its places.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from voronec.audit.correction.changes import Change, Piece, Spare, insert, replace_word
from voronec.audit.correction.factors import (
    NUMBERS,
    left_out,
    own_factors,
    put_in,
    words_left_out,
)
from voronec.audit.correction.fonts import Letter, is_letter, known_fonts, letters_of, spaced
from voronec.audit.correction.keyboard import keyboard_slips
from voronec.audit.correction.missing import differentials, relations
from voronec.audit.correction.numbers import (
    letter_exponents,
    number_edits,
    numbers_for_letters,
    script_edits,
)
from voronec.audit.latex.displays import RELATIONS, script_ranges
from voronec.audit.latex.nodes import Chain
from voronec.audit.latex.reader import read
from voronec.audit.latex.tokens import Token, tokenize
from voronec.audit.latex.vocabulary import APPLIED
from voronec.audit.study import Study
from voronec.errors import DefinitionError

__all__ = ["single_changes"]


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
        (*words_left_out(words), *left_out(printed, chain, words)),
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
                yield replace_word(word, spaced(other))


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

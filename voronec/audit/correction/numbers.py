"""Numbers that may be wrong: digits, exponents, numbers in the place of letters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from voronec.audit.correction.changes import Change, insert, replace_word, without
from voronec.audit.correction.fonts import is_letter, spaced
from voronec.audit.latex.displays import script_ranges
from voronec.audit.latex.tokens import Token

__all__ = ["letter_exponents", "number_edits", "numbers_for_letters", "script_edits"]

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
                yield replace_word(word, spaced(letter))


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

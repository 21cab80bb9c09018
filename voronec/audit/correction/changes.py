"""A small change of a printed formula: the text that takes the place of other text.

Letters have fonts and accents, and may be mistaken for others.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from voronec.audit.latex.displays import RELATIONS, script_ranges
from voronec.audit.latex.tokens import ACCENTS, GREEK, Token
from voronec.audit.study import Study
from voronec.audit.transcript import Transcript

__all__ = [
    "Change",
    "FontLetter",
    "Piece",
    "Spare",
    "apply_pieces",
    "insert",
    "is_letter",
    "known_fonts",
    "letters_of",
    "names_in",
    "replace_word",
    "space_after",
    "without",
]


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
    their fonts, names with their indices, whole formulas.

    A formula is given as its words without spacing, to compare neighbours with.
    """

    indices: tuple[str, ...] = ()
    letters: tuple[str, ...] = ()
    names: tuple[FontLetter, ...] = ()
    factors: tuple[str, ...] = ()
    formulas: tuple[str, ...] = ()

    @classmethod
    def of(cls, transcript: Transcript, study: Study) -> Spare:
        """Collect them."""
        formulas = list(transcript.formulas())
        words = [w for f in formulas for w in f.piece.tokens]
        letters = dict.fromkeys(w.text for w in words if is_letter(w))
        texts = tuple("".join(f.printed.split()) for f in formulas)
        names = {name.text: name for f in formulas for name in letters_of(f.piece.tokens)}
        factors = dict.fromkeys(
            name for f in formulas for name in names_in(f.piece.tokens, f.unit.display)
        )
        return cls(
            transcript.indices(study), tuple(letters), tuple(names.values()), tuple(factors), texts
        )


def apply_pieces(printed: str, pieces: Sequence[Piece]) -> tuple[str, tuple[tuple[int, int], ...]]:
    """The changed text, and where the new words stand in it."""
    text, last, marks = "", 0, []
    for start, end, new in sorted(pieces):
        if new.endswith(" ") and not printed[end : end + 1].isalpha():
            new = new.rstrip()
        text += printed[last:start]
        marks.append((len(text), len(text) + len(new)))
        text, last = text + new, end
    return text + printed[last:], tuple(marks)


def replace_word(word: Token, text: str) -> Change:
    """Another text for a word."""
    return Change(((word.start, word.end, text),), (word.start, word.end))


def insert(word: Token, text: str, after: bool = False) -> Change:
    """A text before or after a word."""
    place = word.end if after else word.start
    return Change(((place, place, text),), (word.start, word.end))


def without(word: Token, words: Sequence[Token]) -> Change:
    """A word left out, with the space that ends a command, or the plus sign after a first term."""
    at = words.index(word)
    leads = at == 0 or words[at - 1].text in {*RELATIONS, "(", "[", "{"}
    end, after = word.end, words[at + 1 : at + 2]
    if after and leads and after[0].text == "+":
        end = after[0].end
    elif after and leads and word.text.startswith("\\"):
        end = after[0].start
    return Change(((word.start, end, ""),), (word.start, end))


@dataclass(frozen=True)
class FontLetter:
    r"""``\mathbf G``: the command of the font or accent, or nothing, the letter, its range."""

    accent: str
    letter: str
    start: int
    end: int

    @property
    def text(self) -> str:
        """One spelling, to be put in another place."""
        return (self.accent + " " if self.accent else "") + space_after(self.letter)


def is_letter(word: Token) -> bool:
    """Whether a word is a letter by itself."""
    return word.kind == "letter" or word.text in GREEK


def space_after(text: str) -> str:
    """A word that a letter may follow."""
    return text + " " if text.startswith("\\") else text


def letters_of(words: Sequence[Token]) -> Iterator[FontLetter]:
    r"""All letters; ``\mathbf{G}`` is one, like ``\mathbf G``."""
    skip = 0
    for position, word in enumerate(words):
        inside = words[position + 1 : position + 4]
        if position < skip:
            continue
        if word.text in ACCENTS and inside and is_letter(inside[0]):
            yield FontLetter(word.text, inside[0].text, word.start, inside[0].end)
            skip = position + 2
        elif word.text in ACCENTS and len(inside) == 3 and _are_braced(inside):
            yield FontLetter(word.text, inside[1].text, word.start, inside[2].end)
            skip = position + 4
        elif is_letter(word):
            yield FontLetter("", word.text, word.start, word.end)


def names_in(words: Sequence[Token], source: str) -> Iterator[str]:
    r"""The letters as they are printed, with primes and what stands below: ``R_1``, ``\mu'``."""
    ends = {words[start - 1].start: words[end - 1].end for start, end in script_ranges(words)}
    marks = {word.start: word for word in words if word.text in ("_", "'", '"')}
    for letter in letters_of(words):
        end = letter.end
        while end in marks:
            end = ends.get(end, marks[end].end)
        yield source[letter.start : end]


def _are_braced(words: Sequence[Token]) -> bool:
    return (words[0].text, words[2].text) == ("{", "}") and is_letter(words[1])


def known_fonts(study: Study) -> Mapping[str, Sequence[str]]:
    """Letter -> fonts and accents that the dictionary has it with; nothing for none."""
    found: dict[str, dict[str, None]] = {}
    for key in study.table:
        match = re.match(r"(\\[a-z]+)\{(.+?)\}", key)
        if match and match.group(1) in ACCENTS:
            found.setdefault(match.group(2), {"": None})[match.group(1)] = None
    return {letter: tuple(fonts) for letter, fonts in found.items()}

"""Letters with their fonts and accents, as they are printed, and what they may be mistaken for."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from voronec.audit.latex.displays import script_ranges
from voronec.audit.latex.tokens import ACCENTS, GREEK, Token
from voronec.audit.study import Study

__all__ = ["Letter", "is_letter", "known_fonts", "letters_of", "names_in", "space_after"]


@dataclass(frozen=True)
class Letter:
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


def letters_of(words: Sequence[Token]) -> Iterator[Letter]:
    r"""All letters; ``\mathbf{G}`` is one, like ``\mathbf G``."""
    skip = 0
    for position, word in enumerate(words):
        inside = words[position + 1 : position + 4]
        if position < skip:
            continue
        if word.text in ACCENTS and inside and is_letter(inside[0]):
            yield Letter(word.text, inside[0].text, word.start, inside[0].end)
            skip = position + 2
        elif word.text in ACCENTS and len(inside) == 3 and _are_braced(inside):
            yield Letter(word.text, inside[1].text, word.start, inside[2].end)
            skip = position + 4
        elif is_letter(word):
            yield Letter("", word.text, word.start, word.end)


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

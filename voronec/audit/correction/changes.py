"""A small change of a printed formula: the text that takes the place of other text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from voronec.audit.correction.fonts import Letter, is_letter, letters_of, names_in
from voronec.audit.latex.displays import RELATIONS
from voronec.audit.latex.tokens import Token
from voronec.audit.study import Study
from voronec.audit.transcript import Transcript

__all__ = ["Change", "Piece", "Spare", "apply_pieces", "insert", "replace_word", "without"]

Piece = tuple[int, int, str]
"""Replace the characters from, to by a text."""


@dataclass(frozen=True)
class Change:
    """Replacements; ``about`` is the range of the words they concern, ``rank`` orders changes.

    ``paired`` tells whether it is tried together with a second change.
    """

    pieces: tuple[Piece, ...]
    about: tuple[int, int]
    rank: int = 0
    paired: bool = True


@dataclass(frozen=True)
class Spare:
    """What a section prints elsewhere: index expressions as ``{n+\\nu}``, letters, letters with
    their fonts, names with their indices, whole formulas.

    A formula is given as its words without spacing, to compare neighbours with.
    """

    indices: tuple[str, ...] = ()
    letters: tuple[str, ...] = ()
    names: tuple[Letter, ...] = ()
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

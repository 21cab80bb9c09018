"""A paper as a plugin: its displays, transcribed literally, and dictionaries to derived systems."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from voronec.audit.display import Display
from voronec.audit.sentence import Sentence
from voronec.audit.study import Study


@dataclass(frozen=True)
class Section:
    """A section or subsection of the paper.

    displays
        its displayed formulas in the order of print, letter for letter.
    studies
        takes the transcript and returns the dictionaries by name.
    inline
        formulas of the running text, as LaTeX with its dollar signs.
    sentences
        what the running text states in words, quoted letter for letter.
    complete
        the dictionaries hold every letter of the section, and the reader knows all its signs: what
        is not known is then a fault of the print.  Without it, that is not read.
    """

    title: str
    displays: tuple[Display, ...]
    studies: Callable[[Any], Mapping[str, Study]]
    label: str | None = None
    inline: tuple[Display, ...] = ()
    sentences: tuple[Sentence, ...] = ()
    complete: bool = False


@dataclass(frozen=True)
class Paper:
    """A paper to be audited: its ``sections`` in order; ``references`` are keys of the bibliography
    under which it is cited."""

    name: str
    title: str
    sections: tuple[Section, ...]
    references: tuple[str, ...] = ()
    authors: str = ""

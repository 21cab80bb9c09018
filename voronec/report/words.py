"""The words of LaTeX mathematics for typesetting, each with its place; nothing is refused."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from voronec.report.symbols import BRACKETS, INVISIBLE, SIZES

__all__ = ["Word", "is_closed", "split_words"]

_WORD = re.compile(
    r"(?P<space>\s+|%[^\n]*)|(?P<skip>\\(?:label|tag)\s*\{[^}]*\})"
    r"|(?P<begin>\\begin\s*\{(?:array\}\s*\{[^}]*|[a-zA-Z]+\*?)\})|(?P<end>\\end\s*\{[a-zA-Z]+\*?\})"
    r"|(?P<edge>\\(?:left|right)(?![a-zA-Z])\s*(?:\\[a-zA-Z]+|\\.|.))|(?P<row>\\\\(?:\[[^\]]*\])?)"
    r"|(?P<command>\\(?:[a-zA-Z]+|.))|(?P<number>\d+(?:\.\d+)?)|(?P<letter>[^\W\d_])|(?P<sign>.)",
    re.DOTALL,
)


@dataclass(frozen=True)
class Word:
    """One word: ``kind`` is begin, end, edge, row, command, number, letter or sign."""

    kind: str
    text: str
    start: int
    end: int


def split_words(latex: str, offset: int) -> list[Word]:
    """The words that show something; the size of a bracket belongs to the bracket."""
    found: list[Word] = []
    start = -1
    for match in _WORD.finditer(latex):
        text = match.group()
        if match.lastgroup in ("space", "skip") or text in INVISIBLE:
            continue
        start = match.start() if start < 0 else start
        if text not in SIZES:
            found.append(Word(str(match.lastgroup), text, offset + start, offset + match.end()))
            start = -1
    return found


def is_closed(words: Sequence[Word], opening: str) -> bool:
    """Whether a bracket before ``words`` is closed before its group, line or cell ends."""
    depth, groups = 1, 0
    for word in words:
        left = word.kind == "edge" and word.text.startswith("\\left")
        groups += word.text == "{" or word.kind == "begin" or left
        groups -= word.text == "}" or word.kind == "end" or (word.kind == "edge" and not left)
        if groups < 0 or (groups == 0 and (word.kind == "row" or word.text == "&")):
            return False
        if groups == 0:
            depth += (word.text == opening) - (word.text == BRACKETS[opening])
            if depth == 0:
                return True
    return False

"""One formula of a paper with its place: what is read, compared and referred to."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from voronec.audit.latex.displays import FormulaUnit, Piece
from voronec.audit.latex.nodes import Chain
from voronec.audit.latex.reader import read_tokens
from voronec.audit.latex.vocabulary import LatexVocabulary


@dataclass(frozen=True)
class Formula:
    """One formula with its place: unit, piece, position in the display (a ``Display``)."""

    display: Any
    unit: FormulaUnit
    piece: Piece
    position: int
    kind: str = "display"

    @property
    def printed(self) -> str:
        """The formula as it stands in the source, without alignment marks and labels."""
        return source_of(self.piece, self.unit.display)

    def tree(self, vocabulary: LatexVocabulary) -> Chain:
        """The formula, parsed."""
        return read_tokens(self.piece.tokens, self.unit.display, vocabulary)


def source_of(piece: Piece, display: str) -> str:
    """The source text of a formula: its words with the spacing between them as printed."""
    parts = []
    last = None
    for token in piece.tokens:
        if last is not None:
            gap = display[last : token.start]
            parts.append(_gap(gap))
        parts.append(display[token.start : token.end])
        last = token.end
    return "".join(parts)


def _gap(gap: str) -> str:
    """What stands between two words, without alignment, line ends, labels and environments."""
    gap = re.sub(r"\\label\s*\{[^}]*\}|\\nonumber|\\(?:begin|end)\{\w+\*?\}", "", gap)
    gap = re.sub(r"&|\\\\", "", gap)
    return re.sub(r"\s+", " ", gap)

"""The formulas of a section as trees, so that studies can use what the paper states."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product

from voronec.audit.formula import Formula
from voronec.audit.latex.displays import script_ranges
from voronec.audit.latex.nodes import Chain, Node
from voronec.audit.paper import Section
from voronec.audit.structure import free_indices
from voronec.audit.study import Study
from voronec.errors import DefinitionError


@dataclass(frozen=True)
class Transcript:
    """The formulas of one section."""

    section: Section

    def formulas(self) -> Iterator[Formula]:
        """All formulas: those of the displays in the order of print, then those of the text."""
        for kind, several in (("display", self.section.displays), ("text", self.section.inline)):
            for display in several:
                position = 0
                for unit in display.units:
                    for piece in unit.pieces:
                        yield Formula(display, unit, piece, position, kind)
                        position += 1

    def formula_labelled_as(self, label: str) -> Formula:
        """The first formula of the unit with that label; without one ``DefinitionError``."""
        for formula in self.formulas():
            if formula.unit.label == label:
                return formula
        raise DefinitionError(f"no display of '{self.section.title}' is labelled '{label}'")

    def indices(self, study: Study) -> tuple[str, ...]:
        """Every subscript that the section prints with an index letter in it, each once."""
        subscripts: dict[str, None] = {}
        for formula in self.formulas():
            words = formula.piece.tokens
            for start, end in script_ranges(words):
                if {w.text for w in words[start:end]} & set(study.indices):
                    a, b = words[start].start, words[end - 1].end
                    subscripts.setdefault(formula.unit.display[a:b])
        return tuple(subscripts)


def formulas_by_label(sections: Iterable[Section]) -> dict[str, list[Formula]]:
    """The formulas of what bears a number, by its label."""
    labelled: dict[str, list[Formula]] = {}
    for section in sections:
        for formula in Transcript(section).formulas():
            if formula.unit.label is not None:
                labelled.setdefault(formula.unit.label, []).append(formula)
    return labelled


def assignments(chain: Chain, study: Study) -> list[dict[str, int]]:
    """All values of the free indices of a formula."""
    letters = free_indices(chain, study)
    ranges = [range(1, study.indices[x] + 1) for x in letters]
    return [dict(zip(letters, values, strict=True)) for values in product(*ranges)]


def text_of(part: Node, source: str) -> str:
    """The source of a part of a formula."""
    return " ".join(source[slice(*part.at)].replace("&", "").split())


def instance(part: Node, source: str, where: Mapping[str, int]) -> str:
    """The source of a part with its index letters replaced by values."""
    text = text_of(part, source)
    for letter, value in where.items():
        ends = r"(?![a-zA-Z])" if letter.startswith("\\") else ""
        begins = "" if letter.startswith("\\") else r"(?<![\\a-zA-Z])"
        text = re.sub(begins + re.escape(letter) + ends + r"\s*", str(value), text)
    return text

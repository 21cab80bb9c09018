"""The formulas of a paper, each with its place, its sentence and its tree."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

from voronec.audit.contents import value_or_none
from voronec.audit.display import Display
from voronec.audit.formula import Formula, source_of
from voronec.audit.latex.document import Document, PrintedDisplay, PrintedSentence
from voronec.audit.latex.nodes import Chain, Name
from voronec.audit.latex.tex_file import MarkedText
from voronec.audit.study import Study, key_of
from voronec.errors import DefinitionError


@dataclass(frozen=True)
class PrintedClaim:
    """A formula of the paper with its display, its place and its tree, where it can be read.

    ``error`` says why it cannot; ``doubt``, why it can be read in two ways, of which it is the one
    in which a function takes the next name alone.
    """

    formula: Formula
    display: PrintedDisplay
    section: int
    place: tuple[str, int, int]
    chain: Chain | None
    error: str = ""
    doubt: str = ""

    @property
    def sentence(self) -> str:
        """The words around it."""
        return f"{self.display.before} {self.display.after}"

    @property
    def where(self) -> str:
        """Line and column, and the number in print."""
        number = f"({self.display.number}), " if self.display.number else ""
        return f"{number}line {self.place[1]}, column {self.place[2]}"


def claims_of(document: Document, study: Study) -> list[PrintedClaim]:
    """The formulas of a paper as they are read with a dictionary, its definitions in words too."""
    claims: list[PrintedClaim] = []
    for number, section in enumerate(document.sections):
        for display in section.displays:
            claims += claims_in(document, number, display, study)
    for sentence in document.sentences:
        for match in _DEFINES.finditer(sentence.words):
            numbers = [n for n in match.groups() if n is not None]
            name, value = (sentence.formulas[int(n)] for n in numbers)
            made = claim_in_words(document, sentence, f"${name}={value}$", study)
            parts = made.chain.parts if made is not None and made.chain else ()
            if len(parts) == 2 and isinstance(parts[0], Name) and not isinstance(parts[1], Name):
                claims += [made] if made and key_of(parts[0]) not in study.table else []
    return claims


_DEFINES = re.compile(
    r"(?:\bdenote by \$(\d+)\$|\blet \$(\d+)\$ (?:be|denote)|\$(\d+)\$ (?:denotes|stands for)"
    r"|\bwhere \$(\d+)\$ is(?= the (?:ratio|quantity|sum|difference|product|expression) \$)) "
    r"(?:the )?(?:(?:ratio|quantity|sum|difference|product|constant|expression) )?\$(\d+)\$",
    re.IGNORECASE,
)
"""A letter, and what it is, as "let $k$ be the ratio $J/m$"."""


def claim_in_words(
    document: Document,
    sentence: PrintedSentence,
    latex: str,
    study: Study,
    before: str = "",
    after: str = "",
) -> PrintedClaim | None:
    """A formula that the words of a sentence make, as a claim."""
    marked = MarkedText(latex, (document.body.origins[sentence.at],) * len(latex))
    display = PrintedDisplay(marked, "text", "", before, after, sentence.number)
    titles = [section.title for section in document.sections]
    section = titles.index(sentence.section) if sentence.section in titles else 0
    claims = [*claims_in(document, section, display, study)]
    return claims[0] if len(claims) == 1 else None


_WITH_ARGUMENTS = re.compile(
    r"\s*(?P<name>(?:\\(?:mathbf|boldsymbol|mathcal|mathrm)\s*)?\{?\\?[a-zA-Z]+\}?(?:_\w|_\{\w+\})?)"
    r"\s*\((?P<first>[^()=+\-,]*[a-zA-Z][^()=+\-,]*)(?:,[^()=+\-]*)?\)\s*=",
    re.DOTALL,
)
r"""A letter with its arguments on a left side, ``M(q) = ...``."""


def applied_letters(document: Document, study: Study) -> set[str]:
    """The letters that the paper defines with their arguments, and the system does not have."""
    letters = set()
    printed = [source_of(p, unit.display) for d in document.displays for _, unit, p in d.formulas]
    for match in filter(None, map(_WITH_ARGUMENTS.match, printed)):
        name = value_or_none(study.tree, match["name"])
        plain = any(re.match(re.escape(match["name"].strip()) + r"\s*=", text) for text in printed)
        undeclared = isinstance(name, Name) and key_of(name) not in study.table
        letters |= (
            {name.head} if undeclared and not plain and match["first"].strip() != "t" else set()
        )
    return letters


def claims_in(
    document: Document, section: int, display: PrintedDisplay, study: Study
) -> Iterator[PrintedClaim]:
    """The formulas of a display of a section."""
    for position, unit, piece in display.formulas:
        formula = Formula(Display(display.latex.text), unit, piece, position, display.kind)
        at = document.source.place(display.latex.origins[piece.at[0]])
        yield PrintedClaim(formula, display, section, at, *_tree(formula, study))


def _tree(formula: Formula, study: Study) -> tuple[Chain | None, str, str]:
    """The tree of a formula, why there is none, and why there may be another."""
    try:
        return formula.tree(study.vocabulary), "", ""
    except DefinitionError as refusal:
        doubt = str(refusal)
    try:
        return formula.tree(replace(study.vocabulary, narrow_functions=True)), "", doubt
    except DefinitionError:
        return None, doubt, ""


_BY_TIME = (
    r"(?:time\s+derivatives?|(?:derivatives?|differentiation)\s+(?:with\s+respect\s+to|by|in)\s+"
    r"(?:the\s+)?(?:time\b(?!,?\s*\$(?!t\$))|\$t\$))"
)
_PRIMES = re.compile(
    rf"\bprimes?\s(?:\w+\s+){{0,4}}?{_BY_TIME}|\b{_BY_TIME}\s(?:\w+\s+){{0,4}}?primes?\b",
    re.IGNORECASE,
)
"""Words which say that a prime is a derivative by the time."""


def has_primes(document: Document) -> bool:
    """Whether a paper says that a prime is a derivative by the time."""
    return _PRIMES.search(document.body.text) is not None

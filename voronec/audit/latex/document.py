r"""The sections of a paper, and the formulas that each holds, with their places and sentences.

A display is brought into the shape that ``split_display`` reads: systems in ``cases`` and ``array``
become lines, ``\over`` becomes ``\frac``, numbers that are printed are taken off.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path

from voronec.audit.formula import source_of
from voronec.audit.latex.displays import RELATIONS, FormulaUnit, Piece, split_display
from voronec.audit.latex.tex_file import MarkedText, TexSource, read_tex
from voronec.errors import DefinitionError

_DISPLAYS = (
    "equation align gather multline eqnarray flalign alignat displaymath math dmath xalignat "
    "IEEEeqnarray empheq"
)
_ENVIRONMENTS = "|".join(_DISPLAYS.split())
_OTHER_ENVIRONMENTS = "verbatim|lstlisting|thebibliography|tikzpicture|tabular|comment|figure"
_PARTS = re.compile(
    r"\\(?:part|chapter|(?:sub)*section|paragraph)\*?\s*(?:\[[^]]*\])?\{(?P<title>(?:[^{}]|\{[^{}]*\})*)\}"
    rf"|\\begin\{{(?P<skip>{_OTHER_ENVIRONMENTS})\*?\}}.*?\\end\{{(?P=skip)\*?\}}"
    rf"|(?P<env>\\begin\{{(?P<name>{_ENVIRONMENTS})\*?\}}.*?\\end\{{(?P=name)\*?\}})"
    r"|(?P<dollars>\$\$.*?\$\$)|(?P<bracket>\\\[.*?\\\])"
    r"|(?P<inline>\$(?:\\.|[^$\\])+\$)|(?P<round>\\\((?:\\[^)]|[^\\])+\\\))"
    r"|\\.",
    re.DOTALL,
)
_END_OF_SENTENCE = re.compile(
    r"(?<!Fig)(?<!Eq)(?<!e\.g)(?<!i\.e)(?<![A-Z])\.(?=\s|$|\\)|\n\s*\n"
    r"|\\(?:sub)*section\*?\s*\{[^}]*\}"
)


CLAIMS = RELATIONS - {"\\in", "\\colon", "\\mapsto", "\\longmapsto"}
"""The signs by which a formula claims something of values."""


@dataclass(frozen=True)
class PrintedDisplay:
    """A display or a formula of the text: its LaTeX as the reader takes it, and where it stands.

    ``before`` and ``after`` are the rest of its sentence, which ``sentence`` counts; ``number`` is
    its label, or the number that is printed.
    """

    latex: MarkedText
    kind: str
    number: str
    before: str
    after: str
    sentence: int

    @property
    def units(self) -> tuple[FormulaUnit, ...]:
        """Its formulas, as far as they claim something."""
        try:
            return split_display(self.latex.text)
        except DefinitionError:
            return ()

    @property
    def formulas(self) -> tuple[tuple[int, FormulaUnit, Piece], ...]:
        """What sets sides equal or orders them, counted through the display."""
        pieces = ((unit, piece) for unit in self.units for piece in unit.pieces)
        return tuple(
            (position, unit, piece)
            for position, (unit, piece) in enumerate(pieces)
            if any(token.text in CLAIMS for token in piece.tokens)
        )


@dataclass(frozen=True)
class PrintedSection:
    """A section by its title, and its displays in the order of print."""

    title: str
    displays: tuple[PrintedDisplay, ...]


@dataclass(frozen=True)
class PrintedSentence:
    """A sentence of the text, with ``$0$``, ``$1$`` in its ``words`` for its formulas.

    ``section`` is the title of its section, ``at`` its place in the body, ``number`` counts it as
    the displays do.
    """

    words: str
    formulas: tuple[str, ...]
    section: str
    at: int
    number: int

    def __str__(self) -> str:
        return self.with_formulas(self.words)

    def with_formulas(self, words: str) -> str:
        """Some of its words with the formulas in their slots."""
        return _SLOT.sub(lambda slot: f"${self.formulas[int(slot[1])]}$", words)


@dataclass(frozen=True)
class Document:
    """A paper as its file gives it."""

    source: TexSource
    title: str
    sections: tuple[PrintedSection, ...]
    body: MarkedText

    @property
    def displays(self) -> Iterator[PrintedDisplay]:
        """All displays and formulas of the text, in the order of print."""
        for section in self.sections:
            yield from section.displays

    @cached_property
    def sentences(self) -> tuple[PrintedSentence, ...]:
        """The sentences of the text, with what they say around formulas and in them."""
        return tuple(_sentences(self.body))


def read_document(path: str | Path) -> Document:
    """The paper in a LaTeX file; ``DefinitionError`` where it holds no formula."""
    source = read_tex(path)
    whole = source.body
    title = re.search(r"\\title\s*(?:\[[^]]*\])?\{((?:[^{}]|\{[^{}]*\})*)\}", whole.text)
    begin, end = whole.text.find("\\begin{document}"), whole.text.find("\\end{document}")
    start = 0 if begin < 0 else begin + len("\\begin{document}")
    body = whole[start : len(whole.text) if end < start else end]
    sections = tuple(_sections(body))
    if not any(section.displays for section in sections):
        raise DefinitionError(
            f"'{path}' holds no formula between $ or in a display of LaTeX; give the .tex file"
        )
    return Document(source, "" if title is None else _words(title[1]), sections, body)


def _words(text: str) -> str:
    return " ".join(re.sub(r"\\\\|\\[a-zA-Z]+\*?|[{}]", " ", text).split())


def _sections(body: MarkedText) -> Iterator[PrintedSection]:
    title, displays = "", list[PrintedDisplay]()
    text = body.text
    ends = [m.end() for m in _END_OF_SENTENCE.finditer(text)]
    for match in _PARTS.finditer(text):
        if match["title"] is not None:
            if displays:
                yield PrintedSection(title or "Beginning", tuple(displays))
            title, displays = _words(match["title"]), []
            continue
        kind = match.lastgroup
        if kind not in ("env", "name", "dollars", "bracket", "inline", "round"):
            continue
        sentence = bisect_right(ends, match.start())
        before = text[max([0, *ends[sentence - 1 : sentence]]) : match.start()]
        after = text[match.end() : max(match.end(), *ends[sentence : sentence + 1], 0)]
        shown = "text" if kind in ("inline", "round") else "display"
        latex, number = _readable(body[match.start() : match.end()])
        display = PrintedDisplay(latex, shown, number, before, after, sentence)
        if shown == "display" or display.formulas:
            displays.append(display)
    if displays:
        yield PrintedSection(title or "The paper", tuple(displays))


_SLOT = re.compile(r"\$(\d+)\$")
_REFERENCE = re.compile(r"\(?\\(?:eq)?ref\s*\{([^{}]*)\}\)?")
_ASIDE = re.compile(
    r"\\(?:title|author|date|thanks|cite\w*|label|begin|end|email|affiliation)\*?"
    r"(?:\[[^]]*\])?\{(?:[^{}]|\{[^{}]*\})*\}"
)
_LAST_STOP = re.compile(
    r"\.\s*(?:\\(?:eqno|tag|label|nonumber|hbox)\S*\s*)*"
    r"(?:\\end\{[^}]*\}\s*|\\right\s*\.|\\\]|\$\$?|\\eqno\S*\s*)*\Z"
)
"""A stop at the end of a display."""


ELLIPSIS = r"\ldots"
"""What a sentence quotes in the place of a display of several formulas."""


def _alone(latex: str) -> str:
    """The formula of a display that holds one."""
    try:
        pieces = [(unit, piece) for unit in split_display(latex) for piece in unit.pieces]
    except DefinitionError:
        return ELLIPSIS
    return source_of(pieces[0][1], pieces[0][0].display) if len(pieces) == 1 else ELLIPSIS


def _sentences(body: MarkedText) -> Iterator[PrintedSentence]:
    """The text cut at its stops, headings and empty lines; a formula is a slot."""
    text, title, words, position = body.text, "", "", 0
    start, formulas = -1, list[str]()
    ends = [m.end() for m in _END_OF_SENTENCE.finditer(text)]

    def sentence() -> Iterator[PrintedSentence]:
        nonlocal words, start, formulas
        said = _words(_ASIDE.sub(" ", _REFERENCE.sub(r"(\1)", words)).replace("~", " "))
        if re.search(r"[A-Za-z]{2}", said):
            yield PrintedSentence(said, tuple(formulas), title, start, bisect_right(ends, start))
        words, start, formulas = "", -1, []

    for match in (*_PARTS.finditer(text), None):
        if match is not None and match.lastgroup is None:
            continue
        gap = text[position : match.start() if match else len(text)]
        cuts = [0, *(m.end() for m in _END_OF_SENTENCE.finditer(gap)), len(gap)]
        for a, b in pairwise(cuts):
            if start < 0:
                start = position + a + len(gap[a:b]) - len(gap[a:b].lstrip())
            words += gap[a:b]
            if b < len(gap) or b in cuts[1:-1]:
                yield from sentence()
        if match is None or match.lastgroup in ("title", "skip"):
            yield from sentence()
            title = _words(match["title"]) if match and match["title"] is not None else title
        else:
            words += f" ${len(formulas)}$ "
            formulas.append(_alone(_readable(body[match.start() : match.end()])[0].text))
            if match["inline"] is match["round"] and _LAST_STOP.search(match[0]):
                yield from sentence()
        position = match.end() if match else position


_NUMBER = re.compile(
    r"\\(?:l?eqno)\s*(?:\{?\(([^)]*)\)\}?|\\hbox\{\(([^)]*)\)\})|\\tag\*?\{([^}]*)\}"
)
_SYSTEM = re.compile(
    r"(?:(?P<brace>\\left\s*\\(?:\{|lbrace)|\\\{)|\\left\s*\.)?\s*"
    r"\\begin\{(?P<name>cases|dcases|rcases|array|alignedat|aligned|matrix)\}"
    r"(?:\[[tbc]\])?(?:\{[^{}]*\})?"
    r"(?P<inside>(?:(?!\\begin\{).)*?)\\end\{(?P=name)\}\s*(?:\\right\s*(?:\.|\\\}|\\rbrace))?",
    re.DOTALL,
)
_CONDITION_MARK = re.compile(r"&(?=\s*(?!\\(?:text|mbox|mathrm|le|ge|ne)|[-=<>+&\s]|\\\\))")
_SPELLINGS = (
    (r"\\begin\{(?:alignat|xalignat)(\*?)\}\{\d\}", r"\\begin{align\1}"),
    (r"\\end\{(?:alignat|xalignat)(\*?)\}", r"\\end{align\1}"),
    (r"\\begin\{IEEEeqnarray(\*?)\}(?:\[[^]]*\])?\{[^{}]*\}", r"\\begin{eqnarray\1}"),
    (r"\\end\{IEEEeqnarray(\*?)\}", r"\\end{eqnarray\1}"),
    (r"(\\begin|\\end)\{dmath(\*?)\}", r"\1{equation\2}"),
    (r"\\begin\{empheq\}(?:\[[^]]*\])?\{(\w+\*?)\}", r"\\begin{\1}"),
    (r"\\(?:mathrm|operatorname)\{(diag|det|tr)\}", r"\\\1"),
    (r"\\in(?:\s*(?:\\times\s*)?\\?[a-z]*\s*\{?[A-Z]\}?\w*(?:\^\{?\w+\}?)?)+(?![\w\s]*[\^=])", ""),
    (r":\s*=", "="),
    (r"=\s*:", "="),
    (r"\\label\s*\{[^}]*\}", ""),
)


def _readable(display: MarkedText) -> tuple[MarkedText, str]:
    """A display as ``split_display`` takes it, and its label or number."""
    label = re.search(r"\\label\s*\{([^}]*)\}", display.text)
    printed = _NUMBER.search(display.text)
    number = label[1] if label else ""
    if printed:
        number = number or next((g for g in printed.groups() if g), "")
    while match := _NUMBER.search(display.text):
        display = display.put(*match.span(), "")
    for pattern, other in _SPELLINGS:
        while match := re.search(pattern, display.text):
            display = display.put(*match.span(), match.expand(other))
    if display.text.startswith("\\("):
        display = display.put(len(display.text) - 2, len(display.text), "$").put(0, 2, "$")
    display = _open_systems(display)
    return _fractions(display), number


def _open_systems(display: MarkedText) -> MarkedText:
    """Equations in braces become lines; what follows a sign of equality is a value by cases, with
    whatever brackets it is printed."""
    position = 0
    while match := _SYSTEM.search(display.text, position):
        lines = re.split(r"\\\\", match["inside"])
        value = display.text[: match.start()].rstrip().endswith("=")
        braced = match["brace"] is not None and match["name"] == "array"
        if (value and not braced) or not (value or all("=" in x for x in lines if x.strip())):
            position = match.end()
            continue
        a, b = match.span("inside")
        name = "cases" if value else "gathered"
        display = display.put(b, match.end(), f"\\end{{{name}}}")
        if match["name"].endswith("cases"):
            display = _with_conditions(display, a, b)
        display = display.put(match.start(), a, f"\\begin{{{name}}}")
        position = match.start() + 1
    return display


def _with_conditions(display: MarkedText, start: int, end: int) -> MarkedText:
    """What stands behind ``&`` in a line of ``cases``, and goes on with nothing, is a condition."""
    for mark in reversed([*_CONDITION_MARK.finditer(display.text, start, end)]):
        display = display.put(*mark.span(), r",\text{if }")
    return display


def _fractions(display: MarkedText) -> MarkedText:
    r"""``{a \over b}`` becomes ``{\frac{a}{b}}``."""
    while match := re.search(r"\\over(?![a-zA-Z])", display.text):
        text = display.text
        start, end = _group_around(text, match.start())
        display = display.put(end, end, "}").put(match.start(), match.end(), "}{")
        display = display.put(start, start, "\\frac{")
    return display


def _group_around(text: str, position: int) -> tuple[int, int]:
    """The inside of the group that holds a place; of the whole display where none does."""
    depth, start, end = 0, position, position
    while start > 0 and not (depth == 0 and text[start - 1] == "{"):
        depth += (text[start - 1] == "}") - (text[start - 1] == "{")
        start -= 1
    depth = 0
    while end < len(text) and not (depth == 0 and text[end] == "}"):
        depth += (text[end] == "{") - (text[end] == "}")
        end += 1
    if start == 0:
        opening = re.match(r"\$\$?|\\\[|\\begin\{[^}]*\}", text)
        closing = re.search(r"(?:\$\$?|\\\]|\\end\{[^}]*\})\Z", text)
        start = opening.end() if opening else 0
        end = closing.start() if closing else len(text)
    return start, end

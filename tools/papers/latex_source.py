r"""The sections of a LaTeX file with their displays and inline formulas, letter for letter.

Nothing is expanded or understood: a display is what stands between ``\begin{equation}`` (or one of
its like, ``\[``, ``$$``) and its end, wherever it stands, in a footnote too.  Comments are left
out.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from voronec.errors import DefinitionError

DISPLAYS = "equation eqnarray align alignat flalign gather multline displaymath dmath".split()
_COMMENT = re.compile(r"(?<!\\)((?:\\\\)*)%[^\n]*")
_TITLE = re.compile(r"\\(?:sub)*section\s*\*?\s*(?:\[[^\]]*\]\s*)?(?=\{)")
_MARK = re.compile(
    r"(?P<section>\\(?:sub)*section\b)"
    rf"|\\begin\s*\{{(?P<environment>(?:{'|'.join(DISPLAYS)})\*?)\}}"
    r"|(?P<bracket>\\\[)|(?P<round>\\\()|(?P<skip>\\.)|(?P<double>\$\$)|(?P<single>\$)",
    re.DOTALL,
)


@dataclass(frozen=True)
class Excerpt:
    """A formula with its delimiters, and the line of the file on which it starts."""

    latex: str
    line: int


@dataclass(frozen=True)
class SourceSection:
    """A section or subsection; ``title`` has single spaces, and is empty before the first.

    ``text`` is its source without comments.
    """

    title: str
    line: int
    displays: tuple[Excerpt, ...]
    inline: tuple[Excerpt, ...]
    text: str = ""


def read_sections(text: str) -> tuple[SourceSection, ...]:
    r"""The sections between ``\begin{document}`` and its end, in the order of print.

    Raises ``DefinitionError`` where there is no document, or where a formula does not end.
    """
    text = _COMMENT.sub(r"\1", text.replace("\r\n", "\n"))
    start, end = text.find("\\begin{document}"), text.find("\\end{document}")
    if start < 0:
        raise DefinitionError("the file has no \\begin{document}; give a whole LaTeX article")
    position = start + len("\\begin{document}")
    end = len(text) if end < 0 else end
    found = [_Open("", 1, [], [], position)]
    while match := _MARK.search(text, position, end):
        position = match.end()
        kind, line = match.lastgroup, text.count("\n", 0, match.start()) + 1
        if kind == "section":
            heading = _TITLE.match(text, match.start())
            if heading is None:
                continue
            title, position = _group(text, heading.end(), line)
            found.append(_Open(tidy(title), line, [], [], position))
        elif kind != "skip":
            closing = _closing(match)
            position = _end_of(text, match.end(), end, closing)
            if position < 0:
                raise DefinitionError(f"line {line}: '{match.group()}' has no '{closing}'")
            excerpt = Excerpt(text[match.start() : position], line)
            inline = kind in ("single", "round")
            (found[-1].inline if inline else found[-1].displays).append(excerpt)
    ends = [s.start for s in found[1:]] + [end]
    return tuple(
        SourceSection(s.title, s.line, tuple(s.displays), tuple(s.inline), text[s.start : stop])
        for s, stop in zip(found, ends, strict=True)
    )


def tidy(title: str) -> str:
    """A title with single spaces and without outer ones."""
    return " ".join(title.split())


@dataclass(frozen=True)
class _Open:
    """A section that is being read."""

    title: str
    line: int
    displays: list[Excerpt]
    inline: list[Excerpt]
    start: int


def _closing(match: re.Match[str]) -> str:
    if match["environment"]:
        return f"\\end{{{match['environment']}}}"
    return {"\\[": "\\]", "\\(": "\\)"}.get(match.group(), match.group())


def _end_of(text: str, position: int, end: int, closing: str) -> int:
    """Where a formula ends; ``-1`` where it does not.  A pair of backslashes is a line break."""
    mark = re.compile(re.escape(closing) + r"|\\.", re.DOTALL)
    for match in mark.finditer(text, position, end):
        if match.group() == closing:
            return match.end()
    return -1


def _group(text: str, position: int, line: int) -> tuple[str, int]:
    """What stands in the braces that open here, and where they end."""
    depth = 0
    for match in re.finditer(r"\\.|[{}]", text[position:], re.DOTALL):
        depth += {"{": 1, "}": -1}.get(match.group(), 0)
        if depth == 0:
            return text[position + 1 : position + match.start()], position + match.end()
    raise DefinitionError(f"line {line}: the braces of a section title do not end")

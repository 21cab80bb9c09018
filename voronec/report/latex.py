r"""A formula of the report in LaTeX: its parts coloured, long ones on several lines.

The source is kept letter for letter; colours and line breaks are put between its characters, where
the tree of boxes says that braces are balanced.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from voronec.errors import DefinitionError
from voronec.report.boxes import Box, read_boxes
from voronec.report.breaking import BINARY, RELATIONS, Broken, break_lines
from voronec.report.marks import Marks
from voronec.report.symbols import LETTERS, SIGNS

__all__ = ["display", "escape_text", "inline", "own_commands"]

SPARE = 1.15
"""How far the estimated width of a line may be over the limit before it is shrunk."""
_WIDTH = r"\ifdim\width>\linewidth\linewidth\else\width\fi"
_LABEL = re.compile(r"\\(?:label|tag)\s*\{[^}]*\}")
_SPECIAL = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_SPECIAL |= {c: f"\\{c}" for c in "_&%#${}"}
# signs and letters that pdflatex knows only by their commands
_SPECIAL |= {c: rf"\ensuremath{{\{n}}}" for n, c in (SIGNS | LETTERS).items() if not c.isascii()}


def display(
    latex: str, marks: Sequence[tuple[int, int]] = (), command: str = "", limit: float = 34.0
) -> str:
    """A displayed formula; ranges of its source in ``marks`` are arguments of ``command``.

    What is wider than ``limit``, in em, is broken into lines.  What is no formula is printed as
    its source.
    """
    try:
        box = read_boxes(latex)
    except DefinitionError:
        return f"\n\\texttt{{{escape_text(latex)}}}\n\n"
    broken = break_lines(box, limit)
    body = _body(latex, box, broken, _colours(box, marks, command, broken))
    if broken.width <= SPARE * limit:
        return f"\\[\n{body}\n\\]\n"
    shrunk = f"\\resizebox{{{_WIDTH}}}{{!}}{{$\\displaystyle\n{body}\n$}}"
    return f"\\begin{{center}}\n{shrunk}\n\\end{{center}}\n"


def inline(text: str) -> str:
    """Words with formulas between dollar signs."""
    pieces = text.split("$")
    if len(pieces) % 2 == 0 or "" in pieces[1::2]:  # signs that enclose no formula
        return escape_text(text)
    return "".join(
        _small(piece) if number % 2 else escape_text(piece) for number, piece in enumerate(pieces)
    )


def _small(latex: str) -> str:
    """A formula within a line."""
    try:
        box = read_boxes(latex)
    except DefinitionError:
        return f"\\texttt{{{escape_text(latex)}}}"
    return f"${_body(latex, box, break_lines(box, float('inf')), [])}$"


def own_commands(latex: str) -> set[str]:
    r"""Commands in a formula that LaTeX may not know, such as ``\diag`` of the paper's own."""
    try:
        return {box.text for box in _walk(read_boxes(latex)) if box.kind == "unknown"}
    except DefinitionError:
        return set()


def escape_text(text: str) -> str:
    """Plain text for LaTeX."""
    return "".join(_SPECIAL.get(c, c) for c in text)


def _walk(box: Box) -> Iterator[Box]:
    yield box
    for part in box.parts:
        yield from _walk(part)


def _body(latex: str, box: Box, broken: Broken, colours: list[tuple[int, int, str]]) -> str:
    """The formula with its line breaks and colours."""
    starts = [line[0].start for line in broken.lines[1:]]
    places = [(at, 1, "\\\\\n&\\quad ") for at in starts] + colours
    edges = [edge for fence in broken.opened for edge in (fence.parts[0], fence.parts[2])]
    text = _inserted(latex, places, edges)
    if starts:
        return f"\\begin{{aligned}}\n&{text}\n\\end{{aligned}}"
    return f"\\begin{{aligned}}\n{text}\n\\end{{aligned}}" if _bare_table(box, latex) else text


def _bare_table(box: Box, latex: str) -> bool:
    """Whether there are lines or cells outside any environment."""
    return box.kind == "table" and not latex.startswith("\\begin", box.start)


def _colours(
    box: Box, marks: Sequence[tuple[int, int]], command: str, broken: Broken
) -> list[tuple[int, int, str]]:
    """Where colours begin and end; they end before a line does, and begin again after."""
    breaks = [line[0].start for line in broken.lines[1:]]
    places: list[tuple[int, int, str]] = []
    for run in Marks.of(marks, box).runs(box):
        cuts = [at for at in breaks if run[0].start < at < run[-1].end]
        # an empty group keeps the space on the left of a sign
        sign = run[0].kind == "sign" and run[0].text in BINARY | RELATIONS
        places.append((run[0].start, 2, f"{{\\{command}{{" + ("{}" if sign else "")))
        for at in cuts:
            places += [(at, 0, "}}"), (at, 2, f"{{\\{command}{{{{}}")]
        places.append((run[-1].end, 0, "}}"))
    return places


def _inserted(latex: str, places: Sequence[tuple[int, int, str]], edges: Sequence[Box]) -> str:
    r"""The source with texts inserted; ``\left`` and ``\right`` of open fences are plain."""
    found, last = [], 0
    plain = {e.start: e for e in edges if latex.startswith(("\\left", "\\right"), e.start)}
    stops = sorted([*places, *((at, 3, "") for at in plain)])
    for at, order, text in stops:
        found.append(latex[last:at])
        last = at
        if order == 3:
            edge = plain[at]
            size = r"\bigl" if latex.startswith("\\left", at) else r"\bigr"
            shown = re.sub(r"\\(?:left|right)\s*", "", latex[at : edge.end])
            found.append("" if shown == "." else size + shown)
            last = edge.end
        found.append(text)
    found.append(latex[last:])
    return _LABEL.sub("", "".join(found)).strip()

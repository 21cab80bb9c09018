"""Compare the transcription of a paper with its LaTeX file, display by display.

    python tools/paper.py transcription FILE [--paper NAME] [--json]

Every display of the file has to be in the transcription, letter for letter and in order, and every
inline formula and every quoted sentence in its section of the file.  The exit status is 0 where all
is equal, 1 where something differs, 2 where an argument is wrong.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from difflib import SequenceMatcher
from pathlib import Path

from papers.latex_source import Excerpt, SourceSection, read_sections, tidy
from voronec.audit import Paper, Section
from voronec.declaration.catalogue import load_paper
from voronec.errors import DefinitionError

AROUND = 24
"""Characters that are shown on each side of a difference."""


@dataclass(frozen=True)
class Difference:
    """Something that is not equal: where, what, and what stands in both."""

    section: str
    place: str
    what: str
    source: str = ""
    transcribed: str = ""


@dataclass(frozen=True)
class Row:
    """The counts of one section."""

    title: str
    source: int
    transcribed: int
    inline: int
    inline_found: int
    equal: bool


@dataclass(frozen=True)
class Comparison:
    """The result: a row for each section with something in it, and the differences."""

    rows: tuple[Row, ...]
    differences: tuple[Difference, ...]


def compare(source: Sequence[SourceSection], paper: Paper) -> Comparison:
    """Compare all sections; those that have the same title are matched in order."""
    left = list(source)
    rows, differences, last = [], [], 0
    for section in paper.sections:
        match = next((s for s in left if s.title == tidy(section.title)), None)
        if match is None:
            match = SourceSection(tidy(section.title), 0, (), ())
            found = [Difference(match.title, "title", "the source has no section of this title")]
        else:
            left.remove(match)
            found = []
            if match.line < last:
                found = [Difference(match.title, f"line {match.line}", "the section is elsewhere")]
            last = match.line
        found += [*_displays(match, section), *_inline(match, section)]
        found += _sentences(match, section)
        rows.append(_row(match, section, found))
        differences += found
    for match in left:
        if match.displays:
            place = f"line {match.line}"
            found = [Difference(match.title, place, "this section is not in the transcription")]
            differences += found
            rows.append(Row(match.title, len(match.displays), 0, 0, 0, False))
    return Comparison(tuple(rows), tuple(differences))


def _row(source: SourceSection, section: Section, found: Sequence[Difference]) -> Row:
    missing = sum(d.place.startswith("inline") for d in found)
    inline = len(section.inline)
    counts = (len(source.displays), len(section.displays), inline, inline - missing)
    return Row(source.title, *counts, not found)


def _displays(source: SourceSection, section: Section) -> Iterator[Difference]:
    """Displays that are missing, that are too many, elsewhere, or not equal."""
    printed = [d.latex.strip() for d in source.displays]
    transcribed = [d.latex.strip() for d in section.displays]
    for tag, a, b, c, d in SequenceMatcher(None, printed, transcribed, False).get_opcodes():
        common = min(b - a, d - c) if tag == "replace" else 0
        for i, j in zip(range(a, a + common), range(c, c + common), strict=True):
            yield _difference(source.title, i, source.displays[i], transcribed[j])
        if tag == "equal":
            continue
        for i in range(a + common, b):
            what = "is not transcribed"
            if printed[i] in transcribed:
                what = f"is transcribed as display {transcribed.index(printed[i]) + 1}"
            yield Difference(source.title, _place(i, source.displays[i]), what, _cut(printed[i]))
        for j in range(c + common, d):
            if transcribed[j] not in printed:
                place = f"display {j + 1} of the transcription"
                what = "is not in the source"
                yield Difference(source.title, place, what, "", _cut(transcribed[j]))


def _place(position: int, excerpt: Excerpt) -> str:
    return f"display {position + 1}, line {excerpt.line}"


def _difference(title: str, position: int, excerpt: Excerpt, transcribed: str) -> Difference:
    """What differs between two displays, first place first."""
    printed = excerpt.latex.strip()
    ranges = [
        places
        for tag, *places in SequenceMatcher(None, printed, transcribed, False).get_opcodes()
        if tag != "equal"
    ]
    a, b, c, d = ranges[0]
    line = excerpt.line + printed.count("\n", 0, a)
    more = f", and in {len(ranges) - 1} more places" if len(ranges) > 1 else ""
    return Difference(
        title,
        f"display {position + 1}, line {line}",
        f"differs at its character {a + 1}{more}",
        _cut(printed, a, b),
        _cut(transcribed, c, d),
    )


def _cut(text: str, start: int = 0, end: int = 2 * AROUND) -> str:
    """The range of a text with what stands around it, on one line, line ends shown."""
    a, b = max(0, start - AROUND), min(len(text), end + AROUND)
    inner = text[a:b].replace("\n", "\u23ce")
    return ("..." if a else "") + inner + ("..." if b < len(text) else "")


def _inline(source: SourceSection, section: Section) -> Iterator[Difference]:
    known = {excerpt.latex for excerpt in source.inline}
    for position, formula in enumerate(section.inline, 1):
        latex = formula.latex.strip()
        if latex not in known:
            what = "is not a formula of this section's text"
            yield Difference(source.title, f"inline formula {position}", what, "", latex)


def _sentences(source: SourceSection, section: Section) -> Iterator[Difference]:
    """Quotations that do not stand in this section's text, spaces and line ends being alike."""
    text = tidy(source.text)
    for position, sentence in enumerate(section.sentences, 1):
        quotation = tidy(sentence.quotation)
        if quotation not in text:
            start = _longest(quotation, text)
            what = f"differs from this section's text at its character {start + 1}"
            place = f"quotation {position}"
            yield Difference(source.title, place, what, "", _cut(quotation, start, start))


def _longest(quotation: str, text: str) -> int:
    """How much of a quotation, from its beginning, stands in a text."""
    low, high = 0, len(quotation)
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if quotation[:middle] in text else (low, middle - 1)
    return low


def _table(comparison: Comparison) -> str:
    heads = ("displays", "transcribed", "inline", "found", "equal")
    width = max([len(row.title) for row in comparison.rows] + [len("section")])
    lines = [f"{'section':<{width}}  " + "  ".join(heads)]
    for row in comparison.rows:
        cells = (row.source, row.transcribed, row.inline, row.inline_found)
        numbers = "  ".join(f"{n:>{len(h)}}" for n, h in zip(cells, heads, strict=False))
        lines.append(f"{row.title:<{width}}  {numbers}  {'yes' if row.equal else 'NO'}")
    total = [sum(getattr(r, n) for r in comparison.rows) for n in ("source", "transcribed")]
    lines.append(f"{'':<{width}}  {total[0]:>8}  {total[1]:>11}")
    for found in comparison.differences:
        lines += ["", f"{found.section}: {found.place}: {found.what}"]
        lines += [f"  source       {found.source}"] if found.source else []
        lines += [f"  transcribed  {found.transcribed}"] if found.transcribed else []
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, print, and return the exit status."""
    parser = argparse.ArgumentParser(description="Compare a transcription with its LaTeX file.")
    parser.add_argument("file", help="the paper's LaTeX file")
    parser.add_argument("--paper", default="demchenko", help="the paper's name (%(default)s)")
    parser.add_argument("--json", action="store_true", help="print JSON")
    options = parser.parse_args(arguments)
    try:
        paper = load_paper(options.paper)
        source = read_sections(Path(options.file).read_text("utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        print(f"the file '{options.file}' cannot be read: {reason}", file=sys.stderr)
        return 2
    except DefinitionError as error:
        print(error, file=sys.stderr)
        return 2
    result = compare(source, paper)
    if options.json:
        found = {"paper": options.paper, "equal": not result.differences, **asdict(result)}
        print(json.dumps(found, indent=2, ensure_ascii=False))
    else:
        print(_table(result))
    return 1 if result.differences else 0

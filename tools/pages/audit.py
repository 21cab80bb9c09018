"""Rebuild the audit that the documentation carries: ``python tools/build.py audit``.

Audits Demchenko's paper, keeps the records and the figure in ``docs/audit/demchenko``, and puts the
counts and the errata into ``docs/audit.md``.  The page and the article are made of the records
wherever they are wanted, by ``write_pages``.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from voronec.audit import Audit, FormulaRecord, Paper, Record
from voronec.audit.page.phrases import (
    conventions_with_formulas,
    count_sentences,
    end_sentence,
    short,
    with_verdict,
)
from voronec.audit.page.report import Figure, write_audit
from voronec.cli import main as voronec
from voronec.declaration.catalogue import load, load_paper

PAPER = "demchenko"
DOCS = Path(__file__).resolve().parents[2] / "docs"
FOLDER = DOCS / "audit" / PAPER
PAGE = DOCS / "audit.md"
RESULTS = ("report.json", "trace.svg")
FROM, TO = "<!-- errata: tools/build.py audit -->", "<!-- end of errata -->"


def read_audit(folder: Path, paper: Paper) -> Audit:
    """The audit that the ``report.json`` of a folder holds."""
    entries = json.loads((folder / "report.json").read_text("utf-8"))
    records = tuple(
        Record(
            entry["label"],
            entry["section"],
            entry["ordinal"],
            entry["printed"],
            tuple(map(FormulaRecord.from_dict, entry["formulas"])),
            entry["kind"],
        )
        for entry in entries
    )
    return Audit(paper.name, paper.title, records, paper.references, paper.authors)


def summary(audit: Audit, paper: Paper) -> str:
    """Counts, errata and conventions in Markdown."""
    lines = [f"- {line}" for line in count_sentences(audit)]
    return "\n".join(
        [
            *lines,
            "",
            _numbers_note(paper),
            "",
            *_errata(audit),
            *_conventions(audit),
            *_unaudited_lines(audit),
        ]
    )


def _numbers_note(paper: Paper) -> str:
    """Why there are more records than displays."""
    displays = [display for section in paper.sections for display in section.displays]
    several = sum(len(display.units) > 1 for display in displays)
    records = sum(len(display.units) for display in displays)
    return (
        f"The LaTeX has {len(displays)} displays; {several} of them bear several numbers each, and "
        f"each number counts, hence {records} displayed equations."
    )


def _errata(audit: Audit) -> Iterator[str]:
    yield "### Errata"
    for number, (record, formula) in enumerate(with_verdict(audit, "misprint"), 1):
        yield f"\n{number}. `{record.designation}` in *{record.section}*:"
        if not formula.printed:
            yield f"   not true: {formula.says}"
        else:
            yield from _display("   for", formula.printed)
        if formula.correction is not None:
            yield from _display("\n   read", formula.correction)
        elif formula.derived:
            yield from _display("\n   instead", formula.derived)
        else:
            yield f"\n   {end_sentence(short(formula.method))}"


def _display(word: str, latex: str) -> Iterator[str]:
    yield f"{word}\n\n   ```math\n   {' '.join(latex.split())}\n   ```"


def _conventions(audit: Audit) -> Iterator[str]:
    found = list(conventions_with_formulas(audit))
    if found:
        yield "\n### Conventions and ranges"
    for number, (said, several) in enumerate(found, 1):
        mark = f"\n{number}."
        for record, formula in several:
            what = formula.says or f"$`{' '.join(formula.printed.split())}`$"
            yield f"{mark} `{record.designation}` in *{record.section}*: {what}\\"
            mark = "  "
        yield f"   {end_sentence(short(said))}"


def _unaudited_lines(audit: Audit) -> Iterator[str]:
    found = list(with_verdict(audit, "unaudited"))
    if found:
        yield "\n### Not audited"
    for number, (record, formula) in enumerate(found, 1):
        yield f"\n{number}. `{record.designation}` in *{record.section}*: {formula.says}\\"
        yield f"   {end_sentence(formula.method)}"


def paste(page: str, text: str) -> str:
    """The page with the text between its two marks."""
    before, rest = page.split(FROM)
    return f"{before}{FROM}\n{text}\n{TO}{rest.split(TO)[1]}"


def write_pages(folder: Path) -> None:
    """Write the page and the article of the records that are kept into a folder."""
    paper = load_paper(PAPER)
    figure = Figure(FOLDER / "trace.svg", load(PAPER).scenes["default"].caption)
    write_audit(read_audit(FOLDER, paper), folder, [figure])


def main() -> int:
    """Audit, write, paste; the exit status is that of the audit."""
    with TemporaryDirectory() as folder:
        status = voronec(["regenerate", PAPER, "--out", folder])
        for name in RESULTS if status in (0, 1) else ():
            shutil.copy(Path(folder) / name, FOLDER / name)
    if status in (0, 1):
        paper = load_paper(PAPER)
        audit = read_audit(FOLDER, paper)
        PAGE.write_text(paste(PAGE.read_text("utf-8"), summary(audit, paper)), "utf-8")
    return status

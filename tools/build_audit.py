"""Rebuild the audit that the documentation carries: ``python tools/build_audit.py``.

Audits Demchenko's paper into ``docs/audit/demchenko``, as ``voronec regenerate demchenko --out
docs/audit/demchenko`` does, and puts the counts and the errata into ``docs/audit.md``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from voronec.audit import Audit, FormulaRecord, Paper, Record
from voronec.catalogue import load_paper
from voronec.cli import main as voronec
from voronec.report.audit_words import counted, short, with_verdict

__all__ = ["FOLDER", "PAGE", "PAPER", "main", "pasted", "read_audit", "summary"]

PAPER = "demchenko"
DOCS = Path(__file__).resolve().parent.parent / "docs"
FOLDER = DOCS / "audit" / PAPER
PAGE = DOCS / "audit.md"
FROM, TO = "<!-- errata: tools/build_audit.py -->", "<!-- end of errata -->"


def read_audit(folder: Path, paper: Paper) -> Audit:
    """The audit that the ``report.json`` of a folder holds."""
    entries = json.loads((folder / "report.json").read_text("utf-8"))
    records = tuple(
        Record(
            entry["label"],
            entry["section"],
            entry["ordinal"],
            entry["printed"],
            tuple(map(_formula, entry["formulas"])),
            entry["kind"],
        )
        for entry in entries
    )
    return Audit(paper.name, paper.title, records, paper.references, paper.authors)


def _formula(entry: dict[str, Any]) -> FormulaRecord:
    values = dict(entry)
    for name in ("changes", "struck"):
        values[name] = tuple((a, b) for a, b in values[name])
    for name in ("quantifiers", "ranges"):
        values[name] = tuple(values[name])
    return FormulaRecord(**values)


def summary(audit: Audit) -> str:
    """Counts, errata and conventions in Markdown."""
    lines = [f"- {line}" for line in counted(audit)]
    return "\n".join([*lines, "", *_errata(audit), *_conventions(audit)])


def _errata(audit: Audit) -> Iterator[str]:
    yield "### Errata"
    for number, (record, formula) in enumerate(with_verdict(audit, "misprint"), 1):
        yield f"\n{number}. `{record.called}` in *{record.section}*:"
        if not formula.printed:
            yield f"   not true: {formula.says}"
        else:
            yield from _display("   for", formula.printed)
        if formula.correction is not None:
            yield from _display("\n   read", formula.correction)
        elif formula.derived:
            yield from _display("\n   instead", formula.derived)
        else:
            yield f"\n   {short(formula.method)}."


def _display(word: str, latex: str) -> Iterator[str]:
    yield f"{word}\n\n   ```math\n   {' '.join(latex.split())}\n   ```"


def _conventions(audit: Audit) -> Iterator[str]:
    found = list(with_verdict(audit, "convention"))
    if found:
        yield "\n### Conventions and ranges"
    for number, (record, formula) in enumerate(found, 1):
        what = formula.says or f"$`{' '.join(formula.printed.split())}`$"
        place = f"`{record.called}` in *{record.section}*"
        yield f"\n{number}. {place}: {what}\n   {short(formula.method)}."


def pasted(page: str, text: str) -> str:
    """The page with the text between its two marks."""
    before, rest = page.split(FROM)
    return f"{before}{FROM}\n{text}\n{TO}{rest.split(TO)[1]}"


def main() -> int:
    """Audit, write, paste; the exit status is that of the audit."""
    status = voronec(["regenerate", PAPER, "--out", str(FOLDER)])
    if status in (0, 1):
        audit = read_audit(FOLDER, load_paper(PAPER))
        PAGE.write_text(pasted(PAGE.read_text("utf-8"), summary(audit)), "utf-8")
    return status


if __name__ == "__main__":
    sys.exit(main())

"""The report of an audit: as files, and for the terminal.

Files are plain data, a page, a LaTeX article; the terminal has a line a record, errata and
conventions below.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from voronec.audit.page.article import audit_latex
from voronec.audit.page.html import Figure, audit_page
from voronec.audit.page.phrases import (
    about,
    conventions_with_formulas,
    count_sentences,
    end_sentence,
    faults,
    short,
    values,
    with_verdict,
)
from voronec.audit.record import Audit, FormulaRecord, Record
from voronec.declaration.whole_files import replace_file
from voronec.errors import DefinitionError

__all__ = ["Figure", "audit_summary", "audit_table", "write_audit"]


def _audit_json(audit: Audit) -> str:
    """The records as a JSON list: label, section, ordinal, printed, derived, verdict, correction,
    witness, method, and all formulas."""
    return json.dumps(audit.as_list(), indent=2, ensure_ascii=False) + "\n"


def write_audit(audit: Audit, folder: str | Path, figures: Sequence[Figure] = ()) -> list[Path]:
    """Write ``report.json``, ``report.html`` and ``report.tex``; return their paths.

    ``DefinitionError`` where the folder cannot be written.
    """
    texts = {
        "report.json": _audit_json(audit),
        "report.html": audit_page(audit, figures),
        "report.tex": audit_latex(audit),
    }
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            replace_file(target / name, text)
    except OSError as error:
        reason = error.strerror or str(error)
        raise DefinitionError(f"the folder '{folder}' cannot be written: {reason}") from None
    return [target / name for name in texts]


NAME = 22
"""The widest name of a record that keeps the columns straight."""
NEAR = 12
"""Characters shown before and after a change where a line holds both readings."""
SEVERAL = 8
"""At most so many formulas of one record are spelled out."""


def audit_summary(audit: Audit, width: int = 100, most: int = 12) -> str:
    """What was found, on one screen: the counts and, a line each, at most so many misprints.

    Plain text, no line longer than ``width``.
    """
    lines = [_cut(line, width) for line in count_sentences(audit)]
    # of a record with several the first
    wrong = {id(r): (r, f) for r, f in reversed([*with_verdict(audit, "misprint")])}
    several = [*reversed(wrong.values())]
    if several:
        lines += ["", "wrong in print"]
    for record, formula in several[:most]:
        if formula.correction is None or not formula.struck:
            what = formula.says or formula.printed
        else:
            (a, b), (c, d) = formula.struck[0], formula.changes[0]
            old = _context(formula.printed, a, b, NEAR)
            what = f"{old} -> {_context(formula.correction, c, d, NEAR)}"
        lines.append(_cut_line(f"  {record.designation}: {' '.join(what.split())}", width))
    if len(several) > most:
        lines.append(f"  and {len(several) - most} more")
    undecided = [r.designation for r in audit.records if r.verdict == "undecided"]
    if undecided:
        lines += ["", _cut(f"undecided: {', '.join(undecided)}", width)]
    return "\n".join(lines) + "\n"


def audit_table(audit: Audit, width: int = 100) -> str:
    """One line a record, grouped by section; misprints and conventions spelled out below.

    Plain text, no line longer than ``width``.
    """
    names = max((len(r.designation) for r in audit.records), default=0)
    lines: list[str] = []
    for section in audit.sections:
        lines += ["", _cut(section, width), "-" * min(width, len(section))]
        for record in (r for r in audit.records if r.section == section):
            lines += _lines(record, min(names, NAME), width)
    lines += ["", *(_cut(line, width) for line in count_sentences(audit))]
    for number, (record, formula) in enumerate(with_verdict(audit, "misprint"), 1):
        lines += ["", *_erratum(number, record, formula, width)]
    for said, several in conventions_with_formulas(audit):
        lines.append("")
        for record, formula in several:
            lines.append(_cut(f"convention: {_place(record)}", width))
            lines += _wrap(formula.says or formula.printed, "  ", width)
        lines += _wrap(end_sentence(short(said)), "  ", width)
    return "\n".join(lines).lstrip("\n") + "\n"


def _lines(record: Record, names: int, width: int) -> Iterator[str]:
    head = f"{record.designation:<{names}}  {record.verdict:<10}  "
    yield head + _cut("; ".join(f.printed or f.says for f in record.formulas), width - len(head))
    wrong = faults(record) if len(record.formulas) > 1 else ()
    for formula in wrong[:SEVERAL]:
        head = f"{'':<{names}}  {formula.verdict:<10}    "
        yield head + _cut(formula.printed or formula.says, width - len(head))
        yield from _reason(formula, names, width)
    if not wrong:
        yield from _reason(record.decisive, names, width)


def _reason(formula: FormulaRecord, names: int, width: int) -> list[str]:
    """Why a formula is neither proved nor refuted."""
    if formula.verdict != "undecided":
        return []
    return _wrap(end_sentence(short(formula.method)), " " * (names + 4), width)


def _cut(latex: str, width: int) -> str:
    text = " ".join(latex.split())
    return text if len(text) <= width else text[: max(width - 3, 10)] + "..."


def _wrap(text: str, indent: str, width: int) -> list[str]:
    """Words on lines of the width, the first after ``indent``, the others below its end."""
    lines, empty = [indent], True
    for word in text.split():
        if len(lines[-1]) + len(word) + 1 > width and not empty:
            lines, empty = [*lines, " " * len(indent)], True
        lines[-1] += word if empty else f" {word}"
        empty = False
    return [_cut_line(line, width) for line in lines]


def _cut_line(line: str, width: int) -> str:
    return line if len(line) <= width else line[: width - 3] + "..."


def _place(record: Record) -> str:
    return f"{record.designation} in '{record.section}'"


def _erratum(number: int, record: Record, formula: FormulaRecord, width: int) -> list[str]:
    lines = [_cut(f"erratum {number}: {_place(record)}", width)]
    if formula.says:
        lines += _wrap(formula.says, "  claim  ", width)
    if formula.correction is None:
        lines += _wrap(formula.printed, "  for    ", width) if formula.printed else []
        lines += _wrap(short(formula.method), "  ", width)
    else:
        for (a, b), (c, d) in zip(formula.struck, formula.changes, strict=True):
            lines.append(_cut_line(f"  for    {_context(formula.printed, a, b)}", width))
            lines.append(_cut_line(f"  read   {_context(formula.correction, c, d)}", width))
    return lines + [_cut_line(f"  {line}", width) for line in _witness(formula)]


def _context(latex: str, start: int, end: int, around: int = 24) -> str:
    """The change with a little of what stands around it."""
    a, b = max(0, start - around), min(len(latex), end + around)
    inner = " ".join(latex[a:b].split())
    return ("..." if a else "") + inner + ("..." if b < len(latex) else "")


def _witness(formula: FormulaRecord) -> list[str]:
    """The two values of a witness, in words."""
    witness = formula.witness
    if witness is None:
        return []
    lines = [f"{name:<10}  {short(value)}" for name, value in values(formula)]
    what = about(witness)
    return [lines[0] + (f"  ({what})" if what else ""), *lines[1:]] if lines else []

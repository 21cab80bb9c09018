"""The report of an audit: a table for the terminal, a page, a LaTeX article, and plain data."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from voronec.audit.record import Audit, FormulaRecord, Record
from voronec.errors import DefinitionError
from voronec.report.audit_latex import audit_latex
from voronec.report.audit_page import Figure, audit_page

__all__ = ["Figure", "audit_table", "write_audit"]


def audit_json(audit: Audit) -> str:
    """The records as a JSON list: label, section, ordinal, printed, derived, verdict, correction,
    witness, method, and all formulas."""
    return json.dumps(audit.as_list(), indent=2, ensure_ascii=False) + "\n"


def audit_table(audit: Audit, width: int = 100) -> str:
    """One line a display, misprints spelled out below; plain text of the given width."""
    lines = []
    for section in audit.sections:
        lines += ["", section, "-" * min(width, len(section))]
        for record in (r for r in audit.records if r.section == section):
            lines.append(_table_line(record, width))
            if len(record.formulas) > 1 and record.verdict in ("misprint", "undecided"):
                lines += [
                    f"      {f.verdict:<10}  {_cut(f.printed, width - 18)}" for f in record.formulas
                ]
    count = ", ".join(f"{n} {verdict}" for verdict, n in audit.count().items() if n)
    lines += ["", f"{len(audit.records)} displays: {count}"]
    for record in audit.errata:
        lines += ["", *_erratum(record)]
    return "\n".join(lines).lstrip("\n") + "\n"


def _table_line(record: Record, width: int) -> str:
    name = f"({record.label})" if record.label else f"display {record.ordinal}"
    head = f"{name:<14}  {record.verdict:<10}  "
    return head + _cut("; ".join(f.printed for f in record.formulas), width - len(head))


def _cut(latex: str, width: int) -> str:
    text = " ".join(latex.split())
    return text if len(text) <= width else text[: max(width - 3, 10)] + "..."


def _erratum(record: Record) -> list[str]:
    formula = record.decisive
    name = f"({record.label})" if record.label else f"display {record.ordinal} of {record.section}"
    lines = [f"erratum {name}"]
    for (a, b), (c, d) in zip(formula.struck, formula.changes, strict=True):
        lines.append(f"  for   {_context(formula.printed, a, b)}")
        lines.append(f"  read  {_context(formula.correction or '', c, d)}")
    lines += [f"  {line}" for line in witness_lines(formula)]
    return lines


def _context(latex: str, start: int, end: int) -> str:
    """The change with a little of what stands around it."""
    a, b = max(0, start - 24), min(len(latex), end + 24)
    return ("..." if a else "") + latex[a:b] + ("..." if b < len(latex) else "")


def witness_lines(formula: FormulaRecord) -> list[str]:
    """The two values of a witness, in words."""
    witness = formula.witness
    if witness is None:
        return []
    where = ", ".join(f"{k} = {v}" for k, v in witness.get("indices", {}).items())
    about = f" ({witness['about']})" if "about" in witness else ""
    lines = [f"as printed  {witness['printed']}{about}" + (f"  for {where}" if where else "")]
    return [*lines, f"derived     {witness['derived']}"]


@dataclass(frozen=True)
class _File:
    name: str
    text: str


def write_audit(audit: Audit, folder: str | Path, figures: Sequence[Figure] = ()) -> list[Path]:
    """Write ``report.json``, ``report.html`` and ``report.tex``; return their paths.

    ``DefinitionError`` where the folder cannot be written.
    """
    files = [
        _File("report.json", audit_json(audit)),
        _File("report.html", audit_page(audit, figures)),
        _File("report.tex", audit_latex(audit)),
    ]
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
        for file in files:
            (target / file.name).write_text(file.text, encoding="utf-8")
    except OSError as error:
        reason = error.strerror or str(error)
        raise DefinitionError(f"the folder '{folder}' cannot be written: {reason}") from None
    return [target / file.name for file in files]

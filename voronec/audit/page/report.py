"""The report of an audit as files: plain data, a page, a LaTeX article."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from voronec.audit.page.article import audit_latex
from voronec.audit.page.html import Figure, audit_page
from voronec.audit.page.table import audit_summary, audit_table
from voronec.audit.record import Audit
from voronec.declaration.whole_files import replace_file
from voronec.errors import DefinitionError

__all__ = ["Figure", "audit_json", "audit_summary", "audit_table", "write_audit"]


def audit_json(audit: Audit) -> str:
    """The records as a JSON list: label, section, ordinal, printed, derived, verdict, correction,
    witness, method, and all formulas."""
    return json.dumps(audit.as_list(), indent=2, ensure_ascii=False) + "\n"


def write_audit(audit: Audit, folder: str | Path, figures: Sequence[Figure] = ()) -> list[Path]:
    """Write ``report.json``, ``report.html`` and ``report.tex``; return their paths.

    ``DefinitionError`` where the folder cannot be written.
    """
    texts = {
        "report.json": audit_json(audit),
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

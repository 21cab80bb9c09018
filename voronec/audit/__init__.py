"""The audit of a paper: its formulas read from LaTeX and compared with what the engine derives."""

from __future__ import annotations

from voronec.algebra.normal import shorten
from voronec.audit.paper import Check, Convention, Display, Paper, Section
from voronec.audit.record import Audit, FormulaRecord, Record
from voronec.audit.run import audit_paper
from voronec.audit.study import Motion, Study
from voronec.audit.transcript import Transcript

__all__ = [
    "Audit",
    "Check",
    "Convention",
    "Display",
    "FormulaRecord",
    "Motion",
    "Paper",
    "Record",
    "Section",
    "Study",
    "Transcript",
    "audit_paper",
    "shorten",
]

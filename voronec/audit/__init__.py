"""The audit of a paper: its formulas read from LaTeX and compared with what the engine derives."""

from __future__ import annotations

from voronec.algebra.normal import shorten
from voronec.algebra.verdicts import Verdict
from voronec.audit.cache import Cache
from voronec.audit.display import Check, Convention, Display
from voronec.audit.meaning import direction
from voronec.audit.paper import Paper, Section
from voronec.audit.paper_audit import audit_paper, audit_section
from voronec.audit.record import Audit, FormulaRecord, Record
from voronec.audit.sentence import Sentence
from voronec.audit.slots import Interval, Quoted, Reference, one_of, tight
from voronec.audit.study import Motion, Range, Study
from voronec.audit.transcript import Transcript, formulas_by_label
from voronec.declaration.catalogue import load_paper

__all__ = [
    "Audit",
    "Cache",
    "Check",
    "Convention",
    "Display",
    "FormulaRecord",
    "Interval",
    "Motion",
    "Paper",
    "Quoted",
    "Range",
    "Record",
    "Reference",
    "Section",
    "Sentence",
    "Study",
    "Transcript",
    "Verdict",
    "audit_paper",
    "audit_section",
    "direction",
    "formulas_by_label",
    "load_paper",
    "one_of",
    "shorten",
    "tight",
]

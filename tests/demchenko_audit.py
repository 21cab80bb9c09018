"""The audit of Demchenko's paper: each section is audited once for all tests of a process."""

from __future__ import annotations

from functools import cache
from typing import Any

from voronec.audit import (
    Audit,
    Paper,
    Record,
    Section,
    audit_section,
    formulas_by_label,
    load_paper,
)


@cache
def paper() -> Paper:
    return load_paper("demchenko")


@cache
def labels() -> dict[str, list[Any]]:
    """The formulas of the whole paper, to which sentences refer."""
    return formulas_by_label(paper().sections)


@cache
def records_of(title: str) -> tuple[Record, ...]:
    """The records of the section of this title, as ``audit_paper`` makes them."""
    (section,) = (s for s in paper().sections if s.title == title)
    return tuple(audit_section(section, labels=labels()))


def audit_of(*sections: Section) -> Audit:
    """The audit of some sections of the paper."""
    records = [r for s in sections for r in records_of(s.title)]
    return Audit(paper().name, paper().title, tuple(records), paper().references, paper().authors)


def has_formula(record: Record) -> bool:
    """A display or a formula of the text, and no sentence."""
    return bool(record.formulas[0].printed)

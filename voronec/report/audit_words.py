"""What all reports of an audit say in the same words: verdicts, places, witnesses, lists."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from voronec.audit.record import VERDICTS, Audit, FormulaRecord, Record

__all__ = [
    "KINDS",
    "MEANING",
    "about",
    "counted",
    "counts",
    "faults",
    "point",
    "short",
    "sides",
    "with_verdict",
]

MEANING = {
    "proved": "the formula follows from the derived equations, exactly",
    "misprint": "it is false as printed; the correction, where one is given, is proved",
    "convention": "it is true under a convention, or in a range of the parameters, that is stated",
    "definition": "it introduces a name or a condition; checked by the formulas that use it",
    "cited": "a fact that the paper quotes, and that is not proved here",
    "undecided": "neither proved nor refuted",
}
KINDS = {"display": "displayed equations", "text": "in the text"}
DIGITS = 12
"""Digits of a decimal that are shown; the plain data hold them all."""


def short(value: str, digits: int = DIGITS) -> str:
    """A value with its decimals cut after ``digits`` significant digits, and dots for the rest."""

    def cut(match: re.Match[str]) -> str:
        whole, rest = match[1], match[2]
        leading = len(rest) - len(rest.lstrip("0")) if not whole.strip("0") else 0
        kept = max(digits - len(whole.lstrip("0")), 1) + leading
        return match.group() if len(rest) <= kept else f"{whole}.{rest[:kept]}..."

    return re.sub(r"(\d+)\.(\d+)", cut, value)


def about(witness: Mapping[str, Any]) -> str:
    """What the two values of a witness are values of, and for which indices; often nothing."""
    where = ", ".join(f"{k} = {v}" for k, v in witness.get("indices", {}).items())
    parts = [str(witness.get("about", "")), f"for {where}" if where else ""]
    return ", ".join(part for part in parts if part)


def sides(formula: FormulaRecord) -> tuple[str, str]:
    """What the two values of a witness are called: an inequality has two sides of equal right."""
    plain = formula.printed and not formula.ranges
    return ("as printed", "derived") if plain else ("left side", "right side")


def point(witness: Mapping[str, Any]) -> str:
    """The point of a witness on one line."""
    return ", ".join(f"{name} = {short(str(v), 6)}" for name, v in witness["point"].items())


def with_verdict(audit: Audit, verdict: str) -> Iterator[tuple[Record, FormulaRecord]]:
    """The formulas that have a verdict, each with its record, in the order of print."""
    for record in audit.records:
        for formula in record.formulas:
            if formula.verdict == verdict:
                yield record, formula


def faults(record: Record) -> tuple[FormulaRecord, ...]:
    """The formulas of a record that need a reader's attention."""
    return tuple(f for f in record.formulas if f.verdict in ("misprint", "undecided"))


def counts(audit: Audit) -> dict[str, dict[str, int]]:
    """kind -> verdict -> number of records, worst first, for the verdicts that occur."""
    found = {}
    for kind in KINDS:
        records = [r for r in audit.records if r.kind == kind]
        if records:
            found[kind] = {v: sum(r.verdict == v for r in records) for v in reversed(VERDICTS)}
    return found


def counted(audit: Audit) -> list[str]:
    """The counts, a sentence for each kind of record."""
    lines = []
    for kind, numbers in counts(audit).items():
        each = ", ".join(f"{n} {verdict}" for verdict, n in numbers.items() if n)
        lines.append(f"{sum(numbers.values())} {KINDS[kind]}: {each}")
    return lines

"""The verdicts of an audit, as values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

VERDICTS = (
    "definition",
    "proved",
    "cited",
    "unaudited",
    "convention",
    "not read",
    "unknown letters",
    "undecided",
    "misprint",
)
"""From harmless to worst; a display takes the worst of its formulas."""


@dataclass(frozen=True)
class FormulaRecord:
    """One formula and its verdict.

    ``printed``, ``derived`` and ``correction`` are LaTeX.  ``correction`` is ``None`` unless the
    verdict is misprint; ``changes`` are the ranges of characters of it that differ from print,
    ``struck`` those of ``printed`` that they replace.  ``witness`` gives a point and the values of
    both sides there.  ``quantifiers`` are the ranges of indices as printed.  ``says`` is the claim
    in words, where there is one.  ``ranges`` has an entry for each range of the parameters in which
    the claim was decided: range, statement, verdict (proved, refuted, undecided), method, witness.
    ``source`` is what the derived side was made from, where a verdict rests on one.
    """

    printed: str
    verdict: str
    method: str
    derived: str | None = None
    correction: str | None = None
    changes: tuple[tuple[int, int], ...] = ()
    struck: tuple[tuple[int, int], ...] = ()
    witness: dict[str, Any] | None = None
    quantifiers: tuple[str, ...] = ()
    says: str = ""
    ranges: tuple[dict[str, Any], ...] = ()
    source: str = ""

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> FormulaRecord:
        """The record that a dictionary of its fields holds, as JSON gives it back."""
        values = dict(entry)
        for name in ("changes", "struck"):
            values[name] = tuple((a, b) for a, b in values[name])
        for name in ("quantifiers", "ranges"):
            values[name] = tuple(values[name])
        return cls(**values)


@dataclass(frozen=True)
class Record:
    """What bears one number in print: the worst verdict of its formulas, and all of them.

    ``kind`` is ``display``, or ``text`` for a formula or a claim of the running text; ``ordinal``
    counts the records of a section, displays first.
    """

    label: str | None
    section: str
    ordinal: int
    printed: str
    formulas: tuple[FormulaRecord, ...]
    kind: str = "display"

    @property
    def designation(self) -> str:
        """The label in parentheses, or the place."""
        return designation_of(self.label, self.kind, self.ordinal)

    @property
    def verdict(self) -> str:
        """The worst verdict of the formulas."""
        return worst(f.verdict for f in self.formulas)

    @property
    def decisive(self) -> FormulaRecord:
        """The first formula that has the worst verdict."""
        return next(f for f in self.formulas if f.verdict == self.verdict)

    def as_dict(self) -> dict[str, Any]:
        """What ``report.json`` holds of it."""
        head, several = self.decisive, self.formulas
        derived = [f.derived for f in several if f.derived]
        return {
            "label": self.label,
            "section": self.section,
            "ordinal": self.ordinal,
            "kind": self.kind,
            "printed": self.printed,
            "derived": " \\\\ ".join(derived) or None,
            "verdict": self.verdict,
            "correction": head.correction,
            "witness": head.witness,
            "method": head.method,
            "source": head.source,
            "formulas": [asdict(f) for f in several],
        }


@dataclass(frozen=True)
class Audit:
    """All records of a paper, whose name, title and authors these are; ``references`` are keys of
    the bibliography."""

    paper: str
    title: str
    records: tuple[Record, ...]
    references: tuple[str, ...] = ()
    authors: str = ""

    def count(self) -> dict[str, int]:
        """How many records have each verdict."""
        return {v: sum(r.verdict == v for r in self.records) for v in reversed(VERDICTS)}

    @property
    def errata(self) -> tuple[Record, ...]:
        """The records with a misprint."""
        return tuple(r for r in self.records if r.verdict == "misprint")

    @property
    def sections(self) -> tuple[str, ...]:
        """Titles of the sections, each once."""
        return tuple(dict.fromkeys(r.section for r in self.records))

    def as_list(self) -> list[dict[str, Any]]:
        """The records as JSON can hold them."""
        return [r.as_dict() for r in self.records]


def designation_of(label: str | None, kind: str, ordinal: int) -> str:
    """How a record is called: by its label in parentheses, or by its place."""
    return f"({label})" if label else f"{kind} {ordinal}"


def worst(verdicts: Iterable[str]) -> str:
    """The worst of some verdicts."""
    listed: Sequence[str] = list(verdicts)
    return max(listed, key=VERDICTS.index) if listed else "undecided"

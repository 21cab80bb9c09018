"""What a check found, as data that JSON can hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

SEVERITY = ("broken", "refuted", "undecided", "numeric", "no claims", "proved")
"""Every status, the gravest first.  ``numeric`` is undecided, with numbers that agree."""


@dataclass(frozen=True)
class Finding:
    """One statement with its status.

    ``admitted`` is the reason why it may stay undecided; where it is decided all the same, that
    is out of date, and a failure.  ``remark`` says that it corrects a print,
    or that it stands up to a period, or on a domain.
    """

    kind: str
    name: str
    status: str
    how: str = ""
    admitted: str = ""
    remark: str = ""

    @property
    def stale(self) -> bool:
        """Whether it is declared undecided, and is not."""
        return bool(self.admitted) and self.status in ("proved", "refuted")

    @property
    def fails(self) -> bool:
        """Whether a check with this finding fails."""
        if self.stale:
            return True
        if self.status in ("undecided", "numeric"):
            return not self.admitted
        return self.status in ("broken", "refuted")


@dataclass(frozen=True)
class Result:
    """What was found of one system, relation or square, declared in the file ``place``.

    ``notes`` are words on it: of what kind a relation is.  ``reused`` says that an earlier check
    found it.
    """

    kind: str
    name: str
    place: str
    findings: tuple[Finding, ...]
    seconds: float = 0.0
    notes: tuple[str, ...] = ()
    systems: tuple[str, ...] = ()
    reused: bool = False

    @property
    def status(self) -> str:
        """The gravest status of its findings; ``no claims`` where there are none."""
        return worst(self.findings)

    @property
    def failures(self) -> tuple[Finding, ...]:
        """The findings that make a check fail."""
        return tuple(f for f in self.findings if f.fails)

    def as_dict(self) -> dict[str, Any]:
        """Everything, with the status."""
        return asdict(self) | {"status": self.status}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Result:
        """The result that ``as_dict`` wrote."""
        given = {k: v for k, v in data.items() if k != "status"}
        given["findings"] = tuple(Finding(**f) for f in given["findings"])
        given["notes"], given["systems"] = tuple(given["notes"]), tuple(given["systems"])
        return cls(**given)


@dataclass(frozen=True, repr=False)
class Report:
    """All results of a check; ``stopped`` says that it was ended by hand before it was done."""

    results: tuple[Result, ...]
    seconds: float
    stopped: bool = False

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {status}" for status, n in self.count().items())
        ended = ", stopped" if self.stopped else ""
        return f"Report({len(self.results)} results: {counts}{ended})"

    def of_kind(self, kind: str) -> list[Result]:
        """The results of systems, relations or squares."""
        return [r for r in self.results if r.kind == kind]

    @property
    def failures(self) -> Iterator[tuple[Result, Finding]]:
        """Everything that makes the check fail."""
        return ((r, f) for r in self.results for f in r.failures)

    @property
    def passed(self) -> bool:
        """Whether nothing failed and nothing is left to do."""
        return not self.stopped and not any(True for _ in self.failures)

    def count(self) -> dict[str, int]:
        """How many findings there are of each status."""
        return dict(Counter(f.status for r in self.results for f in r.findings))

    def as_dict(self) -> dict[str, Any]:
        """Everything, as data."""
        return {
            "passed": self.passed,
            "stopped": self.stopped,
            "seconds": round(self.seconds, 3),
            "count": self.count(),
            **{f"{k}s": [r.as_dict() for r in self.of_kind(k)] for k in KINDS},
            "failures": [failure_line(r, f) for r, f in self.failures],
        }


KINDS = ("system", "relation", "square")


def failure_line(result: Result, finding: Finding) -> str:
    """A failure in one line: what, where, why."""
    what = f"{result.kind} '{result.name}'"
    if finding.name and finding.name != result.name:
        what += f": {finding.kind} '{finding.name}'"
    how = f": {finding.how}" if finding.how else ""
    if finding.stale:
        how = f", but is listed under undecided=; take it out there{how}"
    return " ".join(f"{what} is {finding.status} ({result.place}){how}".split())


def worst(findings: Sequence[Finding]) -> str:
    """The gravest status; what is admitted counts, and still shows."""
    return min((f.status for f in findings), key=SEVERITY.index, default="no claims")


def mark_as_known(result: Result) -> Result:
    """The result as one that an earlier check found."""
    return replace(result, reused=True)

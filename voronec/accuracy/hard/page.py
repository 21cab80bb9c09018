"""The page of the hard cases: the table, and what is hard about each case.

Findings are lines of text, data, and rows of the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import Any

from voronec.accuracy.hard.case import HardCase
from voronec.accuracy.hard.trial import CaseResult, Trial
from voronec.motion.methods import METHODS


def sections(findings: Sequence[CaseResult]) -> dict[str, str]:
    """What a page shows, as Markdown: the table, the count of each method, what is hard."""
    return {
        "table": f"Of {summary(findings)}.\n\n## Method against case\n\n{_table(findings)}",
        "methods": _grid([list(TALLY), *tally(findings)]),
        "cases": f"## What is hard\n\n{_cases(findings)}",
    }


def page(findings: Sequence[CaseResult]) -> str:
    """The page as Markdown; what its columns say stands in docs/hard-cases.md."""
    return "\n\n".join(["# Hard cases", *sections(findings).values()])


def _table(findings: Sequence[CaseResult]) -> str:
    rows = [["case", *HEADINGS]]
    for finding in findings:
        link = f"[{finding.case.name}](#{finding.case.name})"
        rows += [[link if i == 0 else "", *cells(t)] for i, t in enumerate(finding.trials)]
    return _grid(rows)


def _grid(rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown, headings first."""
    ruled = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
    return "\n".join(f"| {' | '.join(_plain(cell) for cell in row)} |" for row in ruled)


def _cases(findings: Sequence[CaseResult]) -> str:
    return "\n".join(line for finding in findings for line in _case(finding))


def _case(finding: CaseResult) -> list[str]:
    case, known = finding.case, finding.reference
    start, end = case.scene.times
    settings = [f"{k} = {x}" for k, x in {**case.scene.parameters, **case.scene.initial}.items()]
    made = "No reference: only a refusal is right."
    if known is not None:
        made = f"Reference: {known.provenance}; the two agree to {known.accuracy:.0e}."
    growth = " Errors grow exponentially." if case.chaotic else ""
    return [
        f"### {case.name}\n",
        f"{case.hard}{growth}\n",
        f"- [{case.system}](systems/{case.system}.md), t from {start} to {end}, outputs "
        f"{', '.join(f'`{o}`' for o in case.scene.outputs)}",
        f"- {', '.join(f'`{s}`' for s in settings)}",
        f"- {made}\n",
    ]


def _plain(cell: str) -> str:
    return cell.replace("|", "\\|")


HEADINGS = ("method", "error", "condition", "roundings", "drift", "seconds", "verdict")
VERDICTS = ("met", "kept", "refused", "missed", "lost")
TALLY = ("method", "cases", *VERDICTS, "roundings, median", "roundings, worst", "missed or lost")
WIDTHS = (16, 9, 9, 9, 9, 9)
"""Of columns of the table in a terminal; the last has the rest of the line."""


def cells(trial: Trial) -> list[str]:
    """One trial under ``HEADINGS``; a refusal has its reason in place of numbers."""
    automatic = trial.method in ("auto", "default") and trial.chosen
    method = f"{trial.chosen} ({trial.method})" if automatic else trial.method
    told = f"{trial.verdict}: {trial.reason}" if trial.reason else trial.verdict
    if trial.verdict == "missed" and trial.worst:
        told += f" in {trial.worst}"
    numbers = (trial.error, trial.condition, trial.roundings, trial.drift)
    return [method, *(_show(x, ".1e") for x in numbers), _show(trial.seconds, ".2g"), told]


def _show(x: float, digits: str) -> str:
    return "-" if x != x else format(x, digits)


def head(cases: Sequence[HardCase]) -> str:
    """The line above the table."""
    return _align(_width(cases), "case", HEADINGS)


def lines(finding: CaseResult, cases: Sequence[HardCase]) -> list[str]:
    """The rows of one case, aligned with those of the others."""
    width = _width(cases)
    return [_align(width, finding.case.name, cells(t)) for t in finding.trials]


def _width(cases: Sequence[HardCase]) -> int:
    return max((len(c.name) for c in cases), default=0)


def _align(width: int, name: str, row: Sequence[str]) -> str:
    inner = (w.ljust(n) for w, n in zip(row, WIDTHS, strict=False))
    return "  ".join([name.ljust(width), *inner, row[-1]])


def data(finding: CaseResult) -> dict[str, Any]:
    """One case for JSON."""
    case, known = finding.case, finding.reference
    return {
        "case": case.name,
        "system": case.system,
        "hard": case.hard,
        "chaotic": case.chaotic,
        "times": [float(t) for t in case.scene.times],
        "reference": None if known is None else known.provenance,
        "agreed": None if known is None else known.accuracy,
        "good": finding.good,
        "trials": [t.as_dict() for t in finding.trials],
    }


def summary(findings: Sequence[CaseResult]) -> str:
    """What came out, in a line."""
    choices = [t for f in findings for t in f.trials if t.automatic]
    counts = {v: sum(t.verdict == v for t in choices) for v in ("met", "kept", "refused")}
    wrong = [t.case for t in choices if not t.good]
    if not choices:
        return "the tool's own choice took no part"
    told = ", ".join(f"{n} {v}" for v, n in counts.items() if n)
    silent = f"silently wrong: {', '.join(wrong)}" if wrong else "nothing silently wrong"
    return f"the tool's own choice on {len(choices)} cases: {told or 'none good'}; {silent}"


def tally(findings: Sequence[CaseResult]) -> list[list[str]]:
    """For every method: on how many cases it was tried, and what came out, with the worst."""
    groups: dict[str, list[Trial]] = {}
    for trial in (t for f in findings for t in f.trials):
        groups.setdefault(trial.method, []).append(trial)
        if trial.automatic and trial.chosen in METHODS:
            groups.setdefault(trial.chosen, []).append(trial)
    rows = []
    for method in ("auto", "default", *METHODS):
        trials = groups.get(method, [])
        counts = [sum(t.verdict == v for t in trials) for v in VERDICTS]
        made = [t.roundings for t in trials if t.roundings == t.roundings]
        numbers = (f"{median(made):.1e}", f"{max(made):.1e}") if made else ("-", "-")
        missed = ", ".join(t.case for t in trials if t.verdict in ("missed", "lost"))
        if trials:
            rows.append([method, *map(str, (len(trials), *counts)), *numbers, missed or "-"])
    return rows

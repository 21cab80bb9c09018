"""Findings as lines of text, as data, and as rows for a page."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import Any

from voronec.accuracy.hard.case import HardCase
from voronec.accuracy.hard.run import CaseResult
from voronec.accuracy.hard.trial import Trial
from voronec.motion.methods import METHODS

__all__ = ["HEADINGS", "TALLY", "cells", "data", "head", "lines", "summary", "tally"]

HEADINGS = ("method", "error", "condition", "roundings", "drift", "seconds", "verdict")
VERDICTS = ("met", "kept", "refused", "missed", "lost")
TALLY = ("method", "cases", *VERDICTS, "roundings, median", "roundings, worst", "missed or lost")
WIDTHS = (16, 9, 9, 9, 9, 9)


def cells(trial: Trial) -> list[str]:
    """One trial under ``HEADINGS``; a refusal has its reason in place of numbers."""
    own = trial.method in ("auto", "default") and trial.chosen
    method = f"{trial.chosen} ({trial.method})" if own else trial.method
    told = f"{trial.verdict}: {trial.reason}" if trial.reason else trial.verdict
    if trial.verdict == "missed" and trial.worst:
        told += f" in {trial.worst}"
    numbers = (trial.error, trial.condition, trial.roundings, trial.drift)
    return [method, *map(_short, numbers), _seconds(trial.seconds), told]


def _short(x: float) -> str:
    return "-" if x != x else f"{x:.1e}"


def _seconds(x: float) -> str:
    return "-" if x != x else f"{x:.2g}"


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
        "reference": None if known is None else known.made,
        "agreed": None if known is None else known.agreed,
        "good": finding.good,
        "trials": [t.as_dict() for t in finding.trials],
    }


def summary(findings: Sequence[CaseResult]) -> str:
    """What came out, in a line."""
    own = [t for f in findings for t in f.trials if t.automatic]
    counts = {v: sum(t.verdict == v for t in own) for v in ("met", "kept", "refused")}
    wrong = [t.case for t in own if not t.good]
    if not own:
        return "the tool's own choice took no part"
    told = ", ".join(f"{n} {v}" for v, n in counts.items() if n)
    silent = f"silently wrong: {', '.join(wrong)}" if wrong else "nothing silently wrong"
    return f"the tool's own choice on {len(own)} cases: {told or 'none good'}; {silent}"


def tally(findings: Sequence[CaseResult]) -> list[list[str]]:
    """For every method: on how many cases it was tried, and what came out, with the worst."""
    groups: dict[str, list[Trial]] = {}
    for trial in (t for f in findings for t in f.trials):
        groups.setdefault(trial.method, []).append(trial)
        if trial.automatic and trial.chosen in METHODS:
            groups.setdefault(trial.chosen, []).append(trial)
    rows = []
    for method in ("auto", "default", *METHODS):
        found = groups.get(method, [])
        counts = [sum(t.verdict == v for t in found) for v in VERDICTS]
        made = [t.roundings for t in found if t.roundings == t.roundings]
        numbers = (f"{median(made):.1e}", f"{max(made):.1e}") if made else ("-", "-")
        missed = ", ".join(t.case for t in found if t.verdict in ("missed", "lost"))
        if found:
            rows.append([method, *map(str, (len(found), *counts)), *numbers, missed or "-"])
    return rows

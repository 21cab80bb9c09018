"""Rebuild the hard cases: ``python tools/build.py hard-cases [--references] [CASE ...]``.

Runs all methods on all cases and puts the tables between their marks in ``docs/hard-cases.md``.
With ``--references`` the references of this package's cases are computed anew first, those of the
named cases only where some are named; that takes heyoka.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from time import perf_counter

from figures.table import fill

from voronec.accuracy.hard import CASES, named_cases, trials
from voronec.accuracy.hard.page import sections
from voronec.accuracy.hard.reference import STORE, compute

PAGE = Path(__file__).resolve().parents[2] / "docs" / "hard-cases.md"


def store_references(names: list[str]) -> None:
    """Compute the references of the named cases, or of all, and store each when it is there."""
    for case in named_cases(names, CASES) if names else CASES:
        if not case.formulation:
            continue
        began = perf_counter()
        found = compute(case)
        known = json.loads(STORE.read_text("utf-8")) if STORE.exists() else {}
        stored = {c.name: known[c.name] for c in CASES if c.name in known}
        stored[case.name] = {"digest": case.digest, **found.as_dict()}
        lines = (f"{json.dumps(n)}: {json.dumps(stored[n])}" for n in sorted(stored))
        STORE.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")
        print(
            f"{case.name}: {found.provenance}, agreed to {found.accuracy:.1e}, condition "
            f"{found.largest_condition:.1e}, {perf_counter() - began:.0f} s",
            flush=True,
        )


def main() -> int:
    """References where asked for, and the page."""
    arguments = sys.argv[1:]
    if "--references" in arguments:
        store_references([a for a in arguments if a != "--references"])
    findings = list(trials(CASES, progress=lambda line: print(line, flush=True)))
    text = fill(PAGE.read_text("utf-8"), sections(findings), "tools/build.py hard-cases")
    PAGE.write_text(text, "utf-8")
    return 0 if all(f.good for f in findings) else 1

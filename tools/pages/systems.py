"""Rebuild the pages of the systems: ``python tools/build.py pages [NAME ...]``.

Checks the catalogue and writes, under ``docs/systems``, ``results.json`` with every verdict, a
page for each system, the index, and the picture of the diagram.  With names of systems these are
checked, with their relations and squares; other verdicts, and pages of systems that none of them is
related to, stay as they are.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from pages.system_page import index_page, system_page
from voronec.cli import main as voronec
from voronec.declaration.bibliography import bibtex
from voronec.proof.check import Inventory, Result, check_catalogue, failure_line, user_store
from voronec.proof.check.unit import units_of

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "systems"
RESULTS = "results.json"


def pages(stock: Inventory, results: Sequence[Result], names: Sequence[str] = ()) -> dict[str, str]:
    """The pages by the names of their files: the index, and those of all systems or of some."""
    own = {r.name: r for r in results if r.kind == "system"}
    edges = [r for r in results if r.kind == "relation"]
    systems = [s for n, s in sorted(stock.systems.items()) if stock.entries[n].distribution == OWN]
    found = {"README.md": index_page(systems, {s.name: own[s.name] for s in systems})}
    for system in [s for s in systems if not names or s.name in names]:
        near = [r for r in edges if system.name in {n.partition("@")[0] for n in r.systems}]
        found[f"{system.name}.md"] = system_page(
            system, own[system.name], near, bibtex(system.references)
        )
    return found


OWN = "voronec"


def read_results() -> list[Result]:
    """The results on which the committed pages rest."""
    entries = json.loads((FOLDER / RESULTS).read_text("utf-8"))
    return [*map(Result.from_dict, entries)]


def _without_times(result: Result) -> Result:
    """A result without what differs from run to run."""
    return replace(result, seconds=0.0, reused=False, place=Path(result.place).name)


def main() -> int:
    """Check, and write everything, or what has to do with some systems."""
    stock, names = Inventory.of(), sys.argv[1:]
    report = check_catalogue(names, stock=stock, store=user_store())
    for result, finding in report.failures:
        print(failure_line(result, finding))
    results = [_without_times(r) for r in report.results]
    touched = {n.partition("@")[0] for r in results for n in r.systems} if names else set()
    if names:
        known = {(r.kind, r.name): r for r in (*read_results(), *results)}
        results = [known[unit.kind, unit.name] for unit in units_of(stock)]
    texts = pages(stock, results, sorted(touched))  # before anything old goes: this takes long
    FOLDER.mkdir(exist_ok=True)
    for old in FOLDER.glob("*.md"):
        if not names and old.name not in texts:
            old.unlink()
    entries = [r.as_dict() for r in results]
    (FOLDER / RESULTS).write_text(json.dumps(entries, indent=1) + "\n", "utf-8")
    for name, text in texts.items():
        (FOLDER / name).write_text(text, "utf-8")
    voronec(["graph", "--out", str(FOLDER / "graph.svg")])
    print(f"{len(results)} results in {FOLDER}")
    return 0 if report.passed else 1

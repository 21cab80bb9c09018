"""``voronec list``: the systems and the papers.

Every system is loaded, to say what it is; one that fails is a warning and a mark.
"""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from voronec.catalogue import Entry, entries, names, papers
from voronec.cli.output import columns, print_json, warn
from voronec.errors import DefinitionError

__all__ = ["execute"]


def execute(arguments: Namespace) -> int:
    """Print the catalogue."""
    if arguments.names:
        found = names()
        print_json(found) if arguments.json else print("\n".join(found))
        return 0
    known, warnings = entries()
    rows = [_row(entry) for entry in known]
    if arguments.json:
        print_json({"systems": rows, "papers": papers(), "warnings": list(warnings)})
        return 0
    for message in (*warnings, *(row["trouble"] for row in rows if row["trouble"])):
        warn(message)
    with_paper = papers()
    for line in columns([row["name"], row["title"], _mark(row, with_paper)] for row in rows):
        print(line)
    return 0


def _row(entry: Entry) -> dict[str, Any]:
    row: dict[str, Any] = {"name": entry.name, "distribution": entry.distribution}
    try:
        system = entry.load()
    except DefinitionError as error:
        return row | {"title": "", "claims": 0, "scenes": [], "trouble": str(error)}
    claims = len(system.integrals) + bool(system.measure is not None) + bool(system.invariants)
    title = system.title or system.description
    return row | {"title": title, "claims": claims, "scenes": [*system.scenes], "trouble": ""}


def _mark(row: dict[str, Any], with_paper: list[str]) -> str:
    if row["trouble"]:
        return "broken"
    words = [
        f"{row['claims']} claim{'s' * (row['claims'] != 1)}" if row["claims"] else "unvalidated"
    ]
    if row["name"] in with_paper:
        words.append("paper")
    if row["distribution"] != "voronec":
        words.append(f"from {row['distribution']}")
    return ", ".join(words)

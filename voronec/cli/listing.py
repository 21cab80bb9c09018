"""``voronec list``: the systems and the papers.

A system that fails, or whose relations are wrong at sight, is a warning and a mark.
"""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING, Any

from voronec.algebra.columns import columns
from voronec.cli.output import answer, warn
from voronec.declaration.catalogue import Entry, entries, names, papers

if TYPE_CHECKING:
    from voronec.proof.check import Inventory, Trouble


def execute(arguments: Namespace) -> int:
    """Print the catalogue."""
    if arguments.names:
        listed = names()
        answer(arguments.json, lambda: listed, listed)
        return 0
    from voronec.proof.check import Inventory

    warnings = entries()[1]
    stock, with_paper = Inventory.of(), papers()
    rows = [_row(stock, entry) for entry in stock.entries.values()]
    if not arguments.json:
        for message in (*warnings, *(row["trouble"] for row in rows if row["trouble"])):
            warn(message)
    answer(
        arguments.json,
        lambda: {"systems": rows, "papers": with_paper, "warnings": list(warnings)},
        columns([row["name"], row["title"], _mark(row, with_paper)] for row in rows),
    )
    return 0


def _row(stock: Inventory, entry: Entry) -> dict[str, Any]:
    """What there is to say of a system."""
    row: dict[str, Any] = {"name": entry.name, "distribution": entry.distribution}
    summary = stock.contents.systems.get(entry.name)
    # A name that is hidden is a warning of the catalogue; the system that stands is sound.
    wrong = [t for t in stock.all_troubles if t.owner == entry.name and t.place == entry.place]
    trouble = "; ".join(t.why if t.kind == "system" else _trouble_line(t) for t in wrong)
    if summary is None:
        return row | {"title": "", "claims": 0, "relations": 0, "scenes": [], "trouble": trouble}
    return row | {
        "title": summary.title,
        "claims": summary.claims,
        "relations": sum(entry.name in (r.source, r.target) for r in stock.relations),
        "scenes": [*summary.scenes],
        "trouble": trouble,
    }


def _trouble_line(trouble: Trouble) -> str:
    return f"{trouble.kind} '{trouble.name}' in {trouble.place}: {trouble.why}"


def _mark(row: dict[str, Any], with_paper: list[str]) -> str:
    if row["trouble"]:
        return "broken"
    counted = [(row["claims"], "claim"), (row["relations"], "relation")]
    words = [f"{n} {word}{'s' * (n != 1)}" for n, word in counted if n] or ["no claims"]
    if row["name"] in with_paper:
        words.append("paper")
    if row["distribution"] != "voronec":
        words.append(f"from {row['distribution']}")
    return ", ".join(words)

"""``voronec list``: the systems and the papers.

Every system is loaded once, to say what it is; what it says is kept, and told again while its files
and those that read them are unchanged.  One that fails, or whose relations are wrong at sight, is a
warning and a mark.
"""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING, Any

from voronec.cli.output import columns, print_json, warn
from voronec.declaration.catalogue import Entry, entries, names, papers

if TYPE_CHECKING:
    from voronec.proof.check import Inventory, Trouble

__all__ = ["execute"]

KEPT = 4
"""Catalogues that are remembered: of a few environments that share a home."""
DECIDER = "voronec.proof.check.inventory"
"""The module that loads systems and their relations."""


def execute(arguments: Namespace) -> int:
    """Print the catalogue."""
    if arguments.names:
        found = names()
        print_json(found) if arguments.json else print("\n".join(found))
        return 0
    known, warnings = entries()
    rows = _rows(known)
    if arguments.json:
        print_json({"systems": rows, "papers": papers(), "warnings": list(warnings)})
        return 0
    for message in (*warnings, *(row["trouble"] for row in rows if row["trouble"])):
        warn(message)
    with_paper = papers()
    for line in columns([row["name"], row["title"], _mark(row, with_paper)] for row in rows):
        print(line)
    return 0


def _rows(known: tuple[Entry, ...]) -> list[dict[str, Any]]:
    """What there is to say of each system; of sound ones from an earlier time where that holds."""
    from voronec.proof.verdict_store import Store, closure, digest

    files = closure(e.origin.resolve() for e in known if e.origin is not None)
    store = Store.of_user("list", KEPT)
    key = digest(repr(known), sorted(files), DECIDER)
    kept: list[dict[str, Any]] | None = store.load(key, "rows")
    if kept is not None:
        return kept
    from voronec.proof.check import Inventory

    stock = Inventory.of()
    rows = [_row(stock, entry) for entry in stock.entries.values()]
    if not any(row["trouble"] for row in rows):
        store.save(key, "rows", rows)
    return rows


def _row(stock: Inventory, entry: Entry) -> dict[str, Any]:
    row: dict[str, Any] = {"name": entry.name, "distribution": entry.distribution}
    system = stock.systems.get(entry.name)
    # A name that is hidden is a warning of the catalogue; the system that stands is sound.
    wrong = [t for t in stock.all_troubles if t.owner == entry.name and t.place == entry.place]
    trouble = "; ".join(t.why if t.kind == "system" else _told(t) for t in wrong)
    if system is None:
        return row | {"title": "", "claims": 0, "relations": 0, "scenes": [], "trouble": trouble}
    related = sum(entry.name in (r.value.source, r.value.target) for r in stock.relations)
    return row | {
        "title": system.title or system.description,
        "claims": _claims(system) + sum(_claims(case) for case in system.cases.values()),
        "relations": related,
        "scenes": [*system.scenes],
        "trouble": trouble,
    }


def _told(trouble: Trouble) -> str:
    return f"{trouble.kind} '{trouble.name}' in {trouble.place}: {trouble.why}"


def _claims(holder: Any) -> int:
    """How many claims a system makes, or a case of it."""
    single = ("measure", "multiplier", "poisson", "essential", "integrable", "invariants")
    count = sum(getattr(holder, part, None) not in (None, "", (), {}) for part in single)
    return count + len(holder.integrals) + len(holder.equations)


def _mark(row: dict[str, Any], with_paper: list[str]) -> str:
    if row["trouble"]:
        return "broken"
    counted = [(row["claims"], "claim"), (row["relations"], "relation")]
    words = [f"{n} {word}{'s' * (n != 1)}" for n, word in counted if n] or ["unvalidated"]
    if row["name"] in with_paper:
        words.append("paper")
    if row["distribution"] != "voronec":
        words.append(f"from {row['distribution']}")
    return ", ".join(words)

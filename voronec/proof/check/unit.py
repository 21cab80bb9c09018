"""One unit of a check, which a process of its own can take: where it stands, what it rests on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from voronec.declaration.catalogue import Entry
from voronec.declaration.source_digest import closure, digest
from voronec.proof.check.inventory import Edge, Face, Inventory

DECIDER = "voronec.proof.check.work"
"""The module that decides what a check says."""


@dataclass(frozen=True)
class Unit:
    """A system, a relation or a square to be checked.

    ``entry`` is where it stands, a relation at ``position``; ``square`` is the square, and
    ``through`` where its relations stand; ``system_entries`` are all systems that it is about.
    """

    kind: str
    name: str
    entry: Entry
    position: int
    system_entries: tuple[Entry, ...]
    square: Face | None = None
    through: tuple[tuple[Entry, int], ...] = ()

    def key(self, seen: dict[str, tuple[Path, ...]]) -> str:
        """A digest of everything that the result rests on; ``seen`` spares reading files twice."""
        names = [e.name for e in self.system_entries]
        declared = (self.kind, self.name, self.position, names, self.square)
        files: set[Path] = set()
        for entry in (self.entry, *self.system_entries, *(e for e, _ in self.through)):
            files |= set(_files(entry, seen))
        return digest(repr(declared), sorted(files), DECIDER)


def _files(entry: Entry, seen: dict[str, tuple[Path, ...]]) -> tuple[Path, ...]:
    if entry.place not in seen:
        origin = entry.origin
        seen[entry.place] = () if origin is None else tuple(closure([origin.resolve()]))
    return seen[entry.place]


def units_of(stock: Inventory, names: Sequence[str] = ()) -> list[Unit]:
    """What is to be checked: everything, or what has to do with some systems; a family is checked
    with its members."""
    names = [*names, *(member for name in names for member in stock.members_of(name))]
    edges = {r.label: r for r in stock.relations}
    units = [
        Unit("system", n, stock.entries[n], 0, (stock.entries[n],)) for n in stock.contents.systems
    ]
    # Members of families, NAME@MEMBER, are no entries.
    asked = names or stock.members
    members = {n for n in (*asked, *stock.nodes) if n not in stock.entries}
    units += [Unit("system", n, stock.entry(n), 0, (stock.entry(n),)) for n in sorted(members)]
    units += [_relation(stock, r) for r in stock.relations]
    units += [_square(stock, s, edges) for s in stock.faces]
    if not names:
        return units
    return [unit for unit in units if _touches(unit, {*names})]


def _touches(unit: Unit, names: set[str]) -> bool:
    """Whether a unit is about one of the systems, or stands beside it."""
    about = {e.name for e in unit.system_entries}
    return bool(names & (about if unit.kind == "system" else about | {unit.entry.name}))


def _relation(stock: Inventory, edge: Edge) -> Unit:
    at = stock.entries[edge.owner]
    return Unit("relation", edge.label, at, edge.position, _systems(stock, [edge]))


def _square(stock: Inventory, face: Face, edges: dict[str, Edge]) -> Unit:
    labels = dict.fromkeys((*face.first, *face.second, *filter(None, (face.up_to,))))
    chain = [edges[label] for label in labels]
    at = stock.entries[face.owner]
    through = tuple((stock.entries[r.owner], r.position) for r in chain)
    involved = _systems(stock, chain)
    return Unit("square", face.label, at, face.position, involved, face, through)


def _systems(stock: Inventory, relations: Sequence[Edge]) -> tuple[Entry, ...]:
    names = dict.fromkeys(name for r in relations for name in (r.source, r.target))
    return tuple(stock.entry(name) for name in names)

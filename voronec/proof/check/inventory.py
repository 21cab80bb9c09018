"""What there is to check: systems, relations and squares, and what is wrong with them at sight.

Every system is loaded once, to say what it declares; what it says is kept, and told again while
its files and those that read them are unchanged.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from voronec.algebra.arguments import SEVERAL, TEXT, accepts, require
from voronec.declaration.catalogue import Entry, entries, entry_of, file_entry, registered_entries
from voronec.proof.check.contents import Contents, Edge, Face, Trouble
from voronec.proof.verdict_store import Store, closure, digest

if TYPE_CHECKING:
    from voronec.declaration.relation import Relation
    from voronec.declaration.system import System

__all__ = ["Inventory", "graph"]

CATALOGUES = 8
"""Catalogues that are remembered: of a few environments, and of files, that share a home."""
DECIDER = "voronec.proof.check.survey"
"""The module that loads systems and their relations."""


@dataclass(frozen=True)
class Inventory:
    """The systems of the catalogue and of given files; everything else follows from them."""

    entries: Mapping[str, Entry]
    troubles: tuple[Trouble, ...]

    @classmethod
    def of(cls, files: Iterable[str] = ()) -> Inventory:
        """Take stock.  A file may be one of the catalogue's; ``DefinitionError`` where it fails."""
        known, _ = entries()
        found = {e.name: e for e in known}
        troubles = [
            Trouble("system", hidden.name, hidden.name, hidden.place, _repeats(hidden, found))
            for hidden in _shadowed_entries(known)
        ]
        for file in files:
            entry = file_entry(file)
            other = found.get(entry.name)
            if other is None:
                found[entry.name] = entry
            elif other.origin is None or not other.origin.samefile(entry.path):
                why = _repeats(entry, found)
                troubles.append(Trouble("system", entry.name, entry.name, entry.place, why))
        return cls(found, tuple(troubles))

    @cached_property
    def contents(self) -> Contents:
        """What the systems declare: as an earlier time found it where nothing has changed."""
        files = closure(e.origin.resolve() for e in self.entries.values() if e.origin is not None)
        store = Store.of_user("catalogue", CATALOGUES)
        key = digest(repr(self.entries), sorted(files), DECIDER)
        kept = Contents.from_dict(store.load(key, "contents"))
        if kept is not None:
            return kept
        from voronec.proof.check.survey import survey

        found = survey(self.entries)
        if not found.troubles:  # the cause may lie outside
            store.save(key, "contents", asdict(found))
        return found

    @cached_property
    def systems(self) -> dict[str, System]:
        """The systems that load, loaded."""
        return {name: self.entries[name].load() for name in self.contents.systems}

    @property
    def members(self) -> tuple[str, ...]:
        """Members of families, ``NAME@MEMBER``, beside the one that stands for its family."""
        return tuple(n for name in self.contents.systems for n in self.members_of(name))

    def members_of(self, name: str) -> list[str]:
        """The members of one family; those that cannot be made are among them."""
        family = self.contents.families.get(name, {})
        return [f"{name}@{member}" for member, stands in family.items() if not stands]

    @property
    def relations(self) -> tuple[Edge, ...]:
        """The relations whose systems exist, each label once."""
        return self.contents.relations

    @property
    def faces(self) -> tuple[Face, ...]:
        """The squares that generate the diagram: those declared, and those nobody names."""
        return self.contents.faces

    @property
    def nodes(self) -> list[str]:
        """Systems that load, and members of families at the ends of relations."""
        ends = {n for edge in self.relations for n in (edge.source, edge.target)}
        return [*self.contents.systems, *sorted(ends - {*self.contents.systems})]

    @cached_property
    def graph(self) -> Any:
        """Systems and relations as a networkx ``MultiDiGraph``, the relations by their names."""
        import networkx

        found = networkx.MultiDiGraph()
        found.add_nodes_from(self.nodes)
        found.add_edges_from((e.source, e.target, e.label, {"relation": e}) for e in self.relations)
        return found

    def relation(self, edge: Edge) -> Relation:
        """The relation of that name."""
        return self.entries[edge.owner].load_relations()[0][edge.position]

    @property
    def all_troubles(self) -> tuple[Trouble, ...]:
        """Everything that is wrong at sight."""
        return (*self.troubles, *self.contents.troubles)

    def entry(self, name: str) -> Entry:
        """Where a system is defined; ``DefinitionError`` where there is none."""
        family, at, member = name.partition("@")
        if at and family in self.entries:
            known = member in self.contents.families.get(family, ())
            whole = self.entries[family]
            return whole.member_entry(member) if known else whole.of_member(member)
        return self.entries[name] if name in self.entries else entry_of(name)


def _shadowed_entries(known: Sequence[Entry]) -> list[Entry]:
    """Entries whose name another one bears."""
    shown = {(e.name, e.module, e.attribute) for e in known}
    return [e for e in registered_entries() if (e.name, e.module, e.attribute) not in shown]


def _repeats(entry: Entry, found: Mapping[str, Entry]) -> str:
    return f"the name is that of the system in {found[entry.name].place}; choose another"


@accepts(names=SEVERAL)
def graph(names: Iterable[str] = ()) -> Any:
    """The systems of the catalogue and their relations, as a networkx ``MultiDiGraph``.

    An edge is keyed by the label of its relation, which is its attribute ``relation``.  ``names``
    keeps these systems and what stands in a relation with one of them.
    """
    from voronec.declaration.reading import several

    names = several(names, "names", "name")
    for name in names:
        require("graph", "a name", name, TEXT)
    stock = Inventory.of()
    chosen = {stock.entry(name).name for name in names}
    found = around(stock.graph, chosen) if chosen else stock.graph
    for *_, data in found.edges(data=True):
        data["relation"] = stock.relation(data["relation"])
    return found


def around(whole: Any, chosen: set[str]) -> Any:
    """The part of a graph that has some nodes and their neighbours."""
    near = {n for pair in whole.edges() for n in pair if chosen & {*pair}}
    return whole.subgraph(chosen | near).copy()

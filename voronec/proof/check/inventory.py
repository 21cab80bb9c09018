"""What there is to check: systems, relations and squares, and what is wrong with them at sight."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from voronec.algebra.arguments import SEVERAL, TEXT, accepts, require
from voronec.declaration.catalogue import Entry, entries, entry_of, file_entry, registered
from voronec.declaration.reading import several
from voronec.declaration.relation import Relation, Square
from voronec.declaration.system import System
from voronec.errors import DefinitionError, did_you_mean

__all__ = ["Declared", "Inventory", "Trouble", "graph"]


@dataclass(frozen=True)
class Trouble:
    """What cannot be checked, and why; ``owner`` is the system beside which it stands."""

    kind: str
    name: str
    owner: str
    place: str
    why: str


@dataclass(frozen=True)
class Declared:
    """A relation or a square, and where it stands: beside which system, at which position."""

    entry: Entry
    position: int
    value: Any

    @property
    def label(self) -> str:
        """What it is called."""
        return str(self.value.label)


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
            for hidden in _hidden(known)
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
    def systems(self) -> dict[str, System]:
        """The systems that load."""
        return {n: s for n, s in self._loaded.items() if isinstance(s, System)}

    @cached_property
    def members(self) -> tuple[str, ...]:
        """Members of families, ``NAME@MEMBER``, beside the one that stands for its family."""
        return tuple(n for name in self.systems for n in self.members_of(name))

    def members_of(self, name: str) -> list[str]:
        """The members of one family; those that cannot be made are among them."""
        own, every = self.systems.get(name), self._families[0].get(name, ())
        return [n for n in every if own is None or not self._stands_for(own, n)]

    @cached_property
    def _families(self) -> tuple[dict[str, list[str]], list[Trouble]]:
        """The members of each system that loads, and families that cannot be told apart."""
        found, troubles = dict[str, list[str]](), []
        for name in self.systems:
            entry = self.entries[name]
            try:
                found[name] = [f"{name}@{m}" for m in entry.load_members()]
            except DefinitionError as error:
                troubles.append(Trouble("system", name, name, entry.place, str(error)))
        return found, troubles

    def _stands_for(self, system: System, member: str) -> bool:
        try:
            return bool(self.entry(member).load().lagrangian == system.lagrangian)
        except DefinitionError:
            return False

    @cached_property
    def relations(self) -> tuple[Declared, ...]:
        """The relations whose systems exist, each label once."""
        return self._sorted_out[0]

    @cached_property
    def squares(self) -> tuple[Declared, ...]:
        """The squares whose relations exist, each label once."""
        return self._sorted_out[1]

    @cached_property
    def graph(self) -> Any:
        """Systems and relations as a networkx ``MultiDiGraph``."""
        from voronec.proof.relations.diagram import diagram

        edges = [r.value for r in self.relations]
        members = {n for r in edges for n in (r.source, r.target)}
        return diagram([*self.systems, *sorted(members - {*self.systems})], edges)

    @cached_property
    def faces(self) -> tuple[Declared, ...]:
        """The squares that generate the diagram: those declared, and those nobody names."""
        from voronec.proof.relations.diagram import squares_of

        named = {id(s.value): s for s in self.squares}
        beside = {r.label: r.entry for r in self.relations}
        return tuple(
            named.get(id(s)) or Declared(beside[s.first[0]], -1, s)
            for s in squares_of(self.graph, [s.value for s in self.squares])
        )

    @cached_property
    def all_troubles(self) -> tuple[Trouble, ...]:
        """Everything that is wrong at sight; every system is loaded for it."""
        broken = [
            Trouble("system", name, name, self.entries[name].place, str(error))
            for name, error in self._loaded.items()
            if isinstance(error, DefinitionError)
        ]
        return (*self.troubles, *broken, *self._families[1], *self._sorted_out[2])

    def entry(self, name: str) -> Entry:
        """Where a system is defined; ``DefinitionError`` where there is none."""
        family, at, member = name.partition("@")
        if at and family in self.entries:
            return self.entries[family].of_member(member)
        return self.entries[name] if name in self.entries else entry_of(name)

    @cached_property
    def _loaded(self) -> dict[str, System | DefinitionError]:
        found: dict[str, System | DefinitionError] = {}
        for name, entry in self.entries.items():
            try:
                found[name] = entry.load()
            except DefinitionError as error:
                found[name] = error
        return found

    @cached_property
    def _sorted_out(self) -> tuple[tuple[Declared, ...], tuple[Declared, ...], list[Trouble]]:
        """Relations, squares, and those of both that cannot be checked."""
        relations, squares, troubles = [], [], []
        for entry in self._with_relations():
            try:
                edges, faces = entry.load_relations()
            except DefinitionError as error:
                troubles.append(
                    Trouble("relation", "RELATIONS", entry.name, entry.place, str(error))
                )
                continue
            relations += [Declared(entry, i, edge) for i, edge in enumerate(edges)]
            squares += [Declared(entry, i, face) for i, face in enumerate(faces)]
        edges_kept, wrong = self._sound(relations, self._wrong_relation)
        labels = {r.label: r for r in edges_kept}
        faces_kept, more = self._sound(squares, lambda s: _wrong_square(s, labels))
        return edges_kept, faces_kept, [*troubles, *wrong, *more]

    def _with_relations(self) -> Iterator[Entry]:
        """The systems that load, one for each file: what stands in it is counted once."""
        seen = set()
        for name in self.systems:
            entry = self.entries[name]
            if entry.place not in seen:
                seen.add(entry.place)
                yield entry

    def _sound(self, declared: Sequence[Declared], wrong: Any) -> tuple[Any, list[Trouble]]:
        """Those with which nothing is wrong, and the trouble with the others."""
        kept: dict[str, Declared] = {}
        troubles = []
        for one in declared:
            kind = type(one.value).__name__.lower()
            why = wrong(one.value)
            if one.label in kept:
                other = kept[one.label].entry.place
                why = f"the label is taken in {other}; give one of them another name="
            if why:
                troubles.append(Trouble(kind, one.label, one.entry.name, one.entry.place, why))
            else:
                kept[one.label] = one
        return tuple(kept.values()), troubles

    def _wrong_relation(self, relation: Relation) -> str:
        for role in ("source", "target"):
            try:
                self.entry(getattr(relation, role))
            except DefinitionError as error:
                return f"its {role}: {error}"
        return ""


def _wrong_square(square: Square, known: Mapping[str, Declared]) -> str:
    for label in (*square.first, *square.second, *filter(None, (square.up_to,))):
        if label not in known:
            return f"there is no relation '{label}'" + did_you_mean(label, known)
    return ""


def _hidden(known: Sequence[Entry]) -> list[Entry]:
    """Entries whose name another one bears."""
    shown = {(e.name, e.module, e.attribute) for e in known}
    return [e for e in registered() if (e.name, e.module, e.attribute) not in shown]


def _repeats(entry: Entry, found: Mapping[str, Entry]) -> str:
    return f"the name is that of the system in {found[entry.name].place}; choose another"


@accepts(names=SEVERAL)
def graph(names: Iterable[str] = ()) -> Any:
    """The systems of the catalogue and their relations, as a networkx ``MultiDiGraph``.

    An edge is keyed by the label of its relation, which is its attribute ``relation``.  ``names``
    keeps these systems and what stands in a relation with one of them.
    """
    names = several(names, "names", "name")
    for name in names:
        require("graph", "a name", name, TEXT)
    stock = Inventory.of()
    chosen = {stock.entry(name).name for name in names}
    return around(stock.graph, chosen) if chosen else stock.graph


def around(whole: Any, chosen: set[str]) -> Any:
    """The part of a graph that has some nodes and their neighbours."""
    near = {n for pair in whole.edges() for n in pair if chosen & {*pair}}
    return whole.subgraph(chosen | near).copy()

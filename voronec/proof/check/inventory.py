"""What there is to check: systems, relations and squares, and what is wrong with them at sight.

Every system is loaded once, to say what it declares; what it says is kept, in names that JSON can
hold, and told again while its files and those that read them are unchanged.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from voronec.algebra.arguments import SEVERAL, TEXT, accepts, require
from voronec.declaration.catalogue import Entry, entries, entry_of, file_entry, registered_entries
from voronec.declaration.source_digest import closure, digest
from voronec.declaration.whole_files import Store
from voronec.errors import DefinitionError, did_you_mean

if TYPE_CHECKING:
    from voronec.declaration.relation import Relation, Square
    from voronec.declaration.system import System

CATALOGUES = 8
"""Catalogues that are remembered: of a few environments, and of files, that share a home."""
DECIDER = "voronec.proof.check.inventory"
"""The module that loads systems and their relations."""


@dataclass(frozen=True)
class Trouble:
    """What cannot be checked, and why; ``owner`` is the system beside which it stands."""

    kind: str
    name: str
    owner: str
    place: str
    why: str


@dataclass(frozen=True)
class Summary:
    """What a system is called, how many claims it makes, and its scenes."""

    title: str
    claims: int
    scenes: tuple[str, ...]


@dataclass(frozen=True)
class Edge:
    """A relation by its names; it stands beside the system ``owner``, at a ``position``.

    ``line`` is the kind that its declaration shows.
    """

    label: str
    owner: str
    position: int
    source: str
    target: str
    line: str
    note: str


@dataclass(frozen=True)
class Face:
    """A square by the labels of its relations; at position -1 where nobody names it."""

    label: str
    owner: str
    position: int
    first: tuple[str, ...]
    second: tuple[str, ...]
    up_to: str
    name: str

    def declaration(self) -> Square:
        """The square itself."""
        from voronec.declaration.relation import Square

        return Square(self.first, self.second, self.up_to, self.name)


@dataclass(frozen=True)
class Contents:
    """What the systems of an inventory declare, in names.

    ``families`` holds the members of each system that has some, and whether a member is the one
    that stands for its family.
    """

    systems: Mapping[str, Summary]
    families: Mapping[str, Mapping[str, bool]]
    relations: tuple[Edge, ...]
    faces: tuple[Face, ...]
    troubles: tuple[Trouble, ...] = ()

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Contents:
        """The contents that were written as a dictionary."""
        systems = {
            n: Summary(**s | {"scenes": (*s["scenes"],)}) for n, s in data["systems"].items()
        }
        faces = tuple(
            Face(**f | {"first": (*f["first"],), "second": (*f["second"],)}) for f in data["faces"]
        )
        return cls(systems, data["families"], tuple(Edge(**e) for e in data["relations"]), faces)


@dataclass(frozen=True)
class Inventory:
    """The systems of the catalogue and of given files; everything else follows from them."""

    entries: Mapping[str, Entry]
    troubles: tuple[Trouble, ...]

    @classmethod
    def of(cls, files: Iterable[str] = ()) -> Inventory:
        """Take stock.  A file may be one of the catalogue's; ``DefinitionError`` where it fails."""
        known, _ = entries()
        by_name = {e.name: e for e in known}
        troubles = [
            Trouble("system", hidden.name, hidden.name, hidden.place, _repeats(hidden, by_name))
            for hidden in _shadowed_entries(known)
        ]
        for file in files:
            entry = file_entry(file)
            other = by_name.get(entry.name)
            if other is None:
                by_name[entry.name] = entry
            elif other.origin is None or not other.origin.samefile(entry.path):
                why = _repeats(entry, by_name)
                troubles.append(Trouble("system", entry.name, entry.name, entry.place, why))
        return cls(by_name, tuple(troubles))

    @cached_property
    def contents(self) -> Contents:
        """What the systems declare: as an earlier time found it where nothing has changed."""
        files = closure(e.origin.resolve() for e in self.entries.values() if e.origin is not None)
        store = Store.of_user("catalogue", CATALOGUES)
        key = digest(repr(self.entries), sorted(files), DECIDER)
        kept = store.load(key, "contents")
        if kept is not None:
            return Contents.from_dict(kept)
        declared = _survey(self.entries)
        if not declared.troubles:  # the cause may lie outside
            store.save(key, "contents", asdict(declared))
        return declared

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

        network = networkx.MultiDiGraph()
        network.add_nodes_from(self.nodes)
        network.add_edges_from(
            (e.source, e.target, e.label, {"relation": e}) for e in self.relations
        )
        return network

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


def _survey(entries: Mapping[str, Entry]) -> Contents:
    """What systems declare, and what is wrong with it at sight: every system is loaded."""
    from voronec.proof.relations.diagram import diagram, squares_of

    survey = _Survey(entries)
    edges, squares, troubles = survey.declared_checks
    graph = diagram([*survey.systems, *survey.related_members(edges)], [e.value for e in edges])
    beside = {e.value.label: e.entry for e in edges}
    named = {s.value.label: s for s in squares}
    faces = []
    for square in squares_of(graph, [s.value for s in squares]):
        at = named.get(square.label) or _Declaration(beside[square.first[0]], -1, square)
        ends = (square.first, square.second, square.up_to, square.name)
        faces.append(Face(square.label, at.entry.name, at.position, *ends))
    return Contents(
        {name: _summary(system) for name, system in survey.systems.items()},
        survey.families[0],
        tuple(_edge(e) for e in edges),
        tuple(faces),
        (*survey.troubles, *survey.families[1], *troubles),
    )


@dataclass(frozen=True)
class _Declaration:
    """A relation or a square, and where it stands: beside which system, at which position."""

    entry: Entry
    position: int
    value: Any


def _edge(declared: _Declaration) -> Edge:
    relation = declared.value
    ends = (relation.source, relation.target)
    at = (declared.entry.name, declared.position)
    return Edge(relation.label, *at, *ends, relation.line, relation.note)


def _summary(system: System) -> Summary:
    from voronec.declaration.claims import claim_names

    claims = len([*claim_names(system)])
    return Summary(system.title or system.description, claims, (*system.scenes,))


@dataclass(frozen=True)
class _Survey:
    """The systems at some entries, loaded."""

    entries: Mapping[str, Entry]

    @cached_property
    def systems_or_errors(self) -> dict[str, System | DefinitionError]:
        loaded: dict[str, System | DefinitionError] = {}
        for name, entry in self.entries.items():
            try:
                loaded[name] = entry.load()
            except DefinitionError as error:
                loaded[name] = error
        return loaded

    @cached_property
    def systems(self) -> dict[str, System]:
        """The systems that load."""
        loaded = self.systems_or_errors.items()
        return {n: s for n, s in loaded if not isinstance(s, DefinitionError)}

    @property
    def troubles(self) -> Iterator[Trouble]:
        """Those that do not."""
        for name, error in self.systems_or_errors.items():
            if isinstance(error, DefinitionError):
                yield Trouble("system", name, name, self.entries[name].place, str(error))

    @cached_property
    def families(self) -> tuple[dict[str, dict[str, bool]], list[Trouble]]:
        """The members of each system that has some, and families that cannot be told apart."""
        by_system, troubles = dict[str, dict[str, bool]](), []
        for name, system in self.systems.items():
            entry = self.entries[name]
            try:
                members = entry.load_members()
            except DefinitionError as error:
                troubles.append(Trouble("system", name, name, entry.place, str(error)))
            else:
                if members:
                    by_system[name] = {
                        m: _stands_for(system, entry.member_entry(m)) for m in members
                    }
        return by_system, troubles

    def related_members(self, edges: Sequence[_Declaration]) -> list[str]:
        """The members of families at the ends of relations."""
        ends = {n for e in edges for n in (e.value.source, e.value.target)}
        return sorted(ends - {*self.systems})

    @cached_property
    def declared_checks(
        self,
    ) -> tuple[tuple[_Declaration, ...], tuple[_Declaration, ...], list[Trouble]]:
        """Relations, squares, and those of both that cannot be checked."""
        relations, squares, troubles = [], [], []
        for entry in self.with_relations():
            try:
                edges, faces = entry.load_relations()
            except DefinitionError as error:
                troubles.append(
                    Trouble("relation", "RELATIONS", entry.name, entry.place, str(error))
                )
                continue
            relations += [_Declaration(entry, i, edge) for i, edge in enumerate(edges)]
            squares += [_Declaration(entry, i, face) for i, face in enumerate(faces)]
        edges_kept, wrong = self._sound(relations, self._wrong_relation)
        labels = {r.value.label: r for r in edges_kept}
        faces_kept, more = self._sound(squares, lambda s: _wrong_square(s, labels))
        return edges_kept, faces_kept, [*troubles, *wrong, *more]

    def with_relations(self) -> Iterator[Entry]:
        """The systems that load, one for each file: what stands in it is counted once."""
        seen = set()
        for name in self.systems:
            entry = self.entries[name]
            if entry.place not in seen:
                seen.add(entry.place)
                yield entry

    def _sound(self, declared: Sequence[_Declaration], wrong: Any) -> tuple[Any, list[Trouble]]:
        """Those with which nothing is wrong, and the trouble with the others."""
        kept: dict[str, _Declaration] = {}
        troubles = []
        for one in declared:
            kind = type(one.value).__name__.lower()
            label, why = one.value.label, wrong(one.value)
            if label in kept:
                other = kept[label].entry.place
                why = f"the label is taken in {other}; give one of them another name="
            if why:
                troubles.append(Trouble(kind, label, one.entry.name, one.entry.place, why))
            else:
                kept[label] = one
        return tuple(kept.values()), troubles

    def _wrong_relation(self, relation: Relation) -> str:
        for role in ("source", "target"):
            try:
                self._find(getattr(relation, role))
            except DefinitionError as error:
                return f"its {role}: {error}"
        return ""

    def _find(self, name: str) -> Entry:
        """Where a system is defined; ``DefinitionError`` where there is none."""
        family, _, member = name.partition("@")
        if family not in self.entries:
            return entry_of(name)
        entry = self.entries[family]
        return entry.of_member(member) if "@" in name else entry


def _stands_for(system: System, member: Entry) -> bool:
    """Whether a member of a family is the system that stands for the family."""
    try:
        return bool(member.load().lagrangian == system.lagrangian)
    except DefinitionError:
        return False


def _wrong_square(square: Square, known: Mapping[str, _Declaration]) -> str:
    for label in (*square.first, *square.second, *filter(None, (square.up_to,))):
        if label not in known:
            return f"there is no relation '{label}'" + did_you_mean(label, known)
    return ""


def names_read(place: str, names: Iterable[str]) -> tuple[str, ...]:
    """Names of systems, or one of them, as the function ``place`` was given them."""
    read = tuple(names) if isinstance(names, list | tuple) else _several_names(names)
    for name in read:
        require(place, "a name", name, TEXT)
    return read


def _several_names(names: Any) -> tuple[Any, ...]:
    from voronec.declaration.reading import several  # which loads SymPy, that lists need not

    return several(names, "names", "name")


@accepts(names=SEVERAL)
def graph(names: Iterable[str] = ()) -> Any:
    """The systems of the catalogue and their relations, as a networkx ``MultiDiGraph``.

    An edge is keyed by the label of its relation, which is its attribute ``relation``.  ``names``
    keeps these systems and what stands in a relation with one of them; an unknown one raises
    ``DefinitionError``.
    """
    names = names_read("graph", names)
    stock = Inventory.of()
    chosen = {stock.entry(name).name for name in names}
    network = around(stock.graph, chosen) if chosen else stock.graph
    for *_, data in network.edges(data=True):
        data["relation"] = stock.relation(data["relation"])
    return network


def around(whole: Any, chosen: set[str]) -> Any:
    """The part of a graph that has some nodes and their neighbours."""
    near = {n for pair in whole.edges() for n in pair if chosen & {*pair}}
    return whole.subgraph(chosen | near).copy()

"""Every system loaded, to say what there is to check: the work behind ``Contents``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from voronec.declaration.catalogue import Entry, entry_of
from voronec.declaration.claims import claim_names
from voronec.declaration.relation import Relation, Square
from voronec.declaration.system import System
from voronec.errors import DefinitionError, did_you_mean
from voronec.proof.check.contents import Contents, Edge, Face, Summary, Trouble
from voronec.proof.relations.diagram import diagram, squares_of

__all__ = ["survey"]


def survey(entries: Mapping[str, Entry]) -> Contents:
    """What systems declare, and what is wrong with it at sight."""
    found = _Survey(entries)
    edges, squares, troubles = found.declared_checks
    graph = diagram([*found.systems, *found.related_members(edges)], [e.value for e in edges])
    beside = {e.value.label: e.entry for e in edges}
    named = {s.value.label: s for s in squares}
    faces = []
    for square in squares_of(graph, [s.value for s in squares]):
        at = named.get(square.label) or _Declaration(beside[square.first[0]], -1, square)
        ends = (square.first, square.second, square.up_to, square.name)
        faces.append(Face(square.label, at.entry.name, at.position, *ends))
    return Contents(
        {name: _summary(system) for name, system in found.systems.items()},
        found.families[0],
        tuple(_edge(e) for e in edges),
        tuple(faces),
        (*found.troubles, *found.families[1], *troubles),
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
    claims = len([*claim_names(system)])
    return Summary(system.title or system.description, claims, (*system.scenes,))


@dataclass(frozen=True)
class _Survey:
    """The systems at some entries, loaded."""

    entries: Mapping[str, Entry]

    @cached_property
    def systems_or_errors(self) -> dict[str, System | DefinitionError]:
        found: dict[str, System | DefinitionError] = {}
        for name, entry in self.entries.items():
            try:
                found[name] = entry.load()
            except DefinitionError as error:
                found[name] = error
        return found

    @cached_property
    def systems(self) -> dict[str, System]:
        """The systems that load."""
        return {n: s for n, s in self.systems_or_errors.items() if isinstance(s, System)}

    @property
    def troubles(self) -> Iterator[Trouble]:
        """Those that do not."""
        for name, error in self.systems_or_errors.items():
            if isinstance(error, DefinitionError):
                yield Trouble("system", name, name, self.entries[name].place, str(error))

    @cached_property
    def families(self) -> tuple[dict[str, dict[str, bool]], list[Trouble]]:
        """The members of each system that has some, and families that cannot be told apart."""
        found, troubles = dict[str, dict[str, bool]](), []
        for name, system in self.systems.items():
            entry = self.entries[name]
            try:
                members = entry.load_members()
            except DefinitionError as error:
                troubles.append(Trouble("system", name, name, entry.place, str(error)))
            else:
                if members:
                    found[name] = {m: _stands_for(system, entry.member_entry(m)) for m in members}
        return found, troubles

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

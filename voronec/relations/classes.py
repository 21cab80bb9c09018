"""Which chains between two systems agree if shorter ones do, and squares for the rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

from voronec.relations.declaration import Square
from voronec.relations.families import Course

__all__ = ["missing_squares"]

Labels = tuple[str, ...]
Ends = tuple[str, str]


@dataclass
class _Parallel:
    """The chains between two systems that have a meaning; which are known to agree, or to agree
    up to an automorphism."""

    courses: dict[Labels, Course] = field(default_factory=dict)
    agree: list[tuple[Labels, Labels]] = field(default_factory=list)
    tied: list[tuple[Labels, Labels]] = field(default_factory=list)

    def within(self, moved: dict[str, Any]) -> list[Labels]:
        """The chains whose limits are among given ones."""
        return [c for c, course in self.courses.items() if course.moved.items() <= moved.items()]

    def classes(self, members: Sequence[Labels], edges: Sequence[Any]) -> list[list[Labels]]:
        """Chains that hang together, the shortest first."""
        import networkx

        links = networkx.Graph()
        links.add_nodes_from(members)
        links.add_edges_from((a, b) for a, b in edges if a in links and b in links)
        found = (sorted(c, key=_by_length) for c in networkx.connected_components(links))
        return sorted(found, key=lambda c: _by_length(c[0]))

    def is_agreed(self, one: Labels, other: Labels) -> bool:
        """Whether two chains agree, in the limits of both."""
        if one == other:
            return one in self.courses
        if one not in self.courses or other not in self.courses:
            return False
        first, second = self.courses[one], self.courses[other]
        if not first.is_compatible(second):
            return False
        if not self.tied:
            return True
        members = self.within({**first.moved, **second.moved})
        return any(one in c and other in c for c in self.classes(members, self.agree))


def missing_squares(graph: Any, declared: Sequence[Square]) -> Iterator[Square]:
    """The squares that have to be added to the declared ones; ``graph`` has no circles."""
    import networkx

    order = list(networkx.topological_sort(graph))
    parallel: dict[Ends, _Parallel] = {}
    for start in reversed(order):
        _walk(graph, start, start, (), Course(), parallel)
        for end in order:
            if (start, end) in parallel:
                yield from _between(graph, (start, end), parallel, declared)


def _walk(
    graph: Any, start: str, at: str, labels: Labels, course: Course, found: dict[Ends, _Parallel]
) -> None:
    """All chains from a system that have a meaning."""
    for _, end, key, data in graph.out_edges(at, keys=True, data=True):
        further = course.through(data["relation"])
        if further is not None:
            chain = (*labels, key)
            found.setdefault((start, end), _Parallel()).courses[chain] = further
            _walk(graph, start, end, chain, further, found)


def _between(
    graph: Any, ends: Ends, parallel: dict[Ends, _Parallel], declared: Sequence[Square]
) -> Iterator[Square]:
    """Squares between the classes of chains, for each set of limits that two of them have."""
    own = parallel[ends]
    if len(own.courses) < 2:
        return
    for square in declared:
        if square.first in own.courses and square.second in own.courses:
            (own.tied if square.up_to else own.agree).append((square.first, square.second))
    turns = {key: (a, b) for a, b, key in graph.edges(keys=True)}
    for one, other in combinations(own.courses, 2):
        first, last = turns[one[0]][1], turns[one[-1]][0]
        tails = one[0] == other[0] and _agreed(parallel, (first, ends[1]), one[1:], other[1:])
        heads = one[-1] == other[-1] and _agreed(parallel, (ends[0], last), one[:-1], other[:-1])
        if tails or heads:
            own.agree.append((one, other))
    for moved in _joint_limits([*own.courses.values()]):
        main, *others = own.classes(own.within(moved), [*own.agree, *own.tied])
        for chains in others:
            own.agree.append((chains[0], main[0]))
            yield Square(chains[0], main[0])


def _agreed(parallel: dict[Ends, _Parallel], ends: Ends, one: Labels, other: Labels) -> bool:
    return ends in parallel and parallel[ends].is_agreed(one, other)


def _joint_limits(courses: Sequence[Course]) -> list[dict[str, Any]]:
    """The limits of one chain or of two, the fewest first, each once."""
    found: dict[Any, dict[str, Any]] = {}
    for one in courses:
        for other in courses:
            if one.is_compatible(other):
                joint = {**one.moved, **other.moved}
                found[frozenset(joint.items())] = joint
    return sorted(found.values(), key=lambda m: (len(m), sorted(map(str, m.items()))))


def _by_length(chain: Labels) -> tuple[int, Labels]:
    return len(chain), chain

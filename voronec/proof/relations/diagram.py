"""The diagram of systems and relations, and which squares of it have to commute."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, pairwise, product
from typing import Any

from voronec.declaration.relation import Relation, Square
from voronec.errors import DefinitionError, did_you_mean
from voronec.proof.relations.families import Course

Labels = tuple[str, ...]
Ends = tuple[str, str]


@dataclass
class _Parallel:
    """The chains between two systems that have a meaning; which are known to agree, or to agree
    up to an automorphism."""

    courses: dict[Labels, Course] = field(default_factory=dict)
    agree: list[tuple[Labels, Labels]] = field(default_factory=list)
    up_to: list[tuple[Labels, Labels]] = field(default_factory=list)

    def within(self, moved: dict[str, Any]) -> list[Labels]:
        """The chains whose limits are among given ones."""
        return [c for c, course in self.courses.items() if course.limits.items() <= moved.items()]

    def classes(self, members: Sequence[Labels], edges: Sequence[Any]) -> list[list[Labels]]:
        """Chains that hang together, the shortest first."""
        import networkx

        links = networkx.Graph()
        links.add_nodes_from(members)
        links.add_edges_from((a, b) for a, b in edges if a in links and b in links)
        components = (sorted(c, key=_by_length) for c in networkx.connected_components(links))
        return sorted(components, key=lambda c: _by_length(c[0]))

    def is_agreed(self, one: Labels, other: Labels) -> bool:
        """Whether two chains agree, in the limits of both."""
        if one == other:
            return one in self.courses
        if one not in self.courses or other not in self.courses:
            return False
        first, second = self.courses[one], self.courses[other]
        if not first.is_compatible(second):
            return False
        if not self.up_to:
            return True
        members = self.within({**first.limits, **second.limits})
        return any(one in c and other in c for c in self.classes(members, self.agree))


def _missing_squares(graph: Any, declared: Sequence[Square]) -> Iterator[Square]:
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
    bundle = parallel[ends]
    if len(bundle.courses) < 2:
        return
    for square in declared:
        if square.first in bundle.courses and square.second in bundle.courses:
            (bundle.up_to if square.up_to else bundle.agree).append((square.first, square.second))
    turns = {key: (a, b) for a, b, key in graph.edges(keys=True)}
    for one, other in combinations(bundle.courses, 2):
        first, last = turns[one[0]][1], turns[one[-1]][0]
        tails = one[0] == other[0] and _agree(parallel, (first, ends[1]), one[1:], other[1:])
        heads = one[-1] == other[-1] and _agree(parallel, (ends[0], last), one[:-1], other[:-1])
        if tails or heads:
            bundle.agree.append((one, other))
    for moved in _joint_limits([*bundle.courses.values()]):
        main, *others = bundle.classes(bundle.within(moved), [*bundle.agree, *bundle.up_to])
        for chains in others:
            bundle.agree.append((chains[0], main[0]))
            yield Square(chains[0], main[0])


def _agree(parallel: dict[Ends, _Parallel], ends: Ends, one: Labels, other: Labels) -> bool:
    return ends in parallel and parallel[ends].is_agreed(one, other)


def _joint_limits(courses: Sequence[Course]) -> list[dict[str, Any]]:
    """The limits of one chain or of two, the fewest first, each once."""
    limits: dict[Any, dict[str, Any]] = {}
    for one in courses:
        for other in courses:
            if one.is_compatible(other):
                joint = {**one.limits, **other.limits}
                limits[frozenset(joint.items())] = joint
    return sorted(limits.values(), key=lambda m: (len(m), sorted(map(str, m.items()))))


def _by_length(chain: Labels) -> tuple[int, Labels]:
    return len(chain), chain


def diagram(systems: Iterable[str], relations: Iterable[Relation]) -> Any:
    """A networkx MultiDiGraph: systems by name, an edge for each relation, keyed by its label.

    Raises ``DefinitionError`` where a label is used twice, or a relation leads nowhere.
    """
    import networkx

    graph = networkx.MultiDiGraph()
    graph.add_nodes_from(systems)
    labels: set[str] = set()
    for relation in relations:
        if relation.label in labels:
            raise DefinitionError(
                f"two relations are called '{relation.label}'; give one of them another name="
            )
        labels.add(relation.label)
        for end in (relation.source, relation.target):
            if end not in graph:
                raise DefinitionError(
                    f"relation '{relation.label}': there is no system '{end}'"
                    + did_you_mean(end, graph)
                )
        graph.add_edge(relation.source, relation.target, key=relation.label, relation=relation)
    return graph


def squares_of(graph: Any, declared: Sequence[Square] = ()) -> list[Square]:
    """Squares that generate the diagram.

    A chain has a meaning where the limits of its relations can be carried back to its start; one
    that fixes a parameter and moves it in a later limit has none, and nothing is asked of it.  If
    the squares commute, any two parallel chains with a meaning agree as maps of states, parameters
    and clocks, in the limits of both: exactly so where neither goes through a limit.  Nothing is
    said of chains whose limits move a parameter of the start to different values, and those that
    an automorphism tells apart agree up to it.

    Two chains agree if they begin with the same relation and the rest agrees, or end with the same
    one; so, for each set of limits, a square for each further class of chains that hang together
    in this way is enough, by induction on what lies between.  A chain in the middle joins two
    others only where it has no limits but theirs.  Maps are taken to be continuous at the limits,
    as proofs of relations show them to be.  That holds where no chain leads back to its beginning.
    Where some do, they must be the identity, and every pair of chains that share no system between
    is a square; then that is all that is claimed.  Automorphisms, which lead from a system to
    itself, are no part of chains.  The declared squares come first, and join the classes of their
    chains, unless they hold up to an automorphism only.
    """
    import networkx

    for square in declared:
        _check_labels(graph, square)
    plain = networkx.MultiDiGraph()
    plain.add_nodes_from(graph)
    edges = graph.edges(keys=True, data=True)
    plain.add_edges_from((a, b, key, data) for a, b, key, data in edges if a != b)
    if networkx.is_directed_acyclic_graph(plain):
        return [*declared, *_missing_squares(plain, declared)]
    known = {_pair(s) for s in declared}
    relations = {key: data["relation"] for _, _, key, data in edges}
    squares = {_pair(s): s for s in (*_disjoint_chains(plain), *_circles(plain))}
    meant = (s for s in squares.values() if _has_meaning(s, relations))
    return [*declared, *(s for s in meant if _pair(s) not in known)]


def _has_meaning(square: Square, relations: Mapping[str, Relation]) -> bool:
    return all(
        Course.of(relations[label] for label in chain) is not None
        for chain in (square.first, square.second)
    )


def _pair(square: Square) -> frozenset[tuple[str, ...]]:
    return frozenset({square.first, square.second})


def _disjoint_chains(graph: Any) -> Iterator[Square]:
    """Pairs of chains with the same ends and no common system between."""
    import networkx

    for start in graph:
        for end in networkx.descendants(graph, start):
            chains = list(networkx.all_simple_edge_paths(graph, start, end))
            for first, second in combinations(chains, 2):
                if not _inner(first) & _inner(second):
                    yield Square(_labels(first), _labels(second))


def _circles(graph: Any) -> Iterator[Square]:
    """Chains that lead back to where they began, from each of their systems."""
    import networkx

    for nodes in networkx.simple_cycles(networkx.DiGraph(graph)):
        for at in range(len(nodes)):
            turned = [*nodes[at:], *nodes[:at], nodes[at]]
            for keys in product(*(graph[a][b] for a, b in pairwise(turned))):
                yield Square(tuple(keys), ())


def _inner(chain: Sequence[tuple[str, str, str]]) -> set[str]:
    return {a for a, _, _ in chain[1:]}


def _labels(chain: Sequence[tuple[str, str, str]]) -> tuple[str, ...]:
    return tuple(key for _, _, key in chain)


def _check_labels(graph: Any, square: Square) -> None:
    labels = {key for _, _, key in graph.edges(keys=True)}
    for label in (*square.first, *square.second, *filter(None, [square.up_to])):
        if label not in labels:
            raise DefinitionError(
                f"square '{square.label}': there is no relation '{label}'"
                + did_you_mean(label, labels)
            )

"""The diagram of systems and relations, and which squares of it have to commute."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, pairwise, product
from typing import Any

from voronec.errors import DefinitionError, did_you_mean
from voronec.relations.declaration import Relation, Square

__all__ = ["diagram", "squares_of"]


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
    """Squares that generate the diagram: if they commute, all parallel chains agree.

    Two chains with the same ends agree if they begin with the same relation and the rest agrees,
    or end with the same one.  So of the chains between two systems, those that hang together in
    this way are one class, and a square for each further class is enough, by induction on what
    lies between; that holds where no chain leads back to its beginning.  Where some do, they must
    be the identity, and every pair of chains that share no system between is a square.
    Automorphisms, which lead from a system to itself, are no part of chains.  The declared squares
    come first, and join the classes of their chains.
    """
    import networkx

    for square in declared:
        _check_labels(graph, square)
    plain = networkx.MultiDiGraph()
    plain.add_nodes_from(graph)
    plain.add_edges_from((a, b, key) for a, b, key in graph.edges(keys=True) if a != b)
    if networkx.is_directed_acyclic_graph(plain):
        return [*declared, *_between_classes(plain, declared)]
    known = {_pair(s) for s in declared}
    found = {_pair(s): s for s in (*_disjoint_chains(plain), *_circles(plain))}
    return [*declared, *(s for pair, s in found.items() if pair not in known)]


def _pair(square: Square) -> frozenset[tuple[str, ...]]:
    return frozenset({square.first, square.second})


def _between_classes(graph: Any, declared: Sequence[Square]) -> Iterator[Square]:
    """For each two systems, the squares between the first class of chains and every other."""
    import networkx

    reach = {node: networkx.descendants(graph, node) | {node} for node in graph}
    joined = [(s.first, s.second) for s in declared if s.second]
    for start in graph:
        for end in reach[start] - {start}:
            links = networkx.Graph()
            for _, a, first in graph.out_edges(start, keys=True):
                for b, _, last in graph.in_edges(end, keys=True):
                    if first == last or (end not in (a, b) and b in reach[a]):
                        links.add_edge(("first", first), ("last", last))
            for one, other in joined:
                ends = {("first", c[0]) for c in (one, other)} | {
                    ("last", c[-1]) for c in (one, other)
                }
                if ends <= {*links}:
                    links.add_edge(("first", one[0]), ("first", other[0]))
            classes = networkx.connected_components(links)
            chains = sorted((_shortest(graph, links, c) for c in classes), key=_by_length)
            yield from (Square(chain, chains[0]) for chain in chains[1:])


def _by_length(chain: tuple[str, ...]) -> tuple[int, tuple[str, ...]]:
    return len(chain), chain


def _shortest(graph: Any, links: Any, members: Iterable[tuple[str, str]]) -> tuple[str, ...]:
    """The shortest chain of a class; of several, the first by name."""
    import networkx

    ends = {key: (a, b) for a, b, key in graph.edges(keys=True)}
    chains = []
    for side, first in members:
        if side == "first":
            for last in (name for kind, name in links[side, first] if kind == "last"):
                if first == last:
                    chains.append((first,))
                    continue
                nodes = networkx.shortest_path(graph, ends[first][1], ends[last][0])
                middle = tuple(min(graph[a][b]) for a, b in pairwise(nodes))
                chains.append((first, *middle, last))
    return min(chains, key=_by_length)


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

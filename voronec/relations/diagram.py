"""The diagram of systems and relations, and which squares of it have to commute."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations, pairwise, product
from typing import Any

from voronec.errors import DefinitionError, did_you_mean
from voronec.relations.classes import missing_squares
from voronec.relations.declaration import Relation, Square
from voronec.relations.families import Course

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
        return [*declared, *missing_squares(plain, declared)]
    known = {_pair(s) for s in declared}
    relations = {key: data["relation"] for _, _, key, data in edges}
    found = {_pair(s): s for s in (*_disjoint_chains(plain), *_circles(plain))}
    meant = (s for s in found.values() if _has_meaning(s, relations))
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

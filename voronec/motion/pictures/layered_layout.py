"""A layered layout of a directed graph: edges lead from left to right, and cross little.

Layers come from longest chains of edges.  The order in them is that of networkx's spectral
ordering, by Fiedler's vector, the second one of the Laplacian of the graph: neighbours
are near each other in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

Node = Any
Point = tuple[float, float]


@dataclass(frozen=True)
class Layout:
    """Where nodes are, in layers 0, 1, ... and heights; ``bends`` are the points on the way of an
    edge (source, target) that passes layers; ``alone`` are the nodes without edges."""

    places: Mapping[Node, Point]
    bends: Mapping[tuple[Node, Node], tuple[Point, ...]]
    alone: tuple[Node, ...]


def layered_layout(graph: Any) -> Layout:
    """The layout of a networkx graph.  Loops are left out; circles are cut somewhere."""
    import networkx

    edges = sorted({(a, b) for a, b in graph.edges() if a != b})
    layer = _layers(edges)
    chains = {(a, b): _chain(a, b, layer) for a, b in edges}
    links = networkx.Graph(pair for chain in chains.values() for pair in pairwise(chain))
    order = networkx.spectral_ordering(links, method="tracemin_lu", seed=0) if edges else []
    rows: dict[int, list[Node]] = {}
    for node in order:
        rows.setdefault(layer[node] if node in layer else node[2], []).append(node)
    where = {
        node: (float(i), k - (len(row) - 1) / 2)
        for i, row in rows.items()
        for k, node in enumerate(row)
    }
    return Layout(
        {node: where[node] for node in layer},
        {pair: tuple(where[node] for node in chain[1:-1]) for pair, chain in chains.items()},
        tuple(sorted(node for node in graph if node not in layer)),
    )


def _layers(edges: Sequence[tuple[Node, Node]]) -> dict[Node, int]:
    """Each node as many layers from the right end as its longest chain of edges has."""
    import networkx

    acyclic = networkx.DiGraph()
    acyclic.add_nodes_from(sorted({node for edge in edges for node in edge}))
    for a, b in edges:
        if not networkx.has_path(acyclic, b, a):
            acyclic.add_edge(a, b)
    layers = [*networkx.topological_generations(acyclic.reverse())]
    return {node: i for i, layer in enumerate(reversed(layers)) for node in layer}


def _chain(a: Node, b: Node, layer: Mapping[Node, int]) -> list[Node]:
    """The ends of an edge, with a stand-in in each layer that it passes."""
    step = 1 if layer[b] > layer[a] else -1
    between = range(layer[a] + step, layer[b], step)
    return [a, *((a, b, i) for i in between), b]

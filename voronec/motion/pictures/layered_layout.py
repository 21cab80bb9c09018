"""A layered layout of a directed graph: edges lead from left to right, and cross little."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

__all__ = ["Layout", "layered_layout"]

SWEEPS = 24
"""How often the order in the layers is improved, forth and back."""

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
    edges = sorted({(a, b) for a, b in graph.edges() if a != b})
    nodes = sorted({n for edge in edges for n in edge})
    layer = _layers(nodes, edges)
    chains = {(a, b): _chain(a, b, layer) for a, b in edges}
    rows: dict[int, list[Node]] = {i: [] for i in range(max(layer.values(), default=-1) + 1)}
    for node in nodes:
        rows[layer[node]].append(node)
    for chain in chains.values():
        for dummy in chain[1:-1]:
            rows[dummy[2]].append(dummy)
    links = [pair for chain in chains.values() for pair in pairwise(chain)]
    heights = _heights(_order_layers(rows, links), links)
    where = {n: (float(i), heights[n]) for i, row in rows.items() for n in row}
    return Layout(
        {n: where[n] for n in nodes},
        {pair: tuple(where[d] for d in chain[1:-1]) for pair, chain in chains.items()},
        tuple(sorted(n for n in graph if n not in layer)),
    )


def _layers(nodes: Sequence[Node], edges: Sequence[tuple[Node, Node]]) -> dict[Node, int]:
    """Each node as many layers from the right end as its longest chain of edges has."""
    import networkx

    acyclic = networkx.DiGraph()
    acyclic.add_nodes_from(nodes)
    for a, b in edges:
        if not networkx.has_path(acyclic, b, a):
            acyclic.add_edge(a, b)
    depth: dict[Node, int] = {}
    for node in reversed(list(networkx.topological_sort(acyclic))):
        depth[node] = max((depth[n] + 1 for n in acyclic.successors(node)), default=0)
    last = max(depth.values(), default=0)
    return {node: last - d for node, d in depth.items()}


def _chain(a: Node, b: Node, layer: Mapping[Node, int]) -> list[Node]:
    """The ends of an edge, with a stand-in in each layer that it passes."""
    step = 1 if layer[b] > layer[a] else -1
    between = range(layer[a] + step, layer[b], step)
    return [a, *((a, b, i) for i in between), b]


def _neighbours(links: Iterable[tuple[Node, Node]]) -> dict[Node, list[Node]]:
    """Node -> the nodes at the other ends of its links."""
    near: dict[Node, list[Node]] = {}
    for a, b in links:
        near.setdefault(a, []).append(b)
        near.setdefault(b, []).append(a)
    return near


def _order_layers(
    rows: dict[int, list[Node]], links: Iterable[tuple[Node, Node]]
) -> list[list[Node]]:
    """The layers, each sorted by the mean place of the neighbours, forth and back."""
    near = _neighbours(links)
    layer = {n: i for i, row in rows.items() for n in row}
    found = [sorted(rows[i], key=str) for i in sorted(rows)]
    best, fewest = [list(row) for row in found], _crossings(found, near, layer)
    for sweep in range(SWEEPS):
        forth = sweep % 2 == 0
        order = range(1, len(found)) if forth else range(len(found) - 2, -1, -1)
        for i in order:
            beside = found[i - 1 if forth else i + 1]
            place = {n: k for k, n in enumerate(beside)}
            found[i] = _by_neighbours(found[i], near, place)
        crossing = _crossings(found, near, layer)
        if crossing < fewest:
            best, fewest = [list(row) for row in found], crossing
    return best


def _by_neighbours(
    row: Sequence[Node], near: Mapping[Node, Sequence[Node]], place: Mapping[Node, int]
) -> list[Node]:
    """A layer by the mean places of neighbours in the one beside it; who has none, stays."""
    key = {}
    for k, node in enumerate(row):
        seen = [place[n] for n in near.get(node, ()) if n in place]
        key[node] = sum(seen) / len(seen) if seen else float(k)
    return sorted(row, key=lambda n: key[n])


def _crossings(
    rows: Sequence[Sequence[Node]], near: Mapping[Node, Sequence[Node]], layer: Mapping[Node, int]
) -> int:
    """How many pairs of links cross."""
    count = 0
    for i, row in enumerate(rows[:-1]):
        place = {n: k for k, n in enumerate(rows[i + 1])}
        ends = [
            (k, place[m]) for k, n in enumerate(row) for m in near.get(n, ()) if layer[m] == i + 1
        ]
        count += sum((a - c) * (b - d) < 0 for p, (a, b) in enumerate(ends) for c, d in ends[:p])
    return count


def _heights(
    rows: Sequence[Sequence[Node]], links: Iterable[tuple[Node, Node]]
) -> dict[Node, float]:
    """Heights that keep the order and one unit of distance, near to those of the neighbours."""
    near = _neighbours(links)
    size = max(map(len, rows), default=0)
    height = {
        n: k + (size - len(row)) / 2 for row in rows for k, n in enumerate(row)
    }  # fmt: skip
    for _ in range(60):
        for row in rows:
            wish = [_mean([height[m] for m in near.get(n, ())], height[n]) for n in row]
            for n, h in zip(row, _apart(wish, [_gap(n) for n in row]), strict=True):
                height[n] = h
    return _close_gaps(height)


def _close_gaps(height: Mapping[Node, float]) -> dict[Node, float]:
    """The heights without bands in which nothing lies."""
    found: dict[Node, float] = {}
    before, now = None, 0.0
    for node in sorted(height, key=lambda n: (height[n], str(n))):
        now += 0.0 if before is None else min(height[node] - before, 1.0)
        before = height[node]
        found[node] = now
    return found


def _gap(node: Node) -> float:
    """Half the room that a node takes; the stand-ins of long edges need less."""
    return 0.28 if isinstance(node, tuple) else 0.5


def _mean(values: Sequence[float], other: float) -> float:
    return (sum(values) / len(values) + other) / 2 if values else other


def _apart(wish: Sequence[float], room: Sequence[float]) -> list[float]:
    """The nearest heights in the same order at sufficient distances: pooled where they clash."""
    shift = [0.0]
    for a, b in pairwise(room):
        shift.append(shift[-1] + a + b)
    blocks: list[tuple[float, int]] = []
    for w, s in zip(wish, shift, strict=True):
        total, count = w - s, 1
        while blocks and blocks[-1][0] / blocks[-1][1] > total / count:
            before, n = blocks.pop()
            total, count = total + before, count + n
        blocks.append((total, count))
    flat = [total / count for total, count in blocks for _ in range(count)]
    return [f + s for f, s in zip(flat, shift, strict=True)]

"""Which variables the rates of which others hold: a directed graph, and what a scene needs of it.

An edge x -> y says that the rate of y holds x.  On normal forms that is exact.  Velocities that the
mass matrix couples are solved for together, so each stands for the whole block.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from voronec.motion.model.level import Level

if TYPE_CHECKING:
    import networkx as nx

__all__ = ["blocks", "cyclic", "dependence", "holds", "needed_variables", "restricted"]


def blocks(level: Level) -> list[list[int]]:
    """Positions of velocities that the mass matrix couples, block by block."""
    import networkx as nx

    n = len(level.velocities)
    coupling = nx.Graph()
    coupling.add_nodes_from(range(n))
    coupling.add_edges_from(
        (i, j) for i in range(n) for j in range(n) if i != j and level.mass[i][j] != 0
    )
    return [sorted(block) for block in nx.connected_components(coupling)]


def dependence(level: Level) -> nx.DiGraph:
    """The graph of a level's variables."""
    import networkx as nx

    graph = nx.DiGraph()
    graph.add_nodes_from(level.variables)
    for q, rate in zip(level.positions, level.rates, strict=True):
        graph.add_edges_from((x, q) for x in holds(level, [rate]))
    for block in blocks(level):
        inside = [level.mass[i][j] for i in block for j in block]
        inside += [level.force[i] for i in block]
        own = [level.velocities[i] for i in block]
        shared = own if len(own) > 1 else []
        sources = {*holds(level, inside), *shared}
        graph.add_edges_from((x, v) for x in sources for v in own)
    return graph


def holds(level: Level, exprs: Iterable[Any]) -> list[Any]:
    """The variables of a level on which expressions depend, those inside stages included."""
    stages = dict(level.stages)
    seen: set[Any] = set()
    stack = [s for e in exprs for s in e.free_symbols]
    while stack:
        symbol = stack.pop()
        if symbol not in seen:
            seen.add(symbol)
            if symbol in stages:
                stack.extend(stages[symbol].free_symbols)
    return [x for x in level.variables if x in seen]


def needed_variables(level: Level, graph: nx.DiGraph) -> list[Any]:
    """The smallest closed set of variables on which the outputs depend."""
    import networkx as nx

    exprs = [*level.outputs.values()]
    for angle in level.angles.values():
        exprs += [angle.cosine, angle.sine]
    roots = holds(level, exprs)
    closed = set(roots).union(*(nx.ancestors(graph, x) for x in roots))
    return [x for x in level.variables if x in closed]


def cyclic(graph: nx.DiGraph, kept: Sequence[Any]) -> set[Any]:
    """The variables that take part in a cycle of dependence; the others are quadratures."""
    import networkx as nx

    inside = graph.subgraph(kept)
    found: set[Any] = set()
    for component in nx.strongly_connected_components(inside):
        x = next(iter(component))
        if len(component) > 1 or inside.has_edge(x, x):
            found |= component
    return found


def restricted(level: Level, kept: Iterable[Any]) -> Level:
    """The level with some of its variables; the rest must not occur in what is kept."""
    held = set(kept)
    at = [i for i, q in enumerate(level.positions) if q in held]
    moving = [i for i, v in enumerate(level.velocities) if v in held]
    usable = {*held, *level.parameters, level.time}
    stages = []
    for name, expr in level.stages:
        if expr.free_symbols <= usable:
            stages.append((name, expr))
            usable.add(name)
    return replace(
        level,
        positions=tuple(level.positions[i] for i in at),
        velocities=tuple(level.velocities[i] for i in moving),
        rates=tuple(level.rates[i] for i in at),
        mass=tuple(tuple(level.mass[i][j] for j in moving) for i in moving),
        force=tuple(level.force[i] for i in moving),
        relations=tuple(r for r in level.relations if r.free_symbols <= usable),
        integrals={n: e for n, e in level.integrals.items() if e.free_symbols <= usable},
        stages=tuple(stages),
    )

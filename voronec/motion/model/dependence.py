"""Which variables the rates of which others hold: what a scene needs of a level.

On normal forms that is exact.  Velocities that the mass matrix couples are solved for together, so
each stands for the whole block.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from voronec.motion.model.level import Level

__all__ = ["blocks", "closure", "cyclic", "dependence", "holds", "needed_variables", "restrict"]

Sources = Mapping[Any, tuple[Any, ...]]
"""The variables that the rate of each variable holds."""


def blocks(level: Level) -> list[list[int]]:
    """Positions of velocities that the mass matrix couples, block by block."""
    mass, left = level.mass, [*range(len(level.velocities))]
    coupled = {i: [j for j in left if mass[i][j] != 0 or mass[j][i] != 0] for i in left}
    found = []
    while left:
        block = closure(coupled, left[:1])
        found.append(sorted(block))
        left = [i for i in left if i not in block]
    return found


def dependence(level: Level) -> Sources:
    """What the rate of each variable of a level holds."""
    found = {
        q: tuple(holds(level, [rate])) for q, rate in zip(level.positions, level.rates, strict=True)
    }
    for block in blocks(level):
        inside = [level.mass[i][j] for i in block for j in block]
        inside += [level.force[i] for i in block]
        own = [level.velocities[i] for i in block]
        shared = own if len(own) > 1 else []
        sources = tuple(dict.fromkeys([*holds(level, inside), *shared]))
        found |= dict.fromkeys(own, sources)
    return found


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


def needed_variables(level: Level, sources: Sources) -> list[Any]:
    """The smallest closed set of variables on which the outputs depend."""
    exprs = [*level.outputs.values()]
    for angle in level.angles.values():
        exprs += [angle.cosine, angle.sine]
    closed = closure(sources, holds(level, exprs))
    return [x for x in level.variables if x in closed]


def cyclic(sources: Sources, kept: Sequence[Any]) -> set[Any]:
    """The variables that take part in a cycle of dependence; the others are quadratures."""
    inside = {x: tuple(y for y in sources[x] if y in kept) for x in kept}
    return {x for x in kept if x in closure(inside, inside[x])}


def closure(sources: Mapping[Any, Sequence[Any]], roots: Iterable[Any]) -> set[Any]:
    """The roots, and all on which they depend."""
    found: set[Any] = set()
    stack = [*roots]
    while stack:
        x = stack.pop()
        if x not in found:
            found.add(x)
            stack += sources[x]
    return found


def restrict(level: Level, kept: Iterable[Any]) -> Level:
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

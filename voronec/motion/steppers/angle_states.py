"""Which states are angles: those that the equations hold under sines and cosines only."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

import symengine as se

from voronec.equations.program import Block

__all__ = ["angles_among"]


@lru_cache(maxsize=64)  # it is asked before every run
def angles_among(state: tuple[Any, ...], blocks: tuple[Block, ...]) -> tuple[int, ...]:
    """Positions of the states that blocks hold under sines and cosines only."""
    held = set().union(*(b.symbols for b in blocks))
    turned = _angles(blocks, [s for s in state if s in held])
    return tuple(i for i, s in enumerate(state) if s in turned)


def _angles(blocks: Iterable[Block], among: Iterable[Any]) -> set[Any]:
    """Those of the symbols that occur under sines and cosines only, in whole multiples."""
    found = set(among)
    for block in blocks:
        known: dict[Any, Mapping[Any, int]] = {s: {s: 1} for s in found}
        for name, expr in block.assignments:
            multiples = _multiples(expr, known, found)
            if multiples:
                known[name] = multiples
        for result in block.results:
            found -= set(_multiples(result, known, found))
    return found


def _multiples(
    expr: Any, known: Mapping[Any, Mapping[Any, int]], found: set[Any]
) -> dict[Any, int]:
    """The whole multiples of angles in an expression; an angle that is in it in any other way is
    struck off ``found``."""
    bare = [s for s in _bare(expr, known, found) if s in known]
    total: dict[Any, int] = {}
    for symbol in bare:
        slope = se.diff(expr, symbol)
        if slope.is_Number and slope == int(slope):
            for angle, n in known[symbol].items():
                total[angle] = total.get(angle, 0) + n * int(slope)
        else:
            found -= set(known[symbol])
    return {a: n for a, n in total.items() if n}


def _bare(expr: Any, known: Mapping[Any, Mapping[Any, int]], found: set[Any]) -> set[Any]:
    """Symbols outside of sines and cosines, whose arguments are looked at on the way."""
    result: set[Any] = set()
    stack = [expr]
    while stack:
        node = stack.pop()
        if type(node).__name__ in ("sin", "cos"):
            _multiples(node.args[0], known, found)
        elif node.is_Symbol:
            result.add(node)
        else:
            stack.extend(node.args)
    return result

"""Letters that stand for sums of places, so that normal forms do not write powers of them out.

(x - 1000)^5 + x is a sum of powers of x in normal form, terms of 1e15 which leave 1001 at x = 1001:
in doubles it is rounding.  With a function a(x) in the place of x - 1000 it stays a^5 + x.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.graphs import is_atom, nodes, rebuild

__all__ = ["StandIns"]


@dataclass(frozen=True)
class StandIns:
    """Functions of places, and the sums that they stand for."""

    meaning: Mapping[Any, Any]

    @classmethod
    def of(cls, exprs: Iterable[Any], ground: Any, speeds: Iterable[Any] = ()) -> StandIns:
        """Those for the sums in ``exprs`` of which there are powers or products, and which hold a
        place for a term, or a speed beside a constant.

        Places are the coordinates and the time of the ``ground``, a definition or a form; sums hold
        these, ``speeds`` and parameters alone.  Redundant coordinates have normal forms of their
        own.
        """
        bound = set().union(*(r.free_symbols for r in ground.relations))
        places = [x for x in (*ground.coordinates, ground.time) if x not in bound]
        among = [*places, *speeds]
        known = {*among, *ground.parameters}

        def is_far(expr: Any) -> bool:
            if not isinstance(expr, se.Add) or not expr.free_symbols <= known:
                return False
            moving = [t for t in expr.args if _stands(t, among)]
            if not moving or not expr.free_symbols.isdisjoint(places):
                return any(_stands(t, places) for t in moving)
            return len(moving) < len(expr.args)

        found: dict[Any, None] = {}
        for node in nodes(map(se.sympify, exprs)):
            if isinstance(node, se.Pow) and node.args[1].is_Number and is_far(node.args[0]):
                found[node.args[0]] = None
            elif isinstance(node, se.Mul):
                sums = [factor for factor in node.args if is_far(factor)]
                found |= dict.fromkeys(sums if len(sums) > 1 else ())
        return cls({
            se.Function(f"sum {total}")(*[x for x in among if x in total.free_symbols]): total
            for total in found
        })  # fmt: skip

    def __or__(self, other: StandIns) -> StandIns:
        return StandIns({**self.meaning, **other.meaning})

    def hide(self, expr: Any) -> Any:
        """An expression with the functions in powers and products of their sums."""
        names = {total: name for name, total in self.meaning.items()}
        known: dict[Any, Any] = {}

        def read(node: Any) -> Any:
            if node not in known:
                known[node] = node if is_atom(node) or not node.args else rebuild(
                    node, [names[a] if a in names and isinstance(node, se.Mul | se.Pow) else read(a)
                           for a in node.args]
                )  # fmt: skip
            return known[node]

        return read(se.sympify(expr))

    def show(self, expr: Any) -> Any:
        """The sums again, of what the functions are taken of by now, and their slopes."""
        meaning = {name.get_name(): (name.args, total) for name, total in self.meaning.items()}
        known: dict[Any, Any] = {}

        def read(node: Any) -> Any:
            if node not in known:
                known[node] = spell(node)
            return known[node]

        def spell(node: Any) -> Any:
            if isinstance(node, se.Derivative) and node.args[0] in self.meaning:
                slope = self.meaning[node.args[0]]
                for place in node.args[1:]:
                    slope = slope.diff(place)
                return slope
            if isinstance(node, se.FunctionSymbol) and node.get_name() in meaning:
                letters, total = meaning[node.get_name()]
                return total.xreplace(dict(zip(letters, map(read, node.args), strict=True)))
            if is_atom(node) or not node.args:
                return node
            return rebuild(node, [*map(read, node.args)])

        return read(se.sympify(expr)) if meaning else expr


def _stands(term: Any, places: list[Any]) -> bool:
    """Whether a place stands in a term outside of functions, such as the exponential is one."""
    if isinstance(term, se.Symbol):
        return term in places
    if isinstance(term, se.Pow):
        return bool(term.args[1].is_Number) and _stands(term.args[0], places)
    return isinstance(term, se.Add | se.Mul) and any(_stands(a, places) for a in term.args)

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
    def of(cls, exprs: Iterable[Any], ground: Any) -> StandIns:
        """Those for the sums in ``exprs`` with a place for a term, of which there are powers or
        products.

        Places are the coordinates and the time of the ``ground``, a definition or a form; sums hold
        these and parameters alone.  Redundant coordinates have normal forms of their own.
        """
        bound = set().union(*(r.free_symbols for r in ground.relations))
        among = [x for x in (*ground.coordinates, ground.time) if x not in bound]
        still = {*ground.parameters}

        def is_far(expr: Any) -> bool:
            if not (isinstance(expr, se.Add) and _stands(expr, among)):
                return False
            return all(s in among or s in still for s in expr.free_symbols)

        found: dict[Any, None] = {}
        for node in nodes(map(se.sympify, exprs)):
            if isinstance(node, se.Pow) and node.args[1].is_Number and is_far(node.args[0]):
                found[node.args[0]] = None
            elif isinstance(node, se.Mul):
                sums = [factor for factor in node.args if is_far(factor)]
                found |= dict.fromkeys(sums if len(sums) > 1 else ())
        return cls({
            se.Function(f"sum {i}")(*[x for x in among if x in total.free_symbols]): total
            for i, total in enumerate(sorted(found, key=str))
        })  # fmt: skip

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
        """The sums again, and their slopes for those of the functions."""
        slopes = {}
        for node in nodes([expr]):
            if isinstance(node, se.Derivative) and node.args[0] in self.meaning:
                slope = self.meaning[node.args[0]]
                for place in node.args[1:]:
                    slope = slope.diff(place)
                slopes[node] = slope
        return expr.xreplace(slopes).xreplace(dict(self.meaning))


def _stands(term: Any, places: list[Any]) -> bool:
    """Whether a place stands in a term outside of functions."""
    if isinstance(term, se.Symbol):
        return term in places
    return isinstance(term, se.Add | se.Mul | se.Pow) and any(_stands(a, places) for a in term.args)

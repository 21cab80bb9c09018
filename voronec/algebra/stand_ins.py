"""Letters that stand for sums of places, so that normal forms do not write powers of them out.

(x - 1000)^5 + x is a sum of powers of x in normal form, terms of 1e15 which leave 1001 at x = 1001:
in doubles it is rounding.  With a function a(x) in the place of x - 1000 it stays a^5 + x.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import symengine as se

from voronec.algebra.graphs import is_atom, nodes, rebuild
from voronec.algebra.terms import factors_of, subexpressions

__all__ = ["OriginShift", "StandIns"]


@dataclass(frozen=True)
class PlaceSymbols:
    """Places, and the constants beside which they stand in distances: x - c."""

    symbols: tuple[Any, ...]
    constants: frozenset[Any]

    @classmethod
    def of(cls, ground: Any) -> PlaceSymbols:
        """The coordinates and the time of a ground; redundant coordinates are no places."""
        bound = set().union(*(r.free_symbols for r in ground.relations))
        symbols = (x for x in (*ground.coordinates, ground.time) if x not in bound)
        return cls(tuple(symbols), frozenset(ground.parameters))

    def split(self, total: Any) -> tuple[Any, Any, Any]:
        """The distance in a sum, as a number and what it is a multiple of, c - x of x - c; and the
        rest.  Zeros where there is none: linear in places, it holds a constant, or stays where the
        origin moves, as x - y does."""
        zero = se.Integer(0)
        terms = total.args if isinstance(total, se.Add) else ()
        linear = [t for t in terms if self.is_linear(t)]
        if not linear:
            return zero, zero, total
        constant = [t for t in terms if t.free_symbols <= self.constants]
        part = se.Add(*constant, *linear)
        moved = part.xreplace(dict.fromkeys(self.symbols, se.Integer(1)))
        if not (constant or se.expand(moved) == 0):
            return zero, zero, total
        slope = part.diff(next(x for x in self.symbols if x in part.free_symbols))
        scale = slope if slope.is_Number else se.Integer(1)
        rest = [t for t in terms if t not in constant and t not in linear]
        return scale, se.expand(part / scale), se.Add(*rest)

    def is_linear(self, term: Any) -> bool:
        """Whether a term is a place times constants."""
        factors = factors_of(term)
        places = [f for f in factors if f.is_Symbol and f in self.symbols]
        rest = (f for f in factors if f not in places)
        return len(places) == 1 and all(f.free_symbols <= self.constants for f in rest)

    def distances(self, exprs: Iterable[Any]) -> dict[Any, None]:
        """The distances in sums, as these stand in one another outside of functions."""
        found, sums = dict[Any, None](), (se.Add, se.Mul, se.Pow)
        for node in subexpressions(exprs, lambda part: not isinstance(part, sums)):
            scale, distance, _ = self.split(node)
            found |= {distance: None} if scale != 0 else {}
        return found


@dataclass(frozen=True)
class StandIns:
    """Functions of places, and the sums that they stand for."""

    meaning: Mapping[Any, Any]
    places: PlaceSymbols = PlaceSymbols((), frozenset())

    @classmethod
    def of(cls, exprs: Iterable[Any], ground: Any, speeds: Iterable[Any] = ()) -> StandIns:
        """Those for the sums in ``exprs`` of which there are powers or products, and which hold a
        place for a term, or a speed beside a constant.

        Places are the coordinates and the time of the ``ground``, a definition or a form; sums hold
        these, ``speeds`` and parameters alone.  Of sums that hold more, the distances have letters:
        y - c in (xdot - w (y - c))^2.  Redundant coordinates have normal forms of their own.
        """
        ours = PlaceSymbols.of(ground)
        places = [*ours.symbols]
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
            if isinstance(node, se.Pow) and node.args[1].is_Number:
                sums = [node.args[0]]
            elif isinstance(node, se.Mul):
                sums = [factor for factor in node.args if isinstance(factor, se.Add)]
            else:
                continue
            far = dict.fromkeys(total for total in sums if is_far(total))
            far |= ours.distances(total for total in sums if total not in far)
            if len(far) > 1 or isinstance(node, se.Pow):
                found |= far
        return cls._by_name(found, among, ours)

    @classmethod
    def of_distances(cls, exprs: Iterable[Any], ground: Any) -> StandIns:
        """Those for all distances in ``exprs``, of which products will be taken."""
        places = PlaceSymbols.of(ground)
        return cls._by_name(places.distances(map(se.sympify, exprs)), places.symbols, places)

    @classmethod
    def _by_name(cls, sums: Iterable[Any], among: Sequence[Any], places: PlaceSymbols) -> StandIns:
        """With a function for each of the sums, of those symbols ``among`` some that it holds."""
        names = {}
        for total in sums:
            _, distance, rest = places.split(total)
            whole = distance if rest == 0 else total
            held = [x for x in among if x in whole.free_symbols]
            names[se.Function(f"sum {whole}")(*held)] = whole
        return cls(names, places)

    def __or__(self, other: StandIns) -> StandIns:
        return StandIns({**self.meaning, **other.meaning}, self.places)

    def hide(self, expr: Any, alone: bool = False) -> Any:
        """An expression with the functions in powers and products of their sums; ``alone``: where
        it is such a sum itself, too."""
        names = {total: name for name, total in self.meaning.items()}

        @cache
        def read(node: Any) -> Any:
            if is_atom(node) or not node.args:
                return node
            product = isinstance(node, se.Mul | se.Pow)
            return rebuild(node, [factor(a) if product else read(a) for a in node.args])

        def factor(node: Any) -> Any:
            if node in names:
                return names[node]
            scale, distance, rest = self.places.split(node)
            return scale * names[distance] + read(rest) if distance in names else read(node)

        return (factor if alone else read)(se.sympify(expr)) if names else expr

    def show(self, expr: Any) -> Any:
        """The sums again, of what the functions are taken of by now, and their slopes."""
        meaning = {name.get_name(): (name.args, total) for name, total in self.meaning.items()}

        @cache
        def read(node: Any) -> Any:
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


@dataclass(frozen=True)
class OriginShift:
    """Letters for the distances in relations, d for x - c in (x - c)^2 + y^2 - 1, and what symbols
    are in these, x = d + c.

    Polynomials on the relations are reduced in d, and with x - c in its place keep their digits far
    from the origin.  A symbol is left as it stands inside of functions, and so is every polynomial
    where relations hold no power and no product of a distance.
    """

    meaning: Mapping[Any, Any]
    values: Mapping[Any, Any]
    places: PlaceSymbols

    @classmethod
    def of(cls, relations: Sequence[Any]) -> OriginShift:
        """The shift to the distances of which ``relations`` hold powers and products."""
        held = [se.sympify(r) for r in relations]
        products = [n for n in nodes(held) if isinstance(n, se.Mul | se.Pow)]
        sums = {a for n in products for a in n.args if isinstance(a, se.Add)}
        symbols = sorted(set().union(*(total.free_symbols for total in sums)), key=str)
        places = PlaceSymbols(tuple(symbols), frozenset())
        meaning, values = dict[Any, Any](), dict[Any, Any]()
        for distance in sorted(places.distances(sums), key=str):
            own = distance.xreplace(values)
            fixed = set().union(*(e.free_symbols for e in values.values()))
            free = [x for x in symbols if x in own.free_symbols and x not in fixed]
            if free:
                letter = se.Symbol(f"distance {distance}")
                meaning[letter] = distance
                slope = own.diff(free[0])
                values[free[0]] = se.expand(free[0] + (letter - own) / slope)
        return cls(meaning, values, places)

    def hide(self, expr: Any) -> Any:
        """An expression in the distances."""

        @cache
        def read(node: Any) -> Any:
            if isinstance(node, se.Add):  # c of x = d + c and of x - c are to cancel
                linear = [t for t in node.args if self.places.is_linear(t)]
                rest = [read(t) for t in node.args if t not in linear]
                return se.Add(se.expand(se.Add(*linear).xreplace(self.values)), *rest)
            if isinstance(node, se.Mul) or (isinstance(node, se.Pow) and node.args[1].is_Number):
                return rebuild(node, [*map(read, node.args)])
            return self.values.get(node, node)

        return read(se.sympify(expr)) if self.values else expr

    def show(self, expr: Any) -> Any:
        """The expression again, with the distances as they are."""
        return expr.xreplace(self.meaning) if self.meaning else expr

"""What is one thing on one side of a wall and another beyond, as a choice between the two.

Min, Max and cases come as absolute values and signs, (a + b - |a - b|)/2 and A (1 + sign w)/2 +
B (1 - sign w)/2: exact, but in doubles min(1, exp 40) loses all digits, and a case that is not in
force may be infinite.  Programs that are printed choose:

    choice(w, p, n) = p for w > 0,  n for w < 0,  (p + n)/2 between.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import symengine as se

from voronec.algebra.graphs import nodes
from voronec.algebra.normal import canonical
from voronec.algebra.numeric_functions import CHOICE, numeric_name
from voronec.algebra.stages import split_number
from voronec.algebra.terms import factors_of, summands
from voronec.equations.program.weight import operation_count
from voronec.errors import EngineLimit

__all__ = ["choose_sides"]

LONGER = 8
"""An expression is not made so many times as long: choices in choices double what they hold."""
SHORT = 60
"""Operations up to which a term is multiplied out, so that what cancels does."""
FRACTION = 240
"""Operations up to which all terms of a sum with quotients are chosen together."""
LONG = 3000
"""Expressions of more operations stay as they are."""
ZERO = se.Integer(0)


def choose_sides(expr: Any) -> Any:
    """The expression with choices in place of sums that absolute values and signs hold together;
    one that would grow by far stays as it is."""
    expr = se.sympify(expr)
    size = operation_count([expr])
    found = _Choices().settle(expr) if size < LONG else expr
    return found if operation_count([found]) <= LONGER * (size + SHORT) else expr


@dataclass(frozen=True)
class _Choices:
    """Makes choices; ``known`` are the walls of each expression that was looked at."""

    known: dict[Any, frozenset[Any]] = field(default_factory=dict)

    def walls(self, expr: Any) -> frozenset[Any]:
        """The arguments of all signs and absolute values in an expression."""
        found = self.known.get(expr)
        if found is None:
            found = frozenset[Any]().union(*map(self.walls, expr.args))
            if isinstance(expr, (se.sign, se.Abs)):
                found |= {expr.args[0]}
            self.known[expr] = found
        return found

    def settle(self, expr: Any, kept: frozenset[Any] = frozenset()) -> Any:
        """The expression with a choice at every wall but those that are ``kept``, of which nothing
        cancels; walls that hold others after these."""
        while left := self.walls(expr) - kept:
            wall = min(left, key=lambda w: (len(self.walls(w)), str(w)))
            expr, kept = self.choose(expr, wall), kept | {wall}
        return expr

    def choose(self, expr: Any, wall: Any) -> Any:
        """The expression with a choice at a wall, in the smallest sums that hold it."""
        if wall not in self.walls(expr) or (_jumps(expr) and expr.args[0] == wall):
            return expr
        held = [wall in self.walls(a) for a in expr.args]
        if sum(held) > 1 or isinstance(expr, se.Add):
            return self.choose_terms(expr, wall)
        pairs = zip(expr.args, held, strict=True)
        args = [self.choose(a, wall) if is_held else a for a, is_held in pairs]
        return _product(args) if isinstance(expr, se.Mul) else expr.func(*args)

    def choose_terms(self, expr: Any, wall: Any) -> Any:
        """A sum, with a choice for the terms that hold the wall and those that these may cancel."""
        terms = [t for a in summands(expr) for t in summands(_spread(a))]
        held = [t for t in terms if wall in self.walls(t)]
        keys, beside = _magnitudes(se.Add(*held)), self.walls(se.Add(*held))
        own = [
            t for t in terms
            if split_number(t)[0] in keys or (self.walls(t) and self.walls(t) <= beside)
        ]  # fmt: skip
        if operation_count([expr]) < FRACTION and _has_quotients(expr):
            own = terms
        up, down = (_short(self.on_side(se.Add(*own), wall, side)) for side in (1, -1))
        if up == _spread(-down):  # k |w| or k sign(w), of which nothing cancels
            return expr
        rest = se.Add(*[t for t in terms if t not in own])
        kept = frozenset({wall})
        return rest + _choice(wall, self.settle(up, kept), self.settle(down, kept))

    def on_side(self, expr: Any, wall: Any, side: int) -> Any:
        """The expression where a wall has a sign."""
        if _jumps(expr) and expr.args[0] == wall:
            return se.Integer(side) if isinstance(expr, se.sign) else side * wall
        if wall not in self.walls(expr):
            return expr
        args = [self.on_side(a, wall, side) for a in expr.args]
        if isinstance(expr, se.Add):
            args = [_spread(a) for a in args]
        return expr.func(*args)


def _choice(wall: Any, up: Any, down: Any) -> Any:
    return up if up == down else se.Function(CHOICE)(wall, up, down)


def _product(factors: list[Any]) -> Any:
    """A product; all of it is chosen where one factor is zero on a side, for 0 times infinity."""
    for i, factor in enumerate(factors):
        if numeric_name(factor) == CHOICE and ZERO in factor.args[1:]:
            wall, *sides = factor.args
            others = se.Mul(*factors[:i], *factors[i + 1 :])
            return _choice(wall, *(others * side for side in sides))
    return se.Mul(*factors)


def _jumps(node: Any) -> bool:
    return isinstance(node, (se.sign, se.Abs))


def _spread(expr: Any) -> Any:
    return expr.expand() if operation_count([expr]) < SHORT else expr


def _short(expr: Any) -> Any:
    """A sum multiplied out, as one fraction if that is shorter: parts over one denominator cancel
    where each over its own does not."""
    spread = _spread(expr)
    if operation_count([expr]) >= FRACTION or not _has_quotients(expr):
        return spread
    try:
        return min(spread, canonical([expr])[0], key=lambda e: operation_count([e]))
    except EngineLimit:
        return spread


def _has_quotients(expr: Any) -> bool:
    powers = (n for n in nodes([expr]) if isinstance(n, se.Pow) and n.args[1].is_Number)
    return any(n.args[1] < 0 and n.args[0].free_symbols for n in powers)


def _magnitudes(expr: Any) -> set[Any]:
    """The terms of an expression, but for numbers and signs of either value."""
    letters: dict[Any, Any] = {}
    found = summands(_spread(_with_letters(expr, letters)))
    signs = {*letters.values()}
    factors = (factors_of(split_number(t)[0]) for t in found)
    return {se.Mul(*[f for f in each if not f.free_symbols & signs]) for each in factors}


def _with_letters(expr: Any, letters: dict[Any, Any]) -> Any:
    """The expression with letters s for signs, and s w for absolute values."""
    if not expr.args:
        return expr
    args = [_with_letters(a, letters) for a in expr.args]
    if _jumps(expr):
        letter = letters.setdefault(args[0], se.Symbol(f"sign {len(letters)}"))
        return letter if isinstance(expr, se.sign) else letter * args[0]
    return expr.func(*args)

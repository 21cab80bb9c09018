"""What is one thing on one side of a wall and another beyond, as a choice between the two.

Min, Max and cases come as absolute values and signs, (a + b - |a - b|)/2 and A (1 + sign w)/2 +
B (1 - sign w)/2: exact, but in doubles min(1, exp 40) loses all digits, and a case that is not in
force may be infinite.  Programs that are printed choose:

    choice(w, p, n) = p for w > 0,  n for w < 0,  (p + n)/2 between.
"""

from __future__ import annotations

from typing import Any

import symengine as se

from voronec.algebra.graphs import nodes
from voronec.algebra.numeric_functions import CHOICE
from voronec.algebra.stages import coefficient
from voronec.algebra.terms import summands
from voronec.equations.program.weight import operation_count

__all__ = ["choose_sides"]

LONGER = 8
"""An expression is not made so many times as long: choices in choices double what they hold."""
SHORT = 60
"""Operations up to which a term is multiplied out, so that what cancels does."""
LONG = 3000
"""Expressions of more operations stay as they are."""


def choose_sides(expr: Any) -> Any:
    """The expression with choices in place of sums that absolute values and signs hold together;
    one that would grow by far stays as it is."""
    expr = se.sympify(expr)
    size = operation_count([expr])
    found = _settle(expr) if size < LONG else expr
    return found if operation_count([found]) <= LONGER * (size + SHORT) else expr


def _settle(expr: Any) -> Any:
    for wall in _walls(expr):
        expr = _choose(expr, wall)
    return expr


def _walls(expr: Any) -> list[Any]:
    """The arguments of signs and absolute values, those that hold fewest others first."""
    found = {n.args[0] for n in nodes([expr]) if _jumps(n)}
    return sorted(found, key=lambda w: (sum(map(_jumps, nodes([w]))), str(w)))


def _jumps(node: Any) -> bool:
    return isinstance(node, (se.sign, se.Abs))


def _holds(expr: Any, wall: Any) -> bool:
    return any(_jumps(n) and n.args[0] == wall for n in nodes([expr]))


def _choose(expr: Any, wall: Any) -> Any:
    """The expression with a choice at one wall, in the smallest sums and products that hold it."""
    if _jumps(expr) and expr.args[0] == wall:
        return expr
    held = [_holds(a, wall) for a in expr.args]
    if sum(held) > 1 or (any(held) and isinstance(expr, se.Add)):
        return _choose_terms(expr, wall)
    if any(held):
        pairs = zip(expr.args, held, strict=True)
        return expr.func(*[_choose(a, wall) if is_held else a for a, is_held in pairs])
    return expr


def _choose_terms(expr: Any, wall: Any) -> Any:
    """A sum, with a choice for the terms that hold the wall and those that these may cancel."""
    terms = [t for a in summands(expr) for t in summands(_spread(a))]
    held = [t for t in terms if _holds(t, wall)]
    keys = {_without_number(t) for t in summands(_spread(_without_walls(se.Add(*held))))}
    own = [t for t in terms if t in held or _without_number(t) in keys]
    up, down = (_spread(_on_side(se.Add(*own), wall, side)) for side in (1, -1))
    if up == _spread(-down):  # k |w| or k sign(w), of which nothing cancels
        return expr
    rest = se.Add(*[t for t in terms if t not in own])
    return rest + se.Function(CHOICE)(wall, _settle(up), _settle(down))


def _spread(expr: Any) -> Any:
    return expr.expand() if operation_count([expr]) < SHORT else expr


def _without_number(term: Any) -> Any:
    return se.Integer(1) if term.is_Number else term / coefficient(term)


def _without_walls(expr: Any) -> Any:
    """The expression without its walls, of some side: which one changes numbers of terms alone."""
    if not expr.args:
        return expr
    args = [_without_walls(a) for a in expr.args]
    if isinstance(expr, se.Abs):
        return args[0]
    return se.Integer(1) if isinstance(expr, se.sign) else expr.func(*args)


def _on_side(expr: Any, wall: Any, side: int) -> Any:
    """The expression where a wall has a sign."""
    if _jumps(expr) and expr.args[0] == wall:
        return se.Integer(side) if isinstance(expr, se.sign) else side * wall
    if not expr.args or not _holds(expr, wall):
        return expr
    args = [_on_side(a, wall, side) for a in expr.args]
    if isinstance(expr, se.Add):
        args = [_spread(a) for a in args]
    return expr.func(*args)

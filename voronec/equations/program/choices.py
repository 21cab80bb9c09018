"""What is one thing on one side of a switching surface and another beyond, as a choice between the
two.

Min, Max and cases come as absolute values and signs, (a + b - |a - b|)/2 and A (1 + sign w)/2 +
B (1 - sign w)/2: exact, but in doubles min(1, exp 40) loses all digits, and a case that is not in
force may be infinite.  Programs that are printed choose:

    choice(w, p, n) = p for w > 0,  n for w < 0,  (p + n)/2 between,
    case(w, p, z, n) = p for w > 0,  z for w = 0,  n for w < 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite
from typing import Any

import symengine as se

from voronec.algebra.graphs import nodes
from voronec.algebra.numeric_functions import CASE, CHOICE, numeric_name
from voronec.algebra.roots import known_sign
from voronec.algebra.stages import split_number
from voronec.algebra.terms import factors_of, summands
from voronec.equations.program.weight import operation_count

LONGER = 8
"""An expression is not made so many times as long: choices in choices double what they hold."""
SHORT = 60
"""Operations that every expression may have."""
LONG = 3000
"""Expressions of more operations stay as they are."""
ZERO = se.Integer(0)


def holds_switches(expr: Any) -> bool:
    """Whether an expression holds signs or absolute values."""
    return any(_jumps(n) for n in nodes([se.sympify(expr)]))


def holds_choices(expr: Any) -> bool:
    """Whether an expression holds a choice."""
    return any(numeric_name(n) in (CASE, CHOICE) for n in nodes([se.sympify(expr)]))


def choose_sides(expr: Any) -> Any:
    """The expression with choices in place of sums that absolute values and signs hold together;
    one that would grow by far stays as it is."""
    expr = se.sympify(expr)
    size = operation_count([expr])
    settled = _Choices().settle(expr) if size < LONG else expr
    return settled if operation_count([settled]) <= LONGER * (size + SHORT) else expr


@dataclass
class _Choices:
    """Makes choices; ``known`` are the switching surfaces of each expression that was looked at."""

    known: dict[Any, frozenset[Any]] = field(default_factory=dict)

    def switches(self, expr: Any) -> frozenset[Any]:
        """The arguments of all signs and absolute values in an expression."""
        surfaces = self.known.get(expr)
        if surfaces is None:
            surfaces = frozenset[Any]().union(*map(self.switches, expr.args))
            if isinstance(expr, (se.sign, se.Abs)):
                surfaces |= {expr.args[0]}
            self.known[expr] = surfaces
        return surfaces

    def settle(self, expr: Any, kept: frozenset[Any] = frozenset()) -> Any:
        """The expression with a choice at every switching surface but those that are ``kept``, of
        which nothing cancels; switching surfaces that hold others after these."""
        while left := self.switches(expr) - kept:
            switch = min(left, key=lambda w: (len(self.switches(w)), str(w)))
            expr, kept = self.choose(expr, switch), kept | {switch}
        return expr

    def choose(self, expr: Any, switch: Any) -> Any:
        """The expression with a choice at a switching surface, in the smallest sums that hold
        it."""
        if switch not in self.switches(expr) or (_jumps(expr) and expr.args[0] == switch):
            return expr
        held = [switch in self.switches(a) for a in expr.args]
        if sum(held) > 1 or isinstance(expr, se.Add) or _is_square(expr):
            return self.choose_terms(expr, switch)
        pairs = zip(expr.args, held, strict=True)
        args = [self.choose(a, switch) if is_held else a for a, is_held in pairs]
        return _product(args) if isinstance(expr, se.Mul) else _of_choice(expr.func, args)

    def choose_terms(self, expr: Any, switch: Any) -> Any:
        """A sum, with a choice for the terms that hold the switching surface and those that these
        may cancel."""
        terms = summands(_spread(expr))
        held = [t for t in terms if switch in self.switches(t)]
        keys, beside = _magnitudes(held), self.switches(se.Add(*held))
        switching = [
            t for t in terms
            if split_number(t)[0] in keys or (self.switches(t) and self.switches(t) <= beside)
        ]  # fmt: skip
        total, sign = se.Add(*switching), _sign_of(switch)
        up, on, down = (self.on_side(total, switch, s) for s in (sign or 1, 0, sign or -1))
        if sign and se.sign(switch) not in nodes([total]):
            on = up  # of absolute values alone, which do not jump
        if any(n in (se.nan, se.zoo) for n in nodes([on])):  # it has no value there
            on = (up + down) / 2
        if up == _spread(-down) and on == 0 and not _divides(switch, up):
            return expr  # k |w| or k sign(w), of which nothing cancels
        rest = se.Add(*[t for t in terms if t not in switching])
        kept = frozenset({switch})
        return rest + _choice(switch, *(self.settle(side, kept) for side in (up, on, down)))

    def on_side(self, expr: Any, switch: Any, side: int) -> Any:
        """The expression where a switching surface has a sign."""
        if _jumps(expr) and expr.args[0] == switch:
            return se.Integer(side) if isinstance(expr, se.sign) else side * switch
        if switch not in self.switches(expr):
            return expr
        return _spread(expr.func(*[self.on_side(a, switch, side) for a in expr.args]))


@lru_cache(maxsize=1024)
def _sign_of(switch: Any) -> int:
    """1 or -1 where a switching surface has nowhere the other sign, as a square, or 0: where it is
    never negative the root of -w^2 need not be real."""
    return known_sign(switch)


def _choice(switch: Any, up: Any, on: Any, down: Any) -> Any:
    if up == on == down:
        return up
    if _spread(2 * on - up - down) == 0:
        return se.Function(CHOICE)(switch, up, down)
    return se.Function(CASE)(switch, up, on, down)


def _parts(expr: Any) -> tuple[Any, Any, Any, Any] | None:
    """Of a choice its switching function, and the values where that is positive, zero and negative;
    None of anything else."""
    name = numeric_name(expr)
    if name == CASE:
        return expr.args
    if name == CHOICE:
        switch, up, down = expr.args
        return switch, up, (up + down) / 2, down
    return None


def _product(factors: list[Any]) -> Any:
    """A product; all of it is chosen where one factor is zero on a side, for 0 times infinity, or
    the same on both: the slope on the switching surface is theirs then."""
    for i, factor in enumerate(factors):
        if (parts := _parts(factor)) is None:
            continue
        switch, *sides = parts
        if ZERO in sides or sides[0] == sides[-1]:
            others = se.Mul(*factors[:i], *factors[i + 1 :])
            return _choice(switch, *(others * side for side in sides))
    return se.Mul(*factors)


def _of_choice(function: Any, args: list[Any]) -> Any:
    """A function of a choice; where a side is a number, a choice of its values: the slope of a root
    or an arcsine may be infinite there, and nothing moves on that side."""
    if len(args) < 3 and (parts := _parts(args[0])) is not None:
        switch, *sides = parts
        values = [_of_choice(function, [side, *args[1:]]) for side in sides]
        numbers = [value for value in values if not value.free_symbols]
        if (numbers or any(map(_parts, values))) and all(map(_is_real, numbers)):
            return _choice(switch, *values)
    return function(*args)


def _is_real(number: Any) -> bool:
    try:
        return isfinite(float(number))
    except (RuntimeError, TypeError, ValueError):  # of what is complex, or infinite
        return False


def _divides(switch: Any, expr: Any) -> bool:
    """Whether an expression divides by what vanishes where a switching surface does."""
    at = {switch: ZERO}
    return any(n.args[0].xreplace(at) == 0 for n in _quotients(expr))


def _jumps(node: Any) -> bool:
    return isinstance(node, (se.sign, se.Abs))


def _is_square(expr: Any) -> bool:
    """Whether an expression is a whole power of a sign."""
    return (
        isinstance(expr, se.Pow) and isinstance(expr.args[0], se.sign) and expr.args[1].is_Integer
    )


def _spread(expr: Any, letters: frozenset[Any] = frozenset()) -> Any:
    """A sum without brackets that stand behind numbers and ``letters`` alone: what cancels does,
    and quotients stay as they are, (1 - cos w)/w^2 above all."""
    if isinstance(expr, se.Add):
        return se.Add(*[_spread(a, letters) for a in expr.args])
    sums = [a for a in factors_of(expr) if isinstance(a, se.Add)]
    if len(sums) == 1 and (expr / sums[0]).free_symbols <= letters:
        return se.Add(*[_spread(expr / sums[0] * a, letters) for a in sums[0].args])
    return expr


def _quotients(expr: Any) -> Iterator[Any]:
    """The powers in an expression that divide."""
    powers = (n for n in nodes([expr]) if isinstance(n, se.Pow) and n.args[1].is_Number)
    return (n for n in powers if n.args[1] < 0)


def _magnitudes(terms: Iterable[Any]) -> set[Any]:
    """What terms are sums of, but for numbers and signs of either value."""
    letters: dict[Any, Any] = {}
    lettered = [_with_letters(t, letters) for t in terms]
    signs = frozenset(letters.values())
    parts = [part for t in lettered for part in summands(_spread(t, signs))]
    factors = (factors_of(split_number(t)[0]) for t in parts)
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

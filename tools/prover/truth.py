"""What is true, by a route of its own: SymPy trees as real numbers in mpmath.

Two of them part at points.  Nothing of the prover is used here, neither its door nor its balls."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from random import Random
from typing import Any

import mpmath as mp
import sympy as sp

DIGITS = 50
NEAR = mp.mpf(10) ** -30
"""What is nearer to a cut than this is on it for rounding, unless it is exactly zero there."""
APART = mp.mpf(10) ** -12
"""Two values are different where they are further apart than this, relatively, at both precisions:
statements are made with numbers of few digits."""
STEP = mp.mpf(10) ** -14
"""Of a central difference in 60 digits: its error is far below ``APART``."""
WALLS = (sp.Abs, sp.sign, sp.floor, sp.log, sp.atan2, sp.asin, sp.acos, sp.acosh, sp.atanh)


@dataclass(frozen=True)
class Statement:
    """Something that is asked of the prover, and whether it is true.

    ``sides`` are the two expressions of an identity, against which a witness is held.
    """

    family: str
    text: str
    true: bool
    ask: Callable[[], Any]
    sides: tuple[Any, Any] | None = None


class Outside(Exception):
    """A function has no real value there, or rounding decides which one it has."""


def number(expr: Any, at: Mapping[Any, Any]) -> Any:
    """A SymPy expression as a real number; ``Outside`` where it has none."""
    known: dict[Any, Any] = {}

    def value(e: Any) -> Any:
        if e not in known:
            known[e] = _value(e, at, value)
        return known[e]

    return value(sp.sympify(expr))


def slope(function: Any, at: Mapping[Any, Any], speeds: Mapping[Any, Any]) -> Any:
    """The rate of a function at a state that moves at some speeds, by a central difference."""
    ends = [
        number(function, {**at, **{s: at[s] + h * v for s, v in speeds.items()}})
        for h in (STEP, -STEP)
    ]
    return (ends[0] - ends[1]) / (2 * STEP)


def _value(e: Any, at: Mapping[Any, Any], value: Callable[[Any], Any]) -> Any:
    if e in at:
        return at[e]
    if isinstance(e, sp.Rational):
        return mp.mpf(int(e.p)) / int(e.q)
    if isinstance(e, sp.Float | sp.NumberSymbol):
        return mp.mpf(str(e)) if isinstance(e, sp.Float) else e._to_mpmath(mp.mp.prec)
    arguments = [value(a) for a in e.args]
    if isinstance(e, sp.Add):
        return mp.fsum(arguments)
    if isinstance(e, sp.Mul):
        return mp.fprod(arguments)
    if isinstance(e, sp.Pow):
        return _power(arguments[0], arguments[1], e.exp)
    rule = _FUNCTIONS.get(type(e).__name__)
    if rule is None:  # an infinity, the imaginary unit
        raise Outside
    return rule(*arguments)


def _nonzero(x: Any) -> Any:
    if abs(x) < NEAR:
        raise Outside
    return x


def _above(x: Any) -> Any:
    """A positive number, well away from zero."""
    if x < NEAR:
        raise Outside
    return x


def _power(base: Any, exponent: Any, written: Any) -> Any:
    if isinstance(written, sp.Integer):
        return (base if written >= 0 else _nonzero(base)) ** int(written)
    if base == 0 and isinstance(written, sp.Rational) and written > 0:
        return base
    return _above(base) ** exponent


def _sign(x: Any) -> Any:
    return mp.sign(x if x == 0 else _nonzero(x))


def _within(x: Any) -> Any:
    if abs(x) > 1 - NEAR and abs(x) != 1:
        raise Outside
    return x


def _whole(x: Any) -> Any:
    if x != mp.nint(x) and abs(x - mp.nint(x)) < NEAR:
        raise Outside
    return mp.floor(x)


def _angle(y: Any, x: Any) -> Any:
    on_cut = y == 0 and x < -NEAR  # exactly, where the angle is pi
    if abs(y) < NEAR and not x > NEAR and not on_cut:
        raise Outside
    return mp.atan2(y, x)


def _step(x: Any, middle: Any = None) -> Any:
    return (1 + mp.sign(_nonzero(x))) / 2


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": mp.sin, "cos": mp.cos, "tan": lambda x: mp.sin(x) / _nonzero(mp.cos(x)),
    "cot": lambda x: mp.cos(x) / _nonzero(mp.sin(x)), "sec": lambda x: 1 / _nonzero(mp.cos(x)),
    "csc": lambda x: 1 / _nonzero(mp.sin(x)), "asin": lambda x: mp.asin(_within(x)),
    "acos": lambda x: mp.acos(_within(x)), "atan": mp.atan, "atan2": _angle, "exp": mp.exp,
    "log": lambda x: mp.log(_above(x)), "sinh": mp.sinh, "cosh": mp.cosh, "tanh": mp.tanh,
    "coth": lambda x: mp.coth(_nonzero(x)), "asinh": mp.asinh,
    "acosh": lambda x: mp.acosh(_above(x - 1) + 1),
    "atanh": lambda x: mp.atanh(_within(x) if abs(x) != 1 else _above(0)),
    "Abs": abs, "sign": _sign, "floor": _whole, "Max": max, "Min": min, "Heaviside": _step,
}  # fmt: skip


def difference_at(left: Any, right: Any, at: Mapping[Any, Any]) -> bool | None:
    """Whether two sides differ at exact values; None where one of them has no real value.

    Seen at two precisions: what rounding makes, changes between them.
    """
    apart = []
    for digits in (DIGITS, 2 * DIGITS):
        with mp.workdps(digits):
            exact = {s: mp.mpf(int(v.p)) / int(v.q) for s, v in at.items()}
            try:
                a, b = number(left, exact), number(right, exact)
            except (Outside, ZeroDivisionError, OverflowError, ValueError):
                return None
            if not (mp.isfinite(a) and mp.isfinite(b)):
                return None
            apart.append(abs(a - b) > APART * (abs(a) + abs(b)) and abs(a - b) > NEAR)
    return apart[0] if apart[0] == apart[1] else None


def first_difference(
    left: Any, right: Any, possible: Callable[[Mapping[Any, Any]], bool], dice: Random
) -> dict[Any, Any] | None:
    """A point at which two sides differ, of many in all orthants, near cuts too; else None."""
    symbols = sorted(sp.Tuple(left, right).free_symbols, key=str)
    for at in _points(symbols, _cuts(left, right), dice):
        if possible(at) and difference_at(left, right, at):
            return at
    return None


def _cuts(*sides: Any) -> list[Any]:
    """Arguments of what has jumps, kinks, branches or ends where they vanish."""
    found: dict[Any, None] = {}
    for side in sides:
        for e in sp.preorder_traversal(sp.sympify(side)):
            if isinstance(e, WALLS):
                found.update(dict.fromkeys(e.args))
            elif isinstance(e, sp.Pow) and isinstance(e.exp, sp.Rational) and e.exp.q != 1:
                found[e.base] = None
    return [g for g in found if g.free_symbols][:8]


def _points(
    symbols: Sequence[Any], cuts: Sequence[Any], dice: Random
) -> Iterator[dict[Any, sp.Rational]]:
    few = [sp.Integer(0), sp.Integer(1), sp.Integer(-1), sp.Rational(1, 2), sp.Integer(2)]
    if not symbols:
        yield {}
        return
    signs = list(product((1, -1), repeat=min(len(symbols), 4)))
    for number_of_point in range(40):
        scale = (1, 1, 10, sp.Rational(1, 10), 100)[number_of_point % 5]
        row = [*signs[number_of_point % len(signs)]]
        row += [dice.choice((1, -1)) for _ in symbols[4:]]
        yield {
            q: s * sp.Rational(dice.randint(1, 300), 97) * scale
            for q, s in zip(symbols, row, strict=True)
        }
    for _ in range(15):
        yield {q: dice.choice(few) for q in symbols}
    for cut in cuts:
        yield from _beside(cut, symbols, dice)


def _beside(cut: Any, symbols: Sequence[Any], dice: Random) -> Iterator[dict[Any, sp.Rational]]:
    """Points on both sides of a zero of a function, by bisection between two points."""
    for _ in range(6):
        low, high = (
            {q: sp.Rational(dice.randint(-400, 400), 97) for q in symbols} for _ in range(2)
        )
        try:
            ends = [
                number(cut, {s: mp.mpf(v.p) / v.q for s, v in at.items()}) for at in (low, high)
            ]
            if ends[0] * ends[1] >= 0:
                continue
            for _ in range(24):
                middle = {q: (low[q] + high[q]) / 2 for q in symbols}
                here = number(cut, {s: mp.mpf(v.p) / v.q for s, v in middle.items()})
                low, high = (middle, high) if here * ends[0] > 0 else (low, middle)
        except (Outside, ZeroDivisionError, OverflowError, ValueError):
            continue
        yield low
        yield high

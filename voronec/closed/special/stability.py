"""Whether a motion with constant x is stable: the sign of the quartic f beside its double root.

Stable: x stays as near as one likes if the colatitude and the velocities begin near enough; angles
may drift.  f depends continuously on where a motion begins.  Where f < 0 on both sides at every
small distance, it stays so for motions that begin near, and x stays in between.  Where f > 0 on one
side, motions with the same constants begin there as near as one likes, and move away.  At x = 1 and
x = -1 only the inner side matters.  [DragovicGajicJovanovic2020, sec. "Special Solutions"]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.precision import FIRST, SHARP
from voronec.algebra.verdicts import prove_equal
from voronec.closed.arithmetic import ball, exact, precise
from voronec.declaration.quadratures import Quadratures
from voronec.errors import DefinitionError, EngineLimit

PRECISIONS = (FIRST, SHARP, 1024, 4096)
"""Bits at which a sign is looked for; after the second algebra is asked whether it is zero."""


@dataclass(frozen=True)
class Stability:
    """What was decided about a motion with constant x.

    order
        that of the first derivative of f at x which is not zero: 2, 3 or 4; 0 where f vanishes
        identically.
    sign
        of that derivative.
    derivatives
        f'', f''', f'''' at x, exactly.
    reason
        one sentence.
    """

    stable: bool
    order: int
    sign: int
    derivatives: tuple[sp.Expr, ...]
    reason: str


def sign_of(value: Any) -> int:
    """The sign of an exact number: by a ball that excludes zero, or by a proof that it is zero."""
    number = exact(value)
    if number.is_Rational:
        return int(sp.sign(number))
    for bits in PRECISIONS:
        with precise(bits):
            enclosure = ball(number)
        if enclosure > 0:
            return 1
        if enclosure < 0:
            return -1
        if bits == PRECISIONS[1] and prove_equal(number, 0).proved:
            return 0
    raise EngineLimit(f"the sign of '{number}' is not decided with {PRECISIONS[-1]} bits")


def decide_stability(
    quadratures: Quadratures,
    constants: Mapping[Any, Any],
    parameters: Mapping[Any, Any],
    place: sp.Expr,
) -> Stability:
    """Stability at a place, for exact values of everything.

    Raises ``DefinitionError`` where the place is no multiple root of the quartic.
    """
    x = quadratures.x
    known = {k: v for k, v in {**parameters, **constants}.items() if k != x}
    f = sp.expand(quadratures.quartic.xreplace(known))
    values = [sp.expand(sp.diff(f, x, order).xreplace({x: place})) for order in range(5)]
    signs = [sign_of(value) for value in values]
    if signs[0] or signs[1]:
        raise DefinitionError(
            f"{x} = {place} is no double root of the quartic, so {x} is not constant there; "
            "take the constants of a precession"
        )
    first = next((order for order in range(2, 5) if signs[order]), 0)
    derivatives = tuple(values[2:])
    if not first:
        return _flat(quadratures, known, derivatives)
    stable, reason = _beside(first, signs[first], place)
    return Stability(stable, first, signs[first], derivatives, reason)


def _beside(order: int, sign: int, place: sp.Expr) -> tuple[bool, str]:
    """Stable where f is negative on every side that matters."""
    name = "f" + "'" * order
    if abs(place) == 1:
        inside = sign * (1 if order % 2 == 0 or place == -1 else -1)
        side = "negative" if inside < 0 else "positive"
        return inside < 0, f"at the pole f is {side} on the inner side, by {name}"
    if order == 3:
        return False, "f'' = 0 and f''' is not: f is positive on one side"
    if sign < 0:
        return True, f"{name} < 0: f is negative on both sides"
    return False, f"{name} > 0: f is positive on both sides"


def _flat(
    quadratures: Quadratures, known: Mapping[Any, Any], derivatives: tuple[sp.Expr, ...]
) -> Stability:
    """f vanishes identically: a small change of a constant makes it positive all over (-1, 1)."""
    x = quadratures.x
    parameters = {k: v for k, v in known.items() if k not in quadratures.constants}
    general = sp.expand(quadratures.quartic.xreplace(parameters))
    for constant in quadratures.constants:
        slope = sp.diff(general, constant)
        if not slope or slope.has(constant) or slope.free_symbols - {x}:
            continue
        poly = sp.Poly(slope, x)
        inner = sp.Poly(sp.cancel(poly.as_expr() / _at_the_ends(poly)), x)
        if not inner.count_roots(-1, 1):
            reason = f"f = 0 for all x; a small change of {constant} makes f positive everywhere"
            return Stability(False, 0, 0, derivatives, reason)
    raise EngineLimit("f = 0 for all x, and no constant was found that makes it positive")


def _at_the_ends(poly: sp.Poly) -> sp.Expr:
    """The factors of a polynomial that vanish at 1 and -1."""
    x = poly.gen
    factors = sp.S.One
    for end in (1, -1):
        rest = poly
        while not rest.is_zero and rest.eval(end) == 0:
            rest = rest.quo(sp.Poly(x - end, x))
            factors *= x - end
    return factors

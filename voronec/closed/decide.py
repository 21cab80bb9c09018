"""Whether a number given by a formula is zero: proved, never measured.

A sine or cosine of a rational number that is not 0 is transcendental, and all of those of a formula
are polynomials in sine and cosine of one such number, between which there is only the relation
sin^2 + cos^2 = 1 (Lindemann).  So the number vanishes just where the formula vanishes identically
in that angle.

Square roots leave by their conjugates: ``(a + b r)(a - b r) = a^2 - b^2 r^2`` has one root fewer,
and where it vanishes while ``a - b r`` surely does not, ``a + b r`` does.
"""

from __future__ import annotations

from math import gcd, lcm
from typing import Any

import sympy as sp

from voronec.algebra.precision import PROOF
from voronec.algebra.verdicts import prove_equal
from voronec.closed.arithmetic import ball, compile_expressions, precise

__all__ = ["vanishes"]

_ANGLE = sp.Symbol("closed_form_angle", positive=True)
_RATIOS = {
    sp.tan: lambda a: sp.sin(a) / sp.cos(a),
    sp.cot: lambda a: sp.cos(a) / sp.sin(a),
    sp.sec: lambda a: 1 / sp.cos(a),
    sp.csc: lambda a: 1 / sp.sin(a),
}
MOST = 6
"""Roots that are taken out, one after the other."""


def vanishes(value: sp.Expr) -> bool | None:
    """Whether a constant expression is zero; None where nothing is proved."""
    if value.is_Rational:
        return bool(value == 0)
    spread, step = _in_one_angle(sp.expand_trig(value) if value.has(sp.atan2) else value)
    return _decide_once(spread, step, MOST)


def _decide_once(value: sp.Expr, step: sp.Rational, left: int) -> bool | None:
    verdict = prove_equal(value, 0)
    if verdict.proved:
        return True
    root = _outer_root(value)
    if root is None:
        return False if verdict.refuted else None
    if left == 0:
        return None
    a, b = _by_root(value, root)
    if b == 0:
        return _decide_once(a, step, left - 1)
    with precise(PROOF):
        (other,) = compile_expressions([a - b * root], [_ANGLE])([ball(step)])
    if other.contains(0):
        return None
    return _decide_once(a**2 - b**2 * root**2, step, left - 1)


def _in_one_angle(value: sp.Expr) -> tuple[sp.Expr, sp.Rational]:
    """Sines and cosines of rational numbers, as those of multiples of one symbol; and its value."""
    ratios = [f for f in value.atoms(*_RATIOS) if f.args[0].is_Rational]
    value = value.xreplace({f: _RATIOS[f.func](f.args[0]) for f in ratios})
    calls = [f for f in value.atoms(sp.sin, sp.cos) if f.args[0].is_Rational]
    below = lcm(1, *(int(f.args[0].q) for f in calls))
    # Their greatest common part: 0.7 as a double is a long fraction, multiples of it are short.
    step = sp.Rational(gcd(0, *(int(f.args[0] * below) for f in calls)) or 1, below)
    return value.xreplace({f: f.func(f.args[0] / step * _ANGLE) for f in calls}), step


def _outer_root(value: sp.Expr) -> Any:
    """A square root that is in no other one, of a number that is not rational if there is one."""
    found = {sp.sqrt(p.base) for p in value.atoms(sp.Pow) if _half(p)}
    free = [r for r in found if not any(r is not s and s.has(r) for s in found)]
    return min(free, key=lambda r: (r.base.is_Rational is True, sp.default_sort_key(r)),
               default=None)  # fmt: skip


def _half(expr: Any) -> bool:
    return bool(expr.is_Pow and expr.exp.is_Rational and expr.exp.q == 2)


def _by_root(value: sp.Expr, root: Any) -> tuple[sp.Expr, sp.Expr]:
    """The numerator of an expression as ``a + b root``."""
    name, square = sp.Dummy(), root.base
    apart = value.replace(lambda e: _half(e) and e.base == square, lambda e: name ** int(2 * e.exp))
    parts: list[list[Any]] = [[], []]
    for (k,), c in sp.Poly(sp.fraction(sp.together(apart))[0], name).terms():
        parts[k % 2].append(c * square ** (k // 2))
    return sp.Add(*parts[0]), sp.Add(*parts[1])

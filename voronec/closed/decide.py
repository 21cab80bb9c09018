"""Whether a number given by a formula is zero: proved, never measured.

A sine or cosine of a rational number that is not 0 is transcendental, and all of those of a formula
are polynomials in sine and cosine of one such number, between which there is only the relation
sin^2 + cos^2 = 1 (Lindemann).  So the number vanishes just where the formula vanishes identically
in that angle.
"""

from __future__ import annotations

from math import gcd, lcm

import sympy as sp

from voronec.algebra.verdicts import prove_equal

__all__ = ["vanishes"]

_ANGLE = sp.Symbol("closed_form_angle", positive=True)


def vanishes(value: sp.Expr) -> bool | None:
    """Whether a constant expression is zero; None where nothing is proved."""
    if value.is_Rational:
        return bool(value == 0)
    spread = _in_one_angle(sp.expand_trig(value) if value.has(sp.atan2) else value)
    verdict = prove_equal(spread, 0)
    if verdict.proved:
        return True
    return False if verdict.refuted and not _has_roots(spread) else None


def _in_one_angle(value: sp.Expr) -> sp.Expr:
    """Sines and cosines of rational numbers, as those of multiples of one symbol."""
    calls = [f for f in value.atoms(sp.sin, sp.cos) if f.args[0].is_Rational]
    below = lcm(1, *(int(f.args[0].q) for f in calls))
    # Their greatest common part as the symbol: u = 7/10 as a double is a long fraction, and
    # multiples of it are short.
    step = sp.Rational(gcd(0, *(int(f.args[0] * below) for f in calls)) or 1, below)
    return value.xreplace({f: f.func(f.args[0] / step * _ANGLE) for f in calls})


def _has_roots(value: sp.Expr) -> bool:
    """Whether there are roots, whose signs hold at the number and not identically."""
    return any(not p.exp.is_Integer for p in value.atoms(sp.Pow))

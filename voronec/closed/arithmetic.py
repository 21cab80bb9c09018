"""Expressions in ball arithmetic: compiled once, evaluated at whatever precision is in force.

Numbers in an expression are exact until they are used; doubles are the doubles they are.

Whether a number is zero is proved, never measured.  A sine or cosine of a rational number that is
not 0 is transcendental, and all of those of a formula are polynomials in sine and cosine of one
such number, between which there is only the relation sin^2 + cos^2 = 1 (Lindemann).  So the number
vanishes just where the formula vanishes identically in that angle.

Square roots leave by their conjugates: ``(a + b r)(a - b r) = a^2 - b^2 r^2`` has one root fewer,
and where it vanishes while ``a - b r`` surely does not, ``a + b r`` does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from math import gcd, lcm
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.precision import PROOF
from voronec.algebra.tape import Tape
from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import prove_equal
from voronec.errors import DefinitionError

Function = Callable[[Sequence[Any]], list[Any]]
"""Balls in, balls out."""


def precise(bits: int) -> Any:
    """A context in which balls have so many bits."""
    from flint import ctx

    return ctx.workprec(bits)


def exact(value: Any) -> Any:
    """A number as sympy has it, exactly: doubles and decimals of any length as what they are."""
    if isinstance(value, int | float | Fraction):
        return sp.Rational(value)
    if hasattr(value, "_mpf_"):
        return _rational(value._mpf_)
    expr = as_expression(value)
    replacements = {x: _rational(x._mpf_) for x in expr.atoms(sp.Float)}
    if expr.has(sp.I):
        replacements |= {e: _turn(e) for e in expr.atoms(sp.Mul) if sp.I in e.args}
    return expr.xreplace(replacements)


def _turn(expr: Any) -> Any:
    """``-i log((x + i y)/sqrt(x^2 + y^2))``, which sympy writes for an angle of whose sides it does
    not know the signs, as that angle."""
    logs = [f for f in expr.args if f.func is sp.log]
    if len(logs) != 1:
        return expr
    along, across = logs[0].args[0].as_real_imag()
    factor = sp.Mul(-1, *(f for f in expr.args if f is not logs[0] and f != sp.I))
    turn = sp.atan2(across, along, evaluate=False)
    return turn if factor == 1 else sp.Mul(factor, turn, evaluate=False)


def _rational(parts: Any) -> sp.Rational:
    sign, mantissa, exponent, _ = parts
    return sp.Rational(-int(mantissa) if sign else int(mantissa)) * sp.Integer(2) ** exponent


def ball(value: Any) -> Any:
    """A number as a ball at the precision in force; doubles and integers exactly."""
    from flint import arb, fmpq

    if isinstance(value, arb):
        return value
    if isinstance(value, int | float):
        return arb(value)
    known = exact(value)
    if known.is_Rational:
        return arb(fmpq(int(known.p), int(known.q)))
    return compile_expressions((known,), ())(())[0]


def compile_expressions(expressions: Iterable[Any], symbols: Sequence[Any]) -> Function:
    """A function of the symbols' values, in their order, to those of the expressions.

    Equal parts are computed once.  ``EngineLimit`` for a function that balls do not have.
    """
    from flint import arb

    tape = Tape([se.sympify(exact(e)) for e in expressions], root=root, angle=angle)
    places = {se.sympify(symbol): place for place, symbol in enumerate(symbols)}
    for atom in tape.atoms:
        if atom not in places:
            raise DefinitionError(f"'{atom}' has no value in the closed form")

    def evaluate_balls(given: Sequence[Any]) -> list[Any]:
        values = {atom: given[places[atom]] for atom in tape.atoms}
        return tape.run(values, lambda number: number() if callable(number) else arb(number))

    return evaluate_balls


def angle(y: Any, x: Any) -> Any:
    """atan2(y, x); across the negative axis the ball goes on beyond pi."""
    from flint import arb

    if x < 0 and y.contains(0):
        return arb.pi() + (y / x).atan()
    return arb.atan2(y, x)


def root(x: Any) -> Any:
    """The square root; of a ball that reaches below zero, of its part above."""
    from flint import acb, arb

    if isinstance(x, acb):
        return x.sqrt()
    enclosure = x.sqrt()
    if enclosure.is_finite() or x < 0:
        return enclosure
    return arb(0).union(x.abs_upper().sqrt())


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
    roots = {sp.sqrt(p.base) for p in value.atoms(sp.Pow) if _half(p)}
    free = [r for r in roots if not any(r is not s and s.has(r) for s in roots)]
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

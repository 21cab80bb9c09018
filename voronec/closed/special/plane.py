"""Curves in the strip -1 < x < 1 of a plane (x, w), and the signs between them.

A cylindrical decomposition: above each interval between neighbouring critical values of w the
curves are graphs that do not cross, so that one rational point a cell decides the sign in all of
it.  Everything that decides is exact; only the points for drawing are doubles.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations, pairwise
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.precision import FIRST, SHARP
from voronec.closed.arithmetic import compile_expressions, precise
from voronec.declaration.reading import quote
from voronec.errors import EngineLimit

SHARES = tuple(
    Fraction(round(2**40 * (1 - np.cos(a)) / 2), 2**40) for a in np.linspace(0, np.pi, 63)
)
"""Of an interval, dense towards its ends, which belong to it."""
BESIDE = Fraction(1, 2**100)
"""How near a critical value a strip ends, of its width: two curves that meet there in a fold are
then closer to each other than doubles tell."""


@dataclass(frozen=True)
class Strip:
    """An interval of w without a critical value: its exact ``ends`` lie hard beside the critical
    values or the edges of the window, and ``inside`` between them; the curves are graphs there."""

    ends: tuple[Fraction, Fraction]
    inside: Fraction
    polys: tuple[sp.Poly, ...]

    def places(self) -> list[Fraction]:
        """Rational values of x, one between any two neighbouring curves at ``inside``."""
        roots = [_isolate_roots(p, self.inside) for p in self.polys]
        return _between(sorted(r for isolated in roots for r in isolated))

    def signs(self, expr: sp.Expr) -> list[int]:
        """The sign of an expression on every curve, where it does not vanish on any."""
        signed = []
        for p in self.polys:
            isolated = _isolate_roots(p, self.inside)
            x, w = p.gens
            here = {w: (self.inside, self.inside)}
            signed += [(pair, sign_on(expr, {x: pair, **here})) for pair in isolated]
        return [sign for _, sign in sorted(signed)]

    def places_at(self, w: Fraction) -> list[tuple[Fraction, Fraction]]:
        """Isolating intervals of x of every curve at w, from below."""
        return sorted(pair for p in self.polys for pair in _isolate_roots(p, w))

    def graphs(self) -> list[np.ndarray]:
        """x of every curve at ``abscissae``, from below."""
        columns = [self.places_at(w) for w in self._rows()]
        middles = [[float((a + b) / 2) for a, b in column] for column in columns]
        return [np.array(graph) for graph in zip(*middles, strict=True)]

    def abscissae(self) -> np.ndarray:
        """Values of w, dense towards the ends and with them."""
        return np.array([float(w) for w in self._rows()])

    def _rows(self) -> list[Fraction]:
        low, high = self.ends
        return [low + (high - low) * share for share in SHARES]


def strips(
    polys: Sequence[sp.Expr], x: sp.Symbol, w: sp.Symbol, window: tuple[float, float] | None = None,
    cuts: Sequence[sp.Expr] = (),
) -> list[Strip]:  # fmt: skip
    """The decomposition for the curves ``polys``; ``cuts`` vanish at further critical values."""
    curves = [sp.Poly(p, x, w) for p in _factors(polys) if p.has(x)]
    values = critical(curves, x, w, [*cuts, *(p for p in _factors(polys) if not p.has(x))])
    return [Strip(ends, inside, tuple(curves)) for ends, inside in _intervals(values, window)]


def critical(
    curves: Sequence[sp.Poly], x: sp.Symbol, w: sp.Symbol, cuts: Sequence[sp.Expr] = ()
) -> list[tuple[Fraction, Fraction]]:
    """Isolating intervals of the values of w over which something may change, from below."""
    polynomials = [*cuts]
    for p in curves:
        e = p.as_expr()
        polynomials += [sp.LC(e, x), e.subs(x, 1), e.subs(x, -1)]
        if sp.degree(e, x) > 1:
            polynomials.append(sp.discriminant(e, x))
    polynomials += [sp.resultant(p.as_expr(), q.as_expr(), x) for p, q in combinations(curves, 2)]
    product = sp.Poly(1, w)
    for e in polynomials:
        poly = sp.Poly(e, w)
        if not poly.is_zero and poly.degree() > 0:
            product = product.lcm(poly.sqf_part())
    return [] if product.degree() < 1 else sorted(_real_roots(_integers(product), bits=SHARP))


@cache
def _isolate_roots(poly: sp.Poly, w: Fraction) -> tuple[tuple[Fraction, Fraction], ...]:
    """Intervals with one root x each in (-1, 1), from below: rigorous, by ball arithmetic."""
    x, other = poly.gens
    at = poly.eval(other, sp.Rational(w.numerator, w.denominator))
    inner = at.quo(at.gcd(sp.Poly((x**2 - 1) ** at.degree(), x))) if at.degree() > 0 else at
    if inner.degree() < 1:
        return ()
    return tuple(sorted(_real_roots(_integers(inner), within=1)))


def _integers(poly: sp.Poly) -> Any:
    """An integer polynomial with the same roots, each once."""
    from flint import fmpq_poly

    return fmpq_poly([_quotient(c) for c in reversed(poly.sqf_part().all_coeffs())]).numer()


def _real_roots(
    poly: Any, within: int | None = None, bits: int = FIRST
) -> list[tuple[Fraction, Fraction]]:
    """The real roots of an integer polynomial, or those in (-within, within), neither end of which
    is a root; to so many bits."""
    from flint import ctx

    while True:
        with ctx.workprec(bits):
            roots = [root.real for root, _ in poly.complex_roots() if root.imag == 0]
            if within is None:
                return [_ends(r) for r in roots]
            if not any(r.contains(within) or r.contains(-within) for r in roots):
                return [_ends(r) for r in roots if -within < r < within]
        bits *= 2


def sign_on(expr: sp.Expr, at: Mapping[sp.Symbol, tuple[Fraction, Fraction]]) -> int:
    """The sign of an expression on a box that is small enough for its sign to be one.

    ``EngineLimit`` where ball arithmetic does not tell it.
    """
    from flint import arb

    function = compile_expressions((expr,), tuple(at))
    with precise(SHARP):
        balls = [arb(_quotient(a)).union(arb(_quotient(b))) for a, b in at.values()]
        (value,) = function(balls)
    if value > 0:
        return 1
    if value < 0:
        return -1
    raise EngineLimit(f"the sign of '{quote(expr)}' is not decided beside a critical value")


def _ends(ball: Any) -> tuple[Fraction, Fraction]:
    """The ends of a ball, exactly."""
    return _dyadic(ball.lower()), _dyadic(ball.upper())


def _dyadic(value: Any) -> Fraction:
    mantissa, exponent = value.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def _quotient(value: Any) -> Any:
    from flint import fmpq

    number = sp.Rational(value)
    return fmpq(int(number.p), int(number.q))


def _factors(exprs: Sequence[sp.Expr]) -> list[sp.Expr]:
    """The different irreducible factors."""
    factors: list[sp.Expr] = []
    for e in exprs:
        factors += [f for f, _ in sp.factor_list(e)[1] if f not in factors]
    return factors


def _intervals(
    pairs: Sequence[tuple[Fraction, Fraction]], window: tuple[float, float] | None
) -> list[tuple[tuple[Fraction, Fraction], Fraction]]:
    """Between neighbouring isolating intervals, and outside: the ends, and a number inside."""
    low, high = window or _around(pairs)
    inner = [p for p in pairs if low < p[1] and p[0] < high]
    edges = [(Fraction(low),) * 2, *inner, (Fraction(high),) * 2]
    intervals = []
    for (_, a), (b, _) in pairwise(edges):
        if a < b:
            edge = (b - a) * BESIDE
            intervals.append(((a + edge, b - edge), ((a + b) / 2).limit_denominator(10**6)))
    return [((a, b), m) for (a, b), m in intervals if a < m < b]


def _around(pairs: Sequence[tuple[Fraction, Fraction]]) -> tuple[float, float]:
    if not pairs:
        return -1.0, 1.0
    low, high = float(pairs[0][0]), float(pairs[-1][1])
    span = (high - low) or max(abs(low), 1.0)
    return low - span / 2, high + span / 2


def _between(pairs: Sequence[tuple[Fraction, Fraction]]) -> list[Fraction]:
    """Rational numbers between -1, the roots and 1."""
    edges = [(Fraction(-1),) * 2, *pairs, (Fraction(1),) * 2]
    return [(a + b) / 2 for (_, a), (b, _) in pairwise(edges)]

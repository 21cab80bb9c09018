"""Functions on the rotation group: from Euler angles to the entries of the matrix, exactly.

With R = Rz(phi) Rx(theta) Rz(psi) and c = cos(theta), s = sin(theta) the entries give

    (1 + c) exp(i (phi + psi)) = R11 + R22 + i (R21 - R12),    s exp(i phi) = -R23 + i R13,
    (1 - c) exp(i (phi - psi)) = R11 - R22 + i (R21 + R12),    s exp(i psi) = R32 + i R31.

A polynomial f in sines and cosines is a sum of exp(i (m phi + k psi)) P(c, s).  It is a polynomial
in the entries just where every P is divisible by s^||m| - |k|| (1 +- c)^min(|m|, |k|), with + where
m and k have the same sign: so regular at the poles theta = 0 and pi is what the division says.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import comb
from typing import Any

import flint
import symengine as se

from voronec.algebra.generators import linear_terms
from voronec.algebra.memo import remember
from voronec.algebra.ring import Ring, sparse_terms
from voronec.algebra.terms import rational
from voronec.errors import EngineLimit

Complex = tuple[Any, Any]
"""Real and imaginary part."""
Weight = tuple[int, int]
"""m and k of exp(i (m phi + k psi))."""


@dataclass
class Rotations:
    """Rewrites functions of Euler angles in ``entries``, the matrix row by row, where they are
    regular at the poles; ``EngineLimit`` where they are not, or where that was not found.

    ``roots`` are symbols x with x^2 = f, f a function of the angles.
    """

    phi: Any
    theta: Any
    psi: Any
    entries: Sequence[Sequence[Any]]
    roots: Mapping[Any, Any] = field(default_factory=dict)
    _known: dict[Any, Any] = field(default_factory=dict)

    @remember("_known")
    def rewrite(self, expr: Any) -> Any:
        """One function in the entries."""
        return self._rational(expr) if self._holds(expr) else expr

    def _holds(self, expr: Any) -> bool:
        return bool(expr.free_symbols & {self.phi, self.theta, self.psi})

    def _rational(self, expr: Any) -> Any:
        """A quotient of polynomials in sines, cosines, and functions that are rewritten apart."""
        inner: dict[Any, Any] = {}
        drawn = {x: se.sqrt(f) for x, f in self.roots.items()}
        outer = self._open(expr, inner).xreplace(drawn)
        names = {name: meaning for meaning, name in inner.items()}
        ring = Ring([outer])
        element = ring.fraction(outer)
        drawn_back = {root: x for x, root in drawn.items()}
        ring.meaning = [e.xreplace(drawn_back) for e in ring.meaning]
        poles, below = (0, 0), se.Integer(1)
        for factor, power in ring.field.factors(element.den):
            polar = self._polar(ring, factor)
            if polar is None:
                below = below * self._polynomial(ring, factor, (0, 0)) ** power
            else:
                number, (p, q) = polar
                below, poles = below * number**power, (poles[0] + p * power, poles[1] + q * power)
        return (self._polynomial(ring, element.num, poles) / below).xreplace(names)

    def _open(self, expr: Any, inner: dict[Any, Any]) -> Any:
        """The expression with functions and roots of functions of the angles under names; what
        they are, rewritten, goes to ``inner``."""
        if not self._holds(expr) or not expr.args:
            return expr
        if isinstance(expr, se.sin | se.cos) and self._is_angle(expr.args[0]):
            return expr
        whole = isinstance(expr, se.Pow) and isinstance(expr.args[1], se.Integer)
        if isinstance(expr, se.Add | se.Mul) or whole:
            return expr.func(*[self._open(a, inner) for a in expr.args])
        meaning = expr.func(*[self.rewrite(a) for a in expr.args])
        return inner.setdefault(meaning, se.Symbol(f"function {len(inner)} of an attitude"))

    def _is_angle(self, argument: Any) -> bool:
        """Whether an argument is a sum of multiples of the angles, and of what holds none."""
        angles = {self.phi, self.theta, self.psi}
        return all(term in angles or not self._holds(term) for term in linear_terms(argument))

    def _polar(self, ring: Ring, factor: Any) -> tuple[Any, tuple[int, int]] | None:
        """A multiple of (1 - c)^p (1 + c)^q as number, (p, q); None for anything else."""
        if not ring.has(se.cos(self.theta)):
            return None
        c = ring.field.gens[ring.index(se.cos(self.theta))]
        for powers, poly in (((1, 0), 1 - c), ((0, 1), 1 + c), ((1, 1), 1 - c**2)):
            quotient, rest = divmod(factor, poly)
            if rest == 0 and quotient.is_constant():
                return ring.polynomial(quotient), powers
        return None

    def _polynomial(self, ring: Ring, poly: Any, poles: tuple[int, int]) -> Any:
        """poly / ((1 - c)^p (1 + c)^q) in the entries, p and q the ``poles``."""
        terms = []
        for weight, rest, parts in self._weights(ring, poly):
            if self._holds(rest):
                raise EngineLimit(
                    "a function of an attitude holds an angle otherwise than by sine and cosine"
                )
            factor = self._basis(weight)
            quotients = [_divide(part, weight, poles) for part in parts]
            (a, b), (x, y) = [self._polynomial_in_cosine(q) for q in quotients], factor
            half = 1 if weight == (0, 0) else 2
            terms.append(half * rest * (a * x - b * y))
        return se.Add(*terms)

    def _polynomial_in_cosine(self, poly: Any) -> Any:
        c = self.entries[2][2]
        coefficients = [rational(x) for x in poly.coeffs()]
        return se.Add(*[x * c**n for n, x in enumerate(coefficients)])

    def _basis(self, weight: Weight) -> Complex:
        """The product of the four functions above that has a weight, of least degree."""
        m, k = weight
        E, turns = self.entries, min(abs(m), abs(k))
        sign = 1 if m * k >= 0 else -1
        both = (E[0][0] + sign * E[1][1], E[1][0] - sign * E[0][1])
        more = (-E[1][2], E[0][2]) if abs(m) > abs(k) else (E[2][1], E[2][0])
        down = m < 0, (m if abs(m) > abs(k) else k) < 0
        element: Complex = (se.Integer(1), se.Integer(0))
        for factor, reverse, times in (
            (both, down[0], turns), (more, down[1], abs(abs(m) - abs(k))),
        ):  # fmt: skip
            x, y = factor[0], -factor[1] if reverse else factor[1]
            for _ in range(times):
                element = (element[0] * x - element[1] * y, element[0] * y + element[1] * x)
        return element

    def _weights(self, ring: Ring, poly: Any) -> Iterator[tuple[Weight, Any, Sequence[_Polar]]]:
        """The parts of a polynomial: m and k, the product of everything else that moves, and the
        real and imaginary coefficient, as polynomials in c and s; of opposite weights only one."""
        tables: dict[tuple[Weight, Any], dict[tuple[int, int], list[Any]]] = {}
        place = [
            ring.index(e) if ring.has(e) else -1
            for q in (self.phi, self.psi, self.theta)
            for e in (se.cos(q), se.sin(q))
        ]
        for monomial, coefficient in sparse_terms(poly).items():
            powers = dict(monomial)
            cphi, sphi, cpsi, spsi, c, s = (powers.pop(i, 0) for i in place)
            rest = tuple(sorted(powers.items()))
            for (m, x), (k, y) in product(_waves(cphi, sphi), _waves(cpsi, spsi)):
                if m < 0 or (m == 0 and k < 0):
                    continue
                known = tables.setdefault(((m, k), rest), {})
                total = known.setdefault((c, s), [flint.fmpq(0), flint.fmpq(0)])
                total[0] += coefficient * (x[0] * y[0] - x[1] * y[1])
                total[1] += coefficient * (x[0] * y[1] + x[1] * y[0])
        for (weight, rest), table in tables.items():
            parts = [_Polar.of({powers: x[i] for powers, x in table.items()}) for i in (0, 1)]
            yield weight, ring.term(rest, flint.fmpq(1)), parts


@dataclass(frozen=True)
class _Polar:
    """a(c) + s b(c)."""

    even: Any
    odd: Any

    @classmethod
    def of(cls, table: Mapping[tuple[int, int], Any]) -> _Polar:
        """From coefficients of c^i s^j, j at most 1."""
        rows = [flint.fmpq_poly([0]), flint.fmpq_poly([0])]
        for (i, j), x in table.items():
            rows[j] += flint.fmpq_poly([0] * i + [x])
        return cls(*rows)


def _divide(part: _Polar, weight: Weight, poles: tuple[int, int]) -> Any:
    """q in part = (1 - c)^p (1 + c)^p' s^||m| - |k|| (1 +- c)^min(|m|, |k|) q(c), a polynomial."""
    m, k = weight
    roots, turns = abs(abs(m) - abs(k)), min(abs(m), abs(k))
    whole, other = (part.odd, part.even) if roots % 2 else (part.even, part.odd)
    minus = poles[0] + roots // 2 + (turns if m * k < 0 else 0)
    plus = poles[1] + roots // 2 + (turns if m * k > 0 else 0)
    c = flint.fmpq_poly([0, 1])
    quotient, rest = divmod(whole, (1 - c) ** minus * (1 + c) ** plus)
    if other != 0 or rest != 0:
        raise EngineLimit("a function of an attitude is not regular at the poles of its angles")
    return quotient


def _waves(cosines: int, sines: int) -> list[tuple[int, Complex]]:
    """cos^a sin^b as a sum of exp(i m x): pairs of m and its coefficient."""
    waves: dict[int, list[Any]] = {}
    for i, j in product(range(cosines + 1), range(sines + 1)):
        # i and j factors exp(-i x), and 1/(2i)^b = (-i)^b / 2^b
        size = flint.fmpq(comb(cosines, i) * comb(sines, j) * (-1) ** j, 2 ** (cosines + sines))
        turn = ((1, 0), (0, -1), (-1, 0), (0, 1))[sines % 4]
        total = waves.setdefault(cosines + sines - 2 * (i + j), [flint.fmpq(0), flint.fmpq(0)])
        total[0] += size * turn[0]
        total[1] += size * turn[1]
    return [(m, (x, y)) for m, (x, y) in waves.items()]

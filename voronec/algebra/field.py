"""Exact arithmetic of fractions over a polynomial ring with relations.

Numerators are flint polynomials over Q, reduced by the rules g**q = f of some generators g and by a
Groebner basis.  Denominators are products of irreducible polynomials, kept factored, and are free
of bare g, since 1/g = g**(q-1)/f: a common factor is found by polynomial division alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import flint

from voronec.algebra.factors import irreducible_factors
from voronec.algebra.groebner import groebner_basis, reduce_by
from voronec.algebra.memo import remember
from voronec.errors import EngineLimit

WORK_LIMIT = 3_000_000
"""Term products a field may spend before it gives up with ``EngineLimit``: about a second."""
LARGEST = 20_000_000
"""Exponents, terms times generators, that a polynomial may have: some 100 MB of memory."""


@dataclass(frozen=True)
class Fraction:
    """num / prod(factor[i]**e for i, e in den): a reduced element of a ``Ring``."""

    num: Any
    den: tuple[tuple[int, int], ...] = ()


class Field:
    """Fractions over Q[generators]/relations, for a flint context of generators.

    ``rules`` holds (generator, q, g**q - f), outer radicals before inner ones; ``ideal`` a Groebner
    basis of further relations.  ``work_limit`` bounds the effort; passing it raises
    ``EngineLimit``.
    """

    def __init__(self, context: Any, work_limit: int) -> None:
        self.context = context
        self.gens = context.gens()
        self.one = context.constant(1)
        self.zero = context.constant(0)
        self.rules: list[tuple[int, int, Any]] = []
        self.ideal: list[Any] = []
        self._work = work_limit
        self._factors: list[Any] = []
        self._factor_index: dict[str, int] = {}
        self._local: dict[int, list[Any]] = {}
        self._conjugates: dict[int, tuple[Any, Any]] = {}
        self._norms: dict[int, tuple[Any, list[tuple[int, int]]]] = {}
        self._rule_factors: dict[int, tuple[list[tuple[str, int]], Any]] = {}

    def add_rule(self, generator: int, degree: int, f: Any) -> None:
        """Let generator**degree = f, before the rules there are."""
        self.rules.insert(0, (generator, degree, self.gens[generator] ** degree - f))

    # -- reduction ------------------------------------------------------------------------

    def _spend(self, amount: int) -> None:
        self._work -= amount
        if self._work < 0:
            raise EngineLimit("the normal form is too large for its budget")

    def reduce(self, poly: Any) -> Any:
        """The normal form of a polynomial modulo all relations."""
        while poly != 0:
            if len(poly) * len(self.gens) > LARGEST:
                raise EngineLimit(f"a polynomial of {len(poly)} terms is too large")
            start, degrees = poly, poly.degrees()
            for generator, degree, relation in self.rules:  # outer radicals before inner ones
                if degrees[generator] >= degree:
                    rounds = int(degrees[generator]) // degree
                    self._spend(len(poly) * len(relation) * rounds)
                    poly = divmod(poly, relation)[1]
                    if poly == 0:
                        return poly
                    degrees = poly.degrees()
            if self.ideal:
                self._spend(len(poly))
                poly = reduce_by(poly, self.ideal)
            if not self.ideal or poly == start:
                break
        return poly

    def product(self, a: Any, b: Any) -> Any:
        """The reduced product of two polynomials."""
        return self.reduce(self._times(a, b))

    def _times(self, a: Any, b: Any) -> Any:
        work = len(a) * len(b)
        self._spend(work)
        if work * len(self.gens) > 4 * LARGEST:  # a product has seldom fewer terms by far
            raise EngineLimit(f"a product of {len(a)} by {len(b)} terms is too large")
        return a * b

    def add_angle(self, angle: tuple[Any, Any], c: Any, s: Any) -> tuple[Any, Any]:
        """Cosine and sine of an angle, turned by one with the cosine c and the sine s."""
        cosine, sine = angle
        times = self._times
        return (
            self.reduce(times(cosine, c) - times(sine, s)),
            self.reduce(times(sine, c) + times(cosine, s)),
        )

    # -- denominators ---------------------------------------------------------------------

    def _factor(self, poly: Any) -> int:
        key = str(poly)
        if key not in self._factor_index:
            self._factor_index[key] = len(self._factors)
            self._factors.append(poly)
        return self._factor_index[key]

    def denominator(self, den: Iterable[tuple[int, int]]) -> Any:
        """A factored denominator, multiplied out."""
        total = self.one
        for i, e in den:
            for _ in range(e):
                total = self._times(total, self._factors[i])
        return total

    def factors(self, den: Iterable[tuple[int, int]]) -> list[tuple[Any, int]]:
        """The polynomials of a factored denominator with their exponents."""
        return [(self._factors[i], e) for i, e in den]

    def _cancel(self, num: Any, den: dict[int, int]) -> tuple[Any, dict[int, int]]:
        """Take factors of the denominator out of the numerator."""
        if num == 0:
            return num, {}
        left: dict[int, int] = {}
        for i, exponent in den.items():
            factor = self._factors[i]
            while exponent:
                self._spend(len(num))
                quotient, rest = divmod(num, factor)
                if rest != 0:
                    break
                num, exponent = quotient, exponent - 1
            if exponent:
                left[i] = exponent
        return num, left

    # -- field operations -----------------------------------------------------------------

    def add(self, terms: Sequence[Fraction]) -> Fraction:
        """The sum of fractions over their least common denominator."""
        common: dict[int, int] = {}
        groups: dict[tuple[tuple[int, int], ...], Any] = {}
        for term in terms:
            groups[term.den] = groups[term.den] + term.num if term.den in groups else term.num
            for i, e in term.den:
                common[i] = max(e, common.get(i, 0))
        total = self.zero
        for den, num in groups.items():
            missing = dict(common)
            for i, e in den:
                missing[i] -= e
            scale = self.denominator((i, e) for i, e in missing.items() if e)
            total += num if scale == 1 else self.product(num, scale)
        if len(groups) > 1 or (len(terms) > 1 and common):
            total, common = self._cancel(total, common)
        return self._fraction(total, common)

    def _fraction(self, num: Any, den: Mapping[int, int]) -> Fraction:
        return Fraction(num, tuple(sorted(den.items()))) if num != 0 else Fraction(self.zero)

    def cancel(self, f: Fraction) -> Fraction:
        """A fraction with common factors taken out."""
        num, den = self._cancel(f.num, dict(f.den))
        return Fraction(num, tuple(sorted(den.items())))

    def absorb(self, f: Fraction) -> Fraction:
        """A fraction without the denominators that divide modulo the relations, where it can.

        Sines and square roots are settled by conjugates.  As for the ideal, num/d is a polynomial P
        where num * t reduces to P modulo the ideal and t*d - 1, with t above all generators.
        """
        num, den = self._divide(f.num, dict(f.den))
        for i in list(den) if self.ideal else ():
            basis = self._localization(i)
            while basis and den[i]:
                rest = reduce_by(num * self.gens[0], basis)
                if rest != 0 and rest.degrees()[0]:
                    break
                num, den[i] = rest, den[i] - 1
        return Fraction(num, tuple((i, e) for i, e in sorted(den.items()) if e))

    def _divide(self, num: Any, den: dict[int, int]) -> tuple[Any, dict[int, int]]:
        """Divide by factors that hold generators g with g**2 = f.

        num/d = num*conj/norm, where norm = d*conj is free of every such g; so d divides where the
        polynomial norm does.  Where factors of norm do that leave less than d below, num and d had
        one in common: with s**2 = 1 - c**2 so have x - s and x*s + c**2 - 1 = s*(x - s).
        """
        for i in list(den):
            conjugate, norm = self._conjugate(i)
            while conjugate is not None and den[i]:
                unit, parts = self._norm_factors(i, norm)
                top, left = self._cancel(self.product(num, conjugate), dict(parts))
                if left and not self._is_part(left, i):
                    break
                num, den[i] = top / unit, den[i] - 1
                for k, e in left.items():
                    den[k] = den.get(k, 0) + e
        return self._cancel(num, den)

    def _is_part(self, left: Mapping[int, int], i: int) -> bool:
        """Whether a denominator is less than another, and vanishes nowhere else: then its factors
        divide the square of that, which holds s**2 for s."""
        if self._size(left.items()) >= self._size([(i, 1)]):
            return False
        square = self.product(self._factors[i], self._factors[i])
        return all(divmod(square, self._factors[k])[1] == 0 for k in left)

    def _size(self, den: Iterable[tuple[int, int]]) -> tuple[int, int]:
        """The degree of a denominator, and how many generators it holds."""
        polys = self.factors(den)
        held = {k for poly, _ in polys for k, degree in enumerate(poly.degrees()) if degree}
        return sum(int(poly.total_degree()) * e for poly, e in polys), len(held)

    def _norm_factors(self, i: int, norm: Any) -> tuple[Any, list[tuple[int, int]]]:
        """A number and the factors of the norm of a denominator."""
        if i not in self._norms:
            unit, parts = irreducible_factors(norm)
            leads = [poly.leading_coefficient() for poly, _ in parts]
            for lead, (_, e) in zip(leads, parts, strict=True):
                unit *= lead**e
            keys = [
                (self._factor(poly / lead), e) for lead, (poly, e) in zip(leads, parts, strict=True)
            ]
            self._norms[i] = unit, keys
        return self._norms[i]

    @remember("_conjugates")
    def _conjugate(self, i: int) -> tuple[Any, Any]:
        """conj and norm = d*conj of a denominator d; no conj where d holds no square root.

        Nor where the norm vanishes: then a radicand is a square, as in 1/(sqrt(x**2) + x).
        """
        norm, conjugate = self._factors[i], self.one
        for generator, degree, _ in self.rules:
            if degree == 2 and norm != 0 and norm.degrees()[generator]:
                turned = [-g if k == generator else g for k, g in enumerate(self.gens)]
                mirrored = norm.compose(*turned)
                conjugate = self.product(conjugate, mirrored)
                norm = self.product(norm, mirrored)
        return None if conjugate == 1 or norm == 0 else conjugate, norm

    @remember("_local")
    def _localization(self, i: int) -> list[Any]:
        """A Groebner basis of the ideal with t*d - 1 for a denominator d; empty if too large."""
        extra = self.gens[0] * self._factors[i] - 1
        try:
            return groebner_basis([*self.ideal, extra], self.context)
        except EngineLimit:
            return []

    def mul(self, factors: Sequence[Fraction]) -> Fraction:
        """The product of fractions."""
        den: dict[int, int] = {}
        for f in factors:
            for i, e in f.den:
                den[i] = den.get(i, 0) + e
        nums = []
        for f in sorted(factors, key=lambda f: len(f.num)):
            num, den = self._cancel(f.num, den) if den else (f.num, den)
            nums.append(num)
        total = nums[0]
        for num in nums[1:]:
            total = self.product(total, num)
        if den:
            total, den = self._cancel(total, den)
        return self._fraction(total, den)

    def power(self, f: Fraction, n: int) -> Fraction:
        """An integer power of a fraction."""
        if n < 0:
            return self.power(self.inverse(f), -n)
        total, square, left = self.one, f.num, n
        while left:
            if left & 1:
                total = self.product(total, square)
            left >>= 1
            if left:
                square = self.product(square, square)
        den = {i: e * n for i, e in f.den}
        if den:
            total, den = self._cancel(total, den)
        return Fraction(total, tuple(sorted(den.items())))

    def inverse(self, f: Fraction) -> Fraction:
        """1/f; the numerator is factored, bare sines and radicals go up."""
        if f.num == 0:
            raise EngineLimit("an expression divides by zero")
        self._spend(20 * len(f.num) ** 2)
        content, parts = irreducible_factors(f.num)
        up = [Fraction(self.denominator(f.den) / content)]
        den: dict[int, int] = {}
        for poly, e in parts:
            rule = self._bare(poly)
            if rule is None:
                lead = poly.leading_coefficient()
                up.append(Fraction(self.context.constant(1) / lead**e))
                key = self._factor(poly / lead)
                den[key] = den.get(key, 0) + e
            else:
                up.append(self.power(rule, e))
        for i, e in sorted(den.items()):
            up.append(Fraction(self.one, ((i, e),)))
        return self.mul(up)

    def _bare(self, poly: Any) -> Fraction | None:
        """1/g for a bare generator g with a relation g**q = f, as g**(q-1)/f."""
        if len(poly) != 1:
            return None
        for generator, degree, relation in self.rules:
            g = self.gens[generator]
            if poly == g:
                rest = g**degree - relation
                below = self.inverse(Fraction(self.reduce(rest)))
                return self.mul([Fraction(g ** (degree - 1)), below])
        return None

    def constant(self, p: int, q: int = 1) -> Fraction:
        """A rational number as an element."""
        return Fraction(self.context.constant(flint.fmpq(p, q)))

    # -- square roots ---------------------------------------------------------------------

    def square_roots(self) -> list[tuple[int, Any, list[tuple[int, int]]]]:
        """(generator, f, factors of f) for each relation g**2 = f whose f occurs below.

        The factors are those of denominators; their product is f up to a constant.
        """
        roots = []
        for generator, degree, relation in self.rules:
            if degree == 2:
                keys, rest = self._factored_rule(generator, relation)
                if keys and all(key in self._factor_index for key, _ in keys):
                    roots.append((generator, rest, [(self._factor_index[k], e) for k, e in keys]))
        return roots

    def _factored_rule(self, generator: int, relation: Any) -> tuple[list[tuple[str, int]], Any]:
        """The keys of the factors of f in g**2 = f, and f."""
        if generator not in self._rule_factors:
            rest = self.gens[generator] ** 2 - relation
            _, parts = irreducible_factors(rest)
            keys = [(str(p / p.leading_coefficient()), e) for p, e in parts]
            self._rule_factors[generator] = (keys, rest)
        return self._rule_factors[generator]

"""Exact arithmetic: the field of fractions in which given expressions live.

Numerators are flint polynomials over Q, reduced by the relations between the generators
(``s**2 = 1 - c**2`` for an angle, ``r**q = f`` for a radical, declared relations of redundant
coordinates).  Denominators are products of irreducible polynomials, kept factored, and are free
of bare sines and radicals, since 1/s = s/(1 - c**2) and 1/r = r**(q-1)/f.  The numerator of an
expression is zero only if the expression vanishes: that is a proof.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import lcm
from typing import Any

import flint
import symengine as se

from voronec.algebra.generators import (
    HYPERBOLIC,
    TRIGONOMETRIC,
    Generators,
    linear_terms,
    pi_multiple,
    prime_factors,
)
from voronec.errors import EngineLimit

__all__ = ["Fraction", "Ring"]

WORK_LIMIT = 3_000_000
"""Term products a ring may spend before it gives up with ``EngineLimit``: about a second."""


@dataclass(frozen=True)
class Fraction:
    """num / prod(factor[i]**e for i, e in den): a reduced element of a ``Ring``."""

    num: Any
    den: tuple[tuple[int, int], ...] = ()


class Ring:
    """The field of fractions of Q[generators]/relations that holds ``exprs``.

    ``relations`` are polynomial expressions that vanish.  ``work_limit`` bounds the effort;
    passing it raises ``EngineLimit``.
    """

    def __init__(
        self, exprs: Iterable[Any], relations: Sequence[Any] = (), work_limit: int = WORK_LIMIT
    ) -> None:
        self.found = Generators()
        self.found.scan(exprs)
        self.found.scan(relations)
        self._work = work_limit
        self._name_generators()
        self._memo: dict[Any, Fraction] = {}
        self._factors: list[Any] = []
        self._factor_index: dict[str, int] = {}
        self._rules: list[tuple[int, int, Any]] = []  # (generator, degree, relation polynomial)
        self.ideal: list[Any] = []
        self._roots: dict[Any, Fraction] = {}
        self._rule_factors: dict[int, tuple[list[tuple[str, int]], Any]] = {}
        for angle in self.found.angles:
            c, s = self.pairs[angle]
            self._rules.append((self._index[s], 2, self.gen(s) ** 2 + self.gen(c) ** 2 - 1))
        self._declare(relations)

    # -- generators -----------------------------------------------------------------------

    def _name_generators(self) -> None:
        """Fix the order: radicals (outermost first), sines, then everything else."""
        found = self.found
        self.roots = {base: se.Pow(base, 1 / se.Integer(q)) for base, q in found.radicals.items()}
        self.pairs = {a: (se.cos(a / d), se.sin(a / d)) for a, d in found.angles.items()}
        self.units = {(b, e): se.Pow(b, e / d) for (b, e), d in found.units.items()}
        order = [f"r{i}" for i in reversed(range(len(self.roots)))]
        order += [f"s{i}" for i in range(len(self.pairs))]
        order += [f"c{i}" for i in range(len(self.pairs))]
        order += [f"e{i}" for i in range(len(self.units))]
        order += [f"x{i}" for i in range(len(found.atoms))]
        meaning = list(reversed(self.roots.values()))
        meaning += [s for _, s in self.pairs.values()] + [c for c, _ in self.pairs.values()]
        meaning += list(self.units.values()) + list(found.atoms)
        self.meaning: list[Any] = meaning
        self._index = {expr: i for i, expr in enumerate(meaning)}
        self._plain = set(meaning[len(self.roots) :])
        self.context = flint.fmpq_mpoly_ctx.get(order or ["x0"], flint.Ordering.lex)
        self._gens = self.context.gens()
        self.one = self.context.constant(1)
        self.zero = self.context.constant(0)

    def gen(self, expr: Any) -> Any:
        """The polynomial that stands for a generator given as an expression."""
        return self._gens[self._index[expr]]

    def index(self, expr: Any) -> int:
        """The position of a generator among all, in lexicographic order."""
        return self._index[expr]

    def has(self, expr: Any) -> bool:
        """Whether an expression is one of the generators."""
        return expr in self._index

    def angle_indices(self) -> list[tuple[int, int]]:
        """Positions of the sine and the cosine of each angle."""
        return [(self._index[s], self._index[c]) for c, s in self.pairs.values()]

    def square_roots(self) -> list[tuple[int, Any, list[tuple[int, int]]]]:
        """(generator, f, factors of f) for each relation g**2 = f whose f occurs below.

        The factors are those of denominators; their product is f up to a constant.
        """
        found = []
        for generator, degree, relation in self._rules:
            if degree == 2:
                keys, rest = self._factored_rule(generator, relation)
                if keys and all(key in self._factor_index for key, _ in keys):
                    found.append((generator, rest, [(self._factor_index[k], e) for k, e in keys]))
        return found

    def _factored_rule(self, generator: int, relation: Any) -> tuple[list[tuple[str, int]], Any]:
        """The keys of the factors of f in g**2 = f, and f."""
        if generator not in self._rule_factors:
            rest = self._gens[generator] ** 2 - relation
            _, parts = rest.factor()
            keys = [(str(p / p.leading_coefficient()), e) for p, e in parts]
            self._rule_factors[generator] = (keys, rest)
        return self._rule_factors[generator]

    def _declare(self, relations: Sequence[Any]) -> None:
        if not relations:
            return
        polynomials = [self.fraction(r).num for r in relations]
        polynomials = [p for p in polynomials if p != 0]
        polynomials += [relation for _, _, relation in self._rules]
        self.ideal = groebner_basis(polynomials, self.context)
        self._memo.clear()

    # -- reduction ------------------------------------------------------------------------

    def _spend(self, amount: int) -> None:
        self._work -= amount
        if self._work < 0:
            raise EngineLimit("the normal form is too large for its budget")

    def reduce(self, poly: Any) -> Any:
        """The normal form of a polynomial modulo all relations."""
        while poly != 0:
            start, degrees = poly, poly.degrees()
            for generator, degree, relation in self._rules:  # outer radicals before inner ones
                if degrees[generator] >= degree:
                    self._spend(len(poly) * len(relation))
                    poly = divmod(poly, relation)[1]
                    if poly == 0:
                        return poly
                    degrees = poly.degrees()
            for relation in self.ideal:
                poly = divmod(poly, relation)[1]
            if not self.ideal or poly == start:
                break
        return poly

    def product(self, a: Any, b: Any) -> Any:
        """The reduced product of two polynomials."""
        self._spend(len(a) * len(b))
        return self.reduce(a * b)

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
            total = total * self._factors[i] ** e
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
        return Fraction(total, tuple(sorted(common.items()))) if total != 0 else Fraction(self.zero)

    def cancelled(self, f: Fraction) -> Fraction:
        """A fraction with common factors taken out."""
        num, den = self._cancel(f.num, dict(f.den))
        return Fraction(num, tuple(sorted(den.items())))

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
        return Fraction(total, tuple(sorted(den.items()))) if total != 0 else Fraction(self.zero)

    def power(self, f: Fraction, n: int) -> Fraction:
        """An integer power of a fraction."""
        if n < 0:
            return self.power(self.inverse(f), -n)
        total = self.one
        for _ in range(n):
            total = self.product(total, f.num)
        den = {i: e * n for i, e in f.den}
        if den:
            total, den = self._cancel(total, den)
        return Fraction(total, tuple(sorted(den.items())))

    def inverse(self, f: Fraction) -> Fraction:
        """1/f; the numerator is factored, bare sines and radicals go up."""
        if f.num == 0:
            raise ZeroDivisionError
        self._spend(20 * len(f.num) ** 2)
        content, parts = f.num.factor()
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
        for generator, degree, relation in self._rules:
            g = self._gens[generator]
            if poly == g:
                rest = g**degree - relation
                return self.mul([Fraction(g ** (degree - 1)), self.inverse(Fraction(self.reduce(rest)))])
        return None

    # -- expressions ----------------------------------------------------------------------

    def constant(self, p: int, q: int = 1) -> Fraction:
        """A rational number as an element."""
        return Fraction(self.context.constant(flint.fmpq(p, q)))

    def fraction(self, expr: Any) -> Fraction:
        """The element that a symengine expression stands for."""
        known = self._memo.get(expr)
        if known is None:
            known = self._memo[expr] = self._convert(expr)
        return known

    def _convert(self, expr: Any) -> Fraction:
        if expr in self._plain:
            return Fraction(self.reduce(self.gen(expr)))
        if expr.is_Number:
            return self.constant(int(expr.p), int(expr.q))
        if isinstance(expr, se.Add):
            return self.add([self.fraction(a) for a in expr.args])
        if isinstance(expr, se.Mul):
            return self.mul([self.fraction(a) for a in expr.args])
        if isinstance(expr, TRIGONOMETRIC):
            return self._trigonometric(expr)
        if isinstance(expr, HYPERBOLIC):
            return self._hyperbolic(expr)
        base, exponent = expr.args
        if base == se.E or not exponent.is_Number:
            return self._symbolic_power(base, exponent)
        if exponent.q == 1:
            return self.power(self.fraction(base), int(exponent.p))
        return self._root(base, exponent)

    def _root(self, base: Any, exponent: Any) -> Fraction:
        """base**(p/q) through the radical generators."""
        if isinstance(base, se.Rational):
            parts = prime_factors(int(base.p))
            for prime, e in prime_factors(int(base.q)).items():
                parts[prime] = parts.get(prime, 0) - e
            powers = [self._radical(se.Integer(p), e * exponent) for p, e in parts.items()]
            return self.mul(powers or [self.constant(1)])
        return self._radical(base, exponent)

    def _radical(self, base: Any, exponent: Any) -> Fraction:
        root = self.roots[base]
        q = self.found.radicals[base]
        if base not in self._roots:
            self._roots[base] = self._introduce(base, root, q)
        return self.power(self._roots[base], int(exponent * q))

    def _introduce(self, base: Any, root: Any, q: int) -> Fraction:
        """The relation of a radical: r**q = num * den**(q-1), and base**(1/q) = r/den."""
        value = self.fraction(base)
        den = self.denominator(value.den)
        polynomial = self.reduce(value.num * den ** (q - 1))
        g = self.gen(root)
        for generator, degree, relation in self._rules:
            if degree == q and self._gens[generator] ** q - relation == polynomial:
                g = self._gens[generator]
                break
        else:
            self._rules.insert(0, (self._index[root], q, g**q - polynomial))
        return self.mul([Fraction(g), Fraction(self.one, value.den)])

    def _symbolic_power(self, base: Any, exponent: Any) -> Fraction:
        parts = []
        for term, coefficient in linear_terms(exponent).items():
            if term == 1 and base != se.E:
                whole = coefficient.q == 1
                parts.append(
                    self.power(self.fraction(base), int(coefficient))
                    if whole
                    else self._root(base, coefficient)
                )
                continue
            unit = self.units[base, term]
            n = int(coefficient * self.found.units[base, term])
            parts.append(self.power(Fraction(self.gen(unit)), n))
        return self.mul(parts or [self.constant(1)])

    def _angle(self, angle: Any) -> tuple[Any, Any]:
        """cos and sin of a sum of rational multiples, as polynomials."""
        cosine, sine = self.one, self.zero
        for term, coefficient in linear_terms(angle).items():
            if term == se.pi:
                c, s = (self.fraction(v).num for v in pi_multiple(coefficient))
                steps, sign = 1, 1
            else:
                c, s = (self.gen(g) for g in self.pairs[term])
                n = int(coefficient * self.found.angles[term])
                steps, sign = abs(n), 1 if n > 0 else -1
            for _ in range(steps):
                cosine, sine = (
                    self.reduce(cosine * c - sign * sine * s),
                    self.reduce(sine * c + sign * cosine * s),
                )
        return cosine, sine

    def _trigonometric(self, expr: Any) -> Fraction:
        c, s = (Fraction(p) for p in self._angle(expr.args[0]))
        table = {
            se.sin: lambda: s,
            se.cos: lambda: c,
            se.tan: lambda: self.mul([s, self.inverse(c)]),
            se.cot: lambda: self.mul([c, self.inverse(s)]),
            se.sec: lambda: self.inverse(c),
            se.csc: lambda: self.inverse(s),
        }
        return table[type(expr)]()

    def _hyperbolic(self, expr: Any) -> Fraction:
        up = self._symbolic_power(se.E, expr.args[0])
        down = self.inverse(up)
        minus = self.mul([self.constant(-1), down])
        twice_cosh, twice_sinh = self.add([up, down]), self.add([up, minus])
        if isinstance(expr, se.sinh):
            return self.mul([twice_sinh, self.constant(1, 2)])
        if isinstance(expr, se.cosh):
            return self.mul([twice_cosh, self.constant(1, 2)])
        if isinstance(expr, se.tanh):
            return self.mul([twice_sinh, self.inverse(twice_cosh)])
        return self.mul([twice_cosh, self.inverse(twice_sinh)])


def groebner_basis(polynomials: Sequence[Any], context: Any) -> list[Any]:
    """A Groebner basis over Q of polynomials in a flint context, primitive over Z."""
    if not polynomials:
        return []
    integral = flint.fmpz_mpoly_ctx.get(context.names(), context.ordering())
    cleared = []
    for p in polynomials:
        scale = lcm(*(int(c.q) for c in p.coeffs()))
        cleared.append(integral.from_dict({m: int((c * scale).p) for m, c in p.to_dict().items()}))
    basis = flint.fmpz_mpoly_vec(cleared, integral).buchberger_naive().autoreduction()
    return [context.from_dict({m: flint.fmpq(c) for m, c in p.to_dict().items()}) for p in basis]

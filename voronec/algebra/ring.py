"""The ring of given expressions: symengine graphs in, exact fractions out.

Generators come from a scan of the expressions: atoms, a cosine and a sine for each angle
(``s**2 = 1 - c**2``), a root for each radical, a unit for each symbolic power.  The numerator of an
expression is zero only if the expression vanishes wherever it is defined: that is a proof.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import gcd, lcm
from typing import Any

import flint
import symengine as se
from flint.utils.flint_exceptions import DomainError

from voronec.algebra.field import WORK_LIMIT, Field, Fraction
from voronec.algebra.generators import (
    HYPERBOLIC,
    TRIGONOMETRIC,
    Generators,
    linear_terms,
    pi_multiple,
    plain_power,
    prime_factors,
)
from voronec.algebra.graphs import is_flat
from voronec.algebra.groebner import groebner_basis
from voronec.algebra.memo import remember
from voronec.algebra.terms import is_exponential, summands
from voronec.errors import DefinitionError, EngineLimit

MANY_FOLD = 60
"""Multiples of an angle beyond this are not expanded."""

Monomial = tuple[tuple[int, int], ...]
"""((generator, exponent), ...), exponents positive."""


def sparse_terms(poly: Any) -> dict[Monomial, Any]:
    """A polynomial as {monomial: coefficient}."""
    return {
        tuple((i, int(e)) for i, e in enumerate(monomial) if e): coefficient
        for monomial, coefficient in poly.to_dict().items()
    }


class Ring:
    """The field of fractions of Q[generators]/relations that holds ``exprs``.

    ``relations`` are expressions that vanish.  ``apart`` rewrites expressions before they are read:
    ``voronec.algebra.roots.ring_over`` takes the roots of products apart so.  ``field`` does the
    arithmetic; ``meaning[i]`` is the expression that generator i stands for.  Where it is
    ``split``, exponentials of sums are products of those of the terms.
    """

    def __init__(
        self,
        exprs: Iterable[Any],
        relations: Iterable[Any] = (),
        work_limit: int = WORK_LIMIT,
        apart: Callable[[Any], Any] | None = None,
        split: bool = False,
    ) -> None:
        self._apart = apart
        exprs, equations = [self._read(e) for e in exprs], [self._read(e) for e in relations]
        self.found = Generators(split)
        self.found.scan(exprs)
        self.found.scan(equations)
        self.found.settle()
        self.field = Field(self._name_generators(bool(equations)), work_limit)
        self._memo: dict[Any, Fraction] = {}
        self._roots: dict[Any, Fraction] = {}
        self._radicands: list[tuple[int, Any, Any, Any, Any]] = []
        for c, s in self.pairs.values():
            self.field.add_rule(self._index[s], 2, 1 - self._gen(c) ** 2)
        self._declare(equations)

    def _read(self, expr: Any) -> Any:
        return expr if self._apart is None else self._apart(expr)

    def _name_generators(self, bound: bool) -> Any:
        """The context, radicals (outermost first) before sines before everything else.

        Where relations bind generators, the first one serves ``Field.absorbed``.
        """
        generators = self.found
        self.roots = {
            base: se.Pow(base, 1 / se.Integer(q)) for base, q in generators.radicals.items()
        }
        self.pairs = {a: (se.cos(a / d), se.sin(a / d)) for a, d in generators.angles.items()}
        self.units = {(b, e): se.Pow(b, e / d) for (b, e), d in generators.units.items()}
        order = ["inverse"] if bound else []
        order += [f"r{i}" for i in reversed(range(len(self.roots)))]
        order += [f"s{i}" for i in range(len(self.pairs))]
        order += [f"c{i}" for i in range(len(self.pairs))]
        order += [f"e{i}" for i in range(len(self.units))]
        order += [f"x{i}" for i in range(len(generators.atoms))]
        meaning: list[Any] = [se.Symbol("inverse of a denominator")] if bound else []
        meaning += reversed(self.roots.values())
        meaning += [s for _, s in self.pairs.values()] + [c for c, _ in self.pairs.values()]
        meaning += list(self.units.values()) + list(generators.atoms)
        self.meaning = meaning
        self._index = {expr: i for i, expr in enumerate(meaning)}
        self._plain = set(meaning[len(self.roots) + bound :])
        return flint.fmpq_mpoly_ctx.get(order or ["x0"], flint.Ordering.lex)

    def _gen(self, expr: Any) -> Any:
        """The polynomial that stands for a generator given as an expression."""
        return self.field.gens[self._index[expr]]

    def index(self, expr: Any) -> int:
        """The position of a generator among all, in lexicographic order."""
        return self._index[expr]

    def has(self, expr: Any) -> bool:
        """Whether an expression is one of the generators."""
        return expr in self._index

    def angle_indices(self) -> list[tuple[int, int]]:
        """Positions of the sine and the cosine of each angle."""
        return [(self._index[s], self._index[c]) for c, s in self.pairs.values()]

    def angles(self) -> list[Any]:
        """The angles of which these are sines and cosines; cos(acos(x)) is written as x."""
        return [angle / d for angle, d in self.found.angles.items()]

    def polynomial(self, poly: Any) -> Any:
        """A polynomial as an expanded expression."""
        return se.Add(*[self.term(m, c) for m, c in sparse_terms(poly).items()])

    def term(self, monomial: Monomial, coefficient: Any) -> Any:
        """A monomial with its coefficient as an expression."""
        number = se.Integer(int(coefficient.p))
        if coefficient.q != 1:
            number = number / se.Integer(int(coefficient.q))
        meaning, factors, exponent = self.meaning, [number], list[Any]()
        for i, e in monomial:
            base = meaning[i]
            if is_exponential(base):
                # symengine leaves 3 (x - y) as it is in exp(x - y)^3, and loses some of it later
                exponent += [e * w for w in summands(base.args[1])]
            else:
                factors.append(base if e == 1 else base**e)
        return se.Mul(*factors, se.exp(se.Add(*exponent))) if exponent else se.Mul(*factors)

    def _declare(self, relations: Sequence[Any]) -> None:
        if not relations:
            return
        polynomials = [self._element(r).num for r in relations]
        polynomials = [p for p in polynomials if p != 0]
        polynomials += [relation for _, _, relation in self.field.rules]
        self.field.ideal = groebner_basis(polynomials, self.field.context)
        if any(p.is_constant() for p in self.field.ideal):
            raise DefinitionError("the relations contradict each other: nothing satisfies them")
        self._memo.clear()

    def fraction(self, expr: Any) -> Fraction:
        """The element that a symengine expression stands for."""
        return self._element(self._read(expr))

    @remember("_memo")
    def _element(self, expr: Any) -> Fraction:
        if expr in self._plain:
            return Fraction(self.field.reduce(self._gen(expr)))
        if expr == se.E:
            return self._symbolic_power(se.E, se.Integer(1))
        if is_flat(expr):
            return self.field.constant(0)
        if expr.is_Number:
            return self.field.constant(int(expr.p), int(expr.q))
        if isinstance(expr, se.Add):
            return self.field.add([self._element(a) for a in expr.args])
        if isinstance(expr, se.Mul):
            return self.field.mul([self._element(a) for a in expr.args])
        if isinstance(expr, TRIGONOMETRIC):
            return self._trigonometric(expr)
        if isinstance(expr, HYPERBOLIC):
            return self._hyperbolic(expr)
        if not isinstance(expr, se.Pow):
            raise EngineLimit(f"'{expr}' is not one of the quantities of this computation")
        base, exponent = plain_power(*expr.args)
        if base == se.E or not exponent.is_Number:
            return self._symbolic_power(base, exponent)
        if exponent.q == 1:
            return self.field.power(self._element(base), int(exponent.p))
        return self._root(base, exponent)

    def _root(self, base: Any, exponent: Any) -> Fraction:
        """base**(p/q) through the radical generators."""
        if isinstance(base, se.Rational):
            parts = prime_factors(int(base.p))
            for prime, e in prime_factors(int(base.q)).items():
                parts[prime] = parts.get(prime, 0) - e
            powers = [self._radical(se.Integer(p), e * exponent) for p, e in parts.items()]
            return self.field.mul(powers or [self.field.constant(1)])
        return self._radical(base, exponent)

    def _radical(self, base: Any, exponent: Any) -> Fraction:
        root = self.roots[base]
        q = self.found.radicals[base]
        if base not in self._roots:
            self._roots[base] = self._introduce(base, root, q)
        return self.field.power(self._roots[base], int(exponent * q))

    def _introduce(self, base: Any, root: Any, q: int) -> Fraction:
        """base**(1/q) as scale*g/den, where g stands for den * base**(1/q) / scale.

        ``scale`` takes a perfect power out of the numbers, so that sqrt(4x + 4) is 2 sqrt(x + 1).
        """
        field, value = self.field, self._element(base)
        den = field.denominator(value.den)
        power = value.num
        for _ in range(q - 1 if den != 1 else 0):
            power = field.product(power, den)
        power = field.reduce(power)
        scale = _root_of_content(power, q)
        power = power / scale**q
        below = Fraction(field.one * scale, value.den)
        for degree, num, other, other_power, g in self._radicands:
            if degree == q and power == other_power and _same_sign(q, num, den, other):
                return field.mul([Fraction(g), below])
        index, g = self._index[root], self._gen(root)
        if den != 1 or scale != 1:
            self.meaning[index] = root * self.polynomial(den / scale)
        field.add_rule(index, q, power)
        self._radicands.append((q, value.num, den, power, g))
        return field.mul([Fraction(g), below])

    def _symbolic_power(self, base: Any, exponent: Any) -> Fraction:
        parts = []
        for term, coefficient in self.found.powers(base, exponent).items():
            if term == 1 and base != se.E:
                whole = coefficient.q == 1
                parts.append(
                    self.field.power(self._element(base), int(coefficient))
                    if whole
                    else self._root(base, coefficient)
                )
                continue
            unit = self.units[base, term]
            power = coefficient * self.found.units[base, term]
            if power.q != 1:
                raise EngineLimit(f"a root of '{unit}' is not one of the quantities")
            n = int(power)
            parts.append(self.field.power(Fraction(self._gen(unit)), n))
        return self.field.mul(parts or [self.field.constant(1)])

    def _angle(self, angle: Any) -> tuple[Any, Any]:
        """cos and sin of a sum of rational multiples, as polynomials."""
        cosine, sine = self.field.one, self.field.zero
        for term, coefficient in linear_terms(angle).items():
            if term == se.pi:
                c, s = (self._element(v).num for v in pi_multiple(coefficient))
                steps, sign = 1, 1
            else:
                c, s = (self._gen(g) for g in self.pairs[term])
                n = int(coefficient * self.found.angles[term])
                if abs(n) > MANY_FOLD:
                    raise EngineLimit(f"the {abs(n)}-fold angle of '{term}' is not expanded")
                steps, sign = abs(n), 1 if n > 0 else -1
            for _ in range(steps):
                cosine, sine = self.field.add_angle((cosine, sine), c, sign * s)
        return cosine, sine

    def _trigonometric(self, expr: Any) -> Fraction:
        c, s = (Fraction(p) for p in self._angle(expr.args[0]))
        table = {
            se.sin: lambda: s,
            se.cos: lambda: c,
            se.tan: lambda: self.field.mul([s, self.field.inverse(c)]),
            se.cot: lambda: self.field.mul([c, self.field.inverse(s)]),
            se.sec: lambda: self.field.inverse(c),
            se.csc: lambda: self.field.inverse(s),
        }
        return table[type(expr)]()

    def _hyperbolic(self, expr: Any) -> Fraction:
        if isinstance(expr, se.coth) and (tangent := se.tanh(expr.args[0])) in self._plain:
            return self.field.inverse(Fraction(self._gen(tangent)))
        up = self._symbolic_power(se.E, expr.args[0])
        down = self.field.inverse(up)
        minus = self.field.mul([self.field.constant(-1), down])
        twice_cosh, twice_sinh = self.field.add([up, down]), self.field.add([up, minus])
        if isinstance(expr, se.sinh):
            return self.field.mul([twice_sinh, self.field.constant(1, 2)])
        if isinstance(expr, se.cosh):
            return self.field.mul([twice_cosh, self.field.constant(1, 2)])
        if isinstance(expr, se.tanh):
            return self.field.mul([twice_sinh, self.field.inverse(twice_cosh)])
        return self.field.mul([twice_cosh, self.field.inverse(twice_sinh)])


def _root_of_content(poly: Any, q: int) -> Any:
    """r where r**q is the common rational factor of the coefficients; 1 if it is no such power."""
    coefficients = poly.coeffs()
    if not coefficients:
        return flint.fmpq(1)
    above = gcd(*(abs(int(c.p)) for c in coefficients))
    below = lcm(*(int(c.q) for c in coefficients))
    roots = [flint.fmpz(n).root(q) for n in (above, below)]
    if any(int(r) ** q != n for r, n in zip(roots, (above, below), strict=True)):
        return flint.fmpq(1)
    return flint.fmpq(int(roots[0]), int(roots[1]))


def _same_sign(q: int, num: Any, den: Any, other: Any) -> bool:
    """Whether den*(n/den)**(1/q) and other*(m/other)**(1/q), of equal powers, are equal.

    They may differ in sign, as x*sqrt(y/x) and sqrt(x*y) do where x < 0.  They do not where
    den*other is a square, or a square times the radicand num/other, which is not negative.
    """
    return bool(den == other) or (q == 2 and (_is_square(den * other) or _is_square(num * den)))


def _is_square(poly: Any) -> bool:
    try:
        poly.sqrt()
    except DomainError:
        return False
    return True

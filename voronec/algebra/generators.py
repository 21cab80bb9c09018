"""Which generators a polynomial ring needs to hold given expressions exactly.

A scan of the expression graphs finds them: plain atoms (symbols, unknown functions and their
derivatives, transcendental functions that are left as they are), for each angle a sine and a
cosine, for each power with a symbolic exponent a unit of it, for each radical a root.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import lcm
from typing import Any

import flint
import symengine as se

from voronec.algebra.exponents import DEGREE, ExponentBasis
from voronec.algebra.graphs import is_atom, is_flat, nodes
from voronec.algebra.terms import is_fraction, spread_length, summands
from voronec.errors import EngineLimit

TRIGONOMETRIC = (se.sin, se.cos, se.tan, se.cot, se.sec, se.csc)
HYPERBOLIC = (se.sinh, se.cosh, se.tanh, se.coth)


EXPANSION_LIMIT = 2_000
"""How many terms the argument of a sine or the like may expand to."""
FACTOR_BITS = 120
"""Integers of more bits are not factored."""
FOLDS = 6
"""The n-fold angle is a polynomial in sine and cosine whose coefficients grow like (1 + sqrt(2))^n,
and its terms cancel: two digits are lost at n = 6, twelve at n = 33."""


def linear_terms(expr: Any) -> dict[Any, Any]:
    """An expression as a sum of rational multiples: ``{term without coefficient: coefficient}``."""
    if spread_length(expr, EXPANSION_LIMIT) > EXPANSION_LIMIT:
        raise EngineLimit("the argument of a function is too large to be expanded")
    expr = expr.expand()
    terms: dict[Any, Any] = {}
    for term in summands(expr):
        coefficient, rest = se.Integer(1), term
        if term.is_Number:
            coefficient, rest = term, se.Integer(1)
        elif isinstance(term, se.Mul) and term.args[0].is_Number:
            coefficient = term.args[0]
            rest = se.Mul(*term.args[1:])
        terms[rest] = terms.get(rest, se.Integer(0)) + coefficient
    return {rest: c for rest, c in terms.items() if c != 0}


def holds_far_multiples(exprs: Iterable[Any]) -> bool:
    """Whether a normal form expands sines and cosines of an angle that are many-fold of another,
    sin(33 x) and sin(20 x) of x: exact, but numbers computed from it lose digits."""
    generators = Generators()
    try:
        generators.scan(exprs)
    except EngineLimit:
        return False
    return any(fold > FOLDS for fold in generators.folds.values())


def splits_curved_angles(exprs: Iterable[Any], moving: Iterable[Any]) -> bool:
    """Whether a normal form splits the sine of a sum in which powers or products of what moves
    stand, as cos(t^2 - 2 t): it is exact, but both angles run far ahead of their sum, and series of
    their products have no digits left where it hardly moves."""
    symbols = {*moving}
    return any(
        isinstance(node, TRIGONOMETRIC)
        and isinstance(node.args[0], se.Add | se.Mul)
        and _is_curved_sum(node.args[0], symbols)
        for node in nodes(exprs)
    )


def distance_powers(exprs: Iterable[Any], moving: Iterable[Any]) -> list[Any]:
    """Powers beyond the second of distances, (x - 1000)^5: written out, their terms are larger
    than what they leave, and numbers computed from them have lost their digits."""
    symbols = {*moving}
    powers = (n for n in nodes(exprs) if isinstance(n, se.Pow) and isinstance(n.args[0], se.Add))
    return [
        p
        for p in powers
        if isinstance(p.args[1], se.Integer)
        and abs(int(p.args[1])) > 2
        and {0, 1} <= {_degree(term, symbols) for term in p.args[0].args}
        and any(term.free_symbols.isdisjoint(symbols) for term in p.args[0].args)
    ]


def _is_curved_sum(angle: Any, moving: set[Any]) -> bool:
    try:
        terms = [term for term in linear_terms(angle) if term.free_symbols & moving]
    except EngineLimit:
        return True  # too long to be split, for normal forms too
    return len(terms) > 1 and any(_degree(term, moving) > 1 for term in terms)


def _degree(term: Any, moving: set[Any]) -> int:
    """Of a product, in the symbols that move."""
    degree = 0
    for factor in term.args if isinstance(term, se.Mul) else (term,):
        base, exponent = factor.args if isinstance(factor, se.Pow) else (factor, se.Integer(1))
        if base in moving and isinstance(exponent, se.Integer):
            degree += int(exponent)
    return degree


def prime_factors(n: int) -> dict[int, int]:
    """The prime factorization of a positive integer."""
    if n.bit_length() > FACTOR_BITS:
        raise EngineLimit(f"the integer {n} under a root is too large to be factored")
    return {int(p): e for p, e in flint.fmpz(n).factor()}


@dataclass
class Generators:
    """The generators found so far; ``scan`` adds those of more expressions.

    ``atoms``: expressions that are generators themselves.  ``angles``: angle -> denominator d, for
    the pair cos(angle/d), sin(angle/d).  ``units``: (base, exponent) -> denominator d, for
    base**(exponent/d).  ``radicals``: base -> q, for base**(1/q), innermost first.  ``exponents``
    of e and ``tangents``, the arguments of tanh and coth, with their terms: ``settle`` makes them
    units, or atoms.
    """

    split: bool = False
    atoms: dict[Any, None] = field(default_factory=dict)
    angles: dict[Any, int] = field(default_factory=dict)
    units: dict[tuple[Any, Any], int] = field(default_factory=dict)
    radicals: dict[Any, int] = field(default_factory=dict)
    exponents: dict[Any, dict[Any, Any]] = field(default_factory=dict)
    tangents: dict[Any, dict[Any, Any]] = field(default_factory=dict)
    _seen: set[Any] = field(default_factory=set)
    _multiples: dict[Any, set[Any]] = field(default_factory=dict)
    _basis: ExponentBasis = field(default_factory=lambda: ExponentBasis({}))

    def scan(self, exprs: Iterable[Any]) -> None:
        """Collect the generators of further expressions."""
        for expr in exprs:
            self._visit(expr)

    def settle(self) -> None:
        """Decide what exponentials and hyperbolic tangents are, once everything is scanned.

        Exponentials of independent exponents are units as they stand.  tanh w alone is a
        generator: it obeys no relation, and is bounded, where the quotient of exponentials that it
        equals overflows.  Beside exp(w), or a multiple of w up to ``DEGREE``, it is that quotient.
        """
        related = {}
        for w, terms in self.tangents.items():
            others = self.exponents | {u: t for u, t in self.tangents.items() if u != w}
            combination = ExponentBasis(others).coordinates(terms)
            if combination is None or not all(map(_is_small, combination.values())):
                self.atoms.setdefault(se.tanh(w))
            else:
                related[w] = terms
        self.exponents |= related
        self.tangents.clear()
        one = se.Integer(1)
        terms = {t: {t: one} for terms in self.exponents.values() for t in terms}
        self._basis = ExponentBasis(terms if self.split else self.exponents)
        for terms in self.exponents.values():
            for w, c in self._combination(terms).items():
                key = (se.E, w)
                self.units[key] = lcm(self.units.get(key, 1), int(c.q))

    def powers(self, base: Any, exponent: Any) -> dict[Any, Any]:
        """{w: number} where an exponent is the sum of the products, and those of the w that are no
        numbers are of ``units``."""
        terms = linear_terms(exponent)
        return self._combination(terms) if base == se.E else terms

    def _combination(self, terms: Mapping[Any, Any]) -> dict[Any, Any]:
        coordinates = self._basis.coordinates(terms)
        if coordinates is None:
            raise EngineLimit("an exponential is not one of the quantities of this computation")
        return coordinates

    def _visit(self, expr: Any) -> None:
        if expr in self._seen:
            return
        self._seen.add(expr)
        if is_atom(expr) or expr == se.pi:
            self.atoms.setdefault(expr)
        elif expr == se.E:
            self._power(se.E, se.Integer(1))
        elif is_flat(expr):
            return
        elif expr.is_Number:
            if not isinstance(expr, se.Rational):
                raise EngineLimit(f"the number '{expr}' is not rational")
        elif isinstance(expr, TRIGONOMETRIC):
            self._angle(expr.args[0])
        elif isinstance(expr, (se.tanh, se.coth)):
            self.tangents[expr.args[0]] = linear_terms(expr.args[0])
        elif isinstance(expr, HYPERBOLIC):
            self.exponents[expr.args[0]] = linear_terms(expr.args[0])
        elif isinstance(expr, (se.Add, se.Mul)):
            self.scan(expr.args)
        elif isinstance(expr, se.Pow):
            self._power(*expr.args)
        else:  # log, asin, Abs, ...: sound as an unknown, incomplete
            self.atoms.setdefault(expr)

    def _angle(self, angle: Any) -> None:
        for term, coefficient in linear_terms(angle).items():
            if term == se.pi:
                self.scan(pi_multiple(coefficient))
                continue
            self.angles[term] = lcm(self.angles.get(term, 1), int(coefficient.q))
            self._multiples.setdefault(term, set()).add(coefficient)

    @property
    def folds(self) -> dict[Any, int]:
        """angle -> the largest multiple of the angle of its pair that occurs."""
        return {
            angle: max(abs(int(c * self.angles[angle])) for c in multiples)
            for angle, multiples in self._multiples.items()
        }

    def _power(self, base: Any, exponent: Any) -> None:
        if base == se.E:
            self.exponents[exponent] = linear_terms(exponent)
            return
        base, exponent = plain_power(base, exponent)
        self._visit(base)
        if not exponent.is_Number:
            for term, coefficient in linear_terms(exponent).items():
                if term != 1:
                    key = (base, term)
                    self.units[key] = lcm(self.units.get(key, 1), int(coefficient.q))
                elif coefficient.q != 1:
                    self._radical(base, int(coefficient.q))
        elif isinstance(exponent, se.Rational) and exponent.q != 1:
            self._radical(base, int(exponent.q))

    def _radical(self, base: Any, q: int) -> None:
        if isinstance(base, se.Rational):
            if base < 0:
                raise EngineLimit(f"a root of the negative number {base} is not real")
            for prime in {*prime_factors(int(base.p)), *prime_factors(int(base.q))}:
                known = self.radicals.get(se.Integer(prime), 1)
                self.radicals[se.Integer(prime)] = lcm(known, q)
            return
        self.radicals[base] = lcm(self.radicals.get(base, 1), q)


def plain_power(base: Any, exponent: Any) -> tuple[Any, Any]:
    """Base and exponent with the exponents of roots of roots multiplied: b^(1/2) is real where b is
    not negative alone."""
    while is_fraction(exponent) and isinstance(base, se.Pow) and is_fraction(base.args[1]):
        base, exponent = base.args[0], base.args[1] * exponent
    return base, exponent


def _is_small(ratio: Any) -> bool:
    return bool(max(abs(ratio.p), abs(ratio.q)) <= DEGREE)


def pi_multiple(coefficient: Any) -> tuple[Any, Any]:
    """cos and sin of a rational multiple of pi, in radicals where symengine knows them."""
    values = se.cos(coefficient * se.pi), se.sin(coefficient * se.pi)
    if any(isinstance(v, TRIGONOMETRIC) for v in values):
        raise EngineLimit(f"the sine of {coefficient}*pi is not expressed in square roots")
    return values

"""Roots, powers and logarithms of products, taken factor by factor where signs allow it.

Where p and q are not negative, sqrt(p q) = sqrt(p) sqrt(q) and log(p q) = log p + log q; the root
of the square of what has a sign is that itself, or its opposite: so one function has one form.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import symengine as se

from voronec.algebra.certificates import Sign, Signs
from voronec.algebra.conditions import comparisons, split_hypotheses
from voronec.algebra.factors import fraction_factors
from voronec.algebra.field import WORK_LIMIT, Fraction
from voronec.algebra.generators import TRIGONOMETRIC, prime_factors
from voronec.algebra.graphs import is_atom, nodes
from voronec.algebra.ring import Ring
from voronec.algebra.terms import factors_of, summands
from voronec.errors import EngineLimit

TERMS = 60
"""The sign of a factor with more terms is not asked for."""
_STEPS = (se.sign, se.floor)
_Power = tuple[Any, int]
"""A polynomial and its exponent."""


def domain_conditions(exprs: Iterable[Any]) -> list[Any]:
    """What holds wherever expressions have real values: radicands are not negative.

    Nothing where one of them has cuts: a piece of a function may be undefined where it is not
    taken.
    """
    parts = [*nodes(exprs)]
    if any(isinstance(n, _STEPS) for n in parts):
        return []
    powers = [n.args for n in parts if isinstance(n, se.Pow) and n.free_symbols]
    radicands = [(b, e) for b, e in powers if isinstance(e, se.Rational) and e.q != 1]
    return [base > 0 if exponent < 0 else base >= 0 for base, exponent in radicands]


@dataclass(frozen=True)
class _Factors:
    """content * product of ``known``, which are not negative, and of ``others``, with powers."""

    content: Any
    known: dict[Any, int]
    others: dict[Any, int]


@dataclass
class Roots:
    """Takes roots, powers and logarithms apart in expressions over a ring."""

    ring: Ring
    signs: Signs
    _found: dict[Any, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, exprs: Sequence[Any], conditions: Sequence[Any]) -> Roots | None:
        """For given expressions; None where there is nothing to be taken apart."""
        inner = [*dict.fromkeys(_arguments(exprs))]
        if not any(a.args for a in inner):
            return None
        try:
            held = set[Any]().union(*(a.free_symbols for a in inner))
            told = [e for e, _ in comparisons(conditions) if not held.isdisjoint(e.free_symbols)]
            ring = Ring([*exprs, *inner, *told])
        except EngineLimit:
            return None
        return cls(ring, Signs.of(ring, conditions, bounded=True))

    def apart(self, expr: Any) -> Any:
        """The expression with every root, power and logarithm taken apart."""
        rebuilt = self._found.get(expr)
        if rebuilt is None:
            rebuilt = self._found[expr] = self._rebuilt(expr)
            self._found.setdefault(rebuilt, rebuilt)
        return rebuilt

    def _rebuilt(self, expr: Any) -> Any:
        if not expr.args or is_atom(expr):
            return expr
        if isinstance(expr, se.log):
            return self._logarithm(expr.args[0])
        if isinstance(expr, se.Pow) and not isinstance(expr.args[1], se.Integer):
            base, exponent = expr.args[0], self.apart(expr.args[1])
            return self._exponential(exponent) if base == se.E else self._power(base, exponent)
        arguments = [self.apart(a) for a in expr.args]
        return expr if arguments == [*expr.args] else expr.func(*arguments)

    def _power(self, base: Any, exponent: Any) -> Any:
        """p**a q**a for (p q)**a; |p| for the root of the square of a p of either sign."""
        if exponent.is_Number and exponent.q == 2 and (plain := self._plain_root(base)) is not None:
            return plain ** (base.args[1] * exponent)
        factors = self._factors(base)
        if factors is None:
            return se.Pow(self.apart(base), exponent)
        parts = [se.Pow(n, e * exponent) for n, e in _primes(factors.content)]
        parts += [se.Pow(p, e * exponent) for p, e in factors.known.items()]
        if exponent.is_Number and exponent.q == 2:
            parts += [se.Pow(p, e * exponent) for p, e in _sizes(factors.others)]
            rest = [p for p, e in factors.others.items() if e % 2]
        else:
            rest = [p**e for p, e in factors.others.items()]
        return se.Mul(*parts, se.Pow(se.Mul(*rest), exponent))

    def _plain_root(self, base: Any) -> Any:
        """u or -u for the root of u**2, written so, where the sign of u is known: in sines the
        square need not be seen to be one."""
        if not (isinstance(base, se.Pow) and isinstance(base.args[1], se.Integer)):
            return None
        inner, power = base.args
        if power % 2 or not inner.atoms(*TRIGONOMETRIC):
            return None
        try:
            sign = self.signs.of_fraction(self.ring.fraction(inner))
        except (EngineLimit, KeyError):
            return None
        return sign.value * self.apart(inner) if sign is not None and sign.value else None

    def _logarithm(self, argument: Any) -> Any:
        """log p + log q for log(p q)."""
        factors = self._factors(argument)
        if factors is None:
            return se.log(self.apart(argument))
        terms = [e * se.log(n) for n, e in _primes(factors.content)]
        terms += [e * self._plain_logarithm(p) for p, e in factors.known.items()]
        terms += [e // 2 * se.log(p**2) for p, e in factors.others.items() if e // 2]
        rest = [p for p, e in factors.others.items() if e % 2]
        return se.Add(*terms, se.log(se.Mul(*rest)))

    def _plain_logarithm(self, positive: Any) -> Any:
        """a log(p) for log(p**a)."""
        if isinstance(positive, se.Pow):
            base, exponent = positive.args
            return exponent if base == se.E else exponent * self.apart(se.log(base))
        return se.log(positive)

    def _exponential(self, exponent: Any) -> Any:
        """p**a for exp(a log p)."""
        if not exponent.atoms(se.log):
            return se.exp(exponent)
        exponent = se.expand(exponent)
        terms = summands(exponent)
        powers, rest = [], []
        for term in terms:
            factors = factors_of(term)
            logs = [f for f in factors if isinstance(f, se.log)]
            if len(logs) == 1:
                powers.append(se.Pow(logs[0].args[0], term / logs[0]))
            else:
                rest.append(term)
        return se.Mul(se.exp(se.Add(*rest)), *powers)

    # -- factors --------------------------------------------------------------------------

    def _factors(self, base: Any) -> _Factors | None:
        """The factors of an expression by their signs; None where it is no positive number times
        such factors."""
        try:
            fraction = self.ring.fraction(base)
        except (EngineLimit, KeyError):
            return None
        if fraction.num == 0:
            return None
        unit, powers = self._with_sines(*self._powers(fraction))
        known, others = list[_Power](), list[_Power]()
        for poly, e in powers:
            sign = self.signs.of_polynomial(poly) if len(poly) <= TERMS else None
            if sign is None or not sign.value:
                others.append((poly, e))
            else:
                known.append((sign.value * poly, e))
                unit = unit if sign.value ** abs(e) > 0 else -unit
        if unit < 0:
            odd = next((k for k, (_, e) in enumerate(others) if e % 2), None)
            if odd is None:
                return None
            others[odd] = -others[odd][0], others[odd][1]
        return _Factors(abs(unit), self._express(known), self._express(others))

    def _powers(self, fraction: Fraction) -> tuple[Any, list[_Power]]:
        """A number, and primitive polynomials with their exponents."""
        return fraction_factors(fraction.num, self.ring.field.factors(fraction.den))

    def _with_sines(self, unit: Any, powers: list[_Power]) -> tuple[Any, list[_Power]]:
        """-s**2 for (c - 1) (c + 1), where the sign of the sine s is known."""
        gens = self.ring.field.gens
        for s, c in self.ring.angle_indices():
            if self.signs.of_polynomial(gens[s]) is None:
                continue
            ends = [e for p, e in powers if p in (gens[c] - 1, gens[c] + 1)]
            if len(ends) == 2 and ends[0] == ends[1]:
                unit = -unit if ends[0] % 2 else unit
                powers = [q for q in powers if q[0] not in (gens[c] - 1, gens[c] + 1)]
                powers += [(gens[s], 2 * ends[0])]
        return unit, powers

    def _express(self, powers: Iterable[_Power]) -> dict[Any, int]:
        return {self.apart(self.ring.polynomial(p)): e for p, e in powers}


def _arguments(exprs: Iterable[Any]) -> Iterator[Any]:
    """What roots and powers are taken of, and logarithms; logarithms in exponents."""
    for node in nodes(exprs):
        if isinstance(node, se.log):
            yield node.args[0]
        elif isinstance(node, se.Pow) and not isinstance(node.args[1], se.Integer):
            base, exponent = node.args
            if base != se.E:
                yield base
            elif exponent.atoms(se.log):
                yield exponent


def _sizes(powers: dict[Any, int]) -> Iterator[_Power]:
    """(p^2, k) for the part |p|^2k of p^e beside the root of p where e is odd.

    The product of all p with odd exponents is not negative where its root is real: so the size of
    the last one is that product by the sizes of the others, and sqrt(p/q) sqrt(q/p) is 1.
    """
    whole = {p: e // 2 for p, e in powers.items()}
    odd = sorted((p for p, e in powers.items() if e % 2), key=str)
    if len(odd) > 1 and whole[odd[-1]]:
        times = whole.pop(odd[-1])
        yield se.Mul(*odd), 2 * times
        whole.update({p: whole[p] - times for p in odd[:-1]})
    yield from ((p**2, k) for p, k in whole.items() if k)


def _primes(number: Any) -> list[tuple[Any, int]]:
    """The prime factors of a positive rational number, with their exponents."""
    above, below = (prime_factors(int(n)) for n in (number.p, number.q))
    return [(se.Integer(p), e) for p, e in (*above.items(), *((p, -e) for p, e in below.items()))]


def ring_over(
    exprs: Iterable[Any], relations: Sequence[Any] = (), work_limit: int = WORK_LIMIT,
    split: bool = False,
) -> Ring:  # fmt: skip
    """The ring that holds ``exprs`` where ``relations`` hold: expressions that vanish, and
    conditions, with which the roots of products are products of roots.  Where it is ``split``,
    exponentials of sums are products of those of the terms, so that equal ones have one form."""
    exprs = [*exprs]
    equations, conditions = split_hypotheses(relations)
    roots = Roots.of([*exprs, *equations], conditions) if conditions else None
    return Ring(exprs, equations, work_limit, None if roots is None else roots.apart, split)


def known_sign(expr: Any, hypotheses: Sequence[Any] = (), strict: bool = False) -> int:
    """1 or -1 where an expression in the engine's symbols is proved to have nowhere the other sign,
    or 0.

    ``hypotheses`` vanish, or are conditions that hold; ``strict``: nor is it zero.
    """
    sign = _sign_where(expr, tuple(hypotheses))
    return sign.value if sign is not None and (sign.strict or not strict) else 0


@lru_cache(maxsize=4096)
def _sign_where(expr: Any, hypotheses: tuple[Any, ...]) -> Sign | None:
    """The sign, strict or not: proofs of several claims ask for most of them."""
    try:
        ring = ring_over([expr], hypotheses)
        return Signs.of(ring, hypotheses, bounded=True).of_fraction(ring.fraction(expr))
    except EngineLimit:
        return None

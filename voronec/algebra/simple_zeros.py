"""Zeros and poles of the first order only: a certificate by a random section.

What is no multiple zero on one section is none at all: a component of the zero set along which a
function vanishes to a higher order would meet the section, with that order, unless at infinity.  So
one section with rational numbers and no multiple zero is a proof, for real and complex zeros alike
[Theory, eq. (14c)].  That no zero is at infinity is seen from the degree on lines, and on sections
with relations from the terms of the highest weights [Theory, eq. (14d)].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import lcm
from random import Random
from typing import Any

import flint
import symengine as se

from voronec.algebra.groebner import groebner_basis
from voronec.algebra.ring import Ring
from voronec.errors import DefinitionError, EngineLimit

_TRIES = 2
"""How many sections are tried: all but a set of measure zero serve."""
_MOST_BOUND = 4
"""With more relations and roots than this a section costs too much."""


def has_simple_zeros(
    expr: Any, relations: Sequence[Any] = (), moving: frozenset[Any] = frozenset()
) -> bool:
    """Whether it is proved that zeros and poles of an expression are of the first order.

    It is a function of the symbols ``moving``, of all where none are given; others are generic
    constants.  False says nothing.
    """
    return _has_simple_zeros(expr, tuple(relations), moving)


@lru_cache(maxsize=4096)
def _has_simple_zeros(expr: Any, relations: tuple[Any, ...], moving: frozenset[Any]) -> bool:
    try:
        ring = Ring([expr, *relations])  # the relations as polynomials, which vanish in their ring
        value = ring.fraction(expr)
        poly = value.num * ring.field.denominator(value.den)
        if poly.is_constant():
            return bool(poly != 0)
        if not _is_algebraic(ring):
            return False
        ideal = [ring.fraction(r).num for r in relations]
        still = {i for i, e in enumerate(ring.meaning) if moving and not e.free_symbols & moving}
        still -= {i for i, _, _ in ring.field.rules}  # bound, as a root of two is
        sections = (_Section(ring, frozenset(still), seed) for seed in range(_TRIES))
        return any(section.is_transverse(poly, ideal) for section in sections)
    except (DefinitionError, EngineLimit):
        return False


def _is_algebraic(ring: Ring) -> bool:
    """Whether the generators of a ring are independent but for its rules and relations.

    A sine of what occurs outside of it too is not: x^2 - sin(x)^2 has a zero of higher order.
    """
    taken: set[Any] = set()
    inner = [(angle, angle.free_symbols) for angle in ring.pairs]
    inner += [(unit, unit.free_symbols) for unit in ring.units.values()]
    functions = (se.FunctionSymbol, se.Derivative, se.Subs)
    for atom in ring.found.atoms:
        if isinstance(atom, se.Symbol):
            inner.append((atom, {atom}))
        elif not isinstance(atom, functions):
            inner.append((atom, atom.free_symbols))
    for _, symbols in inner:
        if taken & symbols:
            return False
        taken |= symbols
    return True


@dataclass(frozen=True)
class _Section:
    """Random rational values of all generators, along as many lines as there are conditions;
    those that are ``still`` are numbers."""

    ring: Ring
    still: frozenset[int]
    seed: int

    def is_transverse(self, poly: Any, ideal: Sequence[Any]) -> bool:
        """Whether the zeros of a polynomial on the section are simple."""
        ring, source = self.ring, Random(f"voronec section {self.seed}")
        roots = [ring.index(r) for r in ring.roots.values()]
        used = _support([poly, *ideal])
        while True:  # roots inside of roots
            rules = [(i, p) for i, _, p in ring.field.rules if i in used and i in roots]
            grown = used | _support([p for _, p in rules])
            if grown == used:
                break
            used = grown
        bound = [p for _, p in rules] + [p for p in ideal if p != 0]
        if len(bound) > _MOST_BOUND:
            return False
        names = [f"y{i}" for i in range(len(bound) + 1)]
        context = flint.fmpq_mpoly_ctx.get(names, flint.Ordering.degrevlex)
        lines, below = self._lines(context, source, {i for i, _ in rules})
        if not rules and not bound:
            numerator = compose_on_section(poly, lines, below, context)
            meets_all = numerator.total_degree() == self._degree(poly)
            return bool(meets_all and _squarefree(numerator, [*below.values()]))
        if below:
            return False  # angles and relations together are left to other means
        cut = [compose_on_section(p, lines, {}, context) for p in (*bound, poly)]
        if cut[-1] == 0:
            return False
        jacobian = [[p.derivative(name) for name in names] for p in cut]
        basis = groebner_basis([*cut, _determinant(jacobian)], context)
        if not any(p.is_constant() and p != 0 for p in basis):
            return False
        return self._meets_all((*bound, poly), lines, context)

    def _meets_all(self, polys: Sequence[Any], lines: Sequence[Any], context: Any) -> bool:
        """Whether no zero is at infinity: the terms of highest weight of all polynomials vanish
        together, along the section, at the origin alone [Theory, eq. (14d)]."""
        weights = self._weights()
        origin = [context.constant(0)] * len(context.gens())
        still = self.still
        ways = [v if i in still else v - v.compose(*origin) for i, v in enumerate(lines)]
        tops = [_top(p, weights).compose(*ways, ctx=context) for p in polys]
        basis = groebner_basis([p for p in tops if p != 0], context)
        alone = [{i for i, e in enumerate(p.monoms()[0]) if e} for p in basis]
        return all({i} in alone for i in range(len(context.gens())))

    def _weights(self) -> list[int]:
        """Whole weights of the generators, such that a root grows as its equation says: one for
        those that move, none for numbers."""
        weights = [Fraction(i not in self.still) for i in range(len(self.ring.meaning))]
        for i, degree, relation in reversed(self.ring.field.rules):  # inner roots before outer ones
            weights[i] = Fraction(0)
            weights[i] = _weight(relation, weights) / int(degree)
        scale = lcm(*(w.denominator for w in weights))
        return [int(w * scale) for w in weights]

    def _degree(self, poly: Any) -> int:
        """The degree on a section that meets every zero, none at infinity: twice that in the sine
        and cosine of each angle, where the lines run along the tangent of its half."""
        pairs = self.ring.angle_indices()
        angles = {i for pair in pairs for i in pair}
        monomials = [*poly.to_dict()]
        turned = sum(2 * max(int(m[s]) + int(m[c]) for m in monomials) for s, c in pairs)
        moved = [i for i in range(len(self.ring.meaning)) if i not in angles | self.still]
        return turned + max(sum(int(m[i]) for i in moved) for m in monomials)

    def _lines(self, context: Any, source: Random, roots: set[int]) -> tuple[list[Any], Any]:
        """A value for each generator; for sines and cosines numerators, and their denominators.

        An angle runs along tan(a/2), turned by a rational angle, so that no place is special; a
        root is an unknown of its own.
        """
        gens, count = context.gens(), len(self.ring.meaning)
        free, straight = iter(gens), gens[len(roots) :]
        values = [
            context.constant(_number(source)) if i in self.still else random_line(straight, source)
            for i in range(count)
        ]
        for i in sorted(roots):
            values[i] = next(free)
        below: dict[int, Any] = {}
        for s, c in self.ring.angle_indices():
            t, k = random_line(straight, source), _number(source)
            scale = (1 + k**2) * (1 + t**2)
            cosine, sine = (1 - k**2) * (1 - t**2), 2 * t * (1 - k**2)
            values[c] = cosine - 4 * k * t
            values[s] = sine + 2 * k * (1 - t**2)
            below[s] = below[c] = scale
        return values, below


def _weight(poly: Any, weights: Sequence[Any]) -> Any:
    """The highest weight of the terms of a polynomial."""
    return max(sum(int(e) * w for e, w in zip(m, weights, strict=True)) for m in poly.to_dict())


def _top(poly: Any, weights: Sequence[int]) -> Any:
    """The terms of the highest weight."""
    most = _weight(poly, weights)
    terms = poly.to_dict().items()
    kept = {m: c for m, c in terms if _weight(poly.context().from_dict({m: c}), weights) == most}
    return poly.context().from_dict(kept)


def random_line(gens: Sequence[Any], source: Random) -> Any:
    """A polynomial of the first degree in the generators, with random rational coefficients."""
    total = gens[0] * _number(source)
    for g in gens[1:]:
        total = total + g * _number(source)
    return total + _number(source)


def _number(source: Random) -> Any:
    return flint.fmpq(source.choice((1, -1)) * source.randint(2, 40), source.randint(1, 7))


def _support(polys: Sequence[Any]) -> set[int]:
    return {i for p in polys for i, degree in enumerate(p.degrees()) if degree}


def compose_on_section(
    poly: Any, values: Sequence[Any], below: dict[int, Any], context: Any
) -> Any:
    """A polynomial on a section, times the powers of denominators that clear it."""
    if not below:
        return poly.compose(*values, ctx=context)
    groups: dict[str, tuple[Any, list[int]]] = {}
    for i, scale in below.items():
        groups.setdefault(str(scale), (scale, []))[1].append(i)
    terms = list(poly.to_dict().items())
    total = context.constant(0)
    most = {k: max(sum(m[i] for i in g) for m, _ in terms) for k, (_, g) in groups.items()}
    for monomial, coefficient in terms:
        part = context.constant(coefficient)
        for i, e in enumerate(monomial):
            if e:
                part = part * values[i] ** int(e)
        for k, (scale, g) in groups.items():
            part = part * scale ** int(most[k] - sum(monomial[i] for i in g))
        total = total + part
    return total


def _squarefree(poly: Any, positive: Sequence[Any]) -> bool:
    """Whether a polynomial has no multiple factor but for those without zeros."""
    for factor in positive:
        while (parts := divmod(poly, factor))[1] == 0:
            poly = parts[0]
    return all(e == 1 for _, e in poly.factor_squarefree()[1])


def _determinant(rows: list[list[Any]]) -> Any:
    if len(rows) == 1:
        return rows[0][0]
    total = 0 * rows[0][0]
    for i, entry in enumerate(rows[0]):
        minor = [row[:i] + row[i + 1 :] for row in rows[1:]]
        total = total + (-1) ** i * entry * _determinant(minor)
    return total

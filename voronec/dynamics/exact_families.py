"""Families of steady motions exactly, with their parameters, and their conditions of stability.

    R(q, v) = 0,   F(q, v) = 0,   relations,   what is held

are polynomials once sines are letters.  Each is taken apart into irreducible factors, a branch for
each; Groebner bases tell which branches are empty, of how many dimensions the others are, and which
lie in others.  With F = 0 the linearisation is M dv' = F_q dq + F_v dv, so that

    det(lambda diag(1, M) - (R_x; F_x)) = 0

has polynomials as coefficients.  What holds for special values of parameters alone is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from random import Random
from typing import Any, NamedTuple

import flint
import symengine as se
import sympy as sp

from voronec.algebra.factors import irreducible_factors
from voronec.algebra.groebner import groebner_basis, reduce_by
from voronec.algebra.normal import quotient
from voronec.algebra.symbols import plain_name
from voronec.algebra.terms import atoms
from voronec.algebra.text import as_expression
from voronec.dynamics.spectrum import hurwitz_matrix
from voronec.dynamics.steady_equations import SteadyEquations
from voronec.equations.program.straight import without_stages
from voronec.errors import EngineLimit

BRANCHES = 500
"""So many branches are looked at."""
INVERSE = "inverse"
"""A letter beside the states."""
TERMS = 150
"""Equations of more terms in all are left to numbers."""
SIZE = 8
"""Of matrices with more rows no characteristic polynomial is written."""


@dataclass(frozen=True, eq=False)
class _Letters:
    """A ring of polynomials: states, sines and cosines of states, then constants."""

    ring: Any
    states: tuple[str, ...]
    constants: tuple[str, ...]
    names: Mapping[Any, Any]

    @classmethod
    def of(cls, exprs: Sequence[Any], states: Sequence[Any]) -> _Letters:
        """The ring of expressions.  ``EngineLimit`` where they are no polynomials in it."""
        names: dict[Any, Any] = {}
        for f in atoms(exprs, se.sin, se.cos):
            if f.args[0] in states:
                names[f] = se.Symbol(f"{type(f).__name__}_{f.args[0]}")
        letters = {x for e in exprs for x in e.xreplace(names).free_symbols}
        moving = [str(x) for x in (*states, *names.values()) if x in letters]
        still = sorted({str(x) for x in letters} - {*moving})
        ring = flint.fmpq_mpoly_ctx.get([*moving, *still], flint.Ordering.degrevlex)
        return cls(ring, tuple(moving), tuple(still), names)

    def read(self, expr: Any) -> Any:
        """A polynomial of the ring."""
        letters = [sp.Symbol(n) for n in self.ring.names()]
        try:
            poly = sp.Poly(expr.xreplace(self.names)._sympy_(), *letters, domain="QQ")
        except (sp.PolynomialError, sp.CoercionFailed):
            raise EngineLimit(f"'{expr}' is no polynomial in sines, states and constants") from None
        terms = {m: flint.fmpq(int(c.p), int(c.q)) for m, c in poly.as_dict().items()}
        return self.ring.from_dict(terms)

    def write(self, poly: Any) -> sp.Expr:
        """An expression in SymPy's symbols, sines written out."""
        back = {sp.Symbol(str(x)): f._sympy_() for f, x in self.names.items()}
        letters = [back.get(s, s) for s in map(sp.Symbol, self.ring.names())]
        terms = poly.to_dict().items()
        total = sp.Integer(0)
        for m, c in terms:
            powers = [x**k for x, k in zip(letters, m, strict=True)]
            total += sp.Rational(int(c.p), int(c.q)) * sp.Mul(*powers)
        return total

    def moves(self, poly: Any) -> bool:
        """Whether a polynomial holds states."""
        count = len(self.states)
        return any(any(m[:count]) for m in poly.monoms())


@dataclass(frozen=True, eq=False, repr=False)
class ExactFamily:
    """A family of steady motions: ``equations`` that vanish on it, in variables and parameters, and
    of how many dimensions it is for general parameters."""

    system_name: str
    equations: tuple[sp.Expr, ...]
    dimension: int
    letters: _Letters
    basis: tuple[Any, ...]
    matrices: tuple[sp.Matrix, sp.Matrix] | None
    values: Mapping[str, Any]

    def __repr__(self) -> str:
        text = ", ".join(map(str, self.equations))
        return f"ExactFamily({self.system_name!r}, dimension {self.dimension}: {text})"

    @cached_property
    def characteristic(self) -> tuple[sp.Expr, ...]:
        """The coefficients of the characteristic polynomial from the constant on, without those
        that vanish on the whole family, up to a common factor.

        ``EngineLimit`` where its matrix is large or holds sines.
        """
        if self.matrices is None:
            raise EngineLimit(
                f"the linearisation is not written out: sines stand in it, or over {SIZE} variables"
            )
        left, right = self.matrices
        unknown = sp.Symbol("lambda")
        zero = {sp.Symbol(n): 0 for n in self.zero}
        whole = (unknown * left - right).xreplace(zero)
        top = sp.fraction(sp.together(whole.det(method="berkowitz")))[0]
        poly = sp.Poly(sp.expand(top), unknown)
        read = (self.letters.read(se.sympify(c)) for c in reversed(poly.all_coeffs()))
        coefficients = [reduce_by(c, self.basis) for c in read]
        while coefficients and coefficients[0] == 0:
            coefficients.pop(0)
        return tuple(
            sp.factor(self.letters.write(c)) if c != 0 else sp.Integer(0) for c in coefficients
        )

    @cached_property
    def zero(self) -> tuple[str, ...]:
        """Variables that vanish on it."""
        ring = self.letters.ring
        variables = zip(self.letters.states, ring.gens(), strict=False)
        return tuple(name for name, x in variables if reduce_by(x, self.basis) == 0)

    @cached_property
    def conditions(self) -> dict[str, tuple[sp.Expr, ...]]:
        """The irreducible factors of what vanishes at critical values: ``real`` of the constant
        coefficient, ``pair`` of the Hurwitz determinant, or, where all eigenvalues come in pairs
        of opposite signs, ``meeting`` of the discriminant."""
        c = self.characteristic
        if len(c) < 2:
            return {}
        return {way: tuple(self._factors(e)) for way, e in (("real", c[0]), _critical_condition(c))}

    def _factors(self, expr: sp.Expr) -> Iterator[sp.Expr]:
        poly = reduce_by(self.letters.read(se.sympify(sp.together(expr).as_numer_denom()[0])),
                         self.basis)  # fmt: skip
        for factor, _ in irreducible_factors(poly)[1] if poly != 0 else ():
            if len(factor.monoms()) > 1:
                yield self.letters.write(factor)

    def ranges(self, over: Any) -> tuple[ExactRange, ...]:
        """Between which exact values of a variable or a parameter how many eigenvalues lie right
        of the imaginary axis, all other parameters having their values.

        ``EngineLimit`` where the characteristic polynomial holds other variables, or is none.
        """
        unknown, x = sp.Symbol("lambda"), sp.Symbol(plain_name(over))
        values = {sp.Symbol(n): exact_value(v) for n, v in self.values.items() if v is not None}
        values.pop(x, None)
        whole = sp.Add(
            *[c.xreplace(values) * unknown**k for k, c in enumerate(self.characteristic)]
        )
        for e in (e.xreplace(values) for e in self.equations):
            for y in sorted(e.free_symbols - {x}, key=str):
                if e.diff(y).is_number:  # the family tells it
                    whole = whole.xreplace({y: sp.expand(y - e / e.diff(y))})
        whole = sp.fraction(sp.together(whole))[0]
        others = whole.free_symbols - {unknown, x}
        if others or not whole.is_polynomial(unknown, x):
            raise EngineLimit(
                f"the characteristic polynomial holds {', '.join(sorted(map(str, others)))} beside "
                f"{x}; hold these: at={{name: value}}"
                if others
                else "it is no polynomial"
            )
        poly = sp.Poly(whole, unknown, x, domain="QQ")
        factors = (sp.Poly(f.as_expr(), unknown).all_coeffs()[::-1] for f, _ in
                   poly.factor_list()[1])  # fmt: skip
        edges = {r for c in factors for e in (c[0], c[-1], _critical_condition(c)[1]) if e.has(x)
                 for r in sp.Poly(e, x).real_roots()}  # fmt: skip
        ends = [-sp.oo, *sorted(edges), sp.oo]
        parts = [
            ExactRange(a, b, _on_right(poly.eval(x, _inside(a, b)))) for a, b in pairwise(ends)
        ]
        for i in reversed(range(1, len(parts))):  # what changes nothing is no end
            if parts[i - 1].unstable == parts[i].unstable:
                parts[i - 1 : i + 1] = [parts[i - 1]._replace(high=parts[i].high)]
        return tuple(parts)


class ExactRange(NamedTuple):
    """Between two values, exact or infinite, so many eigenvalues lie on the right."""

    low: sp.Expr
    high: sp.Expr
    unstable: int


def exact_value(value: Any) -> sp.Expr:
    """A value as it was given, of a float the fraction that it is."""
    exact = as_expression(value)
    return sp.Rational(exact) if exact.is_Float else exact


def _critical_condition(c: Sequence[sp.Expr]) -> tuple[str, sp.Expr]:
    """Whether a ``pair`` may cross the imaginary axis, or pairs on it have a ``meeting``, and what
    vanishes where they do; ``c`` are coefficients from the constant on, of a polynomial that is
    even where with one root its negative is one, as an irreducible one is."""
    if any(e != 0 for e in c[1::2]):
        return "pair", sp.Matrix(hurwitz_matrix(c)).det() if len(c) > 2 else sp.Integer(1)
    squares = sp.Poly([*reversed(c[::2])], sp.Symbol("lambda"))
    return "meeting", squares.discriminant() if squares.degree() > 1 else sp.Integer(1)


def _inside(low: sp.Expr, high: sp.Expr) -> sp.Rational:
    """A fraction between two values."""
    if low == -sp.oo:
        return sp.Rational(0) if high == sp.oo else sp.floor(high) - 1
    if high == sp.oo:
        return sp.ceiling(low) + 1
    digits = 3 + max(0, int(-sp.log(high - low, 10).evalf()))
    return sp.Rational(str(((low + high) / 2).evalf(digits + 15).round(digits)))


def _on_right(poly: sp.Poly) -> int:
    """How many roots of a polynomial lie right of the imaginary axis, enclosed by flint."""
    numbers = [int(c) for c in poly.clear_denoms()[1].all_coeffs()[::-1]]
    count = 0
    for factor, power in flint.fmpz_poly(numbers).factor()[1]:
        c = factor.coeffs()
        if any(c[1::2]):  # no root lies on the axis
            count += power * sum(root.real > 0 for root, _ in factor.complex_roots())
        else:
            squares = flint.fmpz_poly(c[::2]).complex_roots()
            count += power * sum(not (s.imag == 0 and s.real <= 0) for s, _ in squares)
    return count


def exact_families(equations: SteadyEquations) -> tuple[ExactFamily, ...]:
    """All families of steady motions for general parameters, those of most dimensions first.

    ``EngineLimit`` where the equations are no polynomials, or elimination grows too large.
    """
    form = equations.formulation
    if form.stages:
        plain, _ = without_stages(form.form, {})
        mass, rates, force = plain.mass, plain.rates, plain.force
    else:
        mass, rates, force = form.mass, form.rates, form.force
    held = [e - se.sympify(equations.targets[n]) for n, e in equations.held]
    fractions = [quotient(e, form.relations) for e in (*rates, *force)]
    tops = [f[0] for f in fractions] + [*form.relations, *held]
    states = equations.unknowns
    wide = [e for row in mass for e in row]
    letters = _Letters.of([*tops, *wide, *(f[1] for f in fractions)], states)
    circles = [letters.read(se.Integer(-1) + f**2 + se.cos(f.args[0]) ** 2)
               for f in letters.names if isinstance(f, se.sin)
               and se.cos(f.args[0]) in letters.names]  # fmt: skip
    divisors = [letters.read(f[1]) for f in fractions if f[1].free_symbols]
    start = [letters.read(e) for e in tops] + circles
    if sum(len(p.monoms()) for p in start) > TERMS:
        raise EngineLimit(f"the equations of steady motions have more than {TERMS} terms")
    branches = [
        (basis, dimension)
        for basis in _branches(start, letters)
        if (dimension := _dimension(basis, divisors, letters)) is not None
        and not any(reduce_by(d, basis) == 0 for d in divisors)
    ]
    branches.sort(key=lambda pair: -pair[1])
    kept: list[tuple[list[Any], int]] = []
    for basis, dimension in branches:
        if not any(all(reduce_by(p, basis) == 0 for p in other) for other, _ in kept):
            kept.append((basis, dimension))
    matrices = _matrices(rates, force, mass, states, equations.size)
    name = equations.system.name
    return tuple(
        ExactFamily(name, tuple(sp.factor(letters.write(p)) for p in basis), dimension, letters,
                    tuple(basis), matrices, equations.values)
        for basis, dimension in kept
    )  # fmt: skip


def _branches(start: Sequence[Any], letters: _Letters) -> Iterator[list[Any]]:
    """Groebner bases of branches that together hold all solutions for general parameters."""
    todo, count, seen = [[p for p in start if p != 0]], 0, set[Any]()
    while todo:
        polys = todo.pop()
        count += 1
        if count > BRANCHES:
            raise EngineLimit(f"the steady motions fall into more than {BRANCHES} branches")
        basis = groebner_basis(polys, letters.ring)
        key = frozenset(map(str, basis))
        if key in seen:
            continue
        seen.add(key)
        if any(not letters.moves(p) for p in basis):
            continue  # empty, or for special parameters alone
        split = next((f for f in (_moving_factors(p, letters) for p in basis) if f[1]), None)
        if split is None:
            yield basis
        else:
            todo += [[*basis, factor] for factor in split[0]]


def _moving_factors(poly: Any, letters: _Letters) -> tuple[list[Any], bool]:
    """The irreducible factors that hold states, and whether they are simpler than the whole."""
    factors = irreducible_factors(poly)[1]
    moving = [f for f, _ in factors if letters.moves(f)]
    return moving, len(factors) > 1 or any(power > 1 for _, power in factors)


def _dimension(basis: Sequence[Any], divisors: Sequence[Any], letters: _Letters) -> int | None:
    """How many states are independent of one another where constants have general values, for which
    random ones are taken, off the zeros of divisors; None where there are no solutions."""
    count, random = len(letters.states), Random(1)
    values = [flint.fmpq(random.randrange(2, 10**6), 997) for _ in letters.constants]
    ring = flint.fmpq_mpoly_ctx.get([*letters.states, INVERSE], flint.Ordering.degrevlex)
    special = []
    for poly in (*basis, *divisors):
        terms: dict[tuple[int, ...], Any] = {}
        for m, c in poly.to_dict().items():
            for value, power in zip(values, m[count:], strict=True):
                c *= value ** int(power)
            key = (*map(int, m[:count]), 0)
            terms[key] = terms.get(key, flint.fmpq(0)) + c
        special.append(ring.from_dict({m: c for m, c in terms.items() if c != 0}))
    whole = ring.gens()[-1]  # the inverse of the product of all divisors
    for divisor in special[len(basis) :]:
        whole *= divisor
    polys = [*special[: len(basis)], whole - 1] if divisors else special
    leading = [p.monoms()[0] for p in groebner_basis([p for p in polys if p != 0], ring)]
    held = [{i for i, k in enumerate(m) if k} for m in leading]
    wide = count + bool(divisors)
    for size in range(wide, -1, -1):
        for chosen in combinations(range(wide), size):
            if not any(h <= {*chosen} for h in held):
                return size
    return None


def _matrices(
    rates: Sequence[Any], force: Sequence[Any], mass: Any, states: Sequence[Any], size: int
) -> tuple[sp.Matrix, sp.Matrix] | None:
    """diag(1, M) and (R_x; F_x); None where they are large."""
    if size > SIZE or any(atoms([e], se.sin, se.cos) for e in (*rates, *force)):
        return None
    k, n = len(rates), len(force)
    left = sp.eye(k + n)
    for i in range(n):
        for j in range(n):
            left[k + i, k + j] = se.sympify(mass[i][j])._sympy_()
    variables = states[:size]
    slopes = [[e.diff(x)._sympy_() for x in variables] for e in (*rates, *force)]
    return left, sp.Matrix(slopes)

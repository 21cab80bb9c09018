"""Factors of polynomials over Q, by flint, within limits that do not depend on the machine."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import flint
import symengine as se
import sympy as sp

from voronec.errors import EngineLimit

MOST_TERMS, MOST_DEGREE = 20_000, 2_000
"""flint takes less than a second for polynomials of this size; for x^n - 1 the square of n."""


def write_polynomial(poly: Any, letters: Sequence[Any]) -> Any:
    """A polynomial of flint as an expression in symengine; ``letters`` stand for the first of its
    variables, and it holds no others."""
    terms = []
    for monomial, c in poly.to_dict().items():
        powers = [x ** int(e) for x, e in zip(letters, monomial, strict=False) if e]
        terms.append(se.Mul(se.Integer(int(c.p)) / int(c.q), *powers))
    return se.Add(*terms)


def irreducible_factors(poly: Any) -> tuple[Any, list[tuple[Any, int]]]:
    """A number, and the irreducible factors of a polynomial with their exponents.

    Raises ``EngineLimit`` where the polynomial has too many terms, or too high a degree.
    """
    if len(poly) > MOST_TERMS:
        raise EngineLimit(f"a polynomial of {len(poly)} terms is too large to be factored")
    if len(poly) > 1 and (degree := int(max(poly.degrees()))) > MOST_DEGREE:
        raise EngineLimit(f"a polynomial of degree {degree} is too large to be factored")
    unit, powers = poly.factor()
    return unit, [(factor, int(exponent)) for factor, exponent in powers]


def fraction_factors(num: Any, den: Iterable[tuple[Any, int]]) -> tuple[Any, list[tuple[Any, int]]]:
    """The factors of a fraction whose denominator is a product of powers: a number, and the
    irreducible ones with their exponents, those below negative."""
    unit, powers = irreducible_factors(num)
    for poly, exponent in den:
        content, parts = irreducible_factors(poly)
        unit /= content**exponent
        powers += [(part, -exponent * times) for part, times in parts]
    return unit, powers


def in_factors(expr: sp.Expr) -> sp.Expr:
    """An expression as one fraction of irreducible factors over Q.

    Functions and roots count as letters.  What is no fraction of polynomials with rational
    coefficients stays as it is.  SymPy's own way of factoring draws random numbers, and took now
    a second and now minutes for the same polynomial.
    """
    above, below = sp.fraction(sp.together(expr))
    number, powers = sp.Integer(1), dict[sp.Expr, Any]()
    try:
        for base, exponent in (*_powers(above, 1), *_powers(below, -1)):
            if base.is_Rational and exponent.is_Integer:
                number *= base**exponent
            else:
                powers[base] = powers.get(base, 0) + exponent
    except (sp.PolynomialError, EngineLimit):
        return expr
    product = sp.Mul(*(base**exponent for base, exponent in powers.items()))
    # SymPy would multiply a number into a sum of its own accord
    return sp.Mul(number, product, evaluate=not product.is_Add or abs(number) in (0, 1))


def _powers(expr: sp.Expr, sign: int) -> Iterator[tuple[sp.Expr, Any]]:
    """The factors of what is no fraction, with their exponents times a sign; numbers too."""
    for part in sp.Mul.make_args(expr):
        base, outer = part.as_base_exp()
        if not outer.is_Integer or not base.is_Add:
            yield base, outer * sign
            continue
        poly = sp.Poly(base)
        if poly.domain not in (sp.ZZ, sp.QQ):
            raise sp.PolynomialError(f"the coefficients lie in {poly.domain}")
        names = [f"x{i}" for i in range(len(poly.gens))]
        context = flint.fmpq_mpoly_ctx.get(names, flint.Ordering.lex)
        terms = {m: flint.fmpq(int(c.p), int(c.q)) for m, c in poly.terms()}
        number, factors = irreducible_factors(context.from_dict(terms))
        yield sp.Rational(int(number.p), int(number.q)), outer * sign
        for factor, inner in factors:
            size, plain = _polynomial(factor, poly.gens).primitive()
            unit = -size if plain.LC() < 0 else size
            yield sp.Rational(unit), inner * outer * sign
            yield (plain * sp.sign(unit)).as_expr(), inner * outer * sign


def _polynomial(poly: Any, gens: tuple[sp.Expr, ...]) -> sp.Poly:
    terms = {m: sp.Rational(int(c.p), int(c.q)) for m, c in poly.to_dict().items()}
    return sp.Poly(terms, *gens, domain=sp.QQ)

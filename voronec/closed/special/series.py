"""Power series in a small e, as lists of coefficients, and integrals around an interval."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from voronec.algebra.normal import shorten

__all__ = ["around", "half_width", "inverse", "product", "quotient", "square_root"]

Series = Sequence[sp.Expr]


def product(a: Series, b: Series, terms: int) -> list[sp.Expr]:
    """The first terms of a product."""
    return [
        sp.Add(*(a[i] * b[n - i] for i in range(n + 1) if i < len(a) and n - i < len(b)))
        for n in range(terms)
    ]


def inverse(a: Series) -> list[sp.Expr]:
    """1/a, with as many terms; the first coefficient is not zero."""
    return quotient([sp.S.One], a, len(a))


def quotient(a: Series, b: Series, terms: int) -> list[sp.Expr]:
    """a/b; the first coefficient of b is not zero."""
    found: list[sp.Expr] = []
    for n in range(terms):
        known = sp.Add(*(b[i] * found[n - i] for i in range(1, n + 1) if i < len(b)))
        found.append(((a[n] if n < len(a) else 0) - known) / b[0])
    return found


def square_root(a: Series, terms: int) -> list[sp.Expr]:
    """The root with a positive first coefficient."""
    found = [sp.sqrt(a[0])]
    for n in range(1, terms):
        known = sp.Add(*(found[i] * found[n - i] for i in range(1, n)))
        found.append(sp.factor(((a[n] if n < len(a) else 0) - known) / (2 * found[0])))
    return found


def around(
    rate: Series, beside: Series, a: sp.Expr, D: sp.Expr, y: sp.Symbol, terms: int
) -> list[sp.Expr]:
    """The integral of rate * (D - a y^2 + e beside[0] + e^2 beside[1] + ...)^(-1/2) over y, around
    the interval between the roots, divided by 2 pi, as a series in e.

    All of it is a sum of integrals of y^(2m) (D - a y^2)^(-1/2 - j), taken around a path that does
    not meet the roots; those with j > 0 are derivatives by D of those with j = 0.
    """
    width, found = sp.Dummy("D"), []
    powers = [[sp.S.One, *[sp.S.Zero] * terms]]
    shifted = [sp.S.Zero, *beside]
    for _ in range(terms):
        powers.append(product(powers[-1], shifted, terms))
    parts = [product(rate, power, terms) for power in powers[: terms + 1]]
    for n in range(terms):
        total = sp.S.Zero
        for j, part in enumerate(parts):
            poly = sp.Poly(sp.expand(part[n]), y) if part[n] != 0 else None
            for (power,), c in poly.terms() if poly is not None else ():
                total += sp.binomial(sp.Rational(-1, 2), j) * c * _moment(power, j, a, width)
        found.append(total.xreplace({width: D}))
    return found


def _moment(power: int, j: int, a: sp.Expr, D: sp.Symbol) -> sp.Expr:
    """The integral of y^power (D - a y^2)^(-1/2 - j) around the interval, over 2 pi."""
    m, odd = divmod(power, 2)
    if odd or j > m:
        return sp.S.Zero
    value = sp.Rational(sp.binomial(2 * m, m), 4**m) * D**m / a**m / sp.sqrt(a)
    for i in range(j):
        value = -sp.diff(value, D) / (i + sp.Rational(1, 2))
    return value


def half_width(
    beside: Series, a: sp.Expr, D: sp.Expr, y: sp.Symbol, terms: int
) -> tuple[list[sp.Expr], list[sp.Expr]]:
    """Half width and centre of the interval between the roots y of the same function."""
    rho, e, slope = sp.Dummy("rho", positive=True), sp.Dummy("e"), sp.Dummy("a")
    root = [rho]
    for n in range(1, terms):
        at = sp.Add(*(c * e**i for i, c in enumerate(root)))
        whole = -slope * (at**2 - rho**2)
        whole += sp.Add(*(e ** (i + 1) * g.subs(y, at) for i, g in enumerate(beside[:n])))
        root.append(sp.expand(sp.expand(whole).coeff(e, n) / (2 * slope * rho)))
    width = sp.sqrt(sp.factor(D / a))
    halves, middles = [], []
    for c in root:
        # odd powers of rho belong to the half width; there are none below -2 * terms
        (short,) = shorten([(c * rho ** (2 * terms)).xreplace({slope: a})])
        above, below = sp.fraction(sp.together(short))
        poly = sp.Poly(sp.expand(above), rho)
        parts = {n - 2 * terms: p / below for (n,), p in poly.terms()}
        odd = sp.Add(*(p * (D / a) ** ((n - 1) // 2) for n, p in parts.items() if n % 2))
        even = sp.Add(*(p * (D / a) ** (n // 2) for n, p in parts.items() if n % 2 == 0))
        halves.append(shorten([odd])[0] * width)
        middles.append(shorten([even])[0])
    return halves, middles

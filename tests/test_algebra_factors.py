"""Expressions in their irreducible factors, against SymPy's own factoring."""

from __future__ import annotations

import random

import pytest
import sympy as sp

from voronec.algebra.factors import in_factors

a, b, x = sp.symbols("a b x")
LEAVES = (a, b, x, sp.sin(x), sp.cos(a + b), sp.sqrt(a), sp.exp(x), sp.Rational(-4, 3))


def _random(draw: random.Random, depth: int) -> sp.Expr:
    if depth == 0:
        return draw.choice(LEAVES)
    one, other = _random(draw, depth - 1), _random(draw, depth - 1)
    kind = draw.randrange(4)
    if kind == 3 and other != 0:
        return one / other
    return (one + other, one * other, one - other)[kind % 3]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_it_is_what_sympy_finds(seed: int) -> None:
    expr = _random(random.Random(seed), 4)
    assert in_factors(expr) == sp.factor(expr)


def test_a_number_before_a_sum_stays_outside() -> None:
    assert str(in_factors(6 * x + 4 * a)) == str(sp.factor(6 * x + 4 * a)) == "2*(2*a + 3*x)"


def test_what_has_no_rational_coefficients_stays() -> None:
    expr = (sp.Float("0.5") * x + a) ** 2 / (x + a)
    assert in_factors(expr) == expr
    assert in_factors(2**x * (a * x + a)) == 2**x * a * (x + 1)

"""Inequalities: certificates, rational witnesses, and what stays open."""

from __future__ import annotations

from fractions import Fraction

import pytest
import sympy as sp

from voronec.algebra import certificates
from voronec.algebra.signs import prove_inequality
from voronec.errors import DefinitionError

p, q, r = POSITIVE = sp.symbols("p q r")
x, y, z = sp.symbols("x y z")
OPPOSITE = {"<": ">=", ">": "<=", "<=": ">", ">=": "<"}

TRUE = [
    (p * q + r, ">", 0),
    (p + q, ">", p),
    (p**2 + q**2, ">=", 2 * p * q),
    (p / q + q / p, ">=", 2),
    (x**2 + x * y + y**2, ">=", 0),
    (x**2 + 2 * x * y + 2 * y**2 + 1, ">", 0),
    ((x - y) ** 2 * (p + x**2), ">=", 0),
    (p * x**2 + 2 * q * x + q**2 / p + r, ">", 0),
    (-p / (1 + p), ">", -1),
    (-(1 + p), "<", -1),
    (1 / (1 + x**2), "<=", 1),
    (sp.sqrt(p), ">", 0),
    (sp.sqrt(p**2 + q), ">", -p),
    (sp.sqrt(x**2), ">=", 0),
    (sp.sqrt(x**2 + y**2), ">=", x),
    (sp.sqrt(x**2 + p), ">", x),
    (2 * x**2 + 3, ">", sp.sqrt(x**4 + 1)),
    (sp.sqrt(p * x**2 + q), ">=", -x * sp.sqrt(p)),
    (p**3 - 3 * p + 3, ">", 0),
    (x**4 - x + 1, ">", 0),
    (x**4 + y**4 + z**4, ">=", x**2 * y**2 + y**2 * z**2 + z**2 * x**2),
    (x**2 + p, "!=", 0),
    ((p + q * x) ** 2 + (q - p * x) ** 2, ">", 0),
    (p**2 + 2 * p * x + x**2 * (1 + q), ">", 0),
    (sp.sin(x) ** 2, "<=", 1),
    (sp.Rational(1, 3), "<", sp.Rational(1, 2)),
    (x * p, "<=", p * x),
]
FALSE = [
    (p, ">", q),
    (x, ">=", 0),
    (x**2, ">", 0),
    ((p - 7) ** 2 * q, ">", 0),
    (p**3 - 3 * p + 1, ">", 0),
    (x * y, ">=", -1000000),
    (sp.sqrt(p), ">=", 1),
    (sp.sqrt(p), "<", sp.sqrt(q)),
    (sp.sqrt(x**2 - y**2), ">=", x),
    (sp.sqrt(x**2 + 1), ">=", 2 * x),
    (1 + p, "<", 1),
    (x - 3, "!=", 0),
    (p * q - 12345, "!=", 0),
    (p, "<", p),
    (p * x**2 + 2 * q * x + q**2 / p - r, ">", 0),
]


@pytest.mark.parametrize(("a", "relation", "b"), TRUE)
def test_true_inequalities_are_proved(a: sp.Expr, relation: str, b: sp.Expr) -> None:
    verdict = prove_inequality(a, relation, b, POSITIVE)
    assert verdict.proved, verdict
    assert verdict.method.startswith("the difference of the sides is ")


@pytest.mark.parametrize(("a", "relation", "b"), TRUE)
def test_the_opposite_of_what_is_true_is_refuted(a: sp.Expr, relation: str, b: sp.Expr) -> None:
    if relation in OPPOSITE:
        assert prove_inequality(a, OPPOSITE[relation], b, POSITIVE).refuted


@pytest.mark.parametrize(("a", "relation", "b"), FALSE)
def test_a_witness_is_a_rational_point_at_which_the_relation_fails(
    a: sp.Expr, relation: str, b: sp.Expr
) -> None:
    verdict = prove_inequality(a, relation, b, POSITIVE)
    assert verdict.refuted and verdict.witness is not None, verdict
    at = {sp.Symbol(n): sp.Rational(Fraction(v)) for n, v in verdict.witness.point.items()}
    assert all(at.get(s, 1) > 0 for s in POSITIVE)
    left, right = sp.sympify(a).xreplace(at), sp.sympify(b).xreplace(at)
    assert left.is_real and right.is_real
    decided = {
        "<": left < right,
        ">": left > right,
        "<=": left <= right,
        ">=": left >= right,
        "!=": sp.Ne(left, right),
    }
    assert decided[relation] == sp.false


def test_what_is_neither_certified_nor_refuted_stays_open() -> None:
    motzkin = x**4 * y**2 + x**2 * y**4 + z**6 - 3 * x**2 * y**2 * z**2
    assert prove_inequality(motzkin, ">=", 0).undecided
    assert prove_inequality(sp.sin(x), "<=", 2).undecided  # a sine may be any number here
    assert prove_inequality(r * x**r + x**2, ">", 0, (r,)).undecided  # exact values took minutes


def test_latex_relations_and_symbols_that_sympy_knows_to_be_positive() -> None:
    m = sp.Symbol("m", positive=True)
    assert prove_inequality(m, r"\ge", 0).proved
    assert prove_inequality(m, r"\ne", 0).proved
    assert prove_inequality(x, r"\leqslant", 0).refuted


def test_what_is_no_inequality_is_refused() -> None:
    with pytest.raises(DefinitionError, match="'=' is no inequality"):
        prove_inequality(p, "=", q)
    with pytest.raises(DefinitionError, match="'p' is declared positive and real"):
        prove_inequality(p, ">", q, [p], [p])


def test_symbols_that_sympy_knows_to_be_negative() -> None:
    m, a = sp.Symbol("m", negative=True), sp.Symbol("a", positive=True)
    assert prove_inequality(m, "<", 0).proved
    assert prove_inequality(m * x**2, "<=", 0).proved
    assert prove_inequality(sp.sqrt(-m), ">", 0).proved
    refuted = prove_inequality(m + a, ">", 0)
    assert refuted.refuted and refuted.witness is not None
    assert Fraction(refuted.witness.point["m"]) < 0 < Fraction(refuted.witness.point["a"])
    with pytest.raises(DefinitionError, match="'m' is negative for SymPy, and declared otherwise"):
        prove_inequality(m, "<", 0, [m])


@pytest.mark.parametrize(("known", "degree"), [("nonpositive", 0), ("integer", 2)])
def test_no_point_is_sought_for_symbols_of_which_more_is_known(known: str, degree: int) -> None:
    """q <= 0, or q <= q^2, is true of them and fails at points that they cannot be at."""
    q = sp.Symbol("q", **{known: True})
    larger = q**2 if degree else 0
    assert prove_inequality(q, "<=", larger).undecided
    assert prove_inequality(q, "<=", larger, real=(q,)).refuted
    assert prove_inequality(q**2, ">=").proved


def test_symbols_that_are_not_real_are_refused() -> None:
    with pytest.raises(DefinitionError, match="'w' is not real"):
        prove_inequality(sp.Symbol("w", imaginary=True) ** 2, "<", 0)


def test_a_root_beyond_a_branch_point_is_no_point() -> None:
    assert prove_inequality(p + q * y + 1 / sp.sqrt(x), ">=", 0, POSITIVE).refuted


@pytest.mark.slow
def test_no_certificate_is_looked_for_in_squares_of_long_polynomials(monkeypatch):
    # two minutes went into the factors of polynomials of up to 100 000 terms
    seen = []
    factors = certificates.irreducible_factors
    monkeypatch.setattr(
        certificates, "irreducible_factors", lambda poly: seen.append(len(poly)) or factors(poly)
    )
    x, b, n = sp.symbols("x b n")
    first = sp.log(-4 * b**2 / 3 - b)
    second = sp.Min(2 * n**2, sp.sqrt(-(b**2) * n**2 / 3 + 2 * b * n + n**2))
    given = sp.Piecewise((first, x > sp.Rational(1, 2)), (second, True))
    assert prove_inequality(given, "<=", x, positive=(b,)).undecided
    assert sum(seen) < 200_000


def test_polynomials_of_high_degree_have_their_roots_isolated():
    # Sturm's chain took ten seconds at degree 76; one with a root is not positive
    x = sp.Symbol("x")
    hard = sum(((-1) ** k * (k**2 + 7) * x**k for k in range(100)), sp.Integer(0)) + 10**9 * x**100
    assert prove_inequality(hard + 10**6, ">", 0).proved
    assert prove_inequality(hard - 10**6, ">", 0).refuted


def test_a_function_does_not_take_any_value() -> None:
    # a "witness" set cos(exp(2 a y)) itself to 5/6, where it is 0.395
    a, b = sp.symbols("a b", positive=True)
    left = sp.cos(sp.exp(2 * a * sp.Symbol("y")))
    found = prove_inequality(left, "!=", b / 2)
    assert not found.proved
    if found.witness is not None:
        at = {sp.Symbol(n): sp.sympify(v) for n, v in found.witness.point.items()}
        assert abs((left - b / 2).subs({a: at[sp.Symbol("a")], b: at[sp.Symbol("b")]} | at)) < 1e-9


@pytest.mark.slow
def test_values_beyond_doubles_are_no_small_ratios() -> None:
    # an OverflowError of Fraction
    b = sp.Symbol("b", positive=True)
    assert not prove_inequality(-sp.sin(sp.sinh(4 * b + sp.Rational(5, 3))), "!=", 0).proved

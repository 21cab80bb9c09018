"""Equality has three answers, and none of them may ever be a guess."""

from __future__ import annotations

import itertools

import mpmath as mp
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from voronec import (
    DefinitionError,
    Equation,
    Fibration,
    System,
    Verdict,
    check_claims,
    prove_equal,
    velocity,
)
from voronec.audit import shorten

x, y, z, a, b, k = sp.symbols("x y z a b k")
p, q = sp.symbols("p q", positive=True)
f, g = sp.Function("f"), sp.Function("g")
half, third = sp.Rational(1, 2), sp.Rational(1, 3)

TRUE = {
    "pythagoras": (sp.sin(x) ** 2 + sp.cos(x) ** 2, 1),
    "addition": (sp.sin(x + y + z), sp.expand_trig(sp.sin(x + y + z))),
    "half angle": (sp.sin(x), 2 * sp.tan(x / 2) / (1 + sp.tan(x / 2) ** 2)),
    "shifted by a third of a turn": (
        sp.sin(x + sp.pi / 3) + sp.sin(x - sp.pi / 3), sp.sin(x),
    ),
    "angles that only look different": (sp.sin((x + 1) ** 2), sp.sin(x**2 + 2 * x + 1)),
    "secant": (sp.sec(x) ** 2 - sp.tan(x) ** 2, 1),
    "cotangent": (sp.csc(x) ** 2, 1 + sp.cot(x) ** 2),
    "hyperbolic": (sp.cosh(x) ** 2 - sp.sinh(x) ** 2, 1),
    "double hyperbolic": (sp.cosh(2 * x), 2 * sp.cosh(x) ** 2 - 1),
    "tanh": (1 - sp.tanh(x) ** 2, 1 / sp.cosh(x) ** 2),
    "exponentials": (sp.exp(x + y / 2) * sp.exp(y / 2), sp.exp(x) * sp.exp(y)),
    "a multiple of asinh": (
        sp.cosh(k * sp.asinh(x)) ** 2 - sp.sinh(k * sp.asinh(x)) ** 2, 1,
    ),
    "rational denominator": (
        1 / (sp.sqrt(x) + sp.sqrt(y)), (sp.sqrt(x) - sp.sqrt(y)) / (x - y),
    ),
    "cube root": (1 / (x**third - 1), (x ** (2 * third) + x**third + 1) / (x - 1)),
    "nested radicals": (
        1 / (sp.sqrt(1 + sp.sqrt(x)) + x),
        (sp.sqrt(1 + sp.sqrt(x)) - x) / (1 + sp.sqrt(x) - x**2),
    ),
    "roots of equal things": (sp.sqrt(x**2 + 2 * x * y + y**2 + 1), sp.sqrt((x + y) ** 2 + 1)),
    "symbolic power": (x ** (k + 1) / (x**k + x ** (k + 1)), x / (1 + x)),
    "derivative of a density": (
        sp.diff((1 + x**2) ** (1 / (2 * k)), x) * (1 + x**2),
        x / k * (1 + x**2) ** (1 / (2 * k)),
    ),
    "numbers": (sp.sqrt(6) / sp.sqrt(2) + 1 / sp.sqrt(3), 4 / sp.sqrt(3)),
    "golden": (sp.cos(sp.pi / 5) - sp.cos(2 * sp.pi / 5), half),
    "constants": (x * sp.pi * sp.E - sp.E * sp.pi * x * (sp.sin(y) ** 2 + sp.cos(y) ** 2), 0),
    "decimals": (0.1 * x + y / 4, x / 10 + 0.25 * y),
    "leibniz": (sp.diff(f(x) * g(x), x), f(x) * g(x).diff(x) + f(x).diff(x) * g(x)),
    "mixed derivatives": (g(x, y).diff(x, y) * sp.sin(x) ** 2,
                          g(x, y).diff(y, x) * (1 - sp.cos(x) ** 2)),
    "chain rule": (f(2 * x).diff(x), 2 * sp.Subs(f(y).diff(y), y, 2 * x)),
    "function of a function": (
        f(g(x)).diff(x), g(x).diff(x) * sp.Subs(f(y).diff(y), y, g(x)),
    ),
    "trigonometry of a function": (sp.sin(f(x)) ** 2 + sp.cos(f(x)) ** 2, 1),
}  # fmt: skip


@pytest.mark.parametrize("sides", TRUE.values(), ids=TRUE)
def test_identities_are_proved(sides):
    assert prove_equal(*sides).proved


def separated(verdict, left, right):
    """Whether the witness's values are the sides' values, recomputed, and differ."""
    assert verdict.witness is not None and verdict.witness.left != verdict.witness.right
    with mp.workdps(60):
        names = {sp.Symbol(n): sp.Rational(v) for n, v in verdict.witness.point.items()}
        values = [sp.N(sp.sympify(e).xreplace(names), 50) for e in (left, right)]
        said = [sp.Float(v, 40) for v in (verdict.witness.left, verdict.witness.right)]
        near = all(
            abs(v - s) <= abs(v) * sp.Rational(1, 10**27) for v, s in zip(values, said, strict=True)
        )
        return near and values[0] != values[1]


TRAPS = {
    "root of a square": (sp.sqrt(x**2), x),
    "root of a square of a difference": (sp.sqrt((x - y) ** 2), x - y),
    "root of squares": (sp.sqrt(x**2 * y**2), x * y),
    "root of a sine squared": (sp.sqrt(1 - sp.cos(x) ** 2), sp.sin(x)),
    "fourth root": (((x - 5) ** 4) ** sp.Rational(1, 4), x - 5),
    "absolute value": (sp.Abs(x), x),
    "arcsine": (sp.asin(sp.sin(x)), x),
    "arctangent": (sp.atan(sp.tan(x)), x),
    "angle of a vector": (sp.atan2(y, x), sp.atan(y / x)),
    "inverse of cosh": (sp.acosh(sp.cosh(x)), x),
    "product of roots": (sp.sqrt(x * y) * sp.sqrt(x / y), x),
    "root of minus": (sp.sqrt(-x), 0),
}


LATE_TRAPS = {
    "right up to ten": (sp.sqrt((x - 50) ** 2), 50 - x),
    "right near zero": (sp.sqrt(1 - sp.sin(x / 20) ** 2), sp.cos(x / 20)),
    "cosine of a small angle": (sp.sqrt(sp.cos(x / 50) ** 2), sp.cos(x / 50)),
    "two roots": (sp.sqrt((x - 50) ** 2) + sp.sqrt((x - 60) ** 2), 110 - 2 * x),
    "one absolute value": (sp.Abs(x - 50), 50 - x),
    "a small arcsine": (sp.asin(sp.sin(x / 100)), x / 100),
    "logarithm of a product": (sp.log(x**2), 2 * sp.log(x) + sp.log(sp.Abs(x + 99)) * 0),
}


@pytest.mark.parametrize("sides", LATE_TRAPS.values(), ids=LATE_TRAPS)
def test_what_fails_only_far_away_is_not_proved(sides):
    assert not prove_equal(*sides).proved


BESIDE_WALLS = {
    "right up to fifty": (sp.sqrt((x - 50) ** 2), 50 - x),
    "two roots": (sp.sqrt((x - 50) ** 2) + sp.sqrt((x - 60) ** 2), 110 - 2 * x),
    "a small angle": (sp.atan(sp.tan(y / 20)), y / 20),
    "a small arcsine": (sp.asin(sp.sin(x / 100)), x / 100),
    "the cosine of a small angle": (sp.sqrt(1 - sp.sin(x / 20) ** 2), sp.cos(x / 20)),
    "a sum of arctangents": (sp.atan(x) + sp.atan(y), sp.atan((x + y) / (1 - x * y))),
    "between two cuts": (sp.sqrt((1 - x) ** 2 * (1 - 2 * x) ** 2), (1 - x) * (1 - 2 * x)),
    "on a cut": (sp.sign(x) ** 2, 1),
    "on a cut of two roots": (
        sp.sqrt(x * y) + sp.sqrt(x * z) + sp.Abs(y * z), sp.sqrt(x * y) + sp.sqrt(x * z) + y * z,
    ),
    "a limit that is far": (sp.Max(x, -1000), x),
    "a small domain": (sp.log((sp.cos(5 * x) + 2) ** 2 - (x**2 + 2) ** 2), 1),
    "the orthant of two signs": (sp.sign(x) * sp.sign(y), sp.sign(x + y)),
}  # fmt: skip


def test_the_size_of_a_product_of_roots_is_real_where_these_are():
    size = sp.Abs(sp.sqrt(y) * sp.sqrt(z))
    assert not prove_equal(size * sp.Abs(y), y * size).refuted  # y and z are not negative there


COMPOSED = {
    "sine of an arctangent": (sp.sin(sp.atan(x)), x / sp.sqrt(1 + x**2)),
    "twice an arccosine": (sp.sin(2 * sp.acos(x)), 2 * x * sp.sqrt(1 - x**2)),
    "angle of a vector": (sp.sin(2 * sp.atan2(y, x)), 2 * x * y / (x**2 + y**2)),
    "angles that add up": (sp.asin(x) + sp.acos(x), sp.pi / 2),
    "reciprocal": (sp.atan(x**2 + 1) + sp.atan(1 / (x**2 + 1)), sp.pi / 2),
    "equal arguments": (sp.sin(sp.cos(x) ** 2), sp.sin(1 - sp.sin(x) ** 2)),
    "sines of sines": (sp.sin(sp.sin(2 * x) + y), sp.sin(2 * sp.sin(x) * sp.cos(x) + y)),
    "half of a sum": (
        sp.Abs(sp.tan((x + y) / 2)), sp.sqrt((1 - sp.cos(x + y)) / (1 + sp.cos(x + y))),
    ),
    "logarithm of a product": (sp.log(p * q), sp.log(p) + sp.log(q)),
    "logarithm of a root": (sp.log(sp.sqrt(p**2 + p)), (sp.log(p) + sp.log(p + 1)) / 2),
    "logarithm of a quotient": (sp.log(x / y), sp.log(sp.Abs(x)) - sp.log(sp.Abs(y))),
    "logarithm of a power": (sp.log((x**2 + 1) ** y), y * sp.log(x**2 + 1)),
    "power as exponential": ((sp.cos(x) + 2) ** y, sp.exp(y * sp.log(sp.cos(x) + 2))),
    "inverse hyperbolic sine": (sp.asinh(x), sp.log(x + sp.sqrt(x**2 + 1))),
    "inverse hyperbolic tangent": (sp.atanh(x), sp.log((1 + x) / (1 - x)) / 2),
    "root of a square of roots": (
        sp.sqrt(x**2 + y**2 + 2 + 2 * sp.sqrt(x**2 + 1) * sp.sqrt(y**2 + 1)),
        sp.sqrt(x**2 + 1) + sp.sqrt(y**2 + 1),
    ),
    "product of sizes": (
        (sp.Abs(x) + sp.Abs(y)) * sp.Abs(sp.Abs(x) - sp.Abs(y)), sp.Abs(x**2 - y**2),
    ),
    "quotients of one sign": (sp.sqrt(x / y) * sp.sqrt(y / x), 1),
    "sign": (sp.sign(x) * sp.Abs(x), x),
    "the root of a square in an angle": (
        sp.sin(sp.sqrt(p + q + 2 * sp.sqrt(p * q))),
        2 * sp.sin((sp.sqrt(p) + sp.sqrt(q)) / 2) * sp.cos((sp.sqrt(p) + sp.sqrt(q)) / 2),
    ),
    "half angles in an angle": (
        sp.cos(x**2 - sp.tan(y / 2)) + sp.cos(x**2 + sp.tan(y / 2)),
        2 * sp.cos(x**2) * sp.cos((1 - sp.cos(y)) / sp.sin(y)),
    ),
    "a turn that is written otherwise": (
        sp.sin(2 * y + sp.sin(sp.cos(y + x))),
        sp.sin(2 * y) * sp.cos(sp.sin(2 * sp.sin(y / 2 + x / 2) ** 2 - 1))
        - sp.sin(sp.sin(2 * sp.sin(y / 2 + x / 2) ** 2 - 1)) * sp.cos(2 * y),
    ),
    "an angle that is a number": (
        sp.tan(q + sp.sqrt(y / x) * sp.sqrt(x / y)),
        (sp.tan(q) + sp.tan(1)) / (1 - sp.tan(1) * sp.tan(q)),
    ),
    "sines of inverse sines": (
        sp.sin(sp.sin(2 * sp.acos(x))) ** 2 + sp.cos(2 * x * sp.sqrt(1 - x**2)) ** 2, 1,
    ),
    "opposite arguments of an arctangent": (
        sp.tan(sp.sin(3 * x) + sp.atan((p - y) ** 3)),
        ((p - y) ** 3 - sp.tan(4 * sp.sin(x) ** 3 - 3 * sp.sin(x)))
        / ((p - y) ** 3 * sp.tan(4 * sp.sin(x) ** 3 - 3 * sp.sin(x)) + 1),
    ),
    "half of an arctangent": (
        sp.cos((y - sp.atan(x)) / 2) * sp.cos((y + sp.atan(x)) / 2),
        sp.cos(y) / 2 + 1 / (2 * sp.sqrt(x**2 + 1)),
    ),
    "half angles in an exponent": (
        (p + 1) ** (sp.tan(y / 2) + 1), (p + 1) * (p + 1) ** ((1 - sp.cos(y)) / sp.sin(y)),
    ),
    "a product of exponentials above one": (
        sp.sinh((p + q) / 2), sp.sqrt((sp.cosh(p + q) - 1) / 2),
    ),
}  # fmt: skip


LEFT_OPEN = {
    "the root of a square in an angle", "half angles in an angle", "half angles in an exponent",
    "a turn that is written otherwise", "sines of inverse sines",
}  # fmt: skip
"""Functions of arguments that normal forms do not show to be equal."""


@pytest.mark.parametrize("name", COMPOSED)
def test_functions_of_functions_are_proved_equal(name):
    wanted = "undecided" if name in LEFT_OPEN else "proved"
    assert prove_equal(*COMPOSED[name]).status == wanted


NEARLY = {
    "arctangents of reciprocals": (sp.atan(x) + sp.atan(1 / x), sp.pi / 2),
    "arctangents of inner terms": (sp.sin(sp.atan2(y, x)), y / sp.sqrt(1 + y**2 / x**2) / x),
    "half of a sum": (sp.tan((x + y) / 2), sp.sqrt((1 - sp.cos(x + y)) / (1 + sp.cos(x + y)))),
    "logarithm of a square": (sp.log(x**2 * (y**2 + 1)), 2 * sp.log(-x) + sp.log(y**2 + 2)),
    "sign": (sp.sign(x) ** 2 * (1 + x), 1 + x),
    "sum of sizes": (sp.sqrt(x**2 + y**2 + 2 * x * y), sp.Abs(x) + sp.Abs(y)),
    "another angle": (sp.sin(sp.cos(x) ** 2), sp.sin(sp.sin(x) ** 2)),
    "arguments that are equal on one side": (
        sp.cos(x + sp.Abs(sp.tan(y / 2))), sp.cos(x + (1 - sp.cos(y)) / sp.sin(y)),
    ),
    "the root of a square of either sign": (
        sp.exp(sp.sqrt(x**2 + y**2 - 2 * x * y)), sp.exp(x - y),
    ),
    "half of an arctangent of either sign": (
        sp.sin(sp.atan(x) / 2), sp.sqrt((1 - 1 / sp.sqrt(1 + x**2)) / 2),
    ),
    "a quotient of either sign": (
        sp.sin(sp.sqrt(x / y) * x), sp.sin(sp.sqrt(x * y) * x / y),
    ),
}  # fmt: skip


REFUTED = {**TRAPS, **BESIDE_WALLS, **NEARLY}


@pytest.mark.parametrize("sides", REFUTED.values(), ids=REFUTED)
def test_what_is_equal_on_one_side_of_a_cut_is_refuted_by_values_that_differ(sides):
    verdict = prove_equal(*sides)
    assert verdict.refuted and separated(verdict, *sides)


def test_a_jump_is_no_witness_against_a_rate():
    """|v|' = -1 where v is not zero, and has no value where it is: friction stops there."""
    v = velocity(x)
    system = System(
        name="brake",
        fibration=Fibration(base=(x,)),
        lagrangian=v**2 / 2,
        forces={x: -sp.sign(v)},
        equations={"speed": Equation(sp.sign(v) * v, -1)},
    )
    assert not check_claims(system)[0].verdict.refuted


@pytest.mark.parametrize(("p", "q"), [*itertools.permutations(sp.symbols("a b c d u w"), 2)])
def test_the_root_of_a_quotient_keeps_its_sign(p, q):
    """sqrt(p/q) = sqrt(p q)/|q|, not sqrt(p q)/q: they differ where p and q are negative."""
    for left, right in (
        (z * sp.sqrt(p / q), z * sp.sqrt(p * q) / q),
        (sp.sqrt(p / q) + z, sp.sqrt(p * q) / q + z),
        (sp.sqrt((p + z) / q), sp.sqrt((p + z) * q) / q),
    ):
        verdict = prove_equal(left, right)
        assert not verdict.proved
        assert verdict.undecided or separated(verdict, left, right)


def test_refuted_values_differ_in_print():
    verdict = prove_equal(sp.sin(x) + sp.Rational(1, 10**50), sp.sin(x))
    assert verdict.undecided or verdict.witness.left != verdict.witness.right


NOT_REFUTABLE = {
    "pythagoras inside": (f(sp.sin(x) ** 2 + sp.cos(x) ** 2), f(1)),
    "square inside": (f((x + 1) ** 2), f(x**2 + 2 * x + 1)),
    "double angle inside": (f(sp.sin(2 * x)), f(2 * sp.sin(x) * sp.cos(x))),
    "nothing added": (f(x + y - y), f(x)),
    "twice inside": (f(f((x + y) ** 2)), f(f(x**2 + 2 * x * y + y**2))),
    "in a factor": (x * f(sp.sin(x) ** 2 + sp.cos(x) ** 2) + y, x * f(1) + y),
    "derivatives": (f((x + 1) ** 2).diff(x), f(x**2 + 2 * x + 1).diff(x)),
    "second place": (g(y, sp.cos(x) ** 2), g(y, 1 - sp.sin(x) ** 2)),
    "root of a quotient": (sp.sqrt(x / y) / sp.sqrt(y / x), x / y),
    "roots inside": (f(sp.sqrt(x) * sp.sqrt(x + 1)), f(sp.sqrt(x**2 + x))),
}


@pytest.mark.parametrize("sides", NOT_REFUTABLE.values(), ids=NOT_REFUTABLE)
def test_a_function_of_equal_things_is_never_refuted(sides):
    assert not prove_equal(*sides).refuted


@pytest.mark.parametrize("sides", [(f(x), f(y)), (f(x), g(x)), (f(x).diff(x), f(x)), (f(1), f(2))])
def test_unknown_functions_are_arbitrary(sides):
    verdict = prove_equal(*sides)
    assert verdict.refuted and verdict.witness.left != verdict.witness.right


def test_a_function_whose_arguments_agree_here_and_differ_there_is_not_proved():
    assert not prove_equal(f(sp.sqrt(x**2)), f(x)).proved


leaves = st.sampled_from([x, y, sp.Integer(2), sp.Rational(1, 3), sp.Integer(-1)])


def grown(children):
    pair = st.tuples(children, children)
    return st.one_of(
        pair.map(lambda p: p[0] + p[1]),
        pair.map(lambda p: p[0] * p[1]),
        children.map(sp.sin),
        children.map(sp.cos),
        children.map(lambda e: sp.sqrt(e**2 + 1)),
        children.map(lambda e: sp.sqrt(e**2, evaluate=False)),
        children.map(lambda e: 1 / (e**2 + 2)),
        children.map(sp.sinh),
        children.map(sp.Abs),
    )


terms = st.recursive(leaves, grown, max_leaves=5)


@pytest.mark.slow
@settings(max_examples=80, deadline=None)
@given(terms, terms, st.integers(-40, 40), st.integers(-40, 40))
def test_what_is_proved_holds_at_points_chosen_afterwards(left, right, p, q):
    at = {x: sp.Rational(p, 7), y: sp.Rational(q, 11)}
    for one, other in ((left, right), (left**2 - right**2, (left - right) * (left + right))):
        verdict = prove_equal(one, other)
        if verdict.proved:
            values = [sp.N(sp.sympify(e).xreplace(at), 40) for e in (one, other)]
            # of sinh(sinh(sinh(5))), which has 1e20 digits, SymPy has none right
            if all(v.is_real and v.is_finite and abs(v) < 10**30 for v in values):
                assert abs(values[0] - values[1]) <= 1e-30 * (1 + abs(values[0]))
        if verdict.refuted:
            assert separated(verdict, one, other)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(terms, terms)
def test_the_binomial_theorem_is_never_refuted(p, q):
    assert not prove_equal((p + q) ** 2, p**2 + 2 * p * q + q**2).refuted


CIRCLE = x**2 + y**2 - 1


def test_relations_are_used():
    assert prove_equal(x**4 - y**4, x**2 - y**2, (CIRCLE,)).proved
    assert prove_equal(sp.sqrt(1 - y**2), sp.sqrt(x**2), (CIRCLE,)).proved
    assert prove_equal(1 / (1 - x), (1 + x) / y**2, (CIRCLE,)).proved
    refuted = prove_equal(x, 1, (CIRCLE,))
    values = [sp.Rational(refuted.witness.point[n]) for n in "xy"]
    assert refuted.refuted and abs(values[0] ** 2 + values[1] ** 2 - 1) < 1e-28


def test_relations_that_touch_each_other_do_not_refute():
    assert not prove_equal(x, 1, (CIRCLE, x - 1)).refuted
    assert not prove_equal(x, y, ((x - y) ** 2,)).refuted


@pytest.mark.parametrize("relations", [(x, x - 1), (x**2 + 1,), (sp.Integer(1),)])
def test_relations_that_nothing_satisfies_have_no_witness(relations):
    try:
        verdict = prove_equal(x, 5, relations)
    except DefinitionError:
        return
    assert not verdict.refuted


SUM = sum(sp.symbols("a b c d e f"))
ONE = sp.sin(x) ** 2 + sp.cos(x) ** 2
HUGE = {
    "argument of a sine": (sp.sin(SUM**22) ** 2 + sp.cos(SUM**22) ** 2, 1),
    "many-fold angle": (sp.sin(10**7 * y) ** 2 + sp.cos(10**7 * y) ** 2, 1),
    "high power": (y ** (10**7) + ONE, y ** (10**7) + 1),
    "power of a sum": ((SUM + 1) ** 80 * ONE, (SUM + 1) ** 80),
    "inverse": (ONE / (SUM**7 + sp.sin(y) ** 7 + 1), 1 / (SUM**7 + sp.sin(y) ** 7 + 1)),
}


@pytest.mark.parametrize("sides", HUGE.values(), ids=HUGE)
def test_huge_input_is_answered(sides):
    assert not prove_equal(*sides).refuted


@pytest.mark.slow
def test_deep_input_is_answered():
    deep = x
    for _ in range(100):
        deep = sp.sin(deep + 1)
    assert prove_equal(deep * ONE, deep).proved


@pytest.mark.parametrize("bad", ["x(", None, sp.eye(2), sp.nan, sp.oo, sp.Integral(x, y), sp.true])
def test_what_is_no_expression_is_refused_in_one_line(bad):
    with pytest.raises(DefinitionError) as caught:
        prove_equal(bad, x)
    assert "\n" not in str(caught.value)


def test_a_verdict_is_not_a_truth_value():
    with pytest.raises(TypeError, match="three values"):
        bool(prove_equal(x, x))


def test_a_denominator_whose_conjugate_vanishes_is_answered():
    root = sp.sqrt(x**2)
    (found,) = shorten([1 / (root + x)])
    assert found.subs(x, 3) == sp.Rational(1, 6)
    assert prove_equal(x / (root + x) + root / (root + x), 1).proved


LETTERS = sp.symbols("a0:12")
LONG_SUM = sum(LETTERS)
LONG_PRODUCT = sum(n * p * q for n, (p, q) in enumerate(itertools.pairwise(LETTERS), 1))


@pytest.mark.parametrize(
    ("left", "right"),
    [
        (
            2 * sp.sin(LONG_SUM) * sp.sin(LONG_PRODUCT),
            sp.cos(LONG_SUM - LONG_PRODUCT) - sp.cos(LONG_SUM + LONG_PRODUCT),
        ),
        (sp.sin(LONG_SUM) ** 2 + sp.cos(LONG_SUM) ** 2, 1),
        (
            sp.sin(LONG_SUM + LONG_PRODUCT / 2) + sp.sin(LONG_SUM - LONG_PRODUCT / 2),
            2 * sp.sin(LONG_SUM) * sp.cos(LONG_PRODUCT / 2),
        ),
    ],
)
def test_sines_of_long_sums_are_not_written_out_term_by_term(left, right):
    assert prove_equal(left, right).proved
    assert prove_equal(left, right + sp.sin(LONG_SUM) / 1000).refuted


@pytest.mark.slow
def test_what_is_too_large_is_left_undecided_with_the_reason():
    angles = [p * LONG_SUM + q for p, q in itertools.pairwise(LETTERS)]
    angles += [p * LONG_PRODUCT for p in LETTERS]
    large = sp.Mul(*[sp.sin(a) + 2 for a in angles])
    mixed = sp.sin(sp.Add(*angles)) * large * (sp.sqrt(x**2) + x) * (sp.sqrt(x**2) - x)
    verdict = prove_equal(mixed + sp.exp(sp.log(x**2 + 1) / 3), sp.cbrt(x**2 + 1))
    assert verdict.proved or (verdict.undecided and "large" in verdict.method)


def test_a_polynomial_of_a_huge_degree_is_not_factored():
    x_to = x**5003 + x + 1
    verdict = prove_equal(sp.sqrt((x_to * y) ** 2) / x_to, sp.Abs(y) * sp.Abs(x_to) / x_to)
    assert not verdict.refuted
    verdict = prove_equal(sp.sin(1 / x_to) * sp.sign(x_to**2), sp.sin(1 / x_to) + x - x * ONE)
    assert verdict.undecided and "degree" in verdict.method


@pytest.mark.parametrize(
    "real",
    [sp.sqrt(x), 1 / sp.sqrt(x), x**y, x**sp.pi, sp.log(x), sp.acosh(x), x**y * sp.log(x)],
    ids=str,
)
def test_a_piece_that_is_not_taken_says_nothing_of_where_the_others_are(real):
    """sqrt(x) for x > 0 and x elsewhere is not sqrt(x) for x > 0 and |x| elsewhere: see x = -1."""

    def pieces(other):
        return sp.Piecewise((real, x > 0), (other, True))

    assert not prove_equal(pieces(x), pieces(sp.Abs(x))).proved
    assert not prove_equal(pieces(1) * sp.Abs(x), pieces(1) * x).proved
    assert not prove_equal(pieces(x) ** 2 * sp.sqrt(x**2), pieces(x) ** 2 * x).proved
    assert not prove_equal(pieces(1), pieces(2)).proved
    assert not prove_equal(pieces(x), pieces(-x)).proved


def test_the_origin_has_no_angle():
    """sin(2 atan2(-5z, 4z)) is -40/41 wherever atan2 is defined, which it is not at z = 0."""
    turned = sp.atan2(-5 * z, 4 * z)
    assert prove_equal(sp.sin(2 * turned), sp.Rational(-40, 41)).proved
    size = 5 * sp.Abs(z) + sp.Abs(sp.sin(2 * sp.atan2(-2 * x, 4 * x)))
    assert not prove_equal(size, 5 * sp.Abs(z) + sp.Rational(4, 5)).refuted
    assert prove_equal(sp.atan2(y, x), sp.atan(y / x)).refuted


WHOLE, EVEN = sp.Symbol("n", integer=True), sp.Symbol("e", even=True)
BELOW = sp.Symbol("l", negative=True)


@pytest.mark.parametrize(
    ("left", "right", "at"),
    [
        ((-1) ** WHOLE, 1, {WHOLE: 1}),
        (sp.cos(sp.pi * WHOLE) * x, x, {WHOLE: 1, x: 2}),
        (x**WHOLE, sp.Abs(x) ** WHOLE, {WHOLE: 3, x: -2}),
        ((x * y) ** WHOLE, sp.Abs(x * y) ** WHOLE, {WHOLE: 3, x: -2, y: 1}),
        (BELOW**WHOLE, (-BELOW) ** WHOLE, {WHOLE: 3, BELOW: -2}),
        ((x * y) ** sp.floor(z), sp.Abs(x * y) ** sp.floor(z), {x: -2, y: 1, z: 3}),
        (sp.Abs(x - 10**5), 10**5 - x, {x: 2 * 10**5}),
        (sp.Max(x, 10**9), 10**9, {x: 2 * 10**9}),
    ],
    ids=str,
)
def test_powers_of_negative_numbers_and_cuts_far_away(left, right, at):
    """Whole powers have signs; the truth is what SymPy's numbers say at one point."""
    left, right = sp.sympify(left), sp.sympify(right)
    assert left.subs(at) != right.subs(at)
    verdict = prove_equal(left, right)
    assert not verdict.proved
    if not {WHOLE, z} & left.free_symbols:
        assert verdict.refuted


def test_the_logarithm_of_what_is_negative_is_no_logarithm_of_its_size():
    assert not prove_equal(sp.log(sp.cosh(x) ** 2), 2 * sp.log(-sp.cosh(x))).proved
    assert prove_equal(sp.log(sp.cosh(x) ** 2), 2 * sp.log(sp.cosh(x))).proved
    assert prove_equal((x**2 + 1) ** WHOLE * (x**2 + 1), (x**2 + 1) ** (WHOLE + 1)).proved
    assert prove_equal(sp.log(BELOW * x), sp.log(-BELOW) + sp.log(-x)).proved
    assert not prove_equal(sp.log(BELOW * x), sp.log(-BELOW) + sp.log(x)).proved


def test_what_is_no_number_has_no_sign_and_no_angle():
    """At x = -1/2, z = 1 one factor is the sign of what is not real, beside a zero; atan2(u, u) has
    no value where u vanishes, whatever it is elsewhere."""
    product = sp.Mul(sp.sqrt(y**2 / (x * z)), sp.sqrt(x * z / y**2), evaluate=False)
    edge = sp.sqrt(1 - 4 * x**2)
    found = prove_equal(sp.sign(product) * sp.sign(edge), sp.sign(edge + 1))
    at = {name: sp.Rational(value) for name, value in found.witness.point.items()}
    assert found.refuted and at["x"] * at["z"] > 0  # 0 against 1 where x = 1/2
    u = sp.sin(2 * sp.acos(x))
    assert not prove_equal(sp.sin(2 * sp.atan2(u, u)), 1).refuted


def test_a_letter_for_an_exponent_does_not_make_its_base_positive():
    n = sp.Symbol("n", integer=True)
    sides = x ** sp.Abs(n), sp.Abs(x) ** sp.Abs(n)
    assert not prove_equal(*sides).proved
    assert not prove_equal(x ** sp.floor(y), sp.Abs(x) ** sp.floor(y)).proved
    assert not prove_equal(x**y, sp.Abs(x) ** y, [y - 3]).proved
    assert not prove_equal((x**2) ** y, x ** (2 * y), [2 * y - 1]).proved
    assert prove_equal((x**2) ** y, x ** (2 * y)).proved


def test_an_angle_without_a_value_in_one_case_is_no_error():
    """Where y = z the signs are zero, and what they stand beside is divided by zero."""
    x, y = sp.symbols("x y", real=True)
    d = x - y
    side = sp.sin((y - x) / sp.Abs(d) + sp.sqrt(d**2) * sp.sign(d))
    turn = sp.sqrt(d**2) / (y - x)
    other = sp.sin(turn) * sp.cos(d) + sp.sin(d) * sp.cos(turn)
    assert not prove_equal(side, other).refuted
    assert prove_equal(side, other + 1).refuted


def test_a_difference_may_write_a_radicand_with_other_signs():
    k, z, y = sp.symbols("k z y", real=True)
    left = sp.sqrt((k - z) / (y - 5))
    right = sp.sqrt((k - z) * (y - 5)) / sp.Abs(y - 5)
    assert prove_equal(left, right).proved
    assert prove_equal(left, 2 * right).refuted


def test_a_witness_without_variables_ends_with_its_values():
    answer = prove_equal(sp.sqrt(2), 1)
    assert answer.refuted and str(answer.witness).endswith(
        "against 1.00000000000000000000000000000"
    )


def test_a_complex_exponent_is_beyond_the_engine():
    n = sp.Symbol("n", integer=True)
    for left, right in ((sp.exp(sp.I * x), sp.cos(x)), (sp.exp(sp.I * sp.pi * n), (-1) ** n)):
        assert prove_equal(left, right).undecided


@pytest.mark.parametrize("function", [sp.exp, lambda u: sp.sqrt(sp.cos(u)), sp.log])
def test_what_relations_make_imaginary_has_no_value(function):
    found = prove_equal(function(y), function(sp.sqrt(1 - x**2)), [x - 2])
    assert found.undecided and "real values" in found.method


def test_a_proof_says_what_it_takes_for_positive() -> None:
    """(x^2)^(k/2) is |x|^k: for k = 3 and x = -1 it is not x^k."""
    assert prove_equal((x**2) ** (k / 2), x**k).limits == "where x > 0"
    assert prove_equal((x**2) ** (k / 2), x**k, x > 0).limits == ""
    assert prove_equal((1 + x**2) ** k * (1 + x**2), (1 + x**2) ** (k + 1)).limits == ""
    whole = sp.Symbol("k", integer=True)
    assert prove_equal(x**whole * x, x ** (whole + 1)).limits == ""


def test_conditions_with_commas_in_them_stay_whole() -> None:
    first, second = "P(u, v) != 0", "Derivative(Q(u), (u, v)) > 0, x > 0"
    found = Verdict("proved", "", domain=first).where(second, "x > 0", first)
    assert found.domain == f"{first}, {second}"
    assert found.where("R(w, v) != 0").domain == f"{first}, {second}, R(w, v) != 0"
    cut = found.where("sqrt(x*m**... > 0", "y > 0")
    assert cut.where("y > 0").domain == cut.domain


@pytest.mark.parametrize(
    "nothing", [1 / (sp.Abs(x) - sp.sqrt(x**2)), sp.log(sp.Abs(x) - sp.sqrt(x**2))]
)
def test_what_has_a_value_nowhere_is_neither_equal_nor_different(nothing):
    for sides in ((nothing, y), (y, nothing)):
        found = prove_equal(*sides)
        assert found.undecided and "has no value" in found.method
    with pytest.raises(DefinitionError, match="has no value"):
        prove_equal(x, y, [nothing])  # as a relation it is a mistake

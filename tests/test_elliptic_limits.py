"""Multiple roots, rest, and motions ever nearer to them."""

from fractions import Fraction

import pytest
from elliptic_problems import ONE_EACH, ball, integrand, problem, working_precision, worst_residual
from flint import arb, ctx

from voronec.elliptic import ends_of, invert

COMPLEX = (("0.3", "0.2"), ("-1", "0.3"))
MOMENTS = ("0", "0.3", "-2.9", "13.77", "-77.7")

MULTIPLE = {
    "a double root above": ("trigonometric", problem(
        -1, "0.5", 1, "0.2 0.9", double="1.5", weighted={"1": 1, "2": 1, "-1": -1},
        general=(COMPLEX[0], "3"), polynomials=ONE_EACH)),
    "a double root below": ("trigonometric", problem(
        -1, "0.5", -1, "0.2 0.9", double="0.1", weighted={"1": 1, "2": 1, "0.15": -1},
        general=(COMPLEX[0], "3"), polynomials=ONE_EACH)),
    "a double end with f beyond it": ("hyperbolic", problem(
        -1, "0.5", 1, "-0.2 1.9", double="0.9", weighted={"-0.3": 1, "2": -1, "5": 1},
        general=(*COMPLEX, "-3"), polynomials=ONE_EACH)),
    "a double end, f rises at infinity": ("hyperbolic", problem(
        1, "0.5", 1, "-0.2 -0.9", double="0.9", weighted={"-0.3": 1, "-0.5": -1},
        general=(*COMPLEX, "-3", "1.5"), polynomials=ONE_EACH)),
    "a double end below": ("hyperbolic", problem(
        -1, "0.5", 1, "0.9 -0.9", double="-0.1", weighted={"-1.3": 1, "2.5": -1},
        general=(*COMPLEX, "-3", "1.5"), polynomials=ONE_EACH)),
    "a double end of a cubic": ("hyperbolic", problem(
        1, "0.5", 1, "-0.2", double="0.9", weighted={"-1.3": 1, "-0.5": -1},
        general=(*COMPLEX, "1.5"), polynomials=ONE_EACH)),
    "a triple end": ("rational", problem(
        -1, "0.5", 1, "-0.2", triple="0.9", weighted={"-0.3": 1, "1.5": -1},
        general=(*COMPLEX, "-1"), polynomials=ONE_EACH)),
    "a triple end below": ("rational", problem(
        -1, "1.1", -1, "1.2", triple="0.9", weighted={"-0.3": 1, "1.5": -1},
        general=(*COMPLEX, "-1"), polynomials=ONE_EACH)),
    "two double ends": ("exponential", problem(
        1, "0.5", 1, double="-0.2 0.9", general=(*COMPLEX, "-1", "1"), polynomials=ONE_EACH)),
    "two double ends, downwards": ("exponential", problem(
        4, "0.5", -1, double="-0.2 0.9", general=(*COMPLEX, "-1", "1"), polynomials=ONE_EACH)),
    "two double ends, from their middle": ("exponential", problem(
        1, "0.35", 1, double="-0.2 0.9", general=(*COMPLEX, "-1", "1"), polynomials=ONE_EACH)),
    "rest": ("rest", problem(
        -1, "0.9", 0, "-0.2 1.9", double="0.9", weighted={"-0.3": 1, "2": -1},
        general=(COMPLEX[0], "-3"), polynomials=ONE_EACH, rest=True)),
}  # fmt: skip


_bits = working_precision(200)


@pytest.mark.parametrize("name", MULTIPLE)
def test_elementary_motions_satisfy_their_equations_and_start_where_they_must(name):
    kind, source = MULTIPLE[name]
    solution = invert(source)
    constants = solution.constants(100)
    assert constants.kind == kind and constants.nome == 0
    assert (constants.half is None) == (kind != "trigonometric") == (constants.advances is None)
    start = solution.enclose(0, 40)
    numbers = solution.source(200)
    assert start.x.overlaps(numbers.place) and start.rate.overlaps(numbers.rate)
    assert all(value.overlaps(arb(0)) for value in start.integrals)
    assert worst_residual(solution, MOMENTS) < 1e-17


@pytest.mark.slow
@pytest.mark.parametrize("name", MULTIPLE)
def test_integrals_of_elementary_motions_are_those_of_their_integrands_over_time(name):
    solution = invert(MULTIPLE[name][1])
    ctx.prec = 100
    numbers = solution.source(100)
    nodes = [(x, w) for n in range(12) for x, w in [arb.legendre_p_root(12, n, weight=True)]]
    found = solution.enclose(3, 30).integrals
    totals = [arb(0) for _ in found]
    for panel in range(12):
        for node, weight in nodes:
            t = (2 * panel + 1 + node) / 8
            x = solution.enclose(lambda bits, t=t: t, 25).x
            for j, integral in enumerate(numbers.integrals):
                totals[j] += weight / 8 * integrand(numbers, integral, x)
    assert all(abs(a - b) < 1e-11 for a, b in zip(found, totals, strict=True))


def test_motion_to_a_double_root_never_arrives_and_goes_on_forever():
    solution = invert(MULTIPLE["a double end with f beyond it"][1])
    late = solution.enclose(300, 250)
    ctx.prec = 1000
    assert solution.period == float("inf")
    assert 0 < ball("0.9") - late.x < 1e-30 and late.rate > 0


@pytest.mark.parametrize("split", ["1e-30", "1e-60"])
@pytest.mark.parametrize("apart", ["real", "complex"])
def test_near_a_separatrix_the_motion_is_near_that_of_the_double_root(split, apart):
    shared = {"weighted": {"1": 1, "-2": -1}, "polynomials": ONE_EACH}
    limit = invert(problem(-1, "0.5", 1, "-0.3 0.9", double="0.2", **shared))
    if apart == "real":
        near = problem(-1, "0.5", 1, f"-0.3 0.2 0.9 {Fraction('0.2') + Fraction(split)}", **shared)
    else:
        near = problem(-1, "0.5", 1, "-0.3 0.9", [("0.2", split)], **shared)
    close = invert(near)
    assert worst_residual(close, ("0", "3.3", "400")) < 1e-17
    assert 60 < close.period < 1000
    constants = close.constants(100)
    for value in (constants.mean, constants.half, constants.nome, constants.turn):
        assert value.rel_accuracy_bits() > 98
    assert all(phase.alpha.rel_accuracy_bits() > 98 for phase in constants.phases)
    for moment in ("-2", "5"):
        one, two = limit.enclose(moment, 40), close.enclose(moment, 40)
        bound = arb(100) * ball(split) ** (2 if apart == "complex" else 1) + ball("1e-39")
        bound *= 10**6
        assert abs(one.x - two.x) < bound
        gaps = [abs(a - b) for a, b in zip(one.integrals, two.integrals, strict=True)]
        assert all(gap < bound for gap in gaps)


@pytest.mark.parametrize("far", [10**6, 10**12])
@pytest.mark.parametrize("apart", ["real", "complex"])
def test_roots_that_are_almost_at_infinity_leave_the_motion_of_lower_degree(far, apart):
    shared = {"weighted": {"1": 1}, "polynomials": ("0 1 0",)}
    limit = invert(problem(-1, "0.5", 1, "0.2 0.9", **shared))
    if apart == "real":
        lead, roots, pairs = Fraction(-1, 10 * far**2), f"0.2 0.9 {far} {10 * far}", ()
    else:
        lead, roots, pairs = Fraction(-1, far**2), "0.2 0.9", [(far, 100)]
    solution = invert(problem(lead, "0.5", 1, roots, pairs, **shared))
    assert worst_residual(solution, ("0", "3.3", "40")) < 1e-17
    one, two = limit.enclose("7", 30), solution.enclose("7", 30)
    assert abs(one.x - two.x) * far < 100
    gaps = [abs(a - b) * far for a, b in zip(one.integrals, two.integrals, strict=True)]
    assert all(gap < 100 for gap in gaps)


def test_a_start_at_a_turning_point_has_its_turn_at_zero_exactly():
    for place, sign in (("0.9", 0), ("0.2", 0)):
        solution = invert(problem(-1, place, sign, "0.2 0.9", [("0.2", "1")]))
        constants = solution.constants(100)
        assert constants.turn.is_zero() and constants.base.overlaps(ball(place))
        ends = ends_of(solution.source)
        assert ends.start is (ends.upper if place == "0.9" else ends.lower)


def test_a_start_near_a_turning_point_has_an_accurate_turn():
    # rate^2 = 1e-60: x is 1e-60 or so below the root, which no double tells from it
    def source(bits):
        numbers = problem(-1, "0.9", 0, "0.2 0.9", [("0.2", "1")])(bits)
        place = ball("0.9") - ball("1e-60")
        f = (place - ball("0.2")) * ball("1e-60") * ((place - ball("0.2")) ** 2 + 1)
        return type(numbers)(numbers.factors, place, -f.sqrt())

    solution = invert(source)
    turn = solution.constants(100).turn
    slope = ball("0.7") * (ball("0.49") + 1)
    assert abs(turn / (-2 * (ball("1e-60") / slope).sqrt()) - 1) < 1e-30
    assert turn.rel_accuracy_bits() > 98


def test_rest_is_seen_where_the_rate_is_zero_at_a_multiple_root():
    source = problem(-1, "0.9", 0, "-0.2 1.9", double="0.9", polynomials=("1 2 0",))
    solution = invert(source)
    assert solution.constants(60).kind == "rest" and ends_of(source).at_rest
    assert solution.enclose("2.5", 30).integrals[0].overlaps(ball("7"))
    assert solution.enclose("2.5", 30).affine(arb(3), arb(3)).overlaps(arb(3))


def test_choices_between_equals_are_the_same_at_every_precision():
    # x starts half way between -1/3 and 1/3, the lattice is square, infinity is half way too
    rhombic = problem(-1, "0", 1, "-1/3 1/3", [("0", "1/3")], polynomials=("0 1 0",))
    for source in (rhombic, problem(-1, "0.5", 1, "1/3 2/3"), problem(-1, "0.3", 1, "0.1 0.5")):
        solution = invert(source)
        found = [solution.constants(bits) for bits in range(60, 400, 13)]
        kinds = {
            (c.kind, c.partner, round(float(c.base), 3), *(phase.side for phase in c.phases))
            for c in found
        }
        assert len(kinds) == 1


def test_rest_at_a_pole_without_weight_has_a_rate():
    source = problem(-1, "1", 0, "-0.2 1.9", double="1", weighted={"1": 0, "-1": 1})
    assert invert(source).enclose("2", 20).integrals[0].overlaps(arb(0))

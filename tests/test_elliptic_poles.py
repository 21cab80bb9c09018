"""Poles of every kind: near the path and on it, far away, without weights, and contradictions."""

from fractions import Fraction
from itertools import pairwise

import pytest
from elliptic_problems import (
    ONE_EACH,
    ball,
    evaluated,
    problem,
    times,
    working_precision,
    worst_residual,
)
from flint import acb, arb, ctx

from voronec.elliptic import Integral, Numbers, Pole, ends_of, invert
from voronec.errors import DefinitionError, EngineLimit

pytestmark = pytest.mark.slow

MOMENTS = ("0", "0.3", "-2.9", "13.77")
PAIRS = (("0.3", "0.2"), ("-1", "0.3"), ("0.5", "-0.1"), ("0.95", "-0.1"), ("-0.4", "0.1"))

GENERAL = {
    "rectangular, trigonometric": problem(
        -1,
        "0.5",
        1,
        "-1.5 -0.3 0.2 0.9",
        general=("-2", "2", "0.1", "-1", *PAIRS),
        polynomials=ONE_EACH,
    ),
    "rectangular, hyperbolic": problem(
        1,
        "0.5",
        1,
        "-1.5 0.1999 0.9 0.9001",
        general=("0", "-2", "2", *PAIRS),
        polynomials=ONE_EACH,
    ),
    "rhombic, trigonometric": problem(
        -1,
        "0.5",
        1,
        "-0.3 0.9",
        [("0.2", "1.05")],
        general=("-2", "2", *PAIRS),
        polynomials=ONE_EACH,
    ),
    "rhombic, hyperbolic": problem(
        -1,
        "0.5",
        1,
        "-0.3 0.9",
        [("0.2", "0.05")],
        general=("-2", "2", *PAIRS),
        polynomials=ONE_EACH,
    ),
    "cubic": problem(
        1, "0.5", 1, "0.2 0.9 1.3", general=("-2", "1", "2", *PAIRS), polynomials=ONE_EACH
    ),
    "quadratic": problem(
        -1, "0.5", 1, "0.2 0.9", general=("-2", "2", *PAIRS), polynomials=ONE_EACH
    ),
}


_bits = working_precision(200)


@pytest.mark.parametrize("name", GENERAL)
def test_integrals_with_poles_of_no_weight_satisfy_their_equations(name):
    solution = invert(GENERAL[name])
    constants = solution.constants(60)
    assert constants.log_terms
    if constants.kind == "hyperbolic":
        # beyond that the phase of a pole, as documented, is not continuous
        most = arb.pi() / (4 if constants.partner == "theta2" else 2)
        places = [one.place.imag for one in constants.log_terms] + [
            one.alpha for one in constants.phases
        ]
        assert all(abs(float(place)) < float(most) * 1.001 for place in places)
    assert worst_residual(solution, MOMENTS) < 1e-16


@pytest.mark.parametrize("name", GENERAL)
def test_integrals_with_poles_of_no_weight_are_continuous_and_advance_by_the_period(name):
    solution = invert(GENERAL[name])
    constants = solution.constants(200)
    pieces = 40
    values = [
        solution.enclose(lambda bits, k=k: 2 * k * solution.constants(bits).half / pieces, 25)
        for k in range(2 * pieces + 1)
    ]
    for j in range(len(constants.rates)):
        places = [float(value.integrals[j]) for value in values]
        # Beside a place 0.1 from the path the integrand is at most |share|/0.1; a logarithm
        # that changes its branch jumps by more than such a step allows.
        step = solution.period / pieces
        assert max(abs(b - a) for a, b in pairwise(places)) < 0.81 / 0.1 * step
        gain = values[2 * pieces].integrals[j] - values[pieces].integrals[j]
        assert abs(gain - constants.advances[j]) < 1e-23
        assert abs(values[pieces].integrals[j] - constants.advances[j]) < 1e-23


@pytest.mark.parametrize("gap", ["1e-12", "1e-26"])
@pytest.mark.parametrize("pair", [("0.2", "1"), ("0.2", "0.05")])
@pytest.mark.parametrize(("end", "side"), [("0.9", 1), ("0.2", -1)])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_trace_that_passes_close_to_a_pole_turns_by_nearly_pi_there(gap, pair, end, side, sign):
    place = Fraction(end) + side * Fraction(gap)
    source = problem(-1, "0.5", 1, "0.2 0.9", [pair], weighted={place: sign})
    solution = invert(source)
    assert solution.constants(60).phases[0].alpha.rel_accuracy_bits() >= 58
    before, after = around_passage(solution, end)
    turned = after.integrals[0] - before.integrals[0]
    # the integrand sign/(x - place) has the sign of -sign above the path
    assert abs(turned + side * sign * arb.pi()) < 0.1
    assert worst_residual(solution, ("0.2", "33")) < 1e-17
    assert abs(before.affine(1, 0) + before.affine(0, 1) - 1) < 1e-30


@pytest.mark.parametrize("pair", [("0.2", "1"), ("0.2", "0.05")])
@pytest.mark.parametrize("end", ["0.9", "0.2"])
def test_a_trace_through_a_pole_jumps_by_pi_at_each_passage_and_runs_on_great_circles(pair, end):
    solution = invert(problem(-1, "0.5", 1, "0.2 0.9", [pair], weighted={end: 0}))
    (phase,) = solution.constants(100).phases
    assert phase.alpha.is_zero() and solution.constants(100).rates[0].is_zero()
    before, after = around_passage(solution, end)
    assert before.integrals[0].overlaps(arb(0)) and after.integrals[0].overlaps(arb.pi())
    assert solution.enclose("200", 20).integrals[0].overlaps(passages(solution, 200) * arb.pi())


def passages(solution, t):
    """How many turns at the pole there are from 0 to t."""
    (phase,) = solution.constants(100).phases
    constants = solution.constants(100)
    first = float(constants.turn) + phase.side * float(constants.half)
    count = 0
    for k in range(-3, int(t / solution.period) + 3):
        count += 0 < first + k * solution.period < t
    return count


def around_passage(solution, end):
    """Just before and after a moment of t > 0 at which x is at the end."""

    def moment(bits):
        constants = solution.constants(bits)
        here = constants.base.overlaps(ball(end))
        first = constants.turn + (0 if here else constants.half)
        return first if first > 0 else first + 2 * constants.half

    return [
        solution.enclose(lambda bits, s=s: moment(bits) + s * ball("1e-3"), 40) for s in (-1, 1)
    ]


def test_a_trace_that_starts_in_a_pole_leaves_it_at_its_longitude():
    for pair in (("0.2", "1"), ("0.2", "0.05")):
        solution = invert(problem(-1, "0.9", 0, "0.2 0.9", [pair], weighted={"0.9": 0}))
        for t, turns in (("0", 0), ("1e-9", 0), ("-1e-9", -1), ("0.5", 0)):
            found = solution.enclose(t, 30).integrals[0]
            assert found.overlaps(turns * arb.pi())


def test_a_pole_with_weight_zero_that_the_trace_never_reaches_adds_nothing():
    source = problem(-1, "0.5", 1, "0.2 0.9 1 1.5", weighted={"1": 0, "-1": 1})
    assert len(invert(source).constants(60).phases) == 1
    asymptotic = problem(1, "0.5", 1, "0.2 -1", double="0.9", weighted={"0.9": 0, "0": 1})
    assert len(invert(asymptotic).constants(60).phases) == 1


@pytest.mark.parametrize("place", ["1e12", "-1e12", "1e30"])
def test_poles_almost_at_infinity_turn_as_the_pole_at_infinity_does(place):
    source = problem(
        -1, "0.5", 1, "0.2 0.9", [("0.2", "1")], weighted={place: 1}, polynomials=("0 1 0",)
    )
    solution = invert(source)
    assert worst_residual(solution, MOMENTS) < 1e-17
    found = solution.enclose("7", 45).integrals
    ctx.prec = 400
    numbers = solution.source(400)
    # w/(x - c) = -w/c - w x/c^2 + ...
    weight, c = numbers.poles[0].weight, numbers.poles[0].place
    expected = -7 * weight / c - found[1] * weight / c**2
    assert abs(found[0] - expected) < 100 / abs(c)


def test_an_affine_function_is_enclosed_by_its_values_at_the_ends():
    gap = Fraction(1, 10**12)
    solution = invert(problem(-1, "0.5", 1, f"0.2 {1 - gap}", [("0.2", "1")]))
    before, after = around_passage(solution, str(1 - gap))
    for found in (before, after):
        upper = found.base > found.other
        ends = (ball(gap), ball("0.8")) if upper else (ball("0.8"), ball(gap))
        assert found.affine(*ends).overlaps(1 - found.x)
        assert found.affine(*ends).rel_accuracy_bits() > 90


def plain(coefficients, place, rate, poles=(), integrals=()):
    def source(bits):
        factor = tuple(map(arb, coefficients))
        return Numbers(((factor, 1),), arb(place), rate, poles, integrals)

    return source


ONE = (Integral(arb(0), arb(0), arb(0), (1,)),)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (plain((-1, 0, 1), 0, arb(0)), "no real motion"),
        (plain((1, 0, -1), 0, arb(2)), "contradicts itself"),
        (plain((1, 0, 1), 0, arb(1)), "no root below"),
        (plain((1, 1), 0, arb(1)), "no root above"),
        (plain((1, 1, 1, 0, 0, -1), 0, arb(1)), "degree 5"),
        (plain((1, 0, -1), 0, arb(1), (Pole(arb(2), arb(1)),), ONE), "its weight"),
        (plain((1, 0, -1), 0, arb(1), (Pole(arb(0.5)),), ONE), "passes the pole"),
        (problem(-1, "0.9", 0, "-0.2 0.9 1.2 1.4", rest=True), "does not rest"),
    ],
)
def test_a_problem_without_a_motion_is_refused_in_one_line(source, message):
    with pytest.raises(DefinitionError, match=message) as raised:
        invert(source).constants(60)
    assert "\n" not in str(raised.value)


def hidden_double_root(bits):
    root = arb(2).sqrt()
    factor = [arb(-1)]
    for place in (ball("0.2"), ball("0.9"), root, 2 / root):
        factor = times(factor, [-place, arb(1)])
    return Numbers(((tuple(factor), 1),), ball("0.5"), evaluated(factor, ball("0.5")).sqrt())


def doubtful_weight(bits):
    pole = Pole(arb(1), arb(0, arb(2) ** -bits))
    return Numbers(((tuple(map(arb, (1, 0, -1))), 1),), arb(0), arb(1), (pole,), ONE)


@pytest.mark.parametrize(
    ("source", "message"),
    [(hidden_double_root, "may be equal"), (doubtful_weight, "may be a root of f")],
)
def test_what_no_precision_decides_is_a_limit_and_leaves_the_precision_as_it_was(source, message):
    with pytest.raises(EngineLimit, match=message):
        invert(source).constants(60)
    assert ctx.prec == 200


def test_the_very_moment_of_a_passage_through_a_pole_cannot_be_enclosed():
    solution = invert(problem(-1, "0.5", 1, "0.2 0.9", weighted={"0.9": 0}))

    def moment(bits):
        constants = solution.constants(bits)
        return constants.turn + constants.half * solution.constants(bits).phases[0].side

    with pytest.raises(EngineLimit, match="passage through a pole"):
        solution.enclose(moment, 30)
    with pytest.raises(EngineLimit, match="wide ball"):
        solution.enclose(arb(1, 1e-10), 30)


def test_a_time_may_be_given_in_any_exact_way():
    solution = invert(problem(-1, "0.5", 1, "0.2 0.9 1.5 2"))
    found = [
        solution.enclose(t, 30).x
        for t in ("0.25", 0.25, Fraction(1, 4), arb(0.25), lambda bits: arb(1) / 4)
    ]
    assert all(one.overlaps(found[0]) for one in found)
    late = solution.enclose("1e30", 30)
    assert worst_residual(solution, ("1e30",)) < 1e-17 and late.x.rad() < 1e-30


def test_where_f_vanishes_altogether_x_rests_anywhere():
    source = plain((), 0.25, arb(0), (), (Integral(arb(1), arb(2), arb(0)),))

    def empty(bits):
        numbers = source(bits)
        return Numbers((), numbers.place, numbers.rate, (), numbers.integrals)

    found = invert(empty).enclose(4, 30)
    assert found.x.overlaps(arb(0.25)) and found.integrals[0].overlaps(arb(6))
    assert invert(empty).roots == () and invert(empty).invariants == (0, 0, 0)


def test_ends_see_a_start_at_a_multiple_root():
    ends = ends_of(problem(-1, "0.9", 0, "-0.2 1.9", double="0.9"))
    assert ends.at_rest and ends.lower is ends.upper and ends.start.times == 2


def test_polynomial_parts_and_poles_are_integrated_together():
    def source(bits):
        numbers = problem(-1, "0.5", 1, "-0.3 0.9", [("0.2", "0.1")], weighted={"1": 1, "-1": -1})(
            bits
        )
        both = Integral(ball("0.3"), ball("-1.2"), ball("0.7"), (1, -1))
        return Numbers(numbers.factors, numbers.place, numbers.rate, numbers.poles, (both,))

    assert worst_residual(invert(source), MOMENTS) < 1e-17


def test_a_conjugate_pair_of_poles_is_the_sum_of_both_or_one_with_twice_the_share():
    def source(places):
        def at(bits):
            numbers = problem(-1, "0.5", 1, "-0.3 0.9", [("0.2", "0.1")])(bits)
            poles = tuple(Pole(acb(ball("0.3"), ball(im))) for im in places)
            share = acb(ball("0.7"), ball("0.4"))
            shares = (share, share.conjugate()) if len(places) == 2 else (2 * share,)
            integral = Integral(arb(0), arb(0), arb(0), shares)
            return Numbers(numbers.factors, numbers.place, numbers.rate, poles, (integral,))

        return at

    both, one = (invert(source(places)).enclose("9.1", 30) for places in (["0.2", "-0.2"], ["0.2"]))
    assert both.integrals[0].overlaps(one.integrals[0])
    assert worst_residual(invert(source(["0.2", "-0.2"])), MOMENTS) < 1e-17

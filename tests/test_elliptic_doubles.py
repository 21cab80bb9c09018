"""Evaluation in doubles against enclosures: every kind, near poles, and however late."""

import math
from fractions import Fraction

import numpy as np
import pytest
from elliptic_problems import ball, f_at, problem, working_precision
from flint import arb, ctx
from test_elliptic_inversion import SHAPES
from test_elliptic_limits import MULTIPLE

from voronec.elliptic import Integral, Numbers, Pole, invert
from voronec.elliptic.doubles import parts
from voronec.elliptic.many_times import BLOCK, Sample
from voronec.errors import DefinitionError, EngineLimit

ALL = SHAPES | {name: source for name, (_, source) in MULTIPLE.items()}
PERIODIC = [*SHAPES, "a double root above", "a double root below"]


_bits = working_precision(300)


def angle_error(found, exact):
    """How far an angle is from the exact one, whole turns apart."""
    turns = (exact - arb(float(found))) / (2 * arb.pi())
    return abs(float(turns - round(float(turns.mid())))) * 2 * math.pi


def relative_error(found, exact):
    return abs(float(arb(float(found)) / exact - 1))


def worst_errors(source, times):
    """The worst errors of x, of the shares of both ends, of the rate and of all angles."""
    solution = invert(source)
    sample = Sample.of(solution, times)
    count = len(solution.constants(64).rates)
    near, far = sample.affine(1.0, 0.0), sample.affine(0.0, 1.0)
    angles = [sample.modulo(j) for j in range(count)]
    whole = [sample.integral(j) for j in range(count)]
    worst = {"x": 0.0, "shares": 0.0, "rate": 0.0, "angles": 0.0, "integrals": 0.0}
    for place, t in enumerate(times):
        exact = solution.enclose(float(t), 40)
        ctx.prec = 300
        found = {"x": abs(float(exact.x - arb(float(sample.x[place]))))}
        shares = ((near, exact.near), (far, exact.far))
        found["shares"] = max(
            relative_error(a[place], b) if b > 1e-290 else float(a[place]) for a, b in shares
        )
        if abs(exact.rate) > 1e-290:
            found["rate"] = relative_error(sample.rate[place], exact.rate)
        found["angles"] = max(
            angle_error(a[place], b) for a, b in zip(angles, exact.integrals, strict=True)
        )
        found["integrals"] = max(
            float(abs(b - arb(float(a[place]))) / (1 + abs(b)))
            for a, b in zip(whole, exact.integrals, strict=True)
        )
        worst = {name: max(worst[name], found.get(name, 0.0)) for name in worst}
    return worst


@pytest.mark.parametrize("name", ALL)
def test_every_kind_of_motion_agrees_with_its_enclosures(name):
    worst = worst_errors(ALL[name], np.random.default_rng(3).uniform(-20, 20, 5))
    assert worst["x"] < 1e-15 and worst["angles"] < 5e-14 and worst["integrals"] < 5e-15
    assert worst["shares"] < 2e-14 and worst["rate"] < 2e-14


@pytest.mark.parametrize("name", PERIODIC)
@pytest.mark.parametrize("latest", [1e4, 1e9])
def test_errors_do_not_grow_with_time(name, latest):
    worst = worst_errors(ALL[name], np.random.default_rng(4).uniform(-latest, latest, 4))
    assert worst["x"] < 1e-15 and worst["angles"] < 5e-15 and worst["integrals"] < 5e-16
    assert worst["shares"] < 5e-15 and worst["rate"] < 5e-15


@pytest.mark.parametrize(
    "name", ["a double end with f beyond it", "a triple end", "two double ends", "rest"]
)
def test_motions_without_a_period_stay_finite_and_right_at_late_times(name):
    worst = worst_errors(ALL[name], np.array([-1e6, -800.0, 755.5, 1e6]))
    assert worst["x"] < 1e-15 and worst["integrals"] < 5e-15
    if name != "two double ends":
        assert worst["angles"] < 1e-14


def near_pole(distance, lead="-1", others="-1.5 -0.3 0.2"):
    """The pole that far beyond the end of the motion at 0.9, and one inside the other gap."""

    def source(bits):
        numbers = problem(lead, "0.5", 1, f"{others} 0.9")(bits)
        places = [ball("0.9") + ball(distance), ball("-2")]
        poles = tuple(Pole(c, (-f_at(numbers, c)).sqrt() / 2) for c in places)
        integrals = tuple(
            Integral(arb(0), arb(0), arb(0), shares) for shares in ((1, 0), (1, -1), (0, 1))
        )
        return Numbers(numbers.factors, numbers.place, numbers.rate, poles, integrals)

    return source


@pytest.mark.parametrize("others", ["-1.5 -0.3 0.2", "-1.5 0.19 0.2"])
@pytest.mark.parametrize("periods", [0, 100, 10**6])
def test_angles_are_right_while_a_trace_passes_very_near_a_pole(others, periods):
    source = near_pole("1e-24", others=others)
    solution = invert(source)
    constants = solution.constants(300)
    assert float(abs(constants.phases[0].alpha)) < 1e-11
    side = constants.phases[0].side
    moment = constants.turn + (2 * periods + side) * constants.half
    middle = float(moment.mid())
    steps = np.array([0, 1, -1, 3, 10, -100, 10**4, 10**9]) * np.spacing(middle)
    worst = worst_errors(source, np.unique(middle + steps))
    assert worst["angles"] < 1e-14 and worst["shares"] < 1e-14 and worst["rate"] < 1e-14


@pytest.mark.parametrize("shape", ["real", "complex"])
def test_angles_and_logarithms_are_right_all_along_a_period_near_a_separatrix(shape):
    """The trace stays near the double root for most of its long period."""
    gap = Fraction(1, 10**30)
    near = {"real": {"roots": f"-1.5 {Fraction('0.2') - gap} 0.2 0.9"}}
    near["complex"] = {"roots": "-1.5 0.9", "pairs": [("0.2", gap)]}
    source = problem(
        -1, "0.5", -1, **near[shape], weighted={"1": 1, "-2": -1}, general=(("0.3", "0.2"),)
    )
    half = invert(source).period / 2
    assert half > 60
    times = half * np.array([-3.3, 0.01, 0.3, 0.45, 0.5, 0.55, 0.8, 0.97, 1.01, 1.7])
    worst = worst_errors(source, times)
    assert worst["x"] < 1e-15 and worst["angles"] < 1e-13 and worst["integrals"] < 1e-13


def test_a_colatitude_is_accurate_next_to_the_pole():
    source = near_pole("1e-24")
    solution = invert(source)
    constants = solution.constants(300)
    place = ball("0.9") + ball("1e-24")
    moment = constants.turn + (40 + constants.phases[0].side) * constants.half
    times = float(moment.mid()) + np.array([0, 1e-13, -1e-9, 1e-4, 1.0])
    ends = [constants.base, constants.other]
    # the cosine x/place, which is 1 at the pole
    south = tuple(float((1 - x / place).mid()) for x in ends)
    north = tuple(float((1 + x / place).mid()) for x in ends)
    found = Sample.of(solution, times).colatitude(south, north)
    for angle, t in zip(found, times, strict=True):
        exact = solution.enclose(float(t), 60)
        ctx.prec = 300
        ratio = exact.affine(1 - ends[0] / place, 1 - ends[1] / place) / (1 + exact.x / place)
        assert relative_error(angle, 2 * ratio.sqrt().atan()) < 1e-15
    assert found.min() < 1e-11


def test_a_great_circle_through_the_pole_jumps_by_pi_at_it_and_starts_after_the_jump():
    def source(bits):
        numbers = problem("-1", "0.9", 0, "-1.5 -0.3 0.2 0.9")(bits)
        share = Integral(arb(0), arb(0), arb(0), (1,))
        return Numbers(
            numbers.factors, numbers.place, arb(0), (Pole(ball("0.9"), arb(0)),), (share,)
        )

    sample = Sample.of(invert(source), [0.0, 1e-300, 1e-9, -1e-300, -1e-9])
    found = sample.integral(0)
    assert found[0] == 0.0 and abs(found[1]) < 1e-15 and abs(found[2]) < 1e-8
    assert abs(found[3] + math.pi) < 1e-15 and abs(found[4] + math.pi) < 1e-8


def test_fast_angles_are_exact_to_a_turn_at_late_times():
    def source(bits):
        numbers = problem("-1", "0.5", 1, "-1.5 -0.3 0.2 0.9")(bits)
        return Numbers(
            numbers.factors, numbers.place, numbers.rate, (),
            (Integral(ball("123456.789"), ball("0.3"), arb(0), ()),),
        )  # fmt: skip

    times = np.random.default_rng(5).uniform(0, 1e9, 8)
    assert Sample.of(invert(source), times) is not None
    assert worst_errors(source, times)["angles"] < 1e-14


def test_results_do_not_depend_on_what_is_asked_together():
    solution = invert(SHAPES["rectangular, trigonometric"])
    times = np.linspace(-30, 50, 2 * BLOCK + 17)
    sample = Sample.of(solution, times)
    x, first, second = sample.each(lambda at: (at.x, at.integral(0), at.modulo(2, 0.25)))
    alone = Sample.of(solution, times[::1000])
    assert np.array_equal(x, sample.x) and np.array_equal(first, sample.integral(0))
    assert np.allclose(alone.x, x[::1000], rtol=0, atol=1e-15)
    shifted = np.exp(1j * (second - 0.25 - sample.modulo(2)))
    assert np.abs(shifted - 1).max() < 1e-14
    assert np.abs(sample.modulo(0)).max() <= math.pi
    unwrapped = np.exp(1j * (sample.integral(0) - sample.modulo(0)))
    assert np.abs(unwrapped - 1).max() < 1e-13


def test_shapes_of_times_are_kept_and_nothing_is_nothing():
    solution = invert(SHAPES["cubic"])
    assert Sample.of(solution, np.ones((2, 3))).integral(0).shape == (2, 3)
    assert Sample.of(solution, 0.5).x.shape == ()
    assert Sample.of(solution, []).modulo(0).shape == (0,)
    (empty,) = Sample.of(solution, []).each(lambda at: (at.x,))
    assert empty.shape == (0,)


def test_times_that_cannot_be_reduced_are_refused():
    solution = invert(SHAPES["cubic"])
    with pytest.raises(EngineLimit, match="half periods"):
        Sample.of(solution, [1e18])
    for bad in (math.nan, math.inf):
        with pytest.raises(DefinitionError, match="finite"):
            Sample.of(solution, [0.0, bad])


def test_parts_of_a_number_add_up_and_have_few_bits():
    value = arb.pi() * 1000
    pieces = parts(value, 20, 6)
    assert abs(sum((arb(p) for p in pieces), arb(0)) - value) < arb(2) ** (12 - 120)
    for number in (3, 2**33 - 1):
        assert all(arb(number * piece) == arb(number) * arb(piece) for piece in pieces)
    assert parts(-value, 20, 6) == tuple(-piece for piece in pieces)


def test_doubles_are_prepared_once_for_a_solution():
    solution = invert(SHAPES["quadratic"])
    assert solution.doubles is solution.doubles

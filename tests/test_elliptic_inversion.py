"""Simple roots: both lattices, both representations, against routes that share no code."""

import pytest
from elliptic_problems import (
    ONE_EACH,
    ball,
    evaluated,
    f_at,
    integrand,
    problem,
    working_precision,
    worst_residual,
)
from flint import acb, arb, ctx

from voronec.elliptic import ends_of, invert
from voronec.elliptic.roots import power
from voronec.elliptic.theta_balls import Sums

pytestmark = pytest.mark.slow

POLES = {"1": 1, "-2": -1}
MOMENTS = ("0", "0.3", "-2.9", "13.77")

SHAPES = {
    "rectangular, trigonometric": problem(
        -1, "0.5", 1, "-1.5 -0.3 0.2 0.9", weighted={**POLES, "0.1999": 1}, polynomials=ONE_EACH
    ),
    "rectangular, hyperbolic": problem(
        -1, "0.5", -1, "-1.5 0.18 0.2 0.9", weighted={**POLES, "0.19": 1}, polynomials=ONE_EACH
    ),
    "rectangular, the lower pair": problem(
        -1, "-0.5", 1, "-1.5 0.2 0.9 0.92", weighted={"0.3": -1, "-2": 1}, polynomials=ONE_EACH
    ),
    "rectangular, f rises at infinity": problem(
        1, "0.5", 1, "-1.5 0.2 0.9 1.2", weighted={"1": 1, "-1": -1}, polynomials=ONE_EACH
    ),
    "rhombic, trigonometric": problem(
        -1, "0.5", 1, "-0.3 0.9", [("0.2", "1.3")], weighted=POLES, polynomials=ONE_EACH
    ),
    "rhombic, hyperbolic": problem(
        -1, "0.5", -1, "-0.3 0.9", [("0.2", "0.1")], weighted=POLES, polynomials=ONE_EACH
    ),
    "cubic": problem(
        1, "0.5", 1, "0.2 0.9 1.3", weighted={"1": 1, "0.1": -1}, polynomials=ONE_EACH
    ),
    "cubic, hyperbolic": problem(
        -1, "0.5", 1, "0.2 0.9 0.199", weighted={"1": 1, "0.1995": -1}, polynomials=ONE_EACH
    ),
    "quadratic": problem(-1, "0.5", 1, "0.2 0.9", weighted=POLES, polynomials=ONE_EACH),
}


NEAR_SEPARATRICES = ("rectangular, f rises at infinity", "cubic")


_bits = working_precision(200)


@pytest.mark.parametrize("name", SHAPES)
def test_x_and_all_integrals_satisfy_their_equations_and_start_where_they_must(name):
    solution = invert(SHAPES[name])
    hyperbolic = "hyperbolic" in name or name in NEAR_SEPARATRICES
    assert solution.constants(100).kind == ("hyperbolic" if hyperbolic else "trigonometric")
    start = solution.enclose(0, 40)
    numbers = solution.source(200)
    assert start.x.overlaps(numbers.place) and start.rate.overlaps(numbers.rate)
    assert all(value.overlaps(arb(0)) for value in start.integrals)
    assert worst_residual(solution, MOMENTS) < 1e-17


@pytest.mark.parametrize("name", SHAPES)
def test_integrals_are_those_that_flint_finds_by_quadrature_over_x(name):
    solution = invert(SHAPES[name])
    numbers = solution.source(200)
    below, above = numbers.place, numbers.place + numbers.rate.sgn() / 8

    def over_x(of):
        def value(x, analytic):
            return of(x) / f_at(numbers, x).sqrt(analytic=analytic)

        return acb.integral(value, below, above).real * numbers.rate.sgn()

    time = over_x(lambda x: x * 0 + 1)
    found = solution.enclose(lambda bits: time, 35)
    assert abs(found.x - above) < 1e-35
    for integral, value in zip(numbers.integrals, found.integrals, strict=True):
        expected = over_x(lambda x, integral=integral: integrand(numbers, integral, x))
        assert abs(value - expected) < 1e-34


@pytest.mark.parametrize("name", [name for name in SHAPES if name != "quadratic"])
def test_x_is_that_of_the_function_of_weierstrass(name):
    solution = invert(SHAPES[name])
    constants = solution.constants(160)
    ((f, _),) = solution.source(200).factors
    first = [k * c for k, c in enumerate(f)][1:]
    second = [k * c for k, c in enumerate(first)][1:]
    slope, bend = evaluated(first, constants.base) / 4, evaluated(second, constants.base) / 24
    period, tau = 2 * constants.half, lattice_of_sums(constants)
    g2, g3 = tau.elliptic_invariants()
    assert abs(g2 / period**4 - constants.invariants[0]) < 1e-40
    assert abs(g3 / period**6 - constants.invariants[1]) < 1e-40
    for moment in ("0.37", "2.9"):
        t = ball(moment) - constants.turn
        wp = acb(t / period).elliptic_p(tau) / period**2
        x = constants.base + (slope / (wp - bend)).real
        assert abs(x - solution.enclose(moment, 45).x) < 1e-40


def lattice_of_sums(constants):
    """The complex period over the real one, by the documented meaning of nome and scale."""
    rhombic = constants.partner == "theta2" and constants.nome < 0
    if constants.kind == "trigonometric":
        return acb(ball("0.5") if rhombic else 0, -abs(constants.nome).log() / (2 * arb.pi()))
    ratio = arb.pi() / constants.scale / (2 * constants.half)
    return acb(ball("0.5"), ratio / 2) if rhombic else acb(0, ratio)


@pytest.mark.parametrize("name", SHAPES)
def test_a_period_later_x_is_the_same_and_the_integrals_have_advanced(name):
    solution = invert(SHAPES[name])

    def later(bits):
        return ball("0.4") + 14 * solution.constants(bits).half

    now, then = solution.enclose("0.4", 40), solution.enclose(later, 40)
    assert abs(now.x - then.x) < 1e-39 and abs(now.rate - then.rate) < 1e-38
    advances = solution.constants(160).advances
    for one, two, advance in zip(now.integrals, then.integrals, advances, strict=True):
        assert abs(two - one - 7 * advance) < 1e-38


@pytest.mark.parametrize("name", SHAPES)
def test_constants_are_as_accurate_as_asked_and_more_bits_only_narrow_them(name):
    rough, fine = invert(SHAPES[name]).constants(60), invert(SHAPES[name]).constants(400)
    for field in ("base", "other", "turn", "half", "scale", "nome", "mean"):
        one, two = getattr(rough, field), getattr(fine, field)
        assert one.overlaps(two)
        assert two.is_zero() or two.rel_accuracy_bits() > 395
    for one, two in zip(rough.rates + rough.advances, fine.rates + fine.advances, strict=True):
        assert one.overlaps(two) and two.rad() < 1e-118
    for one, two in zip(rough.phases, fine.phases, strict=True):
        assert (one.side, one.sign) == (two.side, two.sign)
        assert one.alpha.overlaps(two.alpha) and two.alpha.rel_accuracy_bits() > 395


@pytest.mark.parametrize("name", [name for name in SHAPES if name != "quadratic"])
def test_the_nome_is_small_and_the_partner_has_its_closed_form_near_the_other_end(name):
    constants = invert(SHAPES[name]).constants(160)
    assert abs(constants.nome) < 0.0434
    if constants.kind == "hyperbolic":
        sums = Sums(constants.kind, constants.nome, constants.partner)
        half = constants.scale * constants.half
        y = ball("0.3")
        factor = 2 * (-y).exp() if constants.partner == "theta4" else (half - 2 * y).exp()
        assert abs(sums.c(half - y) / (factor * sums.s(y)) - 1) < 1e-40
        assert sums.c(half).contains(0)


def series(kind: str, partner: str, r: arb, z: acb, order: int) -> tuple[acb, acb]:
    """Derivatives of the odd sum and of its partner, term by term."""
    step = acb(0, 1) if kind == "trigonometric" else acb(1)

    def odd(m: int, sign: int) -> acb:
        return (step * m) ** order * ((step * m * z).exp() + sign * (-step * m * z).exp()) / 2

    def term(m: int, parity: int) -> acb:
        return odd(m, parity * (-1) ** order)

    s = sum(((-1) ** n * r ** (n * (n + 1) // 2) * term(2 * n + 1, -1) for n in range(40)), acb(0))
    if partner == "theta4":
        root = r.sqrt()
        c = acb(0 if order else 1)
        for n in range(1, 60):
            c += 2 * (-1) ** n * root ** (n * n) * term(2 * n, 1)
    else:
        c = sum((r ** (n * (n + 1) // 2) * term(2 * n + 1, 1) for n in range(40)), acb(0))
    return s / step, c


@pytest.mark.parametrize("nome", ["0.04", "-0.04", "1e-30", "0"])
@pytest.mark.parametrize("z", [("0.3", "0"), ("1.4", "-0.7"), ("1e-40", "0"), ("0.1", "1.5")])
@pytest.mark.parametrize("kind", ["trigonometric", "hyperbolic"])
def test_the_sums_are_those_of_their_definition(kind, nome, z):
    ctx.prec = 400
    r, place = ball(nome), acb(ball(z[0]), ball(z[1]))
    partner = "theta4" if kind == "hyperbolic" and r >= 0 else "theta2"
    sums = Sums(kind, r, partner)
    (s, c), (slope, fall), (second, _) = (series(kind, partner, r, place, k) for k in range(3))
    found = [sums.s(place), sums.slope(place), sums.c(place), sums.fall(place), sums.bend(place)]
    known = [s, slope, c, fall, second / s - (slope / s) ** 2]
    assert all(
        abs(one - two) < 1e-50 * (1 + abs(two)) for one, two in zip(found, known, strict=True)
    )
    assert abs(sums.s(place) / s - 1) < 1e-50
    if z[1] == "0":
        assert sums.s(place.real).overlaps(s.real) and isinstance(sums.c(place.real), arb)


def test_a_power_of_a_ball_around_zero_is_a_number():
    assert power(arb(0, 1e-3), 2).overlaps(arb(1e-7)) and power(arb(0, 1e-3), 1).is_finite()
    assert power(arb(-2), 3) == -8 and power(arb(5), 0) == 1


def test_ends_are_found_without_inverting():
    ends = ends_of(SHAPES["rhombic, hyperbolic"])
    assert (ends.lower.times, ends.upper.times) == (1, 1)
    assert ends.lower.value.contains(ball("-0.3")) and ends.upper.value.contains(ball("0.9"))
    assert [root.real for root in ends.roots] == [True, True, False, False]


def test_the_arguments_of_poles_are_the_times_at_which_x_is_there():
    solution = invert(SHAPES["rectangular, trigonometric"])
    constants = solution.constants(100)
    ((f, _),) = solution.source(200).factors
    for pole, argument in zip(("1", "-2", "0.1999"), solution.arguments, strict=True):
        tau = lattice_of_sums(constants)
        first = [k * c for k, c in enumerate(f)][1:]
        second = [k * c for k, c in enumerate(first)][1:]
        slope, bend = evaluated(first, constants.base) / 4, evaluated(second, constants.base) / 24
        period = 2 * constants.half
        wp = (acb(argument) / period).elliptic_p(tau) / period**2
        assert abs(constants.base + slope / (wp - bend) - ball(pole)) < 1e-12


@pytest.mark.parametrize("near", ["0.000722", "0.0722", "1e-9"])
def test_all_roots_are_refined_as_far_as_the_precision_goes(near):
    ctx.prec = 400
    source = problem(-1, "-5", 1, "-7.58 -4.07", [("-0.374", near)], polynomials=("0 1 0",))
    for root in ends_of(source, 400).roots:
        assert root.value.rel_accuracy_bits() > 300
    assert worst_residual(invert(source), MOMENTS) < 1e-16

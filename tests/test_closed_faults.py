"""Motions that the closed form once refused or got wrong."""

import math

import pytest
import sympy as sp
from flint import acb_poly, arb, arb_poly, ctx

import voronec as vo
from voronec.closed.arithmetic import ball, compile_expressions, exact, precise, vanishes
from voronec.closed.classes import classify
from voronec.elliptic import Integral, Numbers, invert
from voronec.elliptic.roots import isolations

pytestmark = pytest.mark.slow

R = sp.Rational
x = sp.Symbol("x")


@pytest.fixture(scope="module")
def system():
    return vo.load("demchenko")


@pytest.fixture(autouse=True)
def precision():
    before = ctx.prec
    yield
    ctx.prec = before


def meets(form, time=7.25):
    """Whether balls and doubles of a motion agree at a time."""
    found, doubles = form.enclose(time, 30), form.modulo([time])
    with precise(200):
        for name, value in found.items():
            gap = float((value - float(doubles[name][0])).mid())
            if abs(math.remainder(gap, 2 * math.pi)) > 1e-12 * max(1, abs(gap)):
                return False
    return True


@pytest.mark.parametrize("power", [1, 2, 3, 7, -1, -2, -3])
def test_whole_powers_hold_for_balls_of_either_sign(power):
    with precise(64):
        value = arb(-0.25, 1e-9)
        assert compile_expressions([x**power], [x])([value])[0].contains(arb(-0.25) ** power)


@pytest.mark.parametrize("power", [2, 3, 8])
def test_a_ball_around_zero_has_powers(power):
    with precise(64):
        found = compile_expressions([x**power, x**power + 1], [x])([arb(0, 1e-3)])
        assert all(value.is_finite() for value in found)
        assert found[0].contains(0)
        assert found[0].rad() < 1e-5


def test_an_axial_constant_near_zero_is_no_singular_motion(system):
    start = {"u": sp.acos(R(3, 5)), "theta": sp.pi / 2, "u1": 1, "s": R(1, 3),
             "n": -R(27, 4) + R(1, 10**40)}  # fmt: skip
    assert meets(vo.closed_form(system, initial=start))


def test_starts_that_are_long_doubles_are_on_boundaries_all_the_same(system):
    form = vo.closed_form(system, initial={"u": 0.7, "theta": 1, "u1": 1, "n": 2})
    assert meets(form)
    assert classify(form)["on the ball"].label == "D2+B"


@pytest.mark.parametrize(
    ("value", "zero"),
    [
        (sp.sin(R(7, 10)) / sp.cos(R(7, 10)) - sp.tan(R(7, 10)), True),
        (1 / sp.sin(R(0.7)) ** 2 - 1 / sp.tan(R(0.7)) ** 2 - 1, True),
        (sp.sqrt(sp.sin(1) ** 2 + 2 * sp.sin(1) + 1) - sp.sin(1) - 1, True),
        (sp.sqrt((sp.sin(1) - 1) ** 2) - sp.sin(1) + 1, False),
        (sp.sqrt(5 + sp.sin(1)) * sp.sqrt(3 - sp.cos(1))
         - sp.sqrt((5 + sp.sin(1)) * (3 - sp.cos(1))), True),
        (sp.sqrt(5 + sp.sin(1)) * sp.sqrt(3 - sp.cos(1))
         + sp.sqrt((5 + sp.sin(1)) * (3 - sp.cos(1))), False),
    ],
)  # fmt: skip
def test_numbers_with_quotients_and_roots_are_told_from_zero(value, zero):
    assert vanishes(value) is zero


def test_a_number_that_is_only_small_is_not_said_to_vanish():
    assert not vanishes(sp.sin(R(0.7)) ** 2 + sp.cos(R(0.7)) ** 2 - 1 - R(1, 10**300))


UPRIGHT = [
    # (k, u, v1, s, tau, n)
    (R(1, 5), R(13, 10), -R(6, 5), R(21, 10), R(1, 2), R(17, 5)),
    (R(1, 2), 1, R(19, 12), -R(5, 4), -R(35, 12), -R(3, 2)),
    (0.9, 0.531483925574609, 1.4015931759350293, 0.9778904726576108, 0, -0.63),
    (sp.pi / 3, 2.06, -0.9, -1.73, 7.28, 3.586),
    (-sp.sqrt(2), sp.pi / 3, 2, 0, R(1, 2), 2),
]


@pytest.mark.parametrize("given", UPRIGHT)
def test_momenta_that_are_upright_are_seen_to_be(system, given):
    k, u, v1, s, tau, n = map(exact, given)
    M, A = R(13, 12), R(1, 5)
    a, b, c = (M + A) * s - k * sp.sin(u), (M + A) * tau, A * n + k * sp.cos(u)
    start = {"u": u, "v1": v1, "s": s, "tau": tau, "n": n, "theta": sp.atan2(a, -b),
             "u1": sp.atan2(sp.sqrt(a**2 + b**2), -c)}  # fmt: skip
    form = vo.closed_form(system, parameters={"k": k, "M": M, "A": A}, initial=start)
    assert form.attitude.upright
    assert meets(form)


def test_a_momentum_off_the_vertical_by_a_hair_is_turned(system):
    start = dict(system.scenes["default"].initial)
    form = vo.closed_form(system, initial=start)
    assert form.attitude.upright
    [theta] = [q for q in start if str(q) == "theta"]
    other = vo.closed_form(system, initial={**start, theta: start[theta] + R(1, 10**200)})
    assert not other.attitude.upright
    assert abs(form.enclose(3, 40)["u1"] - other.enclose(3, 40)["u1"]) < 1e-38


def quartic(*roots):
    found = arb_poly([1])
    for place in roots:
        found *= arb_poly([-place, 1])
    return found


@pytest.mark.parametrize(
    ("digits", "more"),
    [(12, ()), (12, (2,)), (12, (1,)), (40, ()), (40, (2,)), (40, (1,)), (100, ())],
)
def test_roots_near_each_other_are_isolated(digits, more):
    ctx.prec = 64 + 40 * digits * (1 + len(more))
    gap = arb(10) ** -digits
    roots = [arb(1) / 3, arb(1) / 3 + gap, arb(-1), *(arb(1) / 3 + k * gap * 3 for k in more)]
    *_, balls = isolations(acb_poly(quartic(*roots)))
    for place in roots:
        assert sum(held.real.contains(place.mid()) for held in balls) == 1
    assert not any(one.overlaps(two) for one in balls for two in balls if one is not two)


def test_equal_roots_are_not_isolated():
    ctx.prec = 200
    assert list(isolations(acb_poly(quartic(arb(2).sqrt(), arb(2).sqrt(), arb(-1))))) == []


def test_a_motion_between_roots_of_which_two_nearly_agree_is_inverted():
    def source(bits):
        gap = arb(10) ** -100
        f = quartic(arb(1) / 2, arb(1) / 2 + gap, -arb(1) / 2, arb(-1))
        place = arb(1) / 10
        integral = Integral(arb(1), arb(0), arb(0))
        return Numbers(((tuple(f.coeffs()), 1),), place, f(place).sqrt(), (), (integral,))

    solution = invert(source)
    # a separatrix in all but name: (dx/dt)^2 = (1/2 - x)^2 (x + 1/2)(x + 1)
    assert 375 < solution.period < 390
    assert abs(solution.enclose(200, 40).x - arb(1) / 2) < arb(10) ** -40


def test_a_sign_is_told_however_small_the_number(system):
    start = {"u": sp.acos(R(3, 5)), "theta": 1, "u1": 1, "s": R(1, 3), "n": -R(47, 178)}
    form = vo.closed_form(system, initial={**start, "tau": R(1, 10**50)})
    assert not form.rests
    assert form.kind == "trigonometric"
    assert vo.closed_form(system, initial={**start, "tau": 0}).rests
    nearer = vo.closed_form(system, initial={**start, "tau": R(1, 10**150)})
    with pytest.raises(vo.EngineLimit, match="two roots of f may be equal"):
        _ = nearer.kind


def test_a_momentum_almost_along_the_normal_has_a_start_in_doubles(system):
    start = {"u": 1, "v": R(43, 50), "v1": R(2, 5), "theta": R(13, 50), "u1": R(11, 10),
             "tau": R(9, 10**57), "n": -2}  # fmt: skip
    form = vo.closed_form(system, parameters={"k": 0}, initial=start)
    assert meets(form)
    assert abs(form.modulo([0.0])["theta"][0] - 0.26) < 1e-15


def test_an_angle_that_sympy_writes_with_a_logarithm_is_that_angle():
    along, across = sp.sin(1) - R(1, 2), -sp.cos(2)
    written = -sp.I * sp.log((along + sp.I * across) / sp.sqrt(along**2 + across**2))
    with precise(100):
        (found,) = compile_expressions([written + sp.pi], ())(())
        assert abs(found - arb.pi() - ball(sp.atan2(across, along))) < 1e-25


def test_velocities_of_coordinates_at_a_pole_are_refused_in_a_line(system):
    with pytest.raises(vo.EngineLimit, match="do not tell the start to many digits at a pole"):
        vo.closed_form(system, initial={"u": 1, "vdot": 0.3, "n": 1})


def test_a_start_next_to_a_pole_stays_on_its_side(system):
    start = {"u": math.pi, "theta": R(1, 2), "u1": 1, "s": R(1, 5), "tau": R(1, 3), "n": R(3, 2)}
    found = vo.closed_form(system, initial=start).at([0, 0.3])
    assert found["u"][1] < math.pi  # math.pi is less than pi by 1.2e-16, lost in a quotient by pi
    assert found["s"][0] == pytest.approx(0.2, abs=1e-12)


def test_both_names_of_a_start_next_to_a_pole_in_space_are_one_motion(system):
    beside = R(1, 10**20)
    start = {"u": 1, "theta": R(1, 2), "s": R(1, 5), "tau": R(1, 3), "n": R(3, 2)}
    near = vo.closed_form(system, initial={**start, "u1": sp.pi - beside})
    beyond = {"u1": sp.pi + beside, "v1": sp.pi, "theta": R(1, 2) + sp.pi}
    far = vo.closed_form(system, initial={**start, **beyond})
    first, second = near.at([0.3]), far.at([0.3])
    assert first["u1"][0] + second["u1"][0] == pytest.approx(2 * math.pi, abs=1e-12)
    for name in ("v1", "theta"):
        assert second[name][0] - first[name][0] == pytest.approx(math.pi, abs=1e-12)
        for form, whole in ((near, first), (far, second)):
            off = whole[name][0] - form.modulo([0.3])[name][0]
            assert math.remainder(off, 2 * math.pi) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("power", [40, 80])
def test_doubles_of_a_start_at_a_pole_but_for_very_little(system, power):
    start = {"u": R(1, 10**power), "theta": R(1, 2), "u1": 1, "s": R(1, 5), "tau": R(1, 3)}
    form = vo.closed_form(system, initial=start)
    assert meets(form, 0)
    assert meets(form, 0.3)


def test_what_cannot_be_had_is_refused_in_words_of_its_own(system):
    with pytest.raises(vo.DefinitionError, match="initial value 'u1' = u is not a real number"):
        vo.closed_form(system, initial={"u": 1, "u1": sp.Symbol("u")})
    with pytest.raises(vo.EngineLimit, match="digits = 20000 is more than 9830; ask for fewer"):
        vo.closed_form(system).enclose(1, 20000)


@pytest.mark.parametrize("power", [6, 12, 15, 30])
def test_angles_that_turn_fast_in_a_long_period_keep_their_digits(system, power):
    """The quartic is nearly zero everywhere: x needs 10^power seconds for what v does in one."""
    body = {"R1": -R(4, 3), "A": R(1, 48), "k": 1}
    start = {"u": sp.pi / 2, "s": R(12, 7), "tau": R(1, 10**power), "theta": R(1, 2), "u1": 1}
    form = vo.closed_form(system, parameters=body, initial=start)
    if power == 30:
        with pytest.raises(vo.EngineLimit, match=r"grows by 1\.08e\+31 in a period"):
            form.modulo([5])
        return
    assert meets(form, 5)
    assert form.at([5], ["v"])["v"][0] == pytest.approx(240 / 7, abs=1e-12)
    if power == 15:
        with pytest.raises(vo.EngineLimit, match="too many turns between passages of poles"):
            form.at([5])

"""Functions that saturate or overflow: what they are is computed, and no step goes over them."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from functools import cache

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import voronec as vo
from voronec import Fibration, System, velocity
from voronec.algebra.numeric_functions import elementary
from voronec.algebra.stable import stable_all
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.equations.program.switches import has_switches

pytestmark = pytest.mark.slow

x, t = sp.symbols("x t")
v = velocity(x)
METHODS = pytest.mark.parametrize("method", ["scipy", "heyoka", "flint"])


@cache
def system(force=0, potential=0, **options) -> System:
    return System(
        name="soft", fibration=Fibration(x), lagrangian=v**2 / 2 - potential, forces={x: force},
        **options,
    )  # fmt: skip


K = 1000
FRICTION = {
    "tanh": -sp.tanh(K * v),
    "logistic": 1 - 2 / (1 + sp.exp(-2 * K * v)),
    "exponentials": (sp.exp(-K * v) - sp.exp(K * v)) / (sp.exp(K * v) + sp.exp(-K * v)),
    "sinh by cosh": -sp.sinh(K * v) / sp.cosh(K * v),
}


@METHODS
@pytest.mark.parametrize("force", FRICTION.values(), ids=FRICTION)
def test_smooth_friction_brings_a_block_to_rest(force, method):
    """v' = -tanh(k v) has sinh(k v) = sinh(k) exp(-k t)."""
    times = [0, 0.5, 0.9, 1.005]
    run = vo.integrate(system(force), times=times, initial={v: 1}, method=method)
    with mp.workdps(500):
        truth = [float(mp.asinh(mp.sinh(K) * mp.exp(-K * mp.mpf(t))) / K) for t in times]
    assert run["xdot"].astype(float) == pytest.approx(truth, abs=1e-13)


RATIOS = {
    "cosh": -sp.cosh(999 * v) / sp.cosh(K * v),
    "sinh": -sp.sinh(999 * v) / sp.cosh(K * v),
    "exponentials": -sp.exp(999 * v) / (1 + sp.exp(K * v)),
}


@METHODS
@pytest.mark.parametrize("force", RATIOS.values(), ids=RATIOS)
def test_ratios_of_high_powers_do_not_overflow(force, method):
    """They are -exp(-|v|) for v > 0, but for 1e-400, and the last one nothing for v < 0."""
    run = vo.integrate(system(force), times=[0, 0.5, 1], initial={v: 1}, method=method)
    truth = [math.log(math.e - t) for t in (0, 0.5, 1)]
    assert run["xdot"].astype(float) == pytest.approx(truth, abs=1e-12)
    run = vo.integrate(system(force), times=[0, 1], initial={v: -9}, method=method)
    change = {"cosh": -1, "sinh": 1, "exponentials": 0}
    rate = next(change[name] for name, f in RATIOS.items() if f == force)
    assert float(run["xdot"][-1]) == pytest.approx(-9 + rate * math.exp(-9), rel=1e-8)


def test_saturation_in_many_digits():
    run = vo.integrate(system(FRICTION["tanh"]), times=[0, 1.005], initial={v: 1}, tol=1e-30)
    with mp.workdps(500):
        truth = mp.asinh(mp.sinh(K) * mp.exp(-K * mp.mpf(1.005))) / K
    assert abs(run["xdot"][-1] - truth) < 1e-29


@METHODS
def test_a_ramp_is_fallen_down_and_left(method):
    """Over the potential log(1 + exp(2000 x))/2000, x for x > 0, the motion is that of a corner,
    but for a part in a million."""
    ramp = sp.log(1 + sp.exp(2000 * x)) / 2000
    made = replace(system(potential=ramp), integrals={"energy": v**2 / 2 + ramp})
    run = vo.integrate(made, times=[0, 0.5, 1], initial={x: 1, v: -1}, method=method)
    fall = math.sqrt(3) - 1
    assert run["x"].astype(float) == pytest.approx([1, 0.375, -math.sqrt(3) * (1 - fall)], abs=2e-6)
    assert run.drift["energy"] < 1e-11
    assert all(claim.verdict.proved for claim in vo.check_claims(made))


@METHODS
def test_no_step_goes_over_a_narrow_barrier(method):
    """A barrier 1/cosh(1000 x) of height 1 throws back what comes with energy 1/2."""
    made = system(potential=1 / sp.cosh(K * x))
    run = vo.integrate(made, times=[0, 2], initial={x: -1, v: 1}, method=method)
    assert float(run["xdot"][-1]) == pytest.approx(-1, abs=1e-11)
    assert -1.02 < float(run["x"][-1]) < -0.98


HIDDEN = {
    "bump": sp.exp(-K * (x - 1) ** 2),
    "pulse": sp.exp(-K * (vo.time - 1) ** 2),
    "softplus": -sp.log(1 + sp.exp(K * (x - 1))) / K,
    "log cosh": -sp.log(sp.cosh(K * (x - 1))) / K,
    "rounded corner": (1 - x) / sp.sqrt((x - 1) ** 2 + sp.Rational(1, 10**18)),
}


def end_of_short_steps(rates, start, end, longest=0.02):
    """The first state at the end, by many short steps of a Runge-Kutta method."""
    short = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-15, "max_step": longest}
    return solve_ivp(rates, (0, end), start, **short).y[0, -1]


@cache
def end_of_hidden(force):
    rate = sp.lambdify((vo.time, x, v), force, "mpmath")
    return end_of_short_steps(lambda t, s: [s[1], float(rate(t, *s))], [0, 1], 2, longest=2e-3)


@METHODS
@pytest.mark.parametrize("force", HIDDEN.values(), ids=HIDDEN)
def test_no_step_goes_over_what_its_series_does_not_see(force, method):
    """Against many short steps of a Runge-Kutta method."""
    run = vo.integrate(system(force), times=[0, 2], initial={v: 1}, method=method)
    assert abs(float(run["x"][-1]) - end_of_hidden(force)) < 1e-8


@cache
def end_on_power(degree, spring, start, end):
    def rates(t, s):
        return [s[1], -(s[0] ** (degree + 1)) - spring * s[0]]

    return end_of_short_steps(rates, start, end)


@METHODS
@pytest.mark.parametrize(("degree", "spring"), [(20, 0), (40, 0), (60, 0), (60, 1)])
def test_no_step_goes_over_a_high_power(degree, spring, method):
    """The series of x^n at x = 0 is zero up to the order n; with a spring a motion comes back."""
    end = 20 if spring else 3
    made = system(-(x ** (degree + 1)) - spring * x)
    for start in ((0, 0.9), (-0.6, 0.7), (0.2, -0.8)):
        begin = dict(zip((x, v), start, strict=True))
        run = vo.integrate(made, times=[0, end], initial=begin, method=method)
        truth = end_on_power(degree, spring, start, end)
        assert float(run["x"][-1]) == pytest.approx(truth, abs=2e-10)


@METHODS
@pytest.mark.parametrize("end", [1.2, 1.8])
def test_a_series_that_knows_nothing_of_what_comes_is_not_trusted(end, method):
    """Two powers, neither of them high: nothing but the right side at the end of a step tells."""
    y = sp.Symbol("y")
    made = System(
        name="two powers", fibration=Fibration((x, y)),
        lagrangian=(v**2 + velocity(y) ** 2) / 2, forces={x: -(x**13) * y**12},
    )  # fmt: skip
    starts = [{x: 0, y: 0, v: 1, velocity(y): 1}, {x: 0, y: 0.01, v: 0.9, velocity(y): 1}]

    def rates(t, s):
        return [s[2], s[3], -(s[0] ** 13) * s[1] ** 12, 0]

    truth = [end_of_short_steps(rates, [float(x) for x in s.values()], end) for s in starts]
    runs = [vo.integrate(made, times=[0, end], initial=s, method=method) for s in starts]
    assert [float(run["x"][-1]) for run in runs] == pytest.approx(truth, abs=1e-12)
    if method != "flint":
        many = vo.ensemble(made, starts=starts, times=[0, end], method=method)
        assert many["x"][:, -1] == pytest.approx(truth, abs=1e-12)


def test_constants_that_are_not_small_round_no_corner():
    form = vo.derive(system(-sp.sqrt(1 + v**2) - 1 / sp.sqrt(4 + 3 * x**2))).form
    assert not has_switches(form.force)


EQUAL = [
    1 / (1 + sp.exp(-x)), sp.exp(-x) / (1 + sp.exp(-x)) ** 2, 1 / sp.cosh(x) ** 2,
    sp.cosh(x) / sp.cosh(2 * x), v * x / (v + 3 * sp.exp(2 * x)), sp.exp(2 * x) / (1 + sp.exp(x)),
    sp.sinh(x) / (v + sp.cosh(x)), (1 - sp.exp(-x)) / x, sp.exp(x) * sp.exp(v) / (1 + sp.exp(x)),
    sp.cosh(9 * x) / sp.cosh(10 * x), (v * sp.sinh(x) + 3) / sp.cosh(7 * x),
    (1 - v * sp.exp(4 * x)) / (2 + 2 * sp.exp(9 * x)),
]  # fmt: skip


@pytest.mark.parametrize("expr", EQUAL, ids=str)
def test_what_is_bounded_is_equal(expr):
    bridge = SymPyBridge()
    (found,) = stable_all([bridge.inward(expr)])
    outward = sp.lambdify((x, v), bridge.outward(elementary(found)), "mpmath")
    given = sp.lambdify((x, v), expr, "mpmath")
    with mp.workdps(60):
        for place in (mp.mpf("-1.7"), mp.mpf("0.4")):
            assert abs(outward(place, 3) / given(place, mp.mpf(3)) - 1) < mp.mpf(10) ** -50


def test_the_hyperbolic_tangent_alone_is_no_quotient_of_exponentials():
    """Beside other functions of its argument it still is, so that identities are proved."""
    assert vo.prove_equal(sp.tanh(x) ** 2 + 1 / sp.cosh(x) ** 2, 1).proved
    assert vo.prove_equal(sp.tanh(2 * x) * (1 + sp.tanh(x) ** 2), 2 * sp.tanh(x)).proved
    assert vo.prove_equal(sp.coth(x) * sp.tanh(x), 1).proved
    assert vo.prove_equal(sp.tanh(x), sp.tanh(2 * x)).refuted


def test_mild_functions_are_integrated_as_before():
    """x'' = -tanh x conserves v^2/2 + log cosh x."""
    made = replace(system(-sp.tanh(x)), integrals={"energy": v**2 / 2 + sp.log(sp.cosh(x))})
    run = vo.integrate(made, times=np.linspace(0, 20, 41), initial={x: 3}, method="heyoka")
    assert run.drift["energy"] < 1e-12


eps, k = sp.symbols("epsilon k")
CORNERS = {
    "root": (-sp.sqrt(x**2 + eps**2), {eps: 1e-10}),
    "quotient": (-x / sp.sqrt(x**2 + eps), {eps: 1e-20}),
    "sine": (-sp.sin(x) / sp.sqrt(sp.sin(x) ** 2 + eps), {eps: 1e-16}),
    "cosine": (-sp.sin(x) / sp.sqrt(1 + eps - sp.cos(x)), {eps: 1e-10}),
    "expanded": (-x / sp.sqrt((x + k) ** 2 - 2 * k * (x + k) + k**2 + eps), {eps: 1e-12, k: 0.5}),
    "fourth root": (-x / (x**4 + eps) ** sp.Rational(1, 4), {eps: 1e-32}),
    "cube root": (-x / (x**2 + eps) ** sp.Rational(1, 3), {eps: 1e-20}),
    "moving": (-x / sp.sqrt(x**2 + eps * (2 + sp.cos(x)) ** 2), {eps: 1e-16}),
    "large": (-k * x / sp.sqrt(k**2 * x**2 + 1), {k: 1e8}),
    "beside a sign": (-x / (sp.Abs(x) + eps), {eps: 1e-10}),
    "tanh": (-sp.tanh(k * x), {k: 1e6}),
}
FALL = {x: 1, v: 0.3}


@cache
def corner(name: str, fixed: bool) -> tuple[System, dict]:
    """The system with its small number in it, or with a parameter for it; and the parameters."""
    force, values = CORNERS[name]
    if fixed:
        return system(force.subs({p: sp.Rational(str(a)) for p, a in values.items()})), {}
    return system(force, parameters=tuple(values)), values


@cache
def true_fall(name: str) -> vo.Trajectory:
    """In 22 digits, with the small number in the equations."""
    return vo.integrate(corner(name, True)[0], times=[0, 3, 7], initial=FALL, tol=1e-22)


@METHODS
@pytest.mark.parametrize("fixed", [True, False], ids=["a number", "a parameter"])
@pytest.mark.parametrize("name", CORNERS)
def test_no_step_goes_over_a_corner_that_is_hardly_rounded(name, fixed, method):
    """Against a run in 22 digits; what is small may stand in the equations or be given to them."""
    wanted = true_fall(name)["x"].astype(float)
    made, values = corner(name, fixed)
    run = vo.integrate(made, times=[0, 3, 7], initial=FALL, parameters=values, method=method)
    assert run["x"].astype(float) == pytest.approx(wanted, abs=1e-10)
    if method != "flint":
        many = vo.ensemble(
            made, starts=[FALL] * 2, times=[0, 3, 7], parameters=values, method=method
        )
        assert many["x"][1] == pytest.approx(wanted, abs=1e-10)


@pytest.mark.parametrize("name", CORNERS)
def test_lsoda_is_right_at_a_corner_or_says_that_it_is_lost(name):
    """Where the acceleration is constant it takes steps over several corners at once."""
    made, values = corner(name, False)
    found = None
    with suppress(vo.IntegrationError):
        run = vo.integrate(made, times=[0, 7], initial=FALL, parameters=values, method="lsoda")
        found = run["x"][-1]
    if found is None:
        with pytest.raises(vo.IntegrationError, match="do not follow the equations"):
            vo.integrate(made, times=[0, 7], initial=FALL, parameters=values, method="lsoda")
    else:
        assert found == pytest.approx(float(true_fall(name)["x"][-1]), abs=1e-8)


@cache
def true_section(name: str):
    """Of two crossings."""
    middle = vo.Event(x, "middle", -1)
    made = corner(name, True)[0]
    run = vo.integrate(made, times=[0, 9], initial=FALL, events=(middle,), tol=1e-22)
    return run.events["middle"]


@pytest.mark.parametrize("method", ["scipy", "heyoka"])
@pytest.mark.parametrize("name", ["quotient", "sine", "expanded", "fourth root"])
def test_no_section_goes_over_a_corner(name, method):
    made, values = corner(name, False)
    truth = true_section(name)
    assert len(truth) == 2
    found = vo.section(
        made, x, outputs=(v,), starts=[FALL] * 2, parameters=values, method=method, direction=-1,
        crossings=len(truth),
    )  # fmt: skip
    assert found.t[found.start == 1] == pytest.approx(truth.t.astype(float), abs=1e-9)
    assert found["xdot"][found.start == 1] == pytest.approx(truth["xdot"].astype(float), abs=1e-9)


PUSHES = {
    "turn": sp.tanh(20 * (t - 5)) * sp.exp(-t / 5),
    "rise": sp.exp(-t / 5) / (1 + sp.exp(-20 * (t - 5))),
}
BRAKE = sp.Rational(3, 10)


@cache
def end_of_push(push: str) -> float:
    """Where friction has stopped what was pushed, by quadratures."""
    sign = -1 if push == "turn" else 1
    with mp.workdps(30):
        pushed = sp.lambdify(t, PUSHES[push] - sign * BRAKE, "mpmath")
        begin = 0 if sign < 0 else mp.findroot(pushed, (5, 5.5), solver="anderson")
        places = [begin, 4.9, 5, 5.1, 6, 7, 8]

        def speed(end):
            return mp.quad(pushed, [p for p in places if p < end] + [end])

        end = mp.findroot(speed, (6.1, 12), solver="anderson", tol=1e-40)
        way = mp.quad(lambda s: (end - s) * pushed(s), [p for p in places if p < end] + [end])
    return float(way)


@pytest.mark.parametrize(
    ("push", "method"),
    # the rise takes the compiler a minute: each side of its forty switching surfaces is a program
    # of its own
    [
        (p, m)
        for p in PUSHES
        for m in ("heyoka", "scipy", "c", "lsoda", "flint")
        if p + m != "risec"
    ],
)
def test_a_fast_saturation_that_fades_moves_what_friction_stops(push, method):
    """Over one letter exp(t/5) the push is a quotient of degree 200, and leaves doubles."""
    truth = end_of_push(push)
    made = system(PUSHES[push] - BRAKE * sp.sign(v))
    run = vo.integrate(made, times=[0, 4, 30], initial={v: 0}, method=method, tol=1e-11)
    assert float(run["x"][-1]) == pytest.approx(truth, abs=3e-9 * abs(truth))
    assert run["xdot"][-1] == 0


BELLS = {
    "time": (lambda s, q, w: -q + mp.exp(-1000 * (s - 0.5) ** 2), (0.75, 0.3), 4),
    "place": (lambda s, q, w: -q + mp.exp(-1000 * (q - 0.5) ** 2), (0.75, 0), 4),
    "speed": (lambda s, q, w: -q + mp.exp(-1000 * (w - 0.5) ** 2), (1, 0), 4),
    "running": (lambda s, q, w: q * mp.exp(-1000 * (s - q) ** 2), (1, 0), 3),
    "late": (lambda s, q, w: -q + mp.exp(-((s - 15) ** 2)), (1, 0), 40),
}


@cache
def end_of_bell(name: str) -> float:
    law, start, end = BELLS[name]
    return end_of_short_steps(lambda s, y: [y[1], float(law(s, *y))], start, end)


@pytest.mark.parametrize("method", ["heyoka", "scipy", "c", "lsoda", "flint"])
@pytest.mark.parametrize("name", BELLS)
def test_a_bell_beside_another_force_is_one_exponential(name, method):
    """Taken apart into exponentials of the terms of its exponent it leaves doubles, and a method
    with numbers of a fixed point lost all of the force."""
    _, (place, speed), end = BELLS[name]
    half = sp.Rational(1, 2)
    force = {
        "time": -x + sp.exp(-1000 * (t - half) ** 2), "place": -x + sp.exp(-1000 * (x - half) ** 2),
        "speed": -x + sp.exp(-1000 * (v - half) ** 2), "running": x * sp.exp(-1000 * (t - x) ** 2),
        "late": -x + sp.exp(-((t - 15) ** 2)),
    }[name]  # fmt: skip
    run = vo.integrate(
        system(force), times=[0, end], initial={x: place, v: speed}, method=method, tol=1e-12
    )
    assert float(run["x"][-1]) == pytest.approx(end_of_bell(name), abs=2e-9)


def test_jumps_at_the_edge_of_a_bell_are_found():
    inside = sp.exp(-1000 * (t - 3) ** 2) - sp.Rational(1, 2)
    width = math.sqrt(math.log(2) / 1000)
    for method in ("heyoka", "scipy", "flint"):
        run = vo.integrate(
            system(sp.Heaviside(inside)), times=[0, 10], initial={x: 0, v: 0}, method=method
        )
        assert float(run["x"][-1]) == pytest.approx(14 * width, abs=1e-12)


@pytest.mark.parametrize("method", ["heyoka", "scipy", "c", "lsoda"])
def test_what_lies_beyond_a_switch_does_not_move_what_comes_before(method):
    """A step that goes over a short pulse is cut where the pulse begins; its dense output was made
    of stages within the pulse."""
    run = vo.integrate(
        system(1 / sp.cosh(50 * (t - 30)) ** 2), times=[0, 28, 60], initial={v: 0}, method=method
    )
    assert run["x"] == pytest.approx([0, 0, 1.2], abs=1e-10)

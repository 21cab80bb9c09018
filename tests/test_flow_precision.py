"""The method ``flint``: any number of digits, against exact solutions and another integrator."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import voronec as vo

pytestmark = pytest.mark.slow

x, phi, g, k = sp.symbols("x phi g k")
Dx, Dphi = map(vo.velocity, (x, phi))


@pytest.fixture(autouse=True)
def _many_digits() -> Any:
    with mpmath.workdps(60):
        yield


OSCILLATOR = vo.System(
    name="oscillator",
    fibration=vo.Fibration(base=(x,)),
    lagrangian=Dx**2 / 2 - k * x**2 / 2,
    parameters=(k,),
    integrals={"energy": Dx**2 / 2 + k * x**2 / 2},
)


def test_forty_digits_of_a_cosine() -> None:
    # sqrt(3), 2/3 and the conditions on velocities are used to the last digit
    traj = vo.integrate(
        OSCILLATOR, times=np.linspace(0, 30, 7), initial={x: 1, Dx: sp.sqrt(3)}, tol=1e-42,
        parameters={k: sp.Rational(2, 3)}, outputs=(x, x**2 * Dx),
    )  # fmt: skip
    w = mpmath.sqrt(mpmath.mpf(2) / 3)
    for t, found, product in zip(traj.t, traj["x"], traj[x**2 * Dx], strict=True):
        exact = mpmath.cos(w * t) + mpmath.sqrt(3) / w * mpmath.sin(w * t)
        slope = mpmath.sqrt(3) * mpmath.cos(w * t) - w * mpmath.sin(w * t)
        assert abs(found - exact) < mpmath.mpf(10) ** -40
        assert abs(product - exact**2 * slope) < mpmath.mpf(10) ** -39
    assert traj.cost.method == "flint" and "finer than doubles" in traj.cost.reason
    assert traj.state.dtype == object and traj.drift["energy"] < 1e-40
    assert abs(traj.parameters["k"] - mpmath.mpf(2) / 3) < mpmath.mpf(10) ** -40


def test_doubles_stay_the_doubles_they_are() -> None:
    traj = vo.integrate(OSCILLATOR, times=[0.0, 1.0], initial={x: 0.1}, parameters={k: 0.3},
                        method="flint", tol=1e-30)  # fmt: skip
    assert traj["x"][0] == mpmath.mpf(0.1) and traj.parameters["k"] == mpmath.mpf(0.3)
    exact = mpmath.mpf(0.1) * mpmath.cos(mpmath.sqrt(mpmath.mpf(0.3)))
    assert abs(traj["x"][-1] - exact) < mpmath.mpf(10) ** -29


def test_a_crossing_to_forty_digits() -> None:
    traj = vo.integrate(
        OSCILLATOR, times=[0.0, 9.0], initial={x: 1}, parameters={k: 2}, tol=1e-42,
        events=vo.Event(x, "zero", stop=True), dense=True,
    )  # fmt: skip
    exact = mpmath.pi / 2 / mpmath.sqrt(2)
    assert abs(traj.events["zero"].t[0] - exact) < mpmath.mpf(10) ** -40
    assert traj.t[-1] == traj.events["zero"].t[0]
    half = traj.at([mpmath.mpf(1) / 3])["x"][0]
    assert abs(half - mpmath.cos(mpmath.sqrt(2) / 3)) < mpmath.mpf(10) ** -40


def test_velocities_follow_from_exact_conditions() -> None:
    y, v, w = sp.symbols("y v w")
    Dy = vo.velocity(y)
    sleigh = vo.System(
        name="sleigh",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        frame=vo.Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
        lagrangian=(Dx**2 + Dy**2 + Dphi**2) / 2,
        constraints=(Dy * sp.cos(phi) - Dx * sp.sin(phi),),
    )
    start = {"ydot": 1, "phi": sp.pi / 6, "phidot": sp.Rational(1, 3)}
    traj = vo.integrate(sleigh, times=[0.0, 1.0], initial=start, tol=1e-40)
    assert abs(traj["v"][0] - 2) < mpmath.mpf(10) ** -40
    turned = mpmath.pi / 6 + mpmath.mpf(1) / 3
    way = 6 * (mpmath.sin(turned) - mpmath.sin(mpmath.pi / 6))
    assert abs(traj["x"][-1] - way) < mpmath.mpf(10) ** -38


a, t, p = sp.Symbol("a"), vo.time, sp.Symbol("p")
ELEMENTARY = [
    sp.sin(a) * sp.cos(t) + sp.tan(t / 3),
    sp.sqrt(a + t) * a ** sp.Rational(-1, 3) + (1 + a) ** sp.Rational(-3, 2),
    sp.log(1 + a**2) / (1 + t) - sp.exp(-a),
    sp.atan(a) * sp.asin(a / 9) + sp.acos(t / 5) * sp.tanh(a),
    sp.sinh(a / 3) / sp.cosh(t) + sp.asinh(a) + sp.atanh(t / 7) + sp.acosh(3 + a),
    sp.atan2(a, 1 + t**2) + sp.Abs(a) * sp.Abs(a + 1),
    a ** (t / 2) + sp.cot(a + 1) + sp.sec(a / 4) + sp.acot(a + 2),
    1 / (a * (t + 1) ** 2) + sp.pi * sp.E / 9 - (1 + a) ** 3 / 50 + p / (1 + p * a),
]


def grown(rate: Any, end: float, tol: float, start: Any = "7/10") -> Any:
    """The last value of a where a' = rate: a constraint along x, which moves at unit speed."""
    system = vo.System(
        name="grown", fibration=vo.Fibration(base=(x,), fibre=(a,)), lagrangian=Dx**2 / 2,
        constraints=(vo.velocity(a) - rate * Dx,), parameters=(vo.Parameter(p, sp.Rational(1, 3)),),
    )  # fmt: skip
    begin = {x: 0, Dx: 1, a: sp.Rational(start)}
    run = vo.integrate(
        system, initial=begin, times=[0.0, end], outputs=(a,), method="flint", tol=tol
    )
    return run[a][-1]


@pytest.mark.parametrize("rate", ELEMENTARY, ids=str)
def test_every_function_has_its_recurrence(rate: Any) -> None:
    found = grown(rate, 0.25, 1e-25)
    function = sp.lambdify((a, t, p), rate, "mpmath")
    with mpmath.workdps(18):
        other = mpmath.odefun(
            lambda s, y: [function(y[0], s, mpmath.mpf(1) / 3)], 0, [mpmath.mpf(7) / 10]
        )
        assert abs(found - other(0.25)[0]) < mpmath.mpf(10) ** -15


def test_small_divisors_ask_for_more_bits() -> None:
    # a' = a^(-3) / 4 from 1e-8: a^4 = a0^4 + t, and 1/a^3 eats 80 bits
    found = grown(1 / (4 * a**3), 2.0**-90, 1e-30, sp.Rational(1, 10**8))
    exact = mpmath.root(mpmath.mpf(10) ** -32 + mpmath.mpf(2) ** -90, 4)
    assert abs(found - exact) < mpmath.mpf(10) ** -29


def test_large_factors_ask_for_more_bits() -> None:
    # exp(-500 a) has no digit among those of the tolerance, and cosh(500 a) would make one of it
    found = grown(2 * a * sp.exp(-500 * a) * sp.cosh(500 * a), 0.25, 1e-25)
    with mpmath.workdps(25):
        exact = mpmath.mpf(7) / 10 * mpmath.exp(0.25)  # a' = a, but for exp(-1000 a)
    assert abs(found - exact) < mpmath.mpf(10) ** -24


def test_auto_says_what_it_chose_and_why() -> None:
    pytest.importorskip("heyoka")
    one = {"initial": {x: 1}, "parameters": {k: 1}}
    for end, tol in ((1.0, 1e-13), (1.0, 1e-15)):  # DOP853 has no such tolerance
        cost = vo.integrate(OSCILLATOR, times=[0.0, end], tol=tol, **one).cost
        assert cost.method == "heyoka" and cost.reason.startswith("auto:")


def test_saved_digits_are_all_there(tmp_path: Any) -> None:
    traj = vo.integrate(OSCILLATOR, times=[0.0, 1.0], initial={x: sp.Rational(1, 3)}, tol=1e-40,
                        parameters={k: sp.Rational(1, 7)}, outputs=(x,))  # fmt: skip
    rows = traj.save(tmp_path / "motion.csv").read_text().splitlines()
    assert rows[0] == "t,x"
    assert abs(mpmath.mpf(rows[2].split(",")[1]) - traj["x"][1]) < mpmath.mpf(10) ** -40
    with np.load(traj.save(tmp_path / "motion.npz")) as data:
        assert abs(mpmath.mpf(str(data["state"][1, 0])) - traj["x"][1]) < mpmath.mpf(10) ** -40
        assert abs(mpmath.mpf(str(data["parameter k"])) * 7 - 1) < mpmath.mpf(10) ** -40


@pytest.mark.parametrize("dense", [False, True])
def test_a_step_from_a_special_state_on_the_way_is_not_too_long(dense: bool) -> None:
    """x'' = 1 - x^2 rests at 0, where its series has t^2, t^6, t^10, ... alone, at the end of
    heyoka's third step: its next one would go three times as far as it may."""
    hy = pytest.importorskip("heyoka")
    here, speed = hy.make_vars("x", "v")
    walker = hy.taylor_adaptive([(here, speed), (speed, 1 - here * here)], [0.0, 0.0], tol=1e-13)
    q = sp.Symbol("x")
    system = vo.System(
        name="special",
        fibration=vo.Fibration(base=(q,)),
        lagrangian=vo.velocity(q) ** 2 / 2 + q - q**3 / 3,
    )

    def before(time: float) -> list[float]:
        back = vo.integrate(
            system, initial={"x": 0, "xdot": 0}, times=[0, -time], outputs=(), tol=1e-16
        )
        return [back["x"][-1], back["xdot"][-1]]

    def third(time: float) -> float:
        walker.time, walker.state[:] = -time, before(time)
        for _ in range(3):
            walker.step()
        return float(walker.time)

    first = brentq(third, 0.8, 1.0, xtol=1e-15)
    start = dict(zip(("x", "xdot"), before(first), strict=True))
    run = {"initial": start, "times": [-first, 0.5, 2.5], "outputs": ("x",)}
    seen = vo.Event("x", direction=1)
    motion = vo.integrate(system, method="heyoka", dense=dense, events=(seen,), **run)
    truth = vo.integrate(system, method="flint", tol=1e-25, **run)
    assert motion["x"] == pytest.approx(truth["x"].astype(float), abs=1e-12)
    assert len(motion.events["x"].t) <= 1


def test_one_step_that_is_made_short_does_not_end_a_run() -> None:
    """A disc with hardly any spin turns over at its flattest point within 1e-8: a step to there was
    too long, and the one in its place was measured as if it were two hundred."""
    pytest.importorskip("heyoka")
    disc, start = vo.load("falling-disc"), {"theta": 0.3, "s": 1e-8, "p": 0.5}
    fine, usual = (
        vo.integrate(disc, initial=start, times=[0, 2.8], tol=tol) for tol in (1e-16, 1e-13)
    )
    assert fine.cost.method == "heyoka"
    assert fine["theta"][-1] == pytest.approx(usual["theta"][-1], abs=1e-6)

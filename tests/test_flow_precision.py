"""The method ``flint``: any number of digits, against exact solutions and another integrator."""

from __future__ import annotations

import sys
import traceback
from typing import Any

import mpmath
import numpy as np
import pytest
import symengine as se
import sympy as sp
from scipy.optimize import brentq

import voronec as vo
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.program import Program
from voronec.equations.program.recurrences import recurrences
from voronec.errors import EngineLimit
from voronec.motion import methods
from voronec.motion.steppers import integer_taylor as digits
from voronec.motion.steppers.run import Problem

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


a, t, p, da = se.symbols("a t p da")
ELEMENTARY = [
    se.sin(a) * se.cos(t) + se.tan(t / 3),
    se.sqrt(a + t) * a ** se.Rational(-1, 3) + (1 + a) ** se.Rational(-3, 2),
    se.log(1 + a**2) / (1 + t) - se.exp(-a),
    se.atan(a) * se.asin(a / 9) + se.acos(t / 5) * se.tanh(a),
    se.sinh(a / 3) / se.cosh(t) + se.asinh(a) + se.atanh(t / 7) + se.acosh(3 + a),
    se.atan2(a, 1 + t**2) + se.Abs(a) * se.sign(a + 1),
    a ** (t / 2) + se.cot(a + 1) + se.sec(a / 4) + se.acot(a + 2),
    1 / (a * (t + 1) ** 2) + se.pi * se.E / 9 - (1 + a) ** 3 / 50 + p / (1 + p * a),
]


def _problem(rate: Any, tol: float) -> Problem:
    form = FirstOrderForm((a,), (), (p,), t, (se.sympify(rate),), (), (), (), (da,))
    start = np.array([mpmath.mpf(7) / 10], dtype=object)
    return Problem(Program.of(form, {}), start, [mpmath.mpf(1) / 3], tol)


@pytest.mark.parametrize("rate", ELEMENTARY, ids=str)
def test_every_function_has_its_recurrence(rate: Any) -> None:
    run = digits.digits(_problem(rate, 1e-25))(np.array([0.0, 0.25]))
    names = sp.symbols("a t p")
    function = sp.lambdify(names, sp.sympify(rate), "mpmath")
    with mpmath.workdps(18):
        other = mpmath.odefun(
            lambda s, y: [function(y[0], s, mpmath.mpf(1) / 3)], 0, [mpmath.mpf(7) / 10]
        )
        assert abs(run.states[-1, 0] - other(0.25)[0]) < mpmath.mpf(10) ** -15


def test_a_sum_of_thousands_of_terms_is_no_depth_for_the_compiler() -> None:
    """a' = a + a^2 + ... = a/(1 - a), so that log(a) - a grows as the time."""
    problem = _problem(se.Add(*[a**k for k in range(1, 4001)]), 1e-20)
    run = digits.digits(problem)(np.array([0.0, 0.01]))
    first, last = (mpmath.log(x) - x for x in run.states[:, 0])
    assert abs(last - first - mpmath.mpf(0.01)) < mpmath.mpf(10) ** -19


def test_a_function_without_a_recurrence_is_refused() -> None:
    with pytest.raises(EngineLimit, match="'gamma' has no recurrence here"):
        recurrences(_problem(se.gamma(a), 1e-20).program)


def test_generated_lines_show_in_tracebacks() -> None:
    expand = recurrences(_problem(1 / a, 1e-20).program).expansion([mpmath.mpf(1)], 100)
    try:
        expand([0], 0, 1 << 100, 5)
    except ZeroDivisionError:
        shown = "".join(traceback.format_exception(*sys.exc_info()))
    assert "(ONE << P)//y0[0]" in shown


def test_small_divisors_ask_for_more_bits() -> None:
    # a' = a^(-3) / 4 from 1e-8: a^4 = a0^4 + t, and 1/a^3 eats 80 bits
    problem = _problem(1 / (4 * a**3), 1e-30)
    small = mpmath.mpf(10) ** -8
    start = np.array([small], dtype=object)
    problem = Problem(problem.program, start, problem.parameters, problem.tol)
    run = digits.digits(problem)(np.array([0.0, 2.0**-90]))
    exact = mpmath.root(small**4 + mpmath.mpf(2) ** -90, 4)
    assert abs(run.states[-1, 0] - exact) < mpmath.mpf(10) ** -29


def test_large_factors_ask_for_more_bits() -> None:
    # exp(-500 a) has no digit among those of the tolerance, and cosh(500 a) would make one of it
    run = digits.digits(_problem(2 * a * se.exp(-500 * a) * se.cosh(500 * a), 1e-25))(
        np.array([0.0, 0.25])
    )
    with mpmath.workdps(25):
        exact = mpmath.mpf(7) / 10 * mpmath.exp(0.25)  # a' = a, but for exp(-1000 a)
    assert abs(run.states[-1, 0] - exact) < mpmath.mpf(10) ** -24


def test_auto_says_what_it_chose_and_why(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("heyoka")

    def cost(**more: Any) -> vo.Trajectory:
        return vo.integrate(OSCILLATOR, initial={x: 1}, parameters={k: 1}, **more).cost

    assert cost(times=[0.0, 1.0]).method == "heyoka"
    monkeypatch.setattr(methods, "HEAVY", 0)
    monkeypatch.setattr(methods, "compiled_method", str)  # nothing else compiles
    short, long = cost(times=[0.0, 1.0]), cost(times=[0.0, 1e4])
    assert short.method == "python" and "less time than compiling" in short.reason
    assert long.method == "heyoka" and long.reason.startswith("auto:")
    # DOP853 has no such tolerance
    assert cost(times=[0.0, 1.0], tol=1e-15).method == "heyoka"
    monkeypatch.setattr(methods, "TINY", 1)
    assert cost(times=[0.0, 1.0]).method == "heyoka"


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
    stepper = hy.taylor_adaptive([(here, speed), (speed, 1 - here * here)], [0.0, 0.0], tol=1e-13)
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
        stepper.time, stepper.state[:] = -time, before(time)
        for _ in range(3):
            stepper.step()
        return float(stepper.time)

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

"""Inputs: functions of the time given as numbers, expressions, tables and functions of Python's."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from sympy.physics.mechanics import dynamicsymbols

import voronec as vo
from voronec import DefinitionError, Fibration, Frame, System, Table, time, velocity

pytestmark = pytest.mark.slow

x, tau, m = sp.symbols("x tau m")
q, r, u, v = dynamicsymbols("q r u v")
DX, DQ, DR = velocity(x), q.diff(time), r.diff(time)
SPRING = System(
    name="driven-spring", fibration=Fibration(x), lagrangian=DX**2 / 2 - x**2 / 2,
    forces={x: tau}, inputs=(tau,),
)  # fmt: skip
TIMES = [0, 0.7, 2.3]
METHODS = ["scipy", "heyoka", "flint"]
steppers = pytest.mark.parametrize("method", METHODS)


def moved(value, method="auto", times=TIMES, **options):
    return vo.integrate(
        SPRING, times=times, initial={x: 1}, inputs={tau: value}, method=method, **options
    )


def by_duhamel(force, knots=()):
    """x(t) = cos t + int_0^t sin(t - s) u(s) ds, by Gauss's rule between the knots."""
    nodes, weights = np.polynomial.legendre.leggauss(40)

    def at(t):
        ends = sorted({0.0, t, *(k for k in knots if 0 < k < t)})
        total = math.cos(t)
        for a, b in pairwise(ends):
            s = (a + b) / 2 + (b - a) / 2 * nodes
            values = np.array([force(z) for z in s])
            total += (b - a) / 2 * float(weights @ (np.sin(t - s) * values))
        return total

    return np.array([at(t) for t in TIMES])


JUMPS = lambda t: 1.0 if t < 1 else -1.0 if t < 2 else 3.0  # noqa: E731
LINES = lambda t: float(np.interp(t, [0, 1, 3], [1, -1, 3]))  # noqa: E731
VALUES = {
    "number": (2, lambda t: 2.0, ()),
    "expression": (sp.sin(2 * time), lambda t: math.sin(2 * t), ()),
    "text": ("sin(2*t)", lambda t: math.sin(2 * t), ()),
    "held table": (Table([0, 1, 2], [1, -1, 3], "held"), JUMPS, (1, 2)),
    "table": (([0, 1, 3], [1, -1, 3]), LINES, (1,)),
}


@steppers
@pytest.mark.parametrize("case", VALUES.values(), ids=VALUES)
def test_the_motion_is_that_of_duhamels_integral(case, method):
    value, force, knots = case
    run = moved(value, method, outputs=(x, tau))
    assert np.abs(run["x"].astype(float) - by_duhamel(force, knots)).max() < 2e-12
    assert run["tau"].astype(float) == pytest.approx([force(t) for t in TIMES], abs=1e-15)


def test_a_held_table_is_met_exactly_in_many_digits():
    """cos t for t <= 1, then two arcs about -1 and 3, glued."""
    run = moved(Table([0, 1, 2], [0, -1, 3], "held"), times=[0, 2.5], tol=1e-30)
    c, s = sp.cos(1), sp.sin(1)
    at, speed = c, -s
    for centre, span in ((-1, 1), (3, sp.Rational(1, 2))):
        at, speed = (
            centre + (at - centre) * sp.cos(span) + speed * sp.sin(span),
            -(at - centre) * sp.sin(span) + speed * sp.cos(span),
        )
    assert abs(sp.Float(mpmath.nstr(run["x"][-1], 38), 40) - at.evalf(40)) < 1e-28


def test_a_function_of_pythons_goes_by_scipy():
    run = moved(lambda t: math.sin(2 * t), outputs=(x, tau))
    assert run.cost.method == "scipy" and "function of Python's" in run.cost.reason
    assert np.abs(run["x"] - by_duhamel(lambda t: math.sin(2 * t))).max() < 1e-12
    assert run["tau"] == pytest.approx(np.sin(2 * np.array(TIMES)))
    ahead = vo.integrate(
        SPRING, times=TIMES, initial={x: 1}, inputs={tau: math.sin}, events=(vo.Event(tau - 0.9),)
    )
    assert ahead.events["tau - 0.9"].t == pytest.approx([math.asin(0.9), math.pi - math.asin(0.9)])


def bell(t: float) -> float:
    return math.exp(-(((t - 5.1234) / 0.01) ** 2)) / 0.01


MASS = System(
    name="mass", fibration=Fibration(x), lagrangian=DX**2 / 2, forces={x: tau}, inputs=(tau,)
)
SHORT_PUSHES = {
    "a bell": (bell, math.sqrt(math.pi)),
    "a bell of arrays": (lambda t: 100 * np.exp(-(((t - 5.1234) / 0.01) ** 2)),
                         math.sqrt(math.pi)),
    "a short push": (lambda t: 100.0 if 5 < t < 5.01 else 0.0, 1.0),
    "a beat": (lambda t: math.sin(50 * t) if 3 < t < 3.5 else 0.0,
               (math.cos(150) - math.cos(175)) / 50),
    "one of small size beside a slow one": (lambda t: math.sin(t) + bell(t) / 1000,
                                            1 - math.cos(10) + math.sqrt(math.pi) / 1000),
}  # fmt: skip


@pytest.mark.parametrize(
    ("push", "method"),
    [*((push, "auto") for push in SHORT_PUSHES), ("a bell", "lsoda"), ("a beat", "lsoda")],
)
def test_a_short_push_by_a_function_is_not_stepped_over(push, method):
    function, gained = SHORT_PUSHES[push]
    for times in ([0, 10], np.linspace(0, 10, 101), np.linspace(0, 10, 1001), [10, 0]):
        run = vo.integrate(
            MASS, times=times, initial={x: 0, DX: 0}, inputs={tau: function}, method=method
        )
        sign = 1 if times[-1] > 0 else -1
        assert abs(run["xdot"][-1] - sign * gained) < 1e-10 and run.notes == ()


def test_an_event_of_a_short_push_is_seen():
    seen = vo.integrate(
        MASS, times=[0, 10], initial={x: 0}, inputs={tau: bell}, events=(vo.Event(tau - 50),)
    )
    half = 0.01 * math.sqrt(math.log(2))
    assert seen.events["tau - 50"].t == pytest.approx([5.1234 - half, 5.1234 + half], abs=1e-12)


@pytest.mark.parametrize("method", ["auto", "lsoda"])
@pytest.mark.parametrize(("instant", "size"), [(math.sqrt(2), -1e9), (1.5, 1e6), (5e-324, 1e3)])
def test_a_function_that_jumps_by_far_more_than_the_motion_is_met_at_the_jump(
    method, instant, size
):
    jump = {tau: lambda t: size if t >= instant else 0.0}
    times = [0, 1.5, 3]
    run = vo.integrate(
        SPRING, times=times, initial={x: 1, DX: 0}, inputs=jump, method=method,
        events=(vo.Event(tau - size / 2),), dense=True,
    )  # fmt: skip
    late = np.maximum(np.array(times) - instant, 0)
    truth = np.cos(times) + size * 2 * np.sin(late / 2) ** 2
    assert np.abs(run["x"] - truth).max() < 1e-12 * abs(size)
    assert np.abs(run.at(times)["x"] - truth).max() < 1e-12 * abs(size)
    (crossed,) = run.events.values()
    assert crossed.t == pytest.approx([instant] if instant > 1e-9 else [])


def test_an_input_that_is_sampled_too_coarsely_says_so():
    rough = np.random.default_rng(0).normal(size=1001)
    grid = np.linspace(0, 10, 1001)
    noise = {tau: lambda t: float(np.interp(t, grid, rough))}
    run = vo.integrate(MASS, times=[0, 10], initial={x: 0}, inputs=noise)
    assert any("'tau' changes faster than it is sampled, every 0.00244" in n for n in run.notes)
    assert abs(run["xdot"][-1] - np.trapezoid(rough, dx=0.01)) < 1e-6
    short = vo.integrate(MASS, times=[0, 0.1], initial={x: 0}, inputs=noise)
    assert short.notes == ()


def test_a_function_is_asked_only_where_the_run_comes():
    """Beyond an event that stops the run it may have no value; what it shows there is not told."""
    run = vo.integrate(
        MASS, times=[0, 10], initial={x: 0, DX: 0}, inputs={tau: lambda t: 1 / math.sqrt(4 - t)},
        events=(vo.Event(x - 1, stop=True),),
    )  # fmt: skip
    assert run.stopped and run.t[-1] < 4


RATED = System(
    name="rated", fibration=Fibration(x), lagrangian=DX**2 / 2, forces={x: velocity(tau)},
    inputs=(tau,),
)  # fmt: skip
STEP = sp.Piecewise((0, time < 2), (time, True))


def test_what_the_equations_hold_a_rate_of_may_have_corners_but_no_jumps():
    """The rate of a step is an impact, and nothing beside it."""
    for value in (sp.Abs(time - 2), "abs(t - 2)", sp.Max(2 - time, time - 2)):
        run = vo.integrate(RATED, initial={x: 0}, times=[0, 5], inputs={tau: value})
        assert abs(run["xdot"][-1] - 1) < 1e-12
    turned = vo.integrate(RATED, initial={x: 0}, times=[0, 5], inputs={tau: sp.acos(sp.cos(time))})
    assert abs(turned["xdot"][-1] - (2 * np.pi - 5)) < 1e-12
    angles = sp.atan(1 / (time - 2)), sp.atan2(sp.sin(time), sp.cos(time)), sp.acot(time - 2)
    for value in (STEP, sp.sign(time - 2), sp.floor(time), *angles):
        with pytest.raises(DefinitionError, match="a rate of 'tau', which jumps"):
            vo.integrate(RATED, initial={x: 0}, times=[0, 5], inputs={tau: value})


def test_an_input_in_a_force_may_hold_the_state():
    run = moved("-2*xdot")
    truth = np.exp(-np.array(TIMES)) * (1 + np.array(TIMES))
    assert np.abs(run["x"] - truth).max() < 1e-12


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_the_cosine_of_a_fast_table_is_not_split(method):
    """cos(a + b t + c t^2 + d t^3): its parts run ten times as fast as the whole, and heyoka's
    series of their products had no digits left (1e-4 off)."""
    system = System(
        name="chirp", fibration=Fibration(x), lagrangian=DX**2 / 2 - x**2 / 2,
        forces={x: sp.cos(tau)}, inputs=(tau,),
    )  # fmt: skip
    instants, values = [-1, 0.5294, 0.5343, 0.5663, 1.1127, 2.3], [1, -1.98, -1.24, -0.245, -1.9, 0]
    spline = CubicSpline(instants, values)
    run = vo.integrate(
        system, times=TIMES, initial={x: 1}, inputs={tau: Table(instants, values, "cubic")},
        method=method, outputs=(x,),
    )  # fmt: skip
    knots = (*np.linspace(0, 2.3, 2000), *instants)
    assert np.abs(run["x"] - by_duhamel(lambda t: math.cos(spline(t)), knots)).max() < 1e-12


@steppers
def test_runs_backwards_and_dense_output_know_every_piece(method):
    instants = np.linspace(0, 3, 40)
    table = Table(instants, np.sin(2 * instants), "cubic")
    there = moved(table, method, times=[0, 3], dense=True)
    within = np.array([0.01, 0.4, 1.1, 2.95])
    fine = solve_ivp(
        lambda t, y: [y[1], float(np.sin(2 * t)) - y[0]], (0, 3), [1, 0], "DOP853",
        t_eval=within, rtol=1e-12, atol=1e-12,
    ).y[0]  # fmt: skip
    found = there.at(within)["x"].astype(float)
    assert np.abs(found - fine).max() < 1e-6  # as the spline allows
    end = {x: float(there["x"][-1]), DX: float(there["xdot"][-1])}
    back = vo.integrate(
        SPRING, times=[3, *within[::-1], 0], initial=end, inputs={tau: table}, method=method,
        dense=True,
    )  # fmt: skip
    assert abs(float(back["x"][-1]) - 1) < 1e-11
    assert np.abs(back["x"][1:-1].astype(float)[::-1] - found).max() < 1e-11
    assert np.abs(back.at(within)["x"].astype(float) - found).max() < 1e-11


RHEONOMIC = System(
    name="rheonomic", fibration=Fibration(q, r), constraints=(DR - u * DQ - sp.sin(q),),
    lagrangian=(1 + u * sp.sin(r) ** 2) * DQ**2 / 2 + DR**2 / 2, forces={q: u * q},
)  # fmt: skip
POINT = {q: "0.3", r: "0.4", DQ: "0.5", u: "0.7", "udot": "0.2"}


def test_rates_of_inputs_stand_in_the_equations_and_both_routes_ask_for_them():
    here = vo.derive(RHEONOMIC).acceleration(POINT, 25)
    there = vo.multiplier_acceleration(RHEONOMIC, POINT, 25)
    assert all(abs(here[c] - there[c]) < 1e-22 for c in here)
    law = sp.Rational(7, 10) + (time - 1) / 5
    written = System(
        name="written", fibration=Fibration(q, r),
        constraints=tuple(c.xreplace({u: law}) for c in RHEONOMIC.constraints),
        lagrangian=RHEONOMIC.lagrangian.xreplace({u: law}), forces={q: law * q},
    )  # fmt: skip
    at = {k: value for k, value in POINT.items() if k not in (u, "udot")} | {time: 1}
    assert all(abs(here[c] - a) < 1e-22 for c, a in vo.multiplier_acceleration(written, at).items())
    less = {k: value for k, value in POINT.items() if k != "udot"}
    with pytest.raises(DefinitionError, match="'udot' to the point"):
        vo.derive(RHEONOMIC).acceleration(less)
    with pytest.raises(DefinitionError, match="'udot' to the point"):
        vo.multiplier_acceleration(RHEONOMIC, less)


def test_the_rate_of_an_input_is_exact_given_or_refused():
    start = {q: 0.3, r: 0.4, DQ: 0.5}

    def run(inputs, **options):
        return vo.integrate(
            RHEONOMIC, times=[0, 0.5, 1], initial=start, inputs=inputs,
            outputs=(q, r, "reaction 1"), **options,
        )  # fmt: skip

    exact = run({u: sp.sin(time)})
    called = run({u: math.sin, u.diff(time): math.cos})
    grid = np.linspace(0, 1, 200)
    spline = run({"u": Table(grid, np.sin(grid), "cubic")})
    for name in ("q", "r", "reaction 1"):
        assert np.abs(exact[name] - called[name]).max() < 1e-10
        assert np.abs(exact[name] - spline[name]).max() < 1e-8
    with pytest.raises(DefinitionError, match=r"'udot', a derivative .* function of Python's"):
        run({u: math.sin})
    with pytest.raises(DefinitionError, match=r"'udot', a derivative .* held table"):
        run({u: Table([0], [1], "held")})
    with pytest.raises(DefinitionError, match="function of the time alone"):
        run({u: sp.sin(q)})


BAD = {
    "missing": ({}, {}, r"no value for the input 'tau'; give inputs=\{'tau': ...\}"),
    "unknown": ({"sigma": 1}, {}, r"no input 'sigma'; declare it, System.*inputs=\(sigma,\)"),
    "near": ({"tauu": 1}, {}, "no input 'tauu'.*did you mean 'tau'"),
    "namesake": (
        {"tau": sp.Symbol("x", real=True)},
        {},
        "contains 'x'.*a different symbol of that",
    ),
    "values alone": ({tau: np.array([1, 2])}, {}, r"\(times, values\), or voronec\.Table"),
    "a list": ({tau: [1, 2]}, {}, r"'tau' = \[1, 2\] is no value.*voronec\.Table"),
    "short": ({tau: ([0, 1], [0, 1])}, {}, "from t = 0 to 1, the motion from 0 to 2.3"),
    "heyoka": ({tau: math.sin}, {"method": "heyoka"}, "method='scipy'"),
    "flint": ({tau: math.sin}, {"tol": 1e-30}, "known in doubles"),
    "foreign": ({tau: "y + 1"}, {}, "contains 'y'"),
    "code": ({tau: "__import__('os').getcwd()"}, {}, "tau"),
    "no number": ({tau: lambda t: "a"}, {}, r"'tau' at t = .*ValueError"),
    "not finite": ({tau: lambda t: math.inf}, {}, "not finite"),
}


@pytest.mark.parametrize("case", BAD.values(), ids=BAD)
def test_bad_inputs_are_refused_in_one_line(case):
    inputs, options, message = case
    with pytest.raises(DefinitionError, match=message) as caught:
        vo.integrate(SPRING, times=TIMES, initial={x: 1}, inputs=inputs, **options)
    assert "\n" not in str(caught.value)


TABLES = {
    "kind": (([0, 1], [0, 1], "steps"), "kinds are held, linear, cubic"),
    "shape": (([0, 1], [0]), "2 times and 1 values"),
    "order": (([1, 0], [0, 1]), "must grow"),
    "nan": (([0, 1], [0, math.nan]), "not finite"),
    "few": (([0], [1]), "at least 2 instants"),
}


@pytest.mark.parametrize("case", TABLES.values(), ids=TABLES)
def test_bad_tables_are_refused(case):
    arguments, message = case
    with pytest.raises(DefinitionError, match=message):
        Table(*arguments)


def test_ensembles_and_sections_take_numbers_and_expressions():
    found = vo.ensemble(SPRING, starts={x: [1, 2]}, times=TIMES, inputs={tau: sp.sin(2 * time)})
    assert np.abs(found["x"][0] - by_duhamel(lambda t: math.sin(2 * t))).max() < 1e-11
    points = vo.section(SPRING, "x", starts={x: 2}, value=1, crossings=3, inputs={tau: 1})
    assert points.t == pytest.approx(np.pi * np.array([3, 7, 11]) / 2)  # x = 1 + cos t
    with pytest.raises(DefinitionError, match="give until="):
        vo.section(SPRING, "x", starts={x: 2}, inputs={tau: ([0, 3], [0, 1])})


def test_a_section_takes_tables_and_functions() -> None:
    """With force 1 for ten units and then 2 the swing about 1 becomes one about 2."""
    held = Table([0, 10], [1, 2], "held")
    found = vo.section(
        SPRING, "x", starts={x: [2, 3]}, value=1, until=20, direction=0, inputs={tau: held},
        outputs=(DX,),
    )  # fmt: skip
    for k, size in enumerate((1, 2)):  # x = 1 + size cos t at first
        own = found.start == k
        early = found.t[own][found.t[own] < 10]
        assert early == pytest.approx(np.pi * np.array([1, 3, 5]) / 2, abs=1e-10)
        assert np.abs(found["xdot"][own][:3]) == pytest.approx([size] * 3, abs=1e-10)
        x10, v10 = 1 + size * math.cos(10), -size * math.sin(10)
        wave, phase = math.hypot(x10 - 2, v10), math.atan2(-v10, x10 - 2)
        late = found.t[own][found.t[own] > 10]
        assert 2 + wave * np.cos(late - 10 + phase) == pytest.approx(np.ones(len(late)), abs=1e-9)
        assert len(late) in (3, 4) and wave > 1
        assert found.speed[own] == pytest.approx(found["xdot"][own], abs=1e-6)
    assert found.ends == ("no more crossings up to t = 20",) * 2 and not found.errors
    once = vo.section(
        SPRING, "x", starts={x: 2}, value=1, crossings=1, until=9, inputs={tau: lambda t: 1.0}
    )
    assert once.t == pytest.approx([3 * np.pi / 2], abs=1e-9) and once.ends == ("complete",)
    with pytest.raises(DefinitionError, match="no motion passes through x = 9"):
        vo.section(SPRING, "x", starts={x: 2}, value=9, until=9, inputs={tau: held})


@pytest.mark.parametrize("case", [*VALUES.values(), (math.sin, math.sin, ())])
def test_an_ensemble_takes_every_kind_of_input(case: Any) -> None:
    value, force, knots = case
    found = vo.ensemble(SPRING, {x: [1, 1], DX: [0, 2]}, times=TIMES, inputs={tau: value})
    assert found.finished.all() and found.system is SPRING and not found.parameters
    truth = by_duhamel(force, knots)
    assert np.abs(found["x"][0] - truth).max() < 2e-12
    assert np.abs(found["x"][1] - truth - 2 * np.sin(TIMES)).max() < 2e-12


def test_motions_of_an_ensemble_with_a_function_fail_one_by_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A function that raises after t = 1 ends each motion there; what is no method is refused."""

    def force(t: float) -> float:
        if t > 1:
            raise ValueError("no value")
        return 0.0

    pushed = {"starts": {x: [1, 2]}, "times": TIMES}
    with pytest.raises(DefinitionError, match="ValueError: no value"):
        vo.ensemble(SPRING, inputs={tau: force}, **pushed)
    with pytest.raises(DefinitionError, match=r"the motion from 0 to 2[.]3"):
        vo.ensemble(SPRING, inputs={tau: ([0, 1], [0, 1])}, **pushed)
    with pytest.raises(DefinitionError, match="no method 'flint' for many"):
        vo.ensemble(SPRING, inputs={tau: math.sin}, method="flint", **pushed)
    with pytest.raises(DefinitionError, match="method='scipy'"):
        vo.ensemble(SPRING, inputs={tau: math.sin}, method="heyoka", **pushed)
    monkeypatch.setattr("voronec.motion.steppers.run.LONG", 500)  # steps towards a pole
    pole = vo.ensemble(SPRING, inputs={tau: lambda t: 1 / (t - 2)}, **pushed)
    assert {*pole.errors} == {0, 1} and not pole.finished.any()
    assert np.isfinite(pole["x"][:, :2]).all() and np.isnan(pole["x"][:, 2]).all()


def test_an_integral_that_holds_only_without_the_input_is_not_built_on():
    """The energy less u x is constant while u is; a table's u is not."""
    energy = DX**2 / 2 + x**2 / 2 - tau * x
    system = System(
        name="claims", fibration=Fibration(x), lagrangian=SPRING.lagrangian, forces={x: tau},
        inputs=(tau,), integrals={"energy": energy},
    )  # fmt: skip
    steady = vo.integrate(system, times=TIMES, initial={x: 1}, inputs={tau: 2})
    assert steady.drift["energy"] < 1e-12
    table = vo.integrate(system, times=TIMES, initial={x: 1}, inputs={tau: ([0, 1, 3], [1, -1, 3])})
    assert "energy" not in table.drift
    assert np.abs(table["x"] - by_duhamel(LINES, (1,))).max() < 2e-12


def test_an_input_that_starts_at_zero_is_not_frozen():
    run = moved(([0, 1, 3], [0, 1, 0]), outputs=(x,))
    ramp = lambda t: float(np.interp(t, [0, 1, 3], [0, 1, 0]))  # noqa: E731
    assert np.abs(run["x"] - by_duhamel(ramp, (1,))).max() < 2e-12
    assert run.system is SPRING and "tau" not in run.parameters


def test_generated_programs_take_inputs_as_an_argument(tmp_path):
    eqs = vo.derive(RHEONOMIC)
    space: dict = {}
    exec(eqs.python(), space)
    state = [0.3, 0.4, 0.5]
    truth = [float(a) for a in eqs.acceleration(POINT).values()]
    rates = space["rhs"](0.0, state, [], [0.7, 0.2])
    assert rates[2] == pytest.approx(truth[0], rel=1e-13)
    assert "inputs     = [u, udot]" in eqs.python() and "inputs[1]: udot" in eqs.c()
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    (tmp_path / "rhs.c").write_text(eqs.c(), encoding="utf-8")
    library = tmp_path / "rhs.so"
    command = [compiler, "-shared", "-fPIC", "-o", library, tmp_path / "rhs.c", "-lm"]
    subprocess.run(command, check=True)
    numbers = ctypes.c_double * 3
    result = numbers()
    ctypes.CDLL(str(library)).rhs(
        ctypes.c_double(0.0), numbers(*state), numbers(), numbers(0.7, 0.2, 0), result
    )
    assert result[2] == pytest.approx(truth[0], rel=1e-13)


def test_explain_carries_an_unknown_input_along():
    model = vo.explain(SPRING, outputs=(x,))
    assert {role.variable for role in model.roles} >= {"x", "xdot"}
    parameter = System(
        name="old", fibration=Fibration(q), lagrangian=DQ**2 / 2, forces={q: u}, parameters=(u,)
    )
    assert "u" in vo.derive(parameter).c() and vo.explain(parameter).states


@steppers
def test_a_quasi_velocity_that_is_a_function_of_time_is_integrated(method):
    damped = System(
        name="damped", fibration=Fibration(q), lagrangian=m * DQ**2 / 2, forces={q: -v},
        frame=Frame.quasi({v: DQ}), parameters=(m,), integrals={"drag": m * v + q},
    )  # fmt: skip
    run = vo.integrate(
        damped, times=[0, 1], initial={v: 1}, parameters={m: 1}, method=method,
        outputs=(q, v, v**2), events=(vo.Event(v - sp.Rational(1, 2), name="half"),),
    )  # fmt: skip
    assert abs(float(run["v"][-1]) - math.exp(-1)) < 1e-12
    assert abs(float(run["v(t)**2"][-1]) - math.exp(-2)) < 1e-12
    assert abs(float(run.events["half"].t[0]) - math.log(2)) < 1e-11
    assert run.drift["drag"] < 1e-12
    assert all(claim.verdict.proved for claim in vo.check_claims(damped))
    assert vo.ensemble(damped, {v: [1, 2]}, {m: 1}, [0, 1])["v"][1][-1] == pytest.approx(2 / math.e)


def test_the_command_line_gives_formulas_and_files(tmp_path, capsys, monkeypatch):
    from voronec.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "driven.py").write_text(
        "import sympy as sp\nimport voronec as vo\n"
        "x, u = sp.symbols('x u')\n"
        "SYSTEM = vo.System(name='driven', fibration=vo.Fibration(x), inputs=(u,),\n"
        "    lagrangian=vo.velocity(x)**2/2 - x**2/2, forces={x: u},\n"
        "    scenes={'default': vo.Scene({x: 1}, (0, 2.3))})\n",
        encoding="utf-8",
    )
    (tmp_path / "u.csv").write_text("t,u\n0,1\n1,-1\n3,3\n", encoding="utf-8")
    base = ["run", "driven.py", "--times", "0:2.3:3", "--out", "out", "--input"]
    for value, force, knots in (("u=u.csv", LINES, (1,)), ("u=sin(2*t)", None, ())):
        assert main([*base, value]) == 0
        last = (tmp_path / "out" / "trajectory.csv").read_text().splitlines()[-1].split(",")
        truth = by_duhamel(force or (lambda t: math.sin(2 * t)), knots)[-1]
        assert float(last[1]) == pytest.approx(truth, abs=1e-11)
    capsys.readouterr()
    wrong = ("u", "u=nowhere.csv", "u=u.csv:curved", "w=1", "u=__import__('os')")
    for value in wrong:
        assert main([*base, value]) == 2
        assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert main(["run", "driven.py", "--set", "u=1"]) == 2
    assert "--input u=VALUE" in capsys.readouterr().err
    for option in ("--c", "--python"):
        assert main(["derive", "driven.py", option]) == 0
        assert "inputs" in capsys.readouterr().out
    assert main(["explain", "driven.py"]) == 0


BLOCK = System(
    name="pushed-block", fibration=Fibration(x), lagrangian=DX**2 / 2,
    forces={x: tau - sp.sign(DX)}, inputs=(tau,),
)  # fmt: skip
PUSHES = {
    "table": Table([0, 1], [2, 0], "held"),
    "formula": sp.Piecewise((2, time < 1), (0, True)),
}


@steppers
@pytest.mark.parametrize("push", PUSHES.values(), ids=PUSHES)
def test_a_push_on_a_block_with_dry_friction(method, push):
    """Pushed with 2 against friction 1 for one unit, it slides as long again, 1 in all."""
    run = vo.integrate(
        BLOCK, times=[0, 0.5, 1.5, 4], initial={x: 0, DX: 1e-9}, inputs={tau: push}, method=method
    )
    assert run["x"].astype(float) == pytest.approx([0, 0.125, 0.875, 1], abs=1e-8)
    assert run["xdot"][-1] == 0


def test_a_function_of_pythons_pushes_a_block_with_dry_friction():
    """Pushed with 2 sin t against friction 1 it sticks until sin t = 1/2, slides until its speed is
    spent, and then at once the other way; so do those of an ensemble."""

    def slid(begin: float, way: int) -> tuple[float, float]:
        """The way slid from a start at rest, and when it ends."""

        def speed(t: float) -> float:
            return 2 * (math.cos(begin) - math.cos(t)) - way * (t - begin)

        end = brentq(speed, begin + 0.5, begin + 4)
        gone = 2 * (math.cos(begin) * (end - begin) - math.sin(end) + math.sin(begin))
        return gone - way * (end - begin) ** 2 / 2, end

    there, first = slid(math.pi / 6, 1)
    back, second = slid(first, -1)
    assert math.sin(first) < -0.5 and math.sin(second) > 0.5  # it slides back at once, and then on
    push, times = {tau: lambda t: 2 * math.sin(t)}, [0, 0.4, first, second]
    run = vo.integrate(BLOCK, times=times, initial={x: 0}, inputs=push)
    assert run.cost.method == "scipy" and run["xdot"][1] == 0
    assert run["x"] == pytest.approx([0, 0, there, there + back], abs=1e-11)
    both = vo.ensemble(BLOCK, {x: [0, 1]}, times=times, inputs=push)
    assert both["x"][1] - 1 == pytest.approx(run["x"], abs=1e-11)
    for rounding in range(-20, 21):  # the last instant is that of a switch, but for rounding
        last = second + rounding * math.ulp(second)
        late = vo.integrate(
            BLOCK, times=[*times[:-1], last], initial={x: 1}, inputs=push, dense=True
        )
        assert late["x"][-1] - 1 == pytest.approx(there + back, abs=1e-11)
        assert late.at(last)["x"] == pytest.approx(late["x"][-1], abs=1e-12)


def test_a_belt_whose_speed_is_a_function_of_pythons():
    """Dry friction against a belt of speed cos t takes a block along as long as it can: then its
    speed is that of the belt, which takes the belt's rate to see."""
    belt = System(
        name="belt", fibration=Fibration(x), lagrangian=DX**2 / 2,
        forces={x: -2 * sp.sign(DX - tau)}, inputs=(tau,),
    )  # fmt: skip
    run = {"times": [0, 0.2, 1, 2, 5], "initial": {x: 0, DX: 0}}
    moved = vo.integrate(belt, inputs={tau: math.cos, "taudot": lambda t: -math.sin(t)}, **run)
    caught = brentq(lambda t: 2 * t - math.cos(t), 0, 1)
    begin = caught**2 - math.sin(caught)
    assert moved["x"][1:] == pytest.approx([0.04, *(begin + np.sin([1, 2, 5]))], abs=1e-11)
    assert moved["xdot"][2:] == pytest.approx(np.cos([1, 2, 5]), abs=1e-11)
    with pytest.raises(DefinitionError, match=r"nothing tells how the input 'tau'.*'taudot'"):
        vo.integrate(belt, inputs={tau: math.cos}, **run)


@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
@pytest.mark.parametrize("times", [[0, 2], [0, 1, 1.5, 2], [2, 0]])
def test_an_event_that_jumps_through_zero_with_a_held_input(method: str, times: Any) -> None:
    x, tau = sp.symbols("x tau")
    cart = vo.System(
        name="cart",
        fibration=vo.Fibration(x),
        lagrangian=vo.velocity(x) ** 2 / 2,
        forces={x: tau},
        inputs=(tau,),
    )
    table = vo.Table([0, 0.5, 1.5], [1, -1, 2], "held")
    run = {"inputs": {tau: table}, "initial": {x: 0}, "times": times, "method": method}
    for direction, truth in ((1, [1.5]), (-1, [0.5]), (0, [0.5, 1.5])):
        motion = vo.integrate(cart, events=(vo.Event(tau, direction=direction),), **run)
        assert sorted(map(float, motion.events["tau"].t)) == truth
    ended = vo.integrate(cart, events=(vo.Event(tau, direction=1, stop=True),), **run)
    assert ended.stopped == "tau" and float(ended.t[-1]) == 1.5


def glued_arcs(controller, period, end):
    """The oscillator under a held input: x - u and its rate turn about u from sample to sample."""
    at, speed, t = 1.0, 0.0, 0.0
    for k in range(math.ceil(end / period)):
        force = controller(k * period, {"x": at, "xdot": speed})
        span = min((k + 1) * period, end) - t
        away, c, s = at - force, math.cos(span), math.sin(span)
        at, speed, t = force + away * c + speed * s, speed * c - away * s, t + span
    return at


def damped(t, state):
    return max(-0.6, min(0.6, -2 * state["xdot"] - state["x"]))


@pytest.mark.parametrize("method", ["heyoka", "c", "scipy", "lsoda", "flint"])
def test_a_sampled_controller_is_asked_at_its_instants_and_held_between(method):
    seen = []

    def controller(t, state):
        seen.append(t)
        return damped(t, state)

    run = moved(vo.Sampled(controller, 0.1), method, [0, 0.25, 2.0], outputs=(x, tau))
    assert seen == [k * 0.1 for k in range(20)]
    loose = 1e-7 if method == "lsoda" else 1e-12
    assert float(run["x"][-1]) == pytest.approx(glued_arcs(damped, 0.1, 2.0), abs=loose)
    assert float(run["x"][1]) == pytest.approx(glued_arcs(damped, 0.1, 0.25), abs=loose)
    assert run["tau"][0] == damped(0, {"x": 1, "xdot": 0})


def test_samples_late_in_time_are_rounded_once_and_events_and_dense_output_go_on():
    seen = []
    run = moved(
        vo.Sampled(lambda t, state: seen.append(t) or 0.0, 0.1), times=[7.3, 8.3], dense=True,
        events=(vo.Event(x),),
    )  # fmt: skip
    exact = [sp.Rational(7.3) + k * sp.Rational(0.1) for k in range(10)]
    assert seen == [float(t) for t in exact]
    assert run.at([7.9])["x"] == pytest.approx([math.cos(0.6)], abs=1e-12)
    assert moved(vo.Sampled(damped, 0.5), times=[0, 9], events=(vo.Event(x),)).events["x"].t[0] > 0


@pytest.mark.parametrize("method", ["auto", "lsoda"])
def test_a_continuous_controller_makes_the_motion_of_its_expression(method):
    seen = lambda t, state: -2 * state["xdot"] - state["x"]  # noqa: E731
    run, meant = moved(seen, method, outputs=(x, tau)), moved(-2 * DX - x, outputs=(x, tau))
    assert run.cost.method == ("scipy" if method == "auto" else method)
    loose = 1e-12 if method == "auto" else 1e-8
    assert np.abs(run["x"] - meant["x"]).max() < loose
    assert np.abs(run["tau"] - meant["tau"]).max() < 10 * loose
    saturated = moved(damped, times=[0, 5])["x"][-1]
    assert saturated == pytest.approx(
        moved("Max(-3/5, Min(3/5, -2*xdot - x))", times=[0, 5])["x"][-1]
    )


def test_a_controller_is_told_velocities_that_follow_from_the_constraints():
    y, phi = sp.symbols("y phi")
    knife = System(
        name="knife", fibration=Fibration((x, phi), (y,)),
        lagrangian=(DX**2 + velocity(y) ** 2 + velocity(phi) ** 2) / 2,
        constraints=(velocity(y) * sp.cos(phi) - DX * sp.sin(phi),), forces={phi: tau},
        inputs=(tau,),
    )  # fmt: skip
    told = []
    for kind in (lambda f: f, lambda f: vo.Sampled(f, 0.25)):
        vo.integrate(
            knife, initial={phi: 0.3, DX: 1}, times=[0, 1],
            inputs={tau: kind(lambda t, state: told.append(dict(state)) or -state["phi"])},
        )  # fmt: skip
    assert all(s["ydot"] == pytest.approx(s["xdot"] * math.tan(s["phi"])) for s in told)


def test_ensembles_sweeps_and_prepared_problems_take_controllers(tmp_path):
    grid, value = np.linspace(0, 2, 5), vo.Sampled(damped, 0.1)
    alone = [moved(value, times=grid, outputs=(x,))["x"][-1], glued_arcs(damped, 0.1, 2.0)]
    many = vo.ensemble(SPRING, starts={"x": [1, 2]}, times=grid, inputs={tau: value})
    swept = vo.sweep(
        SPRING, grid={"x": [1, 2]}, times=2, inputs={tau: value}, record=["final(x)"], jobs=1,
        out=tmp_path / "found.zarr",
    )  # fmt: skip
    prepared = vo.prepare(SPRING, inputs={tau: value})
    found = [
        many["x"][0, -1],
        vo.open(swept.path)["final(x)"].values[0],
        prepared.run({x: 1}, times=grid)["x"][-1],
    ]
    assert found == pytest.approx([alone[0]] * 3, abs=1e-13)
    assert alone[0] == pytest.approx(alone[1], abs=1e-12)


def no_plan(t, state):
    if t > 0.5:
        raise ValueError("no plan")
    return 0.0


@pytest.mark.parametrize("period", [None, 0.1])
@pytest.mark.parametrize(
    ("controller", "words", "reached"),
    [
        (no_plan, "raises ValueError: no plan; the run is kept up to t = 0.", 5),
        (lambda t, state: [1, 2], r"returns an array of 2, not one number; .* t = 0 \(x = 1", 1),
        (lambda t, state: math.nan if t > 0.5 else 0, "returns nan, which is not finite; ", 5),
        (lambda t, state: None, "returns None, which is not finite; ", 1),
        (lambda t, state: state["y"], r"t = 0 raises KeyError: 'y'; .*\(x = 1, xdot = 0\)", 1),
    ],
)
def test_a_controller_that_fails_is_told_with_time_and_state_and_the_run_is_kept(
    controller, words, reached, period
):
    value = vo.Sampled(controller, period) if period else controller
    with pytest.raises(vo.IntegrationError, match=words) as raised:
        moved(value, times=np.linspace(0, 1, 11))
    assert "\n" not in str(raised.value) and len(raised.value.trajectory) >= reached
    kept = raised.value.trajectory
    if controller is no_plan:
        assert np.abs(kept["x"] - np.cos(kept.t)).max() < 1e-12
    with pytest.raises(vo.IntegrationError, match=words):  # with events it goes piece by piece
        moved(value, times=np.linspace(0, 1, 11), events=(vo.Event(x - 5),))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: vo.Sampled(damped, 0), "the period 0 is no positive number"),
        (lambda: vo.Sampled(3, 0.1), "the controller 3 is no function"),
        (lambda: moved(damped, "heyoka"), r"give Sampled\(controller, period\)"),
        (lambda: moved(vo.Sampled(damped, 0.1), times=[1, 0]), "let the times grow"),
        (lambda: moved(vo.Sampled(damped, 1e-9)), "would be asked .* times; give a longer period"),
    ],
)
def test_controllers_that_make_no_sense_are_refused_in_a_line(make, words):
    with pytest.raises(DefinitionError, match=words) as raised:
        make()
    assert "\n" not in str(raised.value)


def test_a_controller_that_chatters_is_sent_to_samples():
    with pytest.raises(vo.IntegrationError, match=r"give Sampled\(controller, period\)"):
        moved(lambda t, state: -2 if state["xdot"] > 0 else 2, times=[0, 5])

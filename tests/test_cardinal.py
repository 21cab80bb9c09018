"""Quotients such as sin(w)/w have a value where w vanishes: motions start there and pass it."""

from __future__ import annotations

import shutil

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from test_program import c_function

import voronec as vo
from voronec import Fibration, System, velocity
from voronec.algebra.cardinal import cardinal_all
from voronec.algebra.numeric_functions import elementary, numeric_name
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.equations.program import Program, compile_program

x, y = sp.symbols("x y")
v = velocity(x)
METHODS = pytest.mark.parametrize(
    "method", ["scipy", pytest.param("heyoka", marks=pytest.mark.slow), "flint"]
)


def system(force=0) -> System:
    return System(
        name="entire", fibration=Fibration(x), lagrangian=v**2 / 2, forces={x: force}
    )  # fmt: skip


FORCES = {
    "sin": (sp.sin(x) / x, mp.si),
    "sinc": (sp.sinc(x), mp.si),
    "cos": ((1 - sp.cos(x)) / x**2, lambda s: mp.si(s) - (1 - mp.cos(s)) / s),
    "slope": (sp.cos(x) / x - sp.sin(x) / x**2, lambda s: mp.sinc(s) - 1),
    "beside others": (sp.sin(x) / x - x, lambda s: mp.si(s) - s**2 / 2),
}  # fmt: skip


def time_to(end, start, speed, integral):
    """v^2 = v_0^2 + 2 (F(x) - F(x_0)), and the time is the integral of dx/v."""
    before = integral(start) if start else mp.mpf(0)

    def slowness(s):
        return 1 / mp.sqrt(speed**2 + 2 * ((integral(s) if s else 0) - before))

    return mp.quad(slowness, sorted({mp.mpf(start), mp.mpf(0), mp.mpf(end)}))


@pytest.mark.slow
@METHODS
@pytest.mark.parametrize("start", [0, -1.5])
@pytest.mark.parametrize("kind", FORCES)
def test_motions_start_where_the_quotient_has_no_value_and_pass_there(kind, start, method):
    force, integral = FORCES[kind]
    speed = 1 if start == 0 else 2
    run = vo.integrate(system(force), times=[0, 1.5], initial={x: start, v: speed}, method=method)
    with mp.workdps(25):
        passed = time_to(mp.mpf(float(run["x"][-1])), mp.mpf(start), speed, integral)
    assert float(passed) == pytest.approx(1.5, abs=1e-12)


def test_many_digits_through_the_place():
    run = vo.integrate(
        system(sp.sin(x) / x), times=[0, 1.5], initial={x: -1.5, v: 2}, tol=1e-30
    )  # fmt: skip
    with mp.workdps(40):
        passed = time_to(mp.mpf(run["x"][-1]), mp.mpf(-1.5), 2, mp.si)
        assert abs(passed - 1.5) < 1e-28


@METHODS
def test_a_force_of_the_velocity_reverses_it(method):
    run = vo.integrate(system(-sp.sin(v) / v), times=[0, 2], initial={v: 0.5}, method=method)
    with mp.workdps(25):
        slow = mp.quad(lambda s: 1 / mp.sinc(s), [float(run["xdot"][-1]), 0, 0.5])
    assert float(slow) == pytest.approx(2, abs=1e-12)


@pytest.mark.parametrize("kind", FORCES)
def test_what_is_written_and_the_referee_have_the_same_values(kind, tmp_path):
    force = FORCES[kind][0]
    made, namespace = vo.derive(system(force)), {}
    exec(made.python(), namespace)
    functions = [namespace["rhs"], compile_program(Program.of(made.form), True)[0]]
    functions += [c_function(made.c(), tmp_path, 2)] if shutil.which("cc") else []
    for place in (0, 1e-9, -0.3, 2):
        with mp.workdps(80):
            near = mp.mpf(place) if place else mp.mpf("1e-25")
            truth = float(sp.lambdify(x, force, "mpmath")(near))
        value = pytest.approx(truth, rel=1e-15, abs=1e-24)
        assert [f(0.0, [float(place), 1.0], [])[1] for f in functions] == [value] * len(functions)
        rows = namespace["rhs"](0.0, [np.array([place, 1.0]), np.ones(2)], [])
        assert rows[1][0] == value
        point = {x: place, v: 1}
        theirs = vo.multiplier_acceleration(system(force), point, 20)
        for found in (made.acceleration(point), theirs):
            assert float(next(iter(found.values()))) == value


EQUAL = {
    sp.sin(v) / v + x: 1, (1 - sp.cos(x)) / x**2 + 3: 1, sp.tan(x) / x: 1,
    sp.sin(x - y) / (x - y): 1, sp.sin(x * y) / x: 1, sp.sin(x) ** 2 / x**3: 1,
    sp.sin(sp.sqrt(x**2 + y**2)) / sp.sqrt(x**2 + y**2): 1, sp.sinh(x) / x: 0,
    (1 - sp.cos(sp.sqrt(x**2 + y**2))) / (x**2 + y**2): 1, x / sp.sin(x): 0,
    sp.sin(sp.sin(x) / x) / x: 1, sp.sin(x) / y: 0, x * sp.sin(x): 0, (x + sp.cos(x)) / x: 0,
}  # fmt: skip


@pytest.mark.parametrize("expr", EQUAL, ids=str)
def test_quotients_are_recognised_and_equal(expr):
    import symengine as se

    bridge = SymPyBridge()
    found = cardinal_all([bridge.inward(expr)])[0]
    assert any(map(numeric_name, found.atoms(se.FunctionSymbol))) == bool(EQUAL[expr])
    assert vo.prove_equal(bridge.outward(elementary(found)), expr).proved


@pytest.mark.parametrize("potential", [sp.sin(x) / x, sp.sinc(2 * x)])
def test_slopes_of_quotients_have_values_where_these_have(potential):
    """Their forces were nan at zero."""
    lagrangian = v**2 / 2 - potential
    energy = {"energy": v**2 / 2 + potential}
    well = System("well", Fibration(x), lagrangian, integrals=energy)
    run = vo.integrate(well, times=[0.0, 0.1], initial={x: 0}, method="scipy")
    assert abs(run["x"][-1]) < 1e-4 and run.drift["energy"] < 1e-12
    rates, _ = compile_program(Program.of(vo.derive(well).form))
    force = sp.lambdify(x, -potential.diff(x), "mpmath")
    for place in (-0.25, -1e-3, 1e-9, 0.1):
        with mp.workdps(60):
            wanted = float(force(mp.mpf(place)))
        assert abs(rates(0.0, [place, 0.0], [])[1] - wanted) < 1e-14


@pytest.mark.parametrize(
    "potential",
    [sp.tan(x) / x, (1 - sp.cos(x)) / x**2, sp.sinh(x) / x, sp.log(1 + x) / x],
)
def test_slopes_of_other_quotients_are_refused_where_these_divide_by_zero(potential):
    well = System("well", Fibration(x), v**2 / 2 - potential)
    with pytest.raises(vo.VoronecError, match="x = 0"):
        vo.integrate(well, times=[0.0, 0.1], initial={x: 0})

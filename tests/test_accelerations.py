"""Accelerations in forces are inertia; derivatives with no meaning are refused, never dropped."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from sympy.physics.mechanics import LagrangesMethod, Point, ReferenceFrame, dynamicsymbols

import voronec as vo
from voronec import DefinitionError, Equation, Fibration, Frame, System, time, velocity
from voronec.algebra.sympy_bridge import SymPyBridge

pytestmark = pytest.mark.slow

q, r, v = dynamicsymbols("q r v")
x, y, z, w, a, b, m = sp.symbols("x y z w a b m")
DQ, DR = q.diff(time), r.diff(time)
SPRING = DQ**2 / 2 - q**2 / 2
PLANE = (velocity(x) ** 2 + velocity(y) ** 2) / 2


def spring(**options) -> System:
    return System(**{"name": "spring", "fibration": Fibration(q), "lagrangian": SPRING} | options)


def plane(**options) -> System:
    given = {"name": "plane", "fibration": Fibration((x, y)), "lagrangian": PLANE} | options
    return System(**given)


ADDED = spring(forces={q: -q.diff(time, 2) / 2})


def agree(system: System, point: dict) -> dict:
    here = vo.derive(system).acceleration(point, 25)
    there = vo.multiplier_acceleration(system, point, 25)
    for coordinate, value in there.items():
        assert abs(here[coordinate] - value) < 1e-22
    return here


def test_an_added_mass_is_a_mass():
    eqs = vo.derive(ADDED)
    assert eqs.mass == sp.ImmutableMatrix([[sp.Rational(3, 2)]])
    assert eqs.force == sp.ImmutableMatrix([[-q]])
    assert abs(agree(ADDED, {q: 1, DQ: 0})[q] + sp.Rational(2, 3)) < 1e-24
    left, right = (sp.sympify(side[0]) for side in (eqs.left, eqs.right))
    assert sp.expand(left - right - (sp.Rational(3, 2) * q.diff(time, 2) + q)) == 0


@pytest.mark.parametrize("method", ["scipy", "heyoka", "flint"])
def test_the_motion_with_an_added_mass_has_its_frequency(method):
    times = np.linspace(0, 3, 7)
    run = vo.integrate(ADDED, times=times, initial={q: 1}, method=method)
    truth = np.cos(np.sqrt(2 / 3) * times)
    assert np.abs(run["q"].astype(float) - truth).max() < 1e-11


def test_the_energy_holds_the_added_mass_and_an_acceleration_is_no_integral():
    right, wrong = 3 * DQ**2 / 4 + q**2 / 2, DQ**2 / 2 + q**2 / 2
    claims = spring(forces=ADDED.forces, integrals={"right": right, "wrong": wrong})
    found = {claim.name: claim.verdict for claim in vo.check_claims(claims)}
    assert found["right"].proved and found["wrong"].refuted
    with pytest.raises(DefinitionError, match=r"integral 'a' contains .*accelerations"):
        spring(integrals={"a": q.diff(time, 2)})


def test_coupled_added_masses_agree_with_sympys_lagranges_method():
    """Forces -N qddot are what a kinetic energy qdot N qdot / 2 with constant N gives."""
    lagrangian = m * DQ**2 / 2 + (2 + sp.sin(q)) * DR**2 / 2 - q * r**2
    forces = {q: -a * q.diff(time, 2) - b * r.diff(time, 2) + sp.sin(time),
              r: -b * q.diff(time, 2) - 2 * r.diff(time, 2) - DR}  # fmt: skip
    system = System(
        name="coupled", fibration=Fibration((q, r)), lagrangian=lagrangian, forces=forces,
        parameters=(m, a, b),
    )  # fmt: skip
    whole = lagrangian + a * DQ**2 / 2 + b * DQ * DR + DR**2
    frame = ReferenceFrame("N")
    points = [Point("P"), Point("R")]
    points[0].set_vel(frame, DQ * frame.x)
    points[1].set_vel(frame, DR * frame.x)
    loads = [(points[0], sp.sin(time) * frame.x), (points[1], -DR * frame.x)]
    method = LagrangesMethod(whole, [q, r], forcelist=loads, frame=frame)
    method.form_lagranges_equations()
    at = {q: 0.3, r: -0.7, DQ: 0.4, DR: 0.9, m: 2, a: 0.5, b: 0.25, time: 1}
    numbers = {k: sp.nsimplify(value) for k, value in at.items()}
    rates = {s: value for s, value in numbers.items() if s.is_Derivative}

    def number(matrix):
        return matrix.xreplace(rates).xreplace(numbers).evalf(30)

    truth = number(method.mass_matrix).LUsolve(number(method.forcing))
    here = agree(system, {k: str(value) for k, value in at.items()})
    assert max(abs(here[c] - t) for c, t in zip((q, r), truth, strict=True)) < 1e-22


def test_rates_of_quasi_velocities_and_constraints_go_by_the_chain_rule():
    dot = velocity
    framed = plane(
        name="framed",
        frame=Frame.quasi({w: dot(x) * (2 + sp.sin(x)), v: dot(y)}),
        forces={x: -dot(w) * (2 + sp.sin(x)) / 3, y: -v.diff(time) + x},
    )
    here = agree(framed, {"x": "0.3", "y": "0.7", "w": "0.4", "v": "-0.2"})
    g, slope = 2 + sp.sin(sp.Rational(3, 10)), sp.cos(sp.Rational(3, 10))
    rate = sp.Rational(2, 5) / g  # xdot; xddot + g (g xddot + g' xdot^2)/3 = 0
    assert abs(here[x] + (g * slope * rate**2 / 3 / (1 + g**2 / 3)).evalf(30)) < 1e-22
    assert abs(here[y] - sp.Rational(3, 20)) < 1e-22
    rolling = System(
        name="rolling", fibration=Fibration((x, y), (z,)), constraints=(dot(z) - x * dot(y),),
        lagrangian=PLANE + dot(z) ** 2 / 2 - z, forces={x: -dot(dot(x)) / 3, z: -dot(dot(z)) / 5},
    )  # fmt: skip
    point = {"x": "0.3", "y": "0.7", "z": 0, dot(x): "0.4", dot(y): "-0.2"}
    agree(rolling, point)
    force = vo.reaction_forces(rolling, point).multipliers[0]
    start = {k: float(value) for k, value in point.items()}
    seen = vo.integrate(rolling, times=[0, 1], initial=start, outputs=("reaction 1",))
    assert abs(seen["reaction 1"][0] - float(force)) < 1e-12


LOST = {
    "a Lagrangian": (lambda: spring(lagrangian=SPRING + q * q.diff(time, 2)), "the Lagrangian con"),
    "a constraint": (
        lambda: System(
            name="two", fibration=Fibration(q, r), lagrangian=DQ**2 + DR**2,
            constraints=(r.diff(time, 2) - DQ,),
        ), "constraint 1 contains",
    ),
    "an equation": (
        lambda: spring(equations={"e": Equation(DQ, q.diff(time, 2))}), "equation 'e' contains",
    ),
    "third order": (lambda: spring(forces={q: q.diff(time, 3)}), "higher derivative"),
    "a plain symbol": (
        lambda: plane(forces={x: sp.Derivative(x, time)}), r"write voronec.velocity\(x\)",
    ),
    "a velocity by a coordinate": (
        lambda: vo.derive(spring(forces={q: sp.Derivative(DQ, q)})), "stands for nothing here",
    ),
    "an expression by the time": (
        lambda: spring(forces={q: sp.Derivative(sp.sin(q), time)}), "neither coordinate",
    ),
    "not linear": (
        lambda: vo.derive(spring(forces={q: q.diff(time, 2) ** 2})), "not linear in the accel",
    ),
    "not symmetric": (
        lambda: vo.derive(plane(forces={x: -velocity(velocity(y))})), "is not symmetric",
    ),
    "an integral": (
        lambda: vo.derive(plane(parameters=(m,), forces={x: sp.Integral(sp.sin(m), (m, 0, x))})),
        "of kind Integral",
    ),
    "torn": (
        lambda: SymPyBridge([q, DQ]).inward(sp.Subs(q * DQ, q, x)),
        "replaces a function under its deriv",
    ),
    "an output": (
        lambda: vo.integrate(spring(), times=[0, 1], initial={q: 1}, outputs=(q.diff(time, 2),)),
        "'qdotdot'|stands for nothing",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", LOST.values(), ids=LOST)
def test_what_has_no_meaning_is_refused_in_one_line(case):
    make, message = case
    with pytest.raises(DefinitionError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_partial_derivatives_that_sympy_can_take_are_taken():
    energy = sp.Derivative(x**2 * y, x)
    system = plane(forces={x: -energy})
    assert vo.derive(system).force[0] == -2 * x * y
    agree(system, {"x": "0.3", "y": "0.7", velocity(x): 0, velocity(y): 0})


@pytest.mark.parametrize("number", [sp.Float("1e-400"), sp.Float("1e400"), sp.Float("2.5")])
def test_decimals_beyond_doubles_are_what_they_are(number):
    assert SymPyBridge().outward(SymPyBridge().inward(number)) == sp.Rational(str(number))


def test_an_error_of_the_door_is_seen_by_the_referee(monkeypatch):
    """The two routes read expressions each in its own way."""
    system = spring(lagrangian=DQ**2 / 2 - sp.sin(q))
    inward = SymPyBridge.inward

    def wrong(self, expr):
        return inward(self, sp.sympify(expr).replace(sp.sin, lambda a: sp.sin(a) / 2))

    monkeypatch.setattr(SymPyBridge, "inward", wrong)
    point = {q: "0.3", DQ: 0}
    here, there = vo.derive(system).acceleration(point), vo.multiplier_acceleration(system, point)
    assert abs(there[q] + sp.cos(sp.Rational(3, 10)).evalf(30)) < 1e-25
    assert abs(here[q] - there[q]) > 0.1


@pytest.mark.parametrize(
    "bend", [sp.sign, sp.floor, sp.Abs, sp.sin, lambda e: sp.Max(e, 0), lambda e: sp.sqrt(1 + e)]
)
def test_what_bends_an_acceleration_is_not_linear_in_it(bend):
    with pytest.raises(DefinitionError, match="not linear in the accelerations"):
        vo.derive(spring(forces={q: -bend(q.diff(time, 2))}))


def test_accelerations_of_plain_symbols_are_called_so() -> None:
    """As those of functions of time are; other unknown symbols are still to be declared."""
    second, third = velocity(velocity(x)), velocity(velocity(velocity(x)))
    for place in (
        {"integrals": {"e": second}}, {"lagrangian": PLANE + x * second},
        {"constraints": (second - y,)}, {"forces": {x: third}},
    ):  # fmt: skip
        with pytest.raises(DefinitionError, match=r"'xdotdot(dot)?', which is no velocity"):
            plane(**place)
    with pytest.raises(DefinitionError, match=r"'mdot', .*declare it in parameters"):
        plane(parameters=(m,), integrals={"e": velocity(m)})


def test_forces_on_a_group_hold_rates_of_its_velocities() -> None:
    """A body about a point in a fluid, whose added inertia is not diagonal, on an edge."""
    w1, w2, w3 = w = sp.symbols("w1:4")
    turning = {(w1, w2): {w3: 1}, (w2, w3): {w1: 1}, (w3, w1): {w2: 1}}
    pull = {w1: -velocity(w1) / 2 - velocity(w2) / 5, w2: -velocity(w1) / 5 - w1 * w3}
    system = System(
        "body in a fluid", Fibration(()), (w1**2 + 2 * w2**2 + 3 * w3**2) / 2, (w3 - w1 / 3,),
        frame=Frame.group((w1, w2), turning, fibre=(w3,)), forces=pull,
    )  # fmt: skip
    eqs = vo.derive(system)
    assert eqs.mass[0, 0] == 1 + sp.Rational(1, 2) + sp.Rational(1, 3)
    assert eqs.mass[0, 1] == sp.Rational(1, 5)
    found = agree(system, {w1: sp.Rational(1, 2), w2: sp.Rational(-1, 3)})
    assert {*found} == {*w}


def test_forces_that_take_all_inertia_away_are_named() -> None:
    with pytest.raises(DefinitionError, match="accelerations in the forces take away") as caught:
        vo.derive(plane(forces={x: velocity(velocity(x))}))
    assert "gives 'xdot' no inertia; change these forces" in str(caught.value)
    with pytest.raises(DefinitionError, match="the Lagrangian gives 'xdot' no inertia; add its"):
        vo.derive(plane(lagrangian=velocity(y) ** 2 / 2))

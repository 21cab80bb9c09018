"""Descent: equations closed in invariants, as the classics write them."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp
from balls import R, gamma, inertia, m, omega, rolling_ball, x, y
from sympy.physics.mechanics import dynamicsymbols

import voronec as vo
from voronec import (
    DefinitionError,
    EngineLimit,
    Fibration,
    Frame,
    System,
    descend,
    kinematics,
    prove_equal,
    velocity,
)

phi, theta, psi, u, v, g, length = sp.symbols("phi theta psi u v g l")
q = sp.symbols("q0:4")
TURN, VERTICAL = sp.Matrix(omega), sp.Matrix(gamma)
SPHERE = VERTICAL.dot(VERTICAL) - 1

CHARTS = {
    "euler zxz": kinematics.Rotation.euler("zxz", phi, theta, psi),
    "euler zyx": kinematics.Rotation.euler("zyx", phi, theta, psi),
    "quaternion": kinematics.Rotation.quaternion(*q),
    "dynamicsymbols": kinematics.Rotation.euler("zxz", *dynamicsymbols("phi theta psi")),
}


def heavy_top(rotation, moments=(inertia[0], inertia[0], inertia[2]), invariants=None):
    vertical = rotation.matrix.row(2)
    named = dict(zip(map(str, gamma), vertical, strict=True))
    return System(
        name="top",
        fibration=Fibration(rotation.coordinates, relations=rotation.relations),
        frame=Frame.quasi(dict(zip(omega, rotation.body_rates, strict=True))),
        lagrangian=kinematics.kinetic_energy(0, (0, 0, 0), moments, rotation.body_rates)
        - m * g * length * vertical[2],
        parameters=(m, g, length, *inertia),
        invariants=named if invariants is None else invariants,
    )


def all_equal(found, expected, relations=()):
    pairs = zip(sp.Matrix(found), sp.Matrix(expected), strict=True)
    return all(prove_equal(a, b, relations).proved for a, b in pairs)


def check_descent(system):
    """With the invariants written out, the closed equations are the equations."""
    eqs, found = vo.derive(system), descend(system)
    ideal = system.fibration.relations
    out = dict(zip(found.invariants, found.definitions, strict=True))
    coordinates = set(system.coordinates)
    for matrix in (found.mass, found.force, found.rates, sp.Matrix(found.relations)):
        assert not matrix.atoms(*map(type, coordinates)) & coordinates
    assert all_equal(found.mass.xreplace(out), eqs.mass, ideal)
    assert all_equal(found.force.xreplace(out), eqs.force, ideal)
    for definition, rate in zip(found.definitions, found.rates, strict=True):
        along = sum(
            definition.diff(c) * e for c, e in zip(system.coordinates, eqs.rates, strict=True)
        )
        assert prove_equal(rate.xreplace(out), along, ideal).proved
    for relation in found.relations:
        assert prove_equal(relation.xreplace(out), 0, ideal).proved
    return found


@pytest.mark.parametrize("chart", CHARTS.values(), ids=CHARTS)
def test_chaplygins_ball_obeys_chaplygins_equations(chart):
    """Gdot = G x omega, gammadot = gamma x omega [Chaplygin1903], whatever the chart."""
    found = descend(rolling_ball(chart))
    rolling = m * R**2
    momentum = sp.diag(*inertia) * TURN + rolling * (TURN - VERTICAL * VERTICAL.dot(TURN))
    assert found.invariants == gamma and found.velocities == omega
    assert len(found.relations) == 1 and prove_equal(found.relations[0] ** 2, SPHERE**2).proved
    assert all_equal(found.momenta, momentum, found.relations)
    assert all_equal(found.momentum_rates, momentum.cross(TURN), found.relations)
    assert all_equal(found.rates, VERTICAL.cross(TURN), found.relations)


@pytest.mark.parametrize("chart", CHARTS.values(), ids=CHARTS)
def test_a_heavy_top_obeys_euler_and_poisson(chart):
    """Mdot = M x omega + m g l gamma x e_3, gammadot = gamma x omega."""
    found = descend(heavy_top(chart, moments=inertia))
    momentum = sp.diag(*inertia) * TURN
    weight = m * g * length * VERTICAL.cross(sp.Matrix([0, 0, 1]))
    assert all_equal(found.momenta, momentum)
    assert all_equal(found.momentum_rates, momentum.cross(TURN) + weight, found.relations)
    assert all_equal(found.rates, VERTICAL.cross(TURN), found.relations)


def test_lagranges_top_keeps_its_spin():
    found = descend(heavy_top(CHARTS["euler zxz"]))
    assert found.force[2] == 0
    assert not found.force[0].has(inertia[1]) and found.mass == sp.diag(
        inertia[0], inertia[0], inertia[2]
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "chaplygin-ball",
        "falling-disc",
        "gyroscopic-ball-on-sphere",
        "displaced-ball-on-sphere",
        "gyroscopic-rubber-ball-on-sphere",
        "gyroscopic-spheroid-on-plane",
        "suslov",
        "veselova",
    ],
)
def test_a_declared_descent_is_one(name):
    """One of each family: that the claims of all hold after it is in ``test_conformance``."""
    check_descent(vo.load(name))


@pytest.mark.parametrize("chart", ["euler zyx", "quaternion"])
def test_the_closed_equations_are_the_equations(chart):
    check_descent(rolling_ball(CHARTS[chart]))
    check_descent(heavy_top(CHARTS[chart]))


def test_demchenkos_ball_descends_to_the_height_of_its_contact():
    """With x = cos u, y = sin u: xdot, ydot turn by one rate, and the third row is -k tau y."""
    found = descend(vo.load("demchenko"))
    height, side = found.invariants
    s, tau, n = found.velocities
    R1, R2, M, A, k = (p.symbol for p in found.system.parameters)
    P = M * R2**2 + A
    assert all_equal(found.mass, sp.diag(P, P, A))
    assert found.relations == (height**2 + side**2 - 1,)
    turn = R1 * tau / (R1 + R2)
    assert all_equal(found.rates, [turn * side, -turn * height])
    assert prove_equal(found.force[2], -k * tau * side).proved
    energy = s * found.force[0] + tau * found.force[1] + n * found.force[2]
    assert prove_equal(energy, 0).proved


def test_invariants_may_be_given_and_combined():
    """(cos theta, cos theta + 1) are dependent: a relation is found, and it is linear."""
    chart = CHARTS["euler zxz"]
    named = dict(zip(("a", "b", "c"), chart.matrix.row(2), strict=True))
    found = descend(rolling_ball(chart, {}), named | {"d": named["c"] + 1, "e": named["a"] ** 2})
    a, b, c, d, e = found.invariants
    for relation in (d - c - 1, e - a**2, a**2 + b**2 + c**2 - 1):
        assert prove_equal(relation, 0, found.relations).proved
    assert prove_equal(found.rates[4], 2 * a * found.rates[0], found.relations).proved


def test_a_system_with_roots_and_exponentials_descends():
    """A particle on a line of varying mass, in the invariant h = sqrt(1 + exp(x))."""
    h = sp.sqrt(1 + sp.exp(x))
    system = System(
        name="line",
        fibration=Fibration((x,)),
        lagrangian=h * velocity(x) ** 2 / 2 - sp.exp(2 * x),
        invariants={"h": h},
    )
    found = check_descent(system)
    tag = found.invariants[0]
    assert prove_equal(found.rates[0], (tag**2 - 1) / (2 * tag) * velocity(x)).proved


def test_the_coordinates_themselves_are_invariants():
    system = System(
        name="plane",
        fibration=Fibration((x, y)),
        lagrangian=(velocity(x) ** 2 + (1 + x**2) * velocity(y) ** 2) / 2 - x * y**3,
    )
    found = descend(system, {"X": x, "Y": y})
    assert found.relations == ()
    assert all_equal(found.rates, [velocity(x), velocity(y)])
    back = dict(zip(found.invariants, (x, y), strict=True))
    assert all_equal(found.force.xreplace(back), vo.derive(system).force)


REFUSED = {
    "height only": {"gamma3": sp.cos(theta)},
    "another body's vertical": {"a": sp.sin(phi) * sp.sin(theta), "b": sp.cos(theta)},
    "unrelated": {"a": sp.sin(phi)},
}


@pytest.mark.parametrize("invariants", REFUSED.values(), ids=REFUSED)
def test_what_is_no_function_of_the_invariants_is_refused(invariants):
    with pytest.raises(DefinitionError, match="not a function of the invariants") as caught:
        descend(rolling_ball(CHARTS["euler zxz"], invariants))
    assert "\n" not in str(caught.value) and "'ball'" in str(caught.value)


def test_the_refusal_names_the_equation():
    height = {"gamma3": sp.cos(theta)}
    with pytest.raises(DefinitionError, match=r"force\[0\] is not a function"):
        descend(heavy_top(CHARTS["euler zxz"], (1, 1, 1), height))
    free = replace(heavy_top(CHARTS["euler zxz"], (1, 1, 1), height), parameters=(m, g, length))
    free = replace(free, lagrangian=free.lagrangian.xreplace({g: sp.Integer(0)}))
    with pytest.raises(DefinitionError, match="d/dt gamma3 is not a function"):
        descend(free)


@pytest.mark.parametrize("chart", ["euler zxz", "quaternion"])
def test_a_branch_is_not_guessed(chart):
    """gamma3 is +-sqrt(1 - gamma1^2 - gamma2^2): a function of the others, but two-valued."""
    vertical = CHARTS[chart].matrix.row(2)
    with pytest.raises(EngineLimit, match="no expression was found"):
        descend(rolling_ball(CHARTS[chart], {"a": vertical[0], "b": vertical[1]}))


def test_a_coordinate_in_a_denominator_is_a_coordinate():
    system = System(
        name="below",
        fibration=Fibration((x, y)),
        lagrangian=(velocity(x) ** 2 + velocity(y) ** 2) / 2,
        forces={x: 1 / (2 + y**2)},
    )
    with pytest.raises(DefinitionError, match=r"force\[0\] is not a function"):
        descend(system, {"X": x})
    assert descend(system, {"Y": y}).force[0] == 1 / (2 + sp.Symbol("Y") ** 2)


@pytest.mark.parametrize("name", ["omega1", "theta", "thetadot", "m", "t"])
def test_a_name_in_use_is_refused(name):
    vertical = CHARTS["euler zxz"].matrix.row(2)
    named = dict(zip((name, "b", "c"), vertical, strict=True))
    with pytest.raises(DefinitionError, match=f"'{name}'"):
        descend(rolling_ball(CHARTS["euler zxz"], {}), named)


@pytest.mark.parametrize("bad", [velocity(phi), omega[0] * sp.cos(theta), velocity(x) + 1])
def test_an_invariant_with_velocities_is_refused(bad):
    vertical = CHARTS["euler zxz"].matrix.row(2)
    named = dict(zip(("a", "b", "c"), vertical, strict=True))
    with pytest.raises(DefinitionError, match="'d' contains a velocity"):
        descend(rolling_ball(CHARTS["euler zxz"], {}), named | {"d": bad})


def test_a_system_without_invariants_asks_for_some():
    with pytest.raises(DefinitionError, match="declares no invariants"):
        descend(vo.load("sleigh"))

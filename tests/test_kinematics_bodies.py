"""Energies: a rigid body is the sum of its points, a rotor is Routh's function."""

from __future__ import annotations

import pytest
import sympy as sp

from voronec import DefinitionError, prove_equal
from voronec.kinematics import axial_rotor, kinetic_energy, point_velocity, uniform_field_energy

OMEGA = sp.symbols("omega1:4")
SPEED = sp.symbols("w1:4")
MASSES = sp.symbols("m1:5")
PLACES = [(1, 0, 2), (-1, 3, 0), (0, -2, 1), (2, 1, -1)]
k, C, m, g, z = sp.symbols("k C m g z")


def point_masses():
    """Total mass, centre of mass, inertia tensor about it, energy of the points themselves."""
    mass = sum(MASSES)
    points = [sp.Matrix(place) for place in PLACES]
    pairs = list(zip(MASSES, points, strict=True))
    centre = sum((mi * p for mi, p in pairs), sp.zeros(3, 1)) / mass
    tensor = sp.zeros(3)
    for mi, p in pairs:
        arm = p - centre
        tensor += mi * (arm.dot(arm) * sp.eye(3) - arm * arm.T)
    energy = 0
    for mi, p in pairs:
        w = sp.Matrix(SPEED) + sp.Matrix(OMEGA).cross(p)
        energy += mi * w.dot(w) / 2
    return mass, centre, tensor, energy


def test_a_rigid_body_has_the_energy_of_its_points():
    mass, centre, tensor, energy = point_masses()
    carried = point_velocity(SPEED, OMEGA, centre)
    assert prove_equal(kinetic_energy(mass, carried, tensor, OMEGA), energy).proved


def test_inertia_may_be_given_in_three_ways():
    moments = sp.symbols("I1:4")
    rows = [[moments[i] if i == j else 0 for j in range(3)] for i in range(3)]
    energies = {
        kinetic_energy(m, SPEED, inertia, OMEGA) for inertia in (moments, rows, sp.Matrix(rows))
    }
    energy = m * sum(w**2 for w in SPEED) / 2
    energy += sum(i * w**2 for i, w in zip(moments, OMEGA, strict=True)) / 2
    assert {sp.expand(e) for e in energies} == {sp.expand(energy)}


def test_a_rotor_adds_rouths_function():
    """k = dL/d(chidot), and L - k chidot differs from what is added by a constant."""
    axis = (0, sp.Rational(3, 5), sp.Rational(4, 5))
    chidot = sp.Symbol("chidot")
    own = C * (sum(a * w for a, w in zip(axis, OMEGA, strict=True)) + chidot) ** 2 / 2
    solved = sp.solve(sp.diff(own, chidot) - k, chidot)[0]
    routh = (own - k * chidot).subs(chidot, solved)
    assert prove_equal(routh, axial_rotor(k, axis, OMEGA) - k**2 / (2 * C)).proved


def test_a_rotor_adds_its_axial_momentum():
    """dL/d(omega) = I omega + k axis."""
    moments, axis = sp.symbols("I1:4"), (0, 0, 1)
    energy = kinetic_energy(m, (0, 0, 0), moments, OMEGA) + axial_rotor(k, axis, OMEGA)
    for i in range(3):
        assert sp.expand(energy.diff(OMEGA[i]) - moments[i] * OMEGA[i] - k * axis[i]) == 0


def test_gravity_grows_with_height():
    assert uniform_field_energy(m, (5, 7, z), (0, 0, -g)) == m * g * z


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: kinetic_energy(m, SPEED, (1, 2), OMEGA), "three principal moments"),
        (lambda: kinetic_energy(m, SPEED, sp.eye(2), OMEGA), "three principal moments"),
        (lambda: kinetic_energy(m, SPEED, sp.Matrix(3, 3, range(9)), OMEGA), "not symmetric"),
        (lambda: kinetic_energy(m, SPEED, [[1, 2, 3], [4], [5]], OMEGA), "differ in length"),
        (lambda: kinetic_energy(m, SPEED, 3, OMEGA), "three principal moments"),
        (lambda: kinetic_energy(m, SPEED[:2], (1, 1, 1), OMEGA), "the velocity of a body must be"),
        (lambda: axial_rotor(k, (0, 1), OMEGA), "the axis of a rotor must be three"),
        (lambda: uniform_field_energy(m, 3, (0, 0, g)), "a position must be three expressions"),
    ],
)
def test_bad_bodies_are_told_in_one_line(build, message):
    with pytest.raises(DefinitionError, match=message) as caught:
        build()
    assert "\n" not in str(caught.value)

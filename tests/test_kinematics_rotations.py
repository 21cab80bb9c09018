"""Rotations: R is orthogonal, and omega is what the hat of R^T dR/dt says."""

from __future__ import annotations

import itertools

import pytest
import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

from voronec import DefinitionError, prove_equal, velocity
from voronec.kinematics import Rotation

SEQUENCES = [
    "".join(axes) for axes in itertools.product("xyz", repeat=3) if axes[0] != axes[1] != axes[2]
]
ANGLES = sp.symbols("phi theta psi")
QUATERNION = sp.symbols("q0:4")
ENTRIES = sp.symbols("a1:4 b1:4 c1:4")


def rate_of_change(matrix, coordinates):
    return sum((matrix.diff(q) * velocity(q) for q in coordinates), sp.zeros(3))


def hat(omega):
    x, y, z = omega
    return sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def assert_equal(left, right, relations=()):
    for a, b in zip(sp.Matrix(left), sp.Matrix(right), strict=True):
        verdict = prove_equal(a, b, relations)
        assert verdict.proved, verdict


def on_shell(rotation):
    """The relations and their derivatives."""
    moving = [
        sum(sp.diff(r, q) * velocity(q) for q in rotation.coordinates) for r in rotation.relations
    ]
    return [*rotation.relations, *moving]


@pytest.mark.slow
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_an_euler_chart_is_a_rotation_that_turns_with_its_rates(sequence):
    rotation = Rotation.euler(sequence, *ANGLES)
    r, dr = rotation.matrix, rate_of_change(rotation.matrix, ANGLES)
    assert_equal(r.T * r, sp.eye(3))
    assert_equal([r.det(method="berkowitz")], [1])
    assert_equal(r.T * dr, hat(rotation.body_rates))
    assert_equal(dr * r.T, hat(rotation.space_rates))
    assert rotation.coordinates == ANGLES
    assert rotation.relations == ()


def test_there_are_twelve_euler_charts():
    assert len(SEQUENCES) == 12


def test_an_euler_chart_turns_right_handedly_about_body_axes_in_turn():
    yaw, pitch, roll = ANGLES
    rotation = Rotation.euler("zyx", yaw, pitch, roll).matrix
    quarter = {yaw: sp.pi / 2, pitch: 0, roll: 0}
    assert rotation.subs(quarter) * sp.Matrix([1, 0, 0]) == sp.Matrix([0, 1, 0])
    both = {yaw: sp.pi / 2, pitch: 0, roll: sp.pi / 2}  # the roll is about the yawed x axis
    assert rotation.subs(both) * sp.Matrix([0, 1, 0]) == sp.Matrix([0, 0, 1])


def test_the_zxz_rates_are_the_textbook_ones():
    phi, theta, psi = ANGLES
    dphi, dtheta, dpsi = map(velocity, ANGLES)
    expected = [
        dphi * sp.sin(theta) * sp.sin(psi) + dtheta * sp.cos(psi),
        dphi * sp.sin(theta) * sp.cos(psi) - dtheta * sp.sin(psi),
        dphi * sp.cos(theta) + dpsi,
    ]
    assert_equal(Rotation.euler("zxz", phi, theta, psi).body_rates, expected)


def test_a_unit_quaternion_is_a_rotation_that_turns_with_its_rates():
    rotation = Rotation.quaternion(*QUATERNION)
    shell = on_shell(rotation)
    r, dr = rotation.matrix, rate_of_change(rotation.matrix, QUATERNION)
    assert rotation.relations == (sum(q**2 for q in QUATERNION) - 1,)
    assert_equal(r.T * r, sp.eye(3), shell)
    assert_equal(r.T * dr, hat(rotation.body_rates), shell)
    assert_equal(dr * r.T, hat(rotation.space_rates), shell)


def test_a_quaternion_turns_by_twice_its_angle():
    half = sp.Symbol("h")
    about_z = {**dict.fromkeys(QUATERNION, 0), QUATERNION[0]: sp.cos(half)}
    about_z[QUATERNION[3]] = sp.sin(half)
    turned = Rotation.quaternion(*QUATERNION).matrix.subs(about_z)
    psi = ANGLES[2]
    expected = Rotation.euler("xyz", *ANGLES).matrix.subs({ANGLES[0]: 0, ANGLES[1]: 0})
    assert_equal(turned, expected.subs({psi: 2 * half}))


def orthogonal_point():
    """A rational rotation matrix and a rational velocity tangent to the rotation group."""
    q = dict(zip(QUATERNION, map(sp.Rational, ("1/5", "2/5", "2/5", "4/5")), strict=True))
    matrix = Rotation.quaternion(*QUATERNION).matrix.subs(q)
    spin = sp.Matrix([sp.Rational(3, 7), -2, sp.Rational(5, 3)])
    return matrix, spin, matrix * hat(spin)


@pytest.mark.parametrize("symbols", [ENTRIES, sp.Matrix(3, 3, ENTRIES)])
def test_the_matrix_entries_are_a_chart_with_their_rates(symbols):
    rotation = Rotation.entries(symbols)
    matrix, spin, moving = orthogonal_point()
    at = dict(zip(ENTRIES, matrix, strict=True))
    at |= dict(zip(map(velocity, ENTRIES), moving, strict=True))
    assert rotation.matrix == sp.Matrix(3, 3, ENTRIES)
    assert rotation.body_rates.subs(at) == spin
    assert rotation.space_rates.subs(at) == matrix * spin
    assert [r.subs(at) for r in on_shell(rotation)] == [0] * 12


def test_dynamicsymbols_keep_their_derivatives():
    angles = dynamicsymbols("phi theta psi")
    rates = Rotation.euler("zyz", *angles).body_rates
    assert {velocity(a) for a in angles} <= rates.atoms(sp.Derivative)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Rotation.euler("zzx", *ANGLES), "'zzx' is not an Euler sequence"),
        (lambda: Rotation.euler("ZXZ", *ANGLES), "'ZXZ' is not an Euler sequence"),
        (lambda: Rotation.euler("zxz", *ANGLES[:2]), "3 symbols are needed, 2 are given"),
        (lambda: Rotation.euler("zxz", ANGLES[0], ANGLES[1], ANGLES[0]), "'phi' is used twice"),
        (lambda: Rotation.euler("zxz", ANGLES[0], 1, ANGLES[2]), "'1' is not a symbol"),
        (lambda: Rotation.quaternion(*QUATERNION[:3], QUATERNION[0]), "'q0' is used twice"),
        (lambda: Rotation.entries(ENTRIES[:8]), "9 symbols are needed, 8 are given"),
    ],
)
def test_bad_charts_are_told_in_one_line(build, message):
    with pytest.raises(DefinitionError, match=message) as caught:
        build()
    assert "\n" not in str(caught.value)

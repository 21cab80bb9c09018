"""The rolling ball as a builder: what it says of itself is true of the body it describes."""

from __future__ import annotations

import pytest
import sympy as sp

import voronec as vo
from voronec import DefinitionError, prove_equal
from voronec.kinematics import RollingBall, Surface, contact_momentum

pytestmark = pytest.mark.slow

R1, R2, m = sp.symbols("R1 R2 m")
inertia = sp.symbols("I1:4")
offset = sp.symbols("a1:4")
omega = sp.symbols("omega1:4")
D = m * R2**2

BALLS = {
    "sphere": RollingBall.on_sphere(R1, R2, m, inertia),
    "sphere of negative radius": RollingBall.on_sphere(-R1, R2, m, inertia),
    "plane": RollingBall.on_plane(R2, m, inertia),
    "torus": RollingBall.on(
        Surface.torus(3 * R1, R1, *sp.symbols("u1 v1")), R2, m, inertia, offset
    ),
    "plane, displaced": RollingBall.on_plane(R2, m, inertia, offset),
}
each = pytest.mark.parametrize("name", BALLS)


def equal(left, right):
    return all(prove_equal(a, b).proved for a, b in zip(left, right, strict=True))


def derived(ball):
    """The equations of the ball that rolls without slipping."""
    return vo.derive(
        vo.System(
            name="ball",
            fibration=vo.Fibration(ball.base, ball.fibre),
            frame=vo.Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
            lagrangian=ball.energy,
            constraints=ball.no_slip,
            parameters=(R1, R2, m, *inertia, *offset),
        )
    )


def rolled(ball, exprs):
    """Expressions where the ball rolls without slipping, by its angular velocity."""
    eqs = derived(ball)
    rates = {
        vo.velocity(q): rate for q, rate in zip(eqs.system.coordinates, eqs.rates, strict=True)
    }
    return [sp.sympify(e).xreplace(rates) for e in exprs]


@each
def test_the_momentum_about_the_contact_is_the_mass_matrix_times_the_angular_velocity(name):
    ball = BALLS[name]
    eqs = derived(ball)
    assert equal(eqs.mass * sp.Matrix(omega), rolled(ball, ball.momentum))


@pytest.mark.parametrize("name", ["sphere", "sphere of negative radius", "plane"])
def test_a_balanced_ball_has_the_momentum_that_contact_momentum_gives(name):
    ball = BALLS[name]
    found = rolled(ball, ball.momentum)
    assert equal(found, contact_momentum(inertia, D, omega, ball.normal))
    assert not equal(found, contact_momentum(inertia, -D, omega, ball.normal))


@each
def test_the_normal_leads_from_the_contact_to_the_centre(name):
    ball = BALLS[name]
    contact = ball.contact
    outward = contact.attitude * sp.Matrix(ball.normal)
    assert equal(outward, contact.fixed.normal)
    reach = contact.centre - sp.Matrix(contact.fixed.position)
    assert equal(reach, R2 * outward)


@pytest.mark.parametrize(
    ("name", "epsilon"),
    [
        ("sphere", R1 / (R1 + R2)),
        ("sphere of negative radius", R1 / (R1 - R2)),
        ("plane", 1),
        ("plane, displaced", 1),
    ],
)
def test_the_normal_turns_with_epsilon_times_the_angular_velocity(name, epsilon):
    ball = BALLS[name]
    normal = sp.Matrix(ball.normal)
    moved = sum((normal.diff(q) * vo.velocity(q) for q in ball.contact.coordinates), sp.zeros(3, 1))
    turned = normal.cross(sp.Matrix(omega))
    assert equal(rolled(ball, moved), epsilon * turned)
    assert not equal(rolled(ball, moved), -epsilon * turned)


@each
def test_without_twist_the_angular_velocity_is_across_the_normal(name):
    ball = BALLS[name]
    across = sum(w * g for w, g in zip(ball.spin, ball.normal, strict=True))
    assert prove_equal(ball.no_twist, -across).proved


def test_the_centre_of_mass_moves_as_a_point_of_the_ball():
    ball = BALLS["plane, displaced"]
    contact = ball.contact
    place = contact.centre + contact.attitude * sp.Matrix(offset)
    moved = sum((place.diff(q) * vo.velocity(q) for q in contact.coordinates), sp.zeros(3, 1))
    assert equal(moved, contact.attitude * sp.Matrix(ball.centre_velocity))


def test_a_displaced_centre_of_mass_without_displacement_is_the_balls_centre():
    with_zeros = RollingBall.on_plane(R2, m, inertia, (0, 0, 0))
    assert with_zeros == BALLS["plane"]
    shifted = BALLS["plane, displaced"]
    back = dict.fromkeys(offset, sp.Integer(0))
    assert prove_equal(shifted.energy.xreplace(back), with_zeros.energy).proved
    assert not prove_equal(shifted.energy, with_zeros.energy).proved


def test_base_and_fibre_are_the_coordinates_of_the_contact():
    ball = BALLS["sphere"]
    assert {*ball.base, *ball.fibre} == {*ball.contact.coordinates}
    assert list(map(str, (*ball.base, *ball.fibre))) == ["u", "v", "theta", "u1", "v1"]
    assert list(map(str, BALLS["plane"].fibre)) == ["x", "y"]


@pytest.mark.parametrize(
    ("build", "place"),
    [
        (lambda: RollingBall.on_plane(R2, m, inertia[:2]), "the moments of a ball"),
        (lambda: RollingBall.on_plane(R2, m, inertia, (1, 0)), "the centre of mass of a ball"),
        (lambda: contact_momentum(inertia[:2], D, omega, (0, 0, 1)), "the moments of a ball"),
        (lambda: contact_momentum(inertia, D, omega[:2], (0, 0, 1)), "an angular velocity"),
        (lambda: contact_momentum(inertia, D, omega, (0, 1)), "a normal"),
    ],
)
def test_what_is_not_three_expressions_is_refused_by_name(build, place):
    with pytest.raises(DefinitionError, match=f"{place} must be three expressions"):
        build()

"""Rolling contact: every formula against the motion of a rigid body, differentiated numerically."""

from __future__ import annotations

import re
from pathlib import Path

import mpmath
import pytest
import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

from voronec import DefinitionError, prove_equal, velocity
from voronec.kinematics import RollingContact, Surface

pytestmark = pytest.mark.slow

u, v, u1, v1, theta = NAMES = sp.symbols("u v u1 v1 theta")
DOTS = tuple(map(velocity, NAMES))
R1, R2 = sp.symbols("R1 R2")
RADII = {R1: sp.Rational(13, 10), R2: sp.Rational(7, 10)}
THIRD = sp.Rational(1, 3)

SHEARED = Surface((u, v), (sp.sin(u) * sp.cos(v + u), sp.sin(u) * sp.sin(v + u), sp.cos(u) / 2))
SADDLE = Surface((u1, v1), (u1 + v1 * THIRD, v1, u1**2 - u1 * v1 / 2))
CONTACTS = {
    "ball on a sphere": RollingContact(Surface.sphere(R2, u, v), Surface.sphere(R1, u1, v1), theta),
    "ball inside a sphere": RollingContact(
        Surface.sphere(R2, u, v), Surface.sphere(-R1, u1, v1), theta
    ),
    "ball on a plane": RollingContact(Surface.sphere(R2, u, v), Surface.plane(u1, v1), theta),
    "ellipsoid on a torus": RollingContact(
        Surface.ellipsoid((R2, THIRD, 1), u, v), Surface.torus(2, R1, u1, v1), theta
    ),
    "torus on a saddle": RollingContact(Surface.torus(R1, R2, u, v), SADDLE, theta),
    "sheared ellipsoid on a saddle": RollingContact(SHEARED, SADDLE, theta),
}
each = pytest.mark.parametrize("name", CONTACTS)

PLACE = [mpmath.mpf(x) / 41 for x in (31, 17, 37, -23, 29)]
MOTION = [mpmath.mpf(x) / 29 for x in (11, -13, 17, 23, -19)]
TINY = mpmath.mpf(10) ** -30


def numeric(expr, names=NAMES):
    """A function of the coordinates (and velocities) that gives mpmath numbers."""
    function = sp.lambdify(names, sp.Matrix(expr).subs(RADII), "mpmath")
    return lambda point: mpmath.matrix(function(*point).tolist())


def now(expr):
    """The value at the place and the velocity of the tests."""
    return numeric(expr, (*NAMES, *DOTS))([*PLACE, *MOTION])


def rate(expr):
    """The time derivative of an expression of the coordinates, by finite differences."""
    function = numeric(expr)

    def entry(i, j):
        def along(time):
            return function([x + time * w for x, w in zip(PLACE, MOTION, strict=True)])[i, j]

        return mpmath.diff(along, 0)

    rows, columns = sp.Matrix(expr).shape
    return mpmath.matrix([[entry(i, j) for j in range(columns)] for i in range(rows)])


def vee(skew):
    return mpmath.matrix([skew[2, 1], skew[0, 2], skew[1, 0]])


def cross(a, b):
    return mpmath.matrix(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def assert_close(left, right):
    assert max(abs(x) for x in left - right) < TINY


@pytest.fixture(autouse=True)
def fifty_digits():
    with mpmath.workdps(50):
        yield


@each
def test_the_bodies_touch_with_opposite_normals(name):
    contact = CONTACTS[name]
    attitude = now(contact.attitude)
    assert_close(attitude.T * attitude, mpmath.eye(3))
    assert abs(mpmath.det(attitude) - 1) < TINY
    material = now(contact.centre) + attitude * now(contact.body.position)
    assert_close(material, now(contact.fixed.position))
    assert_close(attitude * now(contact.body.normal), -now(contact.fixed.normal))


@each
def test_theta_is_the_angle_from_v1_to_u(name):
    contact = CONTACTS[name]
    turned = now(contact.attitude) * now(contact.body.frame[:, 0])
    eu1, ev1, n1 = (now(contact.fixed.frame[:, i]) for i in range(3))
    angle = PLACE[4]
    assert_close(turned, mpmath.cos(angle) * ev1 + mpmath.sin(angle) * cross(n1, ev1))
    assert_close(cross(n1, ev1), -eu1)


@each
def test_the_angular_velocity_is_that_of_the_attitude(name):
    contact = CONTACTS[name]
    omega = vee(now(contact.attitude).T * rate(contact.attitude))
    assert_close(omega, now(contact.angular_velocity))
    assert_close(now(contact.body.frame).T * omega, now(contact.spin))


@each
def test_slip_and_centre_velocity_are_those_of_the_rigid_body(name):
    contact = CONTACTS[name]
    attitude, centre_moves = now(contact.attitude), rate(contact.centre)
    omega = attitude * vee(attitude.T * rate(contact.attitude))
    arm = now(contact.fixed.position) - now(contact.centre)
    to_frame = (attitude * now(contact.body.frame)).T
    assert_close(to_frame * arm, now(contact.arm))
    assert_close(to_frame * centre_moves, now(contact.centre_velocity))
    slip = centre_moves + cross(omega, arm)
    assert_close(to_frame * slip, now(contact.slip))
    along_u1, along_v1 = now(contact.no_slip)
    expected = now(contact.fixed.frame) * mpmath.matrix([along_u1, along_v1, 0])
    assert_close(slip, expected)
    assert abs(now([contact.no_twist])[0] - (to_frame * omega)[2]) < TINY


@each
def test_the_constraints_make_the_contact_point_rest(name):
    """Solve the constraints for du1/dt, dv1/dt: then dO/dt = -omega x OM."""
    contact = CONTACTS[name]
    solved = sp.solve(contact.no_slip, DOTS[2:4], dict=True)[0]
    at = [*PLACE, MOTION[0], MOTION[1], 0, 0, MOTION[4]]
    fibre = numeric([solved[d] for d in DOTS[2:4]], (*NAMES, *DOTS))(at)
    at[7], at[8] = fibre[0], fibre[1]
    spin, arm, centre = (
        numeric(x, (*NAMES, *DOTS))(at)
        for x in (contact.spin, contact.arm, contact.centre_velocity)
    )
    assert_close(centre, -cross(spin, arm))


def test_outer_rolling_of_a_ball():
    contact = CONTACTS["ball on a sphere"]
    n1 = contact.fixed.normal
    for entry, expected in zip(contact.centre, (R1 + R2) * n1, strict=True):
        assert prove_equal(entry, expected).proved
    assert contact.arm == (0, 0, R2)


def test_inner_rolling_is_outer_rolling_with_the_radius_reversed():
    """n1 points inward, so O = (R2 - R1) n1 lies at the distance R1 - R2 from the middle."""
    outer, inner = CONTACTS["ball on a sphere"], CONTACTS["ball inside a sphere"]
    assert inner.fixed.position == tuple(-x for x in outer.fixed.position)
    for name in ("centre", "spin", "slip", "centre_velocity", "no_slip", "attitude"):
        pairs = zip(getattr(inner, name), getattr(outer, name), strict=True)
        assert all(prove_equal(a, b.subs(R1, -R1)).proved for a, b in pairs)
    for entry, expected in zip(inner.centre, (R2 - R1) * inner.fixed.normal, strict=True):
        assert prove_equal(entry, expected).proved


@pytest.mark.parametrize(
    ("contact", "mu_prime"),
    [
        (CONTACTS["ball on a sphere"], R2 / R1),
        (CONTACTS["ball inside a sphere"], -R2 / R1),
    ],
)
def test_rolling_balls_have_the_printed_rates(contact, mu_prime):
    """[DragovicGajicJovanovic2020, eq. (4.2.789)], and w^2 = R2^2 (s^2 + tau^2)."""
    du, dv, _, dv1, dtheta = DOTS
    rolling = sp.solve(contact.no_slip, DOTS[2:4], dict=True)[0]
    mu = 1 + mu_prime
    s, tau, n = contact.spin
    assert prove_equal(s.subs(rolling), mu * sp.sin(u) * dv).proved
    assert prove_equal(tau.subs(rolling), -mu * du).proved
    assert prove_equal(n, -dtheta - sp.cos(u) * dv - sp.cos(u1) * dv1).proved
    square = sum(w**2 for w in contact.centre_velocity).subs(rolling)
    assert prove_equal(square, (R2**2 * (s**2 + tau**2)).subs(rolling)).proved


def test_the_dictionary_of_the_ball():
    """N on the ball: gamma = R^T n1 = -N and (omega, gamma) = -n."""
    contact = CONTACTS["ball on a sphere"]
    pole = (sp.sin(u) * sp.cos(v), sp.sin(u) * sp.sin(v), sp.cos(u))
    assert tuple(contact.body.normal) == pole
    gamma = contact.attitude.T * contact.fixed.normal
    assert all(prove_equal(g, -x).proved for g, x in zip(gamma, pole, strict=True))
    along = sum(w * g for w, g in zip(contact.angular_velocity, gamma, strict=True))
    assert prove_equal(along, -contact.spin[2]).proved


def revolution(names, letters):
    f, g = (sp.Function(letter)(names[0]) for letter in letters)
    return Surface.revolution((f, g), *names)


@pytest.mark.parametrize(
    "contact",
    [
        CONTACTS["ball on a sphere"],
        RollingContact(Surface.torus(2, R2, u, v), Surface.sphere(R1, u1, v1), theta),
        RollingContact(revolution((u, v), "fg"), revolution((u1, v1), "FG"), theta),
        # u and v exchanged: here E_v, not G_u, makes the frame turn
        RollingContact(
            Surface((u, v), (sp.cosh(v) * sp.cos(u), -sp.cosh(v) * sp.sin(u), v)),
            Surface.sphere(R1, u1, v1),
            theta,
        ),
    ],
)
def test_lines_of_curvature_give_the_printed_formulas(contact):
    """[DragovicGajicJovanovic2020, eqs. eq:n, eq:nosliding2], every sign as printed."""
    (e, _, g), (d, mixed, dd) = contact.body.first_form, contact.body.second_form
    (e1, _, g1), (d1, mixed1, dd1) = contact.fixed.first_form, contact.fixed.second_form
    assert contact.body.orthogonal
    assert contact.fixed.orthogonal
    assert (mixed, mixed1) == (0, 0)
    (lu, lv), (lu1, lv1) = (
        x.lengths or tuple(map(sp.sqrt, (x.first_form[0], x.first_form[2])))
        for x in (contact.body, contact.fixed)
    )
    du, dv, du1, dv1, dtheta = DOTS
    c, sn = sp.cos(theta), sp.sin(theta)
    s = -dd / lv * dv - dd1 / lv1 * dv1 * sn - d1 / lu1 * du1 * c
    tau = d / lu * du - d1 / lu1 * du1 * sn + dd1 / lv1 * dv1 * c
    n = -dtheta + (e1.diff(v1) * du1 - g1.diff(u1) * dv1) / (2 * lu1 * lv1)
    n += (e.diff(v) * du - g.diff(u) * dv) / (2 * lu * lv)
    for derived, printed in zip(contact.spin, (s, tau, n), strict=True):
        assert prove_equal(derived, printed).proved
    rolling = (
        lu1 * du1 - (-lu * du * sn + lv * dv * c),
        lv1 * dv1 - (lu * du * c + lv * dv * sn),
    )
    for derived, printed in zip(contact.no_slip, rolling, strict=True):
        assert prove_equal(derived, printed).proved


def test_everything_is_linear_in_the_velocities():
    for contact in CONTACTS.values():
        for expr in (*contact.spin, *contact.slip, *contact.no_slip):
            assert all(expr.diff(a, b) == 0 for a in DOTS for b in DOTS)
            assert prove_equal(expr.subs(dict.fromkeys(DOTS, 0))).proved


def test_dynamicsymbols_are_symbols_like_others():
    moving = dynamicsymbols("u v u1 v1 theta")
    contact = RollingContact(
        Surface.sphere(R2, *moving[:2]), Surface.sphere(R1, *moving[2:4]), moving[4]
    )
    names = dict(zip(NAMES, moving, strict=True))
    names |= dict(zip(DOTS, map(velocity, moving), strict=True))
    still = CONTACTS["ball on a sphere"]
    for attribute in ("spin", "no_slip", "centre_velocity"):
        pairs = zip(getattr(contact, attribute), getattr(still, attribute), strict=True)
        assert all(a == b.xreplace(names) for a, b in pairs)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (
            lambda: RollingContact(Surface.sphere(R2, u, v), Surface.plane(u, v1), theta),
            "'u' is used twice",
        ),
        (
            lambda: RollingContact(Surface.sphere(R2, u, v), Surface.plane(u1, v1), v),
            "'v' is used twice",
        ),
        (
            lambda: RollingContact(Surface.sphere(R2, u, v), Surface.plane(u1, v1), 0),
            "'0' is not a symbol",
        ),
        (
            lambda: RollingContact(Surface.sphere(theta, u, v), Surface.plane(u1, v1), theta),
            "the body surface contains 'theta'",
        ),
        (
            lambda: RollingContact(Surface.plane(u, v), Surface.sphere(u, u1, v1), theta),
            "the fixed surface contains 'u'",
        ),
    ],
)
def test_bad_contacts_are_told_in_one_line(build, message):
    with pytest.raises(DefinitionError, match=message) as caught:
        build()
    assert "\n" not in str(caught.value)


def test_the_example_of_the_conventions_runs():
    page = Path(__file__).parents[1] / "docs" / "conventions.md"
    (block,) = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    exec(block, {})

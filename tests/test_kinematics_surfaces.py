"""Surfaces: the frame is a rotation that follows the tangents, and Gauss's theorem holds."""

from __future__ import annotations

import random
from typing import Any

import mpmath
import pytest
import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

from voronec import DefinitionError, prove_equal, time, velocity
from voronec.kinematics import Surface

pytestmark = pytest.mark.slow

u, v = sp.symbols("u v")
a, b, c, R = sp.symbols("a b c R")
f, g = sp.Function("f"), sp.Function("g")
VALUES = {a: sp.Rational(3, 2), b: sp.Rational(5, 7), c: sp.Rational(9, 10), R: sp.Rational(4, 3)}

SURFACES = {
    "sphere": Surface.sphere(R, u, v),
    "sphere seen from inside": Surface.sphere(-R, u, v),
    "plane": Surface.plane(u, v),
    "ellipsoid": Surface.ellipsoid((a, b, c), u, v),
    "torus": Surface.torus(a, b, u, v),
    "catenoid": Surface.revolution((sp.cosh(u), u), u, v),
    "skew paraboloid": Surface((u, v), (u + v / 3, v, u**2 + a * u * v)),
    "skew plane": Surface((u, v), (u + v / 2, v, sp.Integer(0))),
    "sheared sphere": Surface(
        (u, v),
        (sp.sin(u) * sp.cos(v + u), sp.sin(u) * sp.sin(v + u), sp.cos(u)),
        lengths=(sp.sqrt(1 + sp.sin(u) ** 2), sp.sin(u)),
        area=sp.sin(u),
    ),
}
each = pytest.mark.parametrize("name", SURFACES)


def at_points(exprs, count=3):
    """Values of expressions at random rational points, to 50 digits."""
    names = (u, v, *map(velocity, (u, v)), *VALUES)
    function = sp.lambdify(names, list(exprs), "mpmath")
    fields = random.Random(3)
    for _ in range(count):
        point = [mpmath.mpf(fields.randint(20, 130)) / 97 for _ in range(4)]
        with mpmath.workdps(50):
            yield function(*point, *[mpmath.mpf(x.p) / x.q for x in VALUES.values()])


def assert_zero(exprs):
    for values in at_points(exprs):
        assert max(abs(x) for x in values) < mpmath.mpf(10) ** -35


def tangents(surface):
    r = sp.Matrix(surface.position)
    return r.diff(u), r.diff(v)


@each
def test_the_frame_is_a_proper_rotation_along_the_tangents(name):
    surface = SURFACES[name]
    ru, rv = tangents(surface)
    frame = surface.frame
    assert_zero(frame.T * frame - sp.eye(3))
    assert_zero([frame.det() - 1, *sp.Matrix(frame[:, 0]).cross(ru), frame[:, 2].dot(rv)])
    sign = -1 if name == "sphere seen from inside" else 1
    for along, across, outward in at_points(
        [frame[:, 0].dot(ru), frame[:, 1].dot(rv), frame[:, 2].dot(ru.cross(rv))]
    ):
        assert sign * along > 0
        assert sign * across > 0
        assert outward > 0


@each
def test_the_fundamental_forms_are_those_of_the_definition(name):
    surface = SURFACES[name]
    ru, rv = tangents(surface)
    first = [ru.dot(ru), ru.dot(rv), rv.dot(rv)]
    second = [x.dot(surface.normal) for x in (ru.diff(u), ru.diff(v), rv.diff(v))]
    assert_zero(p - q for p, q in zip(surface.first_form, first, strict=True))
    assert_zero(p - q for p, q in zip(surface.second_form, second, strict=True))


@each
def test_the_curvature_is_intrinsic(name):
    """Theorema egregium: K from both forms is K from the first alone (Brioschi)."""
    surface = SURFACES[name]
    e, ff, gg = surface.first_form
    corner = -sp.diff(e, v, 2) / 2 + sp.diff(ff, u, v) - sp.diff(gg, u, 2) / 2
    eu, ev, gu, gv = (sp.diff(x, y) / 2 for x in (e, gg) for y in (u, v))
    one = sp.Matrix([[corner, eu, sp.diff(ff, u) - ev], [sp.diff(ff, v) - gu, e, ff], [gv, ff, gg]])
    two = sp.Matrix([[0, ev, gu], [ev, e, ff], [gu, ff, gg]])
    brioschi = (one.det() - two.det()) / (e * gg - ff**2) ** 2
    assert_zero([surface.gauss_curvature - brioschi])


@each
def test_the_frame_turns_with_its_rates(name):
    surface = SURFACES[name]
    moving = surface.frame.diff(u) * velocity(u) + surface.frame.diff(v) * velocity(v)
    x, y, z = surface.frame_rates
    assert_zero(surface.frame.T * moving - sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]]))


@each
def test_position_and_velocity_are_their_components_in_the_frame(name):
    surface = SURFACES[name]
    ru, rv = tangents(surface)
    assert_zero(surface.frame * sp.Matrix(surface.support) - sp.Matrix(surface.position))
    moving = ru * velocity(u) + rv * velocity(v)
    assert_zero(surface.frame * sp.Matrix(surface.trace_velocity) - moving)


def test_known_curvatures_come_out_short():
    assert SURFACES["sphere"].gauss_curvature == R**-2
    assert SURFACES["plane"].gauss_curvature == 0
    assert SURFACES["skew plane"].gauss_curvature == 0
    assert SURFACES["sheared sphere"].gauss_curvature == 1
    assert prove_equal(SURFACES["catenoid"].gauss_curvature, -(sp.cosh(u) ** -4)).proved


def test_a_profile_may_be_unknown():
    surface = Surface.revolution((f(u), g(u)), u, v)
    f1, g1, f2, g2 = f(u).diff(u), g(u).diff(u), f(u).diff(u, 2), g(u).diff(u, 2)
    expected = g1 * (f1 * g2 - g1 * f2) / (f(u) * (f1**2 + g1**2) ** 2)
    assert prove_equal(surface.gauss_curvature, expected).proved


def test_what_is_outward_is_outward():
    inside = {"sphere": (0, 0, 0), "ellipsoid": (0, 0, 0)}
    for name, point in inside.items():
        surface = SURFACES[name]
        arm = sp.Matrix(surface.position) - sp.Matrix(point)
        assert all(value[0] > 0 for value in at_points([arm.dot(surface.normal)]))
    torus = SURFACES["torus"]
    arm = sp.Matrix(torus.position) - a * sp.Matrix([sp.cos(v), sp.sin(v), 0])
    assert_zero([arm.dot(torus.normal) - b])


def test_a_sphere_bends_away_from_its_outward_normal():
    assert SURFACES["sphere"].second_form == (-R, 0, -R * sp.sin(u) ** 2)
    assert tuple(SURFACES["plane"].normal) == (0, 0, 1)


def test_the_sphere_of_negative_radius_has_the_same_frame():
    outside, inside = SURFACES["sphere"], SURFACES["sphere seen from inside"]
    assert inside.frame == outside.frame
    assert inside.support == (0, 0, -R)
    assert outside.support == (0, 0, R)


def test_orthogonality_is_seen():
    crossing = [name for name, surface in SURFACES.items() if not surface.orthogonal]
    assert crossing == ["ellipsoid", "skew paraboloid", "skew plane", "sheared sphere"]
    assert Surface.ellipsoid((a, a, c), u, v).orthogonal


def test_dynamicsymbols_are_symbols_like_others():
    p, q = dynamicsymbols("u v")
    moving, still = Surface.sphere(R, p, q), SURFACES["sphere"]
    names = {u: p, v: q, velocity(u): velocity(p), velocity(v): velocity(q)}
    assert moving.frame == still.frame.xreplace(names)
    for one, other in zip(moving.frame_rates, still.frame_rates, strict=True):
        assert one == other.xreplace(names)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (
            lambda: Surface((u, v), SURFACES["sphere"].position, (R, R)),
            r"\|r_v\| = R of the surface is wrong: its square must be R\*\*2\*sin\(u\)\*\*2",
        ),
        (
            lambda: Surface((u, v), SURFACES["skew plane"].position, area=2),
            r"the area = 2 of the surface is wrong: its square must be 1 ",
        ),
        (lambda: Surface((u, v), (u + v, 2 * u + 2 * v, 0)), "is not a surface"),
        (lambda: Surface((u, v), (sp.cos(u), sp.sin(u), 0)), "is not a surface"),
        (lambda: Surface((u, v), (a, b, c)), "is not a surface"),
        (lambda: Surface((u, u), (u, u**2, 0)), "'u' is used twice"),
        (lambda: Surface((u, 2), (u, 2, 0)), "'2' is not a symbol"),
        (lambda: Surface((u,), (u, 2, 0)), "2 symbols are needed, 1 are given"),
        (lambda: Surface((u, v), (u, v)), "must be three expressions"),
        (lambda: Surface((u, v), (u, v, 0), (1,)), "two are needed"),
        (lambda: Surface((u, v), (u, v, time)), "depends on the time"),
        (lambda: Surface.ellipsoid((a, b), u, v), "the semi-axes .* three expressions"),
    ],
)
def test_bad_surfaces_are_told_in_one_line(build, message):
    with pytest.raises(DefinitionError, match=message) as caught:
        build()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "made",
    [
        lambda u, v: Surface.sphere("2 +", u, v),
        lambda u, v: Surface.sphere([1], u, v),
        lambda u, v: Surface.sphere(1, "2 +", v),
        lambda u, v: Surface.torus(None, 1, u, v),
        lambda u, v: Surface.ellipsoid((1, 1, 1), u, "2 +"),
    ],
)
def test_what_is_no_expression_is_refused(made: Any) -> None:
    with pytest.raises(DefinitionError):
        made(*sp.symbols("u v"))
    assert Surface.sphere("R", "u", "v") == Surface.sphere(*sp.symbols("R u v"))

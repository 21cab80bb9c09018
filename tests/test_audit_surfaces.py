"""Surfaces known by their forms only: what is derived for all of them holds on explicit ones."""

from __future__ import annotations

import pytest
import sympy as sp
from voronec.systems.demchenko.dictionary.body import DOTS, Body
from voronec.systems.demchenko.dictionary.gyroscope import AXIAL, CLIMB, SPEED, WithGyroscope
from voronec.systems.demchenko.dictionary.surfaces import (
    BASE,
    COORDINATES,
    FIBRE,
    MASS,
    QUASI,
    theta,
    u,
    u1,
    v,
    v1,
)

import voronec as vo
from voronec import DefinitionError, prove_equal, velocity
from voronec.kinematics import (
    RollingContact,
    Surface,
    SurfaceForms,
    axial_rotor,
    kinetic_energy,
    point_velocity,
)

pytestmark = pytest.mark.slow

R, r, shift = sp.symbols("R r shift", positive=True)
I1, I3, k = sp.symbols("I1 I3 k", positive=True)
EXPLICIT = {
    "sphere": Surface.sphere(R, u, v),
    "torus": Surface.torus(R, r, u, v),
    "ellipsoid of revolution": Surface.revolution((R * sp.sin(u), r * sp.cos(u)), u, v),
}
each = pytest.mark.parametrize("name", EXPLICIT)


def assert_equal(left, right):
    for a, b in zip(left, right, strict=True):
        verdict = prove_equal(a, b)
        assert verdict.proved, verdict


def values_of(forms, mark=""):
    """What the unknown functions of ``SurfaceForms.unknown`` are on an explicit surface."""
    (e, _, g), (d, _, dd) = forms.first_form, forms.second_form
    names = dict(zip(("E", "G", "D", "D''"), (e, g, d, dd), strict=True))
    return {name + mark: (forms.coordinates, value) for name, value in names.items()}


def specialise(expr, functions):
    """Explicit functions for unknown ones, and their derivatives for derivatives."""
    expr = sp.sympify(expr)
    at = {name: sp.Lambda(names, value) for name, (names, value) in functions.items()}
    rules = {}
    for node in expr.atoms(sp.Derivative):
        if node.expr.func.__name__ in at:
            value = at[node.expr.func.__name__](*node.expr.args)
            rules[node] = sp.diff(value, *node.variable_count)
    for node in expr.atoms(sp.core.function.AppliedUndef):
        if node.func.__name__ in at:
            rules[node] = at[node.func.__name__](*node.args)
    return positive(expr.xreplace(rules))


def positive(expr):
    """Square roots of squares: sin u is positive on the chart."""
    return expr.replace(
        lambda x: x.is_Pow and x.exp.is_Rational and x.exp.q == 2,
        lambda x: sp.powdenest(x, force=True),
    )


@each
def test_forms_of_an_explicit_surface_move_as_it_does(name):
    surface = EXPLICIT[name]
    forms = SurfaceForms.of(surface)
    assert_equal(forms.frame_rates, surface.frame_rates)
    assert_equal(forms.trace_velocity, surface.trace_velocity)
    assert_equal(forms.relations, (0, 0, 0))


@each
def test_unknown_surfaces_specialise_to_explicit_ones(name):
    surface = EXPLICIT[name]
    functions = values_of(surface)
    unknown = SurfaceForms.unknown(u, v)
    special = [specialise(x, functions) for x in unknown.frame_rates]
    assert_equal(special, surface.frame_rates)


@each
def test_rules_are_the_derivatives_on_explicit_surfaces(name):
    surface = EXPLICIT[name]
    frame, inertia = sp.Matrix(surface.frame), sp.diag(I1, I1, I3)
    axis = [sp.Function(x)(u, v) for x in ("a", "b", "c")]
    tensor = sp.Matrix(3, 3, lambda i, j: sp.Function(f"J{min(i, j)}{max(i, j)}")(u, v))
    unknown = SurfaceForms.unknown(u, v)
    functions = values_of(surface)
    for names, entries in (
        (unknown.support, surface.support),
        (axis, frame.T * sp.Matrix([0, 0, 1])),
        (tensor, frame.T * inertia * frame),
    ):
        pairs = zip(names, entries, strict=True)
        functions |= {x.func.__name__: ((u, v), entry) for x, entry in pairs}
    rules = unknown.rules((axis,), (tensor,))
    assert len(rules) == 3 + 2 * (3 + 3 + 6)
    for name_, value in rules.items():
        assert_equal([specialise(name_, functions)], [specialise(value, functions)])


def test_lines_that_are_not_lines_of_curvature_are_refused():
    with pytest.raises(DefinitionError, match="lines of curvature"):
        SurfaceForms.of(Surface((u, v), (u, v, u * v)))


def test_what_needs_a_position_says_so():
    unknown = SurfaceForms.unknown(u, v)
    contact = RollingContact(unknown, SurfaceForms.unknown(u1, v1, "_1"), theta)
    with pytest.raises(DefinitionError, match="no position in space"):
        _ = contact.attitude
    bare = SurfaceForms((u, v), unknown.first, unknown.second)
    with pytest.raises(DefinitionError, match="support"):
        _ = RollingContact(bare, contact.fixed, theta).arm
    with pytest.raises(DefinitionError, match="another coordinate"):
        RollingContact(unknown, SurfaceForms((u1, v1), (u, 1), (0, 0)), theta)


def test_contact_of_forms_is_contact_of_surfaces():
    pair = Surface.torus(R, r, u, v), Surface.sphere(R, u1, v1)
    explicit = RollingContact(*pair, theta)
    forms = RollingContact(*(SurfaceForms.of(x) for x in pair), theta)
    assert_equal(forms.spin, explicit.spin)
    assert_equal(forms.no_slip, explicit.no_slip)
    assert_equal(forms.centre_velocity, explicit.centre_velocity)


CONTACT = RollingContact(Surface.sphere(r, u, v), Surface.sphere(R, u1, v1), theta)
OFFSET = sp.Matrix(CONTACT.body.frame).T * sp.Matrix([0, 0, shift])
"""The mass centre of a ball that is not homogeneous, seen from its geometric centre."""


def ball_energy():
    centre = point_velocity(CONTACT.centre_velocity, CONTACT.spin, OFFSET)
    body = sp.Matrix(CONTACT.body.frame)
    return kinetic_energy(MASS, centre, body.T * sp.diag(I1, I1, I3) * body, CONTACT.spin)


def ball_functions():
    """The unknown functions of the general body, on the ball; gravity for the force function."""
    body = sp.Matrix(CONTACT.body.frame)
    inertia, arm = body.T * sp.diag(I1, I1, I3) * body, sp.Matrix(CONTACT.arm) - OFFSET
    found = values_of(CONTACT.body) | values_of(CONTACT.fixed, "_1")
    arms = zip(("rho_u", "rho_v", "epsilon"), arm, strict=True)
    axis = zip(("alpha''", "beta''", "gamma''"), body.row(2), strict=True)
    found |= {name: ((u, v), entry) for name, entry in (*arms, *axis)}
    found |= {f"J{i + 1}{j + 1}": ((u, v), inertia[i, j]) for i in range(3) for j in range(i, 3)}
    return found | {"U": (COORDINATES, -MASS * height())}


def height():
    """The mass centre's height, up to a constant."""
    centre = CONTACT.centre + sp.Matrix(CONTACT.fixed.frame) * CONTACT.turn * OFFSET
    return centre[2]


def ball_system(**more):
    return vo.System(
        name="ball",
        fibration=vo.Fibration(base=BASE, fibre=FIBRE),
        constraints=CONTACT.no_slip,
        parameters=(MASS, R, r, shift, I1, I3, k),
        **more,
    )


@pytest.fixture(scope="module")
def body():
    return Body.derive()


@pytest.fixture(scope="module")
def gyroscope():
    return WithGyroscope.derive()


def residuals(eqs):
    dots = sp.Matrix([velocity(w) for w in eqs.velocities])
    return list(eqs.mass * dots - eqs.force)


def test_general_momenta_and_equations_are_those_of_a_ball_with_offset(body):
    eqs = vo.derive(ball_system(lagrangian=ball_energy() - MASS * height()))
    functions = ball_functions()
    assert_equal([specialise(x, functions) for x in body.momenta], eqs.momenta)
    assert_equal([specialise(x, functions) for x in body.residuals], residuals(eqs))


def test_deltas_are_what_the_equations_hold(body):
    (lu, lv), dots = body.roots[0], DOTS
    held = (
        -sp.diff(body.along[0, 1], dots[1]) / (lu * lv),
        -sp.diff(body.along[0, 0], dots[1]) / (lu * lv),
    )
    assert_equal(held, body.deltas)


def test_balance_of_moments_is_the_engines_in_the_frame_of_quasi_velocities(gyroscope):
    """The engine in the frame (s, tau, n), the rotor as Routh's term: a route of its own."""
    axis = sp.Matrix(CONTACT.body.frame).row(2)
    lagrangian = ball_energy() - MASS * height() + axial_rotor(k, axis, CONTACT.spin)
    frame = vo.Frame.quasi(dict(zip(QUASI, CONTACT.spin, strict=True)))
    eqs = vo.derive(ball_system(lagrangian=lagrangian, frame=frame))
    functions, motion = ball_functions(), gyroscope.surfaces.motion
    spin = [specialise(x, functions) for x in gyroscope.spin]
    dots = motion.derivative(gyroscope.spin).xreplace(gyroscope.rules)
    at = dict(zip(QUASI, spin, strict=True))
    at |= {velocity(w): specialise(x, functions) for w, x in zip(QUASI, dots, strict=True)}
    at_k = {SPEED: k / AXIAL, CLIMB: sp.Integer(0)}
    rows = [specialise(x, functions).xreplace(at_k) for x in gyroscope.rows]
    assert_equal(rows, [x.xreplace(at) for x in residuals(eqs)])


def test_the_relative_curvature_of_a_plane_on_a_plane_vanishes(body):
    surfaces = body.surfaces
    flat = dict.fromkeys((x for f in surfaces.forms for x in f.second), sp.Integer(0))
    assert surfaces.curvature.xreplace(flat) == 0
    assert surfaces.dependent().proved

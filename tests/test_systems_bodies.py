"""Rolling bodies: their claims hold and say something, as in the coordinates of Neumann."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib import import_module

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec import Equation, Measure, prove_equal, velocity
from voronec.equations.motions import Motions
from voronec.equations.program import Program, compile_program
from voronec.equations.staged_equations import staged_form
from voronec.kinematics import ConvexBody, RollingContact, Surface, SurfaceForms, kinetic_energy
from voronec.proof.claims import check_claims
from voronec.proof.relations.decision import check_relation

pytestmark = pytest.mark.slow

ELLIPSOIDS = (
    "ellipsoid-on-plane",
    "gyroscopic-ellipsoid-on-plane",
    "ellipsoid-on-sphere",
    "gyroscopic-ellipsoid-on-sphere",
)
SPHEROIDS = (
    "spheroid-on-plane",
    "gyroscopic-spheroid-on-plane",
    "spheroid-on-sphere",
    "gyroscopic-spheroid-on-sphere",
)
TORI = ("torus-on-ellipsoid", "gyroscopic-torus-on-ellipsoid")
MOVING = ("bychkov-ball", "ball-on-free-sphere")
GENERAL = ("rolling-body", "gyroscopic-rolling-body", "symmetric-body-on-sphere")
BODIES = (*ELLIPSOIDS, *SPHEROIDS, *TORI, *MOVING, *GENERAL, "displaced-ball-on-sphere")

gamma, omega, height = sp.symbols("gamma1:4"), sp.symbols("omega1:4"), sp.Symbol("height")
u, v, theta, u1, v1 = sp.symbols("u v theta u1 v1")
s, tau, n = quasi = sp.symbols("s tau n")
a, b, c, R1 = sp.symbols("a b c R1")


def module(name):
    return import_module(f"voronec.systems.{name.replace('-', '_')}")


@cache
def motions(name):
    return Motions.of(vo.load(name))


RELATIONS = {r.label: r for name in BODIES for r in getattr(module(name), "RELATIONS", ())}


def verdict_on(system, **claims):
    """The verdict on one claim about a system, without its own claims."""
    bare = replace(
        system, integrals={}, equations={}, measure=None, essential=(), cases={}, integrable=""
    )
    kind = next(iter(claims)).removesuffix("s")
    return next(c for c in check_claims(replace(bare, **claims)) if c.kind == kind).verdict


def test_the_momentum_about_the_vertical_is_no_integral_of_an_ellipsoid():
    system = vo.load("ellipsoid-on-plane")
    momentum = sp.Matrix(system.equations["momentum"].function)
    claim = {"vertical momentum": momentum.dot(sp.Matrix(gamma))}
    assert verdict_on(system, integrals=claim).refuted


def test_the_contact_moves_over_the_body_and_that_counts():
    system = vo.load("ellipsoid-on-plane")
    momentum = sp.Matrix(system.equations["momentum"].function)
    weight = sp.Matrix(system.equations["momentum"].rate).diff(sp.Symbol("g")) * sp.Symbol("g")
    still = momentum.cross(sp.Matrix(omega)) + weight
    claim = {"momentum": Equation(tuple(momentum), tuple(still))}
    assert verdict_on(system, equations=claim).refuted


@pytest.mark.parametrize("name", ELLIPSOIDS)
def test_an_ellipsoid_of_three_axes_has_not_the_measure_of_one_of_revolution(name):
    system = vo.load(name)
    rolling = module(name).rolling
    density = rolling.density * (
        rolling.body.curvature_product(R1) if name.endswith("sphere") else 1
    )
    claim = Measure(density, (*gamma, height, *omega))
    assert verdict_on(system, measure=claim).refuted


@pytest.mark.parametrize("name", [name for name in SPHEROIDS if name.endswith("sphere")])
def test_the_measure_of_a_spheroid_on_a_sphere_is_not_that_on_a_plane(name):
    claim = Measure(module(name).rolling.density, (*gamma, height, *omega))
    assert verdict_on(vo.load(name), measure=claim).refuted


@pytest.mark.parametrize(
    ("target", "carried"),
    [
        ("spheroid-on-plane", {"energy", "momentum", "normal", "linear", "density"}),
        ("symmetric-body-on-sphere", {"energy", "momentum", "linear", "second order", "nutation"}),
        ("ellipsoid-on-sphere", {"energy", "momentum", "normal"}),
        ("rolling-body", {"energy", "momentum"}),
    ],
)
def test_a_spheroid_on_a_sphere_is_one_of_the_general_bodies(target, carried):
    found = check_relation(RELATIONS[f"spheroid-on-sphere -> {target}"], motions)
    assert found.verdict.proved
    assert {c.name for c in found.pulled if c.verdict.proved} == carried


def test_the_measure_on_a_sphere_holds_the_radii_of_curvature():
    system = vo.load("symmetric-body-on-sphere")
    claim = system.measure.density / module("symmetric-body-on-sphere").spread
    assert verdict_on(system, measure=claim * sp.sin(u)).refuted


def test_the_energy_of_a_ball_on_a_turning_sphere_changes():
    system = vo.load("bychkov-ball")
    assert verdict_on(system, integrals={"energy": module("bychkov-ball").energy}).refuted


def test_the_linear_integrals_of_the_displaced_ball_stay_along_its_motion():
    system = vo.load("displaced-ball-on-sphere")
    claims = system.cases["oblate"].integrals
    motion = vo.integrate(system, scene="default", outputs=(*gamma, *omega))
    constants = {p.symbol: p.value for p in system.parameters}
    for claim in claims.values():
        function = sp.lambdify((*gamma, *omega), claim.subs(constants))
        values = function(*(motion[str(x)] for x in (*gamma, *omega)))
        assert np.ptp(values) < 1e-9 * np.abs(values).max()


def neumann_torus():
    """The torus on the ellipsoid in Neumann's five coordinates, as the book has it."""
    R, r, m, A, C = sp.symbols("R r m A C")
    w = sp.sqrt(sp.sin(u1) ** 2 + (c / a) ** 2 * sp.cos(u1) ** 2)
    reach = a * sp.sin(u1) / w
    position = (reach * sp.cos(v1), reach * sp.sin(v1), c**2 / a * sp.cos(u1) / w)
    fixed = Surface((u1, v1), position, (c**2 / (a * w**3), reach))
    contact = RollingContact(Surface.torus(R, r, u, v), fixed, theta)
    kinetic = kinetic_energy(m, contact.centre_velocity, (A, A, C), contact.angular_velocity)
    return vo.System(
        name="neumann-torus",
        fibration=vo.Fibration(base=(u, v, theta), fibre=(u1, v1)),
        frame=vo.Frame.quasi(dict(zip(quasi, contact.spin, strict=True))),
        lagrangian=kinetic,
        constraints=contact.no_slip,
        parameters=(R, r, a, c, m, A, C),
    )


def test_a_contact_carried_along_moves_as_in_the_coordinates_of_neumann():
    carried = vo.load("torus-on-ellipsoid")
    constants = {p.symbol: p.value for p in carried.parameters}
    axes = {u: 1, v: sp.Rational(1, 2), theta: sp.Rational(2, 3), v1: sp.Rational(1, 3)}
    place = {**axes, u1: sp.Rational(6, 5), s: 1, tau: sp.Rational(-1, 2), n: 2}
    slant = sp.sqrt(sp.sin(place[u1]) ** 2 + sp.Rational(4, 9) * sp.cos(place[u1]) ** 2)
    others = {"phi": 1, "chi": 1, "psi": 1, "o1": 3, "o2": 1, "o3": 2, "w": slant.n(60)}
    short = vo.derive(neumann_torus()).acceleration({**constants, **place}, 25)
    long = motions("torus-on-ellipsoid").equations.acceleration({**place, **others}, 25)
    for q in (u, v, theta, u1, v1):
        assert abs(short[q] - long[q]) < 1e-20 * (1 + abs(short[q]))


@pytest.mark.parametrize("name", ["ellipsoid-on-plane", "bychkov-ball"])
def test_quasi_velocities_in_constraints_are_read_in_the_lean_form_too(name):
    raw = motions(name).equations.raw
    results = []
    for form in (raw.form, staged_form(raw)):
        derivative, _ = compile_program(Program.of(form))
        system = raw.definition.system
        state = np.linspace(0.4, 0.9, len(system.coordinates) + len(system.velocities))
        values = [float(p.value) for p in system.parameters]
        results.append(np.array(derivative(0.0, list(state), values), dtype=float))
    assert np.allclose(*results, rtol=1e-12)


def test_the_velocities_of_a_rolling_contact_meet_the_constraints_and_the_spin():
    w = sp.sqrt(a**2 * sp.sin(u1) ** 2 + c**2 * sp.cos(u1) ** 2)
    forms = SurfaceForms.revolution(u1, v1, (a**2 * c**2 / w**3, a**2 / w))
    contact = RollingContact(Surface.torus(b, R1, u, v), forms, theta)
    known = {velocity(q): rate for q, rate in contact.rolling_velocities(quasi).items()}
    for claim, meant in zip((*contact.no_slip, *contact.spin), (0, 0, *quasi), strict=True):
        assert prove_equal(claim.xreplace(known), meant).proved


def test_coordinates_off_the_lines_of_curvature_are_refused():
    skew = Surface((u1, v1), (u1 + v1 / 2, v1, u1**2))
    with pytest.raises(vo.DefinitionError, match="lines of curvature"):
        RollingContact(Surface.sphere(a, u, v), skew, theta).rolling_velocities(quasi)


def test_forms_by_the_radii_of_curvature_are_those_of_the_surface():
    w = sp.sqrt(a**2 * sp.sin(u) ** 2 + c**2 * sp.cos(u) ** 2)
    profile = (a**2 * sp.sin(u) / w, c**2 * sp.cos(u) / w)
    surface = Surface(
        (u, v),
        (profile[0] * sp.cos(v), profile[0] * sp.sin(v), profile[1]),
        (a**2 * c**2 / w**3, profile[0]),
    )
    forms = SurfaceForms.revolution(u, v, (a**2 * c**2 / w**3, a**2 / w))
    for part in ("first_form", "second_form", "trace_velocity", "frame_rates"):
        for x, y in zip(getattr(surface, part), getattr(forms, part), strict=True):
            assert prove_equal(x, y).proved


def test_an_ellipsoid_is_touched_where_its_normal_is():
    normal = sp.Matrix(gamma)
    level = sp.sqrt(sum((q * g) ** 2 for q, g in zip((a, b, c), gamma, strict=True)))
    body = ConvexBody.ellipsoid((a, b, c), gamma, level)
    on_it = sum((r / q) ** 2 for r, q in zip(body.arm, (a, b, c), strict=True))
    assert prove_equal(on_it, 1).proved
    gradient = sp.Matrix([r / q**2 for r, q in zip(body.arm, (a, b, c), strict=True)])
    assert all(prove_equal(x).proved for x in gradient.cross(normal))
    slopes = body.arm.jacobian(normal)
    assert all(prove_equal(x + y).proved for x, y in zip(slopes, body.radii, strict=True))


def test_a_ball_turns_its_normal_by_epsilon():
    gone = sum(g**2 for g in gamma) - 1
    ball = ConvexBody.ellipsoid((a, a, a), gamma, a)
    turned = ball.rolling_rate(omega, R1)
    meant = R1 / (R1 + a) * sp.Matrix(gamma).cross(sp.Matrix(omega))
    for x, y in zip(turned, meant, strict=True):
        assert prove_equal(x, y, relations=(gone,)).proved

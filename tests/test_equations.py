"""Equations whose answer is known by hand: redundant coordinates, chart edges, numbers."""

from __future__ import annotations

import decimal
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

import voronec as vo
from voronec import DefinitionError, Fibration, Frame, System, prove_equal, time, velocity
from voronec.motion.explanation import model_text

Q = sp.Rational
x, y, z, s, phi, theta = sp.symbols("x y z s phi theta")
Dx, Dy, Dz, Ds, Dphi, Dtheta = map(velocity, (x, y, z, s, phi, theta))
v, w, g, k = sp.symbols("v w g k")
f = sp.Function("f")


def agree(system, point, digits=30):
    ours = vo.derive(system).acceleration(point, digits=digits)
    theirs = vo.multiplier_acceleration(system, point, digits=digits)
    size = 1 + max(abs(a) for a in theirs.values())
    assert list(ours) == list(theirs)
    for name in theirs:
        assert abs(ours[name] - theirs[name]) <= size * Q(10) ** (2 - digits), (ours, theirs)


q = sp.symbols("q0:4")
omega = sp.symbols("omega1:4")
inertia = (2, 3, 5)


def body_turn():
    """The angular velocity in the body, 2 conj(q) qdot."""
    a, b, c, d = q
    p, r, t, u = map(velocity, q)
    return (
        2 * (a * r - b * p - c * u + d * t),
        2 * (a * t - c * p - d * r + b * u),
        2 * (a * u - d * p - b * t + c * r),
    )


def space_rotation():
    a, b, c, d = q
    return sp.Matrix(
        [
            [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
        ]
    )


SPHERE = sum(c**2 for c in q) - 1
FREE = System(
    name="body",
    fibration=Fibration(q, relations=(SPHERE,)),
    frame=Frame.quasi(dict(zip(omega, body_turn(), strict=True))),
    lagrangian=sum(i * u**2 for i, u in zip(inertia, body_turn(), strict=True)) / 2,
)
ORIENTATIONS = [
    (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, -1), (Q(3, 5), 0, Q(4, 5), 0),
    (Q(1, 10), Q(1, 2), -Q(1, 2), Q(7, 10)),
]  # fmt: skip
TURN = dict(zip(omega, (1, Q(-2, 3), 3), strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("at", ORIENTATIONS, ids=str)
def test_a_quaternion_has_no_chart_edge(at):
    agree(FREE, dict(zip(q, at, strict=True)) | TURN)


def test_a_rigid_body_in_quaternions_obeys_euler():
    eqs = vo.derive(FREE)
    turn = sp.Matrix(omega)
    tensor = sp.diag(*inertia)
    for found, expected in zip(
        [*eqs.mass, *eqs.force], [*tensor, *(tensor * turn).cross(turn)], strict=True
    ):
        assert prove_equal(found, expected, (SPHERE,)).proved
    # d omega = -(1/2)[omega, omega]: [h_1, h_2] = -h_3 or h_3 by orientation, never a function
    assert [abs(eqs.brackets.c[2, 0, 1]), eqs.brackets.c[0, 0, 1]] == [1, 0]
    assert eqs.kind == "holonomic" and eqs.growth == (3,)
    assert eqs.force.free_symbols <= set(omega) and eqs.mass.free_symbols == set()


@pytest.mark.slow
def test_a_ball_in_quaternions_rolls_with_growth_three_five():
    spin = space_rotation() * sp.Matrix(body_turn())
    system = System(
        name="ball",
        fibration=Fibration(q, (x, y), relations=(SPHERE,)),
        frame=FREE.frame,
        lagrangian=(Dx**2 + Dy**2) / 2 + sum(u**2 for u in body_turn()) / 5,
        constraints=(Dx - spin[1], Dy + spin[0]),
    )
    eqs = vo.derive(system)
    assert eqs.growth == (3, 5) and eqs.kind == "chaplygin" and eqs.integrable == ()
    for at in ORIENTATIONS:
        agree(system, dict(zip(q, at, strict=True)) | TURN | {x: 0, y: 0})


def test_what_turns_on_a_redundant_circle_is_holonomic():
    """One degree of freedom is always integrable, whatever the ambient curvature."""
    system = System(
        name="circle",
        fibration=Fibration((x, y), (s,), relations=(x**2 + y**2 - 1,)),
        frame=Frame.quasi({w: x * Dy - y * Dx}),
        lagrangian=(Dx**2 + Dy**2 + Ds**2) / 2,
        constraints=(Ds - (x * Dy - y * Dx),),
    )
    eqs = vo.derive(system)
    assert eqs.kind == "holonomic" and eqs.growth == (1,) and len(eqs.integrable) == 1
    for at in ((1, 0), (0, 1), (Q(3, 5), Q(-4, 5))):
        agree(system, {x: at[0], y: at[1], s: 0, w: 2})


R = sp.Matrix(3, 3, sp.symbols("r1:4(1:4)"))
SPIN = R.T * R.applyfunc(velocity)
ENTRIES = System(
    name="entries",
    fibration=Fibration(
        tuple(R),
        relations=tuple((R.T * R - sp.eye(3))[i, j] for i in range(3) for j in range(i + 1)),
    ),
    frame=Frame.quasi(dict(zip(omega, (SPIN[2, 1], SPIN[0, 2], SPIN[1, 0]), strict=True))),
    lagrangian=sum(
        i * u**2 for i, u in zip(inertia, (SPIN[2, 1], SPIN[0, 2], SPIN[1, 0]), strict=True)
    ) / 2,
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("at", ORIENTATIONS[:2] + ORIENTATIONS[-1:], ids=str)
def test_rotation_matrix_entries_have_no_chart_edge(at):
    rotation = space_rotation().xreplace(dict(zip(q, map(sp.sympify, at), strict=True)))
    agree(ENTRIES, dict(zip(R, rotation, strict=True)) | TURN)


def test_the_spherical_pendulum_in_three_coordinates():
    system = System(
        name="pendulum",
        fibration=Fibration((x, y), (z,), relations=(x**2 + y**2 + z**2 - 1,)),
        lagrangian=(Dx**2 + Dy**2 + Dz**2) / 2 - g * z,
        parameters=(g,),
    )
    eqs = vo.derive(system)
    assert eqs.kind == "holonomic" and eqs.growth == (2,)
    agree(system, {x: Q(2, 7), y: Q(3, 7), z: Q(-6, 7), Dx: 1, Dy: Q(1, 3), g: 9})
    with pytest.raises(DefinitionError, match="does not satisfy the relation"):
        eqs.acceleration({x: 1, y: 1, z: 1, Dx: 0, Dy: 0, g: 1})


def test_a_circle_that_grows_moves_what_runs_on_it():
    system = System(
        name="growing",
        fibration=Fibration((x, y), relations=(x**2 + y**2 - (1 + time) ** 2,)),
        frame=Frame.quasi({w: x * Dy - y * Dx}),
        lagrangian=(Dx**2 + Dy**2) / 2 - g * y,
        parameters=(g,),
    )
    agree(system, {x: Q(6, 5), y: Q(-8, 5), w: Q(2, 3), g: 3, time: 1})


def disc(first, second):
    ahead = sp.cos(phi) * Dx + sp.sin(phi) * Dy - 2 * Dtheta
    aside = sp.sin(phi) * Dx - sp.cos(phi) * Dy
    pair = {"ahead": ahead, "aside": aside}
    return System(
        name="disc",
        fibration=Fibration((phi, theta), (x, y)),
        lagrangian=(Dx**2 + Dy**2) / 2 + Dphi**2 + Dtheta**2,
        constraints=(pair[first], pair[second]),
    )


@pytest.mark.parametrize("order", [("ahead", "aside"), ("aside", "ahead")])
@pytest.mark.parametrize("heading", [0, Q(1, 3), sp.pi / 2, sp.pi, -sp.pi / 2])
def test_a_disc_has_accelerations_at_every_heading(order, heading):
    """The constraints determine xdot, ydot at every phi, whichever pivot generic points liked."""
    agree(disc(*order), {phi: heading, theta: 0, x: 0, y: 0, Dphi: 1, Dtheta: 2})


@pytest.mark.parametrize("heading", [0, sp.pi / 2, sp.pi])
def test_a_sleigh_with_quasi_velocities_has_accelerations_at_every_heading(heading):
    system = System(
        name="sleigh",
        fibration=Fibration((x, phi), (y,)),
        frame=Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
        lagrangian=(Dx**2 + Dy**2) / 2 + Dphi**2,
        constraints=(Dy * sp.cos(phi) - Dx * sp.sin(phi),),
    )
    agree(system, {phi: heading, x: 0, y: 0, v: 1, w: 2})


def test_where_the_chart_really_ends_the_error_says_so():
    system = System(
        name="sphere",
        fibration=Fibration((theta, phi)),
        lagrangian=(Dtheta**2 + sp.sin(theta) ** 2 * Dphi**2) / 2,
    )
    with pytest.raises(DefinitionError, match="singular") as caught:
        vo.derive(system).acceleration({theta: 0, phi: 0, Dtheta: 1, Dphi: 1})
    assert "\n" not in str(caught.value)


with mp.workdps(60):
    THIRD = mp.mpf(1) / 3
NUMBERS = {
    "int": (2, 2), "float": (0.1, Q(0.1)), "fraction": (Fraction(1, 3), Q(1, 3)),
    "ratio": ("1/3", Q(1, 3)), "decimal": ("0.1", Q(1, 10)), "root": (sp.sqrt(2), sp.sqrt(2)),
    "pi": (sp.pi, sp.pi), "long mpf": (THIRD, Q(1, 3)), "sympy": (sp.Float("0.1", 60), Q(1, 10)),
    "numpy": (np.float64(0.5), Q(1, 2)), "numpy int": (np.int64(3), 3),
    "Decimal": (decimal.Decimal("0.1"), Q(1, 10)),
}  # fmt: skip


def fall(force=k):
    return System(
        name="fall", fibration=Fibration((x,)), lagrangian=Dx**2 / 2 + force * x, parameters=(k,)
    )


@pytest.mark.parametrize(("given", "meant"), NUMBERS.values(), ids=NUMBERS)
def test_numbers_are_taken_exactly_whatever_their_kind(given, meant):
    found = vo.derive(fall()).acceleration({x: 1, Dx: 0, k: given}, digits=50)[x]
    assert abs(found - sp.sympify(meant).evalf(60)) < Q(1, 10**48)


BAD = ["wide", "", None, [1], 1j, sp.I, float("nan"), float("inf"), sp.nan, sp.oo, sp.Symbol("h")]


@pytest.mark.parametrize("given", BAD, ids=repr)
def test_what_is_no_number_is_refused_and_named(given):
    with pytest.raises(DefinitionError, match="k") as caught:
        vo.derive(fall()).acceleration({x: 1, Dx: 0, k: given})
    assert "\n" not in str(caught.value) and "mass matrix" not in str(caught.value)


@pytest.mark.parametrize("digits", [0, -3, 2.5, "30", None])
def test_digits_must_be_a_positive_whole_number(digits):
    with pytest.raises(DefinitionError, match="digits"):
        vo.derive(fall()).acceleration({x: 1, Dx: 0, k: 1}, digits=digits)


@pytest.mark.parametrize("point", [5, None, [1], {x: 1, "x": 2, Dx: 0, k: 1}, {x: 1}, {}])
def test_a_point_that_is_none_is_refused(point):
    with pytest.raises(DefinitionError):
        vo.derive(fall()).acceleration(point)


def test_absolute_values_are_differentiated_away_from_zero():
    system = System(
        name="wedge",
        fibration=Fibration((x,)),
        lagrangian=Dx**2 / 2 - 3 * sp.Abs(x),
        forces={x: -sp.sign(Dx)},
    )
    agree(system, {x: -2, Dx: 1})
    assert abs(vo.derive(system).acceleration({x: 2, Dx: -4})[x] + 2) < sp.Float(10) ** -28


def test_roots_of_quotients_survive_the_normal_form():
    system = fall(sp.sqrt(k / (k - 9)) * sp.cos(x) ** 2 + sp.sqrt(k / (k - 9)) * sp.sin(x) ** 2)
    eqs = vo.derive(system)
    found = (eqs.force[0] / eqs.mass[0]).xreplace({x: Q(1, 3), k: Q(2), Dx: Q(0)})
    assert found.has(sp.I) or prove_equal(eqs.force[0], sp.sqrt(k / (k - 9))).proved
    agree(system, {x: Q(1, 3), Dx: 0, k: 12})
    value = eqs.force[0].xreplace({k: sp.Integer(12), x: Q(1, 3)}).evalf(20)
    assert abs(value - 2) < 1e-15


def test_dynamicsymbols_and_unknown_functions_pass_the_door_both_ways():
    p, r, a = dynamicsymbols("p r alpha")
    system = System(
        name="dynamic",
        fibration=Fibration((p, a), (r,)),
        lagrangian=(p.diff(time) ** 2 + r.diff(time) ** 2 + a.diff(time) ** 2) / 2 - f(2 * p),
        constraints=(r.diff(time) - sp.tan(a) * p.diff(time),),
        forces={p: f(p**2).diff(p) + f(3 * p).diff(p)},
    )
    eqs = vo.derive(system)
    slope = sp.Symbol("slope")
    own = f(p**2).diff(p) + f(3 * p).diff(p) - f(2 * p).diff(p)
    expected = own - sp.sin(a) / sp.cos(a) ** 3 * a.diff(time) * p.diff(time)
    assert prove_equal(eqs.force[0] + slope, expected + slope).proved
    assert eqs.velocities == (p.diff(time), a.diff(time))


def row(count, ahead):
    """A car and what it draws, each on wheels that do not slip; hinges stand one length ahead of
    the wheels of what is behind, and ``ahead`` lengths behind those of what is before."""
    angles, lengths = sp.symbols(f"theta0:{count + 1}"), sp.symbols(f"l1:{count + 1}")
    masses, moments = sp.symbols(f"m0:{count + 1}"), sp.symbols(f"J0:{count + 1}")
    turns, pace, kinetic, constraints = [*map(velocity, angles)], (Dx, Dy), 0, []
    for i, (angle, turn) in enumerate(zip(angles, turns, strict=True)):
        if i:
            arms = ((angles[i - 1], turns[i - 1], ahead), (angle, turn, 1))
            pace = (
                pace[0] + lengths[i - 1] * sum(n * sp.sin(a) * t for a, t, n in arms),
                pace[1] - lengths[i - 1] * sum(n * sp.cos(a) * t for a, t, n in arms),
            )
        kinetic += (masses[i] * (pace[0] ** 2 + pace[1] ** 2) + moments[i] * turn**2) / 2
        constraints.append(pace[0] * sp.sin(angle) - pace[1] * sp.cos(angle))
    return System(
        name="row", fibration=Fibration((x, angles[0]), (y, *angles[1:])), lagrangian=kinetic,
        frame=Frame.quasi({v: Dx * sp.cos(angles[0]) + Dy * sp.sin(angles[0]), w: turns[0]}),
        constraints=tuple(constraints), parameters=(*masses, *moments, *lengths),
    )  # fmt: skip


@pytest.mark.slow
def test_equations_of_vehicles_in_a_row_grow_evenly_with_their_number():
    sizes = []
    for count in (2, 3, 4):
        eqs = vo.derive(row(count, ahead=0))
        assert eqs.in_normal_form and eqs.operations < eqs.raw.form.operations / 4
        sizes.append(eqs.operations)
    steps = np.diff(sizes)
    assert all(steps > 0) and max(steps) < 2 * min(steps)
    point = {s: Q(i + 2, 7 + i) for i, s in enumerate([*eqs.coordinates, *eqs.velocities])}
    point |= {p.symbol: Q(i + 4, 5) for i, p in enumerate(eqs.system.parameters)}
    moving = eqs.mass.LUsolve(eqs.force).xreplace(point)
    rate = {q: e.xreplace(point) for q, e in zip(eqs.coordinates, eqs.rates, strict=True)}
    theirs = vo.multiplier_acceleration(eqs.system, point, 30)
    for q in eqs.coordinates:
        own = eqs.rates[eqs.coordinates.index(q)]
        slopes = [own.diff(u).xreplace(point) * e for u, e in rate.items()]
        slopes += [own.diff(u).xreplace(point) * e for u, e in zip((v, w), moving, strict=True)]
        assert abs(sum(slopes).evalf(30) - theirs[q]) < 1e-25


@pytest.mark.slow
def test_what_normal_forms_make_longer_is_left_as_it_is():
    for count in (2, 4):
        eqs = vo.derive(row(count, ahead=1))
        assert eqs.operations <= eqs.raw.form.operations
    assert "terms, more than its budget" in eqs.limit
    assert eqs.limit in " ".join(model_text(vo.explain(eqs.system, outputs=(v,))).split())


TURN_MATRIX = sp.Matrix(3, 3, sp.symbols("r1:4(1:4)"))
ORTHOGONAL = TURN_MATRIX.T * TURN_MATRIX - sp.eye(3)


def matrix_turn():
    """The angular velocity in the body, R^T Rdot, by the nine entries of the rotation."""
    spin = TURN_MATRIX.T * TURN_MATRIX.applyfunc(velocity)
    return spin[2, 1], spin[0, 2], spin[1, 0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("turn", "places", "raw"),
    [
        (body_turn(), Fibration(q[:3], q[3:], relations=(SPHERE,)), 1000),
        (matrix_turn(), Fibration((*TURN_MATRIX,)[1:], (*TURN_MATRIX,)[:1], relations=tuple(
            ORTHOGONAL[i, j] for i in range(3) for j in range(i, 3)
        )), 400),
    ],
    ids=["quaternions", "nine entries"],
)  # fmt: skip
def test_the_program_of_suslov_is_as_short_as_its_equations(turn, places, raw):
    p, r = sp.symbols("p r")
    system = System(
        name="suslov", fibration=places,
        lagrangian=sum(i * e**2 for i, e in zip(inertia, turn, strict=True)) / 2
        + turn[0] * turn[2] + turn[1] * turn[2],
        constraints=(turn[2],), frame=Frame.quasi({p: turn[0], r: turn[1]}),
    )  # fmt: skip
    eqs = vo.derive(system)
    assert eqs.mass == sp.diag(2, 3) and eqs.raw.form.operations > raw
    assert prove_equal(eqs.force[0], -r * (p + r)).proved
    assert eqs.operations < 40 and len(eqs.python().splitlines()) < 40

"""Lagrange-d'Alembert with multipliers, against answers derived by hand."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import mpmath as mp
import pytest
import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

import voronec as vo
from voronec import DefinitionError, Fibration, Frame, Parameter, System, velocity
from voronec.equations.referee import multiplier_acceleration, reaction_forces

pytestmark = pytest.mark.slow

x, y, z, phi, theta, psi = sp.symbols("x y z phi theta psi")
m, g, a, J, R, length = sp.symbols("m g a J R l")
v, w = sp.symbols("v w")
Dx, Dy, Dz, Dphi, Dtheta, Dpsi = map(velocity, (x, y, z, phi, theta, psi))
Q = sp.Rational


def close(value, expected, digits=29):
    """Equal to that many digits, relative, or both zero."""
    expected = sp.sympify(expected).evalf(digits + 15)
    return abs(value - expected) <= abs(expected) * Q(10) ** -digits


def sleigh(**options):
    centre = (Dx - a * sp.sin(phi) * Dphi, Dy + a * sp.cos(phi) * Dphi)
    return System(
        name="sleigh",
        fibration=Fibration(base=(x, phi), fibre=(y,)),
        frame=Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
        lagrangian=m * (centre[0] ** 2 + centre[1] ** 2) / 2 + J * Dphi**2 / 2,
        constraints=(Dy * sp.cos(phi) - Dx * sp.sin(phi),),
        parameters=(Parameter(m, 2), Parameter(J, Q(1, 3)), Parameter(a, Q(1, 5))),
        **options,
    )


SLEIGH_POINT = {x: 1, y: -2, phi: Q(3, 7), v: Q(5, 4), w: Q(-2, 3)}


def sleigh_rates(force=0, torque=0):
    """vdot = a w^2 + F/m,  wdot = (M - m a v w) / (J + m a^2)."""
    speed, turn = SLEIGH_POINT[v], SLEIGH_POINT[w]
    vdot = Q(1, 5) * turn**2 + Q(force) / 2
    return speed, turn, vdot, (torque - 2 * Q(1, 5) * speed * turn) / (Q(1, 3) + 2 * Q(1, 25))


def test_sleigh_moves_as_its_closed_form_says():
    speed, turn, vdot, wdot = sleigh_rates()
    angle = SLEIGH_POINT[phi]
    found = multiplier_acceleration(sleigh(), SLEIGH_POINT)
    assert list(found) == [x, phi, y]
    assert close(found[phi], wdot)
    assert close(found[x], vdot * sp.cos(angle) - speed * turn * sp.sin(angle))
    assert close(found[y], vdot * sp.sin(angle) + speed * turn * sp.cos(angle))


def test_sleigh_knife_carries_the_lateral_acceleration_of_the_centre_of_mass():
    speed, turn, _, wdot = sleigh_rates()
    angle = SLEIGH_POINT[phi]
    lateral = 2 * (Q(1, 5) * wdot + speed * turn)
    found = reaction_forces(sleigh(), SLEIGH_POINT)
    assert close(found.multipliers[0], lateral)
    assert found.relation_multipliers == ()
    assert close(found.generalized[x], -lateral * sp.sin(angle))
    assert close(found.generalized[y], lateral * sp.cos(angle))
    assert found.generalized[phi] == 0


def test_forces_may_depend_on_quasi_velocities():
    drag = -Q(3, 2) * v
    system = sleigh(forces={x: drag * sp.cos(phi), y: drag * sp.sin(phi), phi: -(w**3)})
    speed, turn, vdot, wdot = sleigh_rates(-Q(3, 2) * Q(5, 4), Q(2, 3) ** 3)
    angle = SLEIGH_POINT[phi]
    found = multiplier_acceleration(system, SLEIGH_POINT)
    assert close(found[phi], wdot)
    assert close(found[x], vdot * sp.cos(angle) - speed * turn * sp.sin(angle))


def test_vertical_disc_rolls_uniformly_and_its_reactions_turn_the_centre():
    system = System(
        name="disc",
        fibration=Fibration(base=(phi, theta), fibre=(x, y)),
        lagrangian=m * (Dx**2 + Dy**2) / 2 + J * Dtheta**2 / 2 + a * Dphi**2 / 2,
        constraints=(Dx - R * sp.cos(phi) * Dtheta, sp.Eq(Dy, R * sp.sin(phi) * Dtheta)),
        parameters=(m, J, a, R),
    )
    point = {phi: Q(2, 3), theta: 0, x: 0, y: 0, Dphi: Q(1, 2), Dtheta: 3}
    point |= {"m": 2, "J": 1, "a": 1, "R": Q(1, 4)}
    found = multiplier_acceleration(system, point)
    push = reaction_forces(system, point)
    across = Q(1, 4) * 3 * Q(1, 2)
    assert found[phi] == 0 and found[theta] == 0
    assert close(found[x], -across * sp.sin(Q(2, 3)))
    assert close(found[y], across * sp.cos(Q(2, 3)))
    assert close(push.multipliers[0], -2 * across * sp.sin(Q(2, 3)))
    assert close(push.multipliers[1], 2 * across * sp.cos(Q(2, 3)))
    assert push.generalized[theta] == 0


CIRCLE = x**2 + y**2 - length**2


def pendulum(relations=(), constraints=(), frame=None):
    return System(
        name="pendulum",
        fibration=Fibration(base=(x,), fibre=(y,), relations=relations),
        lagrangian=m * (Dx**2 + Dy**2) / 2 - m * g * y,
        constraints=constraints,
        frame=frame,
        parameters=(Parameter(m, 3), Parameter(g, Q(49, 5)), Parameter(length, 5)),
    )


# At (3, -4) with angular velocity 1/2: the velocity is (2, 3/2).
PENDULUM_POINT = {x: 3, y: -4, Dx: 2}
ANGULAR = -Q(49, 5) / 5 * Q(3, 5)
TENSION = 3 * Q(49, 5) * Q(4, 5) + 3 * 5 * Q(1, 4)


@pytest.mark.parametrize(
    "system",
    [
        pendulum(relations=(CIRCLE,)),
        pendulum(constraints=(x * Dx + y * Dy,)),
        pendulum(relations=(CIRCLE,), constraints=(x * Dx + y * Dy,)),
        pendulum(relations=(CIRCLE, CIRCLE * (x + 7))),
    ],
    ids=["relation", "constraint", "both", "relation twice"],
)
def test_pendulum_in_redundant_coordinates_is_the_pendulum_of_the_angle(system):
    found = multiplier_acceleration(system, PENDULUM_POINT)
    assert close(found[x], 4 * ANGULAR - 3 * Q(1, 4))
    assert close(found[y], 3 * ANGULAR + 4 * Q(1, 4))
    push = reaction_forces(system, PENDULUM_POINT).generalized
    assert close(push[x], -TENSION * Q(3, 5)) and close(push[y], TENSION * Q(4, 5))


def test_multipliers_are_given_where_they_are_unique():
    by_relation = reaction_forces(pendulum(relations=(CIRCLE,)), PENDULUM_POINT)
    assert by_relation.multipliers == ()
    assert close(by_relation.relation_multipliers[0], -TENSION / 10)
    by_constraint = reaction_forces(pendulum(constraints=(x * Dx + y * Dy,)), PENDULUM_POINT)
    assert close(by_constraint.multipliers[0], -TENSION / 5)
    both = pendulum(relations=(CIRCLE,), constraints=(x * Dx + y * Dy,))
    shared = reaction_forces(both, PENDULUM_POINT)
    assert shared.multipliers is None and shared.relation_multipliers is None


def test_a_quasi_velocity_reaches_where_the_base_velocity_does_not():
    frame = Frame.quasi({w: (x * Dy - y * Dx) / length**2})
    system = pendulum(relations=(CIRCLE,), frame=frame)
    bottom = multiplier_acceleration(system, {x: 5, y: 0, w: Q(1, 2)})
    assert close(bottom[x], -Q(5, 4)) and close(bottom[y], -Q(49, 5))


def test_a_point_off_its_relation_by_rounding_is_taken_for_the_nearest_on_it():
    system = pendulum(relations=(CIRCLE,), constraints=(x * Dx + y * Dy,))
    point = {x: 3.0000000000000004, y: -4.0, Dx: 2}
    found = multiplier_acceleration(system, point)
    assert close(found[x], 4 * ANGULAR - 3 * Q(1, 4), 14)


def test_superfluous_base_velocities_may_be_rounded():
    relations = (x**2 + y**2 - 1, z / 10 - x - y)
    system = System(
        name="ring",
        fibration=Fibration(base=(x, y, z), relations=relations),
        lagrangian=Dx**2 + Dy**2,
    )
    point = {x: 0.6, y: 0.8, z: 14.0, Dx: -1.6, Dy: 1.2, Dz: -4.0}
    found = multiplier_acceleration(system, point)
    for name, expected in ((x, -4 * Q(6, 10)), (y, -4 * Q(8, 10)), (z, -56)):
        assert close(found[name], expected, 14)


def test_a_rounded_point_on_dependent_relations_is_settled():
    """The entries of a plane rotation: orthogonality implies the determinant."""
    entries = sp.symbols("a11 a12 a21 a22")
    a11, a12, a21, a22 = entries
    relations = (
        a11**2 + a12**2 - 1, a21**2 + a22**2 - 1, a11 * a21 + a12 * a22, a11 * a22 - a12 * a21 - 1
    )  # fmt: skip
    system = System(
        name="rotor",
        fibration=Fibration(base=entries, relations=relations),
        lagrangian=sum(velocity(e) ** 2 for e in entries) / 2,
        frame=Frame.quasi({w: a11 * velocity(a21) + a12 * velocity(a22)}),
    )
    point = {a11: 0.540302305868141, a12: -0.84147098480789, a21: 0.841470984807896, w: 2}
    found = multiplier_acceleration(system, point | {a22: 0.54030230586814})
    for entry, value in zip(entries, (sp.cos(1), -sp.sin(1), sp.sin(1), sp.cos(1)), strict=True):
        assert close(found[entry], -4 * value, 12)


def test_bead_on_a_hoop_whose_rate_grows_with_the_time():
    rate = R + a * vo.time
    system = System(
        name="hoop",
        fibration=Fibration(base=(theta,), fibre=(psi,)),
        lagrangian=m * (Dtheta**2 + sp.sin(theta) ** 2 * Dpsi**2) / 2 + m * g * sp.cos(theta),
        constraints=(Dpsi - rate,),
        parameters=(m, g, R, a),
    )
    point = {theta: 1, psi: 0, Dtheta: Q(1, 2), m: 2, g: 9, R: 3, a: Q(1, 4), vo.time: 2}
    found = multiplier_acceleration(system, point)
    sine, cosine, turn = sp.sin(1), sp.cos(1), Q(7, 2)
    assert close(found[theta], sine * cosine * turn**2 - 9 * sine)
    assert close(found[psi], Q(1, 4))
    torque = 2 * (2 * sine * cosine * Q(1, 2) * turn + sine**2 * Q(1, 4))
    assert close(reaction_forces(system, point).multipliers[0], torque)
    del point[vo.time]
    with pytest.raises(DefinitionError, match="no value for 't'"):
        multiplier_acceleration(system, point)


def test_a_moving_relation_is_differentiated_in_time():
    system = System(
        name="lift",
        fibration=Fibration(base=(x,), fibre=(y,), relations=(y - x**2 - vo.time**3,)),
        lagrangian=(Dx**2 + Dy**2) / 2,
    )
    found = multiplier_acceleration(system, {x: 1, y: 9, "xdot": 1, "t": 2})
    # ydd = 2 x xdd + 2 xd^2 + 6 t and xdd + 2 x ydd = 0
    assert close(found[x], -Q(28, 5)) and close(found[y], Q(14, 5))


def test_a_relativistic_particle_resists_more_along_its_velocity():
    system = System(
        name="relativistic",
        fibration=Fibration(base=(x, y)),
        lagrangian=-m * sp.sqrt(1 - Dx**2 - Dy**2) + g * x,
        parameters=(m, g),
    )
    found = multiplier_acceleration(system, {x: 0, y: 0, Dx: Q(3, 10), Dy: Q(4, 10), m: 2, g: 5})
    gamma = 1 / sp.sqrt(1 - Q(1, 4))
    assert close(found[x], 5 * (1 - Q(9, 100)) / (2 * gamma))
    assert close(found[y], -5 * Q(12, 100) / (2 * gamma))


q = sp.symbols("q0:4")
omega = sp.symbols("omega1:4")
inertia = (2, 3, Q(7, 2))


def quaternion_product(p, r):
    return (
        p[0] * r[0] - p[1] * r[1] - p[2] * r[2] - p[3] * r[3],
        p[0] * r[1] + p[1] * r[0] + p[2] * r[3] - p[3] * r[2],
        p[0] * r[2] - p[1] * r[3] + p[2] * r[0] + p[3] * r[1],
        p[0] * r[3] + p[1] * r[2] - p[2] * r[1] + p[3] * r[0],
    )


def rigid_body(fibre=(), relations=(), constraints=None, potential=0):
    """A rigid body with a fixed point; the angular velocity in the body is 2 conj(q) qdot."""
    conjugate = (q[0], -q[1], -q[2], -q[3])
    turn = [2 * c for c in quaternion_product(conjugate, tuple(map(velocity, q)))[1:]]
    return System(
        name="body",
        fibration=Fibration(base=q, fibre=fibre, relations=(sum(c**2 for c in q) - 1, *relations)),
        frame=Frame.quasi(dict(zip(omega, turn, strict=True))),
        lagrangian=sum(i * u**2 for i, u in zip(inertia, turn, strict=True)) / 2 - potential,
        constraints=constraints(turn) if constraints else (),
    )


ORIENTATION = dict(zip(q, (Q(1, 10), Q(5, 10), -Q(5, 10), Q(7, 10)), strict=True))
TURNING = dict(zip(omega, (Q(1, 3), Q(-2, 7), Q(5, 4)), strict=True))


def quaternion_acceleration(torque=(0, 0, 0)):
    """From I wdot = I w x w + M and qdot = q w / 2."""
    turn = sp.Matrix(list(TURNING.values()))
    momentum = sp.Matrix([i * u for i, u in zip(inertia, turn, strict=True)])
    right = momentum.cross(turn) + sp.Matrix(torque)
    turning = (0, *turn)
    change = (0, *(r / i for r, i in zip(right, inertia, strict=True)))
    at = tuple(ORIENTATION.values())
    rate = tuple(c / 2 for c in quaternion_product(at, turning))
    pairs = zip(quaternion_product(rate, turning), quaternion_product(at, change), strict=True)
    return [(b + c) / 2 for b, c in pairs]


def test_a_rigid_body_in_quaternions_obeys_euler_to_fifty_digits():
    found = multiplier_acceleration(rigid_body(), ORIENTATION | TURNING, digits=50)
    for name, expected in zip(q, quaternion_acceleration(), strict=True):
        assert close(found[name], expected, 49)


@pytest.mark.parametrize("as_floats", [False, True])
def test_a_heavy_top_with_a_redundant_poisson_vector_obeys_euler_and_poisson(as_floats):
    gamma = sp.symbols("gamma1:4")

    def poisson(turn):
        cross = sp.Matrix(gamma).cross(sp.Matrix(turn))
        return tuple(velocity(c) - r for c, r in zip(gamma, cross, strict=True))

    system = rigid_body(
        gamma, (sum(c**2 for c in gamma) - 1,), poisson, Q(3, 2) * gamma[0] + gamma[2]
    )
    vertical = (Q(2, 7), Q(3, 7), Q(6, 7))
    point = ORIENTATION | TURNING | dict(zip(gamma, vertical, strict=True))
    if as_floats:
        point = {key: float(value) for key, value in point.items()}
    torque = sp.Matrix(vertical).cross(sp.Matrix([Q(3, 2), 0, 1]))
    found = multiplier_acceleration(system, point)
    for name, expected in zip(q, quaternion_acceleration(torque), strict=True):
        assert close(found[name], expected, 14 if as_floats else 29)
    push = reaction_forces(system, point)
    assert push.multipliers is None
    assert close(push.generalized[gamma[0]], Q(3, 2), 14 if as_floats else 29)


@pytest.mark.parametrize("seed", range(4))
def test_ideal_constraints_do_no_work(seed):
    """dE/dt = Q qdot, for any Lagrangian, forces, and constraints that are linear."""
    coordinates, dots = (x, y, z), (Dx, Dy, Dz)
    k = seed + 2
    lagrangian = (
        (1 + x**2) * Dx**2 + (2 + sp.cos(k * y)) * Dy**2 + k * Dz**2 + Dx * Dz * sp.sin(y) / k
        + Dy**4 / (5 + z**2) + sp.exp(-x * z) - k * sp.cos(y * z) + (x * Dy - z * Dx) * k
    )  # fmt: skip
    forces = {x: -Dx * k + y, z: Dy * Dx - k * z}
    system = System(
        name="random",
        fibration=Fibration(base=(x, y), fibre=(z,)),
        lagrangian=lagrangian,
        constraints=((3 + x * y) * Dz - y * Dx * k + sp.sin(x + z) * Dy,),
        forces=forces,
    )
    point = {x: Q(k, 7), y: Q(3, k), z: Q(-1, k), Dx: Q(k, 3), Dy: Q(-2, k)}
    rate = sp.solve(system.constraints[0].subs(point), Dz)[0]
    full = point | {Dz: rate}
    found = multiplier_acceleration(system, point, digits=40)
    push = reaction_forces(system, point, digits=40).generalized
    energy = sum(d * lagrangian.diff(d) for d in dots) - lagrangian
    change = sum(
        energy.diff(c) * d + energy.diff(d) * found[c]
        for c, d in zip(coordinates, dots, strict=True)
    )
    power = sum(force * velocity(c) for c, force in forces.items())
    assert abs((change - power).subs(full).evalf(45)) < Q(10) ** -35
    work = sum(push[c] * d for c, d in zip(coordinates, dots, strict=True))
    assert abs(work.subs(full).evalf(45)) < Q(10) ** -35
    assert any(abs(p) > Q(1, 100) for p in push.values())


def test_more_digits_continue_fewer():
    few = multiplier_acceleration(sleigh(), SLEIGH_POINT, 30)
    many = multiplier_acceleration(sleigh(), SLEIGH_POINT, 60)
    for name in few:
        assert close(few[name], many[name])
        assert few[name]._prec < many[name]._prec


@pytest.mark.parametrize("tiny", [Q(10) ** -20, Q(10) ** -45])
def test_digits_lost_to_a_nearly_singular_mass_are_made_good(tiny):
    coupled = (Dx**2 + Dy**2) / 2 + (1 - tiny) * Dx * Dy
    system = System(
        name="near", fibration=Fibration(base=(x, y)), lagrangian=coupled, forces={x: 1}
    )
    found = multiplier_acceleration(system, {x: 0, y: 0, Dx: 0, Dy: 0})
    determinant = 1 - (1 - tiny) ** 2
    assert close(found[x], 1 / determinant) and close(found[y], (tiny - 1) / determinant)


def free(force, **options):
    return System(
        name="free", fibration=Fibration(base=(x,)), lagrangian=Dx**2 / 2, forces={x: force},
        parameters=(a,), **options,
    )  # fmt: skip


def test_digits_lost_to_cancellation_are_made_good():
    tiny = Q(10) ** -90
    found = multiplier_acceleration(free((sp.sqrt(1 + a) - 1) / a), {x: 0, Dx: 0, a: tiny})
    assert close(found[x], Q(1, 2) - tiny / 8)


def test_what_cancels_altogether_is_zero():
    found = multiplier_acceleration(free(sp.sin(x) ** 2 + sp.cos(x) ** 2 - 1), {x: 1, Dx: 0, a: 0})
    assert found[x] == 0


def test_a_constraint_that_cancels_altogether_binds_nothing():
    nothing = sp.sin(x) ** 2 + sp.cos(x) ** 2 - 1
    for at in (1, 2, 3):
        system = plane(constraints=(Dy, nothing * (Dx + 2 * Dy)), forces={x: 7})
        found = multiplier_acceleration(system, {x: at, y: 0, Dx: 5})
        assert close(found[x], 7) and found[y] == 0


def test_roots_are_taken_with_all_digits():
    found = multiplier_acceleration(free(sp.cbrt(x) + x ** sp.sqrt(2)), {x: 5, Dx: 0, a: 0}, 60)
    assert close(found[x], sp.cbrt(5) + sp.Integer(5) ** sp.sqrt(2), 59)
    turn = multiplier_acceleration(free(a), {x: 0, Dx: 0, a: sp.pi / 10}, 60)
    assert close(turn[x], sp.pi / 10, 59)


def test_the_scale_of_the_masses_plays_no_part():
    system = pendulum(relations=(CIRCLE,))
    light = multiplier_acceleration(system, PENDULUM_POINT | {m: Q(10) ** -90})
    heavy = multiplier_acceleration(system, PENDULUM_POINT)
    assert all(close(light[name], heavy[name]) for name in heavy)


@pytest.mark.parametrize(
    "number", [Fraction(1, 5), Decimal("0.2"), "0.2", "1/5", sp.sin(sp.pi / 6) * Q(2, 5)]
)
def test_numbers_are_taken_exactly_whatever_their_kind(number):
    found = multiplier_acceleration(sleigh(), {**SLEIGH_POINT, "a": number})
    assert found == multiplier_acceleration(sleigh(), SLEIGH_POINT)


def test_binary_numbers_are_not_read_as_decimals():
    with mp.workdps(60):
        third = mp.mpf(1) / 3
    system = free(a)
    point = {x: 0, Dx: 0}
    assert close(multiplier_acceleration(system, point | {a: 0.1}, 50)[x], Q(0.1), 49)
    assert close(multiplier_acceleration(system, point | {a: sp.Float(0.1)}, 50)[x], Q(0.1), 49)
    assert close(multiplier_acceleration(system, point | {a: third}, 50)[x], Q(1, 3), 49)


def test_dynamicsymbols_name_points_and_answers():
    angle = dynamicsymbols("alpha")
    rate = angle.diff(vo.time)
    system = System(
        name="swing",
        fibration=Fibration(base=(angle,)),
        lagrangian=rate**2 / 2 + g * sp.cos(angle),
        parameters=(g,),
    )
    found = multiplier_acceleration(system, {angle: 1, rate: 2, g: 3})
    assert list(found) == [angle] and close(found[angle], -3 * sp.sin(1))
    assert found == multiplier_acceleration(system, {"alpha": 1, "alphadot": 2, "g": 3})


def test_absolute_values_are_differentiated_away_from_zero():
    system = System(
        name="wedge",
        fibration=Fibration(base=(x,)),
        lagrangian=Dx**2 / 2 - sp.Abs(x) * 3,
        forces={x: -sp.sign(Dx)},
    )
    assert multiplier_acceleration(system, {x: Q(-1, 2), Dx: 0})[x] == sp.Float(3, 30)
    assert multiplier_acceleration(system, {x: Q(1, 2), Dx: -4})[x] == sp.Float(-2, 30)


def test_a_constraint_that_only_looks_quadratic_is_accepted():
    disguised = sp.sin(x) ** 2 * Dx**2 + sp.cos(x) ** 2 * Dx**2 - Dx**2 + Dy - 2 * x * Dx
    system = System(
        name="disguised",
        fibration=Fibration(base=(x,), fibre=(y,)),
        lagrangian=(Dx**2 + Dy**2) / 2,
        constraints=(disguised,),
    )
    found = multiplier_acceleration(system, {x: 1, y: 0, Dx: 1})
    assert close(found[x], -Q(4, 5)) and close(found[y], Q(2, 5))


def plane(lagrangian=(Dx**2 + Dy**2) / 2, **options):
    return System(
        name="plane", fibration=Fibration(base=(x,), fibre=(y,)), lagrangian=lagrangian, **options
    )


REST = {x: 0, y: 0, Dx: 0}
BAD = {
    "missing": (sleigh(), {k: n for k, n in SLEIGH_POINT.items() if k != w}, "no value for 'w'"),
    "unknown": (sleigh(), SLEIGH_POINT | {"k": 1}, "'k' is not a coordinate, velocity"),
    "dependent velocity": (sleigh(), SLEIGH_POINT | {Dy: 1}, "'ydot' is not a coordinate"),
    "twice": (sleigh(), SLEIGH_POINT | {"x": 1}, "gives 'x' twice"),
    "no name": (sleigh(), SLEIGH_POINT | {x + y: 1}, "neither a symbol nor a name"),
    "not a number": (sleigh(), SLEIGH_POINT | {x: "wide"}, "value of 'x' is 'wide'"),
    "not finite": (sleigh(), SLEIGH_POINT | {x: float("nan")}, "not a real number"),
    "infinite": (sleigh(), SLEIGH_POINT | {x: sp.oo}, "not a real number"),
    "not real": (sleigh(), SLEIGH_POINT | {x: 1j}, "not a real number"),
    "off the relation": (
        pendulum(relations=(CIRCLE,)), PENDULUM_POINT | {y: 4.01},
        r"relation -l\*\*2 \+ x\*\*2 \+ y\*\*2 = 0 \(residual 0.0801\)",
    ),
    "chart edge": (
        pendulum(relations=(CIRCLE,)), {x: 5, y: 0, Dx: 0}, "do not determine 'ydot'",
    ),
    "velocities off the relation": (
        System(
            name="two", fibration=Fibration(base=(x, y), relations=(x**2 + y**2 - 1,)),
            lagrangian=Dx**2 + Dy**2,
        ),
        {x: 1, y: 0, Dx: 1, Dy: 1}, "velocity 'xdot' of the point is off by 1.0",
    ),
    "no inertia": (
        plane(Dx**2 / 2 + Dx * Dy + Dy**2 / 2, constraints=(Dx + Dy - 1,)), REST,
        r"admissible velocity \((xdot = 1.0, ydot = -1.0|xdot = -1.0, ydot = 1.0)\)",
    ),
    "contradiction": (
        plane(constraints=(Dx + Dy, 2 * Dx + 2 * Dy - 1)), REST, "constraint 2 contradicts",
    ),
    "contradiction in time": (
        plane(constraints=(Dy, vo.time * Dx + Dy)), REST | {Dx: 1, "t": 0},
        "constraint 2 depends on the others, and its derivative contradicts",
    ),
    "bent": (plane(constraints=(Dy - Dx**3,)), REST, "constraint 1 is not affine"),
    "jump of a velocity": (
        plane(constraints=(Dy - sp.sign(Dx),)), REST, "constraint 1 is not affine",
    ),
    "bent frame": (
        plane(constraints=(Dy,), frame=Frame.quasi({v: Dx * Dx})), {x: 0, y: 0, v: 1},
        "definition of 'v' is not affine",
    ),
    "unknown function": (
        plane(Dx**2 + Dy**2 - sp.Function("f")(x), constraints=(Dy,)), REST,
        "needs a formula",
    ),
    "unknown function of the time": (
        plane(
            Dx**2 + Dy**2 - x * dynamicsymbols("h"), constraints=(Dy,),
            parameters=(dynamicsymbols("h"),),
        ),
        REST | {"t": 0}, r"unknown function 'h\(t\)' has no value",
    ),
    "undefined": (plane(Dx**2 + Dy**2 - 1 / x, constraints=(Dy,)), REST, "division by zero"),
    "imaginary": (plane(Dx**2 + Dy**2 - sp.sqrt(x - 1), constraints=(Dy,)), REST, "no real value"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD.values(), ids=BAD)
def test_bad_input_is_refused_in_one_line_that_says_what(case):
    system, point, message = case
    for ask in (multiplier_acceleration, reaction_forces):
        with pytest.raises(DefinitionError, match=message) as caught:
            ask(system, point)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("digits", [0, -3, 2.5, "30", True, 10**5, 10**120])
def test_digits_must_be_a_whole_number_within_bounds(digits):
    with pytest.raises(DefinitionError, match="a whole number from 1 to 10000"):
        multiplier_acceleration(sleigh(), SLEIGH_POINT, digits)


@pytest.mark.parametrize("tower", [sp.exp(sp.exp(sp.Integer(7 * 10**8))), sp.cosh(sp.exp(30))])
def test_a_number_beyond_all_sizes_is_refused_at_once(tower):
    with pytest.raises(DefinitionError, match=r"'v' is .* not a real number of a size"):
        multiplier_acceleration(sleigh(), {**SLEIGH_POINT, v: tower})


CASES = (
    sp.Max(sp.sqrt(1 + x**2), 2 * x), sp.Max(sp.sin(x) / x, Q(1, 2)), sp.Abs(sp.Max(a, x)),
    sp.Piecewise((sp.sqrt(1 + x**2), sp.sin(x) / x > Q(1, 2)), (x, True)),
    sp.Min(sp.log(1 + sp.exp(x)), sp.sqrt(4 + x**2)) * sp.cos(x),
    sp.Max(Q(1, 3), sp.Piecewise((1, x > 1), (x, True))),
    sp.Min(2, sp.Max(x, sp.Piecewise((a, x > 0), (1, True))), x**2),
)  # fmt: skip


@pytest.mark.parametrize("force", CASES, ids=str)
def test_forces_in_cases_of_roots_and_quotients_are_read(force):
    made = System(
        name="cases", fibration=Fibration(x), lagrangian=Dx**2 / 2, forces={x: force},
        parameters=(Parameter(a, 1),),
    )  # fmt: skip
    for place in (2, Q(1, 2)):
        found = multiplier_acceleration(made, {x: place, Dx: 0})[x]
        assert close(found, force.subs({x: place, a: 1}))

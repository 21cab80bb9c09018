"""The models of SymPy's and PyDy's documentation and tests, each with its source: all go in as they
are, and have the accelerations of SymPy's own method at a random rational point, or are refused
with the reason."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath as mp
import pytest
import sympy as sp
from sympy.physics import mechanics as me
from sympy.physics.biomechanics import FiberForceLengthActiveDeGroote2016
from test_mechanics import CLOSE, DIGITS, kane_speeds, moving_names, numbers, solved, t, valued
from tool_modules import tool

import voronec as vo

shared = tool("figures.mechanics_models")
frame, kane, ds, syms = shared.frame, shared.kane, me.dynamicsymbols, sp.symbols


@dataclass(frozen=True)
class Entry:
    """A model: where it comes from, what makes the method, and why it is refused, if it is."""

    source: str
    make: Callable[[], Any]
    refused: str = ""


MODELS: dict[str, Entry] = {}


def model(source: str, refused: str = "") -> Callable[[Callable[[], Any]], Callable[[], Any]]:
    def keep(make: Callable[[], Any]) -> Callable[[], Any]:
        MODELS[make.__name__] = Entry(source, make, refused)
        return make

    return keep


def along(values: Sequence[Any], axes: Any) -> Any:
    """The vector of these components."""
    return sum((v * e for v, e in zip(values, axes, strict=False)), 0 * axes.x)


def rest(name: str = "N") -> tuple[Any, Any]:
    """An inertial frame and a point at rest in it."""
    ground, origin = me.ReferenceFrame(name), me.Point("O")
    origin.set_vel(ground, 0)
    return ground, origin


def fixed(parent: Any, name: str, arm: Any, ground: Any, body: Any) -> Any:
    """A point fixed in the same body as its parent."""
    point = parent.locatenew(name, arm)
    point.v2pt_theory(parent, ground, body)
    return point


def rates(q: Sequence[Any], u: Sequence[Any]) -> list[Any]:
    return [x.diff(t) - v for x, v in zip(q, u, strict=True)]


def spun(ground: Any, name: str, angle: Any, speed: Any, axis: Any) -> Any:
    """A frame turned about an axis of its parent, its rate a speed."""
    found = frame(ground, name, angle, axis)
    found.set_ang_vel(ground, speed * axis)
    return found


# SymPy's tests of Kane's method


@model("SymPy, test_kane.py, one_dof and input_format; docs of KanesMethod")
def mass_on_a_spring() -> Any:
    q, u = ds("q u")
    m, k, c = syms("m k c")
    ground, _ = rest()
    p = me.Point("P")
    p.set_vel(ground, u * ground.x)
    load = (p, (-k * q - c * u) * ground.x)
    return kane(ground, [q], [u], rates([q], [u]), [me.Particle("p", p, m)], [load])


def chain_of_masses(n: int, **more: bool) -> Any:
    """Displacements from one mass to the next."""
    q, u, f = ds(f"x:{n}"), ds(f"v:{n}"), ds(f"f:{n}")
    m, k, c = syms(f"m:{n}"), (*syms(f"k:{n}"), 0), (*syms(f"c:{n}"), 0)
    ground, _ = rest()
    x, v = (*q, 0), (*u, 0)
    bodies, loads = [], []
    for i in range(n):
        p = me.Point(f"P{i}")
        p.set_vel(ground, sum(u[: i + 1]) * ground.x)
        bodies.append(me.Particle(f"block{i}", p, m[i]))
        pull = -k[i] * x[i] - c[i] * v[i] + k[i + 1] * x[i + 1] + c[i + 1] * v[i + 1]
        pull += m[i] * sp.Symbol("g") if more.get("gravity") else 0
        pull += f[i] if more.get("forces") else 0
        loads.append((p, pull * ground.x))
    return kane(ground, q, u, rates(q, u), bodies, loads)


@model("SymPy, test_kane.py, two_dof; test_jointsmethod.py, two_dof_joints")
def two_masses() -> Any:
    return chain_of_masses(2)


@model("SymPy, test_models.py; PyDy, models.multi_mass_spring_damper")
def three_masses_that_are_pushed() -> Any:
    return chain_of_masses(3, gravity=True, forces=True)


@model("PyDy, docs, mass-spring-damper")
def one_mass_that_is_pushed() -> Any:
    return chain_of_masses(1, gravity=True, forces=True)


@model("SymPy, test_kane.py, pend; test_linearize.py, pendulum_kane_minimal; docs, linearize")
def pendulum() -> Any:
    q, u = ds("q u")
    m, length, g = syms("m l g")
    ground, origin = rest()
    rod = spun(ground, "A", q, u, ground.z)
    bob = fixed(origin, "P", length * rod.x, ground, rod)
    load = (bob, m * g * ground.x)
    return kane(ground, [q], [u], rates([q], [u]), [me.Particle("bob", bob, m)], [load])


@model("SymPy, test_kane.py, aux")
def disc_with_two_auxiliary_speeds() -> Any:
    return disc_with_contact_forces(set_acceleration=False)


def disc_with_contact_forces(set_acceleration: bool) -> Any:
    q, u, aux, f = ds("q1:4"), ds("u1:4"), ds("u4:6"), ds("f1:3")
    r, m, g = syms("r m g")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "Y", q[0], ground.z)
    lean = frame(yaw, "L", q[1], yaw.x)
    disc = frame(lean, "R", q[2], lean.y)
    turning = disc.ang_vel_in(ground)
    disc.set_ang_vel(ground, along(u, lean))
    contact = me.Point("C")
    contact.set_vel(ground, aux[0] * lean.x + aux[1] * me.cross(yaw.z, lean.x))
    centre = fixed(contact, "D", r * lean.z, ground, disc)
    if set_acceleration:
        centre.a2pt_theory(contact, ground, disc)
    inertia = me.inertia(lean, m * r**2 / 4, m * r**2 / 2, m * r**2 / 4)
    body = me.RigidBody("disc", centre, disc, m, (inertia, centre))
    push = f[0] * lean.x + f[1] * me.cross(yaw.z, lean.x)
    kd = [me.dot(disc.ang_vel_in(ground) - turning, axis) for axis in lean]
    loads = [(centre, -m * g * yaw.z), (contact, push)]
    return kane(ground, q, u, kd, [body], loads, u_auxiliary=aux)


@model("SymPy, test_kane.py, parallel_axis; test_system_class.py, cart_pendulum_kanes")
def inertia_about_the_hinge() -> Any:
    q, u, push = ds("q1:3"), ds("u1:3"), ds("F")
    g, k, slack, a, m_a, m_c = syms("g k ls a mA mC")
    ground, origin = rest()
    rod = spun(ground, "A", -q[1], -u[1], ground.z)
    hinge = origin.locatenew("C", q[0] * ground.x)
    hinge.set_vel(ground, u[0] * ground.x)
    centre = fixed(hinge, "Ao", a * rod.y, ground, rod)
    inertia = me.inertia(rod, *syms("Ix Iy Iz"))
    bodies = [
        me.Particle("cart", hinge, m_c),
        me.RigidBody("rod", centre, rod, m_a, (inertia, hinge)),
    ]
    loads = [(centre, -g * m_a * ground.y), (hinge, -g * m_c * ground.y)]
    loads += [(hinge, (push - k * (q[0] - slack)) * ground.x)]
    return kane(ground, q, u, rates(q, u), bodies, loads)


@model("SymPy, test_kane.py, issue_24887", "the Lagrangian gives 'u2' no inertia")
def point_on_a_rod_with_three_angles() -> Any:
    q, u = ds("q1:4"), ds("u1:4")
    g, length, m = syms("g l m")
    ground, origin = rest()
    rod = me.ReferenceFrame("A")
    rod.orient_body_fixed(ground, q, "zxy")
    kd = [rod.ang_vel_in(ground).dot(e) - v for e, v in zip(rod, u, strict=True)]
    bob = origin.locatenew("Po", -length * rod.y)
    bob.set_vel(rod, 0)
    return kane(ground, q, u, kd, [me.Particle("P", bob, m)], [(bob, -m * g * ground.y)])


@model("SymPy, test_kane2.py, aux_dep; PyDy, rollingdisc_nonminimal.py")
def disc_with_a_dependent_height_and_contact_forces() -> Any:
    q, u, aux = ds("q:4"), ds("u:6"), ds("ua:3")
    r, m, g, moment, spin, *push = syms("r m g I J Fx Fy Fz")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "A", q[0], ground.z)
    lean = frame(yaw, "B", q[1], yaw.x)
    disc = frame(lean, "C", q[2], lean.y)
    disc.set_ang_vel(ground, along(u[:3], lean))
    contact = me.Point("P")
    contact.set_vel(ground, along(aux, yaw))
    centre = contact.locatenew("O", q[3] * yaw.z + r * sp.sin(q[1]) * yaw.y)
    centre.set_vel(ground, along(u[3:], yaw))
    arm = centre.pos_from(contact)
    turning = q[0].diff(t) * yaw.z + q[1].diff(t) * lean.x + q[2].diff(t) * lean.y
    rise = arm.diff(t, yaw) + me.cross(yaw.ang_vel_in(ground), arm)
    kd = [me.dot(turning - disc.ang_vel_in(ground), axis) for axis in lean]
    slip = centre.vel(ground) - contact.vel(ground) - me.cross(disc.ang_vel_in(ground), arm)
    body = me.RigidBody("disc", centre, disc, m, (me.inertia(lean, moment, spin, moment), centre))
    return kane(
        ground, q[:3], u[:3], [*kd, me.dot(rise - centre.vel(ground), yaw.z)], [body],
        [(centre, m * g * yaw.z), (contact, along(push, yaw))], q_dependent=q[3:],
        configuration_constraints=[me.dot(-r * lean.z, yaw.z) - q[3]], u_dependent=u[3:],
        velocity_constraints=[me.dot(slip, axis) for axis in yaw], u_auxiliary=aux,
    )  # fmt: skip


def carriage(turned_by: Any, about_the_axle: bool) -> Any:
    """Kane and Levinson's carriage, its no-slip conditions among the kinematic equations."""
    q, u = ds("q1:4"), ds("u1:3")
    r, m_all, g, e, f, tilt, a, b, m_a, m_b = syms("R M g e f theta a b mA mB")
    ground = me.ReferenceFrame("F")
    plane = frame(ground, "P", -tilt, ground.y)
    body = frame(plane, "A", q[0], plane.x)
    body.set_ang_vel(ground, u[0] * body.x + turned_by * body.z)
    wheels = [frame(body, name, x, body.z) for name, x in zip("BC", q[1:], strict=True)]
    axle = me.Point("D")
    axle.set_vel(body, 0)
    axle.set_vel(ground, u[1] * body.y)
    arms = (e * body.y, f * body.y - r * body.x, a * body.y, b * body.z, -b * body.z)
    points = [fixed(axle, f"D{i}", arm, ground, body) for i, arm in enumerate(arms)]
    touch = [fixed(p, "T", -r * body.x, ground, w) for p, w in zip(points[3:], wheels, strict=True)]
    kd = [me.dot(p.vel(ground), body.y) for p in touch] + [u[0] - q[0].diff(t)]
    moments = [me.inertia(body, *syms("IA IA22 IA33"), 0, sp.Symbol("IA23"), 0)]
    moments += [me.inertia(w, *syms("K K J")) for w in wheels]
    bodies = []
    for p, own, m, i in zip(points[2:], (body, *wheels), (m_a, m_b, m_b), moments, strict=True):
        about = axle if about_the_axle else p
        shift = me.inertia_of_point_mass(m, p.pos_from(about), body)
        bodies.append(me.RigidBody(f"body {len(bodies)}", p, own, m, (i + shift, about)))
    loads = [(points[0], -m_all * g * ground.x), (points[1], along(syms("Q1:4"), body))]
    more = {"u_auxiliary": [turned_by]} if turned_by != 0 else {}
    return kane(ground, q, u, kd, bodies, loads, **more)


@model("SymPy, test_kane2.py, sub_qdot")
def carriage_with_a_speed_about_its_track() -> Any:
    return carriage(ds("u3"), about_the_axle=False)


@model("SymPy, test_kane2.py, non_central_inertia")
def carriage_with_inertia_about_its_axle() -> Any:
    return carriage(0, about_the_axle=True)


@model("SymPy, test_kane2.py, sub_qdot2; PyDy, Kane1985, Ex8.3.py", "holds no bodies")
def forces_without_bodies() -> Any:
    q, u = ds("q u")
    ground, _ = rest()
    p = me.Point("P")
    p.set_vel(ground, q.diff(t) * ground.x)
    return me.KanesMethod(ground, [q], [u], rates([q], [u]), forcelist=[(p, ground.x)])


@model("SymPy, test_kane4.py")
def forces_of_the_rates_of_coordinates() -> Any:
    q, u = ds("q1:3"), ds("u1:3")
    m, k, c, length = syms("m k c l")
    ground, origin = rest()
    rod = spun(ground, "A", q[1], u[0] - u[1], ground.z)
    end = origin.locatenew("P", q[0] * ground.x)
    end.set_vel(ground, u[0] * ground.x)
    bob = fixed(end, "Q", length * rod.y, ground, rod)
    kd = [q[0].diff(t) - u[0], q[1].diff(t) - u[0] + u[1]]
    loads = [(end, (-k * q[0] - c * q[0].diff(t)) * ground.x), (rod, -c * q[1].diff(t) * ground.z)]
    bodies = [me.Particle("p", end, m), me.Particle("q", bob, m)]
    return kane(ground, q, u, kd, bodies, loads)


def disc_of_five(height: bool, **more: Any) -> Any:
    """Place and attitude of a disc; no slip binds two speeds, or three with the height."""
    q, u = ds("q1:6"), ds("u1:7")
    g, r, m = syms("g r m")
    ground, origin = rest()
    yaw = frame(ground, "Y", q[0], ground.z)
    lean = frame(yaw, "L", q[1], yaw.x)
    disc = frame(lean, "R", q[2], lean.y)
    turning = disc.ang_vel_in(ground)
    disc.set_ang_vel(ground, along(u[:3], lean))
    rise = ds("q6") if height else r * sp.cos(q[1])
    centre = origin.locatenew("C", q[3] * ground.x + q[4] * ground.y + rise * ground.z)
    moved = centre.pos_from(origin).dt(ground)
    if height:
        centre.set_vel(ground, along(u[3:], ground))
    else:
        centre.set_vel(ground, along(u[3:5], ground) + me.dot(moved, ground.z) * ground.z)
    kd = [me.dot(disc.ang_vel_in(ground) - turning, axis) for axis in lean]
    kd += [me.dot(moved - centre.vel(ground), axis) for axis in [*ground][: 3 if height else 2]]
    slip = centre.vel(ground) + me.cross(disc.ang_vel_in(ground), -r * lean.z)
    bound = [me.dot(slip, axis) for axis in (*ground,)][: 3 if height else 2]
    inertia = me.inertia(lean, m * r**2 / 4, m * r**2 / 2, m * r**2 / 4)
    if height:
        more |= {"q_dependent": [rise], "configuration_constraints": [rise - r * sp.cos(q[1])]}
    return kane(
        ground, q, u[:3], kd, [me.RigidBody("disc", centre, disc, m, (inertia, centre))],
        [(centre, -m * g * ground.z)], u_dependent=u[3:] if height else u[3:5],
        velocity_constraints=bound, **more,
    )  # fmt: skip


@model("SymPy, test_kane5.py")
def disc_with_implicit_kinematics() -> Any:
    return disc_of_five(False, explicit_kinematics=False, constraint_solver="CRAMER")


@model("SymPy, test_linearize.py, rolling_disc_kane")
def disc_with_six_coordinates() -> Any:
    return disc_of_five(True)


# SymPy's tests of Lagrange's method


@model("SymPy, test_lagrange.py, disc_on_an_incline_plane")
def disc_on_an_incline() -> Any:
    y, theta = ds("y theta")
    m, g, r, length, tilt = syms("m g R l alpha")
    ground = me.ReferenceFrame("N")
    plane = frame(ground, "A", sp.pi / 2 - tilt, ground.z)
    disc = frame(plane, "B", -theta, plane.z)
    centre = me.Point("Do")
    centre.set_vel(ground, y.diff(t) * plane.x)
    body = me.RigidBody("D", centre, disc, m, (m * r**2 / 2 * (disc.z | disc.z), centre))
    body.potential_energy = m * g * (length - y) * sp.sin(tilt)
    energy = me.Lagrangian(ground, body)
    return me.LagrangesMethod(energy, [y, theta], hol_coneqs=[y - r * theta])


def swinging(rods: int, **more: Any) -> Any:
    """Pendulums in a row by absolute angles, with Lagrange's method."""
    q = ds(f"q1:{rods + 1}")
    m, length, g = syms("m l g")
    ground, point = rest()
    bodies = []
    for x in q:
        rod = frame(ground, "A", x, ground.z)
        point = fixed(point, "P", length * rod.x, ground, rod)
        bodies.append(me.Particle(f"bob {len(bodies)}", point, m))
        bodies[-1].potential_energy = -m * g * point.pos_from(point).dot(ground.x)
    loads = [(b.masscenter, m * g * ground.x) for b in bodies]
    energy = me.Lagrangian(ground, *bodies)
    return me.LagrangesMethod(energy, q, forcelist=loads, frame=ground, **more)


@model(
    "SymPy, test_lagrange.py, simp_pen; test_linearize.py; docs, linearize; PyDy, simple_pendulum"
)
def pendulum_of_lagrange() -> Any:
    return swinging(1)


@model("SymPy, test_lagrange.py, dub_pen; PyDy, double_pendulum.py")
def two_pendulums_of_lagrange() -> Any:
    return swinging(2)


@model(
    "SymPy, test_lagrange.py, test_linearize.py, rolling_disc; docs, rollingdisc_example_lagrange"
)
def disc_of_lagrange() -> Any:
    q = ds("q1:4")
    r, m, g = syms("r m g")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "Y", q[0], ground.z)
    lean = frame(yaw, "L", q[1], yaw.x)
    disc = frame(lean, "R", q[2], lean.y)
    contact = me.Point("C")
    contact.set_vel(ground, 0)
    centre = fixed(contact, "D", r * lean.z, ground, disc)
    inertia = me.inertia(lean, m * r**2 / 4, m * r**2 / 2, m * r**2 / 4)
    body = me.RigidBody("disc", centre, disc, m, (inertia, centre))
    body.potential_energy = m * g * r * sp.cos(q[1])
    return me.LagrangesMethod(me.Lagrangian(ground, body), q)


@model("SymPy, test_lagrange2.py, lagrange_2forces; docs, lagrange")
def two_forces_on_one_point() -> Any:
    q = ds("q1:3")
    m, k, f, g = syms("m k f g")
    ground, _ = rest()
    points = [me.Point("A"), me.Point("B")]
    for p, x in zip(points, q, strict=True):
        p.set_vel(ground, x.diff(t) * ground.x)
    bodies = [me.Particle(p.name, p, m) for p in points]
    bodies[0].potential_energy = k * (q[1] - q[0]) ** 2 / 2
    loads = [(points[0], f * ground.x), (points[0], g * ground.x), (points[1], -f * ground.x)]
    energy = me.Lagrangian(ground, *bodies)
    return me.LagrangesMethod(energy, q, forcelist=loads, frame=ground)


@model("SymPy, docs, lagrange")
def energy_alone() -> Any:
    q1, q2 = ds("q1 q2")
    energy = q1.diff(t) ** 2 + q2.diff(t) ** 2 - 3 * q1 - 4 * q2
    return me.LagrangesMethod(energy, [q1, q2], hol_coneqs=[q1 - q2])


@model("SymPy, docs, muscle_model_example")
def muscle_about_a_sphere() -> Any:
    theta, phi = ds("theta phi")
    m, k, radius, slack, wrapped = syms("m k R L0 L_wrap")
    ground, origin = rest()
    place = (sp.sin(theta) * sp.cos(phi), sp.sin(theta) * sp.sin(phi), sp.cos(theta))
    p = origin.locatenew("P", radius * along(place, ground))
    p.set_vel(ground, p.pos_from(origin).diff(t, ground))
    ends = [origin.locatenew(s, along(syms(f"{s}x {s}y {s}z"), ground)) for s in "AB"]
    length = wrapped + sum(sp.sqrt(me.dot(p.pos_from(e), p.pos_from(e))) for e in ends)
    body = me.Particle("p", p, m)
    body.potential_energy = k * (length - slack) ** 2 / 2
    return me.LagrangesMethod(me.Lagrangian(ground, body), [theta, phi])


@model("SymPy, docs, duffing-example; test_actuator.py, DuffingSpring")
def block_on_a_hardening_spring() -> Any:
    q1, q2 = ds("q1 q2")
    big, m, length, k1, k2, c, g, r = syms("M m l k1 k2 c1 g r")
    ground, origin = rest()
    rod = frame(ground, "B", q2, ground.z)
    block = origin.locatenew("block", q1 * ground.y)
    block.set_vel(ground, q1.diff(t) * ground.y)
    bob = fixed(block, "pendulum", length * rod.y, ground, rod)
    path = me.LinearPathway(origin, block)
    loads = me.DuffingSpring(k1, k2, path, 0).to_loads() + me.LinearDamper(c, path).to_loads()
    bodies = [
        me.RigidBody("block", block, ground, big, (me.inertia(ground, *syms("Ix Iy Iz")), block)),
        me.RigidBody("ball", bob, rod, m, (2 * m * r**2 / 5 * me.inertia(rod, 1, 0, 1), bob)),
    ]
    loads += [me.Force(b, b.mass * g * ground.y) for b in bodies]
    energy = me.Lagrangian(ground, *bodies)
    return me.LagrangesMethod(energy, [q1, q2], bodies=bodies, forcelist=loads, frame=ground)


# SymPy's systems, joints and actuators


def formed(system: Any, method: Any = me.KanesMethod) -> Any:
    system.form_eoms(eom_method=method)
    return system


@model("SymPy, docs of PinJoint and joints; test_joint.py; test_jointsmethod.py, jointsmethod")
def pin_joint() -> Any:
    wall, link = me.RigidBody("wall"), me.RigidBody("link")
    system = me.System.from_newtonian(wall)
    length, g = syms("l g")
    system.add_joints(
        me.PinJoint("pin", wall, link, child_point=-length * link.x, joint_axis=wall.z)
    )
    system.apply_uniform_gravity(-g * wall.y)
    return formed(system)


@model("SymPy, test_jointsmethod.py, complete_simple_double_pendulum")
def two_pin_joints() -> Any:
    q, u = ds("q1:3"), ds("u1:3")
    m, length, g = syms("m l g")
    wall, first, last = me.RigidBody("C"), me.RigidBody("P", mass=m), me.RigidBody("R", mass=m)
    system = me.System.from_newtonian(wall)
    for parent, link, x, v in ((wall, first, q[0], u[0]), (first, last, q[1], u[1])):
        arm = -length * link.x
        joint = me.PinJoint(
            f"to {link.name}", parent, link, x, v, child_point=arm, joint_axis=wall.z
        )
        system.add_joints(joint)
    system.add_loads(*[(b.masscenter, m * g * wall.x) for b in (first, last)])
    return formed(system)


@model("SymPy, test_jointsmethod.py and test_joint.py, chaos_pendulum")
def chaos_pendulum_of_joints() -> Any:
    m_a, m_b, l_a, l_b, g = syms("m_A m_B l_A l_B g")
    theta, phi, omega, alpha = ds("theta phi omega alpha")
    ground = me.RigidBody("C")
    names = [me.ReferenceFrame("A"), me.ReferenceFrame("B")]
    rod = me.RigidBody("rod", mass=m_a, frame=names[0], inertia=None)
    plate = me.RigidBody("plate", mass=m_b, frame=names[1])
    rod.central_inertia = me.inertia(names[0], *syms("A_x A_y"), 0)
    plate.central_inertia = me.inertia(names[1], *syms("B_x B_y B_z"))
    system = me.System.from_newtonian(ground)
    system.add_joints(
        me.PinJoint("J1", ground, rod, theta, omega, child_point=-l_a * rod.z, joint_axis=ground.y),
        me.PinJoint(
            "J2", rod, plate, phi, alpha, parent_point=(l_b - l_a) * rod.z, joint_axis=rod.z
        ),
    )
    system.add_loads((rod.masscenter, m_a * g * ground.z), (plate.masscenter, m_b * g * ground.z))
    return formed(system)


@model("SymPy, docs of System; test_system_class.py, moving_point_mass")
def slider_and_pin() -> Any:
    rail, cart, bob = me.RigidBody("rail"), me.RigidBody("cart"), me.RigidBody("bob")
    push, length, g = ds("F"), *syms("l g")
    system = me.System.from_newtonian(rail)
    slide = me.PrismaticJoint("slider", rail, cart, joint_axis=rail.x)
    hinge = me.PinJoint("pin", cart, bob, joint_axis=cart.z, child_point=length * bob.y)
    system.add_joints(slide, hinge)
    system.apply_uniform_gravity(-g * rail.y)
    system.add_loads(me.Force(cart, push * rail.x))
    return formed(system)


@model("SymPy, docs of System")
def pin_that_must_stay_above_the_rail() -> Any:
    system = slider_and_pin()
    rail, _, bob = system.bodies
    system.add_holonomic_constraints(bob.masscenter.pos_from(rail.masscenter).dot(system.x))
    (slide, slide_speed), (hinge, hinge_speed) = zip(system.q_ind, system.u_ind, strict=True)
    system.q_ind, system.q_dep = [hinge], [slide]
    system.u_ind, system.u_dep = [hinge_speed], [slide_speed]
    return formed(system)


@model("SymPy, test_system_class.py, cart_pendulum_lagrange; docs of System.form_eoms")
def slider_and_pin_of_lagrange() -> Any:
    qc, qp, push = ds("qc qp F")
    length, m_c, m_p, g, k = syms("l mc mp g k")
    rail, cart = me.RigidBody("rail"), me.RigidBody("cart", mass=m_c)
    bob = me.Particle("bob", mass=m_p)
    own = me.ReferenceFrame("bob")
    system = me.System.from_newtonian(rail)
    system.add_joints(
        me.PrismaticJoint("slider", rail, cart, qc, qc.diff(t), joint_axis=rail.x),
        me.PinJoint("pin", cart, bob, qp, qp.diff(t), joint_axis=cart.z, child_interframe=own,
                    child_point=length * own.y),
    )  # fmt: skip
    bob.potential_energy = m_p * g * bob.masscenter.pos_from(rail.masscenter).dot(rail.y)
    system.add_actuators(me.TorqueActuator(k * qp, cart.z, own, cart.frame))
    system.add_loads(me.Force(cart, push * rail.x))
    return formed(system, me.LagrangesMethod)


@model("SymPy, test_system_class.py, box_on_ground")
def box_with_coulomb_friction() -> Any:
    g, m, mu = syms("g m mu")
    q, u, lift = ds("q u ua")
    normal, push = ds("N F", positive=True)
    box, system = me.Particle("P", mass=m), me.System()
    system.add_bodies(box)
    box.masscenter.set_pos(system.fixed_point, q * system.x)
    box.masscenter.set_vel(system.frame, u * system.x + lift * system.y)
    system.q_ind, system.u_ind, system.u_aux = [q], [u], [lift]
    system.kdes = [q.diff(t) - u]
    system.apply_uniform_gravity(-g * system.y)
    system.add_loads((box.masscenter, normal * system.y + (push - mu * normal) * system.x))
    return formed(system)


@model("SymPy, test_jointsmethod.py, four_bar_linkage; docs, four_bar_linkage_example")
def four_bars_of_joints() -> Any:
    q, u, aux, pull = ds("q1:4"), ds("u1:4"), ds("uaux1:3"), ds("T1:3")
    length, rho = syms("l1:5"), sp.Symbol("rho")
    frames = me.ReferenceFrame("N"), *(me.ReferenceFrame(f"L{i}") for i in (1, 2, 3))
    links = []
    for i, own in enumerate(frames):
        m = rho * length[i]
        links.append(me.RigidBody(f"link {i}", frame=own, mass=m))
        links[-1].central_inertia = me.inertia(own, 0, 0, m * length[i] ** 2 / 12)
    system = me.System.from_newtonian(links[0])
    for i in range(3):
        a, b = links[i], links[i + 1]
        system.add_joints(me.PinJoint(
            f"J{i}", a, b, q[i], u[i], parent_point=length[i] / 2 * a.x,
            child_point=-length[i + 1] / 2 * b.x, joint_axis=a.z,
        ))  # fmt: skip
    start = links[0].masscenter.locatenew("start", -length[0] / 2 * links[0].x)
    end = links[3].masscenter.locatenew("end", length[3] / 2 * links[3].x)
    gap = end.pos_from(start)
    end.v2pt_theory(links[3].masscenter, links[0].frame, links[3].frame)
    end.set_vel(frames[0], end.vel(frames[0]) + along(aux, frames[0]))
    system.add_holonomic_constraints(gap.dot(links[0].x), gap.dot(links[0].y))
    system.add_loads((end, along(pull, frames[0])))
    system.q_ind, system.q_dep = q[:1], q[1:]
    system.u_ind, system.u_dep, system.u_aux = u[:1], u[1:], aux
    return formed(system)


@model("SymPy and PyDy, docs, multidof-holonomic")
def slider_with_two_pendulums() -> Any:
    q, u, (push, torque) = ds("q1:4"), ds("u1:4"), ds("F T")
    length, k, c, g, k_t, m_a, m_b, m_c, moment = syms("l k c g kT ma mb mc IBzz")
    wall, block = me.RigidBody("N"), me.Particle("A", mass=m_a)
    plate, bob = me.RigidBody("B", mass=m_b), me.Particle("C", mass=m_c)
    plate.central_inertia = me.inertia(plate.frame, 0, 0, moment)
    system = me.System.from_newtonian(wall)
    on, off = me.ReferenceFrame("A"), me.ReferenceFrame("C")
    block.masscenter.set_vel(on, 0)
    bob.masscenter.set_vel(off, 0)
    system.add_joints(
        me.PrismaticJoint("J1", wall, block, q[0], u[0], child_interframe=on),
        me.PinJoint("J2", block, plate, q[1], u[1], joint_axis=wall.z, parent_interframe=on,
                    child_point=length * 2 / 3 * plate.y),
        me.PinJoint("J3", plate, bob, q[2], u[2], joint_axis=plate.z, child_interframe=off,
                    parent_point=-length / 3 * plate.y, child_point=length * off.y),
    )  # fmt: skip
    system.apply_uniform_gravity(-g * wall.y)
    system.add_loads(me.Force(block, push * wall.x))
    path = me.LinearPathway(wall.masscenter, block.masscenter)
    system.add_actuators(
        me.LinearSpring(k, path), me.LinearDamper(c, path),
        me.TorqueActuator(torque, wall.z, plate, wall),
        me.TorqueActuator(k_t * q[2], wall.z, plate, off),
    )  # fmt: skip
    return formed(system)


@model("SymPy, docs of CoulombKineticFriction; test_actuator.py")
def friction_of_coulomb_and_stribeck() -> Any:
    x, v = ds("x v")
    m, g, k, mu_k, mu_s, v_s, sigma = syms("m g k mu_k mu_s v_s sigma", positive=True)
    ground, origin = rest()
    p = origin.locatenew("P", x * ground.x)
    p.set_vel(ground, v * ground.x)
    path = me.LinearPathway(origin, p)
    spring = me.LinearSpring(k, path)
    drag = me.CoulombKineticFriction(mu_k, m * g, path, v_s=v_s, sigma=sigma, mu_s=mu_s)
    loads = spring.to_loads() + drag.to_loads()
    return kane(ground, [x], [v], rates([x], [v]), [me.Particle("p", p, m)], loads)


@model("SymPy, docs, atwoods_machine_example; test_pathway.py, WrappingPathway")
def atwoods_machine() -> Any:
    q, u, pull = ds("q u T")
    m1, m2, g, h, r = syms("m1 m2 g h r", positive=True)
    ground, origin = rest()
    ends = [origin.locatenew(f"P{i}", s * r * ground.y - (h + s * q) * ground.z)
            for i, s in enumerate((1, -1))]  # fmt: skip
    for end, s in zip(ends, (1, -1), strict=True):
        end.set_vel(ground, -s * u * ground.z)
    tangent = [origin.locatenew(f"T{s}", s * r * ground.y) for s in (1, -1)]
    for p in tangent:
        p.set_vel(ground, 0)
    wrapped = me.WrappingPathway(*tangent, me.WrappingCylinder(r, origin, ground.x))
    bodies = [me.Particle(p.name, p, m) for p, m in zip(ends, (m1, m2), strict=True)]
    loads = wrapped.to_loads(pull) + [(b.masscenter, -b.mass * g * ground.z) for b in bodies]
    return kane(ground, [q], [u], rates([q], [u]), bodies, loads)


@model("SymPy, docs, biomechanics and biomechanical-model-example")
def muscle_with_a_measured_curve() -> Any:
    q, u = ds("q u")
    m, strength = syms("m F_max")
    ground, origin = rest()
    p = origin.locatenew("P", q * ground.x)
    p.set_vel(ground, u * ground.x)
    pull = -strength * FiberForceLengthActiveDeGroote2016.with_defaults(q)
    return kane(ground, [q], [u], rates([q], [u]), [me.Particle("p", p, m)], [(p, pull * ground.x)])


# PyDy's examples


@model("PyDy, four_bar_linkage_with_motion_constrained_link.ipynb")
def four_bars_with_a_skate() -> Any:
    q, u, torque = ds("q1:5"), ds("u1:5"), ds("T")
    l1, l2, l3, l4, l5, m2, m3, m5, g = syms("l1:6 m2 m3 m5 g")
    ground, origin = rest()
    a = spun(ground, "A", q[0], u[0], ground.z)
    b = spun(a, "B", q[1], u[1], -a.z)
    c, d = spun(b, "C", q[2], u[2], -b.z), spun(b, "D", q[3], u[3], -b.z)
    p2 = fixed(origin, "P2", l1 * a.x, ground, a)
    p3 = fixed(p2, "P3", l2 * b.x, ground, b)
    p5 = fixed(p3, "P5", l5 * d.x, ground, d)
    loop = p3.locatenew("P4", l3 * c.x).pos_from(origin) - l4 * ground.x
    closed = [loop.dot(ground.x), loop.dot(ground.y)]
    speeds = dict(zip([x.diff(t) for x in q], u, strict=True))
    masses = ((p2, m2), (p3, m3), (p5, m5))
    loads = [(p, -m * g * ground.y) for p, m in masses] + [(a, torque * ground.z)]
    return kane(
        ground, [q[0], q[3]], u[:1], rates(q, u), [me.Particle(p.name, p, m) for p, m in masses],
        loads, q_dependent=q[1:3], configuration_constraints=closed, u_dependent=u[1:],
        velocity_constraints=[p5.vel(ground).dot(d.y), *(e.diff(t).subs(speeds) for e in closed)],
    )  # fmt: skip


def robot() -> tuple[Any, Any, list[Any], list[Any]]:
    """A differential drive: energy, frame, coordinates, and six rows of no slip, one of them zero
    for each wheel and one the same for both."""
    x, y, theta, *spin = q = ds("x y theta phi_1 phi_2")
    r, m_w, w, d, m_b = syms("r m_w w d m_b")
    ground, origin = rest()
    body = frame(ground, "R", theta, ground.z)
    middle = origin.locatenew("Cw", x * ground.x + y * ground.y)
    middle.set_vel(ground, x.diff(t) * ground.x + y.diff(t) * ground.y)
    rows, bodies = [], []
    for side, angle in zip((-1, 1), spin, strict=True):
        hub = fixed(middle, f"H{side}", side * w * body.y, ground, body)
        wheel = frame(body, f"W{side}", angle, body.y)
        touch = fixed(hub, "C", -r * body.z, ground, wheel).vel(ground)
        rows += [touch.dot(axis) for axis in ground]
        moments = me.inertia(body, *syms("J_x J_y J_x"))
        bodies.append(me.RigidBody(f"wheel {side}", hub, wheel, m_w, (moments, hub)))
    centre = fixed(middle, "Cm", d * body.x, ground, body)
    moments = me.inertia(body, *syms("Ixx Iyy Izz"))
    bodies.append(me.RigidBody("robot", centre, body, m_b, (moments, centre)))
    return me.Lagrangian(ground, *bodies), ground, q, rows


@model("PyDy, Differential Drive.ipynb")
def differential_drive() -> Any:
    energy, ground, q, rows = robot()
    return me.LagrangesMethod(energy, q, nonhol_coneqs=[rows[0], rows[1], rows[3]], frame=ground)


@model("PyDy, NotebookDynamics_2DoF-Scara.ipynb")
def arm_of_two_links() -> Any:
    q, torques = ds("theta_1 theta_2"), syms("tau_1 tau_2")
    l_1, r_1, r_2, m_1, m_2, moment, g = syms("l_1 r_1 r_2 m_1 m_2 I g", positive=True)
    ground, origin = rest()
    first = frame(ground, "B1", q[0], ground.z)
    second = frame(first, "B2", q[1], first.z)
    elbow = fixed(origin, "A", l_1 * first.x, ground, first)
    c1 = fixed(origin, "C1", r_1 * first.x, ground, first)
    c2 = fixed(elbow, "C2", r_2 * second.x, ground, second)
    inertia = me.inertia(first, 0, 0, moment)
    bodies = [me.RigidBody("1", c1, first, m_1, (inertia, c1)),
              me.RigidBody("2", c2, second, m_2, (inertia, c2))]  # fmt: skip
    for b in bodies:
        b.potential_energy = -b.mass * g * b.masscenter.pos_from(origin).dot(ground.z)
    loads = [(f, tau * ground.z) for f, tau in zip((first, second), torques, strict=True)]
    energy = me.Lagrangian(ground, *bodies)
    return me.LagrangesMethod(energy, q, frame=ground, forcelist=loads)


@model("PyDy, docs, astrobee")
def free_flyer() -> Any:
    q, x = ds("q1:4"), ds("x y z")
    u, v = ds("u_1:4"), ds("u_x u_y u_z")
    ground, origin = rest()
    own = me.ReferenceFrame("B")
    own.orient(ground, "Body", q, "xyz")
    centre = origin.locatenew("C", along(x, ground))
    centre.set_vel(ground, along(v, ground))
    speeds = dict(zip([a.diff(t) for a in q], u, strict=True))
    own.set_ang_vel(ground, own.ang_vel_in(ground).subs(speeds))
    body = me.RigidBody(
        "B", centre, own, sp.Symbol("m"), (me.inertia(own, *syms("I_x I_y I_z")), centre)
    )
    loads = [(centre, along(ds("F1:4"), own)), (own, along(ds("T1:4"), own))]
    return kane(ground, [*x, *q], [*v, *u], rates([*x, *q], [*v, *u]), [body], loads)


@model("PyDy, sliding_ladder.py")
def sliding_ladder() -> Any:
    q, u = ds("q u")
    m, length, g, moment = syms("m l g Izz")
    ground, origin = rest()
    lean = spun(ground, "L", q, u, ground.z)
    centre = origin.locatenew("A", length / 2 * (-sp.cos(q) * ground.x + sp.sin(q) * ground.y))
    centre.set_vel(ground, length / 2 * u * (sp.sin(q) * ground.x + sp.cos(q) * ground.y))
    body = me.RigidBody("ladder", centre, lean, m, (me.inertia(lean, 0, 0, moment), centre))
    return kane(ground, [q], [u], rates([q], [u]), [body], [(centre, -m * g * ground.y)])


@model("PyDy, babyboot.py")
def baby_boot() -> Any:
    q, u = ds("qA qB"), ds("uA uB")
    la, lb, ma, mb, ax, bx, by, bz, g = syms("LA LB mA mB IAx IBx IBy IBz g")
    ground, origin = rest()
    rod = spun(ground, "A", q[0], u[0], ground.x)
    boot = spun(rod, "B", q[1], u[1], rod.z)
    c_a = fixed(origin, "Acm", -la * rod.z, ground, rod)
    c_b = fixed(origin, "Bcm", -lb * rod.z, ground, rod)
    bodies = [me.RigidBody("rod", c_a, rod, ma, (me.inertia(rod, ax, 0, 0), c_a)),
              me.RigidBody("boot", c_b, boot, mb, (me.inertia(boot, bx, by, bz), c_b))]  # fmt: skip
    loads = [(c_a, -ma * g * ground.z), (c_b, -mb * g * ground.z)]
    return kane(ground, q, u, rates(q, u), bodies, loads)


@model(
    "PyDy, three_link_conical_pendulum; docs, three-link-conical-pendulum", "that of no orientation"
)
def conical_pendulum() -> Any:
    """Its angular velocities are set to what is not the rate of its rotations."""
    (alpha, beta), (omega, delta) = ds("alpha beta"), ds("omega delta")
    m, length, g = syms("m l g")
    ground, origin = rest()
    link = me.ReferenceFrame("A")
    link.orient(ground, "Space", [alpha, beta, 0], "ZXY")
    link.set_ang_vel(ground, omega * ground.z + delta * ground.x)
    centre = fixed(origin, "P", -length * link.y, ground, link)
    body = me.RigidBody("link", centre, link, m, (me.inertia(link, *syms("Ixx Iyy Izz")), centre))
    kd = rates([alpha, beta], [omega, delta])
    return kane(ground, [alpha, beta], [omega, delta], kd, [body], [(centre, -m * g * ground.y)])


@model("PyDy, docs, 3d-n-body-pendulum")
def balls_on_rods_that_collide() -> Any:
    q, u = ds("q:6"), ds("u:6")
    m, g, r, length, k = syms("m g r l k")
    ground, joint = rest()
    bodies, kd, parent = [], [], ground
    for i in range(2):
        rod = me.ReferenceFrame(f"A{i}")
        rod.orient_body_fixed(parent, q[3 * i : 3 * i + 3], "123")
        turning = rod.ang_vel_in(ground)
        rod.set_ang_vel(ground, along(u[3 * i : 3 * i + 3], rod))
        kd += [me.dot(turning - rod.ang_vel_in(ground), axis) for axis in rod]
        centre = fixed(joint, f"C{i}", length / 2 * rod.y, ground, rod)
        joint, parent = fixed(joint, f"P{i}", length * rod.y, ground, rod), rod
        moments = me.inertia(rod, *syms("iXX iYY iZZ"))
        bodies.append(me.RigidBody(f"ball {i}", centre, rod, m, (moments, centre)))
    a, b = (body.masscenter for body in bodies)
    gap = b.pos_from(a)
    push = k * (2 * r - gap.magnitude()) * sp.Heaviside(2 * r - gap.magnitude()) * gap.normalize()
    loads = [(p, -m * g * ground.y) for p in (a, b)] + [(b, push), (a, -push)]
    return kane(ground, q, u, kd, bodies, loads)


@model("PyDy, npendulum; models.n_link_pendulum_on_cart; SymPy, test_models.py")
def cart_with_torques() -> Any:
    method = shared.n_pendulum_on_a_cart(2)
    ground, torques = method._inertial, ds("T1:3")
    first, last = (b.masscenter.pos_from(a.masscenter).args[0][1]
                   for a, b in zip(method.bodies, method.bodies[1:], strict=False))  # fmt: skip
    loads = [*method.loads, (ground, -torques[0] * ground.z), (last, torques[1] * ground.z)]
    loads += [(first, (torques[0] - torques[1]) * ground.z)]
    return kane(ground, method.q, method.u, method._k_ku_implicit * method.u
                + method._k_kqdot_implicit * method.q.diff(t), method.bodies, loads)  # fmt: skip


SLOW = ("balls_on_rods_that_collide", "four_bars_with_a_skate")


def method_of(source: Any) -> Any:
    return source.eom_method if isinstance(source, me.System) else source


def by_lagrange(method: Any, seed: str) -> tuple[dict[Any, Any], list[Any]]:
    """A point on the constraints, and the accelerations there by SymPy's multipliers."""
    method.form_lagranges_equations()
    point, rates = numbers(moving_names(method), seed), [*method.q.diff(t)]
    held = [*method._hol_coneqs]
    point = solved(held, [*method.q][: len(held)], point) if held else point
    if method.coneqs:
        rows = sp.Matrix([*method.coneqs])
        left = valued(rows.jacobian(rates), point)
        right = valued(rows, point)
        change = left.T * mp.lu_solve(left * left.T, right)
        point |= {v: point[v] - d for v, d in zip(rates, change, strict=True)}
    full, right = method.mass_matrix_full, method.forcing_full
    count = len(rates)
    return point, [*mp.lu_solve(valued(full, point), valued(right, point))][count : 2 * count]


def agree(source: Any, seed: str) -> None:
    """Our accelerations of a model are those of its method."""
    method = method_of(source)
    system = vo.from_mechanics(source)
    eqs = vo.derive(system)
    with mp.workdps(DIGITS):
        if isinstance(method, me.KanesMethod):
            form = eqs.to_mechanics()
            point, expected = kane_speeds(method, seed)
            idle = (*form.q, *(p.symbol for p in system.parameters), *system.inputs)
            point = dict.fromkeys(idle, mp.mpf("0.7")) | point
            here = mp.lu_solve(valued(form.mass_matrix, point), valued(form.forcing, point))
            pairs = [(rate, expected[u]) for u, rate in zip(form.u, here, strict=True)]
        else:
            point, there = by_lagrange(method, seed)
            named = {k: sp.Float(v, DIGITS) for k, v in point.items() if not k.has(sp.Derivative)}
            named |= {v: sp.Float(point[v], DIGITS) for v in eqs.velocities}
            idle = {p.symbol: 1 for p in system.parameters}
            found = eqs.acceleration(idle | named, digits=DIGITS)
            pairs = [(mp.mpf(str(found[q])), a) for q, a in zip(method.q, there, strict=True)]
    assert pairs
    for ours, theirs in pairs:
        assert abs(ours - theirs) < CLOSE * (1 + abs(theirs)), (seed, pairs)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in MODELS]
)
def test_models_go_in_as_they_are_or_are_refused_with_the_reason(name: str) -> None:
    entry = MODELS[name]
    if not entry.refused:
        agree(entry.make(), name)
        return
    with pytest.raises(vo.DefinitionError) as refusal:
        vo.derive(vo.from_mechanics(entry.make()))
    assert entry.refused in str(refusal.value) and "\n" not in str(refusal.value)

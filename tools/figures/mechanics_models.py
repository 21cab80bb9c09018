"""Models of SymPy's and PyDy's documentation and tests, written anew with SymPy's mechanics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy as sp
from sympy.physics import mechanics as me

ds = me.dynamicsymbols


def frame(parent: Any, name: str, angle: Any, axis: Any) -> Any:
    """A frame turned about an axis of its parent."""
    return parent.orientnew(name, "Axis", [angle, axis])


def kane(inertial: Any, q: Any, u: Any, kd: Any, bodies: Any, loads: Any, **more: Any) -> Any:
    """A KanesMethod."""
    return me.KanesMethod(
        inertial, q_ind=q, u_ind=u, kd_eqs=kd, bodies=bodies, forcelist=loads, **more
    )


def auxiliary_speeds(method: Any) -> list[Any]:
    """Those of a KanesMethod."""
    return [*method._uaux]


def rolling_disc() -> Any:
    """Contact point said to be at rest; speeds along axes of the leaning frame."""
    q, u = ds("q1:4"), ds("u1:4")
    r, m, g = sp.symbols("r m g")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "Y", q[0], ground.z)
    lean = frame(yaw, "L", q[1], yaw.x)
    disc = frame(lean, "R", q[2], lean.y)
    turning = disc.ang_vel_in(ground)
    disc.set_ang_vel(ground, u[0] * lean.x + u[1] * lean.y + u[2] * lean.z)
    contact = me.Point("C")
    contact.set_vel(ground, 0)
    centre = contact.locatenew("D", r * lean.z)
    centre.v2pt_theory(contact, ground, disc)
    kd = [me.dot(disc.ang_vel_in(ground) - turning, axis) for axis in lean]
    moments = me.inertia(lean, m * r**2 / 4, m * r**2 / 2, m * r**2 / 4)
    body = me.RigidBody("disc", centre, disc, m, (moments, centre))
    return kane(ground, q, u, kd, [body], [(centre, -m * g * yaw.z)])


def rolling_disc_with_contact_forces() -> Any:
    """Auxiliary speeds of the contact point bring the contact forces in."""
    q, u, aux, forces = ds("q1:4"), ds("u1:4"), ds("u4:7"), ds("f1:4")
    r, m, g = sp.symbols("r m g")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "Y", q[0], ground.z)
    lean = frame(yaw, "L", q[1], yaw.x)
    disc = frame(lean, "R", q[2], lean.y)
    turning = disc.ang_vel_in(ground)
    disc.set_ang_vel(ground, u[0] * lean.x + u[1] * lean.y + u[2] * lean.z)
    contact = me.Point("C")
    contact.set_vel(ground, aux[0] * lean.x + aux[1] * me.cross(yaw.z, lean.x) + aux[2] * yaw.z)
    centre = contact.locatenew("D", r * lean.z)
    centre.v2pt_theory(contact, ground, disc)
    kd = [me.dot(disc.ang_vel_in(ground) - turning, axis) for axis in lean]
    moments = me.inertia(lean, m * r**2 / 4, m * r**2 / 2, m * r**2 / 4)
    body = me.RigidBody("disc", centre, disc, m, (moments, centre))
    push = forces[0] * lean.x + forces[1] * me.cross(yaw.z, lean.x) + forces[2] * yaw.z
    loads = [(centre, -m * g * yaw.z), (contact, push)]
    return kane(ground, q, u, kd, [body], loads, u_auxiliary=aux)


def rolling_disc_with_dependent_speeds() -> Any:
    """The height of the centre is a dependent coordinate, its velocity three dependent speeds."""
    q, u = ds("q0:4"), ds("u0:6")
    r, m, g, moment, spin = sp.symbols("r m g I J")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "A", q[0], ground.z)
    lean = frame(yaw, "B", q[1], yaw.x)
    disc = frame(lean, "C", q[2], lean.y)
    rates = [x.diff(sp.Symbol("t")) for x in q]
    turning = rates[0] * yaw.z + rates[1] * lean.x + rates[2] * lean.y
    disc.set_ang_vel(ground, u[0] * lean.x + u[1] * lean.y + u[2] * lean.z)
    contact = me.Point("P")
    contact.set_vel(ground, 0)
    centre = contact.locatenew("O", q[3] * yaw.z + r * sp.sin(q[1]) * yaw.y)
    centre.set_vel(ground, u[3] * yaw.x + u[4] * yaw.y + u[5] * yaw.z)
    arm = centre.pos_from(contact)
    kd = [me.dot(turning - disc.ang_vel_in(ground), axis) for axis in lean]
    rise = arm.diff(sp.Symbol("t"), yaw) + me.cross(yaw.ang_vel_in(ground), arm)
    kd += [me.dot(rise - centre.vel(ground), yaw.z)]
    slip = centre.vel(ground) - me.cross(disc.ang_vel_in(ground), arm)
    body = me.RigidBody("disc", centre, disc, m, (me.inertia(lean, moment, spin, moment), centre))
    return kane(
        ground, q[:3], u[:3], kd, [body], [(centre, m * g * yaw.z)],
        q_dependent=q[3:], configuration_constraints=[me.dot(-r * lean.z, yaw.z) - q[3]],
        u_dependent=u[3:], velocity_constraints=[me.dot(slip, axis) for axis in yaw],
    )  # fmt: skip


def rolling_disc_on_the_plane() -> Any:
    """Five coordinates, two nonholonomic constraints, Lagrange's method."""
    x, y, psi, theta, phi = q = ds("x y psi theta phi")
    r, m, g, moment, spin = sp.symbols("r m g I J")
    t = sp.Symbol("t")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "Y", psi, ground.z)
    lean = frame(yaw, "L", theta, yaw.x)
    disc = frame(lean, "R", phi, lean.y)
    origin = me.Point("O")
    origin.set_vel(ground, 0)
    centre = origin.locatenew("D", x * ground.x + y * ground.y + r * lean.z)
    centre.set_vel(ground, centre.pos_from(origin).dt(ground))
    body = me.RigidBody("disc", centre, disc, m, (me.inertia(lean, moment, spin, moment), centre))
    body.potential_energy = m * g * r * sp.cos(theta)
    contact = centre.vel(ground) + me.cross(disc.ang_vel_in(ground), -r * lean.z)
    rolling = [me.dot(contact, axis) for axis in (ground.x, ground.y)]
    assert all(c.has(x.diff(t)) or c.has(y.diff(t)) for c in rolling)
    return me.LagrangesMethod(me.Lagrangian(ground, body), q, nonhol_coneqs=rolling, frame=ground)


def pendulum_in_the_plane() -> Any:
    """Two redundant coordinates and a rod: Lagrange's method."""
    q1, q2 = ds("q1 q2")
    m, length, g = sp.symbols("m L g")
    ground = me.ReferenceFrame("N")
    pivot = me.Point("O")
    pivot.set_vel(ground, 0)
    bob = pivot.locatenew("P", q1 * ground.x + q2 * ground.y)
    bob.set_vel(ground, bob.pos_from(pivot).dt(ground))
    mass = me.Particle("bob", bob, m)
    return me.LagrangesMethod(
        me.Lagrangian(ground, mass), [q1, q2], hol_coneqs=[q1**2 + q2**2 - length**2],
        forcelist=[(bob, m * g * ground.x)], frame=ground,
    )  # fmt: skip


def pendulum_with_dependent_coordinate() -> Any:
    """The same with Kane's method: q1, u1 depend on q2, u2, which are free where it hangs."""
    q1, q2, u1, u2 = ds("q1 q2 u1 u2")
    m, length, g = sp.symbols("m L g")
    t = sp.Symbol("t")
    ground = me.ReferenceFrame("N")
    pivot = me.Point("O")
    pivot.set_vel(ground, 0)
    bob = pivot.locatenew("P", q1 * ground.x + q2 * ground.y)
    bob.set_vel(ground, u1 * ground.x + u2 * ground.y)
    rod = q1**2 + q2**2 - length**2
    return kane(
        ground, [q2], [u2], [q2.diff(t) - u2, q1.diff(t) - u1], [me.Particle("bob", bob, m)],
        [(bob, m * g * ground.x)], q_dependent=[q1], configuration_constraints=[rod],
        u_dependent=[u1], velocity_constraints=[q1 * u1 + q2 * u2],
    )  # fmt: skip


def four_bar_linkage() -> Any:
    """A loop of three links over a base, closed by two configuration constraints."""
    q, u = ds("q1:4"), ds("u1:4")
    la, lb, lc, ln, m, g = sp.symbols("l_a l_b l_c l_n m g")
    t = sp.Symbol("t")
    ground = me.ReferenceFrame("N")
    links = [frame(ground, "A", q[0], ground.z)]
    links += [frame(links[0], "B", q[1], links[0].z)]
    links += [frame(links[1], "C", q[2], links[1].z)]
    parent = ground
    for link, speed in zip(links, u, strict=True):
        link.set_ang_vel(parent, speed * ground.z)
        parent = link
    points = [me.Point("P1")]
    points[0].set_vel(ground, 0)
    for link, length in zip(links, (la, lb, lc), strict=True):
        points.append(points[-1].locatenew(f"P{len(points) + 1}", length * link.x))
        points[-1].v2pt_theory(points[-2], ground, link)
    masses = [me.Particle(f"mass{i}", p, m) for i, p in enumerate(points[1:3])]
    loop = points[3].pos_from(points[0]) - ln * ground.x
    closed = [me.dot(loop, axis) for axis in (ground.x, ground.y)]
    speeds = dict(zip([x.diff(t) for x in q], u, strict=True))
    return kane(
        ground, q[:1], u[:1], [v - x.diff(t) for x, v in zip(q, u, strict=True)], masses,
        [(p.masscenter if hasattr(p, "masscenter") else p.point, -m * g * ground.y)
         for p in masses],
        q_dependent=q[1:], configuration_constraints=closed, u_dependent=u[1:],
        velocity_constraints=[c.diff(t).subs(speeds) for c in closed],
    )  # fmt: skip


def three_wheeled_carriage() -> Any:
    """Kane and Levinson's carriage on an incline: a speed that no coordinate belongs to."""
    q1, q2, q3 = ds("q1:4")
    u1, u2, u4, u5 = ds("u1 u2 u4 u5")
    r, m_all, g, e, tilt = sp.symbols("R M g e theta")
    a, b, m_a, m_b, i_a, spin, across = sp.symbols("a b m_A m_B I_A J K")
    t = sp.Symbol("t")
    level = me.ReferenceFrame("F")
    plane = frame(level, "P", -tilt, level.y)
    body = frame(plane, "A", q1, plane.x)
    body.set_ang_vel(level, u1 * body.x)
    wheels = [frame(body, "B", q2, body.z), frame(body, "C", q3, body.z)]
    for wheel, speed in zip(wheels, (u4, u5), strict=True):
        wheel.set_ang_vel(body, speed * body.z)
    axle = me.Point("D")
    axle.set_vel(body, 0)
    axle.set_vel(level, u2 * body.y)
    places = {"S": e * body.y, "A*": a * body.y, "B*": b * body.z, "C*": -b * body.z}
    points = {name: axle.locatenew(name, place) for name, place in places.items()}
    for point in points.values():
        point.v2pt_theory(axle, level, body)
    slips = []
    for wheel, centre in zip(wheels, ("B*", "C*"), strict=True):
        lowest = points[centre].locatenew(centre[0] + "^", -r * body.x)
        lowest.v2pt_theory(points[centre], level, wheel)
        slips.append(me.dot(lowest.vel(level), body.y))
    moments = me.inertia(wheels[0], across, across, spin)
    other = me.inertia(wheels[1], across, across, spin)
    own = me.inertia(body, i_a, 2 * i_a, 3 * i_a)
    bodies = [
        me.RigidBody("frame", points["A*"], body, m_a, (own, points["A*"])),
        me.RigidBody("left", points["B*"], wheels[0], m_b, (moments, points["B*"])),
        me.RigidBody("right", points["C*"], wheels[1], m_b, (other, points["C*"])),
    ]
    return kane(
        level, [q1, q2, q3], [u1, u2], [q1.diff(t) - u1, q2.diff(t) - u4, q3.diff(t) - u5],
        bodies, [(points["S"], -m_all * g * level.x)],
        u_dependent=[u4, u5], velocity_constraints=slips,
    )  # fmt: skip


def chaos_pendulum() -> Any:
    """A plate that swings and turns about its rod."""
    theta, phi, omega, alpha = ds("theta phi omega alpha")
    m_r, m_p, length, h, w, g = sp.symbols("m_A m_B l_B h w g")
    t = sp.Symbol("t")
    ground = me.ReferenceFrame("N")
    rod = frame(ground, "A", theta, ground.y)
    plate = frame(rod, "B", phi, rod.z)
    rod.set_ang_vel(ground, omega * ground.y)
    plate.set_ang_vel(rod, alpha * rod.z)
    pivot = me.Point("No")
    pivot.set_vel(ground, 0)
    middle = pivot.locatenew("Ao", (length - h / 2) / 2 * rod.z)
    hung = pivot.locatenew("Bo", length * rod.z)
    for point in (middle, hung):
        point.v2pt_theory(pivot, ground, rod)
    thin = m_r * (length - h / 2) ** 2 / 12
    flat = me.inertia(plate, m_p * h**2 / 12, m_p * (w**2 + h**2) / 12, m_p * w**2 / 12)
    bodies = [
        me.RigidBody("rod", middle, rod, m_r, (me.inertia(rod, thin, thin, 0), middle)),
        me.RigidBody("plate", hung, plate, m_p, (flat, hung)),
    ]
    kd = [theta.diff(t) - omega, phi.diff(t) - alpha]
    loads = [(middle, m_r * g * ground.z), (hung, m_p * g * ground.z)]
    return kane(ground, [theta, phi], [omega, alpha], kd, bodies, loads)


def rattleback() -> Any:
    """An ellipsoid that rolls on a plane, contact point at rest (PyDy's example)."""
    q, u = ds("q1:4"), ds("u1:4")
    a, b, c, m, g = sp.symbols("a b c m g")
    xx, yy, zz, xy = sp.symbols("I_xx I_yy I_zz I_xy")
    t = sp.Symbol("t")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "Y", q[0], ground.z)
    lean = frame(yaw, "L", q[1], yaw.x)
    stone = frame(lean, "R", q[2], lean.y)
    turning = stone.ang_vel_in(ground)
    down = [me.dot(yaw.z, axis) for axis in stone]
    size = sp.sqrt((a * down[0]) ** 2 + (b * down[1]) ** 2 + (c * down[2]) ** 2)
    contact = me.Point("P")
    arm = (a**2 * down[0] * stone.x + b**2 * down[1] * stone.y + c**2 * down[2] * stone.z) / size
    centre = contact.locatenew("O", arm)
    stone.set_ang_vel(ground, u[0] * stone.x + u[1] * stone.y + u[2] * stone.z)
    centre.set_vel(ground, me.cross(stone.ang_vel_in(ground), arm))
    kd = [me.dot(turning - stone.ang_vel_in(ground), axis) for axis in stone]
    assert all(k.has(t) for k in kd)
    body = me.RigidBody("stone", centre, stone, m, (me.inertia(stone, xx, yy, zz, xy), centre))
    return kane(ground, q, u, kd, [body], [(centre, -m * g * yaw.z)])


def body_with_a_quaternion() -> Any:
    """A free body, its attitude a quaternion, its place and velocity along its own axes: SymPy's
    test of kinematic equations that are not solved for the rates."""
    turned, place = ds("lambda_0:4", real=True), ds("B_x:z")
    u, w = ds("U V W"), ds("P Q R")
    push, torque = ds("T_x:z"), ds("M_x:z")
    m, moments = sp.symbols("m"), sp.symbols("J_x:z")
    t = sp.Symbol("t")
    ground = me.ReferenceFrame("N")
    own = ground.orientnew("B", "Quaternion", turned)
    origin = me.Point("O")
    origin.set_vel(ground, 0)
    centre = origin.locatenew("C", sum((x * e for x, e in zip(place, own, strict=True)), 0 * own.x))
    omega, moved = own.ang_vel_in(ground), centre.vel(ground)
    own.set_ang_vel(ground, sum((x * e for x, e in zip(w, own, strict=True)), 0 * own.x))
    kd = [me.dot(own.ang_vel_in(ground) - omega, axis) for axis in own]
    centre.set_vel(ground, sum((x * e for x, e in zip(u, own, strict=True)), 0 * own.x))
    kd += [me.dot(centre.vel(ground) - moved, axis) for axis in own]
    kd += [sum(x * x.diff(t) for x in turned)]
    body = me.RigidBody("body", centre, own, m, (me.inertia(own, *moments), centre))
    loads = [(centre, sum((x * e for x, e in zip(push, own, strict=True)), 0 * own.x))]
    loads += [(own, sum((x * e for x, e in zip(torque, own, strict=True)), 0 * own.x))]
    return kane(
        ground, [*turned[1:], *place], [*u, *w], kd, [body], loads, q_dependent=turned[:1],
        configuration_constraints=[sum(x**2 for x in turned) - 1], velocity_constraints=[],
        u_dependent=[], u_auxiliary=[],
    )  # fmt: skip


def n_pendulum_on_a_cart(n: int = 2) -> Any:
    """A cart that is pushed, with a chain of rods (PyDy's model)."""
    q, u, push = ds(f"q0:{n + 1}"), ds(f"u0:{n + 1}"), ds("F")
    masses, lengths = sp.symbols(f"m0:{n + 1}"), sp.symbols(f"l0:{n}")
    g, t = sp.symbols("g t")
    ground = me.ReferenceFrame("I")
    origin = me.Point("O")
    origin.set_vel(ground, 0)
    joint = origin.locatenew("P0", q[0] * ground.x)
    joint.set_vel(ground, u[0] * ground.x)
    bodies, loads = [me.Particle("Pa0", joint, masses[0])], [(joint, push * ground.x)]
    loads += [(joint, -masses[0] * g * ground.y)]
    for i in range(n):
        rod = frame(ground, f"B{i}", q[i + 1], ground.z)
        rod.set_ang_vel(ground, u[i + 1] * ground.z)
        bob = joint.locatenew(f"P{i + 1}", lengths[i] * rod.x)
        bob.v2pt_theory(joint, ground, rod)
        bodies.append(me.Particle(f"Pa{i + 1}", bob, masses[i + 1]))
        loads.append((bob, -masses[i + 1] * g * ground.y))
        joint = bob
    kd = [x.diff(t) - v for x, v in zip(q, u, strict=True)]
    return kane(ground, q, u, kd, bodies, loads)


def skate() -> Any:
    """Chaplygin's sleigh: a knife edge, damped, with a torque that is given in time."""
    x, y, phi, v, w, s = ds("x y phi v w s")
    m, moment, a, c = sp.symbols("m I a c")
    torque, t = ds("T"), sp.Symbol("t")
    ground = me.ReferenceFrame("N")
    blade = frame(ground, "B", phi, ground.z)
    blade.set_ang_vel(ground, w * ground.z)
    edge = me.Point("E")
    edge.set_vel(ground, v * blade.x + s * blade.y)
    centre = edge.locatenew("G", a * blade.x)
    centre.v2pt_theory(edge, ground, blade)
    body = me.RigidBody("sleigh", centre, blade, m, (me.inertia(blade, 1, 1, moment), centre))
    along = [me.dot(edge.vel(ground), axis) for axis in (ground.x, ground.y)]
    kd = [x.diff(t) - along[0], y.diff(t) - along[1], phi.diff(t) - w]
    loads = [(edge, -c * v * blade.x), (blade, torque * ground.z)]
    return kane(
        ground, [x, y, phi], [v, w], kd, [body], loads, u_dependent=[s], velocity_constraints=[s]
    )


def whipple_bicycle() -> Any:
    """The bicycle of the benchmark: rear frame, fork, two knife-edge wheels; spins and the yaw of
    the contact are left out of the coordinates where nothing depends on them."""
    # long because it is a list: frames, points, rates, bodies and loads of one model
    q1, q2, q4, q5 = ds("q1 q2 q4 q5")
    u1, u2, u3, u4, u5, u6 = ds("u1:7")
    r_f, r_r, tilt, offset, fork_length, frame_length = sp.symbols(
        "r_F r_R tilt offset forklength framelength"
    )
    f1, f3, b1, b3, g = sp.symbols("fork1 fork3 frame1 frame3 g")
    m_b, m_h, m_f, m_r = sp.symbols("m_B m_H m_F m_R")
    w11, w22, v11, v22 = sp.symbols("I_R11 I_R22 I_F11 I_F22")
    bb = sp.symbols("I_B11 I_B22 I_B33 I_B31")
    hh = sp.symbols("I_H11 I_H22 I_H33 I_H31")
    t = sp.Symbol("t")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "Y", q1, ground.z)
    roll = frame(yaw, "R", q2, yaw.x)
    rear = frame(roll, "B", q4 + tilt, roll.y)
    rear_axes = frame(rear, "BB", -tilt, rear.y)
    fork = frame(rear, "H", q5, rear.x)
    fork_axes = frame(fork, "HH", -tilt, fork.y)
    wheels = me.ReferenceFrame("WR"), me.ReferenceFrame("WF")
    contact = me.Point("contact")
    hub = contact.locatenew("hub", r_r * roll.z)
    head = hub.locatenew("head", frame_length * rear.z)
    rear_mass = hub.locatenew("rear mass", -b1 * rear.x + b3 * rear.z)
    fork_mass = head.locatenew("fork mass", -f1 * fork.x + f3 * fork.z)
    front = head.locatenew("front", fork_length * fork.x + offset * fork.z)
    down = (me.dot(fork.y, yaw.z) * fork.y - yaw.z).normalize()
    lowest = front.locatenew("lowest", r_f * down)
    yaw.set_ang_vel(ground, u1 * yaw.z)
    roll.set_ang_vel(yaw, u2 * roll.x)
    wheels[0].set_ang_vel(rear, u3 * rear.y)
    rear.set_ang_vel(roll, u4 * rear.y)
    fork.set_ang_vel(rear, u5 * fork.x)
    wheels[1].set_ang_vel(fork, u6 * fork.y)
    contact.set_vel(ground, 0)
    hub.v2pt_theory(contact, ground, wheels[0])
    head.v2pt_theory(hub, ground, rear)
    rear_mass.v2pt_theory(hub, ground, rear)
    fork_mass.v2pt_theory(head, ground, fork)
    front.v2pt_theory(head, ground, fork)
    lowest.v2pt_theory(front, ground, wheels[1])

    def moments(axes: Any, values: Any) -> Any:
        return me.inertia(axes, *values[:3], 0, 0, values[3])

    bodies = [
        me.RigidBody("rear", rear_mass, rear, m_b, (moments(rear_axes, bb), rear_mass)),
        me.RigidBody("fork", fork_mass, fork, m_h, (moments(fork_axes, hh), fork_mass)),
        me.RigidBody("rear wheel", hub, wheels[0], m_r, (me.inertia(rear, w11, w22, w11), hub)),
        me.RigidBody(
            "front wheel", front, wheels[1], m_f, (me.inertia(fork, v11, v22, v11), front)
        ),
    ]
    loads = [(p, -m * g * yaw.z) for p, m in
             ((rear_mass, m_b), (fork_mass, m_h), (front, m_f), (hub, m_r))]  # fmt: skip
    return kane(
        ground, [q1, q2, q5], [u2, u3, u5],
        [q1.diff(t) - u1, q2.diff(t) - u2, q4.diff(t) - u4, q5.diff(t) - u5], bodies, loads,
        q_dependent=[q4], configuration_constraints=[me.dot(lowest.pos_from(contact), yaw.z)],
        u_dependent=[u1, u4, u6],
        velocity_constraints=[me.dot(lowest.vel(ground), axis) for axis in yaw],
    )  # fmt: skip


MODELS: dict[str, Callable[[], Any]] = {
    make.__name__: make
    for make in (
        rolling_disc,
        rolling_disc_with_contact_forces,
        rolling_disc_with_dependent_speeds,
        rolling_disc_on_the_plane,
        pendulum_in_the_plane,
        pendulum_with_dependent_coordinate,
        four_bar_linkage,
        three_wheeled_carriage,
        chaos_pendulum,
        rattleback,
        body_with_a_quaternion,
        n_pendulum_on_a_cart,
        skate,
        whipple_bicycle,
    )
}

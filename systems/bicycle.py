"""The Whipple bicycle: nine coordinates, two knife-edge wheels rolling without slip.

Axes of the vehicle convention: x forward, y to the right, z down; the ground is z = 0.  The rear
frame is turned by the yaw ``psi``, then the roll ``phi``, then the pitch ``theta``; the front
assembly turns by the steer ``delta`` about an axis tilted back by ``tilt``.  (x, y, z) is the
centre of the rear wheel; the wheels turn by ``beta_R`` and ``beta_F`` about their axles, so that
both rates are negative in forward motion.  Every vector below is a triple of components in the
frame that its comment names.
"""

from __future__ import annotations

from functools import partial

import sympy as sp

from voronec import Fibration, Parameter, Scene, System, velocity

Vector = tuple[sp.Expr, sp.Expr, sp.Expr]

x, y, z, psi, phi, theta, delta, beta_R, beta_F = sp.symbols(
    "x y z psi phi theta delta beta_R beta_F"
)
w, c, tilt, g = sp.symbols("w c tilt g")
r_R, m_R, I_Rxx, I_Ryy = sp.symbols("r_R m_R I_Rxx I_Ryy")
r_F, m_F, I_Fxx, I_Fyy = sp.symbols("r_F m_F I_Fxx I_Fyy")
x_B, z_B, m_B, I_Bxx, I_Bxz, I_Byy, I_Bzz = sp.symbols("x_B z_B m_B I_Bxx I_Bxz I_Byy I_Bzz")
x_H, z_H, m_H, I_Hxx, I_Hxz, I_Hyy, I_Hzz = sp.symbols("x_H z_H m_H I_Hxx I_Hxz I_Hyy I_Hzz")
k_S, a_S, b_S = sp.symbols("k_S a_S b_S")

(Dx, Dy, Dz, Dpsi, Dphi, Dtheta, Ddelta, DR, DF) = map(
    velocity, (x, y, z, psi, phi, theta, delta, beta_R, beta_F)
)


def about_x(angle: sp.Expr, a: Vector) -> Vector:
    """Components in the frame turned by ``angle`` about the first axis."""
    cos, sin = sp.cos(angle), sp.sin(angle)
    return a[0], cos * a[1] + sin * a[2], cos * a[2] - sin * a[1]


def about_y(angle: sp.Expr, a: Vector) -> Vector:
    """Components in the frame turned by ``angle`` about the second axis."""
    cos, sin = sp.cos(angle), sp.sin(angle)
    return cos * a[0] - sin * a[2], a[1], cos * a[2] + sin * a[0]


def about_z(angle: sp.Expr, a: Vector) -> Vector:
    """Components in the frame turned by ``angle`` about the third axis."""
    cos, sin = sp.cos(angle), sp.sin(angle)
    return cos * a[0] + sin * a[1], cos * a[1] - sin * a[0], a[2]


def add(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a: Vector, b: Vector) -> sp.Expr:
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def twice_spin(omega: Vector, xx: sp.Expr, yy: sp.Expr, zz: sp.Expr, xz: sp.Expr) -> sp.Expr:
    """omega . I omega for a body that is symmetric about its plane y = 0."""
    quadratic = xx * omega[0] ** 2 + yy * omega[1] ** 2 + zz * omega[2] ** 2
    return quadratic + 2 * xz * omega[0] * omega[2]


# Rolled frame (yaw, roll): velocity of the rear wheel's centre, rate of turn, the downward unit.
heading = about_z(psi, (Dx, Dy, Dz))
rolled = about_x(phi, heading)
rolled_omega = (Dphi, Dpsi * sp.sin(phi) + Dtheta, Dpsi * sp.cos(phi))
rolled_down = (sp.Integer(0), sp.sin(phi), sp.cos(phi))

# Rear frame (yaw, roll, pitch).
pitch = partial(about_y, theta)
rear_velocity, rear_omega, rear_down = pitch(rolled), pitch(rolled_omega), pitch(rolled_down)
rear_body = (x_B, sp.Integer(0), z_B + r_R)
rear_body_velocity = add(rear_velocity, cross(rear_omega, rear_body))

# Front assembly: the axes of the steered head tube, third axis down the steering axis, which
# passes at ``offset`` before the rear wheel's centre.
head = partial(about_y, tilt + theta)
offset = (w + c) * sp.cos(tilt) - r_R * sp.sin(tilt)
steer = partial(about_z, delta)
axis_velocity = add(head(rolled), cross(head(rolled_omega), (offset, sp.Integer(0), sp.Integer(0))))
front_velocity = steer(axis_velocity)
front_omega = add(steer(head(rolled_omega)), (sp.Integer(0), sp.Integer(0), Ddelta))
front_down = steer(head(rolled_down))


def from_axis(forward: sp.Expr, downward: sp.Expr) -> Vector:
    """Head-tube components, from the axis, of a point given from the rear wheel's centre."""
    point = about_y(tilt, (forward, sp.Integer(0), downward))
    return point[0] - offset, point[1], point[2]


handlebar = from_axis(x_H, z_H + r_R)
handlebar_velocity = add(front_velocity, cross(front_omega, handlebar))
handlebar_omega = about_y(-tilt, front_omega)
hub = (r_F * sp.sin(tilt) - c * sp.cos(tilt), sp.Integer(0), from_axis(w, r_R - r_F)[2])
hub_velocity = add(front_velocity, cross(front_omega, hub))

rear_wheel_omega = (rolled_omega[0], rolled_omega[1] + DR, rolled_omega[2])
front_wheel_omega = (front_omega[0], front_omega[1] + DF, front_omega[2])

kinetic = (
    m_R * (Dx**2 + Dy**2 + Dz**2)
    + twice_spin(rear_wheel_omega, I_Rxx, I_Ryy, I_Rxx, sp.Integer(0))
    + m_B * dot(rear_body_velocity, rear_body_velocity)
    + twice_spin(rear_omega, I_Bxx, I_Byy, I_Bzz, I_Bxz)
    + m_H * dot(handlebar_velocity, handlebar_velocity)
    + twice_spin(handlebar_omega, I_Hxx, I_Hyy, I_Hzz, I_Hxz)
    + m_F * dot(hub_velocity, hub_velocity)
    + twice_spin(front_wheel_omega, I_Fxx, I_Fyy, I_Fxx, sp.Integer(0))
) / 2
axis_height = z + offset * head(rolled_down)[0]
hub_height = axis_height + dot(front_down, hub)
# A spring from the down tube to the fork that centres the steering; the benchmark has none.
stretch = sp.sqrt(a_S**2 + b_S**2 - 2 * a_S * b_S * sp.cos(delta)) - (a_S - b_S)
potential = k_S * stretch**2 / 2 - g * (
    m_R * z
    + m_B * (z + dot(rear_down, rear_body))
    + m_H * (axis_height + dot(front_down, handlebar))
    + m_F * hub_height
)

# The lowest point of the front wheel: the downward unit laid into the plane of the wheel.
sine = sp.sqrt(1 - front_down[1] ** 2)
lever = (r_F * front_down[0] / sine, sp.Integer(0), r_F * front_down[2] / sine)
front_slip = add(hub_velocity, cross(front_omega, lever))
rear_slip = add(rolled, cross(rear_wheel_omega, (sp.Integer(0), sp.Integer(0), r_R)))

# Each slip vanishes: along the track, along the axle, and downwards.
constraints = (
    rear_slip[0],
    rear_slip[1],
    Dz - r_R * sp.sin(phi) * Dphi,
    (hub_velocity[0] * front_down[2] - hub_velocity[2] * front_down[0])
    + r_F * sine * front_wheel_omega[1],
    front_slip[1],
    # Turning about the axle does not raise the lowest point: only the lateral slip enters.
    dot((hub_velocity[0], front_slip[1], hub_velocity[2]), front_down),
)

SYSTEM = System(
    name="bicycle",
    title="Whipple bicycle",
    description="Rear frame with rider, front assembly and two knife-edge wheels on a plane.",
    fibration=Fibration(base=(phi, delta, beta_R), fibre=(x, y, z, psi, theta, beta_F)),
    lagrangian=kinetic - potential,
    constraints=constraints,
    parameters=(
        Parameter(w, sp.Rational("1.02"), positive=True, meaning="wheelbase"),
        Parameter(c, sp.Rational("0.08"), meaning="trail"),
        Parameter(tilt, sp.pi / 10, meaning="backward tilt of the steering axis"),
        Parameter(g, sp.Rational("9.81"), meaning="gravity"),
        Parameter(r_R, sp.Rational("0.3"), positive=True, meaning="radius, rear wheel"),
        Parameter(m_R, 2, positive=True, meaning="mass, rear wheel"),
        Parameter(I_Rxx, sp.Rational("0.0603"), positive=True, meaning="rear wheel, diameter"),
        Parameter(I_Ryy, sp.Rational("0.12"), positive=True, meaning="rear wheel, axle"),
        Parameter(x_B, sp.Rational("0.3"), meaning="rear body, forward of the rear contact"),
        Parameter(z_B, sp.Rational("-0.9"), meaning="rear body, below the ground"),
        Parameter(m_B, 85, positive=True, meaning="mass, rear body and rider"),
        Parameter(I_Bxx, sp.Rational("9.2"), positive=True),
        Parameter(I_Bxz, sp.Rational("2.4")),
        Parameter(I_Byy, 11, positive=True),
        Parameter(I_Bzz, sp.Rational("2.8"), positive=True),
        Parameter(x_H, sp.Rational("0.9"), meaning="handlebar, forward of the rear contact"),
        Parameter(z_H, sp.Rational("-0.7"), meaning="handlebar, below the ground"),
        Parameter(m_H, 4, positive=True, meaning="mass, handlebar and fork"),
        Parameter(I_Hxx, sp.Rational("0.05892"), positive=True),
        Parameter(I_Hxz, sp.Rational("-0.00756")),
        Parameter(I_Hyy, sp.Rational("0.06"), positive=True),
        Parameter(I_Hzz, sp.Rational("0.00708"), positive=True),
        Parameter(r_F, sp.Rational("0.35"), positive=True, meaning="radius, front wheel"),
        Parameter(m_F, 3, positive=True, meaning="mass, front wheel"),
        Parameter(I_Fxx, sp.Rational("0.1405"), positive=True, meaning="front wheel, diameter"),
        Parameter(I_Fyy, sp.Rational("0.28"), positive=True, meaning="front wheel, axle"),
        Parameter(k_S, 0, lower=0, meaning="stiffness of the steering spring"),
        Parameter(a_S, sp.Rational("0.25"), positive=True, meaning="spring's end on the frame"),
        Parameter(b_S, sp.Rational("0.05"), positive=True, meaning="spring's end on the fork"),
    ),
    integrals={
        "energy": kinetic + potential,
        "rear contact": z + r_R * sp.cos(phi),
        "front contact": hub_height + r_F * sine,
    },
    scenes={
        # Both wheels touch the ground where the frame is upright and (z, pitch) = (-r_R, 0).
        "default": Scene(
            initial={z: sp.Rational("-0.3"), Dphi: sp.Rational("0.5"), DR: -sp.Rational(46, 3)},
            times=(0.0, 5.0),
            outputs=(phi, delta, psi, x, y),
            caption="At 4.6 m/s the bicycle rights itself after a knock of 0.5 rad/s.",
        ),
        "weave": Scene(
            initial={z: sp.Rational("-0.3"), delta: sp.Rational("0.02"), DR: -sp.Rational(40, 3)},
            times=(0.0, 6.0),
            outputs=(phi, delta, psi, x, y),
            caption="At 4 m/s the weave grows.",
        ),
    },
    references=("Whipple1899", "Meijaard2007"),
)

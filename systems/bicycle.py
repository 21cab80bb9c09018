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

from voronec import Fibration, Frame, Parameter, Scene, Shape, Sketch, System, velocity
from voronec.kinematics import cross, derivative, dot, matrix_product

Vector = tuple[sp.Expr, sp.Expr, sp.Expr]
ZERO = sp.Integer(0)

x, y, z, psi, phi, theta, delta, beta_R, beta_F = sp.symbols(
    "x y z psi phi theta delta beta_R beta_F"
)
w, c, tilt, g = sp.symbols("w c tilt g")
r_R, m_R, I_Rxx, I_Ryy = sp.symbols("r_R m_R I_Rxx I_Ryy")
r_F, m_F, I_Fxx, I_Fyy = sp.symbols("r_F m_F I_Fxx I_Fyy")
x_B, z_B, m_B, I_Bxx, I_Bxz, I_Byy, I_Bzz = sp.symbols("x_B z_B m_B I_Bxx I_Bxz I_Byy I_Bzz")
x_H, z_H, m_H, I_Hxx, I_Hxz, I_Hyy, I_Hzz = sp.symbols("x_H z_H m_H I_Hxx I_Hxz I_Hyy I_Hzz")
k_S, a_S, b_S = sp.symbols("k_S a_S b_S")
roll_rate, steer_rate, speed = sp.symbols("roll_rate steer_rate speed")

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


# Rolled frame (yaw, roll): its rate of turn, the rear frame's, down, and the rear wheel's centre.
rolled_omega = (Dphi, Dpsi * sp.sin(phi), Dpsi * sp.cos(phi))
frame_omega = add(rolled_omega, (ZERO, Dtheta, ZERO))
frame_down = (ZERO, sp.sin(phi), sp.cos(phi))
rise = cross(rolled_omega, (ZERO, ZERO, -r_R))
centre_velocity = add(about_x(phi, about_z(psi, (Dx, Dy, Dz))), rise)
# The contact runs along the track at this rate where the rear wheel does not slip.
track_rate = -r_R * (Dtheta + DR)
rolling_velocity = add((track_rate, ZERO, ZERO), rise)

# Rear frame, in axes whose third is the steering axis; that passes ``offset`` ahead of the centre.
head = partial(about_y, tilt + theta)
head_omega, head_down = head(frame_omega), head(frame_down)
offset = (w + c) * sp.cos(tilt) - r_R * sp.sin(tilt)

# Front assembly.
steer = partial(about_z, delta)
front_omega, front_down = add(steer(head_omega), (ZERO, ZERO, Ddelta)), steer(head_down)


def from_axis(forward: sp.Expr, down: sp.Expr) -> Vector:
    """The place, from the steering axis, of a point given from the rear wheel's centre."""
    point = about_y(tilt, (forward, ZERO, down))
    return point[0] - offset, ZERO, point[2]


def front_velocity(point: Vector, centre: Vector) -> Vector:
    """The velocity of a point of the front assembly, given that of the rear wheel's centre."""
    axis = add(head(centre), cross(head_omega, (offset, ZERO, ZERO)))
    return add(steer(axis), cross(front_omega, point))


def steering_moments(xx: sp.Expr, yy: sp.Expr, zz: sp.Expr, xz: sp.Expr) -> tuple[sp.Expr, ...]:
    """Moments of inertia (xx, yy, zz, xz) in the axes of the steering."""
    cos, sin = sp.cos(tilt), sp.sin(tilt)
    mixed = 2 * xz * sin * cos
    turned = (xx - zz) * sin * cos + xz * (cos**2 - sin**2)
    return xx * cos**2 + zz * sin**2 - mixed, yy, xx * sin**2 + zz * cos**2 + mixed, turned


def twice_spin(omega: Vector, moments: tuple[sp.Expr, ...], wheel: sp.Expr) -> sp.Expr:
    """omega . I omega of a body and of the moment of its wheel about any diameter."""
    xx, yy, zz, xz = moments
    quadratic = (xx + wheel) * omega[0] ** 2 + yy * omega[1] ** 2 + (zz + wheel) * omega[2] ** 2
    return quadratic + 2 * xz * omega[0] * omega[2]


body = about_y(tilt, (x_B, ZERO, z_B + r_R))
body_velocity = add(head(centre_velocity), cross(head_omega, body))
handlebar = from_axis(x_H, z_H + r_R)
handlebar_velocity = front_velocity(handlebar, centre_velocity)
hub = (r_F * sp.sin(tilt) - c * sp.cos(tilt), ZERO, from_axis(w, r_R - r_F)[2])
hub_velocity = front_velocity(hub, centre_velocity)
rear_spin, front_spin = head_omega[1] + DR, front_omega[1] + DF

kinetic = (
    m_R * dot(centre_velocity, centre_velocity)
    + m_B * dot(body_velocity, body_velocity)
    + twice_spin(head_omega, steering_moments(I_Bxx, I_Byy, I_Bzz, I_Bxz), I_Rxx)
    + I_Ryy * rear_spin**2
    + m_H * dot(handlebar_velocity, handlebar_velocity)
    + m_F * dot(hub_velocity, hub_velocity)
    + twice_spin(front_omega, steering_moments(I_Hxx, I_Hyy, I_Hzz, I_Hxz), I_Fxx)
    + I_Fyy * front_spin**2
) / 2
centre_depth = z - r_R * sp.cos(phi)
axis_depth = centre_depth + offset * head_down[0]
hub_depth = axis_depth + dot(front_down, hub)
# A spring from the down tube to the fork that centres the steering; the benchmark has none.
stretch = sp.sqrt(a_S**2 + b_S**2 - 2 * a_S * b_S * sp.cos(delta)) - (a_S - b_S)
potential = k_S * stretch**2 / 2 - g * (
    m_R * centre_depth
    + m_B * (centre_depth + dot(head_down, body))
    + m_H * (axis_depth + dot(front_down, handlebar))
    + m_F * hub_depth
)

# The lowest point of the front wheel: the downward unit laid into the plane of the wheel.
sine = sp.sqrt(1 - front_down[1] ** 2)
lowest = (r_F * front_down[0] / sine, ZERO, r_F * front_down[2] / sine)
front_depth = hub_depth + r_F * sine
# The front wheel's slip where the rear wheel has none, so without x, y, z.
rolling_hub = front_velocity(hub, rolling_velocity)

constraints = (
    Dx - track_rate * sp.cos(psi),
    Dy - track_rate * sp.sin(psi),
    Dz,
    # Along the front wheel's track, then along its axle.
    rolling_hub[0] * front_down[2] - rolling_hub[2] * front_down[0] + r_F * sine * front_spin,
    rolling_hub[1] + cross(front_omega, lowest)[1],
    # Downwards the rim moves at its lowest point as that point itself, whose place is known.
    sp.Add(*[derivative(front_depth, q) * velocity(q) for q in (z, phi, theta, delta)]),
)

SKETCH = (
    Sketch("seen from the side; z points down")
    .line((-0.9, -0.6), (3.4, -0.6), look="thin")
    .ellipse((0.0, 0.0), 0.6, 0.6)
    .ellipse((2.4, 0.0), 0.6, 0.6)
    .line((0.0, 0.0), (1.75, 0.95), (0.7, 1.0), (0.0, 0.0))
    .line((1.4, 1.55), (2.05, 0.45), (2.4, 0.0))
    .arrow((1.75, 0.95), (1.1, 2.05))
    .turn((1.25, 1.8), 120, 0.24, delta)
    .angle((0.0, 0.0), 0.4, 200, 80, beta_R)
    .angle((2.4, 0.0), 0.4, 200, 80, beta_F)
    .arrow((-2.3, 0.9), (-1.5, 0.9), x)
    .arrow((-2.3, 0.9), (-2.3, 0.1), z)
    .arrow((-2.3, 0.9), (-2.75, 0.55), y)
    .line((0.0, 0.0), (0.0, 1.75), look="dashed")
    .turn((0.0, 1.6), -90, 0.24, psi)
    .line((0.0, 0.0), (-1.3, 0.0), look="dashed")
    .turn((-1.1, 0.0), 0, 0.24, phi)
    .angle((0.0, 0.0), 1.0, 0, 30, theta)
    .dot((0.0, 0.0), "(x, y, z)", -45)
)
# To draw it, upwards: the frames as matrices, components along them to components in space.
upwards, axes = sp.diag(1, -1, -1), ((1, 0, 0), (0, 1, 0), (0, 0, 1))
frame_axes = [about_x(phi, about_z(psi, axis)) for axis in axes]
head_frame = sp.Matrix([head(axis) for axis in frame_axes])
forks = sp.Matrix([steer(head(axis)) for axis in frame_axes])
head_up, forks_up = matrix_product(upwards, head_frame), matrix_product(upwards, forks)
rear_contact = sp.Matrix([x, y, z])
rear = rear_contact - matrix_product(frame_axes, (0, 0, r_R))
pivot = rear + matrix_product(head_frame, (offset, 0, 0))
front = pivot + matrix_product(forks, hub)
rider = rear + matrix_product(head_frame, body)


def wheel(angle: sp.Expr) -> sp.Matrix:
    """A wheel that has turned about the second axis of its frame, its own third."""
    cos, sin = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[sin, cos, 0], [0, 0, 1], [cos, -sin, 0]])


SYSTEM = System(
    name="bicycle",
    title="Whipple bicycle",
    description="Rear frame with rider, front assembly and two knife-edge wheels on a plane.",
    sketch=SKETCH,
    fibration=Fibration(base=(phi, delta, beta_R), fibre=(x, y, z, psi, theta, beta_F)),
    frame=Frame.quasi({roll_rate: Dphi, steer_rate: Ddelta, speed: track_rate}),
    lagrangian=kinetic - potential,
    constraints=constraints,
    meanings={
        x: "place of the rear wheel's centre, forward",
        y: "place of the rear wheel's centre, to the right",
        z: "place of the rear wheel's centre, down",
        psi: "yaw of the rear frame",
        phi: "roll of the rear frame, its lean to the right",
        theta: "pitch of the rear frame",
        delta: "steer, the turn of the front assembly about its axis",
        beta_R: "turn of the rear wheel about its axle",
        beta_F: "turn of the front wheel about its axle",
        roll_rate: "rate of the roll",
        steer_rate: "rate of the steer",
        speed: "speed of the rear contact along its track",
        "rear contact": "depth of the rear wheel's lowest point, which is zero on the ground",
        "front contact": "depth of the front wheel's lowest point, which is zero on the ground",
    },
    parameters=(
        Parameter(w, "1.02", positive=True, meaning="wheelbase"),
        Parameter(c, "0.08", meaning="trail"),
        Parameter(tilt, sp.pi / 10, meaning="backward tilt of the steering axis"),
        Parameter(g, "9.81", meaning="gravity"),
        Parameter(r_R, "0.3", positive=True, meaning="radius, rear wheel"),
        Parameter(m_R, 2, positive=True, meaning="mass, rear wheel"),
        Parameter(I_Rxx, "0.0603", positive=True, meaning="rear wheel, diameter"),
        Parameter(I_Ryy, "0.12", positive=True, meaning="rear wheel, axle"),
        Parameter(x_B, "0.3", meaning="rear body, forward of the rear contact"),
        Parameter(z_B, "-0.9", meaning="rear body, below the ground"),
        Parameter(m_B, 85, positive=True, meaning="mass, rear body and rider"),
        Parameter(I_Bxx, "9.2", positive=True),
        Parameter(I_Bxz, sp.Rational("2.4")),
        Parameter(I_Byy, 11, positive=True),
        Parameter(I_Bzz, "2.8", positive=True),
        Parameter(x_H, "0.9", meaning="handlebar, forward of the rear contact"),
        Parameter(z_H, "-0.7", meaning="handlebar, below the ground"),
        Parameter(m_H, 4, positive=True, meaning="mass, handlebar and fork"),
        Parameter(I_Hxx, "0.05892", positive=True),
        Parameter(I_Hxz, sp.Rational("-0.00756")),
        Parameter(I_Hyy, "0.06", positive=True),
        Parameter(I_Hzz, "0.00708", positive=True),
        Parameter(r_F, "0.35", positive=True, meaning="radius, front wheel"),
        Parameter(m_F, 3, positive=True, meaning="mass, front wheel"),
        Parameter(I_Fxx, "0.1405", positive=True, meaning="front wheel, diameter"),
        Parameter(I_Fyy, "0.28", positive=True, meaning="front wheel, axle"),
        Parameter(k_S, 0, lower=0, meaning="stiffness of the steering spring"),
        Parameter(a_S, "0.25", positive=True, meaning="spring's end on the frame"),
        Parameter(b_S, "0.05", positive=True, meaning="spring's end on the fork"),
    ),
    integrals={"energy": kinetic + potential, "rear contact": z, "front contact": front_depth},
    undecided={
        "energy": "the normal form of the mass matrix is beyond the work that a proof may cost; "
        "in numbers the energy is constant to 200 digits",
    },
    scenes={
        # Both wheels touch the ground where z = 0 and the frame is upright with no pitch.
        "default": Scene(
            initial={roll_rate: "0.5", speed: "4.6"},
            times=(0.0, 5.0),
            outputs=(phi, delta, psi, x, y),
            caption="At 4.6 m/s the bicycle rights itself after a knock of 0.5 rad/s.",
        ),
        "weave": Scene(
            initial={roll_rate: "0.1", speed: 4},
            times=(0.0, 6.0),
            outputs=(phi, delta, psi, x, y),
            caption="At 4 m/s the weave grows.",
        ),
    },
    shapes=(
        Shape.disc(
            r_R,
            centre=matrix_product(upwards, rear),
            attitude=matrix_product(upwards, head_frame, wheel(beta_R)),
            contact=matrix_product(upwards, rear_contact),
        ),
        Shape.disc(
            r_F,
            centre=matrix_product(upwards, front),
            attitude=matrix_product(upwards, forks, wheel(beta_F)),
            contact=matrix_product(upwards, front + matrix_product(forks, lowest)),
        ),
        Shape.box(
            (w / 2, 0.06, 0.06),
            centre=matrix_product(upwards, (rear + pivot) / 2),
            attitude=head_up,
        ),
        Shape.box(
            (0.06, 0.4, r_F),
            centre=matrix_product(upwards, (pivot + front) / 2),
            attitude=forks_up,
        ),
        Shape.ellipsoid(
            (0.15, 0.2, 0.45),
            centre=matrix_product(upwards, rider),
            attitude=head_up,
        ),
        Shape.plane(),
    ),
    references=("Whipple1899", "Meijaard2007"),
)

"""A torus that rolls without slipping over an ellipsoid.

Neumann's coordinates: u goes around the tube of the torus from its top and v around its axis;
u1, v1 are colatitude and longitude of the normal of x^2/a^2 + y^2/a^2 + z^2/c^2 = 1, the ellipsoid,
and theta lies between the lines of u and of v1.  With w^2 = sin^2 u1 + (c/a)^2 cos^2 u1 its radii
of curvature are c^2/(a w^3) and a/w; w is a coordinate too, so that no root occurs.  s, tau, n are
the components of the angular velocity along e_u, e_v and the normal of the torus.

The place of the contact follows from the motion of the body, (du, dv, du1, dv1, dtheta)/dt as
functions of s, tau, n; the body itself is placed by Euler's angles and by its centre seen from it,
o = (o1, o2, o3).  Neither is in the equations, so that any values do for them; those of a body
that touches the ellipsoid are o = R^T O and R = B1 Q B^T.  With G the momentum about the contact M,
r = OM, and Omega the angular velocity of (u, v, n) against the torus,

    dG/dt = G x omega - Omega x G + m r' x (omega x r)

along (u, v, n), where r' = (L_u du/dt, L_v dv/dt, 0) is the velocity of M over the torus.

The torus touches with its outer half, sin u > 0.  The energy is the only integral, but for a ball
on a sphere: R = 0 and a = c.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Equation,
    Fibration,
    Frame,
    Parameter,
    Relation,
    Scene,
    System,
    kinematics,
    velocity,
)

angles = sp.symbols("phi chi psi")
place = sp.symbols("o1:4")
u, v, theta, u1, v1, w = sp.symbols("u v theta u1 v1 w")
s, tau, n = quasi = sp.symbols("s tau n")
R, r, a, c, m, A, C = sp.symbols("R r a c m A C")

torus = kinematics.Surface.torus(R, r, u, v)
ellipsoid = kinematics.SurfaceForms.revolution(u1, v1, (c**2 / (a * w**3), a / w))
contact = kinematics.RollingContact(torus, ellipsoid, theta)
turned = contact.rolled(quasi)
rotation = kinematics.Rotation.euler("zxz", *angles)

# In the axes of the torus: its angular velocity, and how its centre moves in space.
omega = torus.frame * sp.Matrix(quasi)
moved = sp.Matrix([velocity(o) for o in place]) + omega.cross(sp.Matrix(place))
rolled = -omega.cross(sp.Matrix(torus.position))
inertia = (A, A, C)
axis = torus.frame.row(2)  # the axis of the torus along (u, v, n)
spin = axis.dot(sp.Matrix(quasi))

# Along (u, v, n), which turn against the torus: G is the momentum about the contact.
known = {velocity(q): rate for q, rate in turned.items()}
rates, arm = sp.Matrix(quasi), sp.Matrix(contact.arm)
turning = sp.Matrix(torus.frame_rates).xreplace(known)
trace = sp.Matrix(torus.trace_velocity).xreplace(known)
momentum = A * rates + (C - A) * spin * axis.T + m * arm.cross(rates.cross(arm))
whole = momentum
moving = whole.cross(rates) + m * trace.cross(rates.cross(arm)) - turning.cross(momentum)
energy = momentum.dot(rates) / 2

# The same in what the rolling knows of the place.
invariants = {
    "cos_u": sp.cos(u),
    "sin_u": sp.sin(u),
    "cos_theta": sp.cos(theta),
    "sin_theta": sp.sin(theta),
    "cos_u1": sp.cos(u1),
    "sin_u1": sp.sin(u1),
    "slant": w,
}
named = {function: sp.Symbol(name) for name, function in invariants.items()}

SYSTEM = System(
    name="torus-on-ellipsoid",
    title="Torus on an ellipsoid",
    description="A torus rolls without slipping over an ellipsoid of revolution.",
    fibration=Fibration(
        base=angles,
        fibre=(*place, *turned, w),
        relations=(a**2 * (w**2 - sp.sin(u1) ** 2) - c**2 * sp.cos(u1) ** 2,),
    ),
    frame=Frame.quasi(dict(zip(quasi, torus.frame.T * rotation.body_rates, strict=True))),
    lagrangian=kinematics.kinetic_energy(m, moved, inertia, omega),
    constraints=(
        *(velocity(q) - rate for q, rate in turned.items()),
        *(moved - rolled),
    ),
    parameters=(
        Parameter(R, 1, lower=0, meaning="radius of the circle inside the tube"),
        Parameter(r, sp.Rational(1, 2), positive=True, meaning="radius of the tube"),
        Parameter(a, 3, meaning="equatorial semi-axis of the ellipsoid, with its sign"),
        Parameter(c, 2, meaning="polar semi-axis, of the same sign"),
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(A, 1, positive=True, meaning="inertia about a diameter"),
        Parameter(C, sp.Rational(3, 2), positive=True, meaning="inertia about the axis"),
    ),
    invariants=invariants,
    equations={"momentum": Equation(momentum.xreplace(named), moving.xreplace(named))},
    integrals={"energy": energy.xreplace(named)},
    essential=(u, theta, u1, w, s, tau, n),
    scenes={
        "default": Scene(
            initial={
                angles[1]: 1,
                u: 1,
                theta: 1,
                u1: sp.pi / 2,
                w: 1,
                s: 1,
                tau: sp.Rational(1, 2),
                n: 2,
            },
            times=(0.0, 20.0),
            outputs=(u, v, u1, v1, theta),
            caption="The torus runs along the equator and leaves it.",
        ),
    },
    drawing={"on the ellipsoid, by its normal": ("u1", "v1")},
    references=("Neumann1899", "Voronec1911", "Voronec1912"),
)

R1, R2 = sp.symbols("R1 R2")
RELATIONS = (
    Relation(
        "symmetric-ball-on-sphere",
        "torus-on-ellipsoid",
        state={
            **invariants,
            "slant": sp.Integer(1),
            **dict(zip(quasi, torus.frame.T * sp.Matrix(sp.symbols("omega1:4")), strict=True)),
        },
        parameters={R: sp.Integer(0), r: R2, a: R1, c: R1, m: m, A: A, C: C},
        note="a torus about a point is a ball, and equal axes make a sphere",
    ),
)

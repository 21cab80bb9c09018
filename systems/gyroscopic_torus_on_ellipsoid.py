"""A torus with a gyroscope along its axis that rolls without slipping over an ellipsoid.

Neumann's coordinates: u goes around the tube of the torus from its top and v around its axis;
u1, v1 are colatitude and longitude of the normal of x^2/a^2 + y^2/a^2 + z^2/c^2 = 1, the ellipsoid,
and theta lies between the lines of u and of v1.  With w^2 = sin^2 u1 + (c/a)^2 cos^2 u1 its radii
of curvature are c^2/(a w^3) and a/w; w is a coordinate too, so that no root occurs.  s, tau, n are
the components of the angular velocity along e_u, e_v and the normal of the torus.
k is the constant axial momentum of the gyroscope.

The place of the contact follows from the motion of the body, (du, dv, du1, dv1, dtheta)/dt as
functions of s, tau, n; the body itself is placed by Euler's angles and by its centre seen from it,
o = (o1, o2, o3).  Neither is in the equations, so that any values do for them; those of a body
that touches the ellipsoid are o = R^T O and R = B1 Q B^T.  With G the momentum about the contact M,
r = OM, and Omega the angular velocity of (u, v, n) against the torus,

    dG/dt = (G + k e) x omega - Omega x G + m r' x (omega x r)

along (u, v, n), e the axis of the torus, where r' = (L_u du/dt, L_v dv/dt, 0) is the velocity of M
over the torus.

The torus touches with its outer half, sin u > 0.  The energy is the only integral, but for a ball
on a sphere: R = 0 and a = c.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

R, r, a, c, m, A, C, k, R1, R2 = sp.symbols("R r a c m A C k R1 R2")

torus = kinematics.TorusOnEllipsoid((R, r), (a, c), m, (A, C), k)

SYSTEM = torus.system(
    name="gyroscopic-torus-on-ellipsoid",
    title="Torus with a gyroscope on an ellipsoid",
    description="A torus with a gyroscope along its axis rolls without slipping over an ellipsoid "
    "of revolution.",
    values={k: 2},
    caption="The gyroscope turns the torus off the equator.",
    references=("Neumann1899", "Voronec1911", "Voronec1912", "Demchenko1924"),
)

RELATIONS = (
    Relation.into(
        SYSTEM,
        "symmetric-gyroscopic-ball-on-sphere",
        {**torus.ball_state, R: 0, r: R2, a: R1, c: R1},
        note="a torus about a point is a ball, and equal axes make a sphere",
    ),
    Relation.of(SYSTEM, "torus-on-ellipsoid", vanish=k, note="the gyroscope stops"),
)

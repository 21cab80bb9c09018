"""A heavy body of revolution with any profile that rolls on a horizontal plane without slipping.

The surface is known by its support function P(u) about the mass centre O, u the angle between the
axis of symmetry and the outer normal at the contact M; P is the height of O over the plane, and

    OM = P' e_u + P n,    r_u = P + P'',    r_v = P + P' cot u

the arm and the radii of curvature, along the meridian and across.  A, A, C are the moments about O;
s, tau, n the components of the angular velocity along e_u, e_v, n, and w that along the axis.  With
G the momentum about the contact, r = OM and

    rho^2 = A C + m (A r^2 + (C - A) r_3^2),   Z = rho w,   J = (G, r)/r_v,

r_3 along the axis, Z and J change with u by linear equations, dZ/du = b J, dJ/du = c Z, to which
the problem reduces [Chaplygin1897]: the two constants of their solution are integrals linear in the
velocities, and the energy gives tau.  For a general profile they are not elementary.  A search with
P, P' and P'' for letters proves that no integral linear in the velocities is a polynomial in these
and in sin u and cos u, up to degree four.  For P = R - l cos u, ``routh-sphere``, they are those
of Jellett and Routh; P = R sin u is the edge of the ``falling-disc``, and the ``spheroid-on-plane``
has P^2 = a^2 sin^2 u + c^2 cos^2 u.

P being unknown, there is no motion to show.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

u, v, theta, x, y = sp.symbols("u v theta x y")
m, A, C, g = sp.symbols("m A C g")
P = sp.Function("P")(u)

SYSTEM = kinematics.BodyOnPlane(u, P, m, (A, C), g).system(
    name="symmetric-body-on-plane",
    title="Body of revolution on a plane",
    description="A heavy body of revolution of any profile rolls without slipping on a plane.",
    values={m: 1, A: 1, C: "3/2", g: 1},
    references=("Chaplygin1897", "Voronec1912", "BorisovMamaev2002"),
)

# What is known of special profiles, in the variables there.
spin = kinematics.Surface.sphere(1, u, v).frame.T * sp.Matrix(sp.symbols("omega1:4"))
along = dict(zip(sp.symbols("s tau n"), spin, strict=True))
R, l, phi, psi, a, c = sp.symbols("R l phi psi a c")  # noqa: E741
level = sp.sqrt((a * sp.sin(u)) ** 2 + (c * sp.cos(u)) ** 2)
ahead = sp.diff(level, u).xreplace({u: sp.pi - theta})  # of the contact, from below the centre
RELATIONS = (
    Relation.into(
        SYSTEM,
        "routh-sphere",
        {**{q: q for q in (u, v, theta, x, y)}, **along, P: R - l * sp.cos(u)},
        note="a ball, its mass centre off its centre",
    ),
    Relation.into(
        SYSTEM,
        "falling-disc",
        {u: sp.pi / 2 - theta, v: sp.pi / 2 - psi, theta: phi + sp.pi, P: R * sp.sin(u)},
        note="the edge of a disc",
    ),
    Relation.into(
        SYSTEM,
        "spheroid-on-plane",
        {
            u: sp.pi - theta,
            v: -sp.pi / 2 - psi,
            theta: phi,
            x: x - ahead * sp.sin(phi),
            y: y + ahead * sp.cos(phi),
            P: level,
        },
        note="an ellipsoid",
    ),
)

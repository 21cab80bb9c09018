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
of Jellett and Routh; P = R sin u is the edge of the ``falling-disc``.

P being unknown, there is no motion to show.
"""

from __future__ import annotations

import sympy as sp

from voronec import Equation, Fibration, Frame, Parameter, Relation, System, kinematics
from voronec.kinematics import dot

u, v, theta, x, y = sp.symbols("u v theta x y")
s, tau, n = quasi = sp.symbols("s tau n")
m, A, C, g = sp.symbols("m A C g")
P = sp.Function("P")(u)
slope = sp.diff(P, u)

surface = kinematics.SurfaceForms.revolution(
    u, v, (P + sp.diff(P, u, 2), P + slope * sp.cos(u) / sp.sin(u)), (slope, sp.Integer(0), P)
)
contact = kinematics.RollingContact(surface, kinematics.Surface.plane(x, y), theta)
body = kinematics.BodyOfRevolution(contact, m, A, C)

spin, centre = sp.Matrix(contact.spin), sp.Matrix(contact.centre_velocity)
kinetic = (m * dot(centre, centre) + dot(body.turning_momentum(spin), spin)) / 2

nutation_rate, momentum, arm = body.rolling_velocities[u], body.momentum, body.arm
f = nutation_rate.coeff(tau)  # du/dt = f tau
momentum_rate = body.momentum_rate - sp.Matrix([0, f * m * g * slope, 0])

# The linear equations for Z and J.
along, across = -body.trace[0].coeff(tau), body.trace[1].coeff(s)  # r' = (-along tau, across s)
reach = P * sp.sin(u) + slope * sp.cos(u)  # of M from the axis
height = P * sp.cos(u) - slope * sp.sin(u)  # r_3
rho = sp.sqrt(A * C + m * (A * (P**2 + slope**2) + (C - A) * height**2))
Z, J = rho * (n * sp.cos(u) - s * sp.sin(u)), sp.sin(u) / reach * dot(momentum, arm)
e = along * sp.sin(u) - reach
b = m * e * reach / (f * rho * sp.sin(u))
c = (C - A) * e - (across - along) * ((C - A) * height * sp.cos(u) + A * P) / reach
c = c * sp.sin(u) / (f * rho * reach)

SYSTEM = System(
    name="symmetric-body-on-plane",
    title="Body of revolution on a plane",
    description="A heavy body of revolution of any profile rolls without slipping on a plane.",
    sketch=kinematics.rolling_sketch(body="ellipsoid", contact=(u, v), place=(x, y), turned=theta),
    fibration=Fibration(base=(u, v, theta), fibre=(x, y)),
    frame=Frame.quasi(dict(zip(quasi, contact.spin, strict=True))),
    lagrangian=kinetic - m * g * P,
    constraints=contact.no_slip,
    meanings={
        **kinematics.contact_meanings(contact),
        **kinematics.moving_meanings(quasi),
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(A, 1, positive=True, meaning="equatorial moment of inertia"),
        Parameter(C, "3/2", positive=True, meaning="axial moment of inertia"),
        Parameter(g, 1, meaning="gravity"),
    ),
    equations={
        "nutation": Equation(u, nutation_rate),
        "momentum": Equation(momentum, momentum_rate),
        "linear": Equation((Z, J), (nutation_rate * b * J, nutation_rate * c * Z)),
    },
    integrals={"energy": dot(momentum, quasi) / 2 + m * g * P},
    measure=(A + m * dot(arm, arm)) * rho * sp.sin(u),
    essential=(u, s, tau, n),
    references=("Chaplygin1897", "Voronec1912", "BorisovMamaev2002"),
)

# What is known of special profiles, in the variables there.
turned = kinematics.Surface.sphere(1, u, v).frame.T * sp.Matrix(sp.symbols("omega1:4"))
seen = dict(zip(quasi, turned, strict=True))
R, l, phi, psi = sp.symbols("R l phi psi")  # noqa: E741
RELATIONS = (
    Relation.into(
        SYSTEM,
        "routh-sphere",
        {**{q: q for q in (u, v, theta, x, y)}, **seen, P: R - l * sp.cos(u)},
        note="a ball, its mass centre off its centre",
    ),
    Relation.into(
        SYSTEM,
        "falling-disc",
        {u: sp.pi / 2 - theta, v: sp.pi / 2 - psi, theta: phi + sp.pi, P: R * sp.sin(u)},
        note="the edge of a disc",
    ),
)

"""A body of revolution that rolls without slipping over a fixed sphere, drawn to its centre.

The body's surface is any: P(u) is its support function about the mass centre O, u the angle between
the axis of symmetry and the outer normal at the contact.  Then OM = P' e_u + P n, and the radii of
curvature are P + P'' along the meridian, P + P' cot u across.  The moments about O are A, A, C.  A
force towards the centre of the sphere, which depends on its distance from O, has a potential V(u),
any function.  s, tau, n are the components of the angular velocity along e_u, e_v, n; R1 is signed.

With G the momentum about the contact M, r = OM, w the axial component of the angular velocity and

    rho^2 = A C + m (A r^2 + (C - A) r_3^2),   Z = rho w,   J = (G, r) (R1 + r_v)/r_v,

r_3 along the axis and r_v the radius of curvature across the meridian, the force enters the rate of
tau only, du/dt is a multiple of tau, and

    dZ/du = b J,    dJ/du = c Z,    with b and c functions of u:

linear equations with u for the time, so that b Z'' = b' Z' + b^2 c Z: the linear differential
equation of second order to which the problem reduces [KuleshovKatasonova2018].  With its solutions,
the energy gives tau, and the rest are quadratures.  They are not elementary in general, so that no
integral but the energy is declared.  Liouvillian solutions exist for a ball that is dynamically
symmetric and not homogeneous [KuleshovKatasonova2018]: P = R2 - l cos u, the mass centre at l from
the centre along the axis, which is ``displaced-ball-on-sphere``, with the solutions in its cases;
for l = 0 it is ``symmetric-ball-on-sphere``.  An ellipsoid of revolution is another body of this
kind (``spheroid-on-sphere``), for which none are known here.

P and V being unknown functions, there is no motion to show.  Nor is a chart declared at the body's
own poles, where it is smooth only if P is even there; once P is known the engine makes one.
"""

from __future__ import annotations

import sympy as sp

from voronec import Equation, Fibration, Frame, Parameter, System, kinematics
from voronec.kinematics import derivative, dot

u, v, theta, u1, v1 = sp.symbols("u v theta u1 v1")
s, tau, n = quasi = sp.symbols("s tau n")
R1, m, A, C = sp.symbols("R1 m A C")
P, V = sp.Function("P")(u), sp.Function("V")(u)
slope = sp.diff(P, u)

surface = kinematics.SurfaceForms.revolution(
    u,
    v,
    (P + sp.diff(P, u, 2), P + slope * sp.cos(u) / sp.sin(u)),
    (slope, sp.Integer(0), P),
)
sphere = kinematics.Surface.sphere(R1, u1, v1)
contact = kinematics.RollingContact(surface, sphere, theta)
body = kinematics.BodyOfRevolution(contact, m, A, C)

spin, centre = sp.Matrix(contact.spin), sp.Matrix(contact.centre_velocity)
kinetic = (m * dot(centre, centre) + dot(body.turning_momentum(spin), spin)) / 2

# Where the body rolls: the momentum about the contact, and how it changes along (u, v, n).
nutation_rate, momentum, arm = body.rolling_velocities[u], body.momentum, body.arm
f = nutation_rate.coeff(tau)  # du/dt = f tau
momentum_rate = body.momentum_rate - sp.Matrix([0, f * sp.diff(V, u), 0])

# The linear equations for Z and J, and the one for Z alone.
along, across = -body.trace[0].coeff(tau), body.trace[1].coeff(s)  # r' = (-along tau, across s)
reach = P * sp.sin(u) + slope * sp.cos(u)  # of M from the axis
height = P * sp.cos(u) - slope * sp.sin(u)  # r_3
e = along * sp.sin(u) - reach
rho = sp.sqrt(A * C + m * (A * (P**2 + slope**2) + (C - A) * height**2))
wide = R1 * sp.sin(u) / reach + 1  # (R1 + r_v)/r_v
Z, J = rho * (n * sp.cos(u) - s * sp.sin(u)), wide * dot(momentum, arm)
b = m * e / (f * rho * wide)
c = (C - A) * e - (across - along) * ((C - A) * height * sp.cos(u) + A * P) / reach
c = c * wide / (f * rho)
first = b * J
second = derivative(b, u) * J + b * c * Z

# The density of a measure of u, s, tau, n, which with sin u1 is one of all variables; spread is
# (R1 + r_u) (R1 + r_v) sin u.
spread = (R1 + P + sp.diff(P, u, 2)) * (R1 * sp.sin(u) + reach)
density = (A + m * dot(arm, arm)) * rho * spread

SYSTEM = System(
    name="symmetric-body-on-sphere",
    title="Body of revolution on a sphere",
    description="A body of revolution rolls without slipping over a fixed sphere, drawn to its "
    "centre by a force that depends on the distance.",
    sketch=kinematics.rolling_sketch(
        on="sphere", body="ellipsoid", contact=(u, v), place=(u1, v1), turned=theta
    ),
    fibration=Fibration(base=(u, v, theta), fibre=(u1, v1)),
    frame=Frame.quasi(dict(zip(quasi, contact.spin, strict=True))),
    lagrangian=kinetic - V,
    constraints=contact.no_slip,
    meanings={
        **kinematics.contact_meanings(contact),
        **kinematics.moving_meanings(quasi),
    },
    parameters=(
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(A, 1, positive=True, meaning="equatorial moment of inertia"),
        Parameter(C, "3/2", positive=True, meaning="axial moment of inertia"),
    ),
    equations={
        "nutation": Equation(u, nutation_rate),
        "momentum": Equation(momentum, momentum_rate),
        "linear": Equation((Z, J), (nutation_rate * b * J, nutation_rate * c * Z)),
        "second order": Equation((Z, first), (nutation_rate * first, nutation_rate * second)),
    },
    integrals={"energy": dot(momentum, quasi) / 2 + V},
    measure=density * sp.sin(u1),
    charts=kinematics.turned_sphere(contact),
    essential=(u, s, tau, n),
    references=("Voronec1912", "KuleshovKatasonova2018", "DragovicGajicJovanovic2020"),
)

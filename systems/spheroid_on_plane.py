"""An ellipsoid of revolution that rolls without slipping on a horizontal plane, under its weight.

Its semi-axes are a, a, c, its moments about the centre O are A, A, C.  gamma is the vertical along
its axes, h = (gamma, S gamma)^(1/2) with S = diag(a^2, a^2, c^2) the height of O, and
r = OM = -S gamma/h.  Then

    dG/dt = G x omega + m dr/dt x (omega x r) + m g r x gamma,    dgamma/dt = gamma x omega,

where G = I omega + m r x (omega x r).  There is a measure [BorisovMamaev2002], whose
density holds the factor h because h is one of its variables, bound to gamma.

With rho^2 = A C + m (A r^2 + (C - A) r_3^2) and r_v = a^2/h, the radius of curvature across the
meridian, Z = rho omega_3 and J = (G, r)/r_v satisfy linear equations with gamma_3 for the time.
Two integrals, linear in omega, follow from their solutions, which are not elementary in general;
they are not declared.
"""

from __future__ import annotations

import sympy as sp

from voronec import Equation, Relation, kinematics

gamma, omega, height = sp.symbols("gamma1:4"), sp.symbols("omega1:4"), sp.Symbol("height")
m, g, a, c, A, C = sp.symbols("m g a c A C")

rolling = kinematics.RollingEllipsoid.on_plane((a, a, c), m, (A, A, C))
theta = rolling.base[1]

# The linear equations for Z = rho omega_3 and J = (G, r)/r_v, by the radii of curvature.
arm = rolling.body.arm
meridian, parallel = a**2 * c**2 / height**3, a**2 / height
rho = sp.sqrt(A * C + m * (A * (arm[0] ** 2 + arm[1] ** 2) + C * arm[2] ** 2))
Z, J = rho * omega[2], rolling.momentum.dot(arm) / parallel
slip = meridian - parallel
bulge = (a**2 - c**2) / (a**2 * height) * parallel
lean = bulge * (A * height - (C - A) * gamma[2] * arm[2]) - (C - A) * slip
steps = rolling.normal_rate[2] / rho

SYSTEM = rolling.system(
    name="spheroid-on-plane",
    title="Spheroid on a plane",
    description="A heavy ellipsoid of revolution rolls without slipping on a horizontal plane.",
    gravity=g,
    values={m: 1, g: 1, a: 1, c: "0.8", A: "0.4", C: "0.5"},
    equations={
        "linear": Equation((Z, J), (-steps * m * slip * parallel * J, steps * lean / parallel * Z)),
    },
    scenes={
        "default": rolling.scene(
            "A spheroid spins about its axis while it rolls.", {theta: "1/2"}, (1, 0, 3)
        ),
    },
    references=("Voronec1912", "BorisovMamaev2002"),
)

RELATIONS = (
    Relation.of(
        SYSTEM,
        "ellipsoid-on-plane",
        {"a": a, "b": a, "c": c, "I1": A, "I2": A, "I3": C},
        note="two axes are equal",
    ),
)

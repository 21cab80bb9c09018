"""The rubber ball as a shell around a sphere of half its radius: epsilon = -1.

R1 = -R2/2, hence epsilon = R1/(R1 + R2) = -1.  omega1 and omega2 are the velocities, and omega3
follows from (omega, gamma) = 0.  With J = I + D, D = m R2^2, and G = J omega,

    dG/dt = G x omega + lambda gamma,    dgamma/dt = -gamma x omega,
    lambda = -(gamma, J^-1 (G x omega)) / Q,    Q = (gamma, J^-1 gamma),

the system is integrable [BorisovMamaev2007].  Its second integral,

    F = J1 J2 J3 |omega|^2 - S/Q,    S = sum of (Ji - Jj)(Ji - Jk) omega_i^2 gamma_i^2,

i, j, k being 1, 2, 3 in any order, was found by linear algebra.  For generic moments it and the
energy span all integrals that are quadratic forms in omega, of degree 2 in gamma, divided by Q.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

R2, m = sp.symbols("R2 m")
inertia = sp.symbols("I1:4")

ball = kinematics.BalancedBall.on_sphere(-R2 / 2, R2, m, inertia)
w1, w2 = ball.rubber.velocities

SYSTEM = ball.rubber_system(
    name="rubber-ball-eps-minus-one",
    title="Rubber ball around a sphere of half its radius",
    description="A balanced, dynamically non-symmetric shell rolls, without slipping and without "
    "turning about the common normal, around a fixed sphere of half its radius.",
    meanings={
        "Borisov and Mamaev": "the quadratic integral that the ratio of the radii gives",
    },
    values={R2: 1, m: 1, inertia: ("0.4", "0.5", "0.7")},
    integrals={"Borisov and Mamaev": ball.rubber.quadratic_integral},
    integrable="Euler-Jacobi",
    scenes={
        "default": ball.rubber_scene(
            "The shell rolls around the sphere.", 10.0, {w1: "-1/20", w2: "-1/5"}
        ),
    },
    references=("BorisovMamaev2007", "DragovicGajicJovanovic2020"),
)

RELATIONS = (Relation.of(SYSTEM, "rubber-ball-on-sphere", {"R1": -R2 / 2, "R2": R2}),)

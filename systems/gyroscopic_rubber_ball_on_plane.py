"""The rubber ball with a gyroscope on a plane: it neither slips nor twists.

kappa is the gyroscope's momentum, constant in the ball; omega1 and omega2 are the velocities, and
omega3 follows from (omega, gamma) = 0.  With J = I + D, D = m R^2, and G = J omega,

    dG/dt = (G + kappa) x omega + lambda gamma,    dgamma/dt = gamma x omega,
    lambda = -(gamma, J^-1 ((G + kappa) x omega)) / Q,    Q = (gamma, J^-1 gamma).

Because lambda = d(G + kappa, gamma)/dt, the part of G + kappa across gamma keeps its length.  With
dtau = Q^(-1/2) dt the motion is Hamilton's on the cotangent bundle of the sphere, in a magnetic
field.

The gyroscope enters as in the ball of Markeev, which rolls without slipping and may twist
[Markeev1985]; of the rubber ball he says nothing.
"""

from __future__ import annotations

import sympy as sp

from voronec import Case, Relation, kinematics

m, R = sp.symbols("m R")
inertia, kappa = sp.symbols("I1:4"), sp.symbols("kappa1:4")

ball = kinematics.BalancedBall.on_plane(R, m, inertia, kappa)
motion = ball.rubber
u, v, _ = ball.base
w1, w2 = motion.velocities

SYSTEM = ball.rubber_system(
    name="gyroscopic-rubber-ball-on-plane",
    title="Gyroscopic rubber ball on a plane",
    description="A balanced, dynamically non-symmetric ball with a gyroscope rolls on a "
    "plane without slipping and without turning about the vertical.",
    values={m: 1, R: 1, inertia: ("0.4", "0.5", "0.7"), kappa: ("0.3", "-0.2", "0.5")},
    integrable="Euler-Jacobi",
    cases={
        "symmetric": Case(
            parameters={inertia[1]: inertia[0], kappa[0]: 0, kappa[1]: 0},
            integrals={
                "axial": ((inertia[0] - inertia[2]) * motion.spin[2] - kappa[2]) * motion.root
            },
            note="the gyroscope lies along the axis of symmetry",
        ),
    },
    scenes={
        "default": ball.rubber_scene(
            "The gyroscope bends the path of the contact.",
            40.0,
            {u: "1/5", v: 1, w1: "1/10", w2: "1/20"},
        ),
    },
    references=("Markeev1985", "EhlersKoillerMontgomeryRios2005"),
)

RELATIONS = (
    Relation.of(SYSTEM, "rubber-ball-on-plane", vanish=kappa, note="the gyroscope is taken away"),
)

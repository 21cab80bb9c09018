"""The rubber ball with a gyroscope on a sphere: it neither slips nor twists.

kappa is the gyroscope's momentum, constant in the ball; omega1 and omega2 are the velocities, and
omega3 follows from (omega, gamma) = 0.  With J = I + D, D = m R2^2, G = J omega and
epsilon = R1/(R1 + R2),

    dG/dt = (G + kappa) x omega + lambda gamma,    dgamma/dt = epsilon gamma x omega,
    lambda = -(gamma, J^-1 ((G + kappa) x omega)) / Q,    Q = (gamma, J^-1 gamma).

The measure is that of the ball without a gyroscope.  With dtau = N dt, N = Q^(1/(2 epsilon) - 1),
the motion is Hamilton's on the cotangent bundle of the sphere, in a magnetic field.  R1 is signed,
as for the other balls on a sphere.

The gyroscope enters as in the ball of Markeev, which rolls without slipping and may twist
[Markeev1985]; of the rubber ball he says nothing.
"""

from __future__ import annotations

import sympy as sp

from voronec import Case, Relation, Square, kinematics

R1, R2, m = sp.symbols("R1 R2 m")
inertia, kappa = sp.symbols("I1:4"), sp.symbols("kappa1:4")

ball = kinematics.BalancedBall.on_sphere(R1, R2, m, inertia, kappa)
motion = ball.rubber

SYSTEM = ball.rubber_system(
    name="gyroscopic-rubber-ball-on-sphere",
    title="Gyroscopic rubber ball on a sphere",
    description="A balanced, dynamically non-symmetric ball with a gyroscope rolls over a fixed "
    "sphere without slipping and without turning about the common normal.",
    values={R1: 2, R2: 1, m: 1, inertia: ("0.4", "0.5", "0.7"), kappa: ("0.3", "-0.2", "0.5")},
    cases={
        "symmetric": Case(
            parameters={inertia[1]: inertia[0], kappa[0]: 0, kappa[1]: 0},
            integrals={
                "axial": ((inertia[0] - inertia[2]) * motion.spin[2] - kappa[2]) * motion.root
            },
            integrable="Euler-Jacobi",
            note="the gyroscope lies along the axis of symmetry",
        ),
    },
    scenes={"default": ball.rubber_scene("Outer rolling.", 40.0)},
    references=("Markeev1985", "EhlersKoiller2007"),
)

RELATIONS = (
    Relation.of(SYSTEM, "rubber-ball-on-sphere", vanish=kappa, note="the gyroscope is taken away"),
    Relation.of(
        SYSTEM,
        "gyroscopic-rubber-ball-on-plane",
        {"R": R2},
        grow=R1,
        note="the sphere becomes a plane",
    ),
)

SQUARES = (
    Square.through(
        ("gyroscopic-rubber-ball-on-sphere", "rubber-ball-on-sphere", "rubber-ball-on-plane"),
        (
            "gyroscopic-rubber-ball-on-sphere",
            "gyroscopic-rubber-ball-on-plane",
            "rubber-ball-on-plane",
        ),
        name="rubber balls: gyroscope and plane",
    ),
)

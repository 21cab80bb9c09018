"""The rubber ball on a sphere: balanced, not symmetric; it neither slips nor twists.

Derived in Neumann's coordinates, brought down to omega and gamma, the normal of the sphere, both
along the ball's axes.  omega1 and omega2 are the velocities; omega3 follows from
(omega, gamma) = 0.  With J = I + D, D = m R2^2, G = J omega and epsilon = R1/(R1 + R2),

    dG/dt = G x omega + lambda gamma,    dgamma/dt = epsilon gamma x omega,
    lambda = -(gamma, J^-1 (G x omega)) / Q,    Q = (gamma, J^-1 gamma),

and Q^(1/(2 epsilon)) is the density of a measure [EhlersKoiller2007].  R1 is signed: R1 < 0 inside
the sphere (|R1| > R2) and for a shell around it (|R1| < R2).
"""

from __future__ import annotations

import sympy as sp

from voronec import Case, Corrected, Relation, kinematics

R1, R2, m = sp.symbols("R1 R2 m")
inertia = I1, I2, I3 = sp.symbols("I1:4")

ball = kinematics.BalancedBall.on_sphere(R1, R2, m, inertia)
motion = ball.rubber
w1, w2 = motion.velocities
printed_equation = motion.momentum_equation(motion.multiplier(motion.momentum))

SYSTEM = ball.rubber_system(
    name="rubber-ball-on-sphere",
    title="Rubber ball on a sphere",
    description="A balanced, dynamically non-symmetric ball rolls over a fixed sphere without "
    "slipping and without turning about the common normal.",
    values={R1: 2, R2: 1, m: 1, inertia: ("0.4", "0.5", "0.7")},
    equations={
        "momentum": Corrected(
            motion.equations["momentum"], printed_equation, "DragovicGajicJovanovic2020"
        )
    },
    cases={
        "symmetric": Case(
            parameters={I2: I1},
            integrals={"axial": motion.spin[2] * motion.root},
            integrable="Euler-Jacobi",
            note="the third axis is one of symmetry",
        ),
        "homogeneous": Case(
            parameters={I2: I1, I3: I1},
            integrals={f"omega{i + 1}": w for i, w in enumerate(motion.spin)},
            integrable="Euler-Jacobi",
            note="the contact describes circles",
        ),
    },
    scenes={
        "default": ball.rubber_scene("Outer rolling.", 15.0),
        "inner": ball.rubber_scene("Inside a sphere three times as large.", 7.0, {}, {R1: -3}),
        "shell": ball.rubber_scene(
            "A shell around a sphere of a third of its radius.",
            10.0,
            {w1: "-1/20", w2: "-1/5"},
            {R1: "-1/3"},
        ),
    },
    drawing={"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("EhlersKoiller2007", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.of(
        SYSTEM, "rubber-ball-on-plane", {"R": R2}, grow=R1, note="the sphere becomes a plane"
    ),
)

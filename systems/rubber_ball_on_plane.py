"""The rubber ball on a plane: balanced, not symmetric; it neither slips nor twists.

Derived in Neumann's coordinates, brought down to omega and gamma, the vertical, both along the
ball's axes.  omega1 and omega2 are the velocities; omega3 follows from (omega, gamma) = 0.  With
J = I + D, D = m R^2, and G = J omega the equations are

    dG/dt = G x omega + lambda gamma,    dgamma/dt = gamma x omega,
    lambda = -(gamma, J^-1 (G x omega)) / Q,    Q = (gamma, J^-1 gamma),

those of Veselova's body with the moments J [EhlersKoillerMontgomeryRios2005].  Because
lambda = d(G, gamma)/dt, the part of G across gamma keeps its length.
"""

from __future__ import annotations

import sympy as sp

from voronec import Corrected, Relation, kinematics

m, R = sp.symbols("m R")
inertia = sp.symbols("I1:4")

ball = kinematics.BalancedBall.on_plane(R, m, inertia)
motion = ball.rubber
printed_equation = motion.momentum_equation(motion.multiplier(motion.momentum))

SYSTEM = ball.rubber_system(
    name="rubber-ball-on-plane",
    title="Rubber ball on a plane",
    description="A balanced, dynamically non-symmetric ball rolls on a plane without slipping and "
    "without turning about the vertical.",
    values={m: 1, R: 1, inertia: ("0.4", "0.5", "0.7")},
    equations={
        "momentum": Corrected(
            motion.equations["momentum"], printed_equation, "DragovicGajicJovanovic2020"
        )
    },
    integrable="Euler-Jacobi",
    scenes={"default": ball.rubber_scene("The contact wanders over the plane.", 10.0)},
    references=("EhlersKoillerMontgomeryRios2005", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.of(
        SYSTEM,
        "veselova",
        {f"J{i + 1}": J for i, J in enumerate(motion.moments)},
        note="The ball's rotation is that of a body with moments increased by m R^2.",
    ),
)

"""The ball of Borisov and Fedorov: a non-symmetric shell around a sphere of half its radius.

It is Chaplygin's ball on a sphere with epsilon = R1 / (R1 + R2) = -1,

    Gdot = G x omega,   gammadot = -gamma x omega,   G = I omega + D (omega - (omega, gamma) gamma),

and has the integral sum of (I_1 + I_2 + I_3 - 2 I_i + D) G_i gamma_i [BorisovFedorov1995].
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

R2, m = sp.symbols("R2 m")
inertia = sp.symbols("I1:4")

ball = kinematics.BalancedBall.on_sphere(-R2 / 2, R2, m, inertia)

SYSTEM = ball.system(
    name="borisov-fedorov-ball",
    title="Ball of Borisov and Fedorov",
    description="A balanced, dynamically non-symmetric shell rolls without slipping around a fixed "
    "sphere of half its radius.",
    meanings={
        "Borisov-Fedorov": "the integral that the ratio of the radii gives",
    },
    values={R2: 1, m: 1, inertia: ("0.4", "0.5", "0.7")},
    integrals={"Borisov-Fedorov": ball.motion.linear_integral},
    integrable="Euler-Jacobi",
    scenes={"default": ball.scene("A shell around a sphere of half its radius.", 60.0)},
    references=("BorisovFedorov1995", "Yaroshchuk1992", "DragovicGajicJovanovic2020"),
)

RELATIONS = (Relation.of(SYSTEM, "ball-on-sphere", {"R1": -R2 / 2, "R2": R2}),)

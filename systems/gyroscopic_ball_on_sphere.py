"""Chaplygin's ball with a gyroscope on a sphere, dynamically non-symmetric.

The momentum kappa of the gyroscope is constant in the ball.  With G the momentum of the ball about
the contact and gamma the normal of the sphere, both along the ball's principal axes,

    Gdot = (G + kappa) x omega,   gammadot = epsilon gamma x omega,   epsilon = R1 / (R1 + R2),
    G = I omega + D (omega - (omega, gamma) gamma),   D = m R2^2

[DragovicGajicJovanovic2020, eq. (Chap*)].
R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

Energy, the square of G + kappa and the measure are there for every epsilon; no integrable case is
known beyond those of symmetric balls, of the plane, and of kappa = 0, epsilon = -1.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, Square, kinematics

R1, R2, m = sp.symbols("R1 R2 m")
inertia, kappa = sp.symbols("I1:4"), sp.symbols("kappa1:4")

ball = kinematics.BalancedBall.on_sphere(R1, R2, m, inertia, kappa)

SYSTEM = ball.system(
    name="gyroscopic-ball-on-sphere",
    title="Gyroscopic Chaplygin ball on a sphere",
    description="A balanced, dynamically non-symmetric ball with a gyroscope rolls without "
    "slipping over a fixed sphere: outside, inside, or around it as a shell.",
    values={R1: 2, R2: 1, m: 1, inertia: ("0.4", "0.5", "0.7"), kappa: ("0.3", "-0.2", "0.5")},
    references=("Yaroshchuk1992", "Markeev1985", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.of(SYSTEM, "ball-on-sphere", vanish=kappa, note="the gyroscope is taken away"),
    Relation.of(
        SYSTEM, "gyroscopic-ball-on-plane", {"R": R2}, grow=R1, note="the sphere becomes a plane"
    ),
)
SQUARES = (
    Square.through(
        ("gyroscopic-ball-on-sphere", "ball-on-sphere", "chaplygin-ball"),
        ("gyroscopic-ball-on-sphere", "gyroscopic-ball-on-plane", "chaplygin-ball"),
        name="gyroscope and curvature of the sphere vanish in either order",
    ),
)

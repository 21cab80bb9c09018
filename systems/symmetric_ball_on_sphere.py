"""A dynamically symmetric ball on a sphere.

Moments A, A, C about the centre; along the ball's principal axes,

    Gdot = G x omega,   gammadot = epsilon gamma x omega,   epsilon = R1 / (R1 + R2),
    G = I omega + D (omega - (omega, gamma) gamma),   D = m R2^2.

R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

Along a motion, sigma = (omega, gamma) is a function of x = gamma_3 with

    (A + b x^2) sigma'' + 3 b x sigma' + b (1 - mu^2) sigma = 0,   b = (C - A) D / (C + D),

where mu = 1/epsilon = 1 + R2/R1, the prime is d/dx, and
mu (C - A) omega_3 = -A sigma' - x (C - A) omega_3'.
Its solutions are elementary: with c = sqrt(|b|/A) and y = sqrt(1 + (b/A) x^2), sigma = f/y with
f = exp(+-mu asinh(c x)) where C > A, and f = cos, sin of mu asin(c x) where C < A.  Two integrals
linear in the velocities are the constants of this solution; the cases below give them
[BorisovMamaev2002].
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, Square, kinematics

R1, R2, m, A, C = sp.symbols("R1 R2 m A C")

ball = kinematics.BalancedBall.on_sphere(R1, R2, m, (A, A, C))
solution = kinematics.SymmetricBallMotion(ball.motion)

SYSTEM = ball.system(
    name="symmetric-ball-on-sphere",
    title="Symmetric ball on a sphere",
    description="A dynamically symmetric ball rolls without slipping over a fixed sphere: outside, "
    "inside, or around it as a shell.",
    values={R1: 2, R2: 1, m: 1, A: "0.4", C: "0.6"},
    equations=solution.equations,
    cases=solution.cases,
    references=("BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

moments = {"I1": A, "I2": A, "I3": C}
RELATIONS = (
    Relation.of(SYSTEM, "ball-on-sphere", moments),
    Relation.of(
        SYSTEM, "chaplygin-ball", {"R": R2, **moments}, grow=R1, note="the sphere becomes a plane"
    ),
)
SQUARES = (
    Square.through(
        ("symmetric-ball-on-sphere", "ball-on-sphere", "chaplygin-ball"),
        ("symmetric-ball-on-sphere", "chaplygin-ball"),
        name="a symmetric ball on a sphere that becomes a plane",
    ),
)

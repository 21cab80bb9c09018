"""A dynamically symmetric ball with a gyroscope along its axis, on a sphere.

The moments A, A, C are those of ball and rotor about the centre, less the rotor's axial part; k is
the rotor's axial momentum.  Along the ball's principal axes,

    Gdot = (G + k e_3) x omega,   gammadot = epsilon gamma x omega,   epsilon = R1 / (R1 + R2),
    G = I omega + D (omega - (omega, gamma) gamma),   D = m R2^2.

R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

Zhukovsky's condition C = A gives Demchenko's ball.  Without it, sigma = (omega, gamma) is along a
motion a function of x = gamma_3 with

    (A + b x^2) sigma'' + 3 b x sigma' + b (1 - mu^2) sigma = 0,   b = (C - A) D / (C + D),

where mu = 1/epsilon = 1 + R2/R1, the prime is d/dx, and
mu w = -A sigma' - x w', w = (C - A) omega_3 + k.
Its solutions are elementary: with c = sqrt(|b|/A) and y = sqrt(1 + (b/A) x^2), sigma = f/y with
f = exp(+-mu asinh(c x)) where C > A, and f = cos, sin of mu asin(c x) where C < A.  Two integrals
linear in the velocities are the constants of this solution; the cases below give them
[BorisovMamaev2002].  The gyroscope only shifts (C - A) omega_3 by k.
"""

from __future__ import annotations

import sympy as sp

from voronec import Case, Relation, Square, kinematics

R1, R2, m, A, C, k = sp.symbols("R1 R2 m A C k")

ball = kinematics.BalancedBall.on_sphere(R1, R2, m, (A, A, C), (0, 0, k))
solution = kinematics.SymmetricBallMotion(ball.motion)
D, omega = ball.motion.contact_inertia, ball.motion.spin

# Zhukovsky's condition, C = A.
x, mu = solution.x, solution.mu
axial = A * solution.sigma + mu * k * x
half = mu * k * x / 2

SYSTEM = ball.system(
    name="symmetric-gyroscopic-ball-on-sphere",
    title="Symmetric gyroscopic ball on a sphere",
    description="A dynamically symmetric ball with a gyroscope along its axis rolls without "
    "slipping over a fixed sphere: outside, inside, or around it as a shell.",
    values={R1: 2, R2: 1, m: 1, A: "0.4", C: "0.6", k: "0.5"},
    equations=solution.equations,
    cases={
        **solution.cases,
        "Zhukovsky": Case(
            parameters={C: A},
            integrals={
                "axial": axial,
                "level": (A + D) * omega[2] - D / A * ((1 - mu) * axial - (2 - mu) * half) * x,
            },
            integrable="Euler-Jacobi",
            note="Demchenko's ball",
        ),
    },
    references=("BorisovMamaev2002", "Demchenko1924", "DragovicGajicJovanovic2020"),
)

moments = {"I1": A, "I2": A, "I3": C}
RELATIONS = (
    Relation.of(
        SYSTEM, "gyroscopic-ball-on-sphere", {**moments, "kappa1": 0, "kappa2": 0, "kappa3": k}
    ),
    Relation.of(SYSTEM, "symmetric-ball-on-sphere", vanish=k, note="the gyroscope is taken away"),
    Relation.of(SYSTEM, "bobylev-ball", {"R": R2}, grow=R1, note="the sphere becomes a plane"),
)
SQUARES = (
    Square.through(
        ("symmetric-gyroscopic-ball-on-sphere", "symmetric-ball-on-sphere", "chaplygin-ball"),
        ("symmetric-gyroscopic-ball-on-sphere", "bobylev-ball", "chaplygin-ball"),
        name="gyroscope of a symmetric ball and curvature of the sphere vanish in either order",
    ),
    Square.through(
        ("symmetric-gyroscopic-ball-on-sphere", "symmetric-ball-on-sphere", "ball-on-sphere"),
        ("symmetric-gyroscopic-ball-on-sphere", "gyroscopic-ball-on-sphere", "ball-on-sphere"),
        name="a symmetric ball on a sphere without its gyroscope",
    ),
    Square.through(
        (
            "symmetric-gyroscopic-ball-on-sphere",
            "gyroscopic-ball-on-sphere",
            "gyroscopic-ball-on-plane",
        ),
        ("symmetric-gyroscopic-ball-on-sphere", "bobylev-ball", "gyroscopic-ball-on-plane"),
        name="a symmetric gyroscopic ball on a sphere that becomes a plane",
    ),
)

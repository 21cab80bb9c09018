"""The ordinary ball on a sphere: its moment of inertia, A, is the same about all axes.

Along axes fixed in the ball, with D = m R2^2 and epsilon = R1 / (R1 + R2),

    Gdot = G x omega,   gammadot = epsilon gamma x omega,
    G = (A + D) omega - D (omega, gamma) gamma.

R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

The spin (omega, gamma) about the normal is constant, and so are, in the ball, the three components
of (A + D) omega + D (R2/R1) (omega, gamma) gamma.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, Square, kinematics

R1, R2, m, A = sp.symbols("R1 R2 m A")

ball = kinematics.BalancedBall.on_sphere(R1, R2, m, (A, A, A))
D, spin, normal = ball.motion.contact_inertia, ball.motion.spin, ball.motion.normal
along = spin.dot(normal)
constant_vector = (A + D) * spin + D * R2 / R1 * along * normal

SYSTEM = ball.system(
    name="homogeneous-ball-on-sphere",
    title="Ordinary ball on a sphere",
    description="A ball whose inertia is the same about all axes rolls without slipping over a "
    "fixed sphere: outside, inside, or around it as a shell.",
    meanings={
        "normal spin": "angular velocity along the normal",
        **{f"in the ball {k}": f"vector fixed in the ball, along its axis {k}" for k in (1, 2, 3)},
    },
    values={R1: 2, R2: 1, m: 1, A: "0.4"},
    integrals={
        "normal spin": along,
        **{f"in the ball {i + 1}": e for i, e in enumerate(constant_vector)},
    },
    integrable="Euler-Jacobi",
    references=("BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.of(SYSTEM, "symmetric-ball-on-sphere", {"A": A, "C": A}),
    Relation.of(SYSTEM, "homogeneous-ball", {"R": R2}, grow=R1, note="the sphere becomes a plane"),
)
SQUARES = (
    Square.through(
        ("homogeneous-ball-on-sphere", "symmetric-ball-on-sphere", "chaplygin-ball"),
        ("homogeneous-ball-on-sphere", "homogeneous-ball", "chaplygin-ball"),
        name="an ordinary ball on a sphere that becomes a plane",
    ),
)

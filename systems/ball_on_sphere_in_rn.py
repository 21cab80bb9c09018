"""Chaplygin's ball on a sphere in R^n: a balanced ball rolls without slipping over S^(n-1).

The configuration space is that of a free body, SE(n), given by its frame: Omega = g^T dg/dt and
W = g^T dx/dt.  gamma is the unit vector from the sphere's centre to the ball's, seen from the ball,
(R1 + R2) gamma = g^T x; the ball rolls, W = R2 Omega gamma, which keeps |gamma| = 1.  So

    dgamma/dt = -Omega gamma + W/(R1 + R2) = -epsilon Omega gamma,   epsilon = R1/(R1 + R2),

and with D = m R2^2 the momentum about the contact

    G_ij = I_ij Omega_ij + D (gamma gamma^T Omega + Omega gamma gamma^T)_ij

obeys dG/dt = [G, Omega] [Jovanovic2018].  R1 is signed: R1 < 0 inside the sphere (|R1| > R2) and
for a shell around it (|R1| < R2).
"""

from __future__ import annotations

from functools import partial

import sympy as sp

from voronec import System
from voronec.kinematics import BodyInRn

m, R1, R2 = sp.symbols("m R1 R2")


def member(n: int, name: str) -> System:
    """The ball in R^n."""
    ball = BodyInRn(n, m, R2, fixed=R1)
    return ball.system(
        name=name,
        title=f"Chaplygin ball on a sphere in R^{n}",
        description=f"A balanced, dynamically non-symmetric ball of R^{n} rolls without slipping "
        "over a fixed sphere: outside, inside, or around it as a shell.",
        values={R1: 2, R2: 1, m: 1},
        scenes={"default": ball.scene("Outside a sphere twice as large.", 20.0)},
        references=("Jovanovic2018", "Yaroshchuk1992"),
    )


MEMBERS = {str(n): partial(member, n, f"ball-on-sphere-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "ball-on-sphere-in-rn")

RELATIONS, SQUARES = BodyInRn(3, m, R2, fixed=R1).large_sphere(
    "ball-on-sphere-in-rn", "chaplygin-ball-in-rn", "ball-on-sphere", "chaplygin-ball"
)

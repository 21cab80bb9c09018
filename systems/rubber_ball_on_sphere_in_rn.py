"""The rubber ball on a sphere in R^n: balanced, it rolls over S^(n-1) without slip and twist.

The configuration space is that of a free body, SE(n), given by its frame: Omega = g^T dg/dt and
W = g^T dx/dt.  gamma is the unit vector from the sphere's centre to the ball's, seen from the ball,
(R1 + R2) gamma = g^T x.  The ball rolls, W = R2 Omega gamma, and does not turn in planes at right
angles to gamma, so Omega = gamma u^T - u gamma^T, or

    gamma_n Omega_ij = gamma_j Omega_in - gamma_i Omega_jn     (i < j < n);

Omega_in are the velocities, good where gamma_n is not 0.  With epsilon = R1/(R1 + R2), the moments
I_ij in the planes of two axes and G_ij = (I_ij + m R2^2) Omega_ij the equations are

    d(G gamma)/dt = -Omega G gamma + (1 - epsilon) G Omega gamma,   dgamma/dt = -epsilon Omega gamma

[Jovanovic2018].  The entries of G gamma are gamma_n P_i and -(P, gamma), where P_i are the momenta
of the velocities.  R1 is signed: R1 < 0 inside the sphere (|R1| > R2) and for a shell around it.
"""

from __future__ import annotations

from functools import partial

import sympy as sp

from voronec import System
from voronec.kinematics import BodyInRn

m, R1, R2 = sp.symbols("m R1 R2")


def member(n: int, name: str) -> System:
    """The ball in R^n."""
    ball = BodyInRn(n, m, R2, fixed=R1, twists=False)
    caption = "Outside a sphere twice as large, while gamma_n is positive."
    return ball.system(
        name=name,
        title=f"Rubber ball on a sphere in R^{n}",
        description=f"A balanced, dynamically non-symmetric ball of R^{n} rolls over a fixed "
        "sphere without slipping and without twisting.",
        values={R1: 2, R2: 1, m: 1},
        scenes={"default": ball.scene(caption, 6.0)},
        references=("Jovanovic2018", "EhlersKoiller2007"),
    )


MEMBERS = {str(n): partial(member, n, f"rubber-ball-on-sphere-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "rubber-ball-on-sphere-in-rn")

RELATIONS, SQUARES = BodyInRn(3, m, R2, fixed=R1, twists=False).large_sphere(
    "rubber-ball-on-sphere-in-rn",
    "rubber-ball-in-rn",
    "rubber-ball-on-sphere",
    "rubber-ball-on-plane",
)

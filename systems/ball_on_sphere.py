"""Chaplygin's ball on a sphere: balanced and dynamically non-symmetric, for every ratio of radii.

With G the momentum about the contact and gamma the normal of the sphere towards the ball's centre,
both along the ball's principal axes,

    Gdot = G x omega,   gammadot = epsilon gamma x omega,   epsilon = R1 / (R1 + R2),
    G = I omega + D (omega - (omega, gamma) gamma),   D = m R2^2

[DragovicGajicJovanovic2020, eq. (Chap)].
R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

Integrals are the energy and the square of G.  The measure sqrt(1 - D ((I + D)^-1 gamma, gamma)) is
invariant [Yaroshchuk1992].  In general the ball is not integrable; it is for epsilon = -1, a shell
around a sphere of half its radius, with an integral linear in G [BorisovFedorov1995].
"""

from __future__ import annotations

import sympy as sp

from voronec import Case, Relation, kinematics

R1, R2, m = sp.symbols("R1 R2 m")
inertia = sp.symbols("I1:4")

ball = kinematics.BalancedBall.on_sphere(R1, R2, m, inertia)

SYSTEM = ball.system(
    name="ball-on-sphere",
    title="Chaplygin ball on a sphere",
    description="A balanced, dynamically non-symmetric ball rolls without slipping over a fixed "
    "sphere: outside, inside, or around it as a shell.",
    values={R1: 2, R2: 1, m: 1, inertia: ("0.4", "0.5", "0.7")},
    cases={
        "epsilon = -1": Case(
            parameters={R1: -R2 / 2},
            integrals={"Borisov-Fedorov": ball.motion.linear_integral},
            integrable="Euler-Jacobi",
        ),
    },
    references=(
        "Chaplygin1903",
        "Yaroshchuk1992",
        "BorisovFedorov1995",
        "DragovicGajicJovanovic2020",
    ),
)

RELATIONS = (
    Relation.of(SYSTEM, "chaplygin-ball", {"R": R2}, grow=R1, note="the sphere becomes a plane"),
)

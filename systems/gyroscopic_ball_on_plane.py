"""Markeev's ball: a balanced, dynamically non-symmetric ball with a gyroscope rolls on a plane.

The momentum kappa of the gyroscope is constant in the ball.  With G the momentum of the ball about
the contact and gamma the vertical, both along the ball's principal axes,

    Gdot = (G + kappa) x omega,   gammadot = gamma x omega,
    G = I omega + D (omega - (omega, gamma) gamma),   D = m R^2

[Markeev1985].  The whole momentum G + kappa is constant in space; with the energy and the invariant
measure that makes the ball integrable [DragovicGajicJovanovic2020, eqs. (Chap*), (cl:int*)].
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

R, m = sp.symbols("R m")
inertia, kappa = sp.symbols("I1:4"), sp.symbols("kappa1:4")

ball = kinematics.BalancedBall.on_plane(R, m, inertia, kappa)

SYSTEM = ball.system(
    name="gyroscopic-ball-on-plane",
    title="Markeev's gyroscopic ball on a plane",
    description="A balanced, dynamically non-symmetric ball with a gyroscope rolls without "
    "slipping on a plane.",
    values={R: 1, m: 1, inertia: ("0.4", "0.5", "0.7"), kappa: ("0.3", "-0.2", "0.5")},
    poisson=ball.motion.poisson,
    integrable="Euler-Jacobi",
    scenes={"default": ball.scene("The gyroscope bends the path of the ball.")},
    references=("Markeev1985", "Chaplygin1903", "BorisovMamaev2001", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.of(SYSTEM, "chaplygin-ball", vanish=kappa, note="the gyroscope is taken away"),
)

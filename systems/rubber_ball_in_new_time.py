"""The rubber ball in the time in which it obeys Lagrange's equations: a particle on a sphere.

The particle is at gamma, a unit vector, and

    L = Q^(1/epsilon - 2) (Omega, J Omega)/2,    Omega = gamma' x gamma / epsilon,

with Q = (gamma, J^-1 gamma), without constraints.  Omega1 and Omega2 are the velocities; Omega3
follows from (Omega, gamma) = 0.  Rubber balls on spheres become this, omega = N Omega, with
dtau = N dt, N = Q^(1/(2 epsilon) - 1), J = I + D, epsilon = R1/(R1 + R2) [EhlersKoiller2007].
"""

from __future__ import annotations

import sympy as sp

from voronec import Case, Limit, Parameter, Relation, kinematics

epsilon, h = sp.symbols("epsilon h")
moments, names = sp.symbols("J1:4"), sp.symbols("Omega1 Omega2")
motion = kinematics.RubberMotion(moments, epsilon=epsilon, velocities=names)

SYSTEM = motion.particle_system(
    name="rubber-ball-in-new-time",
    title="The rubber ball in the new time",
    description="A particle moves freely on a sphere, in the metric that the rubber ball has after "
    "Chaplygin's change of time.",
    end="normal",
    whose="the ball",
    parameters=(
        Parameter(epsilon, "2/3", meaning="R1/(R1 + R2)"),
        *Parameter.each(moments, ("1.4", "1.5", "1.7"), positive=True, meaning="principal moment"),
    ),
    cases={
        "epsilon = -1": Case(
            parameters={epsilon: -1},
            integrals={"Borisov and Mamaev": motion.quadratic_integral / motion.form**3},
            integrable="Euler-Jacobi",
        ),
    },
    references=("EhlersKoiller2007", "BorisovMamaev2007"),
)

R1, R2, m = sp.symbols("R1 R2 m")
ball = kinematics.BalancedBall.on_sphere(R1, R2, m, sp.symbols("I1:4")).rubber
clock = ball.reducer

RELATIONS = (
    Relation.into(
        SYSTEM,
        "rubber-ball-on-sphere",
        {
            **{W: w / clock for W, w in zip(names, ball.velocities, strict=True)},
            **dict(zip(moments, ball.moments, strict=True)),
            epsilon: ball.epsilon,
        },
        clock=clock,
    ),
    Relation.of(
        SYSTEM,
        "veselova-in-new-time",
        limit=Limit(h, {epsilon: 1 / (1 + h)}),
        note="The sphere becomes a plane.",
    ),
)

"""The rubber ball in the time in which it obeys Lagrange's equations: a particle on a sphere.

The particle is at gamma, a unit vector, and

    L = Q^(1/epsilon - 2) (Omega, J Omega)/2,    Omega = gamma' x gamma / epsilon,

with Q = (gamma, J^-1 gamma), without constraints.  Omega1 and Omega2 are the velocities; Omega3
follows from (Omega, gamma) = 0.  Rubber balls on spheres become this, omega = N Omega, with
dtau = N dt, N = Q^(1/(2 epsilon) - 1), J = I + D, epsilon = R1/(R1 + R2) [EhlersKoiller2007].
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Case,
    Fibration,
    Frame,
    Limit,
    Measure,
    Parameter,
    Relation,
    Scene,
    Shape,
    System,
    kinematics,
    velocity,
)

epsilon, h = sp.symbols("epsilon h")
moments, names = sp.symbols("J1:4"), sp.symbols("Omega1 Omega2")
motion = kinematics.RubberMotion(moments, epsilon=epsilon, velocities=names)
gamma, Omega, Q = motion.normal, motion.spin, motion.form
spin = sp.Matrix([velocity(g) for g in gamma]).cross(gamma) / epsilon

SYSTEM = System(
    name="rubber-ball-in-new-time",
    title="The rubber ball in the new time",
    description="A particle moves freely on a sphere, in the metric that the rubber ball has after "
    "Chaplygin's change of time.",
    sketch=kinematics.particle_sketch(gamma),
    fibration=Fibration(base=gamma, fibre=(), relations=(gamma.dot(gamma) - 1,)),
    frame=Frame.quasi(dict(zip(names, spin, strict=False))),
    lagrangian=Q ** (1 / epsilon - 2) * spin.dot(motion.tensor * spin) / 2,
    meanings={
        **kinematics.vector_meanings(gamma, "place of the particle on the unit sphere", "the ball"),
        **kinematics.vector_meanings(names, "angular velocity in the new time", "the ball"),
    },
    parameters=(
        Parameter(epsilon, "2/3", meaning="R1/(R1 + R2)"),
        *Parameter.each(moments, ("1.4", "1.5", "1.7"), positive=True, meaning="principal moment"),
    ),
    equations={"normal": motion.equations["normal"]},
    integrals={"energy": Q ** (1 / epsilon - 2) * Omega.dot(motion.momentum) / 2},
    measure=Measure(Q ** (2 / epsilon - 3) / gamma[2], (*gamma, *names)),
    cases={
        "epsilon = -1": Case(
            parameters={epsilon: -1},
            integrals={"Borisov and Mamaev": motion.quadratic_integral / Q**3},
            integrable="Euler-Jacobi",
        ),
    },
    scenes={
        "default": Scene(
            initial={gamma[0]: "12/13", gamma[2]: "5/13", names[0]: "1/20", names[1]: "1/5"},
            times=(0.0, 10.0),
            outputs=gamma,
            caption="The trace of the normal on the ball.",
        ),
    },
    shapes=(
        Shape.ball(0.1, centre=gamma, contact=gamma),
        Shape.ball(1, role="ground"),
    ),
    references=("EhlersKoiller2007", "BorisovMamaev2007"),
)

R1, R2, m = sp.symbols("R1 R2 m")
ball = kinematics.BalancedBall.on_sphere(R1, R2, m, sp.symbols("I1:4")).rubber
clock = ball.reducer

RELATIONS = (
    Relation(
        "rubber-ball-on-sphere",
        "rubber-ball-in-new-time",
        state={
            **{g: g for g in gamma},
            **{W: w / clock for W, w in zip(names, ball.velocities, strict=True)},
        },
        parameters={**dict(zip(moments, ball.moments, strict=True)), epsilon: ball.epsilon},
        clock=clock,
    ),
    Relation.of(
        SYSTEM,
        "veselova-in-new-time",
        limit=Limit(h, {epsilon: 1 / (1 + h)}),
        note="The sphere becomes a plane.",
    ),
)

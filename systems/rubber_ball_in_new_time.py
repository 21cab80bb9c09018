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
    Equation,
    Fibration,
    Frame,
    Limit,
    Measure,
    Parameter,
    Relation,
    Scene,
    System,
    velocity,
)

epsilon, h = sp.symbols("epsilon h")
moments = sp.symbols("J1:4")
J = sp.diag(*moments)
gamma = sp.Matrix(sp.symbols("gamma1:4"))
Q = gamma.dot(J.inv() * gamma)
spin = sp.Matrix([velocity(g) for g in gamma]).cross(gamma) / epsilon
kinetic = Q ** (1 / epsilon - 2) * spin.dot(J * spin) / 2
W1, W2 = sp.symbols("Omega1 Omega2")
Omega = sp.Matrix([W1, W2, -(W1 * gamma[0] + W2 * gamma[1]) / gamma[2]])
spread = sum(
    (moments[i] - moments[j]) * (moments[i] - moments[k]) * (Omega[i] * gamma[i]) ** 2
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
)

SYSTEM = System(
    name="rubber-ball-in-new-time",
    title="The rubber ball in the new time",
    description="A particle moves freely on a sphere, in the metric that the rubber ball has after "
    "Chaplygin's change of time.",
    fibration=Fibration(base=tuple(gamma), fibre=(), relations=(gamma.dot(gamma) - 1,)),
    frame=Frame.quasi({W1: spin[0], W2: spin[1]}),
    lagrangian=kinetic,
    parameters=(
        Parameter(epsilon, sp.Rational(2, 3), meaning="R1/(R1 + R2)"),
        *(
            Parameter(i, sp.Rational(tenths, 10), positive=True, meaning="principal moment")
            for i, tenths in zip(moments, (14, 15, 17), strict=True)
        ),
    ),
    equations={"normal": Equation(tuple(gamma), tuple(epsilon * gamma.cross(Omega)))},
    integrals={
        "energy": Q ** (1 / epsilon - 2) * Omega.dot(J * Omega) / 2,
    },
    measure=Measure(Q ** (2 / epsilon - 3) / gamma[2], (*gamma, W1, W2)),
    cases={
        "epsilon = -1": Case(
            parameters={epsilon: -1},
            integrals={"Borisov and Mamaev": (J.det() * Omega.dot(Omega) - spread / Q) / Q**3},
            integrable="Euler-Jacobi",
        ),
    },
    scenes={
        "default": Scene(
            initial={
                gamma[0]: sp.Rational(12, 13),
                gamma[2]: sp.Rational(5, 13),
                W1: sp.Rational(1, 20),
                W2: sp.Rational(1, 5),
            },
            times=(0.0, 10.0),
            outputs=tuple(gamma),
            caption="The trace of the normal on the ball.",
        ),
    },
    references=("EhlersKoiller2007", "BorisovMamaev2007"),
)

N = Q ** (1 / (2 * epsilon) - 1)
R1, R2, m = sp.symbols("R1 R2 m")
inertia = sp.symbols("I1:4")
of_ball = {j: i + m * R2**2 for j, i in zip(moments, inertia, strict=True)}
of_ball[epsilon] = R1 / (R1 + R2)
clock = N.subs(of_ball)

RELATIONS = (
    Relation(
        "rubber-ball-on-sphere",
        "rubber-ball-in-new-time",
        state={
            **{str(g): g for g in gamma},
            "Omega1": sp.Symbol("omega1") / clock,
            "Omega2": sp.Symbol("omega2") / clock,
        },
        parameters=of_ball,
        clock=clock,
    ),
    Relation(
        "rubber-ball-in-new-time",
        "veselova-in-new-time",
        parameters={str(j): j for j in moments},
        limit=Limit(h, {epsilon: 1 / (1 + h)}),
        note="The sphere becomes a plane.",
    ),
)

"""Veselova's system in the time in which it obeys Lagrange's equations: a particle on a sphere.

The particle is at gamma, a unit vector, and

    L = (Omega, J Omega)/(2 Q),    Omega = gamma' x gamma,    Q = (gamma, J^-1 gamma),

without constraints.  Omega1 and Omega2 are the velocities; Omega3 follows from (Omega, gamma) = 0.
Veselova's system, and the rubber ball on a plane with J = I + D, become this, omega = N Omega, with
dtau = N dt, N = Q^(-1/2) [EhlersKoillerMontgomeryRios2005].
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Relation,
    Scene,
    System,
    velocity,
)

moments = sp.symbols("J1:4")
J = sp.diag(*moments)
gamma = sp.Matrix(sp.symbols("gamma1:4"))
Q = gamma.dot(J.inv() * gamma)
spin = sp.Matrix([velocity(g) for g in gamma]).cross(gamma)
kinetic = spin.dot(J * spin) / Q / 2
W1, W2 = sp.symbols("Omega1 Omega2")
Omega = sp.Matrix([W1, W2, -(W1 * gamma[0] + W2 * gamma[1]) / gamma[2]])
G = J * Omega

SYSTEM = System(
    name="veselova-in-new-time",
    title="Veselova's system in the new time",
    description="A particle moves freely on a sphere, in the metric that Veselova's system has "
    "after Chaplygin's change of time.",
    fibration=Fibration(base=tuple(gamma), fibre=(), relations=(gamma.dot(gamma) - 1,)),
    frame=Frame.quasi({W1: spin[0], W2: spin[1]}),
    lagrangian=kinetic,
    parameters=tuple(
        Parameter(i, sp.Rational(tenths, 10), positive=True, meaning="principal moment")
        for i, tenths in zip(moments, (14, 15, 17), strict=True)
    ),
    equations={"normal": Equation(tuple(gamma), tuple(gamma.cross(Omega)))},
    integrals={
        "energy": G.dot(Omega) / Q / 2,
        "momentum across the normal": (G.dot(G) - G.dot(gamma) ** 2) / Q,
    },
    measure=Measure(1 / (Q * gamma[2]), (*gamma, W1, W2)),
    integrable="Euler-Jacobi",
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
            caption="The trace of the direction on the body.",
        ),
    },
    references=("EhlersKoillerMontgomeryRios2005", "VeselovVeselova1988"),
)

RELATIONS = (
    Relation(
        "veselova",
        "veselova-in-new-time",
        state={
            **{str(g): g for g in gamma},
            "Omega1": sp.Symbol("omega1") * sp.sqrt(Q),
            "Omega2": sp.Symbol("omega2") * sp.sqrt(Q),
        },
        parameters={str(x): x for x in moments},
        clock=1 / sp.sqrt(Q),
    ),
)

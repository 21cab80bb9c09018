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
    Shape,
    System,
    kinematics,
    velocity,
)

moments, names = sp.symbols("J1:4"), sp.symbols("Omega1 Omega2")
motion = kinematics.RubberMotion(moments, velocities=names)
gamma, Omega, Q = motion.normal, motion.spin, motion.form
spin = sp.Matrix([velocity(g) for g in gamma]).cross(gamma)

SYSTEM = System(
    name="veselova-in-new-time",
    title="Veselova's system in the new time",
    description="A particle moves freely on a sphere, in the metric that Veselova's system has "
    "after Chaplygin's change of time.",
    sketch=kinematics.particle_sketch(gamma),
    fibration=Fibration(base=gamma, fibre=(), relations=(gamma.dot(gamma) - 1,)),
    frame=Frame.quasi(dict(zip(names, spin, strict=False))),
    lagrangian=spin.dot(motion.tensor * spin) / Q / 2,
    parameters=Parameter.each(
        moments, ("1.4", "1.5", "1.7"), positive=True, meaning="principal moment"
    ),
    equations={"normal": Equation(gamma, gamma.cross(Omega))},
    integrals={
        "energy": motion.momentum.dot(Omega) / Q / 2,
        "momentum across the normal": motion.integrals["momentum across the normal"] / Q,
    },
    measure=Measure(1 / (Q * gamma[2]), (*gamma, *names)),
    integrable="Euler-Jacobi",
    meanings={
        **kinematics.vector_meanings(gamma, "place of the particle on the unit sphere"),
        **kinematics.vector_meanings(names, "angular velocity in the new time"),
        "momentum across the normal": "square of the momentum's part across gamma",
    },
    scenes={
        "default": Scene(
            initial={gamma[0]: "12/13", gamma[2]: "5/13", names[0]: "1/20", names[1]: "1/5"},
            times=(0.0, 10.0),
            outputs=gamma,
            caption="The trace of the direction on the body.",
        ),
    },
    shapes=(
        Shape.ball(0.1, centre=gamma, contact=gamma),
        Shape.ball(1, role="ground"),
    ),
    references=("EhlersKoillerMontgomeryRios2005", "VeselovVeselova1988"),
)

RELATIONS = (
    Relation(
        "veselova",
        "veselova-in-new-time",
        state={
            **{g: g for g in gamma},
            **{W: w * sp.sqrt(Q) for W, w in zip(names, sp.symbols("omega1:3"), strict=True)},
        },
        parameters={x: x for x in moments},
        clock=1 / sp.sqrt(Q),
    ),
)

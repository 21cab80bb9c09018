"""Veselova's system: a rigid body about a fixed point that does not turn about a fixed direction.

gamma, the fixed direction, and omega are along the body's axes.  omega1 and omega2 are the
velocities; omega3 follows from (omega, gamma) = 0.  With moments J and G = J omega,

    dG/dt = G x omega + lambda gamma,    dgamma/dt = gamma x omega,
    lambda = -(gamma, J^-1 (G x omega)) / Q,    Q = (gamma, J^-1 gamma)   [VeselovVeselova1988].
"""

from __future__ import annotations

import sympy as sp

from voronec import Body, Fibration, Frame, Parameter, Scene, Shape, System, kinematics
from voronec.kinematics import (
    Rotation,
    RubberMotion,
    euler_meanings,
    kinetic_energy,
    vector_meanings,
)

phi, theta, psi = sp.symbols("phi theta psi")
moments = sp.symbols("J1:4")

rotation = Rotation.euler("zxz", phi, theta, psi)
motion = RubberMotion(moments)
w1, w2 = motion.velocities

SYSTEM = System(
    name="veselova",
    title="Veselova's system",
    description="A rigid body about a fixed point whose angular velocity stays at right angles to "
    "a direction fixed in space.",
    sketch=kinematics.pinned_sketch((phi, theta, psi), still="no turn about the vertical"),
    fibration=Fibration(base=(theta, psi), fibre=(phi,)),
    frame=Frame.quasi(
        dict(zip((w1, w2), rotation.body_rates, strict=False)),
        beside={sp.Symbol("omega3"): rotation.body_rates[2]},
    ),
    lagrangian=kinetic_energy(0, (0, 0, 0), moments, rotation.body_rates),
    constraints=(rotation.space_rates[2],),
    parameters=Parameter.each(
        moments, ("1.4", "1.5", "1.7"), positive=True, meaning="principal moment"
    ),
    invariants=dict(zip(map(str, motion.normal), rotation.matrix.row(2), strict=True)),
    equations=motion.equations,
    integrals=motion.integrals,
    measure=motion.measure,
    multiplier=motion.reducer,
    essential=(theta, psi, w1, w2),
    integrable="Euler-Jacobi",
    meanings={
        **euler_meanings((phi, theta, psi)),
        **vector_meanings((w1, w2)),
        **vector_meanings(map(str, motion.normal), "direction fixed in space"),
        "momentum across the normal": "square of the momentum's part across gamma",
    },
    scenes={
        "default": Scene(
            initial={theta: "6/5", w1: "-1/5", w2: "1/20"},
            times=(0.0, 10.0),
            outputs=(phi, theta, psi),
            caption="The body swings about a fixed point without turning about the vertical.",
        ),
    },
    bodies=(Body(0, inertia=moments, omega=rotation.body_rates),),
    shapes=(Shape.box((1, 0.7, 0.4), attitude=rotation.matrix),),
    references=("VeselovVeselova1988", "DragovicGajicJovanovic2020"),
)

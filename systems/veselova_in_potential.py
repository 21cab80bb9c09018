"""Veselova's body in a potential: heavy, or in the field of Clebsch and Neumann.

gamma is the direction fixed in space about which the body does not turn, (omega, gamma) = 0, and
the vertical of the potential V = (b, gamma) + epsilon (gamma, J gamma)/2: a weight, and a field as
of a distant centre.  With moments J, G = J omega, F = b + epsilon J gamma,

    dG/dt = G x omega + gamma x F + lambda gamma,    dgamma/dt = gamma x omega,
    lambda = -(gamma, J^-1 (G x omega + gamma x F)) / Q,    Q = (gamma, J^-1 gamma).

Measure and reducing multiplier are those of the body without a potential.  Without weight there is
the integral |G - (G, gamma) gamma|^2 - epsilon det J Q, as in Neumann's problem
[VeselovVeselova1988]; a body with an axis of symmetry that holds the centre of mass keeps
omega3 Q^(1/2).
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
    Case,
    Equation,
    Fibration,
    Frame,
    Parameter,
    Relation,
    Scene,
    Shape,
    System,
    kinematics,
)
from voronec.kinematics import Rotation, RubberMotion, euler_meanings, vector_meanings

phi, theta, psi, epsilon = sp.symbols("phi theta psi epsilon")
moments, b = sp.symbols("J1:4"), sp.symbols("b1:4")

rotation = Rotation.euler("zxz", phi, theta, psi)
motion = RubberMotion(moments)
w1, w2 = motion.velocities
gamma, vertical = motion.normal, rotation.matrix.row(2).T
values = dict(zip(gamma, vertical, strict=True))


def potential(normal: sp.Matrix) -> sp.Expr:
    """V of the direction fixed in space, values from the body."""
    return normal.dot(sp.Matrix(b)) + epsilon * normal.dot(motion.tensor * normal) / 2


torque = gamma.cross(sp.Matrix(b) + epsilon * motion.tensor * gamma)
momentum_rate = sp.Matrix(motion.torque) + torque
across = momentum_rate.dot(motion.tensor.inv() * gamma)

SYSTEM = System(
    name="veselova-in-potential",
    title="Veselova's system in a potential",
    description="A heavy rigid body about a fixed point whose angular velocity stays horizontal.",
    sketch=kinematics.pinned_sketch((phi, theta, psi), still="no turn about the vertical"),
    fibration=Fibration(base=(theta, psi), fibre=(phi,)),
    frame=Frame.quasi(
        dict(zip((w1, w2), rotation.body_rates, strict=False)),
        beside={sp.Symbol("omega3"): rotation.body_rates[2]},
    ),
    lagrangian=kinematics.kinetic_energy(0, (0, 0, 0), moments, rotation.body_rates)
    - potential(vertical),
    constraints=(rotation.space_rates[2],),
    parameters=(
        *Parameter.each(moments, ("1.4", "1.5", "1.7"), positive=True, meaning="principal moment"),
        *Parameter.each(b, (0, 0, 1), meaning="weight times the centre of mass, along an axis"),
        Parameter(epsilon, 0, meaning="strength of the field of the second degree"),
    ),
    invariants=dict(zip(map(str, gamma), vertical, strict=True)),
    equations={
        "momentum": Equation(motion.momentum, momentum_rate - across / motion.form * gamma),
        "normal": motion.equations["normal"],
    },
    integrals={"energy": motion.energy + potential(gamma)},
    measure=motion.measure,
    multiplier=motion.reducer,
    essential=(theta, psi, w1, w2),
    meanings={
        **euler_meanings((phi, theta, psi)),
        **vector_meanings((w1, w2)),
        **vector_meanings(map(str, gamma), "the vertical"),
    },
    cases={
        "Clebsch-Neumann": Case(
            parameters=dict.fromkeys(b, 0),
            integrals={
                "momentum across the vertical": motion.integrals["momentum across the normal"]
                - epsilon * motion.tensor.det() * motion.form
            },
            integrable="Euler-Jacobi",
            note="without weight",
        ),
        "Lagrange": Case(
            parameters={moments[1]: moments[0], b[0]: 0, b[1]: 0},
            integrals={"axial": motion.spin[2] * motion.root},
            integrable="Euler-Jacobi",
            note="the centre of mass lies on an axis of symmetry",
        ),
    },
    scenes={
        "default": Scene(
            initial={theta: "6/5", w1: "-1/5", w2: "1/20"},
            times=(0.0, 20.0),
            outputs=(phi, theta, psi),
            caption="A heavy body swings without turning about the vertical.",
        ),
    },
    bodies=(
        Body(0, inertia=moments, omega=rotation.body_rates, torque=tuple(torque.xreplace(values))),
    ),
    shapes=(Shape.box((1, 0.7, 0.4), attitude=rotation.matrix),),
    references=("VeselovVeselova1988", "DragovicGajicJovanovic1998", "Tsiganov2015"),
)

RELATIONS = (Relation.of(SYSTEM, "veselova", vanish=(*b, epsilon), note="without weight or field"),)

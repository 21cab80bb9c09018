"""Veselova's system: a rigid body about a fixed point that does not turn about a fixed direction.

gamma, the fixed direction, and omega are along the body's axes.  omega1 and omega2 are the
velocities; omega3 follows from (omega, gamma) = 0.  With moments J and G = J omega,

    dG/dt = G x omega + lambda gamma,    dgamma/dt = gamma x omega,
    lambda = -(gamma, J^-1 (G x omega)) / Q,    Q = (gamma, J^-1 gamma)   [VeselovVeselova1988].
"""

from __future__ import annotations

import sympy as sp

from voronec import Equation, Fibration, Frame, Measure, Parameter, Scene, System
from voronec.kinematics import Rotation, kinetic_energy

phi, theta, psi = sp.symbols("phi theta psi")
moments = sp.symbols("J1:4")
rotation = Rotation.euler("zxz", phi, theta, psi)

gamma = sp.Matrix(sp.symbols("gamma1:4"))
w1, w2 = sp.symbols("omega1 omega2")
omega = sp.Matrix([w1, w2, -(w1 * gamma[0] + w2 * gamma[1]) / gamma[2]])  # the constraint
J = sp.diag(*moments)
G = J * omega
Q = gamma.dot(J.inv() * gamma)
torque = G.cross(omega)
multiplier = -gamma.dot(J.inv() * torque) / Q

SYSTEM = System(
    name="veselova",
    title="Veselova's system",
    description="A rigid body about a fixed point whose angular velocity stays at right angles to "
    "a direction fixed in space.",
    fibration=Fibration(base=(theta, psi), fibre=(phi,)),
    frame=Frame.quasi(dict(zip((w1, w2), rotation.body_rates[:2], strict=True))),
    lagrangian=kinetic_energy(0, (0, 0, 0), moments, rotation.body_rates),
    constraints=(rotation.space_rates[2],),
    parameters=tuple(
        Parameter(i, sp.Rational(tenths, 10), positive=True, meaning="principal moment")
        for i, tenths in zip(moments, (14, 15, 17), strict=True)
    ),
    invariants=dict(zip(map(str, gamma), rotation.matrix.row(2), strict=True)),
    equations={
        "momentum": Equation(tuple(G), tuple(torque + multiplier * gamma)),
        "normal": Equation(tuple(gamma), tuple(gamma.cross(omega))),
    },
    integrals={
        "energy": G.dot(omega) / 2,
        "momentum across the normal": G.dot(G) - G.dot(gamma) ** 2,
    },
    # In omega1, omega2: the plane (omega, gamma) = 0 has the area domega1 domega2 / gamma3.
    measure=Measure(sp.sqrt(Q) / gamma[2], (*gamma, w1, w2)),
    multiplier=1 / sp.sqrt(Q),
    essential=(theta, psi, w1, w2),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={theta: sp.Rational(6, 5), w1: -sp.Rational(1, 5), w2: sp.Rational(1, 20)},
            times=(0.0, 10.0),
            outputs=(phi, theta, psi),
            caption="The body swings about a fixed point without turning about the vertical.",
        ),
    },
    references=("VeselovVeselova1988", "DragovicGajicJovanovic2020"),
)

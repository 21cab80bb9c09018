"""The rubber ball on a plane: balanced, not symmetric; it neither slips nor twists.

Derived in Neumann's coordinates, brought down to omega and gamma, the vertical, both along the
ball's axes.  omega1 and omega2 are the velocities; omega3 follows from (omega, gamma) = 0.  With
J = I + D, D = m R^2, and G = J omega the equations are

    dG/dt = G x omega + lambda gamma,    dgamma/dt = gamma x omega,
    lambda = -(gamma, J^-1 (G x omega)) / Q,    Q = (gamma, J^-1 gamma),

those of Veselova's body with the moments J [EhlersKoillerMontgomeryRios2005].  Because
lambda = d(G, gamma)/dt, the part of G across gamma keeps its length.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from voronec import (
    Corrected,
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Relation,
    Scene,
    System,
)
from voronec.kinematics import RollingBall

m, R = sp.symbols("m R")
inertia = sp.symbols("I1:4")
ball = RollingBall.on_plane(R, m, inertia)
u, v, theta = ball.base

gamma = sp.Matrix(sp.symbols("gamma1:4"))
w1, w2 = sp.symbols("omega1 omega2")
omega = sp.Matrix([w1, w2, -(w1 * gamma[0] + w2 * gamma[1]) / gamma[2]])  # no twist
J = sp.diag(*(moment + m * R**2 for moment in inertia))
G = J * omega
Q = gamma.dot(J.inv() * gamma)
torque = G.cross(omega)
multiplier = -gamma.dot(J.inv() * torque) / Q
printed = -G.dot(J.inv() * torque) / Q


def declared(ball: RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi({w1: ball.spin[0], w2: ball.spin[1]}),
        "lagrangian": ball.energy,
    }


SYSTEM = System(
    name="rubber-ball-on-plane",
    title="Rubber ball on a plane",
    description="A balanced, dynamically non-symmetric ball rolls on a plane without slipping and "
    "without turning about the vertical.",
    fibration=Fibration(base=(u, v), fibre=(*ball.fibre, theta)),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=(*ball.no_slip, ball.no_twist),
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        *(
            Parameter(i, sp.Rational(tenths, 10), positive=True, meaning="principal moment")
            for i, tenths in zip(inertia, (4, 5, 7), strict=True)
        ),
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum": Corrected(
            Equation(tuple(G), tuple(torque + multiplier * gamma)),
            Equation(tuple(G), tuple(torque + printed * gamma)),
            "DragovicGajicJovanovic2020",
        ),
        "normal": Equation(tuple(gamma), tuple(gamma.cross(omega))),
    },
    integrals={
        "energy": G.dot(omega) / 2,
        "momentum across the normal": G.dot(G) - G.dot(gamma) ** 2,
    },
    # In omega1, omega2: the plane (omega, gamma) = 0 has the area domega1 domega2 / gamma3.
    measure=Measure(sp.sqrt(Q) / gamma[2], (*gamma, w1, w2)),
    multiplier=1 / sp.sqrt(Q),
    essential=(u, v, w1, w2),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={u: sp.Rational(6, 5), w1: sp.Rational(1, 20), w2: sp.Rational(1, 5)},
            times=(0.0, 10.0),
            outputs=(*ball.fibre, u, v),
            caption="The contact wanders over the plane.",
        ),
    },
    references=("EhlersKoillerMontgomeryRios2005", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation(
        "rubber-ball-on-plane",
        "veselova",
        parameters={f"J{i + 1}": J[i, i] for i in range(3)},
        note="The ball's rotation is that of a body with moments increased by m R^2.",
    ),
)

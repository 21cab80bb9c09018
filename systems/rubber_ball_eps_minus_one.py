"""The rubber ball as a shell around a sphere of half its radius: epsilon = -1.

R1 = -R2/2, hence epsilon = R1/(R1 + R2) = -1.  omega1 and omega2 are the velocities, and omega3
follows from (omega, gamma) = 0.  With J = I + D, D = m R2^2, and G = J omega,

    dG/dt = G x omega + lambda gamma,    dgamma/dt = -gamma x omega,
    lambda = -(gamma, J^-1 (G x omega)) / Q,    Q = (gamma, J^-1 gamma),

the system is integrable [BorisovMamaev2007].  Its second integral,

    F = J1 J2 J3 |omega|^2 - S/Q,    S = sum of (Ji - Jj)(Ji - Jk) omega_i^2 gamma_i^2,

i, j, k being 1, 2, 3 in any order, was found by linear algebra.  For generic moments it and the
energy span all integrals that are quadratic forms in omega, of degree 2 in gamma, divided by Q.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from voronec import Equation, Fibration, Frame, Measure, Parameter, Relation, Scene, System
from voronec.kinematics import RollingBall

R2, m = sp.symbols("R2 m")
R1 = -R2 / 2
inertia = sp.symbols("I1:4")
ball = RollingBall.on_sphere(R1, R2, m, inertia)
u, v, theta = ball.base

gamma = sp.Matrix(sp.symbols("gamma1:4"))
w1, w2 = sp.symbols("omega1 omega2")
omega = sp.Matrix([w1, w2, -(w1 * gamma[0] + w2 * gamma[1]) / gamma[2]])  # no twist
moments = [moment + m * R2**2 for moment in inertia]
J = sp.diag(*moments)
G = J * omega
Q = gamma.dot(J.inv() * gamma)
torque = G.cross(omega)
multiplier = -gamma.dot(J.inv() * torque) / Q
spread = sum(
    (moments[i] - moments[j]) * (moments[i] - moments[k]) * (omega[i] * gamma[i]) ** 2
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
)


def declared(ball: RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi({w1: ball.spin[0], w2: ball.spin[1]}),
        "lagrangian": ball.energy,
    }


SYSTEM = System(
    name="rubber-ball-eps-minus-one",
    title="Rubber ball around a sphere of half its radius",
    description="A balanced, dynamically non-symmetric shell rolls, without slipping and without "
    "turning about the common normal, around a fixed sphere of half its radius.",
    fibration=Fibration(base=(u, v), fibre=(*ball.fibre, theta)),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=(*ball.no_slip, ball.no_twist),
    parameters=(
        Parameter(R2, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass"),
        *(
            Parameter(i, sp.Rational(tenths, 10), positive=True, meaning="principal moment")
            for i, tenths in zip(inertia, (4, 5, 7), strict=True)
        ),
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum": Equation(tuple(G), tuple(torque + multiplier * gamma)),
        "normal": Equation(tuple(gamma), tuple(-gamma.cross(omega))),
    },
    integrals={
        "energy": G.dot(omega) / 2,
        "Borisov and Mamaev": J.det() * omega.dot(omega) - spread / Q,
    },
    # In omega1, omega2: the plane (omega, gamma) = 0 has the area domega1 domega2 / gamma3.
    measure=Measure(1 / (sp.sqrt(Q) * gamma[2]), (*gamma, w1, w2)),
    multiplier=Q ** sp.Rational(-3, 2),
    essential=(u, v, w1, w2),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={
                u: sp.Rational(6, 5),
                sp.Symbol("u1"): 1,
                w1: -sp.Rational(1, 20),
                w2: -sp.Rational(1, 5),
            },
            times=(0.0, 10.0),
            outputs=(u, v, *ball.fibre),
            caption="The shell rolls around the sphere.",
        ),
    },
    references=("BorisovMamaev2007", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation(
        "rubber-ball-eps-minus-one",
        "rubber-ball-on-sphere",
        parameters={"R1": R1, **{str(p): p for p in (R2, m, *inertia)}},
    ),
)

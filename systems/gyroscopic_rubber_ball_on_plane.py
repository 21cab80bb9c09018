"""The rubber ball with a gyroscope on a plane: it neither slips nor twists.

kappa is the gyroscope's momentum, constant in the ball; omega1 and omega2 are the velocities, and
omega3 follows from (omega, gamma) = 0.  With J = I + D, D = m R^2, and G = J omega,

    dG/dt = (G + kappa) x omega + lambda gamma,    dgamma/dt = gamma x omega,
    lambda = -(gamma, J^-1 ((G + kappa) x omega)) / Q,    Q = (gamma, J^-1 gamma).

Because lambda = d(G + kappa, gamma)/dt, the part of G + kappa across gamma keeps its length.  With
dtau = Q^(-1/2) dt the motion is Hamilton's on the cotangent bundle of the sphere, in a magnetic
field.

The gyroscope enters as in the ball of Markeev, which rolls without slipping and may twist
[Markeev1985]; of the rubber ball he says nothing.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from voronec import (
    Case,
    Equation,
    Fibration,
    Frame,
    Limit,
    Measure,
    Parameter,
    Poisson,
    Relation,
    Scene,
    System,
)
from voronec.kinematics import RollingBall

m, R, h = sp.symbols("m R h")
inertia, kappa = sp.symbols("I1:4"), sp.Matrix(sp.symbols("kappa1:4"))
ball = RollingBall.on_plane(R, m, inertia)
u, v, theta = ball.base

gamma = sp.Matrix(sp.symbols("gamma1:4"))
w1, w2 = sp.symbols("omega1 omega2")
omega = sp.Matrix([w1, w2, -(w1 * gamma[0] + w2 * gamma[1]) / gamma[2]])  # no twist
J = sp.diag(*(moment + m * R**2 for moment in inertia))
G = J * omega
Q = gamma.dot(J.inv() * gamma)
whole = G + kappa
torque = whole.cross(omega)
multiplier = -gamma.dot(J.inv() * torque) / Q
N = 1 / sp.sqrt(Q)

# The momentum of the motion of gamma, M = N (G - (G, gamma) gamma), with (M, gamma) = 0.
M1, M2 = sp.symbols("M1 M2")
M3 = -(M1 * gamma[0] + M2 * gamma[1]) / gamma[2]
across = N * (G - G.dot(gamma) * gamma)
field = -N * kappa.dot(gamma)


def declared(ball: RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi({w1: ball.spin[0], w2: ball.spin[1]}),
        "lagrangian": ball.energy + kappa.dot(sp.Matrix(ball.spin)),
    }


SYSTEM = System(
    name="gyroscopic-rubber-ball-on-plane",
    title="Gyroscopic rubber ball on a plane",
    description="A balanced, dynamically non-symmetric ball with a gyroscope rolls on a "
    "plane without slipping and without turning about the vertical.",
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
        *(
            Parameter(k, sp.Rational(tenths, 10), meaning="momentum of the gyroscope")
            for k, tenths in zip(kappa, (3, -2, 5), strict=True)
        ),
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum": Equation(tuple(G), tuple(torque + multiplier * gamma)),
        "normal": Equation(tuple(gamma), tuple(gamma.cross(omega))),
    },
    integrals={
        "energy": G.dot(omega) / 2,
        "momentum across the normal": whole.dot(whole) - whole.dot(gamma) ** 2,
    },
    # In omega1, omega2: the plane (omega, gamma) = 0 has the area domega1 domega2 / gamma3.
    measure=Measure(sp.sqrt(Q) / gamma[2], (*gamma, w1, w2)),
    poisson=Poisson(
        variables={M1: across[0], M2: across[1], **{g: g for g in gamma}},
        bracket={
            (M1, M2): field * gamma[2] - M3,
            (M1, gamma[1]): -gamma[2],
            (M1, gamma[2]): gamma[1],
            (M2, gamma[0]): gamma[2],
            (M2, gamma[2]): -gamma[0],
        },
        hamiltonian=G.dot(omega) / 2,
        clock=N,
    ),
    essential=(u, v, w1, w2),
    integrable="Euler-Jacobi",
    cases={
        "symmetric": Case(
            parameters={inertia[1]: inertia[0], kappa[0]: 0, kappa[1]: 0},
            integrals={"axial": ((inertia[0] - inertia[2]) * omega[2] - kappa[2]) * sp.sqrt(Q)},
            note="the gyroscope lies along the axis of symmetry",
        ),
    },
    scenes={
        "default": Scene(
            initial={u: sp.Rational(1, 5), v: 1, w1: sp.Rational(1, 10), w2: sp.Rational(1, 20)},
            times=(0.0, 40.0),
            outputs=(*ball.fibre, u, v),
            caption="The gyroscope bends the path of the contact.",
        ),
    },
    references=("Markeev1985", "EhlersKoillerMontgomeryRios2005"),
)

RELATIONS = (
    Relation(
        "gyroscopic-rubber-ball-on-plane",
        "rubber-ball-on-plane",
        parameters={str(p): p for p in (m, R, *inertia)},
        limit=Limit(h, {k: h * k for k in kappa}),
        note="the gyroscope is taken away",
    ),
)

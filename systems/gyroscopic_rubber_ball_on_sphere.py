"""The rubber ball with a gyroscope on a sphere: it neither slips nor twists.

kappa is the gyroscope's momentum, constant in the ball; omega1 and omega2 are the velocities, and
omega3 follows from (omega, gamma) = 0.  With J = I + D, D = m R2^2, G = J omega and
epsilon = R1/(R1 + R2),

    dG/dt = (G + kappa) x omega + lambda gamma,    dgamma/dt = epsilon gamma x omega,
    lambda = -(gamma, J^-1 ((G + kappa) x omega)) / Q,    Q = (gamma, J^-1 gamma).

The measure is that of the ball without a gyroscope.  With dtau = N dt, N = Q^(1/(2 epsilon) - 1),
the motion is Hamilton's on the cotangent bundle of the sphere, in a magnetic field.  R1 is signed,
as for the other balls on a sphere.

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
    Square,
    System,
)
from voronec.kinematics import RollingBall

R1, R2, m, h = sp.symbols("R1 R2 m h")
inertia, kappa = sp.symbols("I1:4"), sp.Matrix(sp.symbols("kappa1:4"))
ball = RollingBall.on_sphere(R1, R2, m, inertia)
u, v, theta = ball.base

gamma = sp.Matrix(sp.symbols("gamma1:4"))
w1, w2 = sp.symbols("omega1 omega2")
omega = sp.Matrix([w1, w2, -(w1 * gamma[0] + w2 * gamma[1]) / gamma[2]])  # no twist
epsilon = R1 / (R1 + R2)
J = sp.diag(*(moment + m * R2**2 for moment in inertia))
G = J * omega
Q = gamma.dot(J.inv() * gamma)
torque = (G + kappa).cross(omega)
multiplier = -gamma.dot(J.inv() * torque) / Q
N = Q ** (1 / (2 * epsilon) - 1)

# The momentum of the motion of gamma, M = N/epsilon (G - (G, gamma) gamma), with (M, gamma) = 0.
M1, M2 = sp.symbols("M1 M2")
M3 = -(M1 * gamma[0] + M2 * gamma[1]) / gamma[2]
across = (N / epsilon) * (G - G.dot(gamma) * gamma)
field = -N * kappa.dot(gamma) / epsilon**2


def declared(ball: RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi({w1: ball.spin[0], w2: ball.spin[1]}),
        "lagrangian": ball.energy + kappa.dot(sp.Matrix(ball.spin)),
    }


SYSTEM = System(
    name="gyroscopic-rubber-ball-on-sphere",
    title="Gyroscopic rubber ball on a sphere",
    description="A balanced, dynamically non-symmetric ball with a gyroscope rolls over a fixed "
    "sphere without slipping and without turning about the common normal.",
    fibration=Fibration(base=(u, v), fibre=(*ball.fibre, theta)),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=(*ball.no_slip, ball.no_twist),
    parameters=(
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        Parameter(R2, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass"),
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
        "normal": Equation(tuple(gamma), tuple(epsilon * gamma.cross(omega))),
    },
    integrals={"energy": G.dot(omega) / 2},
    # In omega1, omega2: the plane (omega, gamma) = 0 has the area domega1 domega2 / gamma3.
    measure=Measure(Q ** (1 / (2 * epsilon)) / gamma[2], (*gamma, w1, w2)),
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
    cases={
        "symmetric": Case(
            parameters={inertia[1]: inertia[0], kappa[0]: 0, kappa[1]: 0},
            integrals={
                "axial": ((inertia[0] - inertia[2]) * omega[2] - kappa[2])
                * Q ** (1 / (2 * epsilon))
            },
            integrable="Euler-Jacobi",
            note="the gyroscope lies along the axis of symmetry",
        ),
    },
    scenes={
        "default": Scene(
            initial={
                u: sp.Rational(6, 5),
                sp.Symbol("u1"): 1,
                w1: sp.Rational(1, 20),
                w2: sp.Rational(1, 5),
            },
            times=(0.0, 40.0),
            outputs=(u, v, *ball.fibre),
            caption="Outer rolling.",
        ),
    },
    references=("Markeev1985", "EhlersKoiller2007"),
)

RELATIONS = (
    Relation(
        "gyroscopic-rubber-ball-on-sphere",
        "rubber-ball-on-sphere",
        parameters={str(p): p for p in (R1, R2, m, *inertia)},
        limit=Limit(h, {k: h * k for k in kappa}),
        note="the gyroscope is taken away",
    ),
    Relation(
        "gyroscopic-rubber-ball-on-sphere",
        "gyroscopic-rubber-ball-on-plane",
        parameters={"R": R2, **{str(p): p for p in (m, *inertia, *kappa)}},
        limit=Limit(h, {R1: 1 / h}),
        note="the sphere becomes a plane",
    ),
)

SQUARES = (
    Square(
        first=(
            "gyroscopic-rubber-ball-on-sphere -> rubber-ball-on-sphere",
            "rubber-ball-on-sphere -> rubber-ball-on-plane",
        ),
        second=(
            "gyroscopic-rubber-ball-on-sphere -> gyroscopic-rubber-ball-on-plane",
            "gyroscopic-rubber-ball-on-plane -> rubber-ball-on-plane",
        ),
        name="rubber balls: gyroscope and plane",
    ),
)

"""The rubber ball on a sphere: balanced, not symmetric; it neither slips nor twists.

Derived in Neumann's coordinates, brought down to omega and gamma, the normal of the sphere, both
along the ball's axes.  omega1 and omega2 are the velocities; omega3 follows from
(omega, gamma) = 0.  With J = I + D, D = m R2^2, G = J omega and epsilon = R1/(R1 + R2),

    dG/dt = G x omega + lambda gamma,    dgamma/dt = epsilon gamma x omega,
    lambda = -(gamma, J^-1 (G x omega)) / Q,    Q = (gamma, J^-1 gamma),

and Q^(1/(2 epsilon)) is the density of a measure [EhlersKoiller2007].  R1 is signed: R1 < 0 inside
the sphere (|R1| > R2) and for a shell around it (|R1| < R2).
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from voronec import (
    Case,
    Corrected,
    Equation,
    Fibration,
    Frame,
    Limit,
    Measure,
    Parameter,
    Relation,
    Scene,
    System,
)
from voronec.kinematics import RollingBall

R1, R2, m, h = sp.symbols("R1 R2 m h")
inertia = sp.symbols("I1:4")
ball = RollingBall.on_sphere(R1, R2, m, inertia)
u, v, theta = ball.base

gamma = sp.Matrix(sp.symbols("gamma1:4"))
w1, w2 = sp.symbols("omega1 omega2")
omega = sp.Matrix([w1, w2, -(w1 * gamma[0] + w2 * gamma[1]) / gamma[2]])  # no twist
epsilon = R1 / (R1 + R2)
J = sp.diag(*(moment + m * R2**2 for moment in inertia))
G = J * omega
Q = gamma.dot(J.inv() * gamma)
torque = G.cross(omega)
multiplier = -gamma.dot(J.inv() * torque) / Q
printed = -G.dot(J.inv() * torque) / Q
start = {u: sp.Rational(6, 5), sp.Symbol("u1"): 1, w1: sp.Rational(1, 20), w2: sp.Rational(1, 5)}


def declared(ball: RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi({w1: ball.spin[0], w2: ball.spin[1]}),
        "lagrangian": ball.energy,
    }


SYSTEM = System(
    name="rubber-ball-on-sphere",
    title="Rubber ball on a sphere",
    description="A balanced, dynamically non-symmetric ball rolls over a fixed sphere without "
    "slipping and without turning about the common normal.",
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
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum": Corrected(
            Equation(tuple(G), tuple(torque + multiplier * gamma)),
            Equation(tuple(G), tuple(torque + printed * gamma)),
            "DragovicGajicJovanovic2020",
        ),
        "normal": Equation(tuple(gamma), tuple(epsilon * gamma.cross(omega))),
    },
    integrals={"energy": G.dot(omega) / 2},
    # In omega1, omega2: the plane (omega, gamma) = 0 has the area domega1 domega2 / gamma3.
    measure=Measure(Q ** (1 / (2 * epsilon)) / gamma[2], (*gamma, w1, w2)),
    multiplier=Q ** (1 / (2 * epsilon) - 1),
    essential=(u, v, w1, w2),
    cases={
        "symmetric": Case(
            parameters={inertia[1]: inertia[0]},
            integrals={"axial": omega[2] * Q ** (1 / (2 * epsilon))},
            integrable="Euler-Jacobi",
            note="the third axis is one of symmetry",
        ),
        "homogeneous": Case(
            parameters={inertia[1]: inertia[0], inertia[2]: inertia[0]},
            integrals={f"omega{i + 1}": x for i, x in enumerate(omega)},
            integrable="Euler-Jacobi",
            note="the contact describes circles",
        ),
    },
    scenes={
        "default": Scene(
            initial=start,
            times=(0.0, 15.0),
            outputs=(u, v, *ball.fibre),
            caption="Outer rolling.",
        ),
        "inner": Scene(
            initial=start,
            times=(0.0, 7.0),
            parameters={R1: -3},
            outputs=(u, v, *ball.fibre),
            caption="Inside a sphere three times as large.",
        ),
        "shell": Scene(
            initial={**start, w1: -sp.Rational(1, 20), w2: -sp.Rational(1, 5)},
            times=(0.0, 10.0),
            parameters={R1: -sp.Rational(1, 3)},
            outputs=(u, v, *ball.fibre),
            caption="A shell around a sphere of a third of its radius.",
        ),
    },
    drawing={"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("EhlersKoiller2007", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation(
        "rubber-ball-on-sphere",
        "rubber-ball-on-plane",
        parameters={"R": R2, **{str(p): p for p in (m, *inertia)}},
        limit=Limit(h, {R1: 1 / h}),
        note="the sphere becomes a plane",
    ),
)

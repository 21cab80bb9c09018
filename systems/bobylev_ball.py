"""Bobylev's ball: dynamically symmetric, a gyroscope along its axis of symmetry, on a plane.

The moments A, A, C are those of ball and rotor about the centre, less the rotor's axial part; k is
the rotor's axial momentum [Bobylev1892].  With D = m R^2, along the ball's principal axes,

    Gdot = (G + k e_3) x omega,   gammadot = gamma x omega,
    G = I omega + D (omega - (omega, gamma) gamma).

Symmetry gives one more integral, linear in the velocities,

    sqrt(A + b gamma_3^2) ((C - A) omega_3 + k),   b = (C - A) D / (C + D).

Where C = A this is the number sqrt(A) k, and says nothing; in its place stand the integrals of
Zhukovsky's ball.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from voronec import (
    Equation,
    Fibration,
    Frame,
    Limit,
    Measure,
    Parameter,
    Relation,
    Scene,
    Square,
    System,
    kinematics,
)

omega = sp.symbols("omega1:4")
gamma = sp.symbols("gamma1:4")
m, R = sp.symbols("m R")
A, C = sp.symbols("A C")
inertia = (A, A, C)
k = sp.Symbol("k")

ball = kinematics.RollingBall.on_plane(R, m, inertia)
u, v, theta = ball.base
x, y = ball.fibre

D = m * R**2
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
whole = momentum + sp.Matrix([0, 0, k])
share = sum(D * g**2 / (i + D) for g, i in zip(gamma, inertia, strict=True))
slope = (C - A) * D / (C + D)
start = dict(zip(omega, (sp.Rational(1, 2), 1, 1), strict=True))


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy + kinematics.axial_rotor(k, (0, 0, 1), ball.spin),
    }


SYSTEM = System(
    name="bobylev-ball",
    title="Bobylev's gyroscopic ball on a plane",
    description="A dynamically symmetric ball with a gyroscope along its axis rolls without "
    "slipping on a plane.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
    parameters=(
        Parameter(R, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass of ball and rotor"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="equatorial moment of inertia"),
        Parameter(C, sp.Rational(3, 5), positive=True, meaning="axial moment of inertia"),
        Parameter(k, sp.Rational(1, 2), meaning="axial momentum of the gyroscope"),
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum": Equation(tuple(momentum), tuple(whole.cross(spin))),
        "normal": Equation(gamma, tuple(normal.cross(spin))),
    },
    integrals={
        "energy": momentum.dot(spin) / 2,
        "momentum squared": whole.dot(whole),
        "vertical momentum": whole.dot(normal),
        "axial": sp.sqrt(A + slope * gamma[2] ** 2) * ((C - A) * omega[2] + k),
    },
    measure=Measure(sp.sqrt(1 - share), (*gamma, *omega)),
    essential=(u, v, *omega),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={u: 2, **start},
            times=(0.0, 40.0),
            outputs=(x, y, *omega),
            caption="The gyroscope bends the path of the ball.",
        ),
    },
    references=("Bobylev1892", "Zhukovsky1893", "Markeev1985", "DragovicGajicJovanovic2020"),
)

h = sp.Symbol("h")
RELATIONS = (
    Relation(
        "bobylev-ball",
        "gyroscopic-ball-on-plane",
        parameters={m: m, R: R, "I1": A, "I2": A, "I3": C, "kappa1": 0, "kappa2": 0, "kappa3": k},
    ),
    Relation(
        "bobylev-ball",
        "chaplygin-ball",
        parameters={m: m, R: R, "I1": A, "I2": A, "I3": C},
        limit=Limit(h, {k: h}),
        note="the gyroscope is taken away",
    ),
)
SQUARES = (
    Square(
        first=(
            "bobylev-ball -> gyroscopic-ball-on-plane",
            "gyroscopic-ball-on-plane -> chaplygin-ball",
        ),
        second=("bobylev-ball -> chaplygin-ball",),
        name="Bobylev's ball without its gyroscope",
    ),
)

"""Chaplygin's ball with a gyroscope on a sphere, dynamically non-symmetric.

The momentum kappa of the gyroscope is constant in the ball.  With G the momentum of the ball about
the contact and gamma the normal of the sphere, both along the ball's principal axes,

    Gdot = (G + kappa) x omega,   gammadot = epsilon gamma x omega,   epsilon = R1 / (R1 + R2),
    G = I omega + D (omega - (omega, gamma) gamma),   D = m R2^2

[DragovicGajicJovanovic2020, eq. (Chap*)].
R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

Energy, the square of G + kappa and the measure are there for every epsilon; no integrable case is
known beyond those of symmetric balls, of the plane, and of kappa = 0, epsilon = -1.
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
    Square,
    System,
    kinematics,
)

omega = sp.symbols("omega1:4")
gamma = sp.symbols("gamma1:4")
R1, R2, m = sp.symbols("R1 R2 m")
inertia = sp.symbols("I1:4")
kappa = sp.symbols("kappa1:4")

ball = kinematics.RollingBall.on_sphere(R1, R2, m, inertia)
u, v, _ = ball.base

D = m * R2**2
epsilon = R1 / (R1 + R2)
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
whole = momentum + sp.Matrix(kappa)
share = sum(D * g**2 / (i + D) for g, i in zip(gamma, inertia, strict=True))


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy + sp.Matrix(kappa).dot(sp.Matrix(ball.spin)),
    }


SYSTEM = System(
    name="gyroscopic-ball-on-sphere",
    title="Gyroscopic Chaplygin ball on a sphere",
    description="A balanced, dynamically non-symmetric ball with a gyroscope rolls without "
    "slipping over a fixed sphere: outside, inside, or around it as a shell.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
    parameters=(
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        Parameter(R2, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass of ball and rotor"),
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
        "momentum": Equation(tuple(momentum), tuple(whole.cross(spin))),
        "normal": Equation(gamma, tuple((epsilon * normal).cross(spin))),
    },
    integrals={
        "energy": momentum.dot(spin) / 2,
        "momentum squared": whole.dot(whole),
    },
    measure=Measure(sp.sqrt(1 - share), (*gamma, *omega)),
    essential=(u, v, *omega),
    scenes=ball.scenes_on_sphere(R1, omega),
    drawing={"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("Yaroshchuk1992", "Markeev1985", "DragovicGajicJovanovic2020"),
)

h = sp.Symbol("h")
RELATIONS = (
    Relation(
        "gyroscopic-ball-on-sphere",
        "ball-on-sphere",
        parameters={p: p for p in (R1, R2, m, *inertia)},
        limit=Limit(h, {k: h * k for k in kappa}),
        note="the gyroscope is taken away",
    ),
    Relation(
        "gyroscopic-ball-on-sphere",
        "gyroscopic-ball-on-plane",
        parameters={"R": R2, m: m, **{i: i for i in inertia}, **{k: k for k in kappa}},
        limit=Limit(h, {R1: 1 / h}),
        note="the sphere becomes a plane",
    ),
)
SQUARES = (
    Square(
        first=(
            "gyroscopic-ball-on-sphere -> ball-on-sphere",
            "ball-on-sphere -> chaplygin-ball",
        ),
        second=(
            "gyroscopic-ball-on-sphere -> gyroscopic-ball-on-plane",
            "gyroscopic-ball-on-plane -> chaplygin-ball",
        ),
        name="gyroscope and curvature of the sphere vanish in either order",
    ),
)

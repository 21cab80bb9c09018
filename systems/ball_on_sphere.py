"""Chaplygin's ball on a sphere: balanced and dynamically non-symmetric, for every ratio of radii.

With G the momentum about the contact and gamma the normal of the sphere towards the ball's centre,
both along the ball's principal axes,

    Gdot = G x omega,   gammadot = epsilon gamma x omega,   epsilon = R1 / (R1 + R2),
    G = I omega + D (omega - (omega, gamma) gamma),   D = m R2^2

[DragovicGajicJovanovic2020, eq. (Chap)].
R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

Integrals are the energy and the square of G.  The measure sqrt(1 - D ((I + D)^-1 gamma, gamma)) is
invariant [Yaroshchuk1992].  In general the ball is not integrable; it is for epsilon = -1, a shell
around a sphere of half its radius, with an integral linear in G [BorisovFedorov1995].
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
    Relation,
    System,
    kinematics,
)

omega = sp.symbols("omega1:4")
gamma = sp.symbols("gamma1:4")
R1, R2, m = sp.symbols("R1 R2 m")
inertia = sp.symbols("I1:4")

ball = kinematics.RollingBall.on_sphere(R1, R2, m, inertia)
u, v, _ = ball.base


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy,
    }


D = m * R2**2
epsilon = R1 / (R1 + R2)
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
share = sum(D * g**2 / (i + D) for g, i in zip(gamma, inertia, strict=True))
moments = sp.Matrix(inertia)
weights = [sum(moments) - 2 * i + D for i in inertia]
fourth = sum(b * p * g for b, p, g in zip(weights, momentum, gamma, strict=True))

SYSTEM = System(
    name="ball-on-sphere",
    title="Chaplygin ball on a sphere",
    description="A balanced, dynamically non-symmetric ball rolls without slipping over a fixed "
    "sphere: outside, inside, or around it as a shell.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
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
        "momentum": Equation(tuple(momentum), tuple(momentum.cross(spin))),
        "normal": Equation(gamma, tuple((epsilon * normal).cross(spin))),
    },
    integrals={
        "energy": momentum.dot(spin) / 2,
        "momentum squared": momentum.dot(momentum),
    },
    measure=Measure(sp.sqrt(1 - share), (*gamma, *omega)),
    essential=(u, v, *omega),
    cases={
        "epsilon = -1": Case(
            parameters={R1: -R2 / 2},
            integrals={"Borisov-Fedorov": fourth},
            integrable="Euler-Jacobi",
        ),
    },
    scenes=ball.scenes_on_sphere(R1, omega),
    drawing={"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=(
        "Chaplygin1903",
        "Yaroshchuk1992",
        "BorisovFedorov1995",
        "DragovicGajicJovanovic2020",
    ),
)

h = sp.Symbol("h")
RELATIONS = (
    Relation(
        "ball-on-sphere",
        "chaplygin-ball",
        parameters={"R": R2, m: m, **{i: i for i in inertia}},
        limit=Limit(h, {R1: 1 / h}),
        note="the sphere becomes a plane",
    ),
)

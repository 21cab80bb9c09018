"""The ball of Borisov and Fedorov: a non-symmetric shell around a sphere of half its radius.

It is Chaplygin's ball on a sphere with epsilon = R1 / (R1 + R2) = -1,

    Gdot = G x omega,   gammadot = -gamma x omega,   G = I omega + D (omega - (omega, gamma) gamma),

and has the integral sum of (I_1 + I_2 + I_3 - 2 I_i + D) G_i gamma_i [BorisovFedorov1995].
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from voronec import (
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Relation,
    Scene,
    System,
    kinematics,
)

omega = sp.symbols("omega1:4")
gamma = sp.symbols("gamma1:4")
m, R2 = sp.symbols("m R2")
inertia = sp.symbols("I1:4")

ball = kinematics.RollingBall.on_sphere(-R2 / 2, R2, m, inertia)
u, v, theta = ball.base
u1, v1 = ball.fibre

D = m * R2**2
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
share = sum(D * g**2 / (i + D) for g, i in zip(gamma, inertia, strict=True))
weights = [sum(inertia) - 2 * i + D for i in inertia]
fourth = sum(b * p * g for b, p, g in zip(weights, momentum, gamma, strict=True))
start = dict(zip(omega, (sp.Rational(1, 2), 1, 1), strict=True))


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy,
    }


SYSTEM = System(
    name="borisov-fedorov-ball",
    title="Ball of Borisov and Fedorov",
    description="A balanced, dynamically non-symmetric shell rolls without slipping around a fixed "
    "sphere of half its radius.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
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
        "momentum": Equation(tuple(momentum), tuple(momentum.cross(spin))),
        "normal": Equation(gamma, tuple((-normal).cross(spin))),
    },
    integrals={
        "energy": momentum.dot(spin) / 2,
        "momentum squared": momentum.dot(momentum),
        "Borisov-Fedorov": fourth,
    },
    measure=Measure(sp.sqrt(1 - share), (*gamma, *omega)),
    essential=(u, v, *omega),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={u: 2, theta: 1, u1: 1, **start},
            times=(0.0, 60.0),
            outputs=(u, v, u1, v1, *omega),
            caption="A shell around a sphere of half its radius.",
        ),
    },
    drawing={"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("BorisovFedorov1995", "Yaroshchuk1992", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation(
        "borisov-fedorov-ball",
        "ball-on-sphere",
        parameters={"R1": -R2 / 2, R2: R2, m: m, **{i: i for i in inertia}},
    ),
)

"""The ordinary ball on a plane: its moment of inertia, A, is the same about all axes.

It rolls along a straight line and keeps its angular velocity, both in space and in the ball.
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
m, R = sp.symbols("m R")
A = sp.Symbol("A")
inertia = (A, A, A)

ball = kinematics.RollingBall.on_plane(R, m, inertia)
u, v, theta = ball.base
x, y = ball.fibre

D = m * R**2
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
start = dict(zip(omega, (sp.Rational(1, 2), 1, 1), strict=True))


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy,
    }


SYSTEM = System(
    name="homogeneous-ball",
    title="Ordinary ball on a plane",
    description="A ball whose inertia is the same about all axes rolls without slipping on a "
    "plane.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
    parameters=(
        Parameter(R, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="moment of inertia"),
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum": Equation(tuple(momentum), tuple(momentum.cross(spin))),
        "normal": Equation(gamma, tuple(normal.cross(spin))),
    },
    integrals={
        "energy": momentum.dot(spin) / 2,
        "momentum squared": momentum.dot(momentum),
        "vertical momentum": momentum.dot(normal),
        **{f"spin {i + 1}": w for i, w in enumerate(omega)},
    },
    measure=Measure(1, (*gamma, *omega)),
    essential=omega,
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={u: 2, **start},
            times=(0.0, 40.0),
            outputs=(x, y, *omega),
            caption="A straight line.",
        ),
    },
    references=("Chaplygin1903", "BorisovMamaev2002"),
)

RELATIONS = (
    Relation(
        "homogeneous-ball",
        "chaplygin-ball",
        parameters={m: m, R: R, "I1": A, "I2": A, "I3": A},
    ),
)

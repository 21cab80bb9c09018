"""The ordinary ball on a sphere: its moment of inertia, A, is the same about all axes.

Along axes fixed in the ball, with D = m R2^2 and epsilon = R1 / (R1 + R2),

    Gdot = G x omega,   gammadot = epsilon gamma x omega,
    G = (A + D) omega - D (omega, gamma) gamma.

R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

The spin (omega, gamma) about the normal is constant, and so are, in the ball, the three components
of (A + D) omega + D (R2/R1) (omega, gamma) gamma.
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
A = sp.Symbol("A")
inertia = (A, A, A)

ball = kinematics.RollingBall.on_sphere(R1, R2, m, inertia)
u, v, _ = ball.base

D = m * R2**2
epsilon = R1 / (R1 + R2)
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
along = spin.dot(normal)
kept = (A + D) * spin + D * R2 / R1 * along * normal


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy,
    }


SYSTEM = System(
    name="homogeneous-ball-on-sphere",
    title="Ordinary ball on a sphere",
    description="A ball whose inertia is the same about all axes rolls without slipping over a "
    "fixed sphere: outside, inside, or around it as a shell.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
    parameters=(
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        Parameter(R2, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="moment of inertia"),
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum": Equation(tuple(momentum), tuple(momentum.cross(spin))),
        "normal": Equation(gamma, tuple((epsilon * normal).cross(spin))),
    },
    integrals={
        "energy": momentum.dot(spin) / 2,
        "momentum squared": momentum.dot(momentum),
        "normal spin": along,
        **{f"in the ball {i + 1}": e for i, e in enumerate(kept)},
    },
    measure=Measure(1, (*gamma, *omega)),
    essential=(u, v, *omega),
    integrable="Euler-Jacobi",
    scenes=ball.scenes_on_sphere(R1, omega),
    drawing={"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

h = sp.Symbol("h")
RELATIONS = (
    Relation(
        "homogeneous-ball-on-sphere",
        "symmetric-ball-on-sphere",
        parameters={**{p: p for p in (R1, R2, m, A)}, "C": A},
    ),
    Relation(
        "homogeneous-ball-on-sphere",
        "homogeneous-ball",
        parameters={"R": R2, m: m, A: A},
        limit=Limit(h, {R1: 1 / h}),
        note="the sphere becomes a plane",
    ),
)
SQUARES = (
    Square(
        first=(
            "homogeneous-ball-on-sphere -> symmetric-ball-on-sphere",
            "symmetric-ball-on-sphere -> chaplygin-ball",
        ),
        second=(
            "homogeneous-ball-on-sphere -> homogeneous-ball",
            "homogeneous-ball -> chaplygin-ball",
        ),
        name="an ordinary ball on a sphere that becomes a plane",
    ),
)

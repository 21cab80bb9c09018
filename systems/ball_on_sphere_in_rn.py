"""Chaplygin's ball on a sphere in R^n: a balanced ball rolls without slipping over S^(n-1).

The configuration space is that of a free body, SE(n), given by its frame: Omega = g^T dg/dt and
W = g^T dx/dt.  gamma is the unit vector from the sphere's centre to the ball's, seen from the ball,
(R1 + R2) gamma = g^T x; the ball rolls, W = R2 Omega gamma, which keeps |gamma| = 1.  So

    dgamma/dt = -Omega gamma + W/(R1 + R2) = -epsilon Omega gamma,   epsilon = R1/(R1 + R2),

and with D = m R2^2 the momentum about the contact

    G_ij = I_ij Omega_ij + D (gamma gamma^T Omega + Omega gamma gamma^T)_ij

obeys dG/dt = [G, Omega] [Jovanovic2018].  R1 is signed: R1 < 0 inside the sphere (|R1| > R2) and
for a shell around it (|R1| < R2).
"""

from __future__ import annotations

from functools import partial

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
)
from voronec.kinematics import BodyVelocity, skew, skew_entries, wedge_square

m, R1, R2, h = sp.symbols("m R1 R2 h")
SECOND_MOMENTS = tuple(sp.Rational(a, 10) for a in (4, 3, 1, 2, 5))  # of the mass, by axis
delta = sp.Symbol("Delta")


def member(n: int, name: str) -> System:
    """The ball in R^n."""
    body = BodyVelocity(n)
    gamma, moments = sp.Matrix(body.normal), body.named("I")
    momenta = body.named("G")
    G = skew(momenta, n)
    square = wedge_square(G)
    energy = body.energy(moments, m)
    integrals = {
        "energy": sp.Matrix(momenta).dot(body.angular) - energy,
        "momentum squared": sum(p**2 for p in momenta),
    }
    if n == 4:
        integrals["momentum wedge momentum"] = square[0]
    if n == 5:
        integrals["momentum wedge momentum squared"] = square.dot(square)
    moving = sp.Matrix(body.linear) / (R1 + R2)
    start = dict(zip(gamma, [sp.Rational(k, 5) for k in (-3, *[0] * (n - 2), 4)], strict=True))
    turning = [sp.Rational(5 - 3 * (i % 3), 4 + i) for i in range(len(momenta))]
    return System(
        name=name,
        title=f"Chaplygin ball on a sphere in R^{n}",
        description=f"A balanced, dynamically non-symmetric ball of R^{n} rolls without slipping "
        "over a fixed sphere: outside, inside, or around it as a shell.",
        fibration=Fibration(base=body.normal, relations=(gamma.dot(gamma) - 1,)),
        frame=Frame.group(
            body.angular,
            body.motions,
            dict(zip(gamma, body.seen(gamma, moving), strict=True)),
            fibre=body.linear,
            momenta=momenta,
            determinant=delta,
        ),
        lagrangian=energy,
        constraints=tuple(sp.Matrix(body.linear) - R2 * body.matrix * gamma),
        parameters=(
            Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
            Parameter(R2, 1, positive=True, meaning="radius of the ball"),
            Parameter(m, 1, positive=True, meaning="mass"),
            *(
                Parameter(
                    moment,
                    SECOND_MOMENTS[i - 1] + SECOND_MOMENTS[j - 1],
                    positive=True,
                    meaning=f"moment in the plane of the axes {i} and {j}",
                )
                for (i, j), moment in zip(body.pairs, moments, strict=True)
            ),
        ),
        integrals=integrals,
        equations={
            "momentum": Equation(momenta, skew_entries(G * body.matrix - body.matrix * G)),
            "normal": Equation(tuple(gamma), tuple(R1 / (R1 + R2) * body.seen(gamma))),
        },
        measure=Measure(sp.sqrt(delta)),
        scenes={
            "default": Scene(
                initial={**start, **dict(zip(body.angular, turning, strict=True))},
                times=(0.0, 20.0),
                outputs=(*body.normal, *body.angular),
                caption="Outside a sphere twice as large.",
            ),
        },
        references=("Jovanovic2018", "Yaroshchuk1992"),
    )


MEMBERS = {str(n): partial(member, n, f"ball-on-sphere-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "ball-on-sphere-in-rn")

RELATIONS = (
    Relation(
        "ball-on-sphere-in-rn@3",
        "ball-on-sphere",
        state={
            **{f"gamma{i}": sp.Symbol(f"gamma{i}") for i in (1, 2, 3)},
            "omega1": -sp.Symbol("Omega23"),
            "omega2": sp.Symbol("Omega13"),
            "omega3": -sp.Symbol("Omega12"),
        },
        parameters={
            **{x: x for x in (R1, R2, m)},
            "I1": sp.Symbol("I23"),
            "I2": sp.Symbol("I13"),
            "I3": sp.Symbol("I12"),
        },
        note="three dimensions",
    ),
    # For n = 5 it holds too; the claims that it carries are too large to be decided.
    *(
        Relation(
            f"ball-on-sphere-in-rn{at}",
            f"chaplygin-ball-in-rn{at}",
            parameters={m: m, "R": R2, **{i: i for i in BodyVelocity(n).named("I")}},
            limit=Limit(h, {R1: 1 / h}),
            note="the sphere becomes a hyperplane",
        )
        for n, at in ((3, "@3"), (4, ""))
    ),
)

SQUARES = (
    Square(
        ("ball-on-sphere-in-rn@3 -> ball-on-sphere", "ball-on-sphere -> chaplygin-ball"),
        (
            "ball-on-sphere-in-rn@3 -> chaplygin-ball-in-rn@3",
            "chaplygin-ball-in-rn@3 -> chaplygin-ball",
        ),
    ),
)

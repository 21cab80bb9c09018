"""The rubber ball on a sphere in R^n: balanced, it rolls over S^(n-1) without slip and twist.

The configuration space is that of a free body, SE(n), given by its frame: Omega = g^T dg/dt and
W = g^T dx/dt.  gamma is the unit vector from the sphere's centre to the ball's, seen from the ball,
(R1 + R2) gamma = g^T x.  The ball rolls, W = R2 Omega gamma, and does not turn in planes at right
angles to gamma, so Omega = gamma u^T - u gamma^T, or

    gamma_n Omega_ij = gamma_j Omega_in - gamma_i Omega_jn     (i < j < n);

Omega_in are the velocities, good where gamma_n is not 0.  With epsilon = R1/(R1 + R2), the moments
I_ij in the planes of two axes and G_ij = (I_ij + m R2^2) Omega_ij the equations are

    d(G gamma)/dt = -Omega G gamma + (1 - epsilon) G Omega gamma,   dgamma/dt = -epsilon Omega gamma

[Jovanovic2018].  The entries of G gamma are gamma_n P_i and -(P, gamma), where P_i are the momenta
of the velocities.  R1 is signed: R1 < 0 inside the sphere (|R1| > R2) and for a shell around it.
"""

from __future__ import annotations

from functools import partial

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
    Scene,
    Square,
    System,
)
from voronec.kinematics import BodyVelocity, product_form, product_moments, skew

m, R1, R2, h = sp.symbols("m R1 R2 h")
SECOND_MOMENTS = tuple(sp.Rational(a, 10) for a in (4, 3, 1, 2, 5))  # of the mass, by axis
delta = sp.Symbol("Delta")
epsilon = R1 / (R1 + R2)


def member(n: int, name: str) -> System:
    """The ball in R^n."""
    body = BodyVelocity(n)
    gamma, moments = sp.Matrix(body.normal), body.named("I")
    momenta = sp.symbols(f"P1:{n}")
    energy = body.energy(moments, m)
    G = skew([(i + m * R2**2) * w for i, w in zip(moments, body.angular, strict=True)], n)
    mixed = body.normal_momentum(momenta)
    moving = sp.Matrix(body.linear) / (R1 + R2)
    whole = [i + m * R2**2 for i in moments]  # about the contact
    form = product_form(whole, gamma)
    start = dict(zip(gamma, [sp.Rational(k, 5) for k in (-3, *[0] * (n - 2), 4)], strict=True))
    turning = [sp.Rational(4 * (i % 2) - 3, 10 + i) for i in range(n - 1)]
    return System(
        name=name,
        title=f"Rubber ball on a sphere in R^{n}",
        description=f"A balanced, dynamically non-symmetric ball of R^{n} rolls over a fixed "
        "sphere without slipping and without twisting.",
        fibration=Fibration(base=body.normal, relations=(gamma.dot(gamma) - 1,)),
        frame=Frame.group(
            body.last,
            body.motions,
            dict(zip(gamma, body.seen(gamma, moving), strict=True)),
            fibre=(*body.others, *body.linear),
            momenta=momenta,
            determinant=delta,
        ),
        lagrangian=energy,
        constraints=(
            *(sp.Matrix(body.linear) - R2 * body.matrix * gamma),
            *body.twist(gamma),
        ),
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
        integrals={"energy": sp.Matrix(momenta).dot(body.last) - energy},
        equations={
            "momentum": Equation(
                tuple(mixed),
                tuple(body.seen(mixed) + (1 - epsilon) * G * body.matrix * gamma),
            ),
            "normal": Equation(tuple(gamma), tuple(epsilon * body.seen(gamma))),
        },
        measure=Measure(
            delta ** (1 / (2 * epsilon)) * gamma[n - 1] ** ((n - 2) * (1 / epsilon - 1))
        ),
        multiplier=form ** (1 / (2 * epsilon) - 1) if n == 3 else None,
        cases={
            "I + D = a a": Case(
                parameters={
                    f"I{i}{j}": value - m * R2**2
                    for (i, j), value in product_moments(whole, n).items()
                },
                multiplier=form ** (1 / (2 * epsilon) - 1),
                note="moments about the contact that are products, I_ij + m R2^2 = a_i a_j",
            )
        }
        if n > 3
        else {},
        scenes={
            "default": Scene(
                initial={**start, **dict(zip(body.last, turning, strict=True))},
                times=(0.0, 6.0),
                outputs=body.normal,
                caption="Outside a sphere twice as large, while gamma_n is positive.",
            ),
        },
        references=("Jovanovic2018", "EhlersKoiller2007"),
    )


MEMBERS = {str(n): partial(member, n, f"rubber-ball-on-sphere-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "rubber-ball-on-sphere-in-rn")

RELATIONS = (
    Relation(
        "rubber-ball-on-sphere-in-rn@3",
        "rubber-ball-on-sphere",
        state={
            **{f"gamma{i}": sp.Symbol(f"gamma{i}") for i in (1, 2, 3)},
            "omega1": -sp.Symbol("Omega23"),
            "omega2": sp.Symbol("Omega13"),
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
            f"rubber-ball-on-sphere-in-rn{at}",
            f"rubber-ball-in-rn{at}",
            parameters={m: m, "R": R2, **{i: i for i in BodyVelocity(n).named("I")}},
            limit=Limit(h, {R1: 1 / h}),
            note="the sphere becomes a hyperplane",
        )
        for n, at in ((3, "@3"), (4, ""))
    ),
)

SQUARES = (
    Square(
        (
            "rubber-ball-on-sphere-in-rn@3 -> rubber-ball-on-sphere",
            "rubber-ball-on-sphere -> rubber-ball-on-plane",
        ),
        (
            "rubber-ball-on-sphere-in-rn@3 -> rubber-ball-in-rn@3",
            "rubber-ball-in-rn@3 -> rubber-ball-on-plane",
        ),
    ),
)

"""The rubber ball in R^n: a balanced ball rolls on a hyperplane; it neither slips nor twists.

The configuration space is SE(n), given by its frame: Omega = g^T dg/dt and W = g^T dx/dt are the
angular velocity and the velocity of the centre along the ball's axes, gamma = g^T e_n is the
normal of the hyperplane seen from the ball.  The ball rolls, W = R Omega gamma, and does not turn
in planes at right angles to gamma, so Omega = gamma u^T - u gamma^T, or

    gamma_n Omega_ij = gamma_j Omega_in - gamma_i Omega_jn     (i < j < n);

Omega_in are the velocities, good where gamma_n is not 0.  With the moments I_ij in the planes of
two axes and G_ij = (I_ij + m R^2) Omega_ij the vector G gamma is fixed in space: this is
Veselova's system with the moments I_ij + m R^2 [Jovanovic2018].
"""

from __future__ import annotations

from functools import partial

import sympy as sp

from voronec import (
    Case,
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Relation,
    Scene,
    Square,
    System,
)
from voronec.kinematics import BodyVelocity, product_form, product_moments

m, R = sp.symbols("m R")
SECOND_MOMENTS = tuple(sp.Rational(a, 10) for a in (4, 3, 1, 2, 5))  # of the mass, by axis
delta = sp.Symbol("Delta")


def member(n: int, name: str) -> System:
    """The ball in R^n."""
    body = BodyVelocity(n)
    gamma, moments = sp.Matrix(body.normal), body.named("I")
    momenta = sp.symbols(f"P1:{n}")
    energy = body.energy(moments, m)
    fixed = body.normal_momentum(momenta)
    whole = [i + m * R**2 for i in moments]  # about the contact
    form = product_form(whole, gamma)
    start = dict(zip(gamma, [sp.Rational(k, 5) for k in (-3, *[0] * (n - 2), 4)], strict=True))
    turning = [sp.Rational(4 * (i % 2) - 3, 10 + i) for i in range(n - 1)]
    return System(
        name=name,
        title=f"Rubber ball in R^{n}",
        description=f"A balanced, dynamically non-symmetric ball of R^{n} rolls on a hyperplane "
        "without slipping and without twisting.",
        fibration=Fibration(base=body.normal, relations=(gamma.dot(gamma) - 1,)),
        frame=Frame.group(
            body.last,
            body.motions,
            dict(zip(gamma, body.seen(gamma), strict=True)),
            fibre=(*body.others, *body.linear),
            momenta=momenta,
            determinant=delta,
        ),
        lagrangian=energy,
        constraints=(
            *(sp.Matrix(body.linear) - R * body.matrix * gamma),
            *body.twist(gamma),
        ),
        parameters=(
            Parameter(m, 1, positive=True, meaning="mass"),
            Parameter(R, 1, positive=True, meaning="radius"),
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
        integrals={
            "energy": sp.Matrix(momenta).dot(body.last) - energy,
            "momentum squared": fixed.dot(fixed),
        },
        equations={"momentum": Equation(tuple(fixed), tuple(body.seen(fixed)))},
        measure=Measure(sp.sqrt(delta)),
        multiplier=form ** sp.Rational(-1, 2) if n == 3 else None,
        cases={
            "I + D = a a": Case(
                parameters={
                    f"I{i}{j}": value - m * R**2
                    for (i, j), value in product_moments(whole, n).items()
                },
                multiplier=form ** sp.Rational(-1, 2),
                note="moments about the contact that are products, I_ij + m R^2 = a_i a_j",
            )
        }
        if n > 3
        else {},
        scenes={
            "default": Scene(
                initial={**start, **dict(zip(body.last, turning, strict=True))},
                times=(0.0, 4.0),
                outputs=body.normal,
                caption="The normal of the hyperplane seen from the ball, while gamma_n is "
                "positive.",
            ),
        },
        references=("Jovanovic2018", "FedorovJovanovic2004", "EhlersKoillerMontgomeryRios2005"),
    )


MEMBERS = {str(n): partial(member, n, f"rubber-ball-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "rubber-ball-in-rn")

RELATIONS = (
    Relation(
        "rubber-ball-in-rn@3",
        "rubber-ball-on-plane",
        state={
            **{f"gamma{i}": sp.Symbol(f"gamma{i}") for i in (1, 2, 3)},
            "omega1": -sp.Symbol("Omega23"),
            "omega2": sp.Symbol("Omega13"),
        },
        parameters={
            m: m,
            R: R,
            "I1": sp.Symbol("I23"),
            "I2": sp.Symbol("I13"),
            "I3": sp.Symbol("I12"),
        },
        note="three dimensions",
    ),
    # For n = 5 it holds too; the claims that it carries are too large to be decided.
    *(
        Relation(
            f"rubber-ball-in-rn{at}",
            f"veselova-in-rn{at}",
            parameters={
                f"J{i}{j}": sp.Symbol(f"I{i}{j}") + m * R**2 for i, j in BodyVelocity(n).pairs
            },
            note="the rubber ball on a hyperplane is Veselova's body",
        )
        for n, at in ((3, "@3"), (4, ""))
    ),
)

SQUARES = (
    Square(
        ("rubber-ball-in-rn@3 -> rubber-ball-on-plane", "rubber-ball-on-plane -> veselova"),
        ("rubber-ball-in-rn@3 -> veselova-in-rn@3", "veselova-in-rn@3 -> veselova"),
    ),
)

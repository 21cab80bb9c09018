"""Chaplygin's ball in R^n: a balanced ball rolls without slipping on a hyperplane.

The configuration space is SE(n), given by its frame: Omega = g^T dg/dt and W = g^T dx/dt are the
angular velocity and the velocity of the centre along the ball's axes.  gamma = g^T e_n is the
normal of the hyperplane seen from the ball, dgamma/dt = -Omega gamma, and the ball rolls,
W = R Omega gamma.  With the moments I_ij in the planes of two axes, D = m R^2, and the momentum
about the contact

    G_ij = I_ij Omega_ij + D (gamma gamma^T Omega + Omega gamma gamma^T)_ij

the equations are dG/dt = [G, Omega]: g G g^T is fixed in space, and so is the vector of R^5 into
which n = 5 turns its square [FedorovKozlov1995, Jovanovic2010].
"""

from __future__ import annotations

from functools import partial

import sympy as sp

from voronec import Equation, Fibration, Frame, Measure, Parameter, Relation, Scene, System
from voronec.kinematics import BodyVelocity, skew, skew_entries, wedge_square

m, R = sp.symbols("m R")
SECOND_MOMENTS = tuple(sp.Rational(a, 10) for a in (4, 3, 1, 2, 5))  # of the mass, by axis
delta = sp.Symbol("Delta")


def member(n: int, name: str) -> System:
    """The ball in R^n."""
    body = BodyVelocity(n)
    gamma, moments = sp.Matrix(body.normal), body.named("I")
    momenta = body.named("G")
    G, square = skew(momenta, n), wedge_square(skew(momenta, n))
    energy = body.energy(moments, m)
    integrals = {
        "energy": sp.Matrix(momenta).dot(body.angular) - energy,
        "momentum squared": sum(p**2 for p in momenta),
        "momentum of the normal squared": (G * gamma).dot(G * gamma),
    }
    if n == 3:
        integrals["vertical momentum"] = (
            G[2, 1] * gamma[0] + G[0, 2] * gamma[1] + G[1, 0] * gamma[2]
        )
    if n == 4:
        integrals["momentum wedge momentum"] = square[0]
    if n == 5:
        integrals["momentum wedge momentum squared"] = square.dot(square)
        integrals["momentum wedge momentum along the normal"] = square.dot(gamma)
    start = dict(zip(gamma, [sp.Rational(k, 5) for k in (-3, *[0] * (n - 2), 4)], strict=True))
    turning = [sp.Rational(5 - 3 * (i % 3), 4 + i) for i in range(len(momenta))]
    return System(
        name=name,
        title=f"Chaplygin ball in R^{n}",
        description=f"A balanced, dynamically non-symmetric ball of R^{n} rolls without slipping "
        "on a hyperplane.",
        fibration=Fibration(base=body.normal, relations=(gamma.dot(gamma) - 1,)),
        frame=Frame.group(
            body.angular,
            body.motions,
            dict(zip(gamma, body.seen(gamma), strict=True)),
            fibre=body.linear,
            momenta=momenta,
            determinant=delta,
        ),
        lagrangian=energy,
        constraints=tuple(sp.Matrix(body.linear) - R * body.matrix * gamma),
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
        integrals=integrals,
        equations={
            "momentum": Equation(momenta, skew_entries(G * body.matrix - body.matrix * G)),
            "momentum of the normal": Equation(tuple(G * gamma), tuple(body.seen(G * gamma))),
            **(
                {"momentum wedge momentum": Equation(tuple(square), tuple(body.seen(square)))}
                if n == 5
                else {}
            ),
        },
        measure=Measure(sp.sqrt(delta)),
        scenes={
            "default": Scene(
                initial={**start, **dict(zip(body.angular, turning, strict=True))},
                times=(0.0, 20.0),
                outputs=(*body.normal, *body.angular),
                caption="The normal of the hyperplane seen from the ball.",
            ),
        },
        references=("FedorovKozlov1995", "Jovanovic2010", "Chaplygin1903"),
    )


MEMBERS = {str(n): partial(member, n, f"chaplygin-ball-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "chaplygin-ball-in-rn")

SHARED = ("gamma1", "gamma2", "gamma3", "Omega12", "Omega13", "Omega23")

RELATIONS = (
    Relation(
        "chaplygin-ball-in-rn@3",
        "chaplygin-ball",
        state={
            **{f"gamma{i}": sp.Symbol(f"gamma{i}") for i in (1, 2, 3)},
            "omega1": -sp.Symbol("Omega23"),
            "omega2": sp.Symbol("Omega13"),
            "omega3": -sp.Symbol("Omega12"),
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
    Relation(
        "chaplygin-ball-in-rn@3",
        "chaplygin-ball-in-rn",
        state={
            **{x: sp.Symbol(x) for x in SHARED},
            **dict.fromkeys(("gamma4", "Omega14", "Omega24", "Omega34"), 0),
        },
        parameters={
            m: m,
            R: R,
            **{f"I{i}{j}": sp.Symbol(f"I{i}{j}") for i, j in BodyVelocity(3).pairs},
            **dict.fromkeys(("I14", "I24", "I34"), sp.Symbol("I12")),
        },
        note="a ball of four dimensions that turns in the hyperplane of its first three axes",
    ),
)

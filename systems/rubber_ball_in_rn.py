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

from voronec import Relation, Square, System
from voronec.kinematics import BodyInRn

m, R = sp.symbols("m R")


def member(n: int, name: str) -> System:
    """The ball in R^n."""
    ball = BodyInRn(n, m, R, twists=False)
    caption = "The normal of the hyperplane seen from the ball, while gamma_n is positive."
    return ball.system(
        name=name,
        title=f"Rubber ball in R^{n}",
        description=f"A balanced, dynamically non-symmetric ball of R^{n} rolls on a hyperplane "
        "without slipping and without twisting.",
        values={m: 1, R: 1},
        scenes={"default": ball.scene(caption, 4.0)},
        references=("Jovanovic2018", "FedorovJovanovic2004", "EhlersKoillerMontgomeryRios2005"),
    )


MEMBERS = {str(n): partial(member, n, f"rubber-ball-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "rubber-ball-in-rn")

balls = {at: BodyInRn(n, m, R, twists=False) for n, at in ((3, "@3"), (4, ""))}
RELATIONS = (
    balls["@3"].relation_in_space("rubber-ball-in-rn", "rubber-ball-on-plane"),
    # For n = 5 it holds too; the claims that it carries are too large to be decided.
    *(
        Relation(
            f"rubber-ball-in-rn{at}",
            f"veselova-in-rn{at}",
            parameters=dict(
                zip(
                    ball.body.skew_symbols("J"),
                    (i + ball.contact_inertia for i in ball.moments),
                    strict=True,
                )
            ),
            note="the rubber ball on a hyperplane is Veselova's body",
        )
        for at, ball in balls.items()
    ),
)

SQUARES = (
    Square.through(
        ("rubber-ball-in-rn@3", "rubber-ball-on-plane", "veselova"),
        ("rubber-ball-in-rn@3", "veselova-in-rn@3", "veselova"),
    ),
)

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

from voronec import Relation, System
from voronec.kinematics import BodyInRn

m, R = sp.symbols("m R")


def member(n: int, name: str) -> System:
    """The ball in R^n."""
    ball = BodyInRn(n, m, R)
    return ball.system(
        name=name,
        title=f"Chaplygin ball in R^{n}",
        description=f"A balanced, dynamically non-symmetric ball of R^{n} rolls without slipping "
        "on a hyperplane.",
        values={m: 1, R: 1},
        scenes={"default": ball.scene("The normal of the hyperplane seen from the ball.", 20.0)},
        references=("FedorovKozlov1995", "Jovanovic2010", "Chaplygin1903"),
    )


MEMBERS = {str(n): partial(member, n, f"chaplygin-ball-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "chaplygin-ball-in-rn")

space, larger = BodyInRn(3, m, R), BodyInRn(4, m, R)
# In R^4 the ball turns in the planes of its first three axes.
same = (*space.normal, *space.velocities)
zeros = {q: 0 for q in (*larger.normal, *larger.velocities) if q not in same}
others = {i: space.moments[0] for i in larger.moments if i not in space.moments}
RELATIONS = (
    space.relation_in_space("chaplygin-ball-in-rn", "chaplygin-ball"),
    Relation.into(
        SYSTEM,
        "chaplygin-ball-in-rn@3",
        {**zeros, **others},
        note="a ball of four dimensions that turns in the hyperplane of its first three axes",
    ),
)

"""Veselova's system in R^n: a body of R^n about a fixed point, without turning across a direction.

The configuration space is SO(n), given by its frame.  Omega = g^T dg/dt is the angular velocity
along the body's axes, and gamma = g^T e_n a direction fixed in space, dgamma/dt = -Omega gamma.
The body does not turn in planes at right angles to e_n, so Omega = gamma u^T - u gamma^T, or

    gamma_n Omega_ij = gamma_j Omega_in - gamma_i Omega_jn     (i < j < n),

and Omega_in are the velocities, good where gamma_n is not 0.  With the moments J_ij in the planes
of two axes and G_ij = J_ij Omega_ij the equations are dG/dt = [G, Omega] + Lambda with
Lambda gamma = 0, and so the vector G gamma is fixed in space [FedorovJovanovic2004].  Its entries
are gamma_n P_i and -(P, gamma), where P_i are the momenta of the velocities.

Moments J_ij = a_i a_j (any moments, if n = 3) are the special case in which the density of the
measure is a power of (gamma, A gamma), A = diag(a_1, ..., a_n), and (gamma, A gamma)^(-1/2) is a
reducing multiplier: in another time gamma moves on a geodesic of a metric on the sphere.
"""

from __future__ import annotations

from functools import partial

import sympy as sp

from voronec import Relation, System
from voronec.kinematics import BodyInRn


def member(n: int, name: str) -> System:
    """The system in R^n."""
    body = BodyInRn(n, twists=False)
    caption = "The fixed direction seen from the body, while gamma_n is positive."
    return body.system(
        name=name,
        title=f"Veselova's system in R^{n}",
        description=f"A body of R^{n} about a fixed point, which does not turn in the planes at "
        "right angles to a direction fixed in space.",
        values={},
        second_moments=("0.7", "0.6", "0.4", "0.5", "0.8"),
        scenes={"default": body.scene(caption, 4.0)},
        references=("FedorovJovanovic2004", "VeselovVeselova1988"),
    )


MEMBERS = {str(n): partial(member, n, f"veselova-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "veselova-in-rn")

J12, J13, J23 = sp.symbols("J12 J13 J23")
RELATIONS = (
    BodyInRn(3, twists=False).relation_in_space("veselova-in-rn", "veselova"),
    Relation.into(
        SYSTEM,
        "veselova-in-rn@3",
        {f"Omega{i}4": sp.Symbol(f"Omega{i}3") for i in "12"}
        | {"gamma3": 0, "gamma4": sp.Symbol("gamma3"), "Omega34": 0}
        | {"J14": J13, "J24": J23, "J13": J12, "J23": J12, "J34": J12},
        note="a body of four dimensions that turns in the hyperplane of its axes 1, 2 and 4",
    ),
)

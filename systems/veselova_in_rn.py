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

from voronec import Case, Equation, Fibration, Frame, Measure, Parameter, Relation, Scene, System
from voronec.kinematics import BodyVelocity, product_form, product_moments

SECOND_MOMENTS = tuple(sp.Rational(a, 10) for a in (7, 6, 4, 5, 8))  # of the mass, by axis
delta = sp.Symbol("Delta")


def member(n: int, name: str) -> System:
    """The system in R^n."""
    body = BodyVelocity(n)
    gamma, moments = sp.Matrix(body.normal), body.named("J")
    momenta = sp.symbols(f"P1:{n}")
    energy = body.energy(moments)
    fixed = body.normal_momentum(momenta)
    form = product_form(moments, gamma)
    start = dict(zip(gamma, [sp.Rational(k, 5) for k in (-3, *[0] * (n - 2), 4)], strict=True))
    turning = [sp.Rational(4 * (i % 2) - 3, 10 + i) for i in range(n - 1)]
    return System(
        name=name,
        title=f"Veselova's system in R^{n}",
        description=f"A body of R^{n} about a fixed point, which does not turn in the planes at "
        "right angles to a direction fixed in space.",
        fibration=Fibration(base=body.normal, relations=(gamma.dot(gamma) - 1,)),
        frame=Frame.group(
            body.last,
            body.rotations,
            dict(zip(gamma, body.seen(gamma), strict=True)),
            fibre=body.others,
            momenta=momenta,
            determinant=delta,
        ),
        lagrangian=energy,
        constraints=body.twist(gamma),
        parameters=tuple(
            Parameter(
                J,
                SECOND_MOMENTS[i - 1] + SECOND_MOMENTS[j - 1],
                positive=True,
                meaning=f"moment in the plane of the axes {i} and {j}",
            )
            for (i, j), J in zip(body.pairs, moments, strict=True)
        ),
        integrals={
            "energy": sp.Matrix(momenta).dot(body.last) - energy,
            "momentum squared": fixed.dot(fixed),
        },
        equations={"momentum": Equation(tuple(fixed), tuple(body.seen(fixed)))},
        measure=Measure(sp.sqrt(delta)),
        multiplier=form ** sp.Rational(-1, 2) if n == 3 else None,
        cases={
            "J = a a": Case(
                parameters={
                    f"J{i}{j}": value for (i, j), value in product_moments(moments, n).items()
                },
                measure=Measure(
                    form ** sp.Rational(n - 2, 2) / gamma[n - 1] ** (n - 2), (*gamma, *body.last)
                ),
                multiplier=form ** sp.Rational(-1, 2),
                note="moments that are products, J_ij = a_i a_j",
            )
        }
        if n > 3
        else {},
        scenes={
            "default": Scene(
                initial={**start, **dict(zip(body.last, turning, strict=True))},
                times=(0.0, 4.0),
                outputs=body.normal,
                caption="The fixed direction seen from the body, while gamma_n is positive.",
            ),
        },
        references=("FedorovJovanovic2004", "VeselovVeselova1988"),
    )


MEMBERS = {str(n): partial(member, n, f"veselova-in-rn@{n}") for n in (3, 4, 5)}
SYSTEM = member(4, "veselova-in-rn")

RELATIONS = (
    Relation(
        "veselova-in-rn@3",
        "veselova",
        state={
            **{f"gamma{i}": sp.Symbol(f"gamma{i}") for i in (1, 2, 3)},
            "omega1": -sp.Symbol("Omega23"),
            "omega2": sp.Symbol("Omega13"),
        },
        parameters={"J1": sp.Symbol("J23"), "J2": sp.Symbol("J13"), "J3": sp.Symbol("J12")},
        note="three dimensions",
    ),
    Relation(
        "veselova-in-rn@3",
        "veselova-in-rn",
        state={
            **{f"gamma{i}": sp.Symbol(f"gamma{i}") for i in (1, 2)},
            "gamma3": 0,
            "gamma4": sp.Symbol("gamma3"),
            "Omega14": sp.Symbol("Omega13"),
            "Omega24": sp.Symbol("Omega23"),
            "Omega34": 0,
        },
        parameters={
            "J12": sp.Symbol("J12"),
            "J14": sp.Symbol("J13"),
            "J24": sp.Symbol("J23"),
            **dict.fromkeys(("J13", "J23", "J34"), sp.Symbol("J12")),
        },
        note="a body of four dimensions that turns in the hyperplane of its axes 1, 2 and 4",
    ),
)

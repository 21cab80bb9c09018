"""Routh's sphere: a heavy ball, loaded symmetrically, that rolls on a plane without slipping.

The centre of mass lies on the axis e3 of symmetry, at l from the centre; gamma is the vertical, and
l gamma3 the height of the centre of mass over the centre.  With r = -R gamma - l e3 from the centre
of mass to the contact and G the angular momentum about the contact,

    dG/dt = G x omega - m R dgamma/dt x (omega x r) + m g r x gamma,    dgamma/dt = gamma x omega,
    G = I omega + m r x (omega x r).

The moment of the momentum along r, of Jellett, and rho omega3, of Routh, are constant [Routh1905]:

    (G, r) = -R (I omega, gamma) - l C omega3,
    rho^2 = A C + m (A (r_1^2 + r_2^2) + C r_3^2).

Squared, the second is a polynomial, and the search finds it so.  Upright, gamma3 = 1,
and spinning with omega3 = n, the ball is spectrally stable where

    n^2 (C + m R (R + l))^2 > 4 m g l (A + m (R + l)^2),

for all spins where the centre of mass is below.  Such a ball is a tippe top; one that rolls stays
upright, held by both integrals [GrayNickel2000]: to turn over it has to slip.
"""

from __future__ import annotations

import sympy as sp

from voronec import Equation, Limit, Measure, Parameter, Relation, Scene, System, kinematics

m, R, l, A, C, g = sp.symbols("m R l A C g")  # noqa: E741
ball = kinematics.RollingBall.on_plane(R, m, (A, A, C), (0, 0, l))
u, v, theta = ball.base
gamma, omega = sp.Matrix(sp.symbols("gamma1:4")), sp.Matrix(sp.symbols("omega1:4"))

arm = -R * gamma - sp.Matrix([0, 0, l])
own = sp.diag(A, A, C) * omega
momentum = own + m * arm.cross(omega.cross(arm))
normal_rate = gamma.cross(omega)
gyration = momentum.cross(omega) - m * R * normal_rate.cross(omega.cross(arm))
square = arm.dot(arm)
rho = sp.sqrt(A * C + m * (A * R**2 * (1 - gamma[2] ** 2) + C * arm[2] ** 2))

declaration = ball.declared(potential=m * g * l * gamma[2])
declaration["meanings"] |= {
    "Jellett": "(G, r), G the momentum about the contact, r from the mass centre to the contact",
    "Routh": "the spin about the axis, times the root of a quadratic in gamma3",
}

SYSTEM = System(
    name="routh-sphere",
    title="Routh's sphere",
    description="A heavy ball whose centre of mass lies on its axis of symmetry, off its centre, "
    "rolls without slipping on a plane.",
    **declaration,
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        Parameter(l, "1/5", meaning="centre of mass from the centre, along the axis"),
        Parameter(A, "2/5", positive=True, meaning="central moment about an axis across"),
        Parameter(C, "1/2", positive=True, meaning="moment about the axis of symmetry"),
        Parameter(g, 1, meaning="gravity"),
    ),
    equations={
        "momentum": Equation(momentum, gyration + m * g * arm.cross(gamma)),
        "normal": Equation(gamma, normal_rate),
    },
    integrals={
        "energy": momentum.dot(omega) / 2 + m * g * l * gamma[2],
        "Jellett": own.dot(arm),
        "Routh": rho * omega[2],
    },
    measure=Measure((A + m * square) * rho, (*gamma, *omega)),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={u: "6/5", omega[0]: "1/20", omega[2]: 2},
            times=(0.0, 20.0),
            outputs=(*ball.fibre, u, v),
            caption="The ball nods while it rolls around.",
        ),
        "tippe-top": Scene(
            initial={u: sp.pi - sp.Rational(1, 10), omega[2]: 20},
            parameters={l: "-1/5", g: 10},
            times=(0.0, 5.0),
            outputs=(*ball.fibre, u, v),
            caption="A tippe top that does not slip stays upright.",
        ),
    },
    references=("Routh1905", "GrayNickel2000", "BorisovMamaev2002"),
)

h, K, R1, R2 = sp.symbols("h K R1 R2")
RELATIONS = (
    Relation(
        "routh-sphere",
        "chaplygin-ball",
        parameters={R: R, m: m, "I1": A, "I2": A, "I3": C},
        limit=Limit(h, {l: h * l}),
        note="the centre of mass moves to the centre, where weight does nothing",
    ),
    Relation(
        "displaced-ball-on-sphere",
        "routh-sphere",
        parameters={R: R2, l: l, m: m, A: A, C: C, g: K * R1 / m},
        limit=Limit(h, {R1: 1 / h, K: h * K}),
        note="the sphere becomes a plane, and what draws to its centre the weight",
    ),
)

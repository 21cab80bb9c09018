"""Markeev's ball: a balanced, dynamically non-symmetric ball with a gyroscope rolls on a plane.

The momentum kappa of the gyroscope is constant in the ball.  With G the momentum of the ball about
the contact and gamma the vertical, both along the ball's principal axes,

    Gdot = (G + kappa) x omega,   gammadot = gamma x omega,
    G = I omega + D (omega - (omega, gamma) gamma),   D = m R^2

[Markeev1985].  The whole momentum G + kappa is constant in space; with the energy and the invariant
measure that makes the ball integrable [DragovicGajicJovanovic2020, eqs. (Chap*), (cl:int*)].
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
    Poisson,
    Relation,
    Scene,
    System,
    kinematics,
)

omega = sp.symbols("omega1:4")
gamma = sp.symbols("gamma1:4")
m, R = sp.symbols("m R")
inertia = sp.symbols("I1:4")
kappa = sp.symbols("kappa1:4")

ball = kinematics.RollingBall.on_plane(R, m, inertia)
u, v, theta = ball.base
x, y = ball.fibre

D = m * R**2
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
whole = momentum + sp.Matrix(kappa)
share = sum(D * g**2 / (i + D) for g, i in zip(gamma, inertia, strict=True))
root = sp.sqrt(1 - share)
start = dict(zip(omega, (sp.Rational(1, 2), 1, 1), strict=True))

# In the time dtau = dt / root the ball is Hamiltonian on (G + kappa, gamma), with the bracket of
# the ball without a gyroscope [BorisovMamaev2001].
M = sp.symbols("M1:4")
bracket = {}
for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    bracket[M[i], M[j]] = -root * (M[k] - D * spin.dot(normal) * gamma[k])
    bracket[M[i], gamma[j]], bracket[M[i], gamma[k]] = -root * gamma[k], root * gamma[j]


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy + sp.Matrix(kappa).dot(sp.Matrix(ball.spin)),
    }


SYSTEM = System(
    name="gyroscopic-ball-on-plane",
    title="Markeev's gyroscopic ball on a plane",
    description="A balanced, dynamically non-symmetric ball with a gyroscope rolls without "
    "slipping on a plane.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
    parameters=(
        Parameter(R, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass of ball and rotor"),
        *(
            Parameter(i, sp.Rational(tenths, 10), positive=True, meaning="principal moment")
            for i, tenths in zip(inertia, (4, 5, 7), strict=True)
        ),
        *(
            Parameter(k, sp.Rational(tenths, 10), meaning="momentum of the gyroscope")
            for k, tenths in zip(kappa, (3, -2, 5), strict=True)
        ),
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum": Equation(tuple(momentum), tuple(whole.cross(spin))),
        "normal": Equation(gamma, tuple(normal.cross(spin))),
    },
    integrals={
        "energy": momentum.dot(spin) / 2,
        "momentum squared": whole.dot(whole),
        "vertical momentum": whole.dot(normal),
    },
    measure=Measure(root, (*gamma, *omega)),
    poisson=Poisson(
        variables={**dict(zip(M, whole, strict=True)), **{g: g for g in gamma}},
        bracket=bracket,
        hamiltonian=momentum.dot(spin) / 2,
        clock=1 / root,
    ),
    essential=(u, v, *omega),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={u: 2, **start},
            times=(0.0, 40.0),
            outputs=(x, y, *omega),
            caption="The gyroscope bends the path of the ball.",
        ),
    },
    references=("Markeev1985", "Chaplygin1903", "BorisovMamaev2001", "DragovicGajicJovanovic2020"),
)

h = sp.Symbol("h")
RELATIONS = (
    Relation(
        "gyroscopic-ball-on-plane",
        "chaplygin-ball",
        parameters={p: p for p in (m, R, *inertia)},
        limit=Limit(h, {k: h * k for k in kappa}),
        note="the gyroscope is taken away",
    ),
)

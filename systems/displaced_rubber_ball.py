"""The rubber ball on a plane whose centre of mass is not its centre, without gravity.

a is the centre of mass from the ball's centre, along the principal axes.  omega1 and omega2 are the
velocities, and omega3 follows from (omega, gamma) = 0.  With

    J = I + m (R^2 + a^2) - m a a^T,    s = m R (a, gamma),    K = J omega + 2 s omega,

the part of K across gamma, L = K - (K, gamma) gamma, obeys

    dL/dt = L x omega + (ds/dt) omega,    dgamma/dt = gamma x omega.

The energy is (K, omega)/2, and therefore |L|^2 - 2 s (K, omega) is a second quadratic integral.
The two foliate the states as in Euler's problem of the free body, and yet the ball has in general
no invariant measure [BolsinovBorisovMamaev2012]: none with a density that depends on gamma alone,
because the divergence is no total derivative.  With an axis of symmetry there is one.
"""

from __future__ import annotations

from typing import Any

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
    System,
)
from voronec.kinematics import RollingBall

m, R, h = sp.symbols("m R h")
inertia, offset = sp.symbols("I1:4"), sp.symbols("a1:4")
ball = RollingBall.on_plane(R, m, inertia, offset)
u, v, theta = ball.base

gamma, a = sp.Matrix(sp.symbols("gamma1:4")), sp.Matrix(offset)
w1, w2 = sp.symbols("omega1 omega2")
omega = sp.Matrix([w1, w2, -(w1 * gamma[0] + w2 * gamma[1]) / gamma[2]])  # no twist
J = sp.diag(*inertia) + m * (R**2 + a.dot(a)) * sp.eye(3) - m * a * a.T
s = m * R * a.dot(gamma)
K = J * omega + 2 * s * omega
L = K - K.dot(gamma) * gamma
turning = gamma.cross(omega)

# With an axis of symmetry: the moments about the contact of turns across gamma, about the
# horizontal axis in the ball's equator, and about the one in the plane of axis and gamma.
level = J[0, 0] + 2 * s
upright = level * gamma[2] ** 2 + (J[2, 2] + 2 * s) * (1 - gamma[2] ** 2)
axial = {inertia[1]: inertia[0], offset[0]: 0, offset[1]: 0}


def declared(ball: RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi({w1: ball.spin[0], w2: ball.spin[1]}),
        "lagrangian": ball.energy,
    }


SYSTEM = System(
    name="displaced-rubber-ball",
    title="Displaced rubber ball on a plane",
    description="A ball whose centre of mass is not its centre rolls on a plane without slipping "
    "and without turning about the vertical; there is no gravity.",
    fibration=Fibration(base=(u, v), fibre=(*ball.fibre, theta)),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=(*ball.no_slip, ball.no_twist),
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        *(
            Parameter(i, sp.Rational(tenths, 10), positive=True, meaning="central moment")
            for i, tenths in zip(inertia, (4, 5, 7), strict=True)
        ),
        *(
            Parameter(x, sp.Rational(tenths, 10), meaning="centre of mass from the centre")
            for x, tenths in zip(offset, (1, -1, 2), strict=True)
        ),
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum across the normal": Equation(
            tuple(L), tuple(L.cross(omega) + m * R * a.dot(turning) * omega)
        ),
        "normal": Equation(tuple(gamma), tuple(turning)),
    },
    integrals={
        "energy": K.dot(omega) / 2,
        "momentum across the normal": L.dot(L) - 2 * s * K.dot(omega),
    },
    essential=(u, v, w1, w2),
    cases={
        "symmetric": Case(
            parameters=axial,
            integrals={"axial": omega[2] * sp.sqrt(upright)},
            measure=Measure(level * sp.sqrt(upright) / gamma[2], (*gamma, w1, w2)),
            integrable="Euler-Jacobi",
            note="the displacement lies along the axis of symmetry",
        ),
    },
    scenes={
        "default": Scene(
            initial={u: sp.Rational(6, 5), w1: sp.Rational(1, 20), w2: sp.Rational(1, 5)},
            times=(0.0, 10.0),
            outputs=(*ball.fibre, u, v),
            caption="The ball rolls without gravity.",
        ),
    },
    references=("BolsinovBorisovMamaev2012", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation(
        "displaced-rubber-ball",
        "rubber-ball-on-plane",
        parameters={str(p): p for p in (m, R, *inertia)},
        limit=Limit(h, {str(x): h * x for x in offset}),
        note="the centre of mass moves to the centre",
    ),
)

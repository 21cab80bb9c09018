"""A dynamically symmetric ball on a sphere.

Moments A, A, C about the centre; along the ball's principal axes,

    Gdot = G x omega,   gammadot = epsilon gamma x omega,   epsilon = R1 / (R1 + R2),
    G = I omega + D (omega - (omega, gamma) gamma),   D = m R2^2.

R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

Along a motion, sigma = (omega, gamma) is a function of x = gamma_3 with

    (A + b x^2) sigma'' + 3 b x sigma' + b (1 - mu^2) sigma = 0,   b = (C - A) D / (C + D),

where mu = 1/epsilon = 1 + R2/R1, the prime is d/dx, and
mu (C - A) omega_3 = -A sigma' - x (C - A) omega_3'.
Its solutions are elementary: with c = sqrt(|b|/A) and y = sqrt(1 + (b/A) x^2), sigma = f/y with
f = exp(+-mu asinh(c x)) where C > A, and f = cos, sin of mu asin(c x) where C < A.  Two integrals
linear in the velocities are the constants of this solution; the cases below give them
[BorisovMamaev2002].
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
    Square,
    System,
    kinematics,
)

omega = sp.symbols("omega1:4")
gamma = sp.symbols("gamma1:4")
R1, R2, m = sp.symbols("R1 R2 m")
A, C = sp.symbols("A C")
inertia = (A, A, C)

ball = kinematics.RollingBall.on_sphere(R1, R2, m, inertia)
u, v, _ = ball.base

D = m * R2**2
epsilon = R1 / (R1 + R2)
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
share = sum(D * g**2 / (i + D) for g, i in zip(gamma, inertia, strict=True))

# sigma as a function of x = gamma3, with its first and second derivative.
mu = 1 / epsilon
x, sigma, w = gamma[2], spin.dot(normal), (C - A) * omega[2]
b = D * (C - A) / (C + D)
first = -(mu * w + b * (1 - mu) * x * sigma) / (A + b * x**2)
second = -(3 * b * x * first + b * (1 - mu**2) * sigma) / (A + b * x**2)
rate = epsilon * (gamma[0] * omega[1] - gamma[1] * omega[0])  # of x

# With y^2 = 1 + b x^2/A: y d/dx (y sigma) = (mu/A) partner and d/dx partner = mu b sigma, so that
# the pair (A c y sigma, partner) turns, hyperbolically or not, through mu times the angle of x.
partner = b * x * sigma - w
oblate, prolate = sp.sqrt(b / A), sp.sqrt(-b / A)
spread, swing = (A * c * sp.sqrt(1 + b * x**2 / A) * sigma for c in (oblate, prolate))
growth = sp.exp(mu * sp.asinh(oblate * x))
angle = mu * sp.asin(prolate * x)


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy,
    }


SYSTEM = System(
    name="symmetric-ball-on-sphere",
    title="Symmetric ball on a sphere",
    description="A dynamically symmetric ball rolls without slipping over a fixed sphere: outside, "
    "inside, or around it as a shell.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
    parameters=(
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        Parameter(R2, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="equatorial moment of inertia"),
        Parameter(C, sp.Rational(3, 5), positive=True, meaning="axial moment of inertia"),
    ),
    invariants=dict(zip(map(str, gamma), ball.normal, strict=True)),
    equations={
        "momentum": Equation(tuple(momentum), tuple(momentum.cross(spin))),
        "normal": Equation(gamma, tuple((epsilon * normal).cross(spin))),
        "normal spin": Equation(sigma, first * rate),
        "normal spin, derived": Equation(first, second * rate),
    },
    integrals={
        "energy": momentum.dot(spin) / 2,
        "momentum squared": momentum.dot(momentum),
    },
    measure=Measure(sp.sqrt(1 - share), (*gamma, *omega)),
    essential=(u, v, *omega),
    cases={
        "oblate": Case(
            parameters={},
            integrals={
                "growing": (spread - partner) * growth,
                "falling": (spread + partner) / growth,
            },
            integrable="Euler-Jacobi",
            note="C > A",
        ),
        "prolate": Case(
            parameters={},
            integrals={
                "cosine": swing * sp.cos(angle) - partner * sp.sin(angle),
                "sine": swing * sp.sin(angle) + partner * sp.cos(angle),
            },
            integrable="Euler-Jacobi",
            note="C < A",
        ),
    },
    scenes=ball.scenes_on_sphere(R1, omega),
    drawing={"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

h = sp.Symbol("h")
moments = {"I1": A, "I2": A, "I3": C}
RELATIONS = (
    Relation(
        "symmetric-ball-on-sphere", "ball-on-sphere", parameters={R1: R1, R2: R2, m: m, **moments}
    ),
    Relation(
        "symmetric-ball-on-sphere",
        "chaplygin-ball",
        parameters={"R": R2, m: m, **moments},
        limit=Limit(h, {R1: 1 / h}),
        note="the sphere becomes a plane",
    ),
)
SQUARES = (
    Square(
        first=("symmetric-ball-on-sphere -> ball-on-sphere", "ball-on-sphere -> chaplygin-ball"),
        second=("symmetric-ball-on-sphere -> chaplygin-ball",),
        name="a symmetric ball on a sphere that becomes a plane",
    ),
)

"""Bobylev's ball: dynamically symmetric, a gyroscope along its axis of symmetry, on a plane.

The moments A, A, C are those of ball and rotor about the centre, less the rotor's axial part; k is
the rotor's axial momentum [Bobylev1892].  With D = m R^2, along the ball's principal axes,

    Gdot = (G + k e_3) x omega,   gammadot = gamma x omega,
    G = I omega + D (omega - (omega, gamma) gamma).

Symmetry gives one more integral, linear in the velocities,

    sqrt(A + b gamma_3^2) ((C - A) omega_3 + k),   b = (C - A) D / (C + D).

Where C = A this is the number sqrt(A) k, and says nothing; in its place stand the integrals of
Zhukovsky's ball.
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
    Plane,
    Quadratures,
    Relation,
    Scene,
    Square,
    System,
    Trace,
    kinematics,
    velocity,
)

omega = sp.symbols("omega1:4")
gamma = sp.symbols("gamma1:4")
m, R = sp.symbols("m R")
A, C = sp.symbols("A C")
inertia = (A, A, C)
k = sp.Symbol("k")

ball = kinematics.RollingBall.on_plane(R, m, inertia)
u, v, theta = ball.base
x, y = ball.fibre

D = m * R**2
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
whole = momentum + sp.Matrix([0, 0, k])
share = sum(D * g**2 / (i + D) for g, i in zip(gamma, inertia, strict=True))
slope = (C - A) * D / (C + D)
start = dict(zip(omega, (sp.Rational(1, 2), 1, 1), strict=True))


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy + kinematics.axial_rotor(k, (0, 0, 1), ball.spin),
    }


# Motion by quadratures.  Along (e_u, e_v, n) the spin is (s, tau, n) and the momentum
# (P s - K sin(u), P tau, A n + K cos(u)), K = (C - A) omega_3 + k.  By the axial integral
# K rho = k + (C - A) L, rho = sqrt(1 + 4 beta cos(u)^2).  With E = 1 - beta z^2, F = 1 + beta z^2
#     cos(u) = z/E,   rho = F/E,   A n F = C5 F - (k + (C - A) L) z = N,
#     omega_3 F = L E - 2 k (beta/(C - A)) z^2 = T,
# all of them good where C = A too; and in the time tau, dt = rho dtau, dz/dtau has a square of the
# fourth degree: F^2 drops out of it.
z = sp.Symbol("z")
C5, L, h2, H = sp.symbols("C5 L h2 H")
P, Q, excess = A + D, C + D, C - A
part = D / (4 * A * Q)
beta = excess * part
E, F = 1 - beta * z**2, 1 + beta * z**2
whole_axial = k + excess * L
N = C5 * F - whole_axial * z
T = L * E - 2 * k * part * z**2
body = ball.contact.body.frame
s, tau, n = body.T * spin
upward = sp.cos(u)
axial = k + excess * omega[2]  # K
rho = sp.sqrt(1 + 4 * beta * upward**2)
horizontal = (ball.contact.attitude * whole.subs(dict(zip(gamma, ball.normal, strict=True))))[:2]
quartic = (
    (h2 - C5**2 / A - Q * L**2) / P
    + 2 * C5 * (Q * L + k) / (A * P) * z
    - (
        (2 * A * Q + D * excess) * h2 / A
        + D * (2 * P + excess) * (C5 / A) ** 2
        + Q * (2 * Q - D) / A * (excess * L**2 + 2 * k * L)
        + 2 * Q * k**2 / A
    ) / (2 * P * Q) * z**2
    + C5 * D * (excess * (Q * L + k) + 2 * P * k) / (2 * A**2 * P * Q) * z**3
    - part**2 / P * (Q * (excess * L + 2 * k) ** 2 - excess**2 * (h2 - C5**2 / A)) * z**4
)  # fmt: skip
root = sp.sqrt(C * P / (A * Q))  # rho at the poles of the ball
near, far = 2 / (1 + root), -(1 + root) / (2 * beta)  # where cos(u) = 1, on both branches of rho
spun = (whole_axial * (P * C5 / A * z - 2 * P * k * part * z**2 - (Q * L + k) * F)) / H
rolled = sp.Matrix([sp.sin(u) * velocity(v), -velocity(u), N / (A * F)])  # (s, tau, n) again
MOTION = Quadratures(
    variable={z: 2 * upward / (1 + rho)},
    constants={
        C5: A * n + axial * upward,
        L: rho * omega[2] + 4 * k * part * upward**2 / (1 + rho),
        h2: P * (s**2 + tau**2) + A * n**2 + excess * omega[2] ** 2,
        H: sp.sqrt((P * s - axial * sp.sin(u)) ** 2 + (P * tau) ** 2),
    },
    quartic=quartic,
    integrals={
        v: (N * z / A - T * E) / (E**2 - z**2),
        theta: (T * z - N * E / A) / (E**2 - z**2),
    },
    poles={
        **{c: (N / A - T).subs(z, c) / (2 * root) for c in (near, far)},
        **{-c: (N / A + T).subs(z, -c) / (2 * root) for c in (near, far)},
    },
    others=(1 / sp.sqrt(beta), -1 / sp.sqrt(beta)),  # where rho is infinite
    traces=(Trace(u, v, z / E),),
    velocities=dict(zip(omega, body * rolled, strict=True)),
    plane=Plane(
        place=(x, y),
        direction=horizontal,
        length=H,
        rates=(0, -R / (P * E) * (H * F + spun)),
        slopes=(R * whole_axial / (H * E), 0),
    ),
    clock=F / E,
)


SYSTEM = System(
    name="bobylev-ball",
    title="Bobylev's gyroscopic ball on a plane",
    description="A dynamically symmetric ball with a gyroscope along its axis rolls without "
    "slipping on a plane.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
    parameters=(
        Parameter(R, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass of ball and rotor"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="equatorial moment of inertia"),
        Parameter(C, sp.Rational(3, 5), positive=True, meaning="axial moment of inertia"),
        Parameter(k, sp.Rational(1, 2), meaning="axial momentum of the gyroscope"),
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
        "axial": sp.sqrt(A + slope * gamma[2] ** 2) * ((C - A) * omega[2] + k),
    },
    measure=Measure(sp.sqrt(1 - share), (*gamma, *omega)),
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
    motion=MOTION,
    references=("Bobylev1892", "Zhukovsky1893", "Markeev1985", "DragovicGajicJovanovic2020"),
)

h = sp.Symbol("h")
RELATIONS = (
    Relation(
        "bobylev-ball",
        "gyroscopic-ball-on-plane",
        parameters={m: m, R: R, "I1": A, "I2": A, "I3": C, "kappa1": 0, "kappa2": 0, "kappa3": k},
    ),
    Relation(
        "bobylev-ball",
        "chaplygin-ball",
        parameters={m: m, R: R, "I1": A, "I2": A, "I3": C},
        limit=Limit(h, {k: h}),
        note="the gyroscope is taken away",
    ),
)
SQUARES = (
    Square(
        first=(
            "bobylev-ball -> gyroscopic-ball-on-plane",
            "gyroscopic-ball-on-plane -> chaplygin-ball",
        ),
        second=("bobylev-ball -> chaplygin-ball",),
        name="Bobylev's ball without its gyroscope",
    ),
)

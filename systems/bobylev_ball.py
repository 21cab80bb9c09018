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

import sympy as sp

from voronec import Plane, Quadratures, Relation, Square, Trace, kinematics, velocity
from voronec.kinematics import matrix_product

m, R, A, C, k = sp.symbols("m R A C k")

rolling = kinematics.BalancedBall.on_plane(R, m, (A, A, C), (0, 0, k))
ball, D = rolling.ball, rolling.contact_inertia
omega, normal = rolling.motion.spin, rolling.motion.normal
u, v, theta = ball.base
x, y = ball.fibre

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
s, tau, n = matrix_product(body.T, omega)
upward = sp.cos(u)
axial = k + excess * omega[2]  # K
rho = sp.sqrt(1 + 4 * beta * upward**2)
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
drift = (whole_axial * (P * C5 / A * z - 2 * P * k * part * z**2 - (Q * L + k) * F)) / H
contact_spin = sp.Matrix([sp.sin(u) * velocity(v), -velocity(u), N / (A * F)])  # (s, tau, n) again
MOTION = Quadratures(
    variable={z: 2 * upward / (1 + rho)},
    constants={
        C5: A * n + axial * upward,
        L: rho * omega[2] + 4 * k * part * upward**2 / (1 + rho),
        h2: P * (s**2 + tau**2) + A * n**2 + excess * omega[2] ** 2,
        H: sp.sqrt((P * s - axial * sp.sin(u)) ** 2 + (P * tau) ** 2),
    },
    quartic=quartic,
    integrals={v: (N * z / A - T * E) / (E**2 - z**2), theta: (T * z - N * E / A) / (E**2 - z**2)},
    poles={
        **{c: (N / A - T).xreplace({z: c}) / (2 * root) for c in (near, far)},
        **{-c: (N / A + T).xreplace({z: -c}) / (2 * root) for c in (near, far)},
    },
    others=(1 / sp.sqrt(beta), -1 / sp.sqrt(beta)),  # where rho is infinite
    traces=(Trace(u, v, z / E),),
    velocities=dict(zip(omega, matrix_product(body, contact_spin), strict=True)),
    plane=Plane(
        place=(x, y),
        direction=rolling.horizontal_momentum,
        length=H,
        rates=(0, -R / (P * E) * (H * F + drift)),
        slopes=(R * whole_axial / (H * E), 0),
    ),
    clock=F / E,
)


SYSTEM = rolling.system(
    name="bobylev-ball",
    title="Bobylev's gyroscopic ball on a plane",
    description="A dynamically symmetric ball with a gyroscope along its axis rolls without "
    "slipping on a plane.",
    values={R: 1, m: 1, A: "0.4", C: "0.6", k: "0.5"},
    integrals={"axial": sp.sqrt(A + excess * D / Q * normal[2] ** 2) * axial},
    integrable="Euler-Jacobi",
    scenes={"default": rolling.scene("The gyroscope bends the path of the ball.")},
    motion=MOTION,
    references=("Bobylev1892", "Zhukovsky1893", "Markeev1985", "DragovicGajicJovanovic2020"),
)

moments = {"I1": A, "I2": A, "I3": C}
RELATIONS = (
    Relation.of(
        SYSTEM, "gyroscopic-ball-on-plane", {**moments, "kappa1": 0, "kappa2": 0, "kappa3": k}
    ),
    Relation.of(SYSTEM, "chaplygin-ball", moments, vanish=k, note="the gyroscope is taken away"),
)
SQUARES = (
    Square.through(
        ("bobylev-ball", "gyroscopic-ball-on-plane", "chaplygin-ball"),
        ("bobylev-ball", "chaplygin-ball"),
        name="Bobylev's ball without its gyroscope",
    ),
)

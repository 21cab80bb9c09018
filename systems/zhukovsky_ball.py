"""Zhukovsky's ball: Bobylev's under the condition that makes its inertia spherical, on a plane.

Zhukovsky's condition, that the ball's axial moment is the equatorial one of the ball plus that of
the rotor, makes the inertia of ball and rotor, less the rotor's axial part, the same, A, about all
axes [Zhukovsky1893].  With D = m R^2, along the ball's principal axes,

    Gdot = (G + k e_3) x omega,   gammadot = gamma x omega,
    G = (A + D) omega - D (omega, gamma) gamma.

A (omega, gamma) + k gamma_3 and A (A + D) omega_3 + D k gamma_3^2 / 2 are constant.
"""

from __future__ import annotations

import sympy as sp

from voronec import Plane, Quadratures, Relation, Square, Trace, kinematics, velocity
from voronec.kinematics import matrix_product

m, R, A, k = sp.symbols("m R A k")

rolling = kinematics.BalancedBall.on_plane(R, m, (A, A, A), (0, 0, k))
ball, D = rolling.ball, rolling.contact_inertia
omega, normal = rolling.motion.spin, rolling.motion.normal
u, v, theta = ball.base
x, y = ball.fibre

# Motion by quadratures in z = cos(u).  Along (e_u, e_v, n) the spin is (s, tau, n), and the
# momentum (P s - k sin(u), P tau, A n + k cos(u)); on a level of the integrals A n = N,
# P s sin(u) = S, P (s^2 + tau^2) = W.  In the plane, with K for the horizontal momentum,
# P d(x + i y)/dt = -i R K (1 + k sin(u) (P (s + i tau) - k sin(u)) / |K|^2).
z = sp.Symbol("z")
C5, S0, h2, H = sp.symbols("C5 S0 h2 H")
P = A + D
body = ball.contact.body.frame
s, tau, n = matrix_product(body.T, omega)
S1, S2 = P * C5 / A, -k * (2 * A + D) / (2 * A)
S = S0 + S1 * z + S2 * z**2
N = C5 - k * z
W = h2 - N**2 / A
contact_spin = sp.Matrix([sp.sin(u) * velocity(v), -velocity(u), N / A])  # (s, tau, n) again
vertical = A * n + k * sp.cos(u)
MOTION = Quadratures(
    variable={z: sp.cos(u)},
    constants={
        C5: vertical,
        S0: P * s * sp.sin(u) - (S1 * z + S2 * z**2).subs({C5: vertical, z: sp.cos(u)}),
        h2: P * (s**2 + tau**2) + A * n**2,
        H: sp.sqrt((P * s - k * sp.sin(u)) ** 2 + (P * tau) ** 2),
    },
    quartic=(1 - z**2) * W / P - S**2 / P**2,
    integrals={v: S / (P * (1 - z**2)), theta: -N / A - z * S / (P * (1 - z**2))},
    poles={1: S.subs(z, 1) / (2 * P), -1: S.subs(z, -1) / (2 * P)},
    traces=(Trace(u, v, z),),
    velocities=dict(zip(omega, matrix_product(body, contact_spin), strict=True)),
    plane=Plane(
        place=(x, y),
        direction=rolling.horizontal_momentum,
        length=H,
        rates=(0, -R / P * (H + (k * S - k**2 * (1 - z**2)) / H)),
        slopes=(R * k / H, 0),
    ),
)


SYSTEM = rolling.system(
    name="zhukovsky-ball",
    title="Zhukovsky's gyroscopic ball on a plane",
    description="A ball with a gyroscope, spherical in its inertia by Zhukovsky's condition, "
    "rolls without slipping on a plane.",
    values={R: 1, m: 1, A: "0.4", k: "0.5"},
    integrals={"axial": A * (A + D) * omega[2] + D * k * normal[2] ** 2 / 2},
    integrable="Euler-Jacobi",
    scenes={"default": rolling.scene("The gyroscope bends the path of the ball.")},
    motion=MOTION,
    references=("Zhukovsky1893", "Bobylev1892", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.of(SYSTEM, "bobylev-ball", {"A": A, "C": A}),
    Relation.of(SYSTEM, "homogeneous-ball", vanish=k, note="the gyroscope is taken away"),
)
SQUARES = (
    Square.through(
        ("zhukovsky-ball", "bobylev-ball", "chaplygin-ball"),
        ("zhukovsky-ball", "homogeneous-ball", "chaplygin-ball"),
        name="Zhukovsky's ball without its gyroscope",
    ),
)

"""Zhukovsky's ball: Bobylev's under the condition that makes its inertia spherical, on a plane.

Zhukovsky's condition, that the ball's axial moment is the equatorial one of the ball plus that of
the rotor, makes the inertia of ball and rotor, less the rotor's axial part, the same, A, about all
axes [Zhukovsky1893].  With D = m R^2, along the ball's principal axes,

    Gdot = (G + k e_3) x omega,   gammadot = gamma x omega,
    G = (A + D) omega - D (omega, gamma) gamma.

A (omega, gamma) + k gamma_3 and A (A + D) omega_3 + D k gamma_3^2 / 2 are constant.
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
A = sp.Symbol("A")
inertia = (A, A, A)
k = sp.Symbol("k")

ball = kinematics.RollingBall.on_plane(R, m, inertia)
u, v, theta = ball.base
x, y = ball.fibre

D = m * R**2
spin, normal = sp.Matrix(omega), sp.Matrix(gamma)
momentum = kinematics.contact_momentum(inertia, D, omega, gamma)
whole = momentum + sp.Matrix([0, 0, k])
start = dict(zip(omega, (sp.Rational(1, 2), 1, 1), strict=True))


def declared(ball: kinematics.RollingBall) -> dict[str, Any]:
    """What depends on the ball's axes."""
    return {
        "frame": Frame.quasi(dict(zip(omega, ball.spin, strict=True))),
        "lagrangian": ball.energy + kinematics.axial_rotor(k, (0, 0, 1), ball.spin),
    }


# Motion by quadratures in z = cos(u).  Along (e_u, e_v, n) the spin is (s, tau, n), and the
# momentum (P s - k sin(u), P tau, A n + k cos(u)); on a level of the integrals A n = N,
# P s sin(u) = S, P (s^2 + tau^2) = W.  In the plane, with K for the horizontal momentum,
# P d(x + i y)/dt = -i R K (1 + k sin(u) (P (s + i tau) - k sin(u)) / |K|^2).
z = sp.Symbol("z")
C5, S0, h2, H = sp.symbols("C5 S0 h2 H")
P = A + D
body = ball.contact.body.frame
s, tau, n = body.T * spin
S1, S2 = P * C5 / A, -k * (2 * A + D) / (2 * A)
S = S0 + S1 * z + S2 * z**2
N = C5 - k * z
W = h2 - N**2 / A
horizontal = (ball.contact.attitude * whole.subs(dict(zip(gamma, ball.normal, strict=True))))[:2]
rolled = sp.Matrix([sp.sin(u) * velocity(v), -velocity(u), N / A])  # (s, tau, n) again
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
    velocities=dict(zip(omega, body * rolled, strict=True)),
    plane=Plane(
        place=(x, y),
        direction=horizontal,
        length=H,
        rates=(0, -R / P * (H + (k * S - k**2 * (1 - z**2)) / H)),
        slopes=(R * k / H, 0),
    ),
)


SYSTEM = System(
    name="zhukovsky-ball",
    title="Zhukovsky's gyroscopic ball on a plane",
    description="A ball with a gyroscope, spherical in its inertia by Zhukovsky's condition, "
    "rolls without slipping on a plane.",
    fibration=Fibration(base=ball.base, fibre=ball.fibre),
    **declared(ball),
    charts=ball.charts(declared),
    constraints=ball.no_slip,
    parameters=(
        Parameter(R, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass of ball and rotor"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="moment of inertia"),
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
        "axial": A * (A + D) * omega[2] + D * k * gamma[2] ** 2 / 2,
    },
    measure=Measure(1, (*gamma, *omega)),
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
    references=("Zhukovsky1893", "Bobylev1892", "DragovicGajicJovanovic2020"),
)

h = sp.Symbol("h")
RELATIONS = (
    Relation("zhukovsky-ball", "bobylev-ball", parameters={m: m, R: R, "A": A, "C": A, k: k}),
    Relation(
        "zhukovsky-ball",
        "homogeneous-ball",
        parameters={m: m, R: R, A: A},
        limit=Limit(h, {k: h}),
        note="the gyroscope is taken away",
    ),
)
SQUARES = (
    Square(
        first=("zhukovsky-ball -> bobylev-ball", "bobylev-ball -> chaplygin-ball"),
        second=("zhukovsky-ball -> homogeneous-ball", "homogeneous-ball -> chaplygin-ball"),
        name="Zhukovsky's ball without its gyroscope",
    ),
)

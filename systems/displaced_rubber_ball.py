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

import sympy as sp

from voronec import Case, Equation, Measure, Parameter, Relation, Scene, System, kinematics

m, R = sp.symbols("m R")
inertia, offset = sp.symbols("I1:4"), sp.symbols("a1:4")
ball = kinematics.RollingBall.on_plane(R, m, inertia, offset)
u, v, _ = ball.base

motion = kinematics.RubberMotion(inertia)
gamma, omega, a = motion.normal, motion.spin, sp.Matrix(offset)
w1, w2 = motion.velocities
J = sp.diag(*inertia) + m * (R**2 + a.dot(a)) * sp.eye(3) - m * a * a.T
s = m * R * a.dot(gamma)
K = J * omega + 2 * s * omega
L = K - K.dot(gamma) * gamma
normal_rate = gamma.cross(omega)

# With an axis of symmetry: the moments about the contact of turns across gamma, about the
# horizontal axis in the ball's equator, and about the one in the plane of axis and gamma.
level = J[0, 0] + 2 * s
upright = level * gamma[2] ** 2 + (J[2, 2] + 2 * s) * (1 - gamma[2] ** 2)
declaration, INTEGRAL = ball.declared(twists=False), "momentum across the normal"

SYSTEM = System(
    name="displaced-rubber-ball",
    title="Displaced rubber ball on a plane",
    description="A ball whose centre of mass is not its centre rolls on a plane without slipping "
    "and without turning about the vertical; there is no gravity.",
    **declaration | {"meanings": declaration["meanings"] | {INTEGRAL: "|L|^2 - 2 s (K, omega)"}},
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        *Parameter.each(inertia, ("0.4", "0.5", "0.7"), positive=True, meaning="central moment"),
        *Parameter.each(offset, ("0.1", "-0.1", "0.2"), meaning="centre of mass from the centre"),
    ),
    equations={
        INTEGRAL: Equation(L, L.cross(omega) + m * R * a.dot(normal_rate) * omega),
        "normal": Equation(gamma, normal_rate),
    },
    integrals={"energy": K.dot(omega) / 2, INTEGRAL: L.dot(L) - 2 * s * K.dot(omega)},
    cases={
        "symmetric": Case(
            parameters={inertia[1]: inertia[0], offset[0]: 0, offset[1]: 0},
            integrals={"axial": omega[2] * sp.sqrt(upright)},
            measure=Measure(level * sp.sqrt(upright) / gamma[2], (*gamma, w1, w2)),
            integrable="Euler-Jacobi",
            note="the displacement lies along the axis of symmetry",
        ),
    },
    scenes={
        "default": Scene(
            initial={u: "6/5", w1: "1/20", w2: "1/5"},
            times=(0.0, 10.0),
            outputs=(*ball.fibre, u, v),
            caption="The ball rolls without gravity.",
        ),
    },
    references=("BolsinovBorisovMamaev2012", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.of(
        SYSTEM, "rubber-ball-on-plane", vanish=offset, note="the centre of mass moves to the centre"
    ),
)

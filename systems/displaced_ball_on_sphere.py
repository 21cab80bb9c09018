"""A symmetric ball on a sphere whose mass centre lies on its axis, off its centre.

The mass centre O is at l along the axis from the ball's centre, and is drawn to the centre of the
sphere by the force K times the distance.  The moments about O are A, A, C.  With gamma the normal
of the sphere, M the contact, r = OM = -R2 gamma - l e_3 and epsilon = R1/(R1 + R2),

    dG/dt = G x omega + m r' x (omega x r) + K (R1 + R2) r x gamma + K l r x e_3,
    dgamma/dt = epsilon gamma x omega,    G = I omega + m r x (omega x r),    r' = -R2 dgamma/dt.

R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.

It is the body of revolution on a sphere for which the linear equation has elementary solutions.
With rho^2 = A C + m (A r^2 + (C - A) r_3^2), which is a quadratic in r_3, J = (G, r),
Z = rho omega_3,

    dZ/dr_3 = -(R2/R1) m J/rho,    dJ/dr_3 = -(R2/R1) (C - A) Z/rho:

the pair (m J, sqrt(m |C - A|) Z) turns, hyperbolically where C > A, with the integral of
dr_3/rho.  The cases give the two integrals that are linear in the velocities.  Where C = A, J is
constant, and the other is algebraic.  The force enters the energy only.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Case,
    Equation,
    Measure,
    Parameter,
    Relation,
    Scene,
    System,
    kinematics,
)
from voronec.kinematics import dot

omega, gamma = sp.symbols("omega1:4"), sp.symbols("gamma1:4")
R1, R2, m, A, C, shift, K = sp.symbols("R1 R2 m A C l K")
inertia = (A, A, C)

ball = kinematics.RollingBall.on_sphere(R1, R2, m, inertia, (0, 0, shift))
u, v, theta = ball.base
u1, v1 = ball.fibre

spin, normal, axis = sp.Matrix(omega), sp.Matrix(gamma), sp.Matrix([0, 0, 1])
ratio = R2 / R1
normal_rate = normal.cross(spin) / (1 + ratio)
arm = -R2 * normal - shift * axis
momentum = sp.diag(*inertia) * spin + m * arm.cross(spin.cross(arm))
pull = arm.cross(K * (R1 + R2) * normal + K * shift * axis)
momentum_rate = momentum.cross(spin) - m * R2 * normal_rate.cross(spin.cross(arm)) + pull
potential = K * (R1 + R2) * shift * gamma[2]

# rho^2 = curve r_3^2 - 2 m A l r_3 + level, and lean = d(rho^2)/dr_3 / 2.
square = R2**2 + shift**2 + 2 * R2 * shift * gamma[2]  # |r|^2 where |gamma| = 1
curve, level = m * (C - A), A * C + m * A * (R2**2 - shift**2)
rho = sp.sqrt(A * C + m * A * square + curve * arm[2] ** 2)
lean = curve * arm[2] - m * A * shift
J, Z = dot(momentum, arm), rho * omega[2]
root = sp.sqrt(curve)
growth = (root * rho + lean) ** ratio
# Where C < A, -curve rho^2 = side^2 - lean^2.
side = sp.sqrt((m * A * shift) ** 2 - curve * level)
swing = side * sp.sqrt(1 - (lean / side) ** 2) * omega[2]
angle = ratio * sp.asin(lean / side)

SYSTEM = System(
    name="displaced-ball-on-sphere",
    title="Displaced symmetric ball on a sphere",
    description="A symmetric ball whose mass centre lies on its axis, off its centre, rolls "
    "without slipping over a fixed sphere, drawn to its centre.",
    **ball.declared(potential=potential),
    parameters=(
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        Parameter(R2, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(A, "0.4", positive=True, meaning="equatorial moment of inertia"),
        Parameter(C, "0.5", positive=True, meaning="axial moment of inertia"),
        Parameter(shift, "0.2", meaning="mass centre along the axis"),
        Parameter(K, 1, meaning="force over distance, to the centre of the sphere"),
    ),
    equations={
        "momentum": Equation(momentum, momentum_rate),
        "normal": Equation(gamma, normal_rate),
        "linear": Equation(
            (Z, J),
            (
                ratio * m * J * R2 * normal_rate[2] / rho,
                ratio * (C - A) * Z * R2 * normal_rate[2] / rho,
            ),
        ),
    },
    integrals={"energy": dot(momentum, spin) / 2 + potential},
    measure=Measure((A + m * square) * rho, (*gamma, *omega)),
    cases={
        "oblate": Case(
            parameters={},
            integrals={
                "growing": (m * J + root * Z) * growth,
                "falling": (m * J - root * Z) / growth,
            },
            integrable="Euler-Jacobi",
            note="C > A",
        ),
        "prolate": Case(
            parameters={},
            integrals={
                "cosine": m * J * sp.cos(angle) + swing * sp.sin(angle),
                "sine": m * J * sp.sin(angle) - swing * sp.cos(angle),
            },
            integrable="Euler-Jacobi",
            note="C < A",
        ),
        "spherical": Case(
            parameters={C: A},
            integrals={
                "Jellett": J.xreplace({C: A}),
                "axial": (Z * A * shift - ratio * J * rho).xreplace({C: A}),
            },
            integrable="Euler-Jacobi",
        ),
    },
    scenes={
        "default": Scene(
            initial={u: 1, u1: 1, **dict(zip(omega, ("1/2", 1, 2), strict=True))},
            times=(0.0, 30.0),
            outputs=(u, v, u1, v1, *omega),
            caption="The heavy side of the ball swings while it rolls around the sphere.",
        ),
    },
    drawing={"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

general = dict(zip(sp.symbols("s tau n"), ball.contact.body.frame.T * spin, strict=True))
RELATIONS = (
    Relation.into(
        SYSTEM, "symmetric-ball-on-sphere", {shift: 0, K: 0}, note="the mass centre at the centre"
    ),
    Relation.of(
        SYSTEM,
        "symmetric-body-on-sphere",
        {
            R1: R1,
            sp.Function("P")(u): R2 - shift * sp.cos(u),
            sp.Function("V")(u): -K * (R1 + R2) * shift * sp.cos(u),
        },
        state={**{q: q for q in (u, v, theta, u1, v1)}, **general},
        note="its support function about the mass centre",
    ),
)

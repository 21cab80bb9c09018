"""A ball with a gyroscope on a sphere that is free to turn about its fixed centre.

The sphere has the moment J about every diameter, and the ball rolls on it without slipping; nothing
else turns it.  Along the principal axes of the ball, omega and W are the angular velocities of ball
and sphere, gamma the normal of the sphere, kappa the momentum of the gyroscope, and x_t the part
of x across gamma.  With D = m R2^2 and epsilon = R1/(R1 + R2),

    G = I omega + D omega_t + m R1 R2 W_t,        dG/dt = (G + kappa) x omega,
    N = J W + m R1^2 W_t + m R1 R2 omega_t,       dN/dt = N x omega,
    dgamma/dt = epsilon gamma x (omega - W):

the momentum of the ball about the contact and N, that of the sphere with the ball's mass put
at the contact, are both constant in space.

Where N = 0, W = -c omega_t with c = m R1 R2/(J + m R1^2), and the ball moves as one on a sphere at
rest, of another mass and with another ratio of the radii: so every ball on a fixed sphere occurs
here (the relation takes J = m R1^2), Demchenko's among them, whose contact moves by quadratures.
Of the two readings of a moving sphere [Bychkov2004] this is the free one; in ``bychkov-ball`` it
turns in a prescribed way.  R1 is signed.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, Scene, kinematics

theta, beta = sp.symbols("theta beta")
place = sp.symbols("n1:4")
omega, gamma, wheel = (sp.symbols(f"{name}1:4") for name in ("omega", "gamma", "W"))
R1, R2, m, J = sp.symbols("R1 R2 m J")
inertia, kappa = sp.symbols("I1:4"), sp.symbols("kappa1:4")

rolling = kinematics.BallOnMovingSphere(R1, R2, m, inertia, kappa, moment=J)
spin, whole, sphere_momentum = rolling.spin, rolling.whole, rolling.sphere_momentum

SYSTEM = rolling.system(
    name="ball-on-free-sphere",
    title="Gyroscopic ball on a free sphere",
    description="A ball with a gyroscope rolls without slipping over a sphere that turns freely "
    "about its fixed centre.",
    meanings={
        "momentum squared": "square of the momentum of the ball about the contact, with the rotor",
        "momentum of the sphere squared": "square of N, the momentum of the sphere",
        "product of the momenta": "scalar product of both momenta",
    },
    values={R1: 2, R2: 1, m: 1, inertia: ["2/5"] * 3, kappa: (0, 0, 3), J: 2},
    integrals={
        "energy": (rolling.momentum.dot(spin) + sphere_momentum.dot(rolling.swirl)) / 2,
        "momentum squared": whole.dot(whole),
        "momentum of the sphere squared": sphere_momentum.dot(sphere_momentum),
        "product of the momenta": whole.dot(sphere_momentum),
    },
    measure=rolling.measure(m * R2**2 * J / (J + m * R1**2)),  # of a sphere at rest with this D
    essential=(*place, *omega, *wheel),
    scenes={
        "default": Scene(
            initial={
                theta: 1,
                beta: 1,
                place[2]: 1,
                **dict(zip(omega, ("1/2", 0, 1), strict=True)),
                wheel[1]: "1/5",
            },
            times=(0.0, 40.0),
            outputs=(*rolling.contact, *omega, *wheel),
            caption="The ball drives the sphere and is driven; the contact, seen from space.",
        ),
    },
    references=("Bychkov2004", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.into(
        SYSTEM,
        "gyroscopic-ball-on-sphere",
        dict(zip(wheel, -R2 / (R1 - R2) * rolling.across(spin), strict=True))
        | {R1: (R1 - R2) / 2, m: 2 * m, J: m * (R1 - R2) ** 2 / 2},
        note="N = 0 and J = m R1^2",
    ),
)

"""A ball with a gyroscope on a moving sphere, which turns uniformly about a fixed axis.

The ball rolls without slipping over a sphere that is kept turning with the constant angular
velocity Omega about a vertical axis through its centre, so that the constraints are affine.  Along
the principal axes of the ball, gamma is the normal of the sphere and zeta the vertical; kappa is
the momentum of the gyroscope, D = m R2^2 and epsilon = R1/(R1 + R2).  With the momentum about the
contact

    G = I omega + D (omega - (omega, gamma) gamma) + m R1 R2 Omega (zeta - (zeta, gamma) gamma),
    dG/dt = (G + kappa) x omega,    dgamma/dt = epsilon gamma x (omega - Omega zeta),
    dzeta/dt = zeta x omega:

G + kappa is constant in space, as it is over a sphere at rest.  The energy is not constant; the
energy less Omega times the momentum about the vertical is, which is the energy in the frame that
turns with the sphere.

Yu. P. Bychkov treated a body with a gyroscope on a moving sphere, where the central ellipsoid of
the two is one of revolution, and found the contact of a ball by quadratures [Bychkov2004], as told
in [DragovicGajicJovanovic2020].  Of his bodies only the ball is done, and it may have three
different moments.  How his sphere moves is not told there, so that there are two readings: here it
turns as said above, which is prescribed; in ``ball-on-free-sphere`` it turns freely.  R1 is signed:
negative inside the sphere and for a shell around it.
"""

from __future__ import annotations

import sympy as sp

from voronec import Case, Relation, Scene, kinematics

theta, psi = sp.symbols("theta psi")
place = sp.symbols("n1:4")
omega, gamma, zeta = (sp.symbols(f"{name}1:4") for name in ("omega", "gamma", "zeta"))
R1, R2, m, Omega = sp.symbols("R1 R2 m Omega")
inertia, kappa = sp.symbols("I1:4"), sp.symbols("kappa1:4")

rolling = kinematics.BallOnMovingSphere(R1, R2, m, inertia, kappa, rate=Omega)
spin, whole = rolling.spin, rolling.whole
normal, upright = sp.Matrix(gamma), sp.Matrix(zeta)
moment = sp.diag(*inertia) * spin
centre_velocity = (R2 * spin + R1 * Omega * upright).cross(normal)  # the velocity of the centre
about_vertical = upright.dot(
    moment + sp.Matrix(kappa) + m * (R1 + R2) * normal.cross(centre_velocity)
)
energy = (moment.dot(spin) + m * centre_velocity.dot(centre_velocity)) / 2
start = {theta: 1, place[2]: 1, omega[0]: "1/2", omega[2]: 1}
usual_outputs = (*rolling.contact, *omega)

SYSTEM = rolling.system(
    name="bychkov-ball",
    title="Gyroscopic ball on a turning sphere",
    description="A ball with a gyroscope rolls without slipping over a sphere that turns "
    "uniformly about a fixed axis.",
    meanings={
        "turning energy": "energy in the frame that turns with the sphere",
        "momentum squared": "square of the momentum about the contact, with the rotor",
        "vertical momentum": "vertical part of the momentum about the contact",
    },
    values={R1: 2, R2: 1, m: 1, inertia: ["2/5"] * 3, kappa: (0, 0, 3), Omega: "1/2"},
    integrals={
        "turning energy": energy - Omega * about_vertical,
        "momentum squared": whole.dot(whole),
        "vertical momentum": whole.dot(upright),
    },
    measure=rolling.measure(m * R2**2),
    essential=(theta, psi, *place, *omega),
    cases={
        "homogeneous": Case(
            parameters={**dict.fromkeys(inertia[1:], inertia[0]), **dict.fromkeys(kappa, 0)},
            integrals={"twist": spin.dot(normal) + R1 / R2 * Omega * upright.dot(normal)},
            note="a homogeneous ball without gyroscope",
        ),
    },
    scenes={
        "default": Scene(
            initial=start,
            times=(0.0, 40.0),
            outputs=usual_outputs,
            caption="The sphere takes the ball along; the contact, seen from space.",
        ),
        "at rest": Scene(
            initial=start,
            parameters={Omega: 0},
            times=(0.0, 40.0),
            outputs=usual_outputs,
            caption="The default start on a sphere at rest: Demchenko's ball.",
        ),
    },
    references=("Bychkov2004", "Demchenko1924", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.of(SYSTEM, "gyroscopic-ball-on-sphere", vanish=Omega, note="the sphere stops"),
)

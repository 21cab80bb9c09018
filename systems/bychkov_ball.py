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
    Shape,
    System,
    kinematics,
    time,
    velocity,
)

angles = phi, theta, psi = sp.symbols("phi theta psi")
place = sp.symbols("n1:4")
omega, gamma, zeta = (sp.symbols(f"{name}1:4") for name in ("omega", "gamma", "zeta"))
R1, R2, m, Omega = sp.symbols("R1 R2 m Omega")
inertia, kappa = sp.symbols("I1:4"), sp.symbols("kappa1:4")

rotation = kinematics.Rotation.euler("zxz", *angles)
spin, normal, upright = sp.Matrix(omega), sp.Matrix(gamma), sp.Matrix(zeta)
D = m * R2**2
epsilon = R1 / (R1 + R2)
moment = sp.diag(*inertia) * spin


def turned(normal: sp.Matrix, upright: sp.Matrix) -> sp.Matrix:
    """dgamma/dt of the rolling ball."""
    return epsilon * normal.cross(spin - Omega * upright)


def across(vector: sp.Matrix) -> sp.Matrix:
    """What is left of a vector without its part along gamma."""
    return vector - vector.dot(normal) * normal


momentum = moment + D * across(spin) + m * R1 * R2 * Omega * across(upright)
whole = momentum + sp.Matrix(kappa)
carried = (R2 * spin + R1 * Omega * upright).cross(normal)  # the velocity of the centre
about_vertical = upright.dot(moment + sp.Matrix(kappa) + m * (R1 + R2) * normal.cross(carried))
energy = (moment.dot(spin) + m * carried.dot(carried)) / 2

# The same in coordinates: Euler's angles and n = gamma.
rates = sp.Matrix([velocity(n) for n in place])
centre = (R1 + R2) * (rates + spin.cross(sp.Matrix(place)))
vertical = sp.Matrix(rotation.matrix.row(2)).T
share = sum(D * g**2 / (i + D) for g, i in zip(gamma, inertia, strict=True))

outwards = rotation.matrix * sp.Matrix(place)

SYSTEM = System(
    name="bychkov-ball",
    title="Gyroscopic ball on a turning sphere",
    description="A ball with a gyroscope rolls without slipping over a sphere that turns "
    "uniformly about a fixed axis.",
    sketch=kinematics.rolling_sketch(on="sphere", attitude=angles, gamma=place, wheel="kappa").turn(
        (0.0, -3.9), 90, 0.35, Omega
    ),
    fibration=Fibration(base=angles, fibre=place, relations=(sum(n**2 for n in place) - 1,)),
    frame=Frame.quasi(dict(zip(omega, rotation.body_rates, strict=True))),
    lagrangian=kinematics.kinetic_energy(m, centre, inertia, omega) + sp.Matrix(kappa).dot(spin),
    constraints=tuple(rates - turned(sp.Matrix(place), vertical)),
    meanings={
        **kinematics.euler_meanings(angles),
        **kinematics.vector_meanings(place, "normal of the sphere at the contact", "space"),
        **kinematics.vector_meanings(omega, whose="the ball"),
        **kinematics.vector_meanings(map(str, gamma), "normal of the sphere", "the ball"),
        **kinematics.vector_meanings(map(str, zeta), "the vertical", "the ball"),
        "turning energy": "energy in the frame that turns with the sphere",
        "momentum squared": "square of the momentum about the contact, with the rotor",
        "vertical momentum": "vertical part of the momentum about the contact",
    },
    parameters=(
        Parameter(R1, 2, meaning="radius of the sphere, signed"),
        Parameter(R2, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass of ball and rotor"),
        *Parameter.each(inertia, ["2/5"] * 3, positive=True, meaning="principal moment"),
        *Parameter.each(kappa, (0, 0, 3), meaning="momentum of the gyroscope"),
        Parameter(Omega, sp.Rational(1, 2), meaning="angular velocity of the sphere"),
    ),
    invariants={
        **dict(zip(map(str, gamma), place, strict=True)),
        **dict(zip(map(str, zeta), vertical, strict=True)),
    },
    equations={
        "momentum": Equation(tuple(momentum), tuple(whole.cross(spin))),
        "normal": Equation(gamma, tuple(turned(normal, upright))),
        "vertical": Equation(zeta, tuple(upright.cross(spin))),
    },
    integrals={
        "turning energy": energy - Omega * about_vertical,
        "momentum squared": whole.dot(whole),
        "vertical momentum": whole.dot(upright),
    },
    measure=Measure(sp.sqrt(1 - share), (*gamma, *zeta, *omega)),
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
            initial={theta: 1, place[2]: 1, omega[0]: sp.Rational(1, 2), omega[2]: 1},
            times=(0.0, 40.0),
            outputs=(*(rotation.matrix * sp.Matrix(place)), *omega),
            caption="The sphere takes the ball along; the contact, seen from space.",
        ),
        "at rest": Scene(
            initial={theta: 1, place[2]: 1, omega[0]: sp.Rational(1, 2), omega[2]: 1},
            parameters={Omega: 0},
            times=(0.0, 40.0),
            outputs=(*(rotation.matrix * sp.Matrix(place)), *omega),
            caption="The same start on a sphere at rest: Demchenko's ball.",
        ),
    },
    shapes=(
        Shape.ball(
            R2,
            centre=(R1 + R2) * outwards,
            attitude=rotation.matrix,
            contact=R1 * outwards,
        ),
        Shape.ball(R1, attitude=Omega * time, role="ground"),
    ),
    references=("Bychkov2004", "Demchenko1924", "DragovicGajicJovanovic2020"),
)

h = sp.Symbol("h")
RELATIONS = (
    Relation(
        "bychkov-ball",
        "gyroscopic-ball-on-sphere",
        parameters={q: q for q in (R1, R2, m, *inertia, *kappa)},
        limit=Limit(h, {Omega: h * Omega}),
        note="the sphere stops",
    ),
)

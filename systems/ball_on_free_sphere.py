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

from voronec import (
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Relation,
    Scene,
    Shape,
    System,
    kinematics,
    velocity,
)

angles = phi, theta, psi = sp.symbols("phi theta psi")
turns = sp.symbols("alpha beta chi")
place = sp.symbols("n1:4")
omega, gamma, wheel = (sp.symbols(f"{name}1:4") for name in ("omega", "gamma", "W"))
R1, R2, m, J = sp.symbols("R1 R2 m J")
inertia, kappa = sp.symbols("I1:4"), sp.symbols("kappa1:4")

ball = kinematics.Rotation.euler("zxz", *angles)
sphere = kinematics.Rotation.euler("zxz", *turns)
spin, normal, swirl = sp.Matrix(omega), sp.Matrix(gamma), sp.Matrix(wheel)
D = m * R2**2
epsilon = R1 / (R1 + R2)


def across(vector: sp.Matrix) -> sp.Matrix:
    """What is left of a vector without its part along gamma."""
    return vector - vector.dot(normal) * normal


momentum = sp.diag(*inertia) * spin + D * across(spin) + m * R1 * R2 * across(swirl)
driven = J * swirl + m * R1**2 * across(swirl) + m * R1 * R2 * across(spin)
whole = momentum + sp.Matrix(kappa)

# The same in coordinates: Euler's angles of both, and n = gamma.
rates = sp.Matrix([velocity(n) for n in place])
centre = (R1 + R2) * (rates + spin.cross(sp.Matrix(place)))
kinetic = kinematics.kinetic_energy(m, centre, inertia, omega) + J * swirl.dot(swirl) / 2

# A ball on a sphere at rest would have this D.
carried = D * J / (J + m * R1**2)
share = sum(carried * g**2 / (i + carried) for g, i in zip(gamma, inertia, strict=True))

outwards = ball.matrix * sp.Matrix(place)

SYSTEM = System(
    name="ball-on-free-sphere",
    title="Gyroscopic ball on a free sphere",
    description="A ball with a gyroscope rolls without slipping over a sphere that turns freely "
    "about its fixed centre.",
    sketch=kinematics.rolling_sketch(
        on="sphere", attitude=angles, place=turns[1:], gamma=place, wheel="kappa"
    ).turn((0.0, -3.9), 90, 0.35, turns[0]),
    fibration=Fibration(
        base=(*angles, *turns), fibre=place, relations=(sum(n**2 for n in place) - 1,)
    ),
    frame=Frame.quasi(
        {
            **dict(zip(omega, ball.body_rates, strict=True)),
            **dict(zip(wheel, ball.matrix.T * sphere.space_rates, strict=True)),
        }
    ),
    lagrangian=kinetic + sp.Matrix(kappa).dot(spin),
    constraints=tuple(rates - epsilon * sp.Matrix(place).cross(spin - swirl)),
    meanings={
        **kinematics.euler_meanings(angles),
        **{q: f"of the sphere: {said}" for q, said in kinematics.euler_meanings(turns).items()},
        **kinematics.vector_meanings(place, "normal of the sphere at the contact", "space"),
        **kinematics.vector_meanings(omega, whose="the ball"),
        **kinematics.vector_meanings(wheel, "angular velocity of the sphere", "the ball"),
        **kinematics.vector_meanings(map(str, gamma), "normal of the sphere", "the ball"),
        "momentum squared": "square of the momentum of the ball about the contact, with the rotor",
        "momentum of the sphere squared": "square of N, the momentum of the sphere",
        "product of the momenta": "scalar product of both momenta",
    },
    parameters=(
        Parameter(R1, 2, meaning="radius of the sphere, signed"),
        Parameter(R2, 1, positive=True, meaning="radius of the ball"),
        Parameter(m, 1, positive=True, meaning="mass of ball and rotor"),
        *Parameter.each(inertia, ["2/5"] * 3, positive=True, meaning="principal moment"),
        *Parameter.each(kappa, (0, 0, 3), meaning="momentum of the gyroscope"),
        Parameter(J, 2, positive=True, meaning="moment of the sphere"),
    ),
    invariants=dict(zip(map(str, gamma), place, strict=True)),
    equations={
        "momentum": Equation(tuple(momentum), tuple(whole.cross(spin))),
        "momentum of the sphere": Equation(tuple(driven), tuple(driven.cross(spin))),
        "normal": Equation(gamma, tuple(epsilon * normal.cross(spin - swirl))),
    },
    integrals={
        "energy": (momentum.dot(spin) + driven.dot(swirl)) / 2,
        "momentum squared": whole.dot(whole),
        "momentum of the sphere squared": driven.dot(driven),
        "product of the momenta": whole.dot(driven),
    },
    measure=Measure(sp.sqrt(1 - share), (*gamma, *omega, *wheel)),
    essential=(*place, *omega, *wheel),
    scenes={
        "default": Scene(
            initial={
                theta: 1,
                turns[1]: 1,
                place[2]: 1,
                **dict(zip(omega, (sp.Rational(1, 2), 0, 1), strict=True)),
                wheel[1]: sp.Rational(1, 5),
            },
            times=(0.0, 40.0),
            outputs=(*(ball.matrix * sp.Matrix(place)), *omega, *wheel),
            caption="The ball drives the sphere and is driven; the contact, seen from space.",
        ),
    },
    shapes=(
        Shape.ball(
            R2,
            centre=(R1 + R2) * outwards,
            attitude=ball.matrix,
            contact=R1 * outwards,
        ),
        Shape.ball(R1, attitude=sphere.matrix, role="ground"),
    ),
    references=("Bychkov2004", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation(
        "gyroscopic-ball-on-sphere",
        "ball-on-free-sphere",
        state={
            **{q: q for q in (*omega, *gamma)},
            **dict(zip(wheel, -R2 / (R1 - R2) * across(spin), strict=True)),
        },
        parameters={
            R1: (R1 - R2) / 2,
            R2: R2,
            m: 2 * m,
            J: m * (R1 - R2) ** 2 / 2,
            **{q: q for q in (*inertia, *kappa)},
        },
        note="N = 0 and J = m R1^2",
    ),
)

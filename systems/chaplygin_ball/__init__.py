"""Chaplygin's ball: a balanced, dynamically non-symmetric ball rolling on a plane.

The configuration is given by Euler angles (zxz) and the point of contact; the equations descend to
gamma, the vertical as seen from the ball, and read, with G the angular momentum about the contact,

    Gdot = G x omega,   gammadot = gamma x omega,   G = I omega + D (omega - (omega, gamma) gamma),

where D = m R^2 [Chaplygin1903].
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
    Case,
    Fibration,
    Frame,
    Parameter,
    Scene,
    Shape,
    System,
    kinematics,
    velocity,
)

x, y, phi, theta, psi = sp.symbols("x y phi theta psi")
m, R = sp.symbols("m R")
inertia = sp.symbols("I1 I2 I3")

rotation = kinematics.Rotation.euler("zxz", phi, theta, psi)
rates = rotation.space_rates
vertical = rotation.matrix.row(2)  # gamma = R^T e_z
motion = kinematics.BallMotion(inertia, m * R**2)
omega, gamma = motion.spin, motion.normal

SYSTEM = System(
    name="chaplygin-ball",
    title="Chaplygin ball on a plane",
    description="A balanced, dynamically non-symmetric ball rolls without slipping on a plane.",
    sketch=kinematics.rolling_sketch(attitude=(phi, theta, psi), place=(x, y)),
    fibration=Fibration(base=(phi, theta, psi), fibre=(x, y)),
    frame=Frame.quasi(dict(zip(omega, rotation.body_rates, strict=True))),
    lagrangian=kinematics.kinetic_energy(
        m, (velocity(x), velocity(y), 0), inertia, rotation.body_rates
    ),
    # The material point at the contact rests: w + omega x (-R e_z) = 0.
    constraints=(velocity(x) - R * rates[1], velocity(y) + R * rates[0]),
    meanings={
        **kinematics.euler_meanings((phi, theta, psi)),
        x: "first coordinate of the contact on the plane",
        y: "second coordinate of the contact on the plane",
        **kinematics.vector_meanings(omega, whose="the ball"),
        **kinematics.vector_meanings(map(str, gamma), "the vertical", "the ball"),
        "momentum squared": "square of the angular momentum about the contact",
        "vertical momentum": "vertical part of the angular momentum about the contact",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        *Parameter.each(inertia, ("0.4", "0.5", "0.7"), positive=True, meaning="principal moment"),
    ),
    invariants=dict(zip(map(str, gamma), vertical, strict=True)),
    equations=motion.equations,
    integrals=motion.integrals,
    measure=motion.measure,
    poisson=motion.poisson,
    integrable="Euler-Jacobi",
    essential=(theta, psi, *omega),
    cases={
        # The factor sin(theta) is the volume of the rotation group.
        "in Euler angles": Case(
            parameters={},
            measure=motion.density.xreplace(dict(zip(gamma, vertical, strict=True)))
            * sp.sin(theta),
            note="the same measure, with the coordinates of the contact",
        ),
    },
    scenes={
        "default": Scene(
            initial={theta: 1, **dict(zip(omega, ("1/2", 2, 0.2), strict=True))},
            times=(0.0, 40.0),
            outputs=(x, y, *omega),
            caption="The ball spins about a direction close to its middle axis, and wanders.",
        ),
    },
    bodies=(Body(m, (velocity(x), velocity(y), 0), inertia, rotation.body_rates, title="ball"),),
    shapes=(
        Shape.ball(R, centre=(x, y, R), attitude=rotation.matrix, contact=(x, y, 0)),
        Shape.plane(),
    ),
    references=("Chaplygin1903", "BorisovMamaev2001", "BorisovMamaev2002"),
)

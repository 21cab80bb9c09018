"""A spherical robot: a shell that rolls on a plane, driven by a pendulum hung at its centre.

The shell has the radius R, the mass M and the moment J about its centre O; it rolls without
slipping.  A pendulum of length l and mass m hangs at O; its direction is d = (sin alpha,
-cos alpha sin beta, -cos alpha cos beta), downwards for alpha = beta = 0.  Motors turn it with the
torque T = (T1, T2, 0) against the shell, and the shell with -T.  With the velocity V of O,

    ((M + m + J/R^2) V + m l d')' = (e3 x T)/R    horizontally,    Omega3' = 0.

So the shell moves as a mass M + J/R^2 that slides on the plane.  Without motors the momentum is
constant, and so is the area that the pendulum sweeps over the plane, d1 d2' - d2 d1': the pendulum
swings as a spherical one whose pivot gives way.  With a gyroscope of Lagrange in the place of the
pendulum the system is that of [BorisovMamaev2012].
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Case,
    Equation,
    Fibration,
    Frame,
    Parameter,
    Scene,
    Shape,
    Sketch,
    System,
    kinematics,
    time,
    velocity,
)

x, y, phi, theta, psi, alpha, beta = sp.symbols("x y phi theta psi alpha beta")
a, b = sp.symbols("a b")
omega = sp.symbols("Omega1:4")
M, R, J, m, l, g = sp.symbols("M R J m l g")  # noqa: E741
T1, T2 = sp.symbols("T1 T2")
up = sp.Matrix([0, 0, 1])

rotation = kinematics.Rotation.euler("zxz", phi, theta, psi)
direction = sp.Matrix([sp.sin(alpha), -sp.cos(alpha) * sp.sin(beta), -sp.cos(alpha) * sp.cos(beta)])
swing = direction.diff(alpha) * velocity(alpha) + direction.diff(beta) * velocity(beta)
centre_velocity = sp.Matrix([velocity(x), velocity(y), 0])
bob_velocity = centre_velocity + l * swing
kinetic = (
    kinematics.kinetic_energy(M, centre_velocity, (J, J, J), rotation.space_rates)
    + m * bob_velocity.dot(bob_velocity) / 2
)
potential = m * g * l * direction[2]
torque = sp.Matrix([T1, T2, 0])
work = [torque.dot(direction.cross(direction.diff(q))) for q in (alpha, beta)]
momentum = (M + J / R**2) * centre_velocity + m * bob_velocity
centre = sp.Matrix([x, y, R])
turn_of_axes = sp.Matrix([[0, 0, 1], [1, 0, 0], [0, 1, 0]])

SKETCH = (
    Sketch("seen from the side")
    .line((-1.7, -1.0), (1.7, -1.0))
    .ellipse((0, 0), 1.0, 1.0)
    .line((0, 0), (0.0, -0.85), look="dashed")
    .line((0, 0), (0.4, -0.6))
    .ellipse((0.4, -0.6), 0.12, 0.12)
    .angle((0, 0), 0.45, -90, -56, alpha)
    .arrow((0, 0), (-0.45, 0.75))
    .angle((0, 0), 0.5, 90, 121, theta)
    .line((0, 0), (0.0, 1.3), look="dashed")
    .turn((0.0, 1.2), 90, 0.2, phi)
    .turn((-0.39, 0.65), 121, 0.18, psi)
    .line((0, 0), (0.85, 0.0), look="dashed")
    .turn((0.75, 0.0), 0, 0.15, beta)
    .dot((0, 0), "O", 20)
    .dot((0.0, -1.0), "(x, y)", -90)
)

SYSTEM = System(
    name="spherical-robot",
    title="Spherical robot with a pendulum",
    description="A spherical shell rolls without slipping on a plane; motors swing a pendulum that "
    "hangs at its centre.",
    sketch=SKETCH,
    fibration=Fibration(base=(phi, theta, psi, alpha, beta), fibre=(x, y)),
    frame=Frame.quasi(
        {
            **dict(zip(omega, rotation.space_rates, strict=True)),
            a: velocity(alpha),
            b: velocity(beta),
        }
    ),
    lagrangian=kinetic - potential,
    constraints=(
        velocity(x) - R * rotation.space_rates[1],
        velocity(y) + R * rotation.space_rates[0],
    ),
    inputs=(T1, T2),
    forces={omega[0]: -T1, omega[1]: -T2, a: work[0], b: work[1]},
    meanings={
        **kinematics.place_meanings((x, y), "the contact on the plane"),
        **kinematics.euler_meanings((phi, theta, psi)),
        alpha: "tilt of the pendulum towards the first axis",
        beta: "tilt of the pendulum about the first axis",
        **{
            w: f"angular velocity of the shell along axis {k} of space"
            for k, w in enumerate(omega, 1)
        },
        a: "rate of alpha",
        b: "rate of beta",
        T1: "torque of the motors on the pendulum, along the first axis of space",
        T2: "torque of the motors on the pendulum, along the second axis of space",
        "spin": "angular velocity of the shell about the vertical",
    },
    parameters=(
        Parameter(M, 1, positive=True, meaning="mass of the shell"),
        Parameter(R, "1/2", positive=True, meaning="radius of the shell"),
        Parameter(J, "1/6", positive=True, meaning="moment of the shell about its centre"),
        Parameter(m, 2, positive=True, meaning="mass of the pendulum"),
        Parameter(l, "3/10", positive=True, meaning="length of the pendulum"),
        Parameter(g, 10, meaning="gravity"),
    ),
    integrals={"spin": omega[2]},
    equations={
        "momentum": Equation(tuple(momentum[:2]), (-T2 / R, T1 / R)),
    },
    cases={
        "without motors": Case(
            parameters={T1: 0, T2: 0},
            integrals={
                "energy": kinetic + potential,
                "momentum, x": momentum[0],
                "momentum, y": momentum[1],
                "area": direction[0] * swing[1] - direction[1] * swing[0],
            },
            note="The pendulum swings, and the shell gives way.",
        ),
    },
    scenes={
        "default": Scene(
            initial={theta: 1, alpha: "1/2", b: 1},
            inputs={T1: 0, T2: 0},
            times=(0.0, 10.0),
            outputs=(x, y, alpha, beta),
            caption="The shell gives way while the pendulum swings around.",
        ),
        "driven": Scene(
            initial={theta: 1},
            inputs={T1: sp.cos(time) / 10, T2: "-1/5"},
            times=(0.0, 10.0),
            outputs=(x, y, alpha, beta),
            caption="Motors hold the pendulum ahead, and the robot speeds up in a winding line.",
        ),
    },
    shapes=(
        *(
            Shape.torus(
                R * sp.Rational(24, 25),
                R / 25,
                centre=centre,
                attitude=rotation.matrix * turn_of_axes**k,
                contact=(x, y, 0) if k == 0 else None,
            )
            for k in range(3)  # rings for the shell, which hides the pendulum
        ),
        Shape.ball(R / 6, centre=centre + l * direction),
        Shape.plane(),
    ),
    references=("BorisovMamaev2012",),
)

"""The ball on a turntable, seen from the table: constraints that depend on the time.

(X, Y) is the point of contact in axes that turn with the table, by the angle Omega t; the attitude
is that in space.  The contact's trace on the table is what the ball's spin, seen from the table,
rolls off, so the constraints are homogeneous, but hold the time.  The centre's circle of the
frequency q Omega, seen from axes of the frequency Omega, is the trace of a point of a rolling
circle.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Equation,
    Fibration,
    Frame,
    Parameter,
    Relation,
    Scene,
    Shape,
    System,
    kinematics,
    time,
    velocity,
)

X, Y, phi, theta, psi = sp.symbols("X Y phi theta psi")
VX, VY, n = sp.symbols("VX VY n")
m, R, A, Omega = sp.symbols("m R A Omega")
DX, DY = velocity(X), velocity(Y)

rotation = kinematics.Rotation.euler("zxz", phi, theta, psi)
rates = rotation.space_rates
cos, sin = sp.cos(Omega * time), sp.sin(Omega * time)
q = A / (A + m * R**2)

# Along the axes of the table: the angular velocity, and the velocity of the centre in space.
along, across = cos * rates[0] + sin * rates[1], cos * rates[1] - sin * rates[0]
centre = (VX - Omega * Y, VY + Omega * X)
place = (cos * X - sin * Y, sin * X + cos * Y)
space_velocity = (cos * centre[0] - sin * centre[1], sin * centre[0] + cos * centre[1])

SYSTEM = System(
    name="ball-on-turntable-in-time",
    title="Ball on a turntable, seen from the table",
    description="A balanced symmetric ball on a table that turns uniformly, in the axes of the "
    "table: the constraints depend on the time.",
    sketch=kinematics.rolling_sketch(
        on="table", attitude=(phi, theta, psi), place=(X, Y), spin=Omega
    ),
    fibration=Fibration(base=(phi, theta, psi), fibre=(X, Y)),
    frame=Frame.quasi({VX: DX, VY: DY, n: rates[2]}),
    lagrangian=kinematics.kinetic_energy(m, (DX - Omega * Y, DY + Omega * X, 0), (A, A, A), rates),
    constraints=(DX - R * across, DY + R * along),
    meanings={
        **kinematics.euler_meanings((phi, theta, psi)),
        **kinematics.place_meanings((X, Y), "the contact on the table"),
        VX: "velocity of the contact over the table, along its first axis",
        VY: "velocity of the contact over the table, along its second axis",
        n: "twist, the angular velocity about the vertical",
        "speed squared": "square of the speed of the centre in space",
        "twist": "angular velocity about the vertical",
        "centre of the circle, x": "place in space of the circle of the contact, times q Omega",
        "centre of the circle, y": "place in space of the circle of the contact, times q Omega",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        Parameter(A, "2/5", positive=True, meaning="moment of inertia"),
        Parameter(Omega, 1, meaning="angular velocity of the table"),
    ),
    integrals={
        "speed squared": centre[0] ** 2 + centre[1] ** 2,
        "twist": n,
        "centre of the circle, x": q * Omega * place[0] - space_velocity[1],
        "centre of the circle, y": q * Omega * place[1] + space_velocity[0],
    },
    equations={
        "Coriolis, centrifugal and magnetic": Equation(
            (VX, VY),
            (
                (2 - q) * Omega * VY + (1 - q) * Omega**2 * X,
                -(2 - q) * Omega * VX + (1 - q) * Omega**2 * Y,
            ),
        ),
    },
    measure=sp.sin(theta),
    essential=(X, Y, VX, VY),
    scenes={
        "default": Scene(
            initial={theta: 1, X: 1, VX: "1/5", VY: -1},
            times=(0.0, 45.0),
            outputs=(X, Y, n),
            caption="On the table the ball leaves the trace of a point of a rolling circle.",
        ),
    },
    shapes=(
        Shape.ball(R, centre=(*place, R), attitude=rotation.matrix, contact=(*place, 0)),
        Shape.plane(attitude=Omega * time),
    ),
    references=("NeimarkFufaev1972", "FassoSansonetto2016"),
)

attitude = {str(s): s for s in (phi, theta, psi, n)}

RELATIONS = (
    Relation.of(
        SYSTEM,
        "ball-on-turntable",
        state={
            **dict(zip(("x", "y", "vx", "vy"), (*place, *space_velocity), strict=True)),
            **attitude,
        },
        note="From the axes of the table to those of space, by a turn that depends on the time.",
    ),
)

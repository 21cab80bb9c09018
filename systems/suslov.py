"""Suslov's problem: a rigid body about a fixed point that cannot turn about an axis of its own.

omega3 = 0, with the axes of the body turned about the third so that I12 = 0.  With
M3 = I13 omega1 + I23 omega2, the angular momentum about the forbidden axis,

    I1 omega1' = -M3 omega2,    I2 omega2' = M3 omega1,    gamma' = gamma x omega    [Suslov1946].

Where the forbidden axis is no principal one the body goes over from one steady turning about the
axis M3 = 0 to the opposite one, so no measure is smooth there; where it is, the body turns
uniformly, the measure is smooth and nothing drifts.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
    Case,
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
)

phi, theta, psi = sp.symbols("phi theta psi")
omega1, omega2 = sp.symbols("omega1 omega2")
I1, I2, I3, I13, I23 = sp.symbols("I1 I2 I3 I13 I23")
gamma = sp.symbols("gamma1 gamma2 gamma3")

rotation = kinematics.Rotation.euler("zxz", phi, theta, psi)
rates = rotation.body_rates
inertia = sp.Matrix([[I1, 0, I13], [0, I2, I23], [I13, I23, I3]])

M3 = I13 * omega1 + I23 * omega2
vertical_rate = sp.Matrix(gamma).cross(sp.Matrix([omega1, omega2, 0]))

SYSTEM = System(
    name="suslov",
    title="Suslov problem",
    description="A rigid body turns about a fixed point, and does not turn about one of its axes.",
    sketch=kinematics.pinned_sketch((phi, theta, psi), still="no turn about the third axis"),
    fibration=Fibration(base=(phi, theta), fibre=(psi,)),
    frame=Frame.quasi({omega1: rates[0], omega2: rates[1]}),
    lagrangian=kinematics.kinetic_energy(0, (0, 0, 0), inertia, rates),
    constraints=(rates[2],),
    meanings={
        **kinematics.euler_meanings((phi, theta, psi)),
        **kinematics.vector_meanings((omega1, omega2)),
        **kinematics.vector_meanings(map(str, gamma), "the vertical"),
    },
    parameters=(
        Parameter(I1, 1, positive=True, meaning="moment about the first axis"),
        Parameter(I2, "3/2", positive=True, meaning="moment about the second axis"),
        Parameter(I3, 2, positive=True, meaning="moment about the forbidden axis"),
        Parameter(I13, "1/5", meaning="product of inertia, forbidden axis and first"),
        Parameter(I23, "2/5", meaning="product of inertia, forbidden axis and second"),
    ),
    invariants=dict(zip(("gamma1", "gamma2", "gamma3"), rotation.matrix.row(2), strict=True)),
    integrals={"energy": (I1 * omega1**2 + I2 * omega2**2) / 2},
    equations={
        "angular velocity": Equation((I1 * omega1, I2 * omega2), (-M3 * omega2, M3 * omega1)),
        "vertical": Equation(gamma, tuple(vertical_rate)),
    },
    measure=Measure(1 / M3, variables=(*gamma, omega1, omega2)),
    essential=(omega1, omega2),
    cases={
        "forbidden axis principal": Case(
            parameters={I13: 0, I23: 0},
            integrals={
                "omega1": omega1,
                "omega2": omega2,
                "vertical along the axis": gamma[0] * omega1 + gamma[1] * omega2,
            },
            measure=Measure(sp.Integer(1), variables=(*gamma, omega1, omega2)),
            integrable="Euler-Jacobi",
            note="The body turns uniformly about an axis fixed in it.",
        ),
    },
    scenes={
        "default": Scene(
            initial={theta: 1, omega1: 1, omega2: "-3/5"},
            times=(0.0, 60.0),
            outputs=(phi, theta, psi, omega1, omega2),
            caption="The body leaves one steady turning for the opposite one.",
        ),
        "principal": Scene(
            initial={theta: 1, omega1: 1, omega2: "-3/5"},
            parameters={I13: 0, I23: 0},
            times=(0.0, 20.0),
            outputs=(phi, theta, psi, omega1, omega2),
            caption="Where the forbidden axis is principal, the turning is steady.",
        ),
    },
    bodies=(Body(0, inertia=inertia, omega=rotation.body_rates),),
    shapes=(Shape.box((1, 0.7, 0.4), attitude=rotation.matrix),),
    references=("Suslov1946", "FedorovMaciejewskiPrzybylska2009", "Bloch2015"),
)

RELATIONS = (
    Relation.into(
        SYSTEM,
        "suslov",
        {omega1: -omega1, omega2: -omega2},
        clock=-1,
        name="suslov reversed",
        note="Time runs back: what attracts and what repels change places.",
    ),
)

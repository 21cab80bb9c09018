"""Suslov's problem in a potential, where the forbidden axis is a principal one.

The body turns about a fixed point with omega3 = 0; gamma is the vertical, and the potential is
(b, gamma) + (c1 gamma1^2 + c2 gamma2^2)/2: a weight, and a field of the second degree, in which
c3 = 0 since |gamma| = 1.  With V_i = b_i + c_i gamma_i

    I1 omega1' = gamma2 b3 - gamma3 V_2,    I2 omega2' = gamma3 V_1 - gamma1 b3,
    gamma' = gamma x omega.

Volume is conserved.  With the energy and one more integral the motion is integrable: one is linear
in the velocities where the centre of mass is across the forbidden axis, as Kharlamova found, or on
it and I1 = I2, as Kozlov found [Kozlov2002].  Where b3 = 0 the energy falls apart into two; without
weight this is the field of Clebsch and Tisserand [DragovicGajicJovanovic1998, Tsiganov2015].
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
moments = I1, I2, I3 = sp.symbols("I1:4")
b, c, gamma = sp.symbols("b1:4"), sp.symbols("c1 c2"), sp.symbols("gamma1:4")

rotation = kinematics.Rotation.euler("zxz", phi, theta, psi)
rates, vertical = rotation.body_rates, tuple(rotation.matrix.row(2))
potential = sum(bi * x for bi, x in zip(b, gamma, strict=True))
potential += sum(ci * x**2 / 2 for ci, x in zip(c, gamma, strict=False))
kinetic = (I1 * omega1**2 + I2 * omega2**2) / 2
first, second = (bi + ci * x for bi, ci, x in zip(b, c, gamma, strict=False))
slope = sp.Matrix([first, second, b[2]])
torque = tuple(sp.Matrix(vertical).cross(slope.xreplace(dict(zip(gamma, vertical, strict=True)))))
normal_rate = sp.Matrix(gamma).cross(sp.Matrix([omega1, omega2, 0]))

SYSTEM = System(
    name="suslov-in-potential",
    title="Suslov problem in a potential",
    description="A heavy body turns about a fixed point, and does not turn about one of its "
    "principal axes.",
    sketch=kinematics.pinned_sketch((phi, theta, psi), still="no turn about the third axis"),
    fibration=Fibration(base=(phi, theta), fibre=(psi,)),
    frame=Frame.quasi({omega1: rates[0], omega2: rates[1]}),
    lagrangian=kinematics.kinetic_energy(0, (0, 0, 0), moments, rates)
    - potential.xreplace(dict(zip(gamma, vertical, strict=True))),
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
        *Parameter.each(b, ("1/2", "1/5", 1), meaning="weight times the centre of mass"),
        *Parameter.each(c, (0, 0), meaning="strength of a field of the second degree"),
    ),
    invariants=dict(zip(map(str, gamma), vertical, strict=True)),
    integrals={"energy": kinetic + potential},
    equations={
        "angular velocity": Equation(
            (I1 * omega1, I2 * omega2),
            (gamma[1] * b[2] - gamma[2] * second, gamma[2] * first - gamma[0] * b[2]),
        ),
        "vertical": Equation(gamma, tuple(normal_rate)),
    },
    measure=Measure(sp.Integer(1), variables=(*gamma, omega1, omega2)),
    essential=(theta, psi, omega1, omega2),
    cases={
        "Kharlamova": Case(
            parameters={b[2]: 0, c[0]: 0, c[1]: 0},
            integrals={"momentum of the weight": b[0] * I1 * omega1 + b[1] * I2 * omega2},
            integrable="Euler-Jacobi",
            note="the centre of mass is across the forbidden axis",
        ),
        "Kozlov": Case(
            parameters={I2: I1, b[0]: 0, b[1]: 0, c[1]: c[0]},
            integrals={"vertical momentum": gamma[0] * omega1 + gamma[1] * omega2},
            integrable="Euler-Jacobi",
            note="the body and the field are symmetric about the forbidden axis",
        ),
        "Clebsch-Tisserand": Case(
            parameters={b[2]: 0},
            integrals={
                "first energy": I2 * omega2**2 / 2 + b[0] * gamma[0] + c[0] * gamma[0] ** 2 / 2,
                "second energy": I1 * omega1**2 / 2 + b[1] * gamma[1] + c[1] * gamma[1] ** 2 / 2,
            },
            integrable="Euler-Jacobi",
            note="the weight across the forbidden axis, and any field of the second degree",
        ),
    },
    scenes={
        "default": Scene(
            initial={theta: 1, omega1: 1, omega2: "-3/5"},
            times=(0.0, 30.0),
            outputs=(phi, theta, psi, omega1, omega2),
            caption="A heavy body that cannot turn about its third axis.",
        ),
    },
    bodies=(Body(0, inertia=moments, omega=rates, torque=torque),),
    shapes=(Shape.box((1, 0.7, 0.4), attitude=rotation.matrix),),
    references=("DragovicGajicJovanovic1998", "Kozlov2002", "Tsiganov2015"),
)

RELATIONS = (
    Relation.of(
        SYSTEM, "suslov", {"I13": 0, "I23": 0}, vanish=(*b, *c), note="without weight or field"
    ),
)

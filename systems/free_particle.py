"""A free particle in the plane: no constraint, straight lines run through uniformly.

Several nonholonomic systems are this one in other coordinates and, it may be, another time.  And it
occurs in others: a homogeneous body keeps its angular velocity; where that is omega = (X', Y', 0),
and level, the vertical gamma goes round it with the speed |omega|, which is also the rate of the
angle (X X' + Y Y')/|omega| along straight lines.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
    Equation,
    Fibration,
    Parameter,
    Relation,
    Scene,
    Shape,
    Sketch,
    System,
    velocity,
)

X, Y = sp.symbols("X Y")
m = sp.Symbol("m")
DX, DY = velocity(X), velocity(Y)

kinetic = m * (DX**2 + DY**2) / 2

SKETCH = (
    Sketch("seen from above").axes(X, Y).dot((1.1, 0.7), "(X, Y)").arrow((1.1, 0.7), (1.7, 0.95))
)

SYSTEM = System(
    name="free-particle",
    title="Free particle in the plane",
    description="A particle without constraint and without force.",
    sketch=SKETCH,
    fibration=Fibration(base=(X, Y)),
    lagrangian=kinetic,
    meanings={
        X: "first Cartesian coordinate",
        Y: "second Cartesian coordinate",
        "velocity, X": "first component of the velocity",
        "velocity, Y": "second component of the velocity",
        "moment of the velocity": "twice the rate at which the area is swept",
    },
    parameters=(Parameter(m, 1, positive=True, meaning="mass"),),
    integrals={
        "energy": kinetic,
        "velocity, X": DX,
        "velocity, Y": DY,
        "moment of the velocity": X * DY - Y * DX,
    },
    equations={"acceleration": Equation((DX, DY), (0, 0))},
    measure=sp.Integer(1),
    multiplier=sp.Integer(1),
    essential=(DX, DY),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={Y: "-1/2", DX: 1, DY: "1/5"},
            times=(0.0, 5.0),
            outputs=(X, Y),
            caption="A straight line.",
        ),
    },
    bodies=(Body(m, (DX, DY, 0), title="particle"),),
    shapes=(Shape.ball(0.25, centre=(X, Y, 0), contact=(X, Y, 0)), Shape.plane()),
    references=("Chaplygin1911",),
)

# The third axis is upright where the line is nearest to (0, 0).  X' and Y' must not both be 0.
speed = sp.sqrt(DX**2 + DY**2)
angle = (X * DX + Y * DY) / speed
uniform_turn = {
    "gamma1": -DY / speed * sp.sin(angle),
    "gamma2": DX / speed * sp.sin(angle),
    "gamma3": sp.cos(angle),
    "omega1": DX,
    "omega2": DY,
}

RELATIONS = (
    Relation(
        "free-particle",
        "suslov",
        state=uniform_turn,
        parameters={"I1": m, "I2": m, "I3": m, "I13": 0, "I23": 0},
        note="A homogeneous body turns uniformly.",
    ),
    Relation(
        "free-particle",
        "homogeneous-ball",
        state={**uniform_turn, "omega3": 0},
        parameters={"m": m, "R": 1, "A": m},
        note="A ball rolls straight on, about an axis of its own that stays level.",
    ),
    Relation(
        "free-particle",
        "veselova",
        state=uniform_turn,
        parameters={"J1": m, "J2": m, "J3": m},
        note="A homogeneous body turns uniformly about a level axis.",
    ),
)

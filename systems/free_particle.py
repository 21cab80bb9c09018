"""A free particle in the plane: no constraint, straight lines run through uniformly.

Several nonholonomic systems are this one in other coordinates and, it may be, another time.
"""

from __future__ import annotations

import sympy as sp

from voronec import Equation, Fibration, Parameter, Scene, System, velocity

X, Y = sp.symbols("X Y")
m = sp.Symbol("m")
DX, DY = velocity(X), velocity(Y)

kinetic = m * (DX**2 + DY**2) / 2

SYSTEM = System(
    name="free-particle",
    title="Free particle in the plane",
    description="A particle without constraint and without force.",
    fibration=Fibration(base=(X, Y)),
    lagrangian=kinetic,
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
            initial={Y: sp.Rational(-1, 2), DX: 1, DY: sp.Rational(1, 5)},
            times=(0.0, 5.0),
            outputs=(X, Y),
            caption="A straight line.",
        ),
    },
    references=("Chaplygin1911",),
)

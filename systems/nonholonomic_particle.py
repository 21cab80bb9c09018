"""The nonholonomic particle: free in space but for the constraint zdot = y xdot.

On the constraint the energy is m ((1 + y^2) xdot^2 + ydot^2)/2, and

    (1 + y^2) xddot + y xdot ydot = 0,    yddot = 0    [Rosenberg1977].

With dtau = dt/sqrt(1 + y^2) these are the geodesics of a flat plane, with the Cartesian coordinates
x and asinh(y): the particle is free in another time.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
    Equation,
    Fibration,
    Parameter,
    Poisson,
    Relation,
    Scene,
    Shape,
    Sketch,
    System,
    velocity,
)

x, y, z, m = sp.symbols("x y z m")
Dx, Dy, Dz = map(velocity, (x, y, z))
root = sp.sqrt(1 + y**2)
X, Y, px, py = sp.symbols("X Y px py")
scale = sp.sqrt(1 + Y**2)

kinetic = m * (Dx**2 + Dy**2 + Dz**2) / 2

SKETCH = (
    Sketch("seen from the side")
    .axes(x, z, size=1.6)
    .arrow((0.0, 0.0), (0.75, 0.5), y)
    .line((0.9, 0.0), (1.4, 0.33), (1.4, 1.2), look="dashed")
    .line((0.5, 0.33), (1.4, 0.33), look="dashed")
    .dot((1.4, 1.2), "(x, y, z)", 150)
    .arrow((1.4, 1.2), (2.0, 1.35))
)

SYSTEM = System(
    name="nonholonomic-particle",
    title="Nonholonomic particle",
    description="A particle in space, free but for one constraint, zdot = y xdot.",
    sketch=SKETCH,
    fibration=Fibration(base=(x, y), fibre=(z,)),
    lagrangian=kinetic,
    constraints=(Dz - y * Dx,),
    meanings={
        x: "first Cartesian coordinate",
        y: "second Cartesian coordinate, the slope of the motion in x and z",
        z: "third Cartesian coordinate",
        "along y": "velocity along y",
        "along the constraint": "speed in the plane of x and z",
        "place, x": "x where y = 0, times the velocity along y",
        "place, z": "z times the velocity along y, less (1 + y^2) times that along x",
    },
    parameters=(Parameter(m, 1, positive=True, meaning="mass"),),
    invariants={"X": x, "Y": y},
    # Energy and four others, of which any three with one of the first three: all there can be.
    integrals={
        "energy": kinetic,
        "along y": Dy,
        "along the constraint": root * Dx,
        "place, x": x * Dy - root * sp.asinh(y) * Dx,
        "place, z": z * Dy - root**2 * Dx,
    },
    equations={
        "x": Equation((1 + y**2) * Dx, y * Dx * Dy),
        "y": Equation(Dy, sp.Integer(0)),
    },
    measure=root,
    multiplier=1 / root,
    # Chaplygin's Hamiltonian form: the momenta of the Lagrangian in the other time.
    poisson=Poisson(
        variables={X: X, Y: Y, px: m * scale * Dx, py: m * Dy / scale},
        bracket={(X, px): 1, (Y, py): 1},
        hamiltonian=(px**2 + (1 + Y**2) * py**2) / (2 * m),
        clock=1 / scale,
    ),
    essential=(y, Dx, Dy),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={y: -2, Dx: 1, Dy: "1/2"},
            times=(0.0, 8.0),
            outputs=(x, y, z),
            caption="While y grows uniformly, z falls and rises again along a hyperbola.",
        ),
    },
    bodies=(Body(m, (Dx, Dy, Dz), title="particle"),),
    shapes=(Shape.ball(0.1, centre=(x, y, z), contact=(x, y, z)),),
    references=("Rosenberg1977", "BatesSniatycki1993", "Chaplygin1911"),
)

RELATIONS = (
    Relation.of(
        SYSTEM,
        "free-particle",
        state={"X": x, "Y": sp.asinh(y), "Xdot": root * Dx, "Ydot": Dy},
        clock=1 / root,
        note="Chaplygin's change of time, by the reducing multiplier.",
    ),
)

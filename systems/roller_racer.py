"""The roller racer: a seat and a handle on one pair of wheels each, joined by a hinge.

The seat's axle is at (x, y) and heads along theta; the hinge is at the distance ``a`` before it.
The handle is turned by phi against the seat, and its axle is at the distance b beyond the hinge.
Neither axle slips sideways; the handle's mass is neglected against its moment of inertia.  With the
speed v of the seat and its rate of turning w

    b phi' = v sin(phi) - (a cos(phi) + b) w,

and the handle turns, against the ground, by u/b, u = v sin(phi) - a w cos(phi).  With the rider's
hands off the handle it goes over into a steady run round a circle
[KrishnaprasadTsakiris2001, Bizyaev2017].  Speed and turning are a frame everywhere; the speed and
the handle's rate, which is what a rider moves, are none where a cos(phi) + b = 0.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
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
    velocity,
)

x, y, theta, phi = sp.symbols("x y theta phi")
v, w = sp.symbols("v w")
m, I1, I2, a, b = sp.symbols("m I1 I2 a b")
Dx, Dy, Dtheta, Dphi = map(velocity, (x, y, theta, phi))

handle = Dtheta + Dphi
# The hinge's velocity.
hinge = (Dx - a * Dtheta * sp.sin(theta), Dy + a * Dtheta * sp.cos(theta))
kinetic = (m * (Dx**2 + Dy**2) + I1 * Dtheta**2 + I2 * handle**2) / 2
u = v * sp.sin(phi) - a * w * sp.cos(phi)

SKETCH = (
    Sketch("seen from above")
    .axes(x, y, size=0.8)
    .box((1.3, 0.95), 0.9, 0.7, 30)
    .line((1.3, 0.95), (2.77, 1.8))
    .line((2.77, 1.8), (3.15, 2.72))
    .line((1.52, 0.57), (1.08, 1.33))
    .wheel((1.52, 0.57), 30, 0.5)
    .wheel((1.08, 1.33), 30, 0.5)
    .line((3.52, 2.57), (2.78, 2.87))
    .wheel((3.52, 2.57), 68, 0.5)
    .wheel((2.78, 2.87), 68, 0.5)
    .line((1.3, 0.95), (2.9, 0.95), look="dashed")
    .line((2.77, 1.8), (3.9, 2.45), look="dashed")
    .angle((1.3, 0.95), 1.25, 0, 30, theta)
    .angle((2.77, 1.8), 0.6, 30, 68, phi)
    .dot((1.3, 0.95))
    .text((0.62, 0.42), "(x, y)")
    .dot((2.77, 1.8), "hinge", -40)
    .distance((1.3, 0.95), (2.77, 1.8), a, 0.55)
    .distance((2.77, 1.8), (3.15, 2.72), b, 0.65)
)
# The middles of the axles, and the hinge, at a height to draw them at.
seat = sp.Matrix([x, y, 0.1])
pin = seat + a * sp.Matrix([sp.cos(theta), sp.sin(theta), 0])
grip = pin + b * sp.Matrix([sp.cos(theta + phi), sp.sin(theta + phi), 0])
down = sp.Matrix([0, 0, 0.1])

SYSTEM = System(
    name="roller-racer",
    title="Roller racer",
    description="Two bodies on an axle each, which do not slip sideways, are joined by a hinge.",
    sketch=SKETCH,
    fibration=Fibration(base=(x, theta), fibre=(y, phi)),
    frame=Frame.quasi({v: Dx * sp.cos(theta) + Dy * sp.sin(theta), w: Dtheta}),
    lagrangian=kinetic,
    constraints=(
        Dx * sp.sin(theta) - Dy * sp.cos(theta),
        hinge[1] * sp.cos(theta + phi) - hinge[0] * sp.sin(theta + phi) + b * handle,
    ),
    meanings={
        **kinematics.place_meanings((x, y), "the middle of the seat's axle"),
        theta: "heading of the seat, from the first axis",
        phi: "angle of the handle against the seat",
        v: "speed of the seat",
        w: "rate of turning of the seat",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(I1, 1, positive=True, meaning="inertia of the seat"),
        Parameter(I2, "1/5", lower=0, meaning="inertia of the handle"),
        Parameter(a, 1, meaning="from the seat's axle to the hinge"),
        Parameter(b, "3/10", meaning="from the hinge to the handle's axle"),
    ),
    invariants={"sine": sp.sin(phi), "cosine": sp.cos(phi)},
    integrals={"energy": kinetic},
    equations={
        "handle": Equation(b * phi, v * sp.sin(phi) - (a * sp.cos(phi) + b) * w),
    },
    essential=(phi, v, w),
    cases={
        "hinge on the axle": Case(
            parameters={a: 0},
            integrals={"turning": w, "way": (m * b**2 + I2 * sp.sin(phi) ** 2) * v**2},
            note="A robot with one trailer.",
        ),
        "light handle": Case(
            parameters={I2: 0},
            integrals={
                "speed": v,
                "turning": w,
                "centre of the circle, x": x * w - v * sp.sin(theta),
                "centre of the circle, y": y * w + v * sp.cos(theta),
            },
            note="The seat goes round as if it were alone.",
        ),
    },
    scenes={
        "default": Scene(
            initial={phi: "1/2", v: 1},
            times=(0.0, 20.0),
            outputs=(x, y, theta, phi, v, w),
            caption="The handle folds back, and the racer goes over into a run round a circle.",
        ),
    },
    bodies=(
        Body(m, (Dx, Dy, 0), (0, 0, I1), (0, 0, Dtheta), title="seat"),
        Body(0, inertia=(0, 0, I2), omega=(0, 0, handle), title="handle"),
    ),
    shapes=(
        Shape.box((a, 0.1, 0.1), centre=(seat + pin) / 2, attitude=theta),
        Shape.box((0.1, 0.6, 0.2), centre=seat, attitude=theta, contact=seat - down),
        Shape.box((b, 0.1, 0.1), centre=(pin + grip) / 2, attitude=theta + phi),
        Shape.box((0.1, 0.5, 0.2), centre=grip, attitude=theta + phi, contact=grip - down),
        Shape.plane(),
    ),
    references=("KrishnaprasadTsakiris2001", "Bizyaev2017"),
)

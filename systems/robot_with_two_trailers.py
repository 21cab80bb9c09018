"""A robot with two trailers: three axles in a row, none of which slips sideways.

The robot's axle is at (x, y) and heads along theta0; each trailer is hitched to the middle of the
axle before it by a bar of length l1, l2, and heads along theta1, theta2.  Every body has its mass
in the middle of its axle and a moment of inertia about it.  With the robot's speed v and its rate
of turning w, and alpha = theta0 - theta1, beta = theta1 - theta2,

    w' = 0,    l1 theta1' = v sin(alpha),    l2 theta2' = v cos(alpha) sin(beta),

and v^2 times the mass that is to be moved along,

    m0 + J1 sin(alpha)^2/l1^2 + cos(alpha)^2 (m1 + J2 sin(beta)^2/l2^2 + m2 cos(beta)^2),

is constant: only differences of the headings matter [Laumond1993].
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
    velocity,
)

x, y = sp.symbols("x y")
headings = theta0, theta1, theta2 = sp.symbols("theta0:3")
v, w = sp.symbols("v w")
masses = m0, m1, m2 = sp.symbols("m0:3")
moments = J0, J1, J2 = sp.symbols("J0:3")
bars = l1, l2 = sp.symbols("l1:3")

kinetic = sp.Integer(0)
constraints = []
pace = [velocity(x), velocity(y)]  # of the middle of an axle, from the first to the last
for body, heading in enumerate(headings):
    turning = velocity(heading)
    if body:
        pace[0] += bars[body - 1] * turning * sp.sin(heading)
        pace[1] -= bars[body - 1] * turning * sp.cos(heading)
    kinetic += (masses[body] * (pace[0] ** 2 + pace[1] ** 2) + moments[body] * turning**2) / 2
    constraints.append(pace[0] * sp.sin(heading) - pace[1] * sp.cos(heading))

forward = velocity(x) * sp.cos(theta0) + velocity(y) * sp.sin(theta0)
alpha, beta = theta0 - theta1, theta1 - theta2
mass_along = m0 + J1 * sp.sin(alpha) ** 2 / l1**2
mass_along += sp.cos(alpha) ** 2 * (m1 + J2 * sp.sin(beta) ** 2 / l2**2 + m2 * sp.cos(beta) ** 2)

SKETCH = (
    Sketch("seen from above")
    .axes(x, y, at=(-0.6, -0.4), size=0.8)
    .box((3.35, 1.55), 1.0, 0.75, 40)
    .box((1.6, 0.67), 0.8, 0.7, 22)
    .box((0.0, 0.5), 0.8, 0.7, 6)
    .line((0.0, 0.5), (1.6, 0.67), (3.15, 1.3))
    .wheel((3.4, 0.99), 40, 0.5)
    .wheel((2.9, 1.6), 40, 0.5)
    .wheel((1.75, 0.3), 22, 0.5)
    .wheel((1.45, 1.04), 22, 0.5)
    .wheel((0.04, 0.1), 6, 0.5)
    .wheel((-0.04, 0.9), 6, 0.5)
    .line((3.15, 1.3), (4.6, 1.3), look="dashed")
    .line((3.15, 1.3), (4.4, 2.35), look="dashed")
    .line((1.6, 0.67), (2.9, 0.67), look="dashed")
    .line((0.0, 0.5), (1.2, 0.5), look="dashed")
    .angle((3.15, 1.3), 1.1, 0, 40, theta0)
    .angle((1.6, 0.67), 1.05, 0, 22, theta1)
    .angle((0.0, 0.5), 1.0, 0, 6, theta2)
    .dot((3.15, 1.3), "(x, y)", -90)
    .distance((1.6, 0.67), (3.15, 1.3), l1, 0.55)
    .distance((0.0, 0.5), (1.6, 0.67), l2, 0.6)
)
axles, rods, down = [sp.Matrix([x, y, 0.1])], [], sp.Matrix([0, 0, 0.1])
for bar, heading in zip(bars, headings[1:], strict=True):
    before = axles[-1]
    axles.append(before - bar * sp.Matrix([sp.cos(heading), sp.sin(heading), 0]))
    middle = (before + axles[-1]) / 2
    rods.append(Shape.box((bar, 0.06, 0.06), centre=middle, attitude=heading))

SYSTEM = System(
    name="robot-with-two-trailers",
    title="Robot with two trailers",
    description="A robot on an axle that does not slip sideways pulls two trailers, each hitched "
    "to the middle of the axle before it.",
    sketch=SKETCH,
    fibration=Fibration(base=(x, theta0), fibre=(y, theta1, theta2)),
    frame=Frame.quasi({v: forward, w: velocity(theta0)}),
    lagrangian=kinetic,
    constraints=tuple(constraints),
    meanings={
        **kinematics.place_meanings((x, y), "the middle of the robot's axle"),
        theta0: "heading of the robot, from the first axis",
        theta1: "heading of the first trailer",
        theta2: "heading of the second trailer",
        v: "speed of the robot",
        w: "rate of turning of the robot",
        "turning": "rate of turning of the robot",
        "way": "square of the speed times the mass that is to be moved along",
    },
    parameters=(
        Parameter(m0, 1, positive=True, meaning="mass of the robot"),
        Parameter(m1, "1/2", lower=0, meaning="mass of the first trailer"),
        Parameter(m2, "1/2", lower=0, meaning="mass of the second trailer"),
        Parameter(J0, "1/5", positive=True, meaning="inertia of the robot"),
        Parameter(J1, "1/10", lower=0, meaning="inertia of the first trailer"),
        Parameter(J2, "1/10", lower=0, meaning="inertia of the second trailer"),
        Parameter(l1, 1, positive=True, meaning="length of the first bar"),
        Parameter(l2, 1, positive=True, meaning="length of the second bar"),
    ),
    integrals={"energy": kinetic, "turning": w, "way": mass_along * v**2},
    equations={
        "first hitch": Equation(l1 * alpha, l1 * w - v * sp.sin(alpha)),
        "second hitch": Equation(
            l1 * l2 * beta, v * (l2 * sp.sin(alpha) - l1 * sp.cos(alpha) * sp.sin(beta))
        ),
    },
    essential=(theta0, theta1, theta2, v, w),
    cases={
        "light trailers": Case(
            parameters={m1: 0, m2: 0, J1: 0, J2: 0},
            integrals={
                "speed": v,
                "centre of the circle, x": x * w - v * sp.sin(theta0),
                "centre of the circle, y": y * w + v * sp.cos(theta0),
            },
            note="The robot goes round as if it were alone.",
        ),
    },
    scenes={
        "default": Scene(
            initial={theta1: "-1/2", theta2: "-3/2", v: 1, w: "3/5"},
            times=(0.0, 20.0),
            outputs=(x, y, theta0, theta1, theta2, v),
            caption="The trailers fall in line, and the three of them run round one centre.",
        ),
    },
    shapes=(
        *(
            Shape.box((0.3, 0.5, 0.2), centre=axle, attitude=heading, contact=axle - down)
            for axle, heading in zip(axles, headings, strict=True)
        ),
        *rods,
        Shape.plane(),
    ),
    references=("Laumond1993", "NeimarkFufaev1972"),
)

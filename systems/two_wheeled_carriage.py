"""The two-wheeled carriage: a body on a common axle of two wheels that roll without slipping.

The middle of the axle is over (x, y), the carriage heads along (cos phi, sin phi), and the centre
of mass is at the distance ``a`` before the axle.  The wheels, at the distance ``b`` to the left and
to the right, have turned by ``left`` and ``right``.  Three constraints: no slip sideways, and each
wheel's rim follows the ground; the difference of the latter two is integrable.  The body moves as
Chaplygin's sleigh, made heavier by the spin of its wheels [NeimarkFufaev1972].
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
    Sketch,
    Square,
    System,
    kinematics,
    velocity,
)

x, y, phi, left, right = sp.symbols("x y phi left right")
v, w = sp.symbols("v w")
m, J, a, b, R, C = sp.symbols("m J a b R C")
Dx, Dy, Dphi, Dleft, Dright = map(velocity, (x, y, phi, left, right))
cos, sin = sp.cos(phi), sp.sin(phi)

car = kinematics.Sleigh(m, J, a)
kinetic = car.kinetic + C * (Dleft**2 + Dright**2) / 2

# The inertia against driving and turning, the wheels' spin with it.
drive = m + 2 * C / R**2
turn = J + m * a**2 + 2 * C * b**2 / R**2
root = sp.sqrt(drive * turn)

SKETCH = (
    Sketch("seen from above")
    .axes(x, y, size=0.8)
    .box((1.75, 1.15), 1.9, 1.0, 32)
    .line((1.72, 0.28), (0.88, 1.62))
    .wheel((0.88, 1.62), 32, 0.6)
    .wheel((1.72, 0.28), 32, 0.6)
    .turn((0.73, 1.86), 122, 0.2, left)
    .turn((1.87, 0.04), 122, 0.2, right)
    .line((1.3, 0.95), (2.9, 0.95), look="dashed")
    .line((1.3, 0.95), (3.0, 2.01), look="dashed")
    .angle((1.3, 0.95), 1.45, 0, 32, phi)
    .dot((1.3, 0.95))
    .text((1.22, 0.62), "(x, y)")
    .dot((1.81, 1.27), "C", 0)
    .distance((1.3, 0.95), (1.81, 1.27), a, -0.2)
    .distance((1.3, 0.95), (0.88, 1.62), b, -0.2)
)

SYSTEM = System(
    name="two-wheeled-carriage",
    title="Two-wheeled carriage",
    description="A carriage, or a robot, on two wheels with a common axle that roll without "
    "slipping and turn independently.",
    sketch=SKETCH,
    fibration=Fibration(base=(left, right), fibre=(x, y, phi)),
    frame=Frame.quasi({v: car.forward, w: Dphi}),
    lagrangian=kinetic,
    constraints=(
        Dx * sin - Dy * cos,
        car.forward - b * Dphi - R * Dleft,
        car.forward + b * Dphi - R * Dright,
    ),
    meanings={
        **kinematics.place_meanings((x, y), "the middle of the axle"),
        phi: "heading of the carriage, from the first axis",
        left: "turn of the left wheel",
        right: "turn of the right wheel",
        v: "speed of the middle of the axle",
        w: "rate of turning",
        "heading by the wheels": "2 b times the heading, less what the wheels count",
        "heading": "m a times the heading in the middle of the turn, where v = 0",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass, wheels included"),
        Parameter(J, "1/2", positive=True, meaning="inertia about the centre of mass"),
        Parameter(a, "3/10", meaning="centre of mass, before the axle"),
        Parameter(b, "1/2", positive=True, meaning="half the track"),
        Parameter(R, "1/4", positive=True, meaning="radius of the wheels"),
        Parameter(C, "1/100", positive=True, meaning="a wheel's inertia, axial"),
    ),
    integrals={
        "energy": (drive * v**2 + turn * w**2) / 2,
        "heading by the wheels": 2 * b * phi - R * (right - left),
        "heading": m * a * phi - root * sp.atan(v * drive / (w * root)),
    },
    equations={
        "driving": Equation(drive * v, m * a * w**2),
        "turning": Equation(turn * w, -m * a * v * w),
    },
    measure=Measure(1 / w, variables=(v, w)),
    integrable="Euler-Jacobi",
    essential=(v, w),
    cases={
        "centre of mass over the axle": Case(
            parameters={a: 0},
            integrals={
                "driving": v,
                "turning": w,
                "centre of the circle, x": x * w - v * sin,
                "centre of the circle, y": y * w + v * cos,
            },
            measure=sp.Integer(1),
            integrable="Euler-Jacobi",
            note="Both wheels turn uniformly.",
        ),
    },
    scenes={
        "default": Scene(
            initial={v: -1, w: "1/20"},
            times=(0.0, 20.0),
            outputs=(x, y, phi, left, right),
            caption="Pushed with the load behind the axle, the carriage turns about.",
        ),
    },
    bodies=(
        Body(m, (*car.centre_velocity, 0), (0, 0, J), (0, 0, Dphi), title="car"),
        *(
            Body(0, (0, 0, 0), (0, C, 0), (0, turned, Dphi), turning=(0, 0, Dphi), title=wheel)
            for wheel, turned in (("left wheel", Dleft), ("right wheel", Dright))
        ),
    ),
    shapes=(
        Shape.box((R, 2 * b, R), centre=(x, y, R), attitude=phi),
        *(
            Shape.wheel(R, phi, rolled, centre=(*hub, R), contact=(*hub, 0))
            for rolled, hub in (
                (left, (x - b * sin, y + b * cos)),
                (right, (x + b * sin, y - b * cos)),
            )
        ),
        Shape.plane(),
    ),
    references=("NeimarkFufaev1972", "Bloch2015"),
)

# What the vertical disc calls its rolling angle, the rates of its angles, and its axial moment.
angle, rolling_rate, yaw_rate, B = sp.symbols("theta thetadot phidot B")

RELATIONS = (
    Relation(
        "two-wheeled-carriage",
        "sleigh",
        state={"x": x, "y": y, "phi": phi, "v": v, "w": w},
        parameters={"m": drive, "J": turn - (m * a) ** 2 / drive, "a": m * a / drive},
        note="A sleigh with the inertia of the wheels' spin.",
    ),
    Relation.into(
        SYSTEM,
        "vertical-disc",
        {left: angle, right: angle, v: R * rolling_rate, w: yaw_rate, J: C, a: 0, b: 0, C: B / 2},
        note="The disc is split into two wheels with no distance between them.",
    ),
)

SQUARES = (
    Square(
        first=("vertical-disc -> sleigh",),
        second=("vertical-disc -> two-wheeled-carriage", "two-wheeled-carriage -> sleigh"),
        name="a disc as a carriage, and both as a sleigh",
    ),
)

"""The snakeboard: a board with a rotor and two pairs of wheels that are steered against each other.

The board's middle is at (x, y) and its direction is ``theta``; the rotor has turned by ``psi``
against the board, the rear wheels by ``phi`` and the front wheels by -``phi``.  Neither pair, at
the distance l from the middle, slips sideways.  Without a rider's torques

    phi'' = 0,    (theta' + psi')' = 0,    theta' sqrt(J + 2 W + m l^2 cot(phi)^2) = constant,

with the moments J of the board, W of each pair of wheels [OstrowskiLewisMurrayBurdick1994,
BlochKrishnaprasadMarsdenMurray1996].
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
    Equation,
    Fibration,
    Measure,
    Parameter,
    Relation,
    Scene,
    Shape,
    Sketch,
    System,
    kinematics,
    velocity,
)

theta, psi, phi, x, y = sp.symbols("theta psi phi x y")
m, length, J, rotor, wheels = sp.symbols("m l J J_r J_w")
sine, cosine = sp.symbols("sine cosine")
Dtheta, Dpsi, Dphi, Dx, Dy = map(velocity, (theta, psi, phi, x, y))

kinetic = (
    m * (Dx**2 + Dy**2)
    + J * Dtheta**2
    + rotor * (Dtheta + Dpsi) ** 2
    + wheels * ((Dtheta + Dphi) ** 2 + (Dtheta - Dphi) ** 2)
) / 2

# sin(phi)^2 times the board's inertia against turning, with the way it makes along its track.
inertia_about_track = (J + 2 * wheels) * sine**2 + m * length**2 * cosine**2

SKETCH = (
    Sketch("seen from above")
    .axes(x, y, size=0.8)
    .line((0.9, 0.5), (3.3, 1.9))
    .ellipse((2.1, 1.2), 0.45, 0.45)
    .line((1.66, 1.29), (2.54, 1.11))
    .line((0.55, 0.86), (1.25, 0.14))
    .wheel((0.55, 0.86), 44, 0.45)
    .wheel((1.25, 0.14), 44, 0.45)
    .line((3.09, 2.36), (3.51, 1.44))
    .wheel((3.09, 2.36), 16, 0.45)
    .wheel((3.51, 1.44), 16, 0.45)
    .line((2.1, 1.2), (3.7, 1.2), look="dashed")
    .line((0.9, 0.5), (1.85, 1.42), look="dashed")
    .line((3.3, 1.9), (4.6, 2.27), look="dashed")
    .line((3.3, 1.9), (4.5, 2.6), look="dashed")
    .angle((2.1, 1.2), 1.3, 0, 30, theta)
    .angle((2.1, 1.2), 0.6, 30, -12, psi)
    .angle((0.9, 0.5), 0.85, 30, 44, phi)
    .angle((3.3, 1.9), 1.1, 30, 16, "-phi")
    .dot((2.1, 1.2), "(x, y)", 110)
    .distance((2.1, 1.2), (0.9, 0.5), "l", -0.75)
)
ahead, left = length * sp.cos(theta), length * sp.sin(theta)

SYSTEM = System(
    name="snakeboard",
    title="Snakeboard",
    description="A board with a rotor and two steered pairs of wheels, without torques.",
    sketch=SKETCH,
    fibration=Fibration(base=(theta, psi, phi), fibre=(x, y)),
    lagrangian=kinetic,
    constraints=(
        sp.cos(theta + phi) * Dy - sp.sin(theta + phi) * Dx - length * sp.cos(phi) * Dtheta,
        sp.cos(theta - phi) * Dy - sp.sin(theta - phi) * Dx + length * sp.cos(phi) * Dtheta,
    ),
    meanings={
        **kinematics.place_meanings((x, y), "the board's middle"),
        theta: "heading of the board, from the first axis",
        psi: "turn of the rotor against the board",
        phi: "steering angle of the rear wheels; the front wheels have the opposite one",
        "steering": "rate of the steering angle",
        "rotor": "angular velocity of the rotor in space",
        "turning": "rate of the heading, times the root of what is moved with it",
        "angle of the rotor": "angle of the rotor in space where phi = 0, times the rate of phi",
    },
    parameters=(
        Parameter(m, 6, positive=True, meaning="mass"),
        Parameter(length, "1/5", positive=True, meaning="half the wheelbase"),
        Parameter(J, "1/10", positive=True, meaning="inertia of the board"),
        Parameter(rotor, "1/20", positive=True, meaning="inertia of the rotor"),
        Parameter(wheels, "1/100", positive=True, meaning="inertia of a pair"),
    ),
    invariants={"sine": sp.sin(phi), "cosine": sp.cos(phi)},
    integrals={
        "energy": kinetic,
        "steering": Dphi,
        "rotor": Dtheta + Dpsi,
        "turning": Dtheta * sp.sqrt(inertia_about_track) / sine,
        "angle of the rotor": (theta + psi) * Dphi - phi * (Dtheta + Dpsi),
    },
    equations={
        "steering and rotor": Equation((Dphi, Dtheta + Dpsi), (sp.Integer(0), sp.Integer(0))),
        "turning": Equation(
            Dtheta, m * length**2 * cosine * Dtheta * Dphi / (sine * inertia_about_track)
        ),
    },
    measure=Measure(
        sp.sqrt(inertia_about_track) / sine, variables=(sine, cosine, Dtheta, Dpsi, Dphi)
    ),
    essential=(sine, cosine, Dtheta, Dphi),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={theta: "1/10", phi: "3/10", Dtheta: "1/5", Dpsi: 1, Dphi: "1/10"},
            times=(0.0, 5.0),
            outputs=(x, y, theta, psi, phi),
            caption="The wheels turn steadily, and the board's track curls up.",
        ),
    },
    bodies=(
        Body(m, (Dx, Dy, 0), (0, 0, J), (0, 0, Dtheta), title="board"),
        Body(0, inertia=(0, 0, rotor), omega=(0, 0, Dtheta + Dpsi), title="rotor"),
        Body(0, inertia=(0, 0, wheels), omega=(0, 0, Dtheta + Dphi), title="rear wheels"),
        Body(0, inertia=(0, 0, wheels), omega=(0, 0, Dtheta - Dphi), title="front wheels"),
    ),
    shapes=(
        Shape.box((2 * length, length / 3, length / 10), centre=(x, y, length / 3), attitude=theta),
        Shape.box(
            (length / 5, length, length / 10), centre=(x, y, length / 2), attitude=theta + psi
        ),
        *(
            Shape.box(
                (length / 4, length / 2, length / 4),
                centre=(*end, length / 8),
                attitude=theta + steered,
                contact=(*end, 0),
            )
            for end, steered in (((x - ahead, y - left), phi), ((x + ahead, y + left), -phi))
        ),
        Shape.plane(),
    ),
    references=("OstrowskiLewisMurrayBurdick1994", "BlochKrishnaprasadMarsdenMurray1996"),
)

RELATIONS = (
    Relation(
        "snakeboard",
        "free-particle",
        state={"X": phi, "Y": theta + psi, "Xdot": Dphi, "Ydot": Dtheta + Dpsi},
        parameters={"m": rotor},
        note="The wheels' angle and the rotor's angle in space.",
    ),
)

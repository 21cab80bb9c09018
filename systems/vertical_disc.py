"""The vertical rolling disc: a coin on its edge, kept upright, rolling without slipping.

It touches the plane at (x, y), heads along (cos phi, sin phi) and has turned by ``theta`` about
its axle.  Both angles change uniformly.
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
    System,
    kinematics,
    velocity,
)

x, y, phi, theta = sp.symbols("x y phi theta")
m, R, B, C = sp.symbols("m R B C")
Dx, Dy, Dphi, Dtheta = map(velocity, (x, y, phi, theta))

kinetic = (m * (Dx**2 + Dy**2) + B * Dtheta**2 + C * Dphi**2) / 2

SYSTEM = System(
    name="vertical-disc",
    title="Vertical rolling disc",
    description="A disc that rolls upright on a plane without slipping, and turns freely.",
    sketch=kinematics.disc_sketch((x, y), phi, theta),
    fibration=Fibration(base=(theta, phi), fibre=(x, y)),
    lagrangian=kinetic,
    constraints=(Dx - R * Dtheta * sp.cos(phi), Dy - R * Dtheta * sp.sin(phi)),
    meanings={
        **kinematics.place_meanings((x, y), "the contact on the plane"),
        phi: "heading of the disc, from the first axis",
        theta: "turn of the disc about its axle",
        "rolling": "rate at which the disc rolls",
        "turning": "rate of the heading",
        "angles": "turn about the axle at heading zero, times the rate of the heading",
        "centre of the circle, x": "place of its centre, times the rate of the heading",
        "centre of the circle, y": "place of its centre, times the rate of the heading",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        Parameter(B, "1/2", positive=True, meaning="inertia about the axle"),
        Parameter(C, "1/4", positive=True, meaning="inertia about a diameter"),
    ),
    # The contact point describes a circle; its centre, multiplied by the rate of turning, is
    # regular where that rate vanishes.
    integrals={
        "energy": kinetic,
        "rolling": Dtheta,
        "turning": Dphi,
        "angles": theta * Dphi - phi * Dtheta,
        "centre of the circle, x": x * Dphi - R * Dtheta * sp.sin(phi),
        "centre of the circle, y": y * Dphi + R * Dtheta * sp.cos(phi),
    },
    equations={"angles": Equation((Dtheta, Dphi), (0, 0))},
    measure=sp.Integer(1),
    # A Chaplygin system that is Hamiltonian in its own time.
    multiplier=sp.Integer(1),
    essential=(Dtheta, Dphi),
    integrable="Euler-Jacobi",
    scenes={
        "default": Scene(
            initial={Dtheta: "1", Dphi: "1/2"},
            times=(0.0, 15.0),
            outputs=(x, y, phi, theta),
            caption="The contact point describes a circle of radius 2.",
        ),
        "straight": Scene(
            initial={Dtheta: "1"},
            times=(0.0, 10.0),
            outputs=(x, y, phi, theta),
            caption="Without turning, the disc rolls straight on.",
        ),
    },
    bodies=(
        Body(
            m, (Dx, Dy, 0), (C, B, C), (0, Dtheta, Dphi), turning=(0, 0, Dphi), title="disc"
        ),  # along the heading, the axle and the vertical
    ),
    shapes=(
        Shape.wheel(R, phi, theta, centre=(x, y, R), contact=(x, y, 0)),
        Shape.plane(),
    ),
    references=("NeimarkFufaev1972", "Bloch2015"),
)

# The sine of the lean at which a disc without weight describes the same circle by itself.
lean = (B + m * R**2) / (B + m * R**2 - C) * Dtheta / Dphi

RELATIONS = (
    Relation(
        "vertical-disc",
        "falling-disc",
        state={
            "gamma2": sp.sqrt(1 - lean**2),
            "gamma3": lean,
            "p": 0,
            "q": Dphi * sp.sqrt(1 - lean**2),
            "s": Dtheta - Dphi * lean,
        },
        parameters={"m": m, "R": R, "A": C, "C": B, "g": 0},
        note="A disc that may lean does not go in a circle upright; where it has no weight, every "
        "circle belongs to one lean.",
    ),
    Relation(
        "vertical-disc",
        "sleigh",
        state={"x": x, "y": y, "phi": phi, "v": R * Dtheta, "w": Dphi},
        parameters={"m": m + B / R**2, "J": C, "a": 0},
        note="The disc moves over the plane as a knife edge that is heavier by its spin.",
    ),
    Relation(
        "vertical-disc",
        "free-particle",
        state={"X": theta, "Y": phi, "Xdot": Dtheta, "Ydot": Dphi},
        parameters={"m": m},
        note="The two angles.",
    ),
)

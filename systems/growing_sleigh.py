"""A sleigh that gathers snow: Chaplygin's sleigh whose mass and inertia grow in time.

The snow lies at rest before it is taken up, and sticks so that mass and inertia grow in one
proportion, 1 + g t, while the centre of mass stays where it is in the sleigh.  The Lagrangian
depends on the time; momenta, not velocities, are what the snow preserves.  With the momenta for
velocities and dtau = dt/(1 + g t) this is the sleigh of constant mass.
"""

from __future__ import annotations

import sympy as sp

from voronec import Equation, Measure, Parameter, Relation, kinematics, time

x, y, phi = sp.symbols("x y phi")
v, w = sp.symbols("v w")
m, J, a, g = sp.symbols("m J a g")

growth = 1 + g * time
sleigh = kinematics.Sleigh(m, J, a)
K = sleigh.turning_inertia
kinetic = growth * sleigh.kinetic

SYSTEM = sleigh.system(
    name="growing-sleigh",
    title="Sleigh that gathers snow",
    description="A Chaplygin sleigh that takes up snow lying at rest: mass and inertia depend on "
    "the time.",
    lagrangian=kinetic,
    meanings={
        "energy, as of the momenta": "energy that the momenta have with the first mass",
        "heading": "a times the heading in the middle of the turn, where v = 0",
    },
    values={
        m: Parameter(m, 1, positive=True, meaning="mass at the time 0"),
        J: Parameter(J, "1/2", positive=True, meaning="inertia at the time 0"),
        a: "3/10",
        g: Parameter(g, "1/10", lower=0, meaning="rate of growth"),
    },
    integrals={"energy, as of the momenta": growth * kinetic, "heading": sleigh.heading_integral},
    equations={
        "momentum": Equation(growth * v, growth * a * w**2),
        "angular momentum": Equation(growth * w, -growth * m * a * v * w / K),
    },
    measure=Measure(growth / w, variables=(v, w)),
    scenes={
        "default": sleigh.scene(
            "The growing sleigh runs along the same track as the constant one, but ever more "
            "slowly.",
            40.0,
            {v: -1, w: "1/20"},
        ),
    },
    references=("Chaplygin1911", "NeimarkFufaev1972"),
)

RELATIONS = (
    Relation(
        "growing-sleigh",
        "sleigh",
        state={"x": x, "y": y, "phi": phi, "v": growth * v, "w": growth * w},
        parameters={"m": m, "J": J, "a": a},
        clock=1 / growth,
        note="The same track in another time, which depends on time alone.",
    ),
)

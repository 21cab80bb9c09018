"""A sleigh on a turntable, held by a spring: not reversible, and chaotic.

The blade of Chaplygin's sleigh does not slip sideways over a table that turns with the angular
velocity Omega, so the constraint is affine.  A spring of stiffness k draws a hook on the sleigh, at
the distance ``along`` before the blade and ``beside`` to its left, to the axis of the table.  Here
everything is seen in axes that turn with the table: the constraint is homogeneous, the Lagrangian
has Coriolis and centrifugal terms, and the Jacobi integral takes the place of the energy
[BorisovMamaevBizyaev2015].

The usual tests of integrators for nonholonomic systems are reversible and integrable, and flatter
every method [ModinVerdier2020].  This system is neither.  With time run back it is that of a table
that turns the other way; a mirror mends that, but puts the hook on the other side.  Where the
centre of mass is over the blade, the volume is kept, and numbers show the motion chaotic; elsewhere
it is attracted.
"""

from __future__ import annotations

import sympy as sp

from voronec import Case, Equation, Limit, Measure, Parameter, Relation, kinematics, velocity

x, y, phi = sp.symbols("x y phi")
ahead, left = sp.symbols("ahead left")
v, w = sp.symbols("v w")
m, J, a, Omega, k, along, beside = sp.symbols("m J a Omega k along beside")
Dx, Dy, Dphi = velocity(x), velocity(y), velocity(phi)
cos, sin = sp.cos(phi), sp.sin(phi)

# The blade from the axis of the table, along the sleigh and across.
before, aside = x * cos + y * sin, y * cos - x * sin
potential = k * ((before + along) ** 2 + (aside + beside) ** 2) / 2

sleigh = kinematics.Sleigh(m, J, a, ground="table")
# In space: of the centre of mass, along the sleigh and across; of the turning.
forward = sleigh.forward - Omega * aside
across = Dy * cos - Dx * sin + Omega * before + a * (Dphi + Omega)
kinetic = (m * (forward**2 + across**2) + J * (Dphi + Omega) ** 2) / 2

# The same of the place as the sleigh sees it.
K = J + m * a**2
relative_energy = (m * v**2 + K * w**2) / 2
spring_energy = k * ((ahead + along) ** 2 + (left + beside) ** 2) / 2
centrifugal = m * Omega**2 * (left**2 + (ahead + a) ** 2) / 2
drive = a * w**2 + 2 * Omega * a * w + Omega**2 * (ahead + a) - k / m * (ahead + along)
turn = -m * a * v * (w + 2 * Omega) + m * a * Omega**2 * left + k * (beside * ahead - along * left)

SKETCH = (
    sleigh.sketch.line(
        (0.0, 0.0), (0.35, 0.12), (0.4, 0.3), (0.6, 0.25), (0.65, 0.45), (0.85, 0.4), (1.3, 1.5)
    )
    .dot((1.3, 1.5), "hook", 90)
    .turn((0.0, 0.0), 90, 0.3, Omega)
)

SYSTEM = sleigh.system(
    name="sleigh-on-turntable",
    title="Sleigh on a turntable, held by a spring",
    description="A sleigh whose blade does not slip over a turning table, with a spring from the "
    "table's axis to a hook beside the sleigh's middle: neither reversible nor integrable.",
    sketch=SKETCH,
    lagrangian=kinetic - potential,
    essential=(),
    meanings={
        "Jacobi": "energy seen from the table, with the potential of the centrifugal force",
    },
    values={
        m: 1,
        J: "1/2",
        a: "3/10",
        Omega: Parameter(Omega, "1/2", meaning="angular velocity of the table"),
        k: Parameter(k, 1, lower=0, meaning="stiffness of the spring"),
        along: Parameter(along, "1/5", meaning="hook, before the blade"),
        beside: Parameter(beside, "2/5", meaning="hook, to the left of the blade"),
    },
    invariants={"ahead": before, "left": aside},
    integrals={"Jacobi": relative_energy + spring_energy - centrifugal},
    equations={
        "place": Equation((ahead, left), (v + w * left, -w * ahead)),
        "speed and turning": Equation((v, K * w), (drive, turn)),
    },
    cases={
        "centre of mass over the blade": Case(
            parameters={a: 0},
            measure=Measure(sp.Integer(1), variables=(ahead, left, v, w)),
        ),
    },
    scenes={
        "default": sleigh.scene(
            "With its centre of mass over the blade, the sleigh settles into no rhythm.",
            60.0,
            {x: 1, v: "1/2", w: "1/2"},
            {a: 0},
        ),
        "attracted": sleigh.scene(
            "With its centre of mass before the blade, the sleigh learns to go forward.",
            60.0,
            {x: 1, v: "-1/2", w: "1/2"},
        ),
    },
    references=("BorisovMamaevBizyaev2015", "ModinVerdier2020"),
)

h = sp.Symbol("h")

RELATIONS = (
    Relation(
        "sleigh-on-turntable",
        "sleigh",
        parameters={"m": m, "J": J, "a": a},
        limit=Limit(h, {Omega: h, k: h}),
        note="The table comes to rest and the spring goes slack.",
    ),
    Relation.into(
        SYSTEM,
        "sleigh-on-turntable",
        {x: x, **{q: -q for q in (v, w, Omega)}},
        clock=-1,
        name="sleigh on a turntable reversed",
        note="With time run back, the table turns the other way.",
    ),
    Relation.into(
        SYSTEM,
        "sleigh-on-turntable",
        {q: -q for q in (y, phi, w, Omega, beside)},
        name="sleigh on a turntable mirrored",
        note="In the mirror the table turns the other way, and the hook is on the other side.",
    ),
)

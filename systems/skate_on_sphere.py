"""A skate on a sphere, under gravity.

The skate touches the sphere of radius R at the colatitude theta and the longitude phi; psi is the
heading of its blade, from the meridian downwards.  Its mass centre is at the contact, and J is the
inertia about the normal.  gamma is the vertical along the blade, across it, and along the normal.
With the speed v along the blade and the rate of turning w,

    v' = -g gamma1,    w' = 0,    gamma' = gamma x (0, v/R, w),

so that w v - g gamma2 is constant, too: gamma1 satisfies the equation of elliptic functions.
It is Suslov's problem in the case of Kharlamova: the blade is the forbidden axis.  Without gravity
the skate goes round a circle of the sphere, with the angular velocity (0, v/R, w), fixed in space.
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
    System,
    kinematics,
)

phi, theta, psi = sp.symbols("phi theta psi")
v, w = sp.symbols("v w")
m, R, J, g = sp.symbols("m R J g")
gamma = sp.symbols("gamma1:4")

rotation = kinematics.Rotation.euler("zyz", phi, theta, psi)
rates, vertical = rotation.body_rates, tuple(rotation.matrix.row(2))
attitude = rotation.matrix
contact = R * attitude[:, 2]
centre_velocity = R * sp.Matrix([rates[1], -rates[0], 0])
spin = sp.Matrix([0, v / R, w])
axis = attitude * spin

SKETCH = (
    Sketch("seen from the side")
    .ellipse((0, 0), 1.3, 1.3)
    .line((0, 0), (0.0, 1.7), look="dashed")
    .line((0, 0), (0.75, 1.06))
    .angle((0, 0), 0.6, 90, 55, theta)
    .turn((0.0, 1.55), 90, 0.2, phi)
    .line((0.75, 1.06), (1.75, 0.36), look="dashed")
    .line((0.4, 1.06), (1.1, 1.06))
    .angle((0.75, 1.06), 0.75, -35, 0, psi)
    .dot((0, 0), "O", 200)
    .dot((0.75, 1.06), "M", 60)
)

SYSTEM = System(
    name="skate-on-sphere",
    title="Skate on a sphere",
    description="A skate glides over a fixed sphere under gravity and does not slip sideways.",
    sketch=SKETCH,
    fibration=Fibration(base=(theta, psi), fibre=(phi,)),
    frame=Frame.quasi({v: R * rates[1], w: rates[2]}, beside={sp.Symbol("roll"): rates[0]}),
    lagrangian=kinematics.kinetic_energy(m, centre_velocity, (0, 0, J), rates)
    - m * g * R * vertical[2],
    constraints=(rates[0],),
    meanings={
        theta: "colatitude of the contact",
        phi: "longitude of the contact",
        psi: "heading of the blade, from the meridian",
        v: "speed along the blade",
        w: "rate of turning about the normal",
        "turning": "rate of turning about the normal",
        "drift": "rate of turning times speed, less the weight's part across the blade",
        **kinematics.vector_meanings(map(str, gamma), "the vertical", "the skate"),
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius of the sphere"),
        Parameter(J, "1/10", positive=True, meaning="inertia about the normal"),
        Parameter(g, 1, meaning="gravity"),
    ),
    invariants=dict(zip(map(str, gamma), vertical, strict=True)),
    equations={
        "speed": Equation(v, -g * gamma[0]),
        "turning": Equation(w, sp.Integer(0)),
        "vertical": Equation(gamma, sp.Matrix(gamma).cross(spin)),
    },
    integrals={
        "energy": (m * v**2 + J * w**2) / 2 + m * g * R * gamma[2],
        "turning": w,
        "drift": w * v - g * gamma[1],
    },
    measure=Measure(sp.Integer(1), variables=(*gamma, v, w)),
    integrable="Euler-Jacobi",
    essential=(theta, psi, v, w),
    cases={
        "without gravity": Case(
            parameters={g: 0},
            integrals={"speed": v, **{f"axis, {q}": x for q, x in zip("xyz", axis, strict=True)}},
            note="A circle, run through uniformly.",
        ),
    },
    scenes={
        "default": Scene(
            initial={theta: "1/2", psi: "1/3", v: "1/5", w: 3},
            times=(0.0, 20.0),
            outputs=(theta, phi, psi, v),
            caption="A skate that turns does not slide down: it drifts around.",
        ),
    },
    bodies=(
        Body(m, attitude * centre_velocity, (0, 0, J), rates, force=(0, 0, -m * g), title="skate"),
    ),
    shapes=(
        Shape.box((R / 2, R / 20, R / 5), centre=contact, attitude=attitude, contact=contact),
        Shape.ball(R, role="ground"),
    ),
    references=("NeimarkFufaev1972", "DragovicGajicJovanovic1998"),
)

zeros = dict.fromkeys(sp.symbols("b1 b3 c1 c2"), 0)
moments, along = (m * R**2, J, m * R**2), (gamma[1], gamma[2], gamma[0], v / R, w)
RELATIONS = (
    Relation.of(
        SYSTEM,
        "suslov-in-potential",
        {**dict(zip(sp.symbols("I1:4"), moments, strict=True)), **zeros, "b2": m * g * R},
        state=dict(zip((*gamma, *sp.symbols("omega1:3")), along, strict=True)),
        note="The blade is the forbidden axis.",
    ),
)

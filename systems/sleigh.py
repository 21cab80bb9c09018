"""The Chaplygin sleigh: a rigid body on a plane, held by a blade that does not slip sideways.

The blade touches the plane at (x, y) and points along (cos phi, sin phi); the centre of mass lies
on the line of the blade, at the distance ``a`` before the point of contact.  With the speed v along
the blade and the rate of turning w,

    vdot = a w^2,    wdot = -m a v w / (J + m a^2)    [Chaplygin1911].
"""

from __future__ import annotations

import sympy as sp

from voronec import Body, Case, Equation, Measure, kinematics, velocity

x, y, phi = sp.symbols("x y phi")
v, w = sp.symbols("v w")
m, J, a = sp.symbols("m J a")

sleigh = kinematics.Sleigh(m, J, a)
K = sleigh.turning_inertia

SYSTEM = sleigh.system(
    name="sleigh",
    title="Chaplygin sleigh",
    description="A rigid body on a plane, supported by a blade that does not slip sideways.",
    meanings={"heading": "a times the heading in the middle of the turn, where v = 0"},
    values={m: 1, J: "1/2", a: "3/10"},
    integrals={"energy": sleigh.kinetic, "heading": sleigh.heading_integral},
    equations={
        "speed": Equation(v, a * w**2),
        "turning": Equation(w, -m * a * v * w / K),
    },
    # The turning dies out, so no measure is invariant whose density is smooth where w = 0.
    measure=Measure(1 / w, variables=(v, w)),
    integrable="Euler-Jacobi",
    cases={
        "centre of mass over the blade": Case(
            parameters={a: 0},
            integrals={
                "speed": v,
                "turning": w,
                "centre of the circle, x": x * w - v * sp.sin(phi),
                "centre of the circle, y": y * w + v * sp.cos(phi),
            },
            measure=sp.Integer(1),
            integrable="Euler-Jacobi",
            note="A knife edge: circles, run through uniformly; the measure is smooth.",
        ),
    },
    scenes={
        "default": sleigh.scene(
            "Pushed backwards, the sleigh turns about and goes on with the blade behind.",
            20.0,
            {v: -1, w: "1/20"},
        ),
    },
    bodies=(
        Body(
            m,
            (*sleigh.centre_velocity, 0),
            (0, 0, J),
            (0, 0, velocity(phi)),
            title="sleigh",
        ),
    ),
    references=("Chaplygin1911", "Caratheodory1933", "NeimarkFufaev1972"),
)

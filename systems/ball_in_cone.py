"""A homogeneous ball that rolls inside an upright cone.

The centre moves on a cone, too, of half opening angle delta, at the distance u from its vertex.
Its moment u^2 w about the axis is constant, w = phi', and so is R s - u w cos(delta), with the spin
s about the normal [Routh1905]: of the ball in a funnel the distance alone is left, which runs
between two values as in a central field.
"""

from __future__ import annotations

import sympy as sp

from voronec import Parameter, Relation, Scene, kinematics

u, v, w, s, delta = sp.symbols("u v w s delta")
m, R, J, g = sp.symbols("m R J g")

steep = Parameter(delta, "1/2", lower=0, upper=sp.pi / 2, meaning="half the opening of the cone")
profile = (u * sp.sin(delta), u * sp.cos(delta))

SYSTEM = kinematics.BallOnRevolution(u, profile, m, R, J, g, length=1).system(
    name="ball-in-cone",
    title="Ball in a cone",
    description="A heavy homogeneous ball rolls without slipping inside an upright cone.",
    values={delta: steep, m: 1, R: "1/5", J: "2/125", g: 1},
    ranges=(0, 3),
    outline=((-2.2, 0.88), (0.0, 0.0), (2.2, 0.88)),
    measured=((0.0, 0.59), (1.15, 1.05)),
    meanings={
        u: "distance of the centre from the vertex of its cone",
        "moment": "square of the distance, times the rate of the azimuth",
        "spin": "R times the spin about the normal, less a part of the speed around",
    },
    integrals={"moment": u**2 * w, "spin": R * s - u * w * sp.cos(delta)},
    scenes={
        "default": Scene(
            initial={u: 2, "beta": 1, v: "-1/5", w: 1},
            times=(0.0, 20.0),
            outputs=(u, "phi", v, s),
            caption="The ball goes round in a funnel, and not through it.",
        ),
    },
    references=("Routh1905",),
)

RELATIONS = (
    Relation.of(
        SYSTEM,
        "ball-on-surface-of-revolution",
        {sp.Function("f")(u): profile[0], sp.Function("h")(u): profile[1]},
        note="the meridian is straight",
    ),
)

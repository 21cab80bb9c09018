"""A heavy homogeneous ball that rolls in a spherical bowl.

The centre moves on a sphere of radius a, at the angle u from the lowest point, and w = phi'.  The
curvatures of a sphere are equal, so that the spin s about the normal is constant, and with
k^2 = J/(J + m R^2) so is the moment about the vertical a sin(u)^2 w - k^2 R s cos(u) [Routh1905]:
the height runs as that of a heavy symmetric top.
"""

from __future__ import annotations

import sympy as sp

from voronec import Parameter, Relation, Scene, kinematics

u, w, s = sp.symbols("u w s")
a, m, R, J, g = sp.symbols("a m R J g")

wide = Parameter(a, 1, positive=True, meaning="radius of the sphere on which the centre moves")
profile, share = (a * sp.sin(u), -a * sp.cos(u)), J / (J + m * R**2)

SYSTEM = kinematics.BallOnRevolution(u, profile, m, R, J, g, length=a).system(
    name="ball-in-bowl",
    title="Ball in a spherical bowl",
    description="A heavy homogeneous ball rolls without slipping in a spherical bowl.",
    values={a: wide, m: 1, R: "1/5", J: "2/125", g: 1},
    ranges=(0, sp.pi / 2),
    meanings={
        u: "angle of the centre from the lowest point",
        "spin": "angular velocity along the normal",
        "moment": "moment about the vertical, over mass and radius, with what the spin adds",
    },
    integrals={"spin": s, "moment": a * sp.sin(u) ** 2 * w - share * R * s * sp.cos(u)},
    scenes={
        "default": Scene(
            initial={u: 1, "beta": 1, w: "1/2", s: 10},
            times=(0.0, 20.0),
            outputs=(u, "phi", s),
            caption="A ball that spins goes round the bowl in loops.",
        ),
    },
    references=("Routh1905",),
)

RELATIONS = (
    Relation.of(
        SYSTEM,
        "ball-on-surface-of-revolution",
        {sp.Function("f")(u): profile[0], sp.Function("h")(u): profile[1]},
        note="the meridian is a circle",
    ),
)

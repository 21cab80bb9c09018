"""A homogeneous ball that rolls on the wall of a vertical cylinder, which it touches from inside.

The centre is at the distance a from the axis and at the height u.  The rate w of the azimuth is
constant, and so is R s + u w, with the spin s about the normal; with k^2 = J/(J + m R^2)

    u'' + k^2 w^2 u = k^2 w (R s + u w) - (1 - k^2) g:

the ball does not fall, but goes up and down, k times as often as it goes round; a solid ball
(2/7)^(1/2) times [Routh1905, GualtieriEtAl2006].
"""

from __future__ import annotations

import sympy as sp

from voronec import Equation, Parameter, Relation, Scene, kinematics

u, v, w, s = sp.symbols("u v w s")
a, m, R, J, g = sp.symbols("a m R J g")

wide = Parameter(a, 1, positive=True, meaning="distance of the centre from the axis")
share = J / (J + m * R**2)
ball = kinematics.BallOnRevolution(u, (a, u), m, R, J, g, length=1)

SYSTEM = ball.system(
    name="ball-in-cylinder",
    title="Ball in a cylinder",
    description="A heavy homogeneous ball rolls without slipping inside a vertical cylinder.",
    values={a: wide, m: 1, R: "1/5", J: "2/125", g: 1},
    ranges=(-4, 2),
    outline=((-1.695, 2.4), (-1.695, -0.4), (1.695, -0.4), (1.695, 2.4)),
    measured=((1.15, -0.4), (1.15, 1.05)),
    meanings={
        u: "height of the centre",
        "turning": "rate of the azimuth",
        "spin": "R times the spin about the normal, and height times rate of the azimuth",
    },
    integrals={"turning": w, "spin": R * s + u * w},
    equations={"height": Equation(v, share * R * s * w - (1 - share) * g)},
    scenes={
        "default": Scene(
            initial={u: 0, "beta": 1, w: 2},
            times=(0.0, 20.0),
            outputs=(u, "phi", v, s),
            caption="The ball that goes round does not fall: it goes down and up again.",
        ),
    },
    references=("Routh1905", "GualtieriEtAl2006"),
)

RELATIONS = (
    Relation.of(
        SYSTEM,
        "ball-on-surface-of-revolution",
        {sp.Function("f")(u): a, sp.Function("h")(u): u},
        note="the meridian is upright",
    ),
)

"""A homogeneous ball that rolls on any surface of revolution with a vertical axis.

Its centre moves on the surface of revolution of the meridian (f(u), h(u)), any functions: L is the
length of (f', h'), and k1, k2 are the curvatures along the meridian and across.  With v = u',
w = phi', the spin s = (omega, n) about the normal,

    R s' = (k1 - k2) L f v w,    (f^2 w)' = -J/(J + m R^2) R k1 L f v s.

So s and f^2 w satisfy linear equations with u for the time, and the two constants of their solution
are integrals that are linear in the velocities [Routh1905]; with the energy, the rest are
quadratures.  The solutions are elementary where the meridian is straight, k1 = 0, and f^2 w is
constant (``ball-in-cylinder``, ``ball-in-cone``); on the sphere, k1 = k2, where s is
(``ball-in-bowl``); and on the paraboloid, ``ball-on-paraboloid`` [BorisovMamaevKilin2002].

f and h being unknown, there is no motion to show.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

u = sp.Symbol("u")
m, R, J, g = sp.symbols("m R J g")
profile = f, h = sp.Function("f")(u), sp.Function("h")(u)

SYSTEM = kinematics.BallOnRevolution(u, profile, m, R, J, g).system(
    name="ball-on-surface-of-revolution",
    title="Ball on a surface of revolution",
    description="A heavy homogeneous ball rolls without slipping on a surface of revolution.",
    values={m: 1, R: "1/5", J: "2/125", g: 1},
    measured=((0.0, 0.6), (1.15, 1.05)),
    meanings={u: "place of the centre on its meridian"},
    references=("Routh1905", "BorisovMamaevKilin2002"),
)

r, c, k = sp.symbols("r c k")
RELATIONS = (
    Relation.into(
        SYSTEM,
        "ball-on-paraboloid",
        {u: r, J: m * R**2 * k**2 / (1 - k**2), f: u, h: c * u**2 / 2},
        note="the centre moves on a paraboloid",
    ),
)

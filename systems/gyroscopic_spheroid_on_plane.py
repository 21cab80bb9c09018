"""A heavy spheroid with a gyroscope along its axis that rolls without slipping on a plane.

As ``spheroid-on-plane``, with the momentum kappa = (0, 0, k) of a gyroscope, constant in the body:

    dG/dt = (G + kappa) x omega + m dr/dt x (omega x r) + m g r x gamma,  dgamma/dt = gamma x omega,

G = I omega + m r x (omega x r) about the contact M, r = OM = -S gamma/h, S = diag(a^2, a^2, c^2)
and h = (gamma, S gamma)^(1/2).  The gyroscope along the axis leaves the measure as it is without.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

omega = sp.symbols("omega1:4")
m, g, a, c, A, C, k = sp.symbols("m g a c A C k")

rolling = kinematics.RollingEllipsoid.on_plane((a, a, c), m, (A, A, C))
theta = rolling.base[1]

SYSTEM = rolling.system(
    name="gyroscopic-spheroid-on-plane",
    title="Spheroid with a gyroscope on a plane",
    description="A heavy ellipsoid of revolution with a gyroscope along its axis rolls without "
    "slipping on a horizontal plane.",
    rotor=(0, 0, k),
    gravity=g,
    values={m: 1, g: 1, a: 1, c: "0.8", A: "0.4", C: "0.5", k: "0.5"},
    scenes={
        "default": rolling.scene(
            "The gyroscope bends the path of the spheroid.", {theta: "1/2"}, (1, 0, 3)
        ),
    },
    references=("Voronec1912", "BorisovMamaev2002"),
)

moments = {"I1": A, "I2": A, "I3": C}
RELATIONS = (
    Relation.of(
        SYSTEM,
        "gyroscopic-ellipsoid-on-plane",
        {"a": a, "b": a, "c": c, **moments, "kappa1": 0, "kappa2": 0, "kappa3": k},
        note="two axes are equal",
    ),
    Relation.of(SYSTEM, "spheroid-on-plane", vanish=k, note="the gyroscope stops"),
)

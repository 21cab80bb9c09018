"""A spheroid with a gyroscope along its axis that rolls without slipping over a fixed sphere.

As ``spheroid-on-sphere``, with the momentum kappa = (0, 0, k) of a gyroscope, constant in the body:

    dG/dt = (G + kappa) x omega + m dr/dt x (omega x r),
    dgamma/dt = R1 (R1 + H)^-1 (gamma x omega),

G = I omega + m r x (omega x r) about the contact M, r = OM = -S gamma/h, S = diag(a^2, a^2, c^2),
h = (gamma, S gamma)^(1/2) and H = -dr/dgamma.  R1 is signed: negative inside the sphere.  The
gyroscope along the axis leaves the measure as it is without.

The chart is that of ``spheroid-on-sphere``: what is not in the equations may have any values.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

omega = sp.symbols("omega1:4")
m, R1, a, c, A, C, k = sp.symbols("m R1 a c A C k")

rolling = kinematics.RollingEllipsoid.spheroid_on_sphere((a, c), m, (A, C), R1)
u, v, u1, v1, theta = rolling.fibre[3:]

SYSTEM = rolling.system(
    name="gyroscopic-spheroid-on-sphere",
    title="Spheroid with a gyroscope on a sphere",
    description="An ellipsoid of revolution with a gyroscope along its axis rolls without slipping "
    "over a fixed sphere.",
    rotor=(0, 0, k),
    values={m: 1, R1: 2, a: 1, c: "0.8", A: "0.4", C: "0.5", k: "0.5"},
    scenes={
        "default": rolling.scene(
            "The gyroscope steers the spheroid around the sphere.",
            {"chi": 1, u: 1, u1: 1},
            (1, "1/2", 3),
        ),
    },
    drawing={"on the spheroid": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("Voronec1912", "BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

body = {"I1": A, "I2": A, "I3": C, "kappa1": 0, "kappa2": 0, "kappa3": k}
state, functions = rolling.as_any_body
RELATIONS = (
    Relation.of(
        SYSTEM,
        "gyroscopic-ellipsoid-on-sphere",
        {"a": a, "b": a, "c": c, **body},
        note="two axes are equal",
    ),
    Relation.of(
        SYSTEM,
        "gyroscopic-rolling-body",
        {**body, **functions},
        state=state,
        note="the surfaces are given",
    ),
    Relation.of(SYSTEM, "gyroscopic-spheroid-on-plane", {"g": 0}, grow=R1, note="a large sphere"),
    Relation.of(SYSTEM, "spheroid-on-sphere", vanish=k, note="the gyroscope stops"),
)

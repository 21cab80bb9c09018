"""An ellipsoid with a gyroscope that rolls without slipping over a fixed sphere.

As ``ellipsoid-on-sphere``, with the momentum kappa of a gyroscope, constant in the body:

    dG/dt = (G + kappa) x omega + m dr/dt x (omega x r),
    dgamma/dt = R1 (R1 + H)^-1 (gamma x omega),

G = I omega + m r x (omega x r) about the contact M, r = OM = -S gamma/h, S = diag(a^2, b^2, c^2),
h = (gamma, S gamma)^(1/2) and H = -dr/dgamma.  R1 is signed: negative inside the sphere.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

m, R1, R2 = sp.symbols("m R1 R2")
axes, inertia, kappa = sp.symbols("a b c"), sp.symbols("I1:4"), sp.symbols("kappa1:4")

rolling = kinematics.RollingEllipsoid.on_sphere(axes, m, inertia, R1)
theta = rolling.base[1]
u, v, support = rolling.fibre
# At the end of the axis a, the support function is a itself.
start = {theta: 1, u: sp.pi / 2, support: 1}

SYSTEM = rolling.system(
    name="gyroscopic-ellipsoid-on-sphere",
    title="Ellipsoid with a gyroscope on a sphere",
    description="An ellipsoid with a gyroscope rolls without slipping over a fixed sphere, or "
    "inside it.",
    rotor=kappa,
    values={
        m: 1,
        R1: 2,
        axes: ("1", "1.2", "0.8"),
        inertia: ("0.4", "0.3", "0.5"),
        kappa: ("0.3", "-0.2", "2"),
    },
    scenes={
        "default": rolling.scene(
            "The gyroscope steers the ellipsoid around the sphere.", start, (1, "1/2", 2)
        ),
        "inner": rolling.scene("Inside a sphere four times as large.", start, (1, 0, 2), {R1: -4}),
    },
    references=("Voronec1911", "Voronec1912", "BorisovMamaev2002"),
)

RELATIONS = (
    Relation.into(
        SYSTEM,
        "gyroscopic-ball-on-sphere",
        {"height": R2, **dict.fromkeys(axes, R2)},
        note="equal axes",
    ),
    Relation.of(SYSTEM, "gyroscopic-ellipsoid-on-plane", {"g": 0}, grow=R1, note="a large sphere"),
    Relation.of(SYSTEM, "ellipsoid-on-sphere", vanish=kappa, note="the gyroscope stops"),
)

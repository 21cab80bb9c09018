"""A heavy ellipsoid with a gyroscope that rolls without slipping on a horizontal plane.

As ``ellipsoid-on-plane``, with the momentum kappa of a gyroscope, constant in the body:

    dG/dt = (G + kappa) x omega + m dr/dt x (omega x r) + m g r x gamma,  dgamma/dt = gamma x omega,

G = I omega + m r x (omega x r) about the contact M, r = OM = -S gamma/h, S = diag(a^2, b^2, c^2)
and h = (gamma, S gamma)^(1/2).  The gyroscope does no work.  Where it lies along the axis of an
ellipsoid of revolution there is a measure (``gyroscopic-spheroid-on-plane``).
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

m, g, R = sp.symbols("m g R")
axes, inertia, kappa = sp.symbols("a b c"), sp.symbols("I1:4"), sp.symbols("kappa1:4")

rolling = kinematics.RollingEllipsoid.on_plane(axes, m, inertia)
_, theta, psi = rolling.base

SYSTEM = rolling.system(
    name="gyroscopic-ellipsoid-on-plane",
    title="Ellipsoid with a gyroscope on a plane",
    description="A heavy ellipsoid with a gyroscope rolls without slipping on a horizontal plane.",
    rotor=kappa,
    gravity=g,
    values={
        m: 1,
        g: 1,
        axes: ("1", "1.2", "0.8"),
        inertia: ("0.4", "0.3", "0.5"),
        kappa: ("0.3", "-0.2", "2"),
    },
    scenes={
        "default": rolling.scene(
            "The gyroscope bends the path of the tumbling ellipsoid.",
            {theta: 1, psi: 1},
            (1, 2, "1/2"),
        ),
        "spheroid": rolling.scene(
            "An ellipsoid of revolution spins about its axis while it rolls.",
            {theta: "1/2"},
            (1, 0, 3),
            {axes[1]: 1, inertia[1]: "2/5", kappa[0]: 0, kappa[1]: 0},
        ),
    },
    references=("Voronec1912", "BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

RELATIONS = (
    Relation.into(
        SYSTEM,
        "gyroscopic-ball-on-plane",
        {"height": R, g: 0, **dict.fromkeys(axes, R)},
        note="equal axes; weight does nothing to a balanced ball",
    ),
    Relation.of(SYSTEM, "ellipsoid-on-plane", vanish=kappa, note="the gyroscope stops"),
)

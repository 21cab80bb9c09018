"""An ellipsoid that rolls without slipping on a horizontal plane, under its weight.

Its axes are the principal axes of inertia about its centre O, where its mass is centred.  gamma is
the vertical, G the momentum about the contact M, both along these axes; h = (gamma, S gamma)^(1/2)
with S = diag(a^2, b^2, c^2) is the height of O and r = -S gamma/h the vector OM.  Then

    dG/dt = G x omega + m dr/dt x (omega x r) + m g r x gamma,    dgamma/dt = gamma x omega,

where G = I omega + m r x (omega x r): the contact moves over the body, and the second term is what
that does.  The equations close in gamma, h, omega.  In general the energy is the only integral, and
no measure is known; an ellipsoid of revolution has one (``spheroid-on-plane``).
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

m, g, R = sp.symbols("m g R")
axes, inertia = sp.symbols("a b c"), sp.symbols("I1:4")

rolling = kinematics.RollingEllipsoid.on_plane(axes, m, inertia)
_, theta, psi = rolling.base

SYSTEM = rolling.system(
    name="ellipsoid-on-plane",
    title="Ellipsoid on a plane",
    description="A heavy ellipsoid rolls without slipping on a horizontal plane.",
    gravity=g,
    values={m: 1, g: 1, axes: ("1", "1.2", "0.8"), inertia: ("0.4", "0.3", "0.5")},
    scenes={
        "default": rolling.scene(
            "The ellipsoid tumbles along the plane.", {theta: 1, psi: 1}, (1, 2, "1/2")
        ),
        "spheroid": rolling.scene(
            "An ellipsoid of revolution spins about its axis while it rolls.",
            {theta: "1/2"},
            (1, 0, 3),
            {axes[1]: 1, inertia[1]: "2/5"},
        ),
    },
    references=("Voronec1912", "BorisovMamaev2002"),
)

RELATIONS = (
    Relation.into(
        SYSTEM,
        "chaplygin-ball",
        {"height": R, g: 0, **dict.fromkeys(axes, R)},
        note="equal axes; weight does nothing to a balanced ball",
    ),
)

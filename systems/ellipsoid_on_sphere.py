"""An ellipsoid that rolls without slipping over a fixed sphere.

Its axes are the principal axes of inertia about its centre O, where its mass is centred.  gamma is
the normal of the sphere, from the contact M into the ellipsoid, G the momentum about M, both along
these axes; h = (gamma, S gamma)^(1/2) with S = diag(a^2, b^2, c^2) is the support function and
r = -S gamma/h the vector OM.  With H = -dr/dgamma, whose eigenvalues are the radii of curvature,

    dG/dt = G x omega + m dr/dt x (omega x r),    dgamma/dt = R1 (R1 + H)^-1 (gamma x omega),

where G = I omega + m r x (omega x r).  R1 is signed: negative where the ellipsoid rolls inside the
sphere, whose radius is then larger than the radii of curvature.  In general the energy is the only
integral; an ellipsoid of revolution has a measure too (``spheroid-on-sphere``).
Over a large sphere the ellipsoid rolls as it does on a plane.

The five coordinates are Euler's angles and the colatitude and longitude of gamma in the ellipsoid,
with the support function as a sixth, so that no root occurs.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

m, R1, R2 = sp.symbols("m R1 R2")
axes, inertia = sp.symbols("a b c"), sp.symbols("I1:4")

rolling = kinematics.RollingEllipsoid.on_sphere(axes, m, inertia, R1)
theta = rolling.base[1]
u, v, support = rolling.fibre
# At the end of the axis a, the support function is a itself.
start = {theta: 1, u: sp.pi / 2, support: 1}

SYSTEM = rolling.system(
    name="ellipsoid-on-sphere",
    title="Ellipsoid on a sphere",
    description="An ellipsoid rolls without slipping over a fixed sphere, or inside it.",
    values={m: 1, R1: 2, axes: ("1", "1.2", "0.8"), inertia: ("0.4", "0.3", "0.5")},
    scenes={
        "default": rolling.scene(
            "The ellipsoid rolls around the sphere; its contact, seen from space.",
            start,
            (1, "1/2", 2),
        ),
        "inner": rolling.scene("Inside a sphere four times as large.", start, (1, 0, 2), {R1: -4}),
    },
    references=("Voronec1911", "Voronec1912", "BorisovMamaev2002"),
)

RELATIONS = (
    Relation.into(
        SYSTEM, "ball-on-sphere", {"height": R2, **dict.fromkeys(axes, R2)}, note="equal axes"
    ),
    Relation.of(SYSTEM, "ellipsoid-on-plane", {"g": 0}, grow=R1, note="a large sphere"),
)

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

from voronec import (
    Equation,
    Fibration,
    Frame,
    Limit,
    Parameter,
    Relation,
    Scene,
    System,
    kinematics,
)

gamma, omega, height = sp.symbols("gamma1:4"), sp.symbols("omega1:4"), sp.Symbol("height")
m, R1 = sp.symbols("m R1")
axes, inertia = sp.symbols("a b c"), sp.symbols("I1:4")

rolling = kinematics.RollingEllipsoid.on_sphere(axes, m, inertia, R1)
theta = rolling.base[1]
u, v, support = rolling.fibre
# At the end of the axis a, the support function is a itself.
start = {theta: 1, u: sp.pi / 2, support: 1}

SYSTEM = System(
    name="ellipsoid-on-sphere",
    title="Ellipsoid on a sphere",
    description="An ellipsoid rolls without slipping over a fixed sphere, or inside it.",
    fibration=Fibration(base=rolling.base, fibre=rolling.fibre, relations=rolling.relations),
    frame=Frame.quasi(rolling.spin),
    lagrangian=rolling.kinetic,
    constraints=rolling.constraints,
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        *(
            Parameter(q, sp.Rational(tenths, 10), positive=True, meaning="semi-axis")
            for q, tenths in zip(axes, (10, 12, 8), strict=True)
        ),
        *(
            Parameter(i, sp.Rational(tenths, 10), positive=True, meaning="principal moment")
            for i, tenths in zip(inertia, (4, 3, 5), strict=True)
        ),
    ),
    invariants=rolling.invariants,
    equations={
        "momentum": Equation(tuple(rolling.momentum), tuple(rolling.momentum_rate())),
        "normal": Equation(gamma, tuple(rolling.turned)),
    },
    integrals={"energy": rolling.momentum.dot(sp.Matrix(omega)) / 2},
    essential=(u, v, support, *omega),
    scenes={
        "default": Scene(
            initial={**start, **dict(zip(omega, (1, sp.Rational(1, 2), 2), strict=True))},
            times=(0.0, 30.0),
            outputs=(*rolling.contact, *omega),
            caption="The ellipsoid rolls around the sphere; its contact, seen from space.",
        ),
        "inner": Scene(
            initial={**start, omega[0]: 1, omega[2]: 2},
            parameters={R1: -4},
            times=(0.0, 30.0),
            outputs=(*rolling.contact, *omega),
            caption="Inside a sphere four times as large.",
        ),
    },
    references=("Voronec1911", "Voronec1912", "BorisovMamaev2002"),
)

g, R2, h = sp.symbols("g R2 h")
RELATIONS = (
    Relation(
        "ball-on-sphere",
        "ellipsoid-on-sphere",
        state={**{q: q for q in (*gamma, *omega)}, height: R2},
        parameters={
            **{q: q for q in (m, R1, *inertia)},
            **dict.fromkeys(axes, R2),
        },
        note="equal axes",
    ),
    Relation(
        "ellipsoid-on-sphere",
        "ellipsoid-on-plane",
        parameters={**{q: q for q in (m, *axes, *inertia)}, g: sp.Integer(0)},
        limit=Limit(h, {R1: 1 / h}),
        note="a large sphere",
    ),
)

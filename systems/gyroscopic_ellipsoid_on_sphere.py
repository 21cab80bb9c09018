"""An ellipsoid with a gyroscope that rolls without slipping over a fixed sphere.

As ``ellipsoid-on-sphere``, with the momentum kappa of a gyroscope, constant in the body:

    dG/dt = (G + kappa) x omega + m dr/dt x (omega x r),
    dgamma/dt = R1 (R1 + H)^-1 (gamma x omega),

G = I omega + m r x (omega x r) about the contact M, r = OM = -S gamma/h, S = diag(a^2, b^2, c^2),
h = (gamma, S gamma)^(1/2) and H = -dr/dgamma.  R1 is signed: negative inside the sphere.
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
kappa = sp.symbols("kappa1:4")

rolling = kinematics.RollingEllipsoid.on_sphere(axes, m, inertia, R1)
theta = rolling.base[1]
u, v, support = rolling.fibre
rotor = sp.Matrix(kappa).dot(sp.Matrix(omega))
# At the end of the axis a, the support function is a itself.
start = {theta: 1, u: sp.pi / 2, support: 1}

SYSTEM = System(
    name="gyroscopic-ellipsoid-on-sphere",
    title="Ellipsoid with a gyroscope on a sphere",
    description="An ellipsoid with a gyroscope rolls without slipping over a fixed sphere, or "
    "inside it.",
    fibration=Fibration(base=rolling.base, fibre=rolling.fibre, relations=rolling.relations),
    frame=Frame.quasi(rolling.spin),
    lagrangian=rolling.kinetic + rotor,
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
        *(
            Parameter(k, sp.Rational(tenths, 10), meaning="momentum of the gyroscope")
            for k, tenths in zip(kappa, (3, -2, 20), strict=True)
        ),
    ),
    invariants=rolling.invariants,
    equations={
        "momentum": Equation(tuple(rolling.momentum), tuple(rolling.momentum_rate(kappa))),
        "normal": Equation(gamma, tuple(rolling.turned)),
    },
    integrals={"energy": rolling.momentum.dot(sp.Matrix(omega)) / 2},
    essential=(u, v, support, *omega),
    scenes={
        "default": Scene(
            initial={**start, **dict(zip(omega, (1, sp.Rational(1, 2), 2), strict=True))},
            times=(0.0, 30.0),
            outputs=(*rolling.contact, *omega),
            caption="The gyroscope steers the ellipsoid around the sphere.",
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
        "gyroscopic-ball-on-sphere",
        "gyroscopic-ellipsoid-on-sphere",
        state={**{q: q for q in (*gamma, *omega)}, height: R2},
        parameters={
            **{q: q for q in (m, R1, *inertia, *kappa)},
            **dict.fromkeys(axes, R2),
        },
        note="equal axes",
    ),
    Relation(
        "gyroscopic-ellipsoid-on-sphere",
        "gyroscopic-ellipsoid-on-plane",
        parameters={**{q: q for q in (m, *axes, *inertia, *kappa)}, g: sp.Integer(0)},
        limit=Limit(h, {R1: 1 / h}),
        note="a large sphere",
    ),
    Relation(
        "gyroscopic-ellipsoid-on-sphere",
        "ellipsoid-on-sphere",
        parameters={q: q for q in (m, R1, *axes, *inertia)},
        limit=Limit(h, {k: h * k for k in kappa}),
        note="the gyroscope stops",
    ),
)

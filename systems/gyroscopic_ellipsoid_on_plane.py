"""A heavy ellipsoid with a gyroscope that rolls without slipping on a horizontal plane.

As ``ellipsoid-on-plane``, with the momentum kappa of a gyroscope, constant in the body:

    dG/dt = (G + kappa) x omega + m dr/dt x (omega x r) + m g r x gamma,  dgamma/dt = gamma x omega,

G = I omega + m r x (omega x r) about the contact M, r = OM = -S gamma/h, S = diag(a^2, b^2, c^2)
and h = (gamma, S gamma)^(1/2).  The gyroscope does no work.  Where it lies along the axis of an
ellipsoid of revolution there is a measure (``gyroscopic-spheroid-on-plane``).
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
m, g = sp.symbols("m g")
axes, inertia = sp.symbols("a b c"), sp.symbols("I1:4")
kappa = sp.symbols("kappa1:4")

rolling = kinematics.RollingEllipsoid.on_plane(axes, m, inertia)
phi, theta, psi = rolling.base
x, y = rolling.fibre
level = rolling.invariants["height"]
rotor = sp.Matrix(kappa).dot(sp.Matrix(omega))
energy = rolling.momentum.dot(sp.Matrix(omega)) / 2 + m * g * height

SYSTEM = System(
    name="gyroscopic-ellipsoid-on-plane",
    title="Ellipsoid with a gyroscope on a plane",
    description="A heavy ellipsoid with a gyroscope rolls without slipping on a horizontal plane.",
    fibration=Fibration(base=rolling.base, fibre=rolling.fibre),
    frame=Frame.quasi(rolling.spin),
    lagrangian=rolling.kinetic - m * g * level + rotor,
    constraints=rolling.constraints,
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(g, 1, meaning="gravity"),
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
        "momentum": Equation(
            tuple(rolling.momentum), tuple(rolling.momentum_rate(kappa, weight=m * g))
        ),
        "normal": Equation(gamma, tuple(rolling.turned)),
    },
    integrals={"energy": energy},
    essential=(theta, psi, *omega),
    scenes={
        "default": Scene(
            initial={theta: 1, psi: 1, **dict(zip(omega, (1, 2, sp.Rational(1, 2)), strict=True))},
            times=(0.0, 30.0),
            outputs=(*rolling.contact, *omega),
            caption="The gyroscope bends the path of the tumbling ellipsoid.",
        ),
        "spheroid": Scene(
            initial={theta: sp.Rational(1, 2), omega[2]: 3, omega[0]: 1},
            parameters={axes[1]: 1, inertia[1]: sp.Rational(2, 5), kappa[0]: 0, kappa[1]: 0},
            times=(0.0, 30.0),
            outputs=(*rolling.contact, *omega),
            caption="An ellipsoid of revolution spins about its axis while it rolls.",
        ),
    },
    references=("Voronec1912", "BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

R, h = sp.symbols("R h")
RELATIONS = (
    Relation(
        "gyroscopic-ball-on-plane",
        "gyroscopic-ellipsoid-on-plane",
        state={**{q: q for q in (*gamma, *omega)}, height: R},
        parameters={
            **{q: q for q in (m, *inertia, *kappa)},
            **dict.fromkeys(axes, R),
            g: sp.Integer(0),
        },
        note="equal axes; weight does nothing to a balanced ball",
    ),
    Relation(
        "gyroscopic-ellipsoid-on-plane",
        "ellipsoid-on-plane",
        parameters={q: q for q in (m, g, *axes, *inertia)},
        limit=Limit(h, {k: h * k for k in kappa}),
        note="the gyroscope stops",
    ),
)

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

from voronec import Equation, Fibration, Frame, Parameter, Relation, Scene, System, kinematics

gamma, omega, height = sp.symbols("gamma1:4"), sp.symbols("omega1:4"), sp.Symbol("height")
m, g = sp.symbols("m g")
axes, inertia = sp.symbols("a b c"), sp.symbols("I1:4")

rolling = kinematics.RollingEllipsoid.on_plane(axes, m, inertia)
phi, theta, psi = rolling.base
x, y = rolling.fibre
level = rolling.invariants["height"]
energy = rolling.momentum.dot(sp.Matrix(omega)) / 2 + m * g * height

SYSTEM = System(
    name="ellipsoid-on-plane",
    title="Ellipsoid on a plane",
    description="A heavy ellipsoid rolls without slipping on a horizontal plane.",
    fibration=Fibration(base=rolling.base, fibre=rolling.fibre),
    frame=Frame.quasi(rolling.spin),
    lagrangian=rolling.kinetic - m * g * level,
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
    ),
    invariants=rolling.invariants,
    equations={
        "momentum": Equation(tuple(rolling.momentum), tuple(rolling.momentum_rate(weight=m * g))),
        "normal": Equation(gamma, tuple(rolling.turned)),
    },
    integrals={"energy": energy},
    essential=(theta, psi, *omega),
    scenes={
        "default": Scene(
            initial={theta: 1, psi: 1, **dict(zip(omega, (1, 2, sp.Rational(1, 2)), strict=True))},
            times=(0.0, 30.0),
            outputs=(*rolling.contact, *omega),
            caption="The ellipsoid tumbles along the plane.",
        ),
        "spheroid": Scene(
            initial={theta: sp.Rational(1, 2), omega[2]: 3, omega[0]: 1},
            parameters={axes[1]: 1, inertia[1]: sp.Rational(2, 5)},
            times=(0.0, 30.0),
            outputs=(*rolling.contact, *omega),
            caption="An ellipsoid of revolution spins about its axis while it rolls.",
        ),
    },
    references=("Voronec1912", "BorisovMamaev2002"),
)

R = sp.Symbol("R")
RELATIONS = (
    Relation(
        "chaplygin-ball",
        "ellipsoid-on-plane",
        state={**{q: q for q in (*gamma, *omega)}, height: R},
        parameters={
            **{q: q for q in (m, *inertia)},
            **dict.fromkeys(axes, R),
            g: sp.Integer(0),
        },
        note="equal axes; weight does nothing to a balanced ball",
    ),
)

"""A heavy spheroid with a gyroscope along its axis that rolls without slipping on a plane.

As ``spheroid-on-plane``, with the momentum kappa = (0, 0, k) of a gyroscope, constant in the body:

    dG/dt = (G + kappa) x omega + m dr/dt x (omega x r) + m g r x gamma,  dgamma/dt = gamma x omega,

G = I omega + m r x (omega x r) about the contact M, r = OM = -S gamma/h, S = diag(a^2, a^2, c^2)
and h = (gamma, S gamma)^(1/2).  The gyroscope along the axis leaves the measure as it is without.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Equation,
    Fibration,
    Frame,
    Limit,
    Measure,
    Parameter,
    Relation,
    Scene,
    System,
    kinematics,
)

gamma, omega, height = sp.symbols("gamma1:4"), sp.symbols("omega1:4"), sp.Symbol("height")
m, g, a, c, A, C, k = sp.symbols("m g a c A C k")
rotor = (0, 0, k)

rolling = kinematics.RollingEllipsoid.on_plane((a, a, c), m, (A, A, C))
phi, theta, psi = rolling.base
energy = rolling.momentum.dot(sp.Matrix(omega)) / 2 + m * g * height

SYSTEM = System(
    name="gyroscopic-spheroid-on-plane",
    title="Spheroid with a gyroscope on a plane",
    description="A heavy ellipsoid of revolution with a gyroscope along its axis rolls without "
    "slipping on a horizontal plane.",
    fibration=Fibration(base=rolling.base, fibre=rolling.fibre),
    frame=Frame.quasi(rolling.spin),
    lagrangian=rolling.kinetic - m * g * rolling.invariants["height"] + k * omega[2],
    constraints=rolling.constraints,
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(g, 1, meaning="gravity"),
        Parameter(a, 1, positive=True, meaning="equatorial semi-axis"),
        Parameter(c, sp.Rational(4, 5), positive=True, meaning="polar semi-axis"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="equatorial moment of inertia"),
        Parameter(C, sp.Rational(1, 2), positive=True, meaning="axial moment of inertia"),
        Parameter(k, sp.Rational(1, 2), meaning="axial momentum of the gyroscope"),
    ),
    invariants=rolling.invariants,
    equations={
        "momentum": Equation(
            tuple(rolling.momentum), tuple(rolling.momentum_rate(rotor, weight=m * g))
        ),
        "normal": Equation(gamma, tuple(rolling.turned)),
    },
    integrals={"energy": energy},
    measure=Measure(rolling.density, (*gamma, height, *omega)),
    essential=(theta, psi, *omega),
    scenes={
        "default": Scene(
            initial={theta: sp.Rational(1, 2), omega[2]: 3, omega[0]: 1},
            times=(0.0, 30.0),
            outputs=(*rolling.contact, *omega),
            caption="The gyroscope bends the path of the spheroid.",
        ),
    },
    references=("Voronec1912", "BorisovMamaev2002"),
)

h = sp.Symbol("h")
RELATIONS = (
    Relation(
        "gyroscopic-spheroid-on-plane",
        "gyroscopic-ellipsoid-on-plane",
        parameters={
            **{q: q for q in (m, g)},
            **dict(zip(sp.symbols("a b c"), (a, a, c), strict=True)),
            **dict(zip(sp.symbols("I1:4"), (A, A, C), strict=True)),
            **dict(zip(sp.symbols("kappa1:4"), rotor, strict=True)),
        },
        note="two axes are equal",
    ),
    Relation(
        "gyroscopic-spheroid-on-plane",
        "spheroid-on-plane",
        parameters={q: q for q in (m, g, a, c, A, C)},
        limit=Limit(h, {k: h * k}),
        note="the gyroscope stops",
    ),
)

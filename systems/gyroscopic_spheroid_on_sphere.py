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
m, R1, a, c, A, C, k = sp.symbols("m R1 a c A C k")
rotor = (0, 0, k)
rolling = kinematics.RollingEllipsoid.spheroid_on_sphere((a, c), m, (A, C), R1)
u, v, u1, v1, theta = rolling.fibre[3:]
level = rolling.invariants["height"]

SYSTEM = System(
    name="gyroscopic-spheroid-on-sphere",
    title="Spheroid with a gyroscope on a sphere",
    description="An ellipsoid of revolution with a gyroscope along its axis rolls without slipping "
    "over a fixed sphere.",
    fibration=Fibration(base=rolling.base, fibre=rolling.fibre),
    frame=Frame.quasi(rolling.spin),
    lagrangian=rolling.kinetic + k * omega[2],
    constraints=rolling.constraints,
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        Parameter(a, 1, positive=True, meaning="equatorial semi-axis"),
        Parameter(c, sp.Rational(4, 5), positive=True, meaning="polar semi-axis"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="equatorial moment of inertia"),
        Parameter(C, sp.Rational(1, 2), positive=True, meaning="axial moment of inertia"),
        Parameter(k, sp.Rational(1, 2), meaning="axial momentum of the gyroscope"),
    ),
    invariants=rolling.invariants,
    equations={
        "momentum": Equation(tuple(rolling.momentum), tuple(rolling.momentum_rate(rotor))),
        "normal": Equation(gamma, tuple(rolling.turned)),
    },
    integrals={"energy": rolling.momentum.dot(sp.Matrix(omega)) / 2},
    measure=Measure(rolling.density * rolling.body.widened(R1), (*gamma, height, *omega)),
    essential=(u, v, *omega),
    charts=rolling.charts,
    scenes={
        "default": Scene(
            initial={
                "chi": 1,
                u: 1,
                u1: 1,
                **dict(zip(omega, (1, sp.Rational(1, 2), 3), strict=True)),
            },
            times=(0.0, 30.0),
            outputs=(u, v, u1, v1, *omega),
            caption="The gyroscope steers the spheroid around the sphere.",
        ),
    },
    drawing={"on the spheroid": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("Voronec1912", "BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

g, h = sp.symbols("g h")
axes, moments, kappa = sp.symbols("a b c"), sp.symbols("I1:4"), sp.symbols("kappa1:4")
frame = kinematics.Surface.sphere(1, u, v).frame
along, across = a**2 * c**2 / level**3, a**2 / level  # radii of curvature
# The vectors that a rolling body carries along: OM, and the directions of u and v.
carried = dict(
    zip(sp.symbols("r1:4"), frame * sp.Matrix([sp.diff(level, u), 0, level]), strict=True)
)
carried |= dict(zip(sp.symbols("e1:4"), frame.col(0), strict=True))
carried |= dict(zip(sp.symbols("f1:4"), frame.col(1), strict=True))
RELATIONS = (
    Relation(
        "gyroscopic-spheroid-on-sphere",
        "gyroscopic-ellipsoid-on-sphere",
        parameters={
            **{q: q for q in (m, R1)},
            **dict(zip(axes, (a, a, c), strict=True)),
            **dict(zip(moments, (A, A, C), strict=True)),
            **dict(zip(kappa, (sp.Integer(0), sp.Integer(0), k), strict=True)),
        },
        note="two axes are equal",
    ),
    Relation(
        "gyroscopic-spheroid-on-sphere",
        "gyroscopic-rolling-body",
        state={
            **{q: q for q in (*rolling.base, *rolling.fibre, *omega)},
            **carried,
        },
        parameters={
            m: m,
            **dict(zip(moments, (A, A, C), strict=True)),
            **dict(zip(kappa, (sp.Integer(0), sp.Integer(0), k), strict=True)),
            "L_u": along,
            "L_v": across * sp.sin(u),
            "k_u": 1 / along,
            "k_v": 1 / across,
            "b_u": 0,
            "b_v": sp.cos(u),
            "L_u1": R1,
            "L_v1": R1 * sp.sin(u1),
            "k_u1": 1 / R1,
            "k_v1": 1 / R1,
            "b_u1": 0,
            "b_v1": sp.cos(u1),
        },
        note="the surfaces are given",
    ),
    Relation(
        "gyroscopic-spheroid-on-sphere",
        "gyroscopic-spheroid-on-plane",
        parameters={**{q: q for q in (m, a, c, A, C, k)}, g: sp.Integer(0)},
        limit=Limit(h, {R1: 1 / h}),
        note="a large sphere",
    ),
    Relation(
        "gyroscopic-spheroid-on-sphere",
        "spheroid-on-sphere",
        parameters={q: q for q in (m, R1, a, c, A, C)},
        limit=Limit(h, {k: h * k}),
        note="the gyroscope stops",
    ),
)

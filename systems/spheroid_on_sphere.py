"""An ellipsoid of revolution that rolls without slipping over a fixed sphere.

Its semi-axes are a, a, c, its moments about the centre O are A, A, C.  gamma is the normal of the
sphere, from the contact M into the spheroid, along its axes; with S = diag(a^2, a^2, c^2) the
support function is h = (gamma, S gamma)^(1/2), which in the angle u between the axis and the outer
normal is (a^2 sin^2 u + c^2 cos^2 u)^(1/2), and r = OM = -S gamma/h.  With H = -dr/dgamma, whose
eigenvalues are the radii of curvature r_u = a^2 c^2/h^3 and r_v = a^2/h,

    dG/dt = G x omega + m dr/dt x (omega x r),    dgamma/dt = R1 (R1 + H)^-1 (gamma x omega),

where G = I omega + m r x (omega x r).  R1 is signed: negative inside the sphere.  The measure is
that on a plane [BorisovMamaev2002] times (R1 + r_u) (R1 + r_v); its density holds the
factor h because h is one of its variables, bound to gamma.

It is the body of revolution on a sphere (``symmetric-body-on-sphere``) with that support function
and without a force: the linear equations of that body, for Z = rho omega_3 and
J = (G, r) (R1 + r_v)/r_v with u for the time, are carried over to this one by the relation.  Two
integrals, linear in omega, follow from their solutions, which are not elementary in general; they
are not declared.

Neumann's coordinates (u, v, u1, v1, theta) follow from omega; the spheroid is placed by Euler's
angles and by its centre seen from it, o = (o1, o2, o3).  Neither is in the equations, so that any
values do for them.  A ball is a spheroid too, with a = c; but its own chart does not hold these,
so that no relation leads from ``symmetric-ball-on-sphere`` to here: the two meet in
``symmetric-body-on-sphere`` and in ``ellipsoid-on-sphere``.
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
m, R1, a, c, A, C = sp.symbols("m R1 a c A C")
rolling = kinematics.RollingEllipsoid.spheroid_on_sphere((a, c), m, (A, C), R1)
u, v, u1, v1, theta = rolling.fibre[3:]
level = rolling.invariants["height"]

SYSTEM = System(
    name="spheroid-on-sphere",
    title="Spheroid on a sphere",
    description="An ellipsoid of revolution rolls without slipping over a fixed sphere.",
    fibration=Fibration(base=rolling.base, fibre=rolling.fibre),
    frame=Frame.quasi(rolling.spin),
    lagrangian=rolling.kinetic,
    constraints=rolling.constraints,
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        Parameter(a, 1, positive=True, meaning="equatorial semi-axis"),
        Parameter(c, sp.Rational(4, 5), positive=True, meaning="polar semi-axis"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="equatorial moment of inertia"),
        Parameter(C, sp.Rational(1, 2), positive=True, meaning="axial moment of inertia"),
    ),
    invariants=rolling.invariants,
    equations={
        "momentum": Equation(tuple(rolling.momentum), tuple(rolling.momentum_rate())),
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
            caption="The spheroid spins about its axis while it rolls around the sphere.",
        ),
    },
    drawing={"on the spheroid": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("Voronec1912", "BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

g, h = sp.symbols("g h")
axes, moments = sp.symbols("a b c"), sp.symbols("I1:4")
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
        "spheroid-on-sphere",
        "ellipsoid-on-sphere",
        parameters={
            **{q: q for q in (m, R1)},
            **dict(zip(axes, (a, a, c), strict=True)),
            **dict(zip(moments, (A, A, C), strict=True)),
        },
        note="two axes are equal",
    ),
    Relation(
        "spheroid-on-sphere",
        "symmetric-body-on-sphere",
        state={
            **{q: q for q in (u, v, theta, u1, v1)},
            **dict(zip(sp.symbols("s tau n"), frame.T * sp.Matrix(omega), strict=True)),
        },
        parameters={
            **{q: q for q in (R1, m, A, C)},
            sp.Function("P")(u): level,
            sp.Function("V")(u): sp.Integer(0),
        },
        note="its support function, and no force",
    ),
    Relation(
        "spheroid-on-sphere",
        "rolling-body",
        state={
            **{q: q for q in (*rolling.base, *rolling.fibre, *omega)},
            **carried,
        },
        parameters={
            m: m,
            **dict(zip(moments, (A, A, C), strict=True)),
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
        "spheroid-on-sphere",
        "spheroid-on-plane",
        parameters={**{q: q for q in (m, a, c, A, C)}, g: sp.Integer(0)},
        limit=Limit(h, {R1: 1 / h}),
        note="a large sphere",
    ),
)

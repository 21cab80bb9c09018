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

from voronec import Relation, kinematics

omega = sp.symbols("omega1:4")
m, R1, a, c, A, C = sp.symbols("m R1 a c A C")

rolling = kinematics.RollingEllipsoid.spheroid_on_sphere((a, c), m, (A, C), R1)
u, v, u1, v1, theta = rolling.fibre[3:]

SYSTEM = rolling.system(
    name="spheroid-on-sphere",
    title="Spheroid on a sphere",
    description="An ellipsoid of revolution rolls without slipping over a fixed sphere.",
    values={m: 1, R1: 2, a: 1, c: "0.8", A: "0.4", C: "0.5"},
    scenes={
        "default": rolling.scene(
            "The spheroid spins about its axis while it rolls around the sphere.",
            {"chi": 1, u: 1, u1: 1},
            (1, "1/2", 3),
        ),
    },
    drawing={"on the spheroid": ("u", "v"), "on the sphere": ("u1", "v1")},
    references=("Voronec1912", "BorisovMamaev2002", "DragovicGajicJovanovic2020"),
)

moments = {"I1": A, "I2": A, "I3": C}
spins = kinematics.matrix_product(kinematics.Surface.sphere(1, u, v).frame.T, omega)
state, functions = rolling.as_any_body
RELATIONS = (
    Relation.of(
        SYSTEM,
        "ellipsoid-on-sphere",
        {"a": a, "b": a, "c": c, **moments},
        note="two axes are equal",
    ),
    Relation.of(
        SYSTEM,
        "symmetric-body-on-sphere",
        {sp.Function("P")(u): rolling.invariants["height"], sp.Function("V")(u): 0},
        state={
            **{q: q for q in (u, v, theta, u1, v1)},
            **dict(zip(sp.symbols("s tau n"), spins, strict=True)),
        },
        note="its support function, and no force",
    ),
    Relation.of(
        SYSTEM, "rolling-body", {**moments, **functions}, state=state, note="the surfaces are given"
    ),
    Relation.of(SYSTEM, "spheroid-on-plane", {"g": 0}, grow=R1, note="a large sphere"),
)

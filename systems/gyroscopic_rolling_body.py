"""Any body with a gyroscope that rolls without slipping on any surface.

Both surfaces are given by their fundamental forms along lines of curvature, in unknown functions:
the lengths L_u, L_v, the curvatures k_u = -D/E, k_v = -D''/G and the bendings b_u, b_v of the
coordinate lines, E_v/(2 L_u L_v) and G_u/(2 L_u L_v); those of the fixed surface bear the mark 1.
u, v, u1, v1, theta are Neumann's coordinates [Neumann1899].  Along the axes of the body, r = OM
points from the mass centre to the contact, e and f lie along the lines of curvature of the body
at M, and n = e x f.  The contact moves over the body with the velocity (x, y) along e and f, which
follows from the angular velocity by the relative curvature; then

    dr/dt = x e + y f,    dG/dt = (G + kappa) x omega + m dr/dt x (omega x r),
    G = I omega + m r x (omega x r):

the momentum about the contact, as in [Voronec1911], with the constant momentum kappa of the
gyroscope.
What is proved here holds for every pair of surfaces; the equations of Codazzi and Gauss are not
needed for it.  The energy is the only integral.  A system in which the functions are given is a
special case, by a relation (``gyroscopic-torus-on-ellipsoid``, ``gyroscopic-spheroid-on-sphere``);
unknown functions have no values, so that there is no motion to show here.
"""

from __future__ import annotations

import sympy as sp

from voronec import Equation, Fibration, Frame, Limit, Parameter, Relation, System, kinematics

m, inertia, kappa = sp.Symbol("m"), sp.symbols("I1:4"), sp.symbols("kappa1:4")
carried = kinematics.CarriedContact.unknown(m, inertia)
contact, omega = carried.contact, carried.omega

SYSTEM = System(
    name="gyroscopic-rolling-body",
    title="Rolling body with a gyroscope",
    description="Any body with a gyroscope rolls without slipping on any surface.",
    fibration=Fibration(base=carried.base, fibre=tuple(carried.rates)),
    frame=Frame.quasi(carried.spin),
    lagrangian=carried.kinetic + omega.dot(sp.Matrix(kappa)),
    constraints=carried.constraints,
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        *(
            Parameter(i, sp.Rational(tenths, 10), positive=True, meaning="principal moment")
            for i, tenths in zip(inertia, (4, 3, 5), strict=True)
        ),
        *(
            Parameter(k, sp.Rational(tenths, 10), meaning="momentum of the gyroscope")
            for k, tenths in zip(kappa, (3, -2, 20), strict=True)
        ),
    ),
    equations={"momentum": Equation(tuple(carried.momentum), tuple(carried.momentum_rate(kappa)))},
    integrals={"energy": carried.momentum.dot(omega) / 2},
    essential=(*(q for axis in carried.vectors[1:] for q in axis), *contact.coordinates, *omega),
    references=("Neumann1899", "Voronec1911", "Voronec1912", "DragovicGajicJovanovic2020"),
)

# A torus on an ellipsoid of revolution: what is known there, by the names there.
R, r, a, c, A, C, k, h = sp.symbols("R r a c A C k h")
u, v, u1, v1, theta = contact.coordinates
w, quasi = sp.Symbol("w"), sp.Matrix(sp.symbols("s tau n"))
torus = kinematics.Surface.torus(R, r, u, v)
reach = R + r * sp.sin(u)
forms = {
    "L_u": r,
    "L_v": reach,
    "k_u": 1 / r,
    "k_v": sp.sin(u) / reach,
    "b_u": 0,
    "b_v": sp.cos(u),
    "L_u1": c**2 / (a * w**3),
    "L_v1": a * sp.sin(u1) / w,
    "k_u1": a * w**3 / c**2,
    "k_v1": w / a,
    "b_u1": 0,
    "b_v1": sp.cos(u1),
}
RELATIONS = (
    Relation(
        "gyroscopic-torus-on-ellipsoid",
        "gyroscopic-rolling-body",
        state={
            **{q: q for q in (*carried.base, *carried.vectors[0], *contact.coordinates)},
            **dict(zip(carried.vectors[1], torus.position, strict=True)),
            **dict(zip(carried.vectors[2], torus.frame[:, 0], strict=True)),
            **dict(zip(carried.vectors[3], torus.frame[:, 1], strict=True)),
            **dict(zip(omega, torus.frame * quasi, strict=True)),
        },
        parameters={
            m: m,
            **dict(zip(inertia, (A, A, C), strict=True)),
            **dict(zip(kappa, (sp.Integer(0), sp.Integer(0), k), strict=True)),
            **forms,
        },
        note="the surfaces are given",
    ),
    Relation(
        "gyroscopic-rolling-body",
        "rolling-body",
        parameters={
            **{q: q for q in (m, *inertia)},
            **{f: sp.Function(f)(*((u1, v1) if f.endswith("1") else (u, v))) for f in forms},
        },
        limit=Limit(h, {k: h * k for k in kappa}),
        note="the gyroscope stops",
    ),
)

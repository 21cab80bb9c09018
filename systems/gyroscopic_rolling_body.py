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

from voronec import Relation, kinematics

m, inertia, kappa = sp.Symbol("m"), sp.symbols("I1:4"), sp.symbols("kappa1:4")
body = kinematics.CarriedContact.unknown(m, inertia)

SYSTEM = body.system(
    name="gyroscopic-rolling-body",
    title="Rolling body with a gyroscope",
    description="Any body with a gyroscope rolls without slipping on any surface.",
    rotor=kappa,
    values={m: 1, inertia: ("0.4", "0.3", "0.5"), kappa: ("0.3", "-0.2", "2")},
    references=("Neumann1899", "Voronec1911", "Voronec1912", "DragovicGajicJovanovic2020"),
)

# A torus on an ellipsoid of revolution: what is known there, by the names there.
R, r, a, c, A, C, k = sp.symbols("R r a c A C k")
u, v, u1, v1, theta = body.contact.coordinates
special = kinematics.TorusOnEllipsoid((R, r), (a, c), m, (A, C), k).body
state, functions = special.as_any_body
moments = {"I1": A, "I2": A, "I3": C, "kappa1": 0, "kappa2": 0, "kappa3": k}
RELATIONS = (
    Relation.into(
        SYSTEM,
        "gyroscopic-torus-on-ellipsoid",
        {**state, **moments, **functions},
        note="the surfaces are given",
    ),
    Relation.of(
        SYSTEM,
        "rolling-body",
        {f: sp.Function(f)(*((u1, v1) if f.endswith("1") else (u, v))) for f in functions},
        vanish=kappa,
        note="the gyroscope stops",
    ),
)

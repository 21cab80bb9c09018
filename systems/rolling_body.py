"""Any body that rolls without slipping on any surface.

Both surfaces are given by their fundamental forms along lines of curvature, in unknown functions:
the lengths L_u, L_v, the curvatures k_u = -D/E, k_v = -D''/G and the bendings b_u, b_v of the
coordinate lines, E_v/(2 L_u L_v) and G_u/(2 L_u L_v); those of the fixed surface bear the mark 1.
u, v, u1, v1, theta are Neumann's coordinates [Neumann1899].  Along the axes of the body, r = OM
points from the mass centre to the contact, e and f lie along the lines of curvature of the body
at M, and n = e x f.  The contact moves over the body with the velocity (x, y) along e and f, which
follows from the angular velocity by the relative curvature; then

    dr/dt = x e + y f,    dG/dt = G x omega + m dr/dt x (omega x r),
    G = I omega + m r x (omega x r):

the momentum about the contact, as in [Voronec1911].  What is proved here holds for every pair of
surfaces; the equations of Codazzi and Gauss are not needed for it.  The energy is the only
integral.  A system in which the functions are given is a special case, by a relation, where its
chart carries the contact along as here: ``torus-on-ellipsoid``, ``spheroid-on-sphere``.  An
ellipsoid of three axes has lines of curvature too, but the colatitude and longitude of its normal,
by which ``ellipsoid-on-sphere`` knows the contact, are not along them.  The position of a body in
Neumann's coordinates alone, as in ``symmetric-body-on-sphere``, gives Euler's angles by inverse
trigonometric functions only, and that system has a force; this one has none.  Unknown functions
have no values, so that there is no motion to show here.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

m, inertia = sp.Symbol("m"), sp.symbols("I1:4")
body = kinematics.CarriedContact.unknown(m, inertia)

SYSTEM = body.system(
    name="rolling-body",
    title="Rolling body",
    description="Any body rolls without slipping on any surface.",
    values={m: 1, inertia: ("0.4", "0.3", "0.5")},
    references=("Neumann1899", "Voronec1911", "Voronec1912", "DragovicGajicJovanovic2020"),
)

# A torus on an ellipsoid of revolution: what is known there, by the names there.
R, r, a, c, A, C = sp.symbols("R r a c A C")
special = kinematics.TorusOnEllipsoid((R, r), (a, c), m, (A, C)).body
state, functions = special.as_any_body
RELATIONS = (
    Relation.into(
        SYSTEM,
        "torus-on-ellipsoid",
        {**state, "I1": A, "I2": A, "I3": C, **functions},
        note="the surfaces are given",
    ),
)

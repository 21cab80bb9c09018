"""The Chaplygin sleigh: a rigid body on a plane, held by a blade that does not slip sideways.

The blade touches the plane at (x, y) and points along (cos phi, sin phi); the centre of mass lies
on the line of the blade, at the distance ``a`` before the point of contact.  With the speed v along
the blade and the rate of turning w,

    vdot = a w^2,    wdot = -m a v w / (J + m a^2)    [Chaplygin1911].
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
    Case,
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Scene,
    System,
    kinematics,
    velocity,
)

x, y, phi = sp.symbols("x y phi")
v, w = sp.symbols("v w")
m, J, a = sp.symbols("m J a")
Dx, Dy, Dphi = velocity(x), velocity(y), velocity(phi)

# The velocity of the centre of mass, (x, y) + a (cos phi, sin phi).
centre = (Dx - a * Dphi * sp.sin(phi), Dy + a * Dphi * sp.cos(phi))
kinetic = m * (centre[0] ** 2 + centre[1] ** 2) / 2 + J * Dphi**2 / 2

K = J + m * a**2
# v and w run along a half of an ellipse, and the heading turns in proportion to the angle there;
# w does not change its sign, so the angle is written without a jump where v = 0.
turned = sp.sqrt(K / m) * sp.atan(v * sp.sqrt(m / K) / w)

SYSTEM = System(
    name="sleigh",
    title="Chaplygin sleigh",
    description="A rigid body on a plane, supported by a blade that does not slip sideways.",
    sketch=kinematics.sleigh_sketch((x, y), phi, a),
    fibration=Fibration(base=(x, phi), fibre=(y,)),
    frame=Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
    lagrangian=kinetic,
    constraints=(Dx * sp.sin(phi) - Dy * sp.cos(phi),),
    meanings={
        **kinematics.sleigh_meanings((x, y), phi, (v, w)),
        "heading": "a times the heading in the middle of the turn, where v = 0",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(J, sp.Rational(1, 2), positive=True, meaning="inertia about the centre of mass"),
        Parameter(a, sp.Rational(3, 10), meaning="centre of mass, before the blade"),
    ),
    integrals={"energy": kinetic, "heading": a * phi - turned},
    equations={
        "speed": Equation(v, a * w**2),
        "turning": Equation(w, -m * a * v * w / K),
    },
    # The turning dies out, so no measure is invariant whose density is smooth where w = 0.
    measure=Measure(1 / w, variables=(v, w)),
    integrable="Euler-Jacobi",
    essential=(v, w),
    cases={
        "centre of mass over the blade": Case(
            parameters={a: 0},
            integrals={
                "speed": v,
                "turning": w,
                "centre of the circle, x": x * w - v * sp.sin(phi),
                "centre of the circle, y": y * w + v * sp.cos(phi),
            },
            measure=sp.Integer(1),
            integrable="Euler-Jacobi",
            note="A knife edge: circles, run through uniformly; the measure is smooth.",
        ),
    },
    scenes={
        "default": Scene(
            initial={v: sp.Rational(-1), w: sp.Rational(1, 20)},
            times=(0.0, 20.0),
            outputs=(x, y, phi, v, w),
            caption="Pushed backwards, the sleigh turns about and goes on with the blade behind.",
        ),
    },
    bodies=(Body(m, (*centre, 0), (0, 0, J), (0, 0, Dphi), title="sleigh"),),
    shapes=kinematics.sleigh_shapes((x, y), phi, a),
    references=("Chaplygin1911", "Caratheodory1933", "NeimarkFufaev1972"),
)

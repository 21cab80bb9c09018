"""The Chaplygin sleigh: a rigid body on a plane, held by a blade that does not slip sideways.

The blade touches the plane at (x, y) and points along (cos phi, sin phi); the centre of mass lies
on the line of the blade, at the distance ``a`` before the point of contact.
"""

from __future__ import annotations

import sympy as sp

from voronec import Fibration, Frame, Parameter, Scene, System, velocity

x, y, phi = sp.symbols("x y phi")
v, w = sp.symbols("v w")
m, J, a = sp.symbols("m J a")
Dx, Dy, Dphi = velocity(x), velocity(y), velocity(phi)

# The velocity of the centre of mass, (x, y) + a (cos phi, sin phi).
centre = (Dx - a * Dphi * sp.sin(phi), Dy + a * Dphi * sp.cos(phi))
kinetic = m * (centre[0] ** 2 + centre[1] ** 2) / 2 + J * Dphi**2 / 2

SYSTEM = System(
    name="sleigh",
    title="Chaplygin sleigh",
    description="A rigid body on a plane, supported by a blade that does not slip sideways.",
    fibration=Fibration(base=(x, phi), fibre=(y,)),
    frame=Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
    lagrangian=kinetic,
    constraints=(Dx * sp.sin(phi) - Dy * sp.cos(phi),),
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(J, sp.Rational(1, 2), positive=True, meaning="inertia about the centre of mass"),
        Parameter(a, sp.Rational(3, 10), meaning="centre of mass, before the blade"),
    ),
    # The angular velocity dies out, so no measure with a smooth positive density is invariant.
    integrals={"energy": kinetic},
    scenes={
        "default": Scene(
            initial={v: sp.Rational(-1), w: sp.Rational(1, 20)},
            times=(0.0, 20.0),
            outputs=(x, y, phi, v, w),
            caption="Pushed backwards, the sleigh turns about and goes on with the blade behind.",
        ),
    },
    references=("Chaplygin1911", "Caratheodory1933", "NeimarkFufaev1972"),
)

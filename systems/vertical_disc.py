"""The vertical rolling disc: a coin on its edge, kept upright, rolling without slipping.

It touches the plane at (x, y), heads along (cos phi, sin phi) and has turned by ``theta`` about
its axle.
"""

from __future__ import annotations

import sympy as sp

from voronec import Fibration, Parameter, Scene, System, velocity

x, y, phi, theta = sp.symbols("x y phi theta")
m, R, B, C = sp.symbols("m R B C")
Dx, Dy, Dphi, Dtheta = map(velocity, (x, y, phi, theta))

kinetic = (m * (Dx**2 + Dy**2) + B * Dtheta**2 + C * Dphi**2) / 2

SYSTEM = System(
    name="vertical-disc",
    title="Vertical rolling disc",
    description="A disc that rolls upright on a plane without slipping, and turns freely.",
    fibration=Fibration(base=(theta, phi), fibre=(x, y)),
    lagrangian=kinetic,
    constraints=(Dx - R * Dtheta * sp.cos(phi), Dy - R * Dtheta * sp.sin(phi)),
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        Parameter(B, sp.Rational(1, 2), positive=True, meaning="inertia about the axle"),
        Parameter(C, sp.Rational(1, 4), positive=True, meaning="inertia about a diameter"),
    ),
    # The contact point describes a circle; its centre, multiplied by the rate of turning, is
    # regular where that rate vanishes.
    integrals={
        "energy": kinetic,
        "rolling": Dtheta,
        "turning": Dphi,
        "centre of the circle, x": x * Dphi - R * Dtheta * sp.sin(phi),
        "centre of the circle, y": y * Dphi + R * Dtheta * sp.cos(phi),
    },
    measure=sp.Integer(1),
    scenes={
        "default": Scene(
            initial={Dtheta: sp.Rational(1), Dphi: sp.Rational(1, 2)},
            times=(0.0, 15.0),
            outputs=(x, y, phi, theta),
            caption="The contact point describes a circle of radius 2.",
        ),
        "straight": Scene(
            initial={Dtheta: sp.Rational(1)},
            times=(0.0, 10.0),
            outputs=(x, y, phi, theta),
            caption="Without turning, the disc rolls straight on.",
        ),
    },
    references=("NeimarkFufaev1972", "Bloch2015"),
)

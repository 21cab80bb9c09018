"""The falling rolling disc: a coin that rolls on its edge without slipping, and may lean.

It touches the plane at (x, y) and heads along e = (cos phi, sin phi, 0).  With the lean ``theta``
to the left, the radius from the contact to the centre is r = (-sin theta sin phi, sin theta
cos phi, cos theta) times R; the disc has turned by ``psi`` about its axle e x r (backwards).
The quasi-velocities are the components of the angular velocity: p about -e, q about r, and s
about the axle.  Along r and the axle, the vertical is gamma2 = cos(theta), gamma3 = sin(theta), and

    A gamma2 qdot = (A gamma3 q + C gamma2 s) p,    (C + m R^2) sdot = m R^2 q p.

With gamma3' = gamma2 p these are two linear equations for q and s as functions of theta, which
Legendre functions solve [Appell1900, Korteweg1900]; their constants are two further integrals.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Scene,
    Shape,
    System,
    kinematics,
    velocity,
)

x, y, phi, theta, psi = sp.symbols("x y phi theta psi")
p, q, s = sp.symbols("p q s")
m, R, A, C, g = sp.symbols("m R A C g")
gamma2, gamma3 = sp.symbols("gamma2 gamma3")
Dx, Dy, Dphi, Dtheta, Dpsi = map(velocity, (x, y, phi, theta, psi))
sin, cos = sp.sin(theta), sp.cos(theta)

# The centre's velocity: along the heading, to its left, upwards.
forward = Dx * sp.cos(phi) + Dy * sp.sin(phi) - R * Dphi * sin
left = Dy * sp.cos(phi) - Dx * sp.sin(phi) + R * Dtheta * cos
upward = -R * Dtheta * sin
spin = Dpsi - Dphi * sin

kinetic = m * (forward**2 + left**2 + upward**2) / 2
kinetic += (A * (Dtheta**2 + Dphi**2 * cos**2) + C * spin**2) / 2
potential = m * g * R * cos

contact_point, heading = sp.Matrix([x, y, 0]), sp.Matrix([sp.cos(phi), sp.sin(phi), 0])
radius = sp.Matrix([-sin * sp.sin(phi), sin * sp.cos(phi), cos])
attitude = sp.Matrix.hstack(
    heading * sp.cos(psi) - radius * sp.sin(psi),
    -radius * sp.cos(psi) - heading * sp.sin(psi),
    radius.cross(heading),
)

SYSTEM = System(
    name="falling-disc",
    title="Falling rolling disc",
    description="A disc that rolls on its edge without slipping and leans under its weight.",
    sketch=kinematics.disc_sketch((x, y), phi, psi, theta),
    fibration=Fibration(base=(phi, theta, psi), fibre=(x, y)),
    frame=Frame.quasi({p: Dtheta, q: Dphi * cos, s: spin}),
    lagrangian=kinetic - potential,
    constraints=(Dx - R * Dpsi * sp.cos(phi), Dy - R * Dpsi * sp.sin(phi)),
    meanings={
        **kinematics.place_meanings((x, y), "the contact on the plane"),
        phi: "heading of the disc, from the first axis",
        theta: "lean of the disc to the left, from the vertical",
        psi: "turn of the disc about its axle, backwards",
        p: "rate of the lean",
        q: "angular velocity about the radius from the contact to the centre",
        s: "angular velocity about the axle",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        Parameter(A, "1/4", positive=True, meaning="inertia about a diameter"),
        Parameter(C, "1/2", positive=True, meaning="inertia about the axle"),
        Parameter(g, 1, meaning="gravity"),
    ),
    invariants={"gamma2": cos, "gamma3": sin},
    integrals={"energy": kinetic + potential},
    equations={
        "vertical": Equation((gamma2, gamma3), (-gamma3 * p, gamma2 * p)),
        "lean": Equation(
            (A + m * R**2) * p,
            m * g * R * gamma3 - A * gamma3 / gamma2 * q**2 - (C + m * R**2) * q * s,
        ),
        "linear in q and s": Equation(
            (A * gamma2 * q, (C + m * R**2) * s),
            (C * gamma2 * p * s, m * R**2 * p * q),
        ),
    },
    measure=Measure(gamma2, variables=(gamma2, gamma3, p, q, s)),
    essential=(theta, p, q, s),
    scenes={
        "default": Scene(
            initial={theta: "1/5", q: "2/5", s: "3/2"},
            times=(0.0, 25.0),
            outputs=(x, y, phi, theta, psi),
            caption="Fast enough to stay up, the disc nods while it rolls.",
        ),
    },
    bodies=(
        Body(
            m,
            tuple(
                sp.Matrix([Dx, Dy, 0]) + R * (radius.diff(phi) * Dphi + radius.diff(theta) * Dtheta)
            ),
            (A, A, C),
            (-Dtheta, -Dphi * cos, spin),
            force=(0, 0, -m * g),
            turning=(-Dtheta, -Dphi * cos, -Dphi * sin),
            title="disc",
        ),  # along the heading, down the radius, and along the axle
    ),
    shapes=(
        Shape.disc(R, centre=contact_point + R * radius, attitude=attitude, contact=(x, y, 0)),
        Shape.plane(),
    ),
    references=("Appell1900", "Korteweg1900", "Chaplygin1897", "BorisovMamaevKilin2003"),
)

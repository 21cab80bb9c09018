"""A sleigh that gathers snow: Chaplygin's sleigh whose mass and inertia grow in time.

The snow lies at rest before it is taken up, and sticks so that mass and inertia grow in one
proportion, 1 + g t, while the centre of mass stays where it is in the sleigh.  The Lagrangian
depends on the time; momenta, not velocities, are what the snow preserves.  With the momenta for
velocities and dtau = dt/(1 + g t) this is the sleigh of constant mass.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Relation,
    Scene,
    System,
    kinematics,
    time,
    velocity,
)

x, y, phi = sp.symbols("x y phi")
v, w = sp.symbols("v w")
m, J, a, g = sp.symbols("m J a g")
Dx, Dy, Dphi = velocity(x), velocity(y), velocity(phi)

growth = 1 + g * time
centre = (Dx - a * Dphi * sp.sin(phi), Dy + a * Dphi * sp.cos(phi))
kinetic = growth * (m * (centre[0] ** 2 + centre[1] ** 2) + J * Dphi**2) / 2
K = J + m * a**2

SYSTEM = System(
    name="growing-sleigh",
    title="Sleigh that gathers snow",
    description="A Chaplygin sleigh that takes up snow lying at rest: mass and inertia depend on "
    "the time.",
    sketch=kinematics.sleigh_sketch((x, y), phi, a),
    fibration=Fibration(base=(x, phi), fibre=(y,)),
    frame=Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
    lagrangian=kinetic,
    constraints=(Dx * sp.sin(phi) - Dy * sp.cos(phi),),
    meanings={
        **kinematics.sleigh_meanings((x, y), phi, (v, w)),
        "energy, as of the momenta": "energy that the momenta have with the first mass",
        "heading": "a times the heading in the middle of the turn, where v = 0",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass at the time 0"),
        Parameter(J, sp.Rational(1, 2), positive=True, meaning="inertia at the time 0"),
        Parameter(a, sp.Rational(3, 10), meaning="centre of mass, before the blade"),
        Parameter(g, sp.Rational(1, 10), lower=0, meaning="rate of growth"),
    ),
    integrals={
        "energy, as of the momenta": growth * kinetic,
        "heading": a * phi - sp.sqrt(K / m) * sp.atan(v * sp.sqrt(m / K) / w),
    },
    equations={
        "momentum": Equation(growth * v, growth * a * w**2),
        "angular momentum": Equation(growth * w, -growth * m * a * v * w / K),
    },
    measure=Measure(growth / w, variables=(v, w)),
    essential=(v, w),
    scenes={
        "default": Scene(
            initial={v: sp.Rational(-1), w: sp.Rational(1, 20)},
            times=(0.0, 40.0),
            outputs=(x, y, phi, v, w),
            caption="The growing sleigh runs along the same track as the constant one, but ever "
            "more slowly.",
        ),
    },
    shapes=kinematics.sleigh_shapes((x, y), phi, a),
    references=("Chaplygin1911", "NeimarkFufaev1972"),
)

RELATIONS = (
    Relation(
        "growing-sleigh",
        "sleigh",
        state={"x": x, "y": y, "phi": phi, "v": growth * v, "w": growth * w},
        parameters={"m": m, "J": J, "a": a},
        clock=1 / growth,
        note="The same track in another time, which depends on time alone.",
    ),
)

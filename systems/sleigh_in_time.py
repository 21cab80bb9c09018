"""Chaplygin's sleigh whose body slides across the blade, to and fro, in a prescribed way.

The blade has no mass; the whole rigid body on it slides, so that J stays the same about the moving
centre of mass, which is at the distance ``a`` before the blade's point of contact and, to the left,
at b(t) = b1 sin(nu t).  With the speed v along the blade and the rate of turning w, the momentum
p = m (v - b w) along the blade and the angular momentum M about the point of contact obey

    p' = m w (a w + b'),    M' = -m v (a w + b'),    M = J w + a m (a w + b') - b p.

The equations for v and w hold the time, and the motion is chaotic [BizyaevBorisovMamaev2017]; but
where a = 0 the sleigh turns uniformly, and nothing is gained from the swing in the mean.
"""

from __future__ import annotations

import sympy as sp

from voronec import Case, Equation, Measure, Parameter, Relation, kinematics, time, velocity

x, y, phi = sp.symbols("x y phi")
v, w = sp.symbols("v w")
m, J, a, b1, nu = sp.symbols("m J a b1 nu")
Dx, Dy, Dphi = velocity(x), velocity(y), velocity(phi)

b = b1 * sp.sin(nu * time)
Db = b.diff(time)
sleigh = kinematics.Sleigh(m, J, a, "b(t)")
# The velocity of the centre of mass, along the blade and across.
forward = sleigh.forward - b * Dphi
across = Dy * sp.cos(phi) - Dx * sp.sin(phi) + a * Dphi + Db

drift = m * (a * w + Db)
momentum = m * (v - b * w)
angular_momentum = J * w + a * drift - b * momentum

SYSTEM = sleigh.system(
    name="sleigh-in-time",
    title="Sleigh with a sliding body",
    description="A Chaplygin sleigh whose body slides across the blade in a prescribed way: "
    "the Lagrangian depends on the time.",
    lagrangian=(m * (forward**2 + across**2) + J * Dphi**2) / 2,
    values={
        m: 1,
        J: "1/2",
        a: "3/10",
        b1: Parameter(b1, "1/2", meaning="amplitude of the swing"),
        nu: Parameter(nu, 2, meaning="angular frequency of the swing"),
    },
    equations={
        "momentum": Equation(momentum, w * drift),
        "angular momentum": Equation(angular_momentum, -v * drift),
    },
    cases={
        "centre of mass beside the blade": Case(
            parameters={a: 0},
            integrals={"turning": w, "speed less swing": v - 2 * b * w},
            measure=Measure(sp.Integer(1), variables=(v, w)),
        ),
    },
    scenes={
        "default": sleigh.scene(
            "The swing of the body drives the sleigh.", 60.0, {v: "1/5", w: "1/2"}
        ),
    },
    references=("BizyaevBorisovMamaev2017", "Chaplygin1911"),
)

RELATIONS = (Relation.into(SYSTEM, "sleigh", {b1: 0, nu: 1}, note="The swing has no amplitude."),)

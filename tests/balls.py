"""A ball that rolls on a plane, in any chart of its attitude: what several tests take apart."""

from __future__ import annotations

import sympy as sp

from voronec import Fibration, Frame, System, kinematics, velocity

x, y, m, R = sp.symbols("x y m R")
omega = sp.symbols("omega1:4")
inertia = sp.symbols("I1:4")
gamma = sp.symbols("gamma1:4")


def rolling_ball(rotation, invariants=None):
    vertical = rotation.matrix.row(2)
    named = dict(zip(map(str, gamma), vertical, strict=True))
    return System(
        name="ball",
        fibration=Fibration(rotation.coordinates, (x, y), relations=rotation.relations),
        frame=Frame.quasi(dict(zip(omega, rotation.body_rates, strict=True))),
        lagrangian=kinematics.kinetic_energy(
            m, (velocity(x), velocity(y), 0), inertia, rotation.body_rates
        ),
        constraints=(
            velocity(x) - R * rotation.space_rates[1], velocity(y) + R * rotation.space_rates[0],
        ),
        parameters=(m, R, *inertia),
        invariants=named if invariants is None else invariants,
    )  # fmt: skip

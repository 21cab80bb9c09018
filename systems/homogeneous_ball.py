"""The ordinary ball on a plane: its moment of inertia, A, is the same about all axes.

It rolls along a straight line and keeps its angular velocity, both in space and in the ball.
"""

from __future__ import annotations

import sympy as sp

from voronec import Relation, kinematics

R, m, A = sp.symbols("R m A")

ball = kinematics.BalancedBall.on_plane(R, m, (A, A, A))
omega = ball.motion.spin

SYSTEM = ball.system(
    name="homogeneous-ball",
    title="Ordinary ball on a plane",
    description="A ball whose inertia is the same about all axes rolls without slipping on a "
    "plane.",
    meanings={
        **{f"spin {k}": f"angular velocity along axis {k} of the ball" for k in (1, 2, 3)},
    },
    values={R: 1, m: 1, A: "0.4"},
    integrals={f"spin {i + 1}": w for i, w in enumerate(omega)},
    essential=tuple(omega),
    integrable="Euler-Jacobi",
    scenes={"default": ball.scene("A straight line.")},
    references=("Chaplygin1903", "BorisovMamaev2002"),
)

RELATIONS = (Relation.of(SYSTEM, "chaplygin-ball", {"I1": A, "I2": A, "I3": A}),)

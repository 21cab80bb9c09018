"""Passing the poles of C. Neumann's coordinates: the motion is smooth there, its angles are not."""

from __future__ import annotations

import sympy as sp

from voronec.accuracy.hard.case import HardCase
from voronec.declaration.scene import Scene

__all__ = ["POLES"]

R = sp.Rational
u, v = sp.symbols("u v")
DEMCHENKO = (sp.cos(u), sp.sin(u) * sp.cos(v), sp.sin(u) * sp.sin(v), "u", "v", "theta", "n")
BALL = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")


def _past(distance: sp.Rational) -> dict[str, object]:
    """Demchenko's ball at its least distance from the pole of the ball, which comes again."""
    return {"u": distance, "s": R(1, 2), "n": R(3, 2), "u1": 1}


def _spinning_start(u0: object, *omega: object) -> dict[str, object]:
    return {"u": u0, "theta": 1, "u1": 1, "omega1": omega[0], "omega2": omega[1],
            "omega3": omega[2]}  # fmt: skip


POLES = (
    HardCase(
        "near-the-pole", "demchenko",
        Scene(_past(R(1, 1000)), (0, 5), {}, DEMCHENKO,
              "Demchenko's contact passes the ball's pole at the distance 1e-3, again and again."),
        points=21,
    ),
    HardCase(
        "grazing-the-pole", "demchenko",
        Scene(_past(R(1, 10**6)), (0, 5), {}, DEMCHENKO,
              "Demchenko's contact passes the ball's pole at the distance 1e-6: v and theta jump "
              "by almost pi."),
        points=21,
    ),
    HardCase(
        "through-the-pole", "ball-on-sphere",
        Scene(_spinning_start(2, 2, 0, 0) | {"theta": 0, "v": sp.pi / 2}, (0, 10), {}, BALL,
              "The contact runs along a meridian through both poles of the ball; in angles the "
              "equations have poles on the way."),
        level="invariants",
    ),
    HardCase(
        "past-the-pole-of-the-ball", "gyroscopic-ball-on-sphere",
        Scene(_spinning_start(R(1, 10**8), R(1, 2), 1, 1), (0, 20), {}, BALL,
              "A ball with a gyroscope starts 1e-8 from the pole of its coordinates."),
        level="invariants",
    ),
    HardCase(
        "past-the-pole-of-the-sphere", "ball-on-sphere",
        Scene(_spinning_start(2, R(1, 2), 1, 1) | {"u1": R(1, 10**6)}, (0, 20), {}, BALL,
              "The contact starts 1e-6 from the pole of the fixed sphere, and nothing that is "
              "wanted knows of it."),
        level="invariants",
    ),
    HardCase(
        "start-at-the-pole", "ball-on-sphere",
        Scene(_spinning_start(0, R(1, 2), 1, 1), (0, 20), {}, BALL,
              "The start is the pole itself: the angles are undefined there, the motion is not."),
        level="invariants",
    ),
    HardCase(
        "angles-from-the-pole", "ball-on-sphere",
        Scene(_spinning_start(0, R(1, 2), 1, 1), (0, 20), {},
              (sp.cos(u), sp.sin(u) * sp.cos(v), sp.sin(u) * sp.sin(v)),
              "The same start, and what is wanted is written in the angles: the contact leaves the "
              "pole along a meridian of its own, whatever v the start names."),
        level="invariants",
    ),
)  # fmt: skip

"""Long times: 1e5 and 1e6 units."""

from __future__ import annotations

import sympy as sp

from voronec.accuracy.hard.case import HardCase
from voronec.declaration.scene import Scene

__all__ = ["SPANS"]

R = sp.Rational
u = sp.Symbol("u")
BALL = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
CONTACT = (sp.cos(u), "s", "tau", "n")
DEMCHENKO_START = {"u": 1, "s": R(1, 5), "n": R(3, 2), "u1": 1}

SPANS = (
    HardCase(
        "long", "demchenko",
        Scene(DEMCHENKO_START, (0, 10**5), {}, CONTACT,
              "Demchenko's ball for 1e5 units of time, tens of thousands of periods."),
        points=11, period="tau", methods=("heyoka",),
    ),
    HardCase(
        "very-long", "demchenko",
        Scene(DEMCHENKO_START, (0, 10**6), {}, CONTACT, "The same for 1e6 units."),
        points=11, period="tau", methods=("heyoka",),
    ),
    HardCase(
        "long-and-not-periodic", "ball-on-sphere",
        Scene({"u": 2, "theta": 1, "u1": 1, "omega1": R(1, 2), "omega2": 1, "omega3": 1},
              (0, 1000), {}, BALL,
              "A non-symmetric ball on a sphere for 1000 units: not periodic, not integrable."),
        points=51, level="invariants", arithmetic="extended", methods=("heyoka",),
    ),
)  # fmt: skip

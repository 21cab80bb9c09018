"""Systems close to a limit: other systems, other dimensions, other clocks."""

from __future__ import annotations

import sympy as sp

from voronec.accuracy.hard.case import HardCase
from voronec.declaration.scene import Scene

__all__ = ["LIMITS"]

R = sp.Rational
u, u1 = sp.symbols("u u1")
BALL = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
CONTACT = ("u", "s", "tau", "n")
DEMCHENKO_START = {"u": 1, "s": R(1, 5), "n": R(3, 2), "u1": 1}
BALL_START = {"u": 2, "theta": 1, "u1": 1, "omega1": R(1, 2), "omega2": 1, "omega3": 1}


LIMITS = (
    HardCase(
        "fast-gyroscope", "demchenko",
        Scene(DEMCHENKO_START, (0, 10), {"k": 1000}, CONTACT,
              "The gyroscope is a thousand times faster than the ball: the ball trembles."),
        arithmetic="extended",
    ),
    HardCase(
        "very-fast-gyroscope", "demchenko",
        Scene(DEMCHENKO_START, (0, R(1, 10)), {"k": 10**5}, CONTACT,
              "The gyroscope is 1e5 times faster than the ball."),
        arithmetic="extended",
    ),
    HardCase(
        "slow-gyroscope", "demchenko",
        Scene(DEMCHENKO_START, (0, 40), {"k": R(1, 10**8)}, (*CONTACT, "v", "theta", "u1", "v1"),
              "A gyroscope of momentum 1e-8."),
        arithmetic="extended",
    ),
    HardCase(
        "no-gyroscope", "demchenko",
        Scene(DEMCHENKO_START, (0, 40), {"k": 0}, CONTACT,
              "No gyroscope at all: formulas that divide by k fail."),
    ),
    HardCase(
        "nearly-equal-radii", "ball-on-sphere",
        Scene(BALL_START, (0, R(1, 4)), {"R1": -R(10001, 10000)}, BALL,
              "A ball in a hollow that is larger by 1e-4 only: epsilon is 1e4, and the contact "
              "runs round 1e4 times faster than the ball turns."),
        level="invariants", arithmetic="extended",
    ),
    HardCase(
        "equal-radii", "ball-on-sphere",
        Scene(BALL_START, (0, 1), {"R1": -1}, BALL,
              "The ball fills its hollow: epsilon is infinite, and no motion of this kind exists."),
        level="",
    ),
    HardCase(
        "nearly-a-plane", "ball-on-sphere",
        Scene(BALL_START, (0, 40), {"R1": 10**9}, BALL,
              "A sphere 1e9 times as large as the ball: epsilon - 1 is 1e-9."),
        level="invariants", arithmetic="extended",
    ),
    HardCase(
        "trace-on-nearly-a-plane", "demchenko",
        Scene(DEMCHENKO_START, (0, 40), {"R1": 10**6}, (10**6 * (u1 - 1), "u", "n"),
              "A sphere 1e6 times as large, and the trace of the contact on it is wanted: six "
              "digits cancel."),
    ),
    HardCase(
        "nearly-symmetric", "ball-on-sphere",
        Scene(BALL_START, (0, 100), {"I1": R(2, 5), "I2": R(2, 5) + R(1, 10**9)}, BALL,
              "Two moments of inertia differ by 1e-9."),
        level="invariants", arithmetic="extended",
    ),
    HardCase(
        "nearly-zhukovsky", "symmetric-gyroscopic-ball-on-sphere",
        Scene(BALL_START, (0, 40), {"C": R(2, 5) + R(1, 10**9)}, BALL,
              "Zhukovsky's condition is missed by 1e-9: closed formulas divide by C - A."),
        level="invariants", arithmetic="extended",
    ),
    HardCase(
        "rod-like-inertia", "ball-on-sphere",
        Scene(BALL_START, (0, 10), {"I1": R(1, 10**6), "I2": R(1, 2), "I3": R(1, 2)}, BALL,
              "One moment of inertia is 1e-6 of the others: the mass matrix is nearly singular "
              "where the contact is on that axis."),
        level="invariants", arithmetic="extended",
    ),
    HardCase(
        "point-like-inertia", "demchenko",
        Scene(DEMCHENKO_START, (0, 5), {"A": R(1, 10**4), "k": 1}, CONTACT,
              "Almost all mass is at the centre: the inertia of spinning is 1e-4."),
    ),
    HardCase(
        "turning-point", "demchenko",
        Scene(DEMCHENKO_START, (0, 40), {}, (sp.cos(u), *CONTACT, "v", "theta"),
              "The start is a turning point of u, where a quadrature in u has a root in its "
              "denominator."),
        arithmetic="extended",
    ),
    HardCase(
        "tiny-nutation", "demchenko",
        Scene({"u": 1, "u1": 1, "n": R(3, 2), "s": R(22915797, 10**7)}, (0, 40), {},
              (u - 1, "tau", "s"),
              "Steady precession, almost: the nutation that is wanted is 1e-9 of u."),
    ),
)  # fmt: skip

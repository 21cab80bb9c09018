"""Motions that magnify small changes: separatrices, unstable turning, chaos."""

from __future__ import annotations

import sympy as sp

from voronec.accuracy.hard.case import HardCase
from voronec.declaration.scene import Scene

__all__ = ["GROWTH"]

R = sp.Rational
u = sp.Symbol("u")
BALL = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
SLEIGH = ("x", "y", "phi", "v", "w")
SLID = {"x": 1, "v": R(1, 2), "w": R(1, 2)}

GROWTH = (
    HardCase(
        "near-a-separatrix", "demchenko",
        Scene({"u": R(9, 5), "u1": 1, "n": 1, "s": R(704202307, 10**8)}, (0, 12), {},
              (sp.cos(u), "u", "s", "tau", "n"),
              "Demchenko's ball starts 4e-9 from an unstable steady rolling, and comes back."),
        methods=("heyoka", "scipy", "lsoda", "flint"),
    ),
    HardCase(
        "middle-axis", "chaplygin-ball",
        Scene({"theta": sp.pi / 2, "omega1": R(1, 10**8), "omega2": 2, "omega3": R(1, 10**8)},
              (0, 100), {}, BALL,
              "Chaplygin's ball turns about its middle axis, almost: it turns over at long "
              "intervals, each time from 1e-8 of the separatrix."),
        level="invariants",
    ),
    HardCase(
        "repelling-turning", "suslov",
        Scene({"theta": 1, "omega1": -R(3, 2), "omega2": R(3, 4) + R(1, 10**9)}, (0, 60), {},
              ("omega1", "omega2", "gamma1", "gamma2", "gamma3"),
              "Suslov's body starts 1e-9 from a steady turning that repels, and goes over to the "
              "one that attracts."),
        level="invariants",
    ),
    HardCase(
        "chaotic-ball", "ball-on-sphere",
        Scene({"u": 2, "theta": 1, "u1": 1, "omega1": R(1, 2), "omega2": 3, "omega3": 1},
              (0, 200), {"I1": R(1, 5), "I2": R(1, 2), "I3": R(13, 20)}, BALL,
              "A non-symmetric ball on a sphere, which is not integrable."),
        points=101, level="invariants", chaotic=True, arithmetic="extended",
    ),
    HardCase(
        "chaotic-sleigh", "sleigh-on-turntable",
        Scene(SLID, (0, 100), {"a": 0}, SLEIGH,
              "Neither reversible nor integrable, Lyapunov exponent about 0.07: errors of either "
              "kind show."),
        points=101, chaotic=True,
    ),
    HardCase(
        "chaotic-sleigh-for-longer", "sleigh-on-turntable",
        Scene(SLID, (0, 250), {"a": 0}, SLEIGH,
              "The same until most digits of a double are spent."),
        points=126, chaotic=True,
    ),
    HardCase(
        "past-the-horizon", "sleigh-on-turntable",
        Scene(SLID, (0, 600), {"a": 0}, ("x", "y", "v", "w"),
              "The same for so long that no double determines where the sleigh is; the Jacobi "
              "integral must hold all the same."),
        points=121, chaotic=True,
    ),
    HardCase(
        "attracted-sleigh", "sleigh-on-turntable",
        Scene({"x": 1, "v": -R(1, 2), "w": R(1, 2)}, (0, 100), {}, SLEIGH,
              "Neither reversible nor integrable, and volume is lost: the standard tests of "
              "nonholonomic integrators have nothing of it."),
        points=101,
    ),
    HardCase(
        "rattling", "rattleback",
        Scene({"theta": R(1, 100), "omega1": R(1, 50), "omega3": -R(1, 2)}, (0, 60), {},
              ("omega1", "omega2", "omega3", "gamma1", "gamma2"),
              "A rattleback spun against its hand: what rattles is tiny at first, and decides."),
        arithmetic="extended",
    ),
)  # fmt: skip

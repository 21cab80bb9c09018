"""The catalogue of hard cases: those of this package, and those beside systems of others.

A plugin declares its own beside its system, ``HARD_CASES = (HardCase(...), ...)`` in the module
that holds ``SYSTEM``.  Nothing is imported from a system here: systems are named.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module

import sympy as sp

from voronec.accuracy.hard.case import HardCase
from voronec.declaration.catalogue import entries
from voronec.declaration.scene import Scene
from voronec.errors import DefinitionError, did_you_mean

R = sp.Rational
u, v, u1 = sp.symbols("u v u1")
BALL = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
CONTACT_ON_SPHERE = (sp.cos(u), sp.sin(u) * sp.cos(v), sp.sin(u) * sp.sin(v))
SLEIGH = ("x", "y", "phi", "v", "w")
SLID = {"x": 1, "v": R(1, 2), "w": R(1, 2)}
CONTACT = ("u", "s", "tau", "n")
PERIODIC = (sp.cos(u), "s", "tau", "n")
DEMCHENKO_START = {"u": 1, "s": R(1, 5), "n": R(3, 2), "u1": 1}
BALL_START = {"u": 2, "theta": 1, "u1": 1, "omega1": R(1, 2), "omega2": 1, "omega3": 1}


def _past(distance: sp.Rational) -> dict[str, object]:
    """Demchenko's ball at its least distance from the pole of the ball, which comes again."""
    return {"u": distance, "s": R(1, 2), "n": R(3, 2), "u1": 1}


def _spinning_start(u0: object, *omega: object) -> dict[str, object]:
    return BALL_START | {"u": u0} | dict(zip(BALL[3:], omega, strict=True))


POLES = (
    HardCase(
        "near-the-pole", "demchenko",
        Scene(_past(R(1, 1000)), (0, 5), {}, (*CONTACT_ON_SPHERE, "u", "v", "theta", "n"),
              "Demchenko's contact passes the ball's pole at the distance 1e-3, again and again."),
        points=21,
    ),
    HardCase(
        "grazing-the-pole", "demchenko",
        Scene(_past(R(1, 10**6)), (0, 5), {}, (*CONTACT_ON_SPHERE, "u", "v", "theta", "n"),
              "Demchenko's contact passes the ball's pole at the distance 1e-6: v and theta jump "
              "by almost pi."),
        points=21,
    ),
    HardCase(
        "through-the-pole", "ball-on-sphere",
        Scene(_spinning_start(2, 2, 0, 0) | {"theta": 0, "v": sp.pi / 2}, (0, 10), {}, BALL,
              "The contact runs along a meridian through both poles of the ball; in angles the "
              "equations have poles on the way."),
        formulation="invariants",
    ),
    HardCase(
        "past-the-pole-of-the-ball", "gyroscopic-ball-on-sphere",
        Scene(_spinning_start(R(1, 10**8), R(1, 2), 1, 1), (0, 20), {}, BALL,
              "A ball with a gyroscope starts 1e-8 from the pole of its coordinates."),
        formulation="invariants",
    ),
    HardCase(
        "past-the-pole-of-the-sphere", "ball-on-sphere",
        Scene(_spinning_start(2, R(1, 2), 1, 1) | {"u1": R(1, 10**6)}, (0, 20), {}, BALL,
              "The contact starts 1e-6 from the pole of the fixed sphere, and nothing that is "
              "wanted knows of it."),
        formulation="invariants",
    ),
    HardCase(
        "start-at-the-pole", "ball-on-sphere",
        Scene(_spinning_start(0, R(1, 2), 1, 1), (0, 20), {}, BALL,
              "The start is the pole itself: the angles are undefined there, the motion is not."),
        formulation="invariants",
    ),
    HardCase(
        "angles-from-the-pole", "ball-on-sphere",
        Scene(_spinning_start(0, R(1, 2), 1, 1), (0, 20), {},
              CONTACT_ON_SPHERE,
              "A start at the pole, with outputs in the angles: the contact leaves the "
              "pole along a meridian of its own, whatever v the start names."),
        formulation="invariants",
    ),
)  # fmt: skip
"""Passing the poles of C. Neumann's coordinates: the motion is smooth there, its angles are not."""

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
        formulation="invariants",
    ),
    HardCase(
        "repelling-turning", "suslov",
        Scene({"theta": 1, "omega1": -R(3, 2), "omega2": R(3, 4) + R(1, 10**9)}, (0, 60), {},
              ("omega1", "omega2", "gamma1", "gamma2", "gamma3"),
              "Suslov's body starts 1e-9 from a steady turning that repels, and goes over to the "
              "one that attracts."),
        formulation="invariants",
    ),
    HardCase(
        "chaotic-ball", "ball-on-sphere",
        Scene({"u": 2, "theta": 1, "u1": 1, "omega1": R(1, 2), "omega2": 3, "omega3": 1},
              (0, 200), {"I1": R(1, 5), "I2": R(1, 2), "I3": R(13, 20)}, BALL,
              "A non-symmetric ball on a sphere, which is not integrable."),
        points=101, formulation="invariants", chaotic=True, arithmetic="extended",
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
              "The chaotic sleigh until most digits of a double are spent."),
        points=126, chaotic=True,
    ),
    HardCase(
        "past-the-horizon", "sleigh-on-turntable",
        Scene(SLID, (0, 600), {"a": 0}, ("x", "y", "v", "w"),
              "It runs for so long that no double determines where the sleigh is; the Jacobi "
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
"""Motions that magnify small changes: separatrices, unstable turning, chaos."""

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
        formulation="invariants", arithmetic="extended",
    ),
    HardCase(
        "equal-radii", "ball-on-sphere",
        Scene(BALL_START, (0, 1), {"R1": -1}, BALL,
              "The ball fills its hollow: epsilon is infinite, and no motion of this kind exists."),
        formulation="",
    ),
    HardCase(
        "nearly-a-plane", "ball-on-sphere",
        Scene(BALL_START, (0, 40), {"R1": 10**9}, BALL,
              "A sphere 1e9 times as large as the ball: epsilon - 1 is 1e-9."),
        formulation="invariants", arithmetic="extended",
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
        formulation="invariants", arithmetic="extended",
    ),
    HardCase(
        "nearly-zhukovsky", "symmetric-gyroscopic-ball-on-sphere",
        Scene(BALL_START, (0, 40), {"C": R(2, 5) + R(1, 10**9)}, BALL,
              "Zhukovsky's condition is missed by 1e-9: closed formulas divide by C - A."),
        formulation="invariants", arithmetic="extended",
    ),
    HardCase(
        "rod-like-inertia", "ball-on-sphere",
        Scene(BALL_START, (0, 10), {"I1": R(1, 10**6), "I2": R(1, 2), "I3": R(1, 2)}, BALL,
              "One moment of inertia is 1e-6 of the others: the mass matrix is nearly singular "
              "where the contact is on that axis."),
        formulation="invariants", arithmetic="extended",
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
"""Systems close to a limit: other systems, other dimensions, other clocks."""

SPANS = (
    HardCase(
        "long", "demchenko",
        Scene(DEMCHENKO_START, (0, 10**5), {}, PERIODIC,
              "Demchenko's ball for 1e5 units of time, tens of thousands of periods."),
        points=11, period="tau", methods=("heyoka",),
    ),
    HardCase(
        "very-long", "demchenko",
        Scene(DEMCHENKO_START, (0, 10**6), {}, PERIODIC, "Demchenko's ball for 1e6 units of time."),
        points=11, period="tau", methods=("heyoka",),
    ),
    HardCase(
        "long-and-not-periodic", "ball-on-sphere",
        Scene(BALL_START, (0, 1000), {}, BALL,
              "A non-symmetric ball on a sphere for 1000 units: not periodic, not integrable."),
        points=51, formulation="invariants", arithmetic="extended", methods=("heyoka",),
    ),
)  # fmt: skip
"""Long times: 1e5 and 1e6 units."""

CASES: tuple[HardCase, ...] = (*POLES, *GROWTH, *LIMITS, *SPANS)
"""The cases of this package."""
QUICK = ("near-the-pole", "start-at-the-pole", "near-a-separatrix", "turning-point", "no-gyroscope")
"""A short selection, for tests."""
OWN = "voronec"


def every_case() -> tuple[tuple[HardCase, ...], tuple[str, ...]]:
    """All cases, and a warning for each module of others that could not be read."""
    cases, warnings = list(CASES), []
    for entry in entries()[0]:
        if entry.distribution == OWN or not entry.module:
            continue
        try:
            cases += _beside(entry.module)
        except Exception as error:  # somebody else's module may fail in any way
            warnings.append(f"the hard cases of system '{entry.name}' cannot be read: {error}")
    return tuple(cases), tuple(warnings)


def _beside(module: str) -> tuple[HardCase, ...]:
    declared = getattr(import_module(module), "HARD_CASES", ())
    for case in declared:
        if not isinstance(case, HardCase):
            raise DefinitionError(
                f"{module}: an entry of HARD_CASES is a {type(case).__name__}; write "
                "HARD_CASES = (HardCase(...),)"
            )
    return tuple(declared)


def named_cases(names: Iterable[str], among: Iterable[HardCase]) -> tuple[HardCase, ...]:
    """The cases of those names; ``DefinitionError`` with the nearest names for an unknown one."""
    known = {case.name: case for case in among}
    chosen = []
    for name in names:
        if name not in known:
            raise DefinitionError(f"there is no hard case '{name}'{did_you_mean(name, known)}")
        chosen.append(known[name])
    return tuple(chosen)

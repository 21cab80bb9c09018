"""The closed form of Demchenko's ball against motions that share no code with it.

The stored values, ``tools/figures/closed-references.json``, come of an integration in 85 digits
without coordinates.
"""

from __future__ import annotations

import importlib
import json
import sys
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

import voronec as vo
from voronec.closed.classes import classify

pytestmark = pytest.mark.slow

TOOLS = Path(__file__).resolve().parent.parent / "tools"
REFERENCES = json.loads((TOOLS / "figures" / "closed-references.json").read_text("utf-8"))
ANGLES = ("u", "v", "u1", "v1", "theta")
CLASSES = [name for name, told in REFERENCES.items() if told["group"] == "class"]
HARD = [name for name, told in REFERENCES.items() if told["group"] == "hard"]
LAST = ("1e-12", "1e12", "1e9")
EXTREME = [n for n in HARD if "1e" not in n or n.endswith(LAST)]
EXTREME += [n for n in HARD if "pole" in n and n.endswith("1e-10")]
ENDLESS = [name for name, told in REFERENCES.items() if told["group"] == "asymptotic"]
ORDINARY = REFERENCES["start near a turning point, 1e-2"]["given"]
UNUSUAL = {
    "nothing moves": {"s": "0", "tau": "0", "n": "0"},
    "nothing moves, no gyroscope": {"s": "0", "tau": "0", "n": "0", "k": "0"},
    "no momentum": {"u": "acos(3/5)", "k": "1", "s": "4/7", "tau": "0", "n": "-3/2"},
    "no gyroscope, along a meridian": {"k": "0", "n": "0", "s": "0"},
    "no gyroscope, along the equator": {"k": "0", "n": "0", "tau": "0", "s": "1", "u": "pi/2"},
    "unstable steady rolling": {
        "k": "-3", "u": "acos(20/29)", "s": "-14/5", "tau": "0", "n": "1096/1281",
    },
    "through the pole of the ball, K across": {
        "k": "-5", "u": "acos(3/5)", "s": "-1713/560", "tau": "-9/5", "n": "-12/5",
    },
    "start at a turning point": {"tau": "0"},
}  # fmt: skip
STORED = mpmath.mpf("2e-41")
"""What the rounding of a stored value to 42 digits may be, of angles."""


def tool(name: str) -> Any:
    """A module of ``tools``."""
    if str(TOOLS) not in sys.path:
        sys.path.insert(0, str(TOOLS))
    return importlib.import_module(name)


@cache
def closed_form(name: str) -> Any:
    start = tool("figures.closed_references").exact_start(REFERENCES[name]["given"])
    return vo.closed_form(vo.load("demchenko"), **start)


def instants(name: str) -> np.ndarray:
    return np.array([float.fromhex(row[0]) for row in REFERENCES[name]["values"]])


def true(name: str) -> dict[str, list[Any]]:
    """The stored values of the angles, a list over instants each."""
    rows = REFERENCES[name]["values"]
    with mpmath.workdps(60):
        return {n: [mpmath.mpf(row[1 + i]) for row in rows] for i, n in enumerate(ANGLES)}


def errors(name: str, found: dict[str, np.ndarray]) -> dict[str, list[float]]:
    """Differences of doubles from the stored values, modulo whole turns."""
    apart = tool("figures.closed_references").apart
    with mpmath.workdps(60):
        return {
            n: [float(apart(n, mpmath.mpf(float(a)), b)) for a, b in zip(found[n], x, strict=True)]
            for n, x in true(name).items()
        }


@pytest.mark.parametrize("name", [*CLASSES, *EXTREME])
def test_doubles_keep_13_digits_in_every_angle_modulo_whole_turns(name: str) -> None:
    closed = closed_form(name)
    for angle, off in errors(name, closed.modulo(instants(name), ANGLES)).items():
        assert max(off) < 1e-13, f"{angle}: {off}"


@pytest.mark.parametrize("name", CLASSES[::3])
def test_continuous_angles_lose_no_more_than_whole_turns_take(name: str) -> None:
    times, closed = instants(name), closed_form(name)
    found = closed.at(times, ANGLES)
    for angle, off in errors(name, found).items():
        held = 1e-13 + 4 * np.spacing(np.abs(found[angle]))
        assert (np.array(off) < held).all(), f"{angle}: {off}"


@pytest.mark.parametrize("name", [*CLASSES[::5], *EXTREME[::4], *ENDLESS])
def test_enclosures_hold_the_stored_digits_however_late(name: str) -> None:
    closed, exact = closed_form(name), true(name)
    apart = tool("figures.closed_references").apart
    for i, t in enumerate(instants(name)):
        found = closed.enclose(float(t), digits=45)
        with mpmath.workdps(60):
            for angle in ANGLES:
                middle, radius = (
                    mpmath.mpf(part.str(60, radius=False))
                    for part in (found[angle].mid(), found[angle].rad())
                )
                assert radius < 1e-45
                assert apart(angle, middle, exact[angle][i]) < STORED, f"{angle} at {t}"


@pytest.mark.parametrize("name", CLASSES)
def test_the_class_is_the_one_that_the_motion_was_found_for(name: str) -> None:
    trace = classify(closed_form(name))["on the ball"]
    whole = "+".join(part for part in trace.label.split("+") if part not in ("A|C", "B", "C"))
    assert (whole or trace.label) == name.split()[1]


@pytest.mark.parametrize("changed", UNUSUAL.values(), ids=[*UNUSUAL])
def test_unusual_starts_are_followed_like_any_other(changed: dict[str, str]) -> None:
    given = {**ORDINARY, **changed}
    start = tool("figures.closed_references").exact_start(given)
    closed = vo.closed_form(vo.load("demchenko"), **start)
    motion = tool("figures.closed_motion").Motion(given, digits=25)
    times = np.array([0.0, 0.75, 2.5])
    doubles = closed.modulo(times)
    apart = tool("figures.closed_references").apart
    for i, t in enumerate(times):
        exact, balls = motion.at(Fraction(float(t))), closed.enclose(float(t), digits=20)
        with mpmath.workdps(30):
            for name, found in doubles.items():
                middle = mpmath.mpf(balls[name].mid().str(30, radius=False))
                assert apart(name, middle, exact[name]) < 1e-19
                assert apart(name, mpmath.mpf(float(found[i])), exact[name]) < 1e-14


@pytest.mark.parametrize("name", ENDLESS)
def test_doubles_follow_a_motion_towards_a_double_root(name: str) -> None:
    for angle, off in errors(name, closed_form(name).modulo(instants(name), ANGLES)).items():
        assert max(off) < 1e-13, f"{angle}: {off}"


@pytest.mark.parametrize("name", [*CLASSES[::4], *HARD[::9]])
def test_the_period_is_that_of_the_integration(name: str) -> None:
    assert closed_form(name).period == pytest.approx(float(REFERENCES[name]["period"]), rel=4e-16)


def test_the_stored_motions_are_those_declared() -> None:
    declared = tool("figures.closed_references").motions()
    assert {*declared} == {*REFERENCES}
    for name, told in declared.items():
        assert told["given"] == REFERENCES[name]["given"]


@pytest.mark.parametrize("name", ["inner B", "near the pole of the ball, 1e-6", "shell pole"])
def test_stored_values_come_out_again_in_fewer_digits(name: str) -> None:
    given = REFERENCES[name]["given"]
    motion = tool("figures.closed_motion").Motion(given, "theta" not in given, digits=30)
    t = Fraction(float(instants(name)[0]))
    with mpmath.workdps(40):
        for angle, values in true(name).items():
            assert abs(motion.at(t)[angle] - values[0]) < 1e-24


def test_whole_periods_agree_with_integration_all_the_way() -> None:
    motion = tool("figures.closed_motion").Motion(REFERENCES["outer C1"]["given"], digits=25)
    t = 4 * motion.turns[0] + Fraction(1, 3)
    with mpmath.workdps(40):
        here, there = motion.at(t), motion.later(t)
        assert all(abs(here[n] - there[n]) < 1e-20 for n in here)


def test_the_independent_motion_keeps_energy_and_meets_its_start() -> None:
    given = REFERENCES["shell A"]["given"]
    motion = tool("figures.closed_motion").Motion(given, digits=25)
    with mpmath.workdps(40):
        begun, later = motion.at(Fraction(0)), motion.at(Fraction(7, 5))
        d = motion.data
        assert all(abs(begun[n] - d[n]) < 1e-24 for n in (*ANGLES, "s", "tau", "n"))
        inertia = d["M"] * d["R2"] ** 2 + d["A"]
        energies = [inertia * (x["s"] ** 2 + x["tau"] ** 2) + d["A"] * x["n"] ** 2
                    for x in (begun, later)]  # fmt: skip
        assert abs(energies[0] - energies[1]) < 1e-22 and abs(begun["u"] - later["u"]) > 0.01

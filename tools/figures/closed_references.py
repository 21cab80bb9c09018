"""References of the closed form: ``python tools/bench.py references [NAME ...]``.

Writes ``closed-references.json`` beside itself: for each motion of ``bench_closed_motions`` its
instants, exact doubles, and the values there to 42 digits, by whole periods of one period
integrated in 85 digits.  With ``--follow`` the motions of the classes are also integrated all the
way through 100 periods in 52 digits, and the largest difference is noted; that takes half a minute
each.
"""

from __future__ import annotations

import json
import random
import sys
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import sympy as sp

from figures.closed_motion import NAMES, Motion
from figures.closed_motions import asymptotic, classes, hard

STORE = Path(__file__).resolve().parent / "closed-references.json"
ANGLES = NAMES[:5]
DIGITS = 42
WORK_DIGITS = 85
ROUTE_DIGITS = 52
LATE = 1e6
ENDLESS = (0.5, 2.0, 5.0, 9.0)
"""Instants of the motions that have no period."""


def motions() -> dict[str, dict[str, Any]]:
    """Every motion that is measured, by its name: group and data."""
    groups = {"class": classes(), "hard": hard(), "asymptotic": asymptotic()}
    return {
        name: {"group": g, "given": d} for g, some in groups.items() for name, d in some.items()
    }


def exact_start(given: Mapping[str, str]) -> dict[str, dict[str, Any]]:
    """Parameters and initial data in exact expressions; K is along z where no theta is given."""
    d = {n: sp.sympify(given.get(n, "0")) for n in (*NAMES, "R1", "R2", "M", "A", "k")}
    if "theta" not in given:
        inertia = d["M"] * d["R2"] ** 2 + d["A"]
        along_u, along_v = inertia * d["s"] - d["k"] * sp.sin(d["u"]), inertia * d["tau"]
        along_n = d["A"] * d["n"] + d["k"] * sp.cos(d["u"])
        d["theta"] = sp.atan2(along_u, -along_v)
        d["u1"] = sp.atan2(sp.sqrt(along_u**2 + along_v**2), -along_n)
    names = ("R1", "R2", "M", "A", "k")
    return {"parameters": {n: d[n] for n in names}, "initial": {n: d[n] for n in NAMES}}


def apart(name: str, a: Any, b: Any) -> Any:
    """The difference of two values; of longitudes and theta, modulo 2 pi."""
    off = a - b
    if name in ("v", "v1", "theta"):
        off -= 2 * mpmath.pi * mpmath.nint(off / (2 * mpmath.pi))
    return abs(off)


def entry(name: str, told: Mapping[str, Any], follow: bool) -> dict[str, Any]:
    """Instants and values of one motion, and how it was made."""
    given, group = told["given"], told["group"]
    motion = Motion(given, "theta" not in given, WORK_DIGITS)
    names = NAMES if group == "class" else ANGLES
    if group == "asymptotic":
        rows = [(t, motion.at(Fraction(t))) for t in ENDLESS]
        return {**told, "period": None, "values": _texts(rows, names)}
    period = motion.turns[0]
    dice = random.Random(name)
    parts = [dice.uniform(0, 3), dice.uniform(30, 70), dice.uniform(99, 100)]
    early = [float(period) * x for x in parts]
    late = [float(period) * x for x in (LATE * dice.uniform(0.3, 0.9), LATE)]
    rows = [(t, motion.later(Fraction(t))) for t in early + late]
    found = {**told, "period": _text(_ratio(period)), "values": _texts(rows, names)}
    if follow and group == "class":
        found["followed"] = _text(_follow(motion, early), 2)
    return found


def _follow(motion: Motion, instants: list[float]) -> Any:
    """How far an integration all the way is from what whole periods tell."""
    other = Motion(motion.given, motion.upright, ROUTE_DIGITS)
    worst = mpmath.mpf(0)
    for t in instants:
        a, b = other.at(Fraction(t), keep=False), motion.later(Fraction(t))
        worst = max(worst, *(apart(n, a[n], b[n]) for n in NAMES))
    return worst


def _texts(rows: list[tuple[float, dict[str, Any]]], names: tuple[str, ...]) -> list[list[str]]:
    return [[t.hex(), *(_text(values[n]) for n in names)] for t, values in rows]


def _text(x: Any, digits: int = DIGITS) -> str:
    return str(mpmath.nstr(x, digits))


def _ratio(x: Fraction) -> Any:
    with mpmath.workdps(WORK_DIGITS):
        return mpmath.mpf(x.numerator) / x.denominator


def main() -> int:
    """Make the references of the named motions, or those that are missing or have changed."""
    follow = "--follow" in sys.argv[1:]
    named = [a for a in sys.argv[1:] if a != "--follow"]
    known = json.loads(STORE.read_text("utf-8")) if STORE.exists() else {}
    wanted = motions()
    for name, told in wanted.items():
        old = known.get(name, {})
        made = all(old.get(key) == x for key, x in told.items())
        made = made and ("followed" in old or not follow or told["group"] != "class")
        if name in named or (not named and not made):
            known[name] = entry(name, told, follow)
            print(f"{name}: {known[name].get('followed', '')}", flush=True)
            lines = (f"{json.dumps(n)}: {json.dumps(known[n])}" for n in wanted if n in known)
            STORE.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")
    return 0

"""Crossings of zero by polynomials whose roots are known: ``python tools/fuzz.py crossings``.

p(t) is a polynomial of degree 2 to 8 with tidy roots, at least 1e-6 of the span apart but for those
that are multiple on purpose, some at the start or at the end, in both directions of time.  It is
the *motion* of a particle with the force p''(t), or a *function* of the motion x = t.  Its zeros
are events of a run, or points of a section.  A motion may be off by the tolerance, or by rounding,
in units of its terms, and a time by rounding: roots between which p is no larger than that makes of
it are counted together, by whether their number is even.  A root that is lost, or found twice, a
passage where p is larger, a multiple root neither found nor noted, and an output that is not p are
failures.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import pairwise
from random import Random
from shutil import which
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from shared.campaign import campaign_parser, read_campaign

import voronec as vo

WEIGHTS = {"heyoka": 40, "scipy": 20, "lsoda": 20, "flint": 20, "c": 3, "numba": 0.2}
"""Methods, and how often each is drawn: two of them compile."""
NEEDS = {"heyoka": find_spec("heyoka"), "numba": find_spec("numba"), "c": which("cc")}
METHODS = [method for method in WEIGHTS if NEEDS.get(method, True)]
LOOSE = 100
"""So many tolerances, or roundings, a motion may be off, in units of its terms."""
LATE = 32
"""So many roundings a time may be off."""
LOOKS = [sp.Rational(k, 40) for k in range(41)]
"""Where a polynomial is looked at between two roots."""
x = sp.Symbol("x")
SECTIONS = {"heyoka", "scipy"}
"""Methods that sections have."""
COEFFICIENTS, ROOTS, FACTOR = sp.symbols("a:9"), sp.symbols("r:8"), sp.Symbol("c")


@dataclass(frozen=True)
class Trial:
    """p = factor (t - root) ..., and how it is asked for its zeros within ``times``."""

    method: str
    way: str
    door: str
    factor: sp.Rational
    roots: Sequence[sp.Rational]
    times: Sequence[sp.Rational]
    tol: float

    @property
    def polynomial(self) -> sp.Poly:
        """p, expanded."""
        return sp.Poly(self.factor * sp.prod([vo.time - r for r in self.roots]), vo.time)

    def values(self, times: Any) -> np.ndarray:
        """p in many digits."""
        parts = [
            np.array([mpmath.mpf(t) - mpmath.mpf(r.p) / r.q for t in times]) for r in self.roots
        ]
        return np.prod(parts, axis=0) * (mpmath.mpf(self.factor.p) / self.factor.q)

    def tolerance_at(self, times: Any) -> np.ndarray:
        """By how much p may be off at some times."""
        unit = self.tol if self.method == "flint" else 2.2e-16
        far, span = float(max(map(abs, self.times))), float(abs(self.times[-1] - self.times[0]))
        coefficients = [mpmath.mpf(a.p) / a.q for a in self.polynomial.all_coeffs()]
        slopes = np.array([mpmath.polyval(coefficients, t, derivative=True)[1] for t in times])
        late = LATE * unit * (max(far, span) * np.abs(slopes) + np.abs(self.values(times)))
        if self.way == "function":
            return late
        terms = np.poly1d([float(abs(a)) for a in coefficients])
        size = terms(far) + span * terms.deriv()(far) + span**2 * terms.deriv(2)(far)
        return late + LOOSE * max(self.tol, unit) * size

    def ask(self) -> tuple[list[Any], bool]:
        """The times at which p is found to pass zero, and whether touches are noted."""
        n, begin = len(self.roots), self.times[0]
        if self.way == "motion":
            p = self.polynomial
            force = sum(k * (k - 1) * COEFFICIENTS[k] * vo.time ** (k - 2) for k in range(2, n + 1))
            parameters = dict(zip(COEFFICIENTS, reversed(p.all_coeffs()), strict=False))
            initial, event = {x: p.eval(begin), vo.velocity(x): p.diff().eval(begin)}, x
        else:
            force, event = 0, FACTOR * sp.prod([x - r for r in ROOTS[:n]])
            parameters = {FACTOR: self.factor, **dict(zip(ROOTS, self.roots, strict=False))}
            initial = {x: begin, vo.velocity(x): 1}
        system = vo.System(
            "polynomial", vo.Fibration(x), vo.velocity(x) ** 2 / 2, forces={x: force},
            parameters=tuple(parameters),
        )  # fmt: skip
        asked: dict[str, Any] = {
            "parameters": parameters,
            "initial": initial,
            "method": self.method,
            "tol": self.tol,
        }
        if self.door == "section":
            scene = vo.Scene(initial=initial, times=(begin, self.times[-1]))
            asked |= {"scene": scene, "crossings": 99, "direction": 0, "strict": False}
            found = vo.section(system, event, (x,), until=float(self.times[-1]), **asked)
            return [*found.t], bool(found.touches)
        run = vo.integrate(
            system, times=self.times, outputs=(event,), events=vo.Event(event, "p"), **asked
        )
        off = np.abs(run[event] - self.values(run.t))
        assert (off <= self.tolerance_at(run.t)).all(), f"the output is off by {float(off.max()):g}"
        return [*run.events["p"].t], any("touches" in note for note in run.notes)

    def failure(self) -> str:
        """What is wrong with the answer; empty where nothing is."""
        found, noted = self.ask()
        begin, end = self.times[0], self.times[-1]
        if found != sorted(found, reverse=bool(end < begin)):
            return f"the times {found} are not in their order"
        if (np.abs(self.values(found)) > self.tolerance_at(found)).any():
            return f"p is not zero at one of {found}"
        groups = [*self.groups()]
        nearest = [
            min(range(len(groups)), key=lambda i: min(abs(t - r) for r in groups[i])) for t in found
        ]
        for i, group in enumerate(groups):
            count, own = nearest.count(i), [r for r in group if r in self.roots and r != begin]
            is_free = end in group or (begin in group and len(group) > 1)
            if count > len(own) or (not is_free and (len(own) - count) % 2):
                return f"{count} passages at the roots {group}"
            if count == 0 and len({*own}) < len(own) and not noted and not is_free:
                return f"the root {own[0]}, {len(own)} times, is neither found nor noted"
        return ""

    def groups(self) -> Iterator[list[sp.Rational]]:
        """The roots and both ends of the times, those together between which p is no larger than it
        may be off."""
        low, high = ends = sorted((self.times[0], self.times[-1]))
        roots = [r for r in self.roots if low <= r <= high]
        inside = sorted([*roots, *(t for t in ends if t not in roots)])
        group = inside[:1]
        for before, root in pairwise(inside):
            times = [mpmath.mpf(t.p) / t.q for t in (before + (root - before) * k for k in LOOKS)]
            if (np.abs(self.values(times)) > 2 * self.tolerance_at(times)).any():
                yield group
                group = []
            group = [*group, root]
        yield group


def draw(dice: Random, method: str) -> Trial:
    """A polynomial, and how it is asked for its zeros."""
    door = dice.choice(["run", "run", "section"] if method in SECTIONS else ["run"])
    way = 1 if door == "section" else dice.choice((1, -1))
    begin = sp.Rational(dice.choice(("0", "0", "-1", "1/4", "5/2")))
    span, part = dice.choice((1, 2, 4, 10)), dice.choice((3, 4, 7, 10, 20))
    end, roots = begin + way * span, list[sp.Rational]()
    if dice.random() < 0.2:
        roots.append(begin)
    if dice.random() < 0.1:
        roots.append(end)
    for _ in range(dice.randint(max(2, len(roots)), 8) - len(roots)):
        root = begin + way * sp.Rational(dice.randint(1, span * part - 1), part)
        if roots and dice.random() < 0.3:  # one close to another
            root = dice.choice(roots) + sp.Rational(way * span, 10 ** dice.randint(1, 6))
        is_multiple = dice.random() < 0.04
        if is_multiple or all(abs(root - r) * 10**6 >= span for r in roots):
            roots.append(root)
    if len(roots) < 2:
        roots.append(begin + way * sp.Rational(span, 3) + sp.Rational(span, 77))
    instants = dice.choice((2, 2, 5, 65))
    times = [begin + (end - begin) * sp.Rational(k, instants - 1) for k in range(instants)]
    tol = dice.choice((1e-30, 1e-20) if method == "flint" else (1e-13, 1e-13, 1e-9, 1e-6))
    factor = sp.Rational(dice.choice(("1", "-1", "3", "1/8")))
    return Trial(method, dice.choice(("motion", "function")), door, factor, roots, times, tol)


def main() -> int:
    """Ask for zeros until their number or the time is reached; the status is 1 where one is
    wrong."""
    chosen = read_campaign(campaign_parser(__doc__, METHODS))
    began, counts, failures = time.monotonic(), Counter[tuple[str, str, str]](), 0
    mpmath.mp.dps = 60
    for i in [chosen.only] if chosen.only is not None else range(chosen.count):
        if time.monotonic() - began > chosen.seconds:
            break
        dice = Random(f"{chosen.seed}:{i}")
        drawn = dice.choices(METHODS, [WEIGHTS[m] for m in METHODS])[0]
        method = chosen.kind or drawn
        trial = draw(dice, method)
        try:
            wrong = trial.failure()
        except vo.IntegrationError as error:
            counts[method, trial.door, "refused"] += 1
            print(f"refused: {error}\n    --seed {chosen.seed} --kind {method} --only {i}")
            continue
        except (vo.VoronecError, AssertionError) as error:
            wrong = str(error)
        counts[method, trial.door, trial.way] += 1
        if wrong:
            failures += 1
            print(f"wrong: {wrong}\n    {trial}")
            print(f"    again: --seed {chosen.seed} --kind {method} --only {i}", flush=True)
    for (method, door, way), count in sorted(counts.items()):
        print(f"  {method:8} {door:8} {way:9} {count}")
    print(f"seed {chosen.seed}: {counts.total()} polynomials, {failures} wrong")
    return int(failures > 0)

"""Starts at the singular places of the coordinates of every system, against the referee.

    .venv/bin/python tools/fuzz.py starts [--seed N] [--seconds S] [SYSTEM ...]

For each system of the catalogue places are looked for at which its equations divide by zero, its
coordinates or its declared velocities fail, or a chart it declares begins: each coordinate, and
each two of them, at multiples of a right angle, and the zeros of what the equations divide by.  At
each a motion begins with velocities at random, given first as the declared ones, then as those of
the coordinates; each start is judged for itself.  What runs is compared with the multiplier
equations of ``reference.py``, which go back to the place from where the engine came, where they are
singular there, too; then what is defined at the place is compared (``pole_values.py``).  What the
engine refuses is *undetermined* where velocities so given mean no motion, or several,
*undefined* where the motion is not defined though the velocities are (``determinacy.py`` finds out
which, by the referee), and else *refused*, which is a fault.  The status is 1 where anything is
wrong or breaks down.
"""

from __future__ import annotations

import argparse
import itertools
import math
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from time import process_time
from typing import Any

import mpmath as mp
import numpy as np
import symengine as se
import sympy as sp

import voronec as vo
from scenes.determinacy import find_defect
from scenes.open_functions import fill_functions
from scenes.pole_values import Value, find_values
from scenes.reference import NoReferee, Referee, mechanics_of
from scenes.scene import catalogue_names
from voronec.equations.attitudes import with_attitude_charts
from voronec.motion.singular_denominators import divisors

RIGHT_ANGLES = (0.0, math.pi / 2, math.pi)
ZERO = 1e-11
"""Below it, in units of its usual size, a function vanishes."""
RELATION_ERROR = 1e-12
"""Relations that are off by more do not hold."""
SINGULAR = 1e10
"""Multiplier equations with a larger condition number are singular."""
INSTANTS = [0.003 * k for k in range(1, 9)]
"""To these the referee goes back where the start is singular; from there a polynomial leads on."""
FINE, COARSE = (1e-15, 1e-13), (1e-12, 1e-10)
"""Tolerances of the referee, ahead and back; the second where it does not get through else."""
NEARBY = 1e-11
"""So far away is the start that tells the condition of a motion."""
ASIDE = mp.mpf("1e-14")
"""So far away are constraints looked at that may be dependent, or have no value at the place; the
referee has 40 digits."""
FLOOR, LOOSE = 1e-9, 1e-6
"""How far off an answer may be, in units of its size: at regular places, and at singular ones."""
TELLS = 1e-4
"""Where more than this would be allowed nothing is told."""
SPAN, EARLY = 1.0, 0.1
"""So long is a motion; one that breaks down later than that part of it has begun."""
SAMPLES = 12


@dataclass(frozen=True)
class Start:
    """What a motion begins with: coordinates, and declared velocities or those of coordinates."""

    place: Mapping[str, float]
    pace: Mapping[str, float]
    declared: bool


@dataclass
class Bench:
    """A system, its equations and the referee, at the default values of its parameters."""

    system: vo.System
    equations: vo.VoronecEquations
    referee: Referee
    values: list[float]
    dice: Random

    @classmethod
    def of(cls, name: str, seed: int) -> Bench:
        """A system of the catalogue, at an example of functions that it leaves open."""
        system = fill_functions(vo.load(name))
        numbers: dict[Any, Any] = {p.symbol: sp.sympify(p.value) for p in system.parameters}
        values = []
        for parameter in system.parameters:
            value = numbers[parameter.symbol]
            while value.free_symbols:
                value = value.xreplace(numbers)
            values.append(float(value))
        referee = Referee(mechanics_of(system))
        return cls(system, vo.derive(system), referee, values, Random(f"{seed} {name}"))

    @property
    def names(self) -> tuple[str, ...]:
        """Coordinates by name."""
        return self.referee.mechanics.coordinates

    def usual(self) -> list[float]:
        """Coordinates at random, near those of a scene, on the relations."""
        scene = next(iter(self.system.scenes.values()), None)
        own = {str(k): v for k, v in scene.initial.items()} if scene else {}
        exact = {p.symbol: x for p, x in zip(self.system.parameters, self.values, strict=True)}
        q = []
        for name in self.names:
            value = sp.sympify(own.get(name, 0)).xreplace(exact)
            q.append((float(value) if value.is_number else 0.0) + self.dice.uniform(-0.7, 0.7))
        return self.onto_relations(q)

    def onto_relations(self, q: list[float]) -> list[float]:
        """Coordinates moved onto the relations."""
        return [float(x) for x in self.referee.onto_relations(q, self.values)]

    def _on_relations(self, q: list[float]) -> bool:
        """Whether coordinates are on the relations: from some places no way leads there."""
        values, _ = self.referee._relations(q, self.values)
        return max(map(abs, values), default=0.0) < RELATION_ERROR

    # -- places -------------------------------------------------------------------------------

    def places(self) -> Iterator[tuple[str, list[float]]]:
        """Singular places, with what is singular there."""
        usual, seen = self.usual(), list[list[float]]()
        for kind, q in itertools.chain(self._angles(usual), self._zeros(usual)):
            try:
                moved = self.onto_relations(q)
            except (ZeroDivisionError, ValueError):
                continue
            if not self._on_relations(moved):
                continue
            near = any(max(map(abs, np.subtract(moved, old)), default=1) < 1e-7 for old in seen)
            if near or not (why := self.why_singular(moved)):
                continue
            seen.append(moved)
            yield f"{kind}: {why}", moved

    def _angles(self, usual: list[float]) -> Iterator[tuple[str, list[float]]]:
        alone = []
        for i, name in enumerate(self.names):
            for angle in RIGHT_ANGLES:
                q = [*usual]
                q[i] = angle
                if self.why_singular(q):
                    alone.append((i, name, angle))
                yield f"{name} = {angle:.3g}", q
        for (i, a, x), (j, b, y) in itertools.combinations(alone, 2):
            if i != j:
                q = [*usual]
                q[i], q[j] = x, y
                yield f"{a} = {x:.3g}, {b} = {y:.3g}", q

    def _zeros(self, usual: list[float]) -> Iterator[tuple[str, list[float]]]:
        """Zeros of what the equations divide by, along one coordinate each."""
        for function in self.functions().values():
            for i, name in enumerate(self.names):

                def along(x: float, i: int = i, function: Any = function) -> float:
                    return self._value(function, [*usual[:i], x, *usual[i + 1 :]])

                found = _root(along, usual[i])
                if found is not None:
                    yield f"{name} = {found:.3g}", [*usual[:i], found, *usual[i + 1 :]]
                    break

    def functions(self) -> dict[str, Any]:
        """What the equations divide by, and where declared charts begin, by text."""
        if not hasattr(self, "_functions"):
            d = self.equations.definition
            found = [*divisors(self.equations.form), *divisors(self.equations.raw.form)]
            found += [d.bridge.inward(c.singular) for c in self.system.charts.values()]
            known = {*d.coordinates, *(d.bridge.inward(p.symbol) for p in self.system.parameters)}
            own = [f for f in found if f.free_symbols <= known]
            self._functions = {str(f): self._compile(f) for f in own}
        return self._functions

    def _compile(self, function: Any) -> Any:
        """A function of coordinates and parameters for numbers; not one where it has no value."""
        d = self.equations.definition
        symbols = [*d.coordinates, *(d.bridge.inward(p.symbol) for p in self.system.parameters)]
        return se.Lambdify(symbols, [function], cse=True)

    def _value(self, function: Any, q: list[float]) -> float:
        with np.errstate(all="ignore"):
            return float(function([*q, *self.values])[0])

    def why_singular(self, q: list[float]) -> str:
        """What is singular at coordinates; empty where nothing is."""
        if self.condition(q) > SINGULAR:
            return "coordinates"
        try:
            matrix, _ = self.referee._kinematics(mp.mpf(0), q, self.values)
        except ZeroDivisionError:
            return "constraints"
        if np.linalg.cond(np.array(matrix, dtype=float)) > SINGULAR:
            return "velocities"
        for text, function in self.functions().items():
            if abs(self._value(function, q)) < ZERO:
                return text[:40]
        return ""

    def condition(self, q: list[float]) -> float:
        """The condition number of the multiplier equations at rest."""
        at_rest = [mp.mpf(x) for x in q] + [mp.mpf(0)] * len(self.referee.mechanics.w)
        return self.referee.condition(at_rest, self.values, 0.0)

    # -- starts -------------------------------------------------------------------------------

    def starts(self, q: list[float]) -> Iterator[Start]:
        """Starts at a place: declared velocities, and those of coordinates."""
        m, place = self.referee.mechanics, dict(zip(self.names, q, strict=True))
        pace = {v: round(self.dice.uniform(-1, 1), 3) for v in m.velocities}
        yield Start(place, pace, True)
        names = [f"{n}dot" for n in self.names]
        if self.system.on_group:
            names = [str(x) for x in self.system.directions]
        # where constraints are dependent, or without a value, they are what they are beside
        beside = [x + ASIDE * self.dice.uniform(0.5, 1) for x in map(mp.mpf, q)]
        guess = [self.dice.uniform(-1, 1) for _ in m.w]
        try:
            state = self.referee.start_of_rates(beside, guess, self.values, 0.0)
        except ZeroDivisionError:
            return
        yield Start(place, dict(zip(names, map(float, state[len(q) :]), strict=True)), False)

    def answer(self, start: Start, span: float = SPAN) -> dict[str, float]:
        """The engine's state at the end of a span."""
        names = self.names + self._regular_names
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            motion = vo.integrate(
                self.equations, times=[0.0, span], initial={**start.place, **start.pace},
                parameters=dict(zip(self.referee.mechanics.parameters, self.values, strict=True)),
                outputs=names,
            )  # fmt: skip
        return {name: float(motion[name][-1]) for name in names}

    @property
    def _regular_names(self) -> tuple[str, ...]:
        """What has a meaning at poles of the coordinates too."""
        return (*self.referee.mechanics.velocities, *self.system.invariants)

    def is_regular(self, start: Start) -> bool:
        """Whether the referee can begin there."""
        q = [start.place[n] for n in self.names]
        if not start.declared:
            return self.condition(q) < SINGULAR
        try:
            matrix, _ = self.referee._kinematics(mp.mpf(0), q, self.values)
        except ZeroDivisionError:
            return False
        return max(self.condition(q), np.linalg.cond(np.array(matrix, dtype=float))) < SINGULAR

    def ahead(
        self, start: Start, found: Mapping[str, float], span: float
    ) -> dict[str, tuple[float, ...]]:
        """Off by how much the end of a motion is, and what is allowed, by name."""
        names, (one, other) = tuple(found), (self._end(start, x, span) for x in (0.0, NEARBY))
        wanted = np.array([found[n] for n in names])
        size, spread = np.maximum(1.0, np.abs(one)), np.abs(other - one)
        bounds = np.maximum(FLOOR * size, 100 * 1.1e-16 * spread / NEARBY)
        return dict(zip(names, zip(np.abs(wanted - one), bounds, strict=True), strict=True))

    def _begin(self, start: Start, q: Sequence[Any]) -> list[Any]:
        """The referee's state at coordinates, with the velocities of a start."""
        begin = self.referee.start if start.declared else self.referee.start_of_rates
        return begin(q, [*start.pace.values()], self.values, 0.0)

    def _end(self, start: Start, off: float, span: float) -> np.ndarray:
        m = self.referee.mechanics
        q = [mp.mpf(start.place[n]) + off * self.dice.uniform(0.5, 1) for n in self.names]
        state = self._begin(start, q)
        wanted = [m.meaning(self.system, n) for n in self.names + self._regular_names]
        return self._observe(state, 0.0, [span], wanted, FINE)[0]

    def _declared_velocities(self, q: Any, w: Any) -> list[Any]:
        """The declared velocities of those of coordinates."""
        matrix, offsets = self.referee._kinematics(mp.mpf(0), q, self.values)
        rows = range(len(self.referee._rows), len(offsets))
        return [mp.fdot(matrix[i], w) + offsets[i] for i in rows]

    def _observe(
        self, state: Any, begin: float, times: Any, wanted: Any, tolerances: tuple[float, ...]
    ) -> np.ndarray:
        """Expressions along the referee's motion, as sharp as it can be had."""
        for tolerance in tolerances:
            found = self.referee.motion(
                state, self.values, begin, times, tolerance, "long double", 400_000
            )
            if found.outcome == "done":
                break
        else:
            raise NoReferee(f"{found.outcome} at t = {found.reached:.4g}")
        reader = self.referee.reader(wanted)
        rows = [reader(t, s, self.values) for t, s in zip(times, found.states, strict=True)]
        return np.array([[float(x) for x in row] for row in rows])

    def backward(
        self, start: Start, found: Mapping[str, float], span: float = SPAN
    ) -> dict[str, tuple[float, ...]]:
        """Off by how much the start is that the referee comes from, and what is allowed: what is
        defined at the place is followed back to it, and drawn on to zero by a polynomial."""
        m, known = self.referee.mechanics, self._find_values(start)
        end = [found[n] for n in self.names], [found[x] for x in m.velocities]
        state = self.referee.start(*end, self.values, span)
        here, turns = (np.array([getattr(k, x) for k in known.values()]) for x in ("here", "turns"))
        wanted = [k.expression for k in known.values()]
        rows = self._observe(state, span, INSTANTS[::-1], wanted, COARSE)[::-1]
        # angles without the whole turns between one instant and the next
        rows[:, turns] = np.unwrap(rows[:, turns], axis=0)
        drawn, rougher = (_at_zero(INSTANTS[:k], rows[:k]) for k in (len(rows), len(rows) - 1))
        bounds = LOOSE * np.maximum(1.0, np.abs(here)) + 10 * np.abs(drawn - rougher)
        gaps = drawn - here
        gaps -= np.where(turns, 2 * np.pi * np.rint(gaps / (2 * np.pi)), 0)
        return dict(zip(known, zip(np.abs(gaps), bounds, strict=True), strict=True))

    def _find_values(self, start: Start) -> dict[str, Value]:
        """What is defined at a singular place."""
        m, q = self.referee.mechanics, [start.place[n] for n in self.names]
        functions = {name: m.own(e) for name, e in self.system.invariants.items()}
        known = find_values(self.referee, functions, q, self.values)
        try:
            v = [*start.pace.values()] if start.declared else self._declared_velocities(
                [mp.mpf(x) for x in q], [mp.mpf(x) for x in start.pace.values()]
            )  # fmt: skip
        except ZeroDivisionError:
            return known
        # frames of charts may turn with coordinates that are free at a pole
        charted = (with_attitude_charts(self.equations) or self.equations).system
        turned = {name for chart in charted.charts.values() for name in chart.state}
        read = zip(m.velocities, m.independent, v, strict=True)
        return known | {n: Value(e, float(x)) for n, e, x in read if n not in turned}

    def defect(self, start: Start) -> tuple[str, str]:
        """Why no motion begins so, by the referee: a word and a line, empty where one does."""
        m, q = self.referee.mechanics, [start.place[n] for n in self.names]
        free = [m.meaning(self.system, n) for n in self.system.invariants]
        return find_defect(
            self.referee, lambda place: self._begin(start, place), q, self.values, free
        )

    def judge(self, start: Start, span: float = SPAN) -> tuple[str, str]:
        """Outcome and detail of one start."""
        try:
            answer = self.answer(start, span)
        except vo.VoronecError as refusal:
            reached = getattr(refusal, "time", None) or 0.0
            if reached > EARLY * SPAN:  # what happens there is no matter of the start
                return self.judge(start, reached / 2)
            outcome, why = self.defect(start)
            return outcome or "refused", f"{why}: {refusal}" if why else str(refusal)
        except Exception as failure:
            return "broken", f"{type(failure).__name__}: {failure}"
        try:
            regular = self.is_regular(start)
            off = (self.ahead if regular else self.backward)(start, answer, span)
        except (NoReferee, ZeroDivisionError, ValueError, np.linalg.LinAlgError) as reason:
            return "no truth", str(reason)
        if any(allowed > TELLS for _, allowed in off.values()):
            return "no truth", "ill-conditioned"
        bad = max(off, key=lambda n: off[n][0] / off[n][1], default=None)
        if bad is None or off[bad][0] <= off[bad][1]:
            return "right", ""
        where = "" if regular else ", followed back to the start"
        return "wrong", f"{bad}{where}, is off by {off[bad][0]:.1e}, allowed {off[bad][1]:.1e}"


def _at_zero(times: list[float], rows: np.ndarray) -> np.ndarray:
    """The value at zero of the polynomial through rows (k, n) at times (k,)."""
    weights = [math.prod(u / (u - t) for u in times if u != t) for t in times]
    return np.asarray(np.array(weights) @ rows)


def _root(function: Any, begin: float) -> float | None:
    """A zero of a function of one variable, where its sign changes without a jump."""
    places = np.linspace(begin - math.pi, begin + math.pi, SAMPLES)
    sizes = [function(x) for x in places]
    for a, b, fa, fb in zip(places, places[1:], sizes, sizes[1:], strict=False):
        if fa * fb < 0:
            for _ in range(60):
                middle = (a + b) / 2
                a, b = (middle, b) if function(middle) * fa > 0 else (a, middle)
            if abs(function(a)) < ZERO * max(map(abs, sizes)):
                return float(a)
    return None


def main() -> int:
    """Sweep, print what is not right, and a line for each system."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--places", type=int, default=24, help="of one system at most")
    parser.add_argument("--seconds", type=float, default=math.inf, help="of work for one system")
    parser.add_argument("systems", nargs="*")
    given = parser.parse_intermixed_args()
    total = Counter[str]()
    for name in given.systems or catalogue_names():
        tally, until = Counter[str](), process_time() + given.seconds
        try:
            bench = Bench.of(name, given.seed)
        except NoReferee as reason:
            print(f"{name}: not judged: {reason}", flush=True)
            continue
        for where, q in itertools.islice(bench.places(), given.places):
            if process_time() > until:
                tally["not looked at, and perhaps more"] += 1
                break
            tally.update(_outcomes(bench, where, q))
        total += tally
        told = ", ".join(f"{n} {outcome}" for outcome, n in sorted(tally.items()))
        print(f"{name}: {told or 'no singular place'}", flush=True)
    print(", ".join(f"{n} {outcome}" for outcome, n in sorted(total.items())))
    return int(bool(total["wrong"] or total["broken"]))


def _outcomes(bench: Bench, where: str, q: list[float]) -> Iterator[str]:
    """What came of each start at a place; what is not right is printed."""
    for start in bench.starts(q):
        outcome, detail = bench.judge(start)
        if outcome != "right":
            print(f"{outcome}: {bench.system.name} at {where}: {detail}")
            print(f"    initial={ {**start.place, **start.pace}!r}", flush=True)
        yield outcome

"""Motions of a given class, found from the declaration alone.

Parameters and starts are drawn among short fractions; what a class demands exactly is solved for
velocities.  Doubles look at all draws at once, the best are classified exactly, and the first that
is of the class is it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.normal import canonical
from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.text import as_expression
from voronec.closed.classes.survey import survey
from voronec.closed.classes.trace_classes import (
    Curve,
    DeclaredTraces,
    classify,
    declared_traces,
    remainder,
)
from voronec.closed.closed_form import ClosedForm
from voronec.closed.compiled_motion import prepare
from voronec.closed.problem import InversionProblem, read_parameters
from voronec.closed.space import turned_upright
from voronec.declaration.scene import Scene
from voronec.declaration.system import System, require_possible
from voronec.errors import DefinitionError, EngineLimit

ROOTS_OF_CLASS = {"B": 1, "C": 2, "C1": 2, "C2": 2, "D1": 1, "D2": 1, "D3": 2, "E1+E2": 2, "A|C": 2}
"""Roots that phi must have."""


@dataclass(frozen=True, eq=False)
class Conditions:
    """``vanishing``, then ``further``: functions of the start that must be zero.

    ``elsewhere``: they hold where the trace passes the pole; the start is to be another point.
    """

    vanishing: tuple[Any, ...]
    further: tuple[Any, ...] = ()
    elsewhere: bool = False


def conditions(known: DeclaredTraces, curve: Curve, label: str) -> Conditions:
    """What makes a motion start at a parallel, with cusps or poles as its class says."""
    parts = set(label.split("+"))
    wanted = [known.rate]
    if parts & {"D1", "D2", "D3"}:
        wanted.append(known.at_start(curve.above_at(known.motion.x)))
    further = ()
    if "D3" in parts:
        further = tuple(known.at_start(e) for e in remainder(known.quartic, curve.above))
    elsewhere = False
    for side, name in ((1, "E1"), (-1, "E2")):
        if name in parts:
            offset, slope = curve.cosine
            at_pole = known.at_start(curve.above_at((side - offset) / slope))
            if _rational(at_pole):
                wanted.append(at_pole)
            else:
                wanted.append(known.at_start(1 - (offset + slope * known.motion.x) ** 2))
                elsewhere = True
    return Conditions(tuple(map(_short, wanted)), further, elsewhere)


def _rational(value: Any) -> bool:
    """Whether no root of anything occurs."""
    return all(p.exp.is_Integer for p in value.atoms(sp.Pow))


def _short(value: Any) -> Any:
    """The numerator in normal form."""
    bridge = SymPyBridge()
    reduced = bridge.outward(canonical([bridge.inward(value)], ())[0])
    return sp.fraction(sp.together(reduced))[0]


def solutions(
    wanted: Conditions, known: Mapping[Any, Any], velocities: Sequence[Any]
) -> Iterator[dict[Any, Any]]:
    """Exact velocities that meet conditions, one after the other; those left free are not there.

    ``known`` gives parameters and coordinates.  A factor that is linear in a velocity gives it; the
    conditions left are solved with it.
    """
    given = dict(known)
    first = [sp.expand(c.xreplace(given)) for c in wanted.vanishing]
    for solution in _solve_start(first, {}, velocities):
        # long formulas wait until numbers have made them short
        rest = [e.xreplace({**given, **solution}) for e in wanted.further]
        rest = [sp.fraction(sp.together(sp.expand(e)))[0] for e in rest]
        yield from _solve_start(rest, solution, velocities)


def _solve_start(
    left: list[Any], found: dict[Any, Any], velocities: Sequence[Any]
) -> Iterator[dict[Any, Any]]:
    left = [c for c in left if c != 0]
    if not left:
        yield found
        return
    if any(not c.has(*velocities) for c in left):
        return
    first = min(left, key=lambda c: (len(c.free_symbols), sp.count_ops(c)))
    for factor, _ in sp.factor_list(first)[1]:
        for rate in velocities:
            if not factor.has(rate) or sp.degree(factor, rate) != 1:
                continue
            slope = factor.coeff(rate, 1)
            if slope.has(*velocities):
                continue
            value = sp.expand(-factor.coeff(rate, 0) / slope)
            rest = [sp.expand(c.xreplace({rate: value})) for c in left if c is not first]
            later = {v: sp.expand(e.xreplace({rate: value})) for v, e in found.items()}
            yield from _solve_start(rest, {**later, rate: value}, velocities)
            break


SHARE = sp.Rational(1, 3)
"""Such a motion begins at this part of its range, off both ends."""
LARGEST = 60
"""The largest denominator of a cosine at which a motion is started anew."""


def fill(system: System, own: Mapping[Any, Any], start: Mapping[Any, Any]) -> dict[Any, Any]:
    """A start with the coordinates in space such that the constant vector is upright."""
    space = system.motion.space if system.motion is not None else None
    if space is None:
        return dict(start)
    values = {**own, **start}
    vector = [sp.nsimplify(sp.simplify(e.xreplace(values))) for e in space.vector]
    turned = {q: sp.simplify(e) for q, e in turned_upright(space, vector).items()}
    return {**start, **{q: sp.Integer(0) if e is sp.nan else e for q, e in turned.items()}}


def elsewhere(closed: ClosedForm, start: Mapping[Any, Any]) -> dict[Any, Any]:
    """The motion from another point, in exact numbers; for a start at which a trace is at its
    pole.  It is left where coordinates or velocities are not given by x alone."""
    motion, problem = closed.quadratures, closed.problem
    moving = [q for q in closed.system.coordinates if motion.meaning.has(q)]
    if len(moving) != 1:
        return dict(start)
    (q,) = moving
    low, high = closed.ends
    place = sp.Rational(low + (high - low) * float(SHARE)).limit_denominator(LARGEST)
    level = {s: sp.nsimplify(sp.simplify(problem.exact_number(s))) for s in motion.constants}
    level |= {p.symbol: as_expression(problem.values[p.symbol]) for p in closed.system.parameters}
    level |= {motion.x: place}
    solved = sp.solve(motion.meaning - place, q)
    angle = next(a for a in solved if 0 <= float(a) <= float(sp.pi))
    pace = sp.sqrt(sp.simplify(motion.quartic.xreplace(level)))
    rates = {velocity(p): e.xreplace(level) for p, e in motion.integrals.items()}
    rates[velocity(q)] = pace / sp.diff(motion.meaning, q).subs(q, angle)
    state = {**dict.fromkeys(closed.system.coordinates, sp.Integer(0)), q: angle}
    for v in closed.system.velocities:
        value = motion.velocities.get(v, v).xreplace({**rates, **level, q: angle})
        state[v] = sp.nsimplify(sp.simplify(value))
    return state


COSINES = tuple(
    sp.Rational(s * a, c)
    for a, c in ((3, 5), (4, 5), (5, 13), (12, 13), (8, 17), (15, 17), (7, 25), (24, 25))
    for s in (1, -1)
)
"""Cosines whose sines are rational, too."""
STEPS = 10
REACH = 4
"""Velocities are drawn among multiples of 1/STEPS up to REACH."""
FEWEST = 3
"""So many draws are looked at exactly where no picture could be made of any."""
FACTORS = tuple(sp.Rational(*q) for q in ((1, 1), (1, 2), (2, 1), (3, 2), (2, 3), (3, 1), (1, 3)))
"""What a default may be multiplied by: ratios that print shortly."""
DRAWS, SOLUTIONS, FEW, ROUNDS, CANDIDATES = 3000, 30, 10, 5, 12
"""Starts that are drawn, where a condition is solved, and where two are, which takes longer; rounds
of these, and of each so many that look best are tried exactly, which takes longest."""
PERIODS = 12
"""A curve that closes after no more periods is liked."""


def find(
    system: System,
    label: str,
    trace: str | None = None,
    parameters: Mapping[Any, Any] | None = None,
    seed: int = 1,
    progress: Callable[[str], Any] | None = None,
) -> Scene:
    """A motion whose trace has a class, with exact parameters and initial data.

    ``trace`` is a title or a coordinate, the first trace unless told.  ``parameters`` are held;
    the others are their defaults first, and drawn around these where no such motion is found.  The
    start is at a turning point, with the constant vector in space upright.  ``DefinitionError``
    says why there is no such motion, or that none was found.
    """
    known = declared_traces(system)
    curve = known.curve(trace)
    fixed = held_parameters(system, parameters or {})
    search = _StartSearch(known, curve, label, fixed, np.random.default_rng(seed))
    for turn in range(ROUNDS):
        if progress is not None:
            progress(f"{label} {curve.title}: round {turn + 1} of at most {ROUNDS}")
        body = search.parameters(turn)
        reason = _impossible(known, curve, label, body) if body is not None else ""
        if reason:
            raise DefinitionError(f"system '{system.name}': {reason}")
        scene = search.best(body) if body is not None else None
        if scene is not None:
            return scene
    raise DefinitionError(f"system '{system.name}': {search.failure}")


def held_parameters(system: System, given: Mapping[Any, Any]) -> dict[Any, Any]:
    """Parameters to be held, exactly, by symbol; ``DefinitionError`` for what no body has, and
    where the declared traces have no value."""
    held = read_parameters(system, given)
    for p in system.parameters:
        if p.symbol in held:
            try:
                p.check(held[p.symbol])
            except DefinitionError as error:
                raise DefinitionError(f"system '{system.name}': {error}") from None
    require_possible(system, {plain_name(s): v for s, v in held.items()})
    for curve in declared_traces(system).curves:
        if any(c.xreplace(held).has(sp.nan, sp.zoo) for c in (*curve.cosine, *curve.phi)):
            values = _in_words(held)
            raise DefinitionError(
                f"system '{system.name}': the trace {curve.title} has no value with {values}, "
                "since its quadratures divide by zero; hold other values"
            )
    return held


def _in_words(values: Mapping[Any, Any]) -> str:
    return ", ".join(f"{plain_name(s)} = {v}" for s, v in values.items())


def _impossible(known: DeclaredTraces, curve: Curve, label: str, own: Mapping[Any, Any]) -> str:
    """Why no motion with these parameters is of a class, as far as degrees tell."""
    values = _in_words(own)
    slope = sp.cancel(curve.cosine[1].xreplace(dict(own)))
    if slope == 0 and label not in ("parallel", "point"):
        return f"class {label} {curve.title} does not exist: the trace is a parallel with {values}"
    phi = [sp.cancel(c.xreplace(dict(own))) for c in curve.phi]
    degree = max((i for i, c in enumerate(phi) if c != 0), default=-1)
    needed = ROOTS_OF_CLASS.get(label, 0)
    if degree < needed:
        return (
            f"class {label} {curve.title} does not exist: it needs a phi with {needed} root"
            f"{'s' if needed > 1 else ''}, whose degree in {known.motion.x} is {max(degree, 0)} "
            f"with {values}"
        )
    return ""


@dataclass(eq=False)
class _StartSearch:
    known: DeclaredTraces
    curve: Curve
    label: str
    fixed: Mapping[Any, Any]
    dice: np.random.Generator
    tallies: Counter[str] = field(default_factory=Counter)

    @cached_property
    def conditions(self) -> Conditions:
        """What the start has to meet."""
        return conditions(self.known, self.curve, self.label)

    def parameters(self, turn: int) -> dict[Any, Any] | None:
        """Exact values: the defaults first, later drawn around them; None for no possible body."""
        system, body = self.known.system, {}
        for p in system.parameters:
            value = sp.nsimplify(p.value) if p.value is not None else sp.Integer(1)
            if turn and p.symbol not in self.fixed:
                value *= FACTORS[self.dice.integers(len(FACTORS))]
            body[p.symbol] = self.fixed.get(p.symbol, value)
            if p.symbol not in self.fixed:
                try:
                    p.check(body[p.symbol])
                except DefinitionError:
                    return None
        possible = system.possible.values()
        return None if any(c.xreplace(body) is sp.false for c in possible) else body

    def best(self, own: Mapping[Any, Any]) -> Scene | None:
        """The best of many draws with some parameters that is exactly of the class."""
        drawn = list(self._starts(own))
        if not drawn:
            return None
        names = [plain_name(q) for q in drawn[0]]
        doubles = {v: float(v) for v in {v for d in drawn for v in d.values()}}
        columns = np.array([[doubles[v] for v in d.values()] for d in drawn]).T
        seen = survey(self.known.system, {plain_name(k): float(v) for k, v in own.items()},
                      dict(zip(names, columns, strict=True)), self.curve.title, True)  # fmt: skip
        marks = _marks(seen, 0.1 if "E" in self.label else 0.7)
        if self.label in ("A", "B", "C1", "C2"):
            marks = np.where(seen.labels == self.label, marks, -np.inf)
        elif np.all(marks == -np.inf):
            marks[:FEWEST] = -1e9  # what comes of the conditions says why there is no such motion
        for i in np.argsort(-marks)[:CANDIDATES]:
            if marks[i] == -np.inf:
                break
            scene = self._confirm_start(own, drawn[i])
            if scene is not None:
                return scene
        return None

    def _starts(self, own: Mapping[Any, Any]) -> Iterator[dict[Any, Any]]:
        """Coordinates and velocities, exact."""
        system = self.known.system
        wanted = self.conditions
        plain = len(wanted.vanishing) == 1
        moving = [q for q in system.coordinates if self.known.place.has(q)]
        for _ in range(DRAWS // 100 if plain else FEW if wanted.further else SOLUTIONS):
            angles = {q: sp.Integer(0) for q in system.coordinates}
            angles |= {q: sp.acos(self.dice.choice(COSINES)) for q in moving}
            for solution in solutions(wanted, {**own, **angles}, system.velocities):
                for _ in range(100 if plain else 1):
                    free = {
                        v: self._draw_fraction() for v in system.velocities if v not in solution
                    }
                    solved = {v: as_expression(e).xreplace(free) for v, e in solution.items()}
                    yield {**angles, **{v: {**free, **solved}[v] for v in system.velocities}}

    def _draw_fraction(self) -> Any:
        """A short fraction."""
        most = STEPS * REACH
        return sp.Rational(int(self.dice.integers(-most, most + 1)), STEPS)

    def _confirm_start(self, own: Mapping[Any, Any], start: Mapping[Any, Any]) -> Scene | None:
        """The scene of a start, where its class is exactly the one wanted."""
        system = self.known.system
        closed = exact_closed_form(system, {**own, **start})
        try:
            classes = classify(closed)
        except EngineLimit:
            return None
        trace_class = classes[self.curve.title]
        self.tallies[trace_class.label] += 1
        if trace_class.label != self.label:
            return None
        if self.conditions.elsewhere:
            start = elsewhere(closed, start)
        start = fill(system, own, start)
        usual = {p.symbol: p.value for p in system.parameters}
        changed = {s: v for s, v in own.items() if s in self.fixed or v != usual[s]}
        return Scene(
            initial={k: v for k, v in start.items() if v != 0},
            parameters=changed,
            times=(0.0, _span(trace_class)),
            caption=f"{self.curve.title}: class {self.label}.",
        )

    @property
    def failure(self) -> str:
        """Why nothing was found."""
        what = f"class {self.label} {self.curve.title}"
        values = _in_words(self.fixed)
        place = f" with {values}" if values else ""
        if self.tallies and self.tallies.keys() <= {"point", "parallel"}:
            only = " and ".join(sorted(self.tallies))
            return f"{what} does not exist{place}: what it demands leaves only '{only}'"
        others = ", ".join(label for label, _ in self.tallies.most_common(4))
        near = f"; nearest were {others}" if others else ""
        return f"no motion of {what} was found{place} among {ROUNDS} rounds of draws{near}"


def exact_closed_form(system: System, values: Mapping[Any, Any]) -> ClosedForm:
    """The closed form of exact values of all symbols of a start."""
    return ClosedForm(InversionProblem(prepare(system, values), dict(values)))


def _span(found: Any) -> float:
    """Periods until the curve closes, or enough of them to be seen."""
    if not np.isfinite(found.period):
        return 20.0
    turns = abs(found.drift or 0) / (2 * np.pi)
    count = int(np.clip(np.ceil(0.95 / turns), 6, PERIODS)) if turns else PERIODS
    for n in range(PERIODS, 0, -1):
        if abs(n * turns - round(n * turns)) < 0.01 and n * turns > 0.5:
            count = n
    return float(np.float32(count * found.period))


def _marks(seen: Any, weight: float) -> np.ndarray:
    """How good a picture would be: parallels apart, away from the poles, a drift that shows the
    curve (of some weight), and few periods until it closes."""
    with np.errstate(invalid="ignore", divide="ignore"):
        low, high = (np.arccos(np.clip(c, -1, 1)) for c in (seen.upper, seen.lower))
        width, turns = high - low, np.abs(seen.drift) / (2 * np.pi)
        marks = -np.abs(np.log(width / 0.8)) - weight * np.abs(np.log(turns / 0.11))
        room = np.minimum(low, np.pi - high)
        marks -= 2 * np.exp(-room / 0.1) * (room > 0)
        counts = np.arange(3, PERIODS + 1)[None, :]
        off = np.abs(counts * turns[:, None] - np.round(counts * turns[:, None])).min(axis=1)
        marks += np.where(off < 0.01, 0.8, 0)
    return np.where(np.isfinite(marks), marks, -np.inf)

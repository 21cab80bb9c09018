"""What every integrator takes and gives: a problem and a grid of times in, a run out.

Parameters may change in time, at known instants or as Python says.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from math import inf
from time import perf_counter
from typing import Any

import mpmath
import numpy as np

from voronec.equations.program import Program, compile_program
from voronec.errors import DefinitionError
from voronec.motion.request import Guard
from voronec.motion.steppers.feedback import Feedback, StateView
from voronec.motion.steppers.samples import StepSamples

COLLAPSE = "the step size collapsed"
ENDLESS = 1e10
"""A run that would take so many steps is ended: a day or more by any method."""
FAR = f"the end is more than {ENDLESS:.0e} steps away".replace("+", "")
WINDOW, CRAWL = 1000, 1e-7
"""So many steps that cover less than this part of the span lead nowhere."""
LONG = 10_000
"""After four times so many steps, and more, a run is ended that would take ``ENDLESS`` ones."""
SHORTER = 0.1
"""Steps that have become shorter by this are said to collapse, where the end is too far away."""
EXPONENTIAL = 1e-6
"""A pace that fades as N^-a, a nearer to 1 than this, makes the steps that are left grow as exp."""
INFINITE = "the state is no longer finite"
SINGULAR = "the motion cannot be continued"
AT_START = 1e-12
"""A crossing nearer to the start than this, in units of the span, is the start itself."""
AT_END = 1e-14
"""Crossings no farther from the one that stops a run than this, in units of the span or time,
belong to one instant."""
DISTANT = 20
"""A run that is stopped by hand so many steps after the last point of its grid keeps where it stood
besides: what took so long is not thrown away."""
EVERY = 0.1
"""Seconds between two reports of progress."""

Suspect = Callable[[np.ndarray, np.ndarray], int | None]
"""Times (k,) and states (k, n) to the first position whose mass matrix is singular, or which the
motion can only have reached through one."""


@dataclass(frozen=True)
class Problem:
    """What is to be integrated, in numbers.

    ``levels`` has the events' functions as extra quantities, in the order of ``events``.
    ``start`` (n,) and ``parameters`` are doubles; ``exact``, given a number of bits, returns both
    as mpmath's numbers, for the method ``flint``.  Events that are ``coarse`` are rare: an
    integrator may look for them only where the ends of a step do not exclude them.  ``switching
    surfaces`` are those at which the right side ceases to hold: they count however near to the
    start. Parameters that are ``changing`` are those of the start.  ``marked`` asks for the ends of
    steps.
    ``units`` (n,) are those in which the states are measured, by default their natural ones.
    Functions of events that are ``apart`` are not integrated beside the states; of others what
    bends is, or, where they alone tell a time, the ``whole``.
    ``measured`` are quantities that controllers are told besides the states; ``conditions``
    functions that vanish along the motion.
    """

    program: Program
    start: np.ndarray
    parameters: Sequence[Any]
    tol: float
    events: tuple[Guard, ...] = ()
    levels: Program | None = None
    dense: bool = False
    suspect: Suspect | None = None
    progress: Callable[[float], Any] | None = None
    exact: Callable[[int], tuple[np.ndarray, Sequence[Any]]] | None = None
    changing: Signals | None = None
    coarse: frozenset[str] = frozenset()
    switching_surfaces: frozenset[str] = frozenset()
    marked: bool = False
    units: np.ndarray | None = None
    apart: frozenset[str] = frozenset()
    whole: bool = False
    measured: Program | None = None
    conditions: tuple[Any, ...] = ()

    @property
    def is_rough(self) -> bool:
        """Whether the rates or the functions of events may hold what is not smooth."""
        return self.program.is_rough or (self.levels is not None and self.levels.is_rough_beside)

    def parameters_at(self) -> Callable[[float, np.ndarray], Sequence[Any]]:
        """The parameters at any time and state (n,) of a piece: those that Python gives are asked
        for there."""
        changing = self.changing
        if changing is None or changing.python_signal is None:
            return lambda _, __: self.parameters
        places = {str(p): i for i, p in enumerate(self.program.parameters)}
        told, followed = self.state_view(), [f for f in changing.feedbacks if not f.is_sampled]

        def at(time: float, state: np.ndarray) -> Sequence[Any]:
            values = list(self.parameters)
            known = changing.values_at(time)
            if followed:
                seen = told(time, state.tolist(), values)
                known |= {f.name: f.value(time, seen) for f in followed}
            for name, value in known.items():
                if name in places:
                    values[places[name]] = value
            return values

        return at

    def state_view(self) -> StateView:
        """What controllers are told: the states by name, and what is measured besides."""
        names, besides = [*map(str, self.program.state)], self.measured
        if besides is None or not besides.names:
            return lambda _time, state, _values: dict(zip(names, state, strict=True))
        extras = compile_program(besides, scalar=True)[1]
        places = [[*map(str, self.program.parameters)].index(str(p)) for p in besides.parameters]

        def full_view(
            time: float, state: Sequence[float], values: Sequence[float]
        ) -> dict[str, float]:
            more = extras(time, state, [values[i] for i in places])
            return dict(zip((*names, *besides.names), (*state, *more), strict=True))

        return full_view


@dataclass(frozen=True)
class Termination:
    """Why and where an integrator could not go on: the last state that was good.

    ``singular`` says that a singular mass matrix is known to be the cause; ``mend``, what would
    help, where that is known.
    """

    reason: str
    time: Any
    state: np.ndarray
    singular: bool = False
    mend: str = ""


@dataclass
class StallDetector:
    """A look at whether steps lead to the end of a run, from its ``start`` on.

    They lead nowhere where many of them cover next to nothing, and where too many are left: at the
    best pace p of the last half of N steps, which fades as N^-a, the way d that is left takes
    N (1 + (1 - a) d/(p N))^(1/(1 - a)) steps, or N exp(d/(p N)) where a = 1.  That is looked at
    whenever their number has doubled, beyond ``looked``.
    """

    start: Any
    end: float
    looked: int = field(default_factory=lambda: LONG)
    marks: tuple[float, int] = field(init=False)
    time: float = field(init=False)
    steps: int = 0
    best: float = 0.0
    former: float = 0.0
    fastest: float = 0.0

    def __post_init__(self) -> None:
        self.time = float(self.start)
        self.marks = self.time, 0

    def failure(self, steps: int, time: Any) -> str:
        """Why so many steps, which came to a time, lead nowhere; empty where they do not.

        The first of them are none to compare: what they cover tells nothing without the next.
        """
        time, mark, marked = float(time), *self.marks
        if steps - marked >= WINDOW:
            self.marks, pace = (time, steps), abs(time - mark) / (steps - marked)
            self.fastest = max(self.fastest, pace)
            if marked and pace * WINDOW <= CRAWL * abs(self.end - float(self.start)):
                return self.reason(pace)
        return self.distance(steps, time)

    def distance(self, steps: int, time: Any) -> str:
        """Why the end is too far away, empty where it is not."""
        if steps - self.steps < WINDOW:
            return ""
        pace = abs(float(time) - self.time) / (steps - self.steps)
        self.time, self.steps, self.best = float(time), steps, max(self.best, pace)
        self.fastest = max(self.fastest, pace)
        if steps < 2 * self.looked or not self.best:
            return "" if self.best else COLLAPSE
        fading = np.log(self.former / self.best) / np.log(steps / self.looked) if self.former else 0
        left = abs(self.end - self.time) / (self.best * steps)
        pace, self.looked, self.former, self.best = self.best, steps, self.best, 0.0
        if np.log(steps) + _log_growth(left, min(fading, 1.0)) <= np.log(ENDLESS):
            return ""
        return self.reason(pace)

    def reason(self, pace: float) -> str:
        """Whether steps have become short, by what many of them cover, or the way is long."""
        return COLLAPSE if pace <= SHORTER * self.fastest else FAR


def _log_growth(left: float, fading: float) -> float:
    """log (1 + (1 - a) z)^(1/(1 - a)), for ``left`` = z and ``fading`` = a up to 1."""
    rest = 1 - fading
    return float(np.log1p(rest * left) / rest if rest > EXPONENTIAL else left)


@dataclass(frozen=True)
class Run:
    """States at ``t``: the first points of the grid, and the crossing that ended the run, or where
    it stood when it was stopped by hand, far from the last of these points.

    ``crossings`` maps each event to its times and states; ``stopped`` names the one that ended the
    run; ``inside``, of dense runs, gives states at any times reached; ``held`` says
    that it was kept on a switching surface, along which no single right side holds; ``switches``
    counts changes of chart, and ``prepared`` are the seconds of the run that making integrators for
    them took; ``notes`` are lines for the user; ``ends``, where a problem asks for them, the ends
    of steps; ``samples`` are taken of the steps, with rates of their own where switches change the
    right side.
    """

    t: np.ndarray
    states: np.ndarray
    steps: int
    evaluations: int
    crossings: Mapping[str, tuple[np.ndarray, np.ndarray]]
    halt: Termination | None = None
    interrupted: bool = False
    stopped: str = ""
    inside: Callable[[np.ndarray], np.ndarray] | None = None
    switches: int = 0
    prepared: float = 0.0
    held: bool = False
    notes: tuple[str, ...] = ()
    ends: tuple[float, ...] = ()
    samples: tuple[StepSamples, ...] = ()

    def until(self, row: int, reason: str, last: tuple[Any, np.ndarray] | None = None) -> Run:
        """The run up to a row of its grid, after which it went wrong: after the ``last`` time and
        state that were good, or at once."""
        halt = Termination(reason, *(last or (self.t[row], self.states[row])))
        kept = until(self.crossings, self.t[0], halt.time)
        t, states = self.t[: row + 1], self.states[: row + 1]
        return replace(self, t=t, states=states, crossings=kept, halt=halt, stopped="")

    def without(self, names: Collection[str]) -> Run:
        """The run without the crossings of some events."""
        kept = {name: rows for name, rows in self.crossings.items() if name not in names}
        return replace(self, crossings=kept)


Integrator = Callable[[np.ndarray], Run]


@dataclass
class Log:
    """Crossings as they come."""

    start: Any
    span: float
    rows: dict[str, list[tuple[Any, np.ndarray]]] = field(default_factory=dict)
    stopped: str = ""
    switching_surfaces: frozenset[str] = frozenset()
    touches: list[tuple[Any, Guard]] = field(default_factory=list)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be said of events of users whose functions touch zero, before a stop."""
        last, first = self.last[0] if self.stopped else None, dict[str, Any]()
        for time, event in self.touches:
            early = last is None or abs(time - self.start) <= abs(last - self.start)
            if event.owner is not None and early:
                first.setdefault(event.owner.name, time)
        return tuple(
            f"the event '{name}' touches zero at t = {float(time):.6g} and passes it at most by "
            "rounding: that is no passage"
            for name, time in first.items()
        )

    def enter_all(
        self, found: Iterable[tuple[Any, Guard]], at: Callable[[np.ndarray], np.ndarray]
    ) -> None:
        """Keep crossings, in the order of the motion, up to those at the instant of one that stops,
        but for rounding; ``at`` gives states (k, n) at times (k,)."""
        for time, event in found:
            end = self.last[0] if self.stopped else time
            if abs(time - end) > AT_END * max(abs(end), self.span):
                break
            near = abs(end - self.start) <= AT_START * self.span
            if near and event.name not in self.switching_surfaces:
                continue
            here = self.last if self.stopped else (time, at(np.array([time]))[0])
            self.rows.setdefault(event.name, []).append(here)
            if event.stop:
                self.stopped = self.stopped or event.name

    @property
    def last(self) -> tuple[Any, np.ndarray]:
        """The crossing that ended the run."""
        return self.rows[self.stopped][-1]


def crossing_arrays(
    found: Mapping[str, Sequence[tuple[Any, np.ndarray]]], events: Sequence[Guard], width: int,
    dtype: Any,
) -> dict[str, tuple[np.ndarray, np.ndarray]]:  # fmt: skip
    """Times (k,) and states (k, n) of each event, from pairs of a time and a state (n,)."""
    result = {}
    for event in events:
        rows = found.get(event.name, [])
        states = np.array([s for _, s in rows], dtype=dtype).reshape(len(rows), width)
        result[event.name] = np.array([t for t, _ in rows], dtype=dtype), states
    return result


@dataclass
class Ticker:
    """Progress, reported now and then."""

    report: Callable[[float], Any] | None
    start: float
    end: float
    latest: float = field(default_factory=perf_counter)

    def __call__(self, time: Any) -> None:
        """The run has come to a time."""
        if self.report is None or perf_counter() - self.latest < EVERY:
            return
        self.latest = perf_counter()
        span = self.end - self.start
        self.report(float((time - self.start) / span) if span else 1.0)


def restart(solver: Integrator, problem: Problem) -> Callable[[np.ndarray, np.ndarray], Run]:
    """A problem's stepper as it goes on from any state (n,) on times (k,)."""

    def run(state: np.ndarray, times: np.ndarray) -> Run:
        problem.start[:] = state
        return solver(times)

    return run


def part_at(ends: Sequence[Any], order: float, times: np.ndarray) -> np.ndarray:
    """In which of the parts of a run, by the times at which they end, each of some times lies;
    ``order`` is 1 of a run into the future, else -1."""
    marks = np.array([float(order * end) for end in ends])
    which = np.searchsorted(marks, (order * times).astype(float), side="left")
    return np.minimum(which, len(marks) - 1)


def in_parts(
    ends: Sequence[Any],
    order: float,
    parts: Sequence[Callable[[np.ndarray], np.ndarray] | None],
    times: np.ndarray,
    states: np.ndarray,
) -> np.ndarray:
    """States at any times reached, each from the dense output of its part; where there are no
    parts, the first of ``states`` (k, n), which have the kind of numbers of the run."""
    if not len(parts):
        return np.repeat(states[:1], len(times), axis=0)
    which = part_at(ends, order, times)
    rows = np.empty((len(times), states.shape[1]), dtype=states.dtype)
    for i in np.unique(which):
        inside = parts[i]
        assert inside is not None
        rows[which == i] = inside(times[which == i])
    return rows


def until(crossings: Mapping[str, Any], start: Any, end: Any) -> dict[str, Any]:
    """Crossings up to a time."""
    kept = {}
    for name, (t, states) in crossings.items():
        early = np.array([abs(x - start) <= abs(end - start) for x in t], dtype=bool)
        kept[name] = t[early], states[early]
    return kept


def in_kind(numbers: np.ndarray, kind: Any) -> np.ndarray:
    """Exact numbers (k,) as doubles, or, where ``kind`` says objects, as mpmath's at the precision
    in force."""
    if np.dtype(kind).kind == "O":
        return np.array([exact_mpf(x) for x in numbers], dtype=object)
    return numbers.astype(float)


def exact_mpf(number: Any) -> Any:
    """An mpmath number at the precision in force."""
    if isinstance(number, Fraction):
        return mpmath.mpf(number.numerator) / number.denominator
    return mpmath.mpf(number)


@dataclass(frozen=True)
class Signal:
    """An input as a polynomial about an instant, its coefficients the values of ``parameters``:
    those of the input and of its rates up to ``degree``, and then, above degree 0, the instant.

    Either ``instants`` begin ``pieces``, each with its coefficients, or ``functions`` of the time
    give them at every instant; then steps end at ``instants``, and in the spans that are ``sharp``
    a function jumps or bends; or a controller gives them from the state, every ``period`` where it
    is sampled, and ``feedback`` is that in one run.  Values are known from ``first`` to ``last``;
    ``kind`` says in words what it was given as.
    """

    name: str
    degree: int
    kind: str
    parameters: tuple[str, ...] = ()
    first: float = -inf
    last: float = inf
    instants: tuple[Fraction | float, ...] = ()
    pieces: tuple[tuple[Fraction, ...], ...] = ()
    functions: tuple[Callable[[float], Any], ...] = ()
    sharp: tuple[tuple[float, float], ...] = ()
    feedback: Feedback | None = None
    period: Fraction | None = None

    @classmethod
    def of_functions(cls, name: str, functions: tuple[Callable[[float], Any], ...]) -> Signal:
        """A function of Python's, with as many of its rates as are given."""
        return cls(name, len(functions) - 1, "a function of Python's", functions=functions)

    @property
    def smoother(self) -> str:
        """What methods take that ask Python for nothing."""
        if self.feedback is not None:
            return "Sampled(controller, period)"
        return "an expression or a table"

    def mend(self, rate: str) -> str:
        """What would bring a rate that is lacking."""
        if self.functions:
            return f"inputs={{'{rate}': ...}} beside it, or an expression of t"
        return "a table of a smoother kind, or an expression of t"

    def on_piece(self, start: float, end: float) -> dict[str, Any]:
        """The parameters between two instants with no other between them."""
        if self.feedback is not None:
            return dict.fromkeys(self.parameters, self.feedback.at(start / 2 + end / 2))
        k = bisect_right(self.instants, Fraction(start) / 2 + Fraction(end) / 2) - 1
        k = min(max(k, 0), len(self.pieces) - 1)
        numbers = (*self.pieces[k], *([self.instants[k]] if self.degree else []))
        return dict(zip(self.parameters, numbers, strict=True))

    def at(self, instant: float) -> dict[str, Any]:
        """The parameters at an instant; at a jump, those after it."""
        if not self.functions:
            return self.on_piece(instant, instant)
        numbers = [self._number(f, instant) for f in self.functions]
        return dict(zip(self.parameters, [*numbers, instant][: len(self.parameters)], strict=True))

    def along(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """The parameters at instants (k,), an array (k,) for each parameter."""
        if self.feedback is not None:
            return dict.fromkeys(self.parameters, self.feedback.along(times))
        if self.functions:
            rows = [[*self.at(t).values()] for t in times.tolist()]
        else:
            last = len(self.pieces) - 1
            places = np.clip(np.searchsorted(self._starts, times, side="right") - 1, 0, last)
            since = [(t,) if self.degree else () for t in self.instants]
            rows = [[*self.pieces[k], *since[k]] for k in places]
        table = np.array(rows, dtype=object).reshape(len(times), len(self.parameters))
        return dict(zip(self.parameters, table.T, strict=True))

    @cached_property
    def _starts(self) -> np.ndarray:
        return np.array(list(map(float, self.instants)))

    def _number(self, function: Callable[[float], Any], instant: float) -> float:
        place = f"the input '{self.name}' at t = {instant:.12g}"
        try:
            value = float(function(instant))
        except Exception as error:  # whatever a user's function raises is told as his
            raise DefinitionError(f"{place}: {type(error).__name__}: {error}") from error
        if not np.isfinite(value):
            raise DefinitionError(f"{place} is {value}, which is not finite")
        return value


@dataclass(frozen=True)
class Signals:
    """The parameters that change in time."""

    signals: tuple[Signal, ...]

    @property
    def names(self) -> set[str]:
        """What they are called."""
        return {p for signal in self.signals for p in signal.parameters}

    @property
    def python_signal(self) -> Signal | None:
        """The first one that Python has to be asked for."""
        return next(
            (s for s in self.signals if s.functions or (s.feedback and not s.feedback.is_sampled)),
            None,
        )

    @property
    def feedbacks(self) -> list[Feedback]:
        """The controllers."""
        return [s.feedback for s in self.signals if s.feedback is not None]

    @property
    def functional(self) -> Signals | None:
        """Those alone that Python has to be asked for; None where there are none."""
        asked = tuple(s for s in self.signals if s.functions)
        return Signals(asked) if asked else None

    def knots(self, start: float, end: float) -> list[float]:
        """The instants of change strictly between two others, in the order of a run."""
        known, (low, high) = self._instants, sorted((start, end))
        instants = known[bisect_right(known, low) : bisect_left(known, high)]
        return instants[::-1] if end < start else instants

    @cached_property
    def _instants(self) -> list[float]:
        return sorted({float(t) for s in self.signals for t in s.instants})

    @property
    def order(self) -> tuple[str, ...]:
        """The parameters in the order in which ``on`` gives them."""
        return tuple(p for signal in self.signals for p in signal.parameters)

    def on(self, start: float, end: float) -> dict[str, Any]:
        """The values with which a run from one instant to the next change begins."""
        values: dict[str, Any] = {}
        ahead = [*self.knots(start, end), end][0]
        for signal in self.signals:
            values |= signal.at(start) if signal.functions else signal.on_piece(start, ahead)
        return values

    def values_at(self, instant: float) -> dict[str, Any]:
        """The values that Python gives at an instant."""
        signals = (s for s in self.signals if s.functions)
        return {name: x for s in signals for name, x in s.at(instant).items()}

    def without_rates(self, names: Iterable[str]) -> Signal | None:
        """The first function of Python's among parameters that is given without its rate."""
        wanted = {*names}
        return next(
            (s for s in self.signals if s.functions and not s.degree and wanted & {*s.parameters}),
            None,
        )

    def along(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """The values at instants (k,), an array (k,) for each parameter, exact where they are."""
        values: dict[str, np.ndarray] = {}
        for signal in self.signals:
            values |= signal.along(np.asarray(times, dtype=float))
        return values


def constants_along(
    changing: Signals | None, constants: Mapping[str, Any], times: np.ndarray
) -> Mapping[str, Any]:
    """Parameters by name, those that change as they are at times (k,), in numbers of that kind."""
    if changing is None:
        return constants
    along = changing.along(times)
    return {**constants, **{name: in_kind(x, times.dtype) for name, x in along.items()}}


def values_along(
    changing: Signals | None, names: Iterable[str], values: Iterable[Any], times: np.ndarray
) -> list[Any]:
    """Parameters by name at times (k,): those that change as arrays (k,), the others as numbers."""
    along = {} if changing is None else changing.along(times)
    pairs = zip(names, values, strict=True)
    return [in_kind(along[n], times.dtype) if n in along else np.float64(x) for n, x in pairs]

"""What every integrator takes and gives: a problem and a grid of times in, a run out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np

from voronec.equations.program import Program
from voronec.motion.events import Event
from voronec.motion.steppers.signals import Signals

__all__ = [
    "COLLAPSE",
    "DISTANT",
    "INFINITE",
    "SINGULAR",
    "Halt",
    "Log",
    "Problem",
    "Run",
    "Stepper",
    "Ticker",
    "cut_at_singularity",
]

COLLAPSE = "the step size collapsed"
INFINITE = "the state is no longer finite"
SINGULAR = "the motion cannot be continued"
AT_START = 1e-12
"""A crossing nearer to the start than this, in units of the span, is the start itself."""
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
    integrator may look for them only where the ends of a step do not exclude them.  ``walls`` are
    those at which the right side ceases to hold: they count however near to the start.
    Parameters that are ``changing`` are those of the start.  ``marked`` asks for the ends of steps.
    What is ``brief`` ends, most likely, long before its grid does: numba compiles for longer.
    ``units`` (n,) are those in which the states are measured, by default their natural ones.
    """

    program: Program
    start: np.ndarray
    parameters: Sequence[Any]
    tol: float
    events: tuple[Event, ...] = ()
    levels: Program | None = None
    dense: bool = False
    suspect: Suspect | None = None
    progress: Callable[[float], Any] | None = None
    exact: Callable[[int], tuple[np.ndarray, Sequence[Any]]] | None = None
    changing: Signals | None = None
    coarse: frozenset[str] = frozenset()
    walls: frozenset[str] = frozenset()
    marked: bool = False
    units: np.ndarray | None = None
    brief: bool = False

    def parameters_at(self) -> Callable[[float], Sequence[Any]]:
        """The parameters at any time of a piece: those that Python gives are asked for there."""
        changing = self.changing
        if changing is None or changing.python_signal is None:
            return lambda _: self.parameters
        places = {str(p): i for i, p in enumerate(self.program.parameters)}

        def at(time: float) -> Sequence[Any]:
            values = list(self.parameters)
            for name, value in changing.values_at(time).items():
                if name in places:
                    values[places[name]] = value
            return values

        return at


@dataclass(frozen=True)
class Halt:
    """Why and where an integrator could not go on: the last state that was good.

    ``singular`` says that a singular mass matrix is known to be the cause.
    """

    reason: str
    time: Any
    state: np.ndarray
    singular: bool = False


@dataclass(frozen=True)
class Run:
    """States at ``t``: the first points of the grid, and the crossing that ended the run, or where
    it stood when it was stopped by hand, far from the last of these points.

    ``crossings`` maps each event to its times and states; ``stopped`` names the one that ended the
    run; ``inside``, of dense runs, gives states at any times reached; ``held`` says
    that it was kept on a wall, along which no single right side holds; ``switches`` counts changes
    of chart, and ``prepared`` are the seconds of the run that making integrators for them took;
    ``notes`` are lines for the user; ``ends``, where a problem asks for them, the ends of steps.
    """

    t: np.ndarray
    states: np.ndarray
    steps: int
    evaluations: int
    crossings: Mapping[str, tuple[np.ndarray, np.ndarray]]
    halt: Halt | None = None
    interrupted: bool = False
    stopped: str = ""
    inside: Callable[[np.ndarray], np.ndarray] | None = None
    switches: int = 0
    prepared: float = 0.0
    held: bool = False
    notes: tuple[str, ...] = ()
    ends: tuple[float, ...] = ()

    def until(self, row: int, reason: str) -> Run:
        """The run up to a row of its grid, after which it went wrong."""
        halt = Halt(reason, self.t[row], self.states[row])
        kept = until(self.crossings, self.t[0], halt.time)
        t, states = self.t[: row + 1], self.states[: row + 1]
        return replace(self, t=t, states=states, crossings=kept, halt=halt, stopped="")

    def without(self, names: Collection[str]) -> Run:
        """The run as if nobody had looked for some events."""
        kept = {name: rows for name, rows in self.crossings.items() if name not in names}
        return replace(self, crossings=kept)


Stepper = Callable[[np.ndarray], Run]


@dataclass
class Log:
    """Crossings as they come."""

    start: Any
    span: float
    width: int
    rows: dict[str, list[tuple[Any, np.ndarray]]] = field(default_factory=dict)
    stopped: str = ""
    silent: bool = False
    walls: frozenset[str] = frozenset()

    def enter(self, event: Event, time: Any, state: np.ndarray) -> bool:
        """Keep a crossing; whether it ends the run."""
        near = event.name not in self.walls and abs(time - self.start) <= AT_START * self.span
        if self.silent or near:
            return False
        self.rows.setdefault(event.name, []).append((time, state))
        if event.stop:
            self.stopped = event.name
        return event.stop

    @property
    def last(self) -> tuple[Any, np.ndarray]:
        """The crossing that ended the run."""
        return self.rows[self.stopped][-1]

    def arrays(self, events: Sequence[Event], dtype: Any) -> dict[str, tuple[Any, Any]]:
        """Times (k,) and states (k, n) by name."""
        result = {}
        for event in events:
            rows = self.rows.get(event.name, [])
            states = np.array([s for _, s in rows], dtype=dtype).reshape(len(rows), self.width)
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


def cut_at_singularity(run: Run, problem: Problem) -> Run:
    """The run, cut before the first point of its grid that lies beyond a singular mass matrix."""
    if problem.suspect is None or len(run.t) < 2:
        return run
    found = problem.suspect(run.t.astype(float), run.states.astype(float))
    if found is None:
        return run
    last = max(found, 1)
    halt = Halt(SINGULAR, run.t[last - 1], run.states[last - 1], singular=True)
    kept = until(run.crossings, run.t[0], halt.time)
    return replace(run, t=run.t[:last], states=run.states[:last], crossings=kept, halt=halt)


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
    found = np.empty((len(times), states.shape[1]), dtype=states.dtype)
    for i in np.unique(which):
        inside = parts[i]
        assert inside is not None
        found[which == i] = inside(times[which == i])
    return found


def until(crossings: Mapping[str, Any], start: Any, end: Any) -> dict[str, Any]:
    """Crossings up to a time."""
    kept = {}
    for name, (t, states) in crossings.items():
        early = np.array([abs(x - start) <= abs(end - start) for x in t], dtype=bool)
        kept[name] = t[early], states[early]
    return kept

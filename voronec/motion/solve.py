"""The loop over the phases of a motion: it alone slices the grid, joins what phases give, and knows
progress, Ctrl-C, the direction of time and the limit on changes that lead nowhere.

A ``Phase`` is one program with the stepper that integrates it.  It runs until the end of the grid,
until an instant of its own, or until a guard stops it; the ``Transition`` that owns the guard then
says what is next: another phase, or a halt.  What a phase runs may be such a loop itself: charts
and modes go through pieces of inputs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from voronec.motion.request import Guard
from voronec.motion.steppers import (
    DISTANT,
    Run,
    StepSamples,
    Termination,
    Ticker,
    crossing_arrays,
    in_kind,
    in_parts,
)

DOUBLE = 53
"""Bits of a double."""
WINDOW, CRAWL = 200, 1e-8
"""So many changes that cover less than this part of the span lead nowhere."""
ULPS = 16
"""Instants that lie closer together than so many roundings of them are one."""
COINCIDENT = 1e-9
"""An event that was seen closer than this to a change, in units of the time, is not another one."""
ZENO = "switches follow one another ever faster"


class Arrival(NamedTuple):
    """Where a phase ended: at a ``time``, in a ``state`` (n,) of its own, which is ``home`` (m,) in
    the variables of the whole run.

    ``guard`` is what ended it, empty where its own end did; ``ahead`` the next instant of the grid,
    None where there is none; ``halt`` says why its stepper could not go on, where it could not.
    """

    time: Any
    state: np.ndarray
    home: np.ndarray
    guard: str
    ahead: Any
    halt: Termination | None


class Transition(Protocol):
    """What ends phases and begins the next ones; whoever makes a phase puts the functions of its
    guards among the events of the phase's problem, and itself beside them in ``Phase.guards``."""

    def next(self, phase: Phase, here: Arrival) -> Phase | Termination:
        """How the motion goes on where a guard of its own ended a phase."""


@dataclass(frozen=True)
class Phase:
    """A part of a motion, from a ``time`` and a ``state`` (n,) on, which is ``home`` (m,) in the
    variables of the whole run.

    ``what`` it goes in is known to its transitions.  ``integrate`` takes a state and times to a run
    in the variables of the phase, which ``to_home`` takes to those of the whole run.  ``guards``
    are the owners of the events that end it, by their names.  At its ``end``, and where its stepper
    can go no farther, ``successor`` is asked; where there is none, the run ends.  ``happened`` are
    the events of users that happen just where it begins, and ``is_change`` counts as a switch.
    """

    what: Any
    time: Any
    state: np.ndarray
    home: np.ndarray
    integrate: Callable[[np.ndarray, np.ndarray], Run]
    guards: Mapping[str, Transition]
    to_home: Callable[[Run], Run] = lambda run: run
    end: Any = None
    successor: Transition | None = None
    happened: Sequence[Guard] = ()
    is_change: bool = True


@dataclass
class Progress:
    """Progress of a phase, reported as progress of the whole run."""

    report: Callable[[float], Any]
    done: float = 0.0
    part: float = 1.0

    def __call__(self, fraction: float) -> None:
        """The phase has come so far."""
        self.report(self.done + fraction * self.part)


class GridRows(NamedTuple):
    """States (k, m) at times (k,) of the grid that belong to one phase."""

    phase: Any
    t: np.ndarray
    states: np.ndarray


@dataclass
class Solver:
    """One run on a ``grid``: where it is, and what it has seen.

    ``events`` are those to be kept, ``progress`` is what the problems of phases report to, and
    ``bits`` are those of its numbers.  ``rows`` are the states on the grid, ``parts`` the phases
    with their runs in the variables of the whole.
    """

    grid: np.ndarray
    events: Sequence[Guard]
    dense: bool
    progress: Progress | None = None
    bits: int = DOUBLE
    rows: list[GridRows] = field(default_factory=list)
    parts: list[tuple[Phase, Run]] = field(default_factory=list)
    crossings: dict[str, list[tuple[Any, np.ndarray]]] = field(default_factory=dict)
    done: int = 1
    switches: int = 0
    idle: float = 0.0
    recent: list[Any] = field(default_factory=list)

    def run(self, phase: Phase | Termination) -> Run:
        """Phase after phase, up to the end of the grid or to what ends the run before."""
        self.order = 1 if self.grid[-1] >= self.grid[0] else -1
        self.forward = self.order * self.grid
        report = None if self.progress is None else self.progress.report
        self.ticker = Ticker(report, float(self.grid[0]), float(self.grid[-1]))
        home = phase.state if isinstance(phase, Termination) else phase.home
        first = in_kind(self.grid[:1], home.dtype)
        self.standing = first[0], home
        self.rows.append(GridRows(phase, first, home[None].copy()))
        if isinstance(phase, Termination):
            return self.result(phase)
        try:
            while True:
                stretch, part = self.segment(phase)
                owner = phase.guards.get(part.stopped)
                if part.halt or (not part.stopped and phase.end is not None):
                    owner = phase.successor
                if owner is None or part.interrupted:
                    return self.result(part.halt, part.interrupted, part.stopped)
                here, done = self.arrive(stretch)
                following = owner.next(phase, here)
                if isinstance(following, Termination):
                    return self.result(following)
                self.switches += following.is_change
                if stopped := self.enter(following, here):
                    return self.result(stopped=stopped)
                if here.guard and self.stalls(here.time):
                    return self.result(Termination(ZENO, *self.standing))
                near = in_kind(self.grid[self.done : done], here.home.dtype)
                self.keep(phase, near, np.repeat(here.home[None], len(near), axis=0))
                if self.done == len(self.grid):
                    return self.result()
                phase = following
        except KeyboardInterrupt:
            return self.result(interrupted=True)

    def segment(self, phase: Phase) -> tuple[Run, Run]:
        """Go on in a phase until it ends, or the grid does: its run, and that at home."""
        times, forward = self.times(phase), self.forward[self.done :]
        if self.progress is not None:
            whole = (self.grid[-1] - self.grid[0]) or 1.0
            self.progress.done = float((phase.time - self.grid[0]) / whole)
            self.progress.part = float((times[-1] - phase.time) / whole)
        stretch = phase.integrate(phase.state, times)
        part = phase.to_home(stretch)
        reached = self.order * part.t
        count = int(np.searchsorted(forward, reached[-1], side="right"))
        taken = np.searchsorted(reached, forward[:count])
        begin, end, halt = part.t[0], part.t[-1], part.halt
        left = abs(end - (self.grid[self.done + count - 1] if count else begin))
        share = float(left / abs(end - begin)) if end != begin else 0.0
        self.idle = (0.0 if count else self.idle) + share * part.steps
        if not self.parts and part.states.dtype != phase.home.dtype:  # now it is in many digits
            self.rows = [GridRows(phase, part.t[:1], part.states[:1])]
        self.keep(phase, part.t[taken], part.states[taken])
        self.parts.append((phase, part))
        self.standing = (halt.time, halt.state) if halt else (end, part.states[-1])
        for event in self.events:
            pairs = zip(*part.crossings[event.name], strict=True)
            self.crossings.setdefault(event.name, []).extend(pairs)
        self.ticker(end)
        return stretch, part

    def times(self, phase: Phase) -> np.ndarray:
        """The instants (k,) for a phase: where it begins, those of the grid, and its own end."""
        ahead, forward = self.grid[self.done :], self.forward[self.done :]
        if phase.end is not None:
            first = np.searchsorted(forward, self.order * phase.time, side="right")
            last = np.searchsorted(forward, self.order * phase.end)
            ahead = np.append(ahead[first:last], phase.end)
        begin = np.array([phase.time], dtype=phase.state.dtype)
        return np.concatenate([begin, ahead.astype(begin.dtype)])

    def keep(self, phase: Phase, t: np.ndarray, states: np.ndarray) -> None:
        """Enter the next points of the grid."""
        if len(t):
            self.rows.append(GridRows(phase, t, states))
            self.done += len(t)

    def arrive(self, own: Run) -> tuple[Arrival, int]:
        """Where a phase ended, and how many points of the grid are then behind it: those that
        rounding alone tells from its end, too, since no step fits between."""
        time, home = self.standing
        state = own.states[-1] if own.halt is None else own.halt.state
        done, near = self.done, ULPS * 2.0**-self.bits * abs(time)
        while done < len(self.grid) and abs(self.grid[done] - time) <= near:
            done += 1
        ahead = self.grid[done] if done < len(self.grid) else None
        return Arrival(time, state, home, own.stopped, ahead, own.halt), done

    def enter(self, found: Phase, here: Arrival) -> str:
        """Enter the events that happen just where a phase begins; the one that ends the run."""
        stopped = ""
        for event in found.happened:
            seen = self.crossings.setdefault(event.name, [])
            if seen and abs(seen[-1][0] - here.time) <= COINCIDENT * max(1, abs(here.time)):
                continue
            seen.append((here.time, found.home))
            self.standing = here.time, found.home
            stopped = stopped or (event.name if event.stop else "")
        return stopped

    def stalls(self, time: Any) -> bool:
        """Whether many changes cover next to nothing."""
        self.recent.append(time)
        if len(self.recent) <= WINDOW:
            return False
        return bool(abs(time - self.recent.pop(0)) <= CRAWL * float(np.ptp(self.grid)))

    def result(
        self, halt: Termination | None = None, interrupted: bool = False, stopped: str = ""
    ) -> Run:
        """The run of all phases."""
        runs, (time, state) = [part for _, part in self.parts], self.standing
        kept = bool(stopped) or (interrupted and self.idle >= DISTANT)
        if kept and self.order * time > self.order * self.rows[-1].t[-1]:
            last = np.array([time], dtype=state.dtype)
            self.rows.append(GridRows(self.parts[-1][0], last, state[None]))
        states = np.vstack([rows.states for rows in self.rows])
        return Run(
            np.concatenate([rows.t for rows in self.rows]), states,
            sum(run.steps for run in runs), sum(run.evaluations for run in runs),
            crossing_arrays(self.crossings, self.events, states.shape[1], states.dtype),
            halt, interrupted, stopped, self.inside if self.dense else None,
            switches=self.switches + sum(run.switches for run in runs),
            prepared=sum(run.prepared for run in runs),
            held=any(run.held for run in runs),
            notes=tuple(dict.fromkeys(note for run in runs for note in run.notes)),
            ends=tuple(end for run in runs for end in run.ends),
            samples=StepSamples.of_pieces(sample for run in runs for sample in run.samples),
        )  # fmt: skip

    def inside(self, times: np.ndarray) -> np.ndarray:
        """States at any times reached."""
        runs = [part for _, part in self.parts]
        ends, parts = [run.t[-1] for run in runs], [run.inside for run in runs]
        return in_parts(ends, self.order, parts, times, self.rows[0].states)

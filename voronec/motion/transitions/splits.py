"""From one split of the velocities to another, where a divisor comes near zero.

Each split is integrated in on the coordinates and through the charts of the system, or through its
modes; at a change all velocities are carried over by exact linear formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter, process_time
from types import MappingProxyType
from typing import Any

import mpmath
import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.errors import IntegrationError
from voronec.motion.atlas import kept_charts
from voronec.motion.methods import is_exact
from voronec.motion.motion_start import WideStart
from voronec.motion.observables import ObservedQuantities, evaluate_watch
from voronec.motion.request import Guard, Namespace
from voronec.motion.singular_coordinates import PoleNotes
from voronec.motion.singular_denominators import CLEAR, GAIN, NEAR, guard_events
from voronec.motion.solve import Arrival, Phase, Progress, Solver
from voronec.motion.split_models import SplitContext, SplitModel, candidates
from voronec.motion.state_probe import StateProbe, quantities
from voronec.motion.steppers import Problem, Run, Termination, in_kind, natural_units, part_at
from voronec.motion.tolerances import EXACT
from voronec.motion.trajectory import Cost, Crossings, Trajectory, assemble_trajectory
from voronec.motion.transitions.charts import through_charts
from voronec.motion.transitions.modes import through_switching_surfaces
from voronec.motion.verify import SolutionCheck

DEPENDENT = "the constraints become dependent"
NOWHERE = "whichever velocities are independent, the equations divide by zero"
LEAST = 1e-6
"""Constraints that are less independent than this, in units of what they usually are, are taken
for dependent, and so are velocities at the start: they lose more digits than they leave."""
FAINT = 1e-3
"""In doubles a run ends where the best split is so near to its end: what is lost is the square of
it, and rounding makes steps short without end."""
LOSS = 10
"""Where rounding may take more than so many times the tolerance, that is said."""
LONGER, RECENT = 4.0, 2
"""A stretch is not expected to be longer than the one times the longest of so many before it."""
EARLY, BETTER = 0.5, 2.0
"""Below the one, in units of its usual size, a divisor makes its split be left for one that is
ready and so many times better: what a split loses grows with powers of its divisors."""
HEAVY, MANY = 200.0, 8
"""Programs that weigh more take seconds to make ready, and a run has no more splits than so many
before one is made that is not needed."""


@dataclass(eq=False)
class SplitRun:
    """One run through the splits of a system.

    ``watch`` and ``functions`` are what is wanted, for the home split; ``began`` and ``busy`` when
    the whole began, in seconds of the clock.
    """

    namespace: Namespace
    ground: SplitContext
    watch: ObservedQuantities
    functions: Mapping[str, Any]
    start: WideStart
    grid: np.ndarray
    method: str
    tol: float
    events: tuple[Guard, ...]
    dense: bool
    progress: Callable[[float], Any] | None
    notes: tuple[str, ...]
    bits: int
    began: float
    splits: list[SplitModel] = field(default_factory=list)
    chosen: dict[str, Any] = field(default_factory=dict)
    methods: dict[str, None] = field(default_factory=dict)
    prepared: float = 0.0
    check_notes: list[str] = field(default_factory=list)
    units: dict[SplitModel, np.ndarray] = field(default_factory=dict)
    faintest: float = np.inf
    faintest_time: float = np.nan
    solver: Solver = field(init=False)

    def trajectory(self) -> Trajectory:
        """Integrate, and look at what is wanted; ``IntegrationError`` where it cannot be done."""
        busy, progress = process_time(), self.progress and Progress(self.progress)
        self.solver = Solver(self.grid, self.events, self.dense, progress, self.bits)
        split = self.best_split(self.grid[0], self.start.wide, None)
        run = self.solver.run(self.phase(split, self.grid[0], self.start.wide))
        if not self.chosen:  # it was stopped by hand before it began
            raise KeyboardInterrupt
        if run.halt is not None:
            raise self.failure(run, run.halt, busy)
        return self.result(run, busy)

    def next(self, phase: Phase, here: Arrival) -> Phase | Termination:
        """The split in which the motion goes on."""
        split, halt = phase.what, here.halt
        if halt is None and here.ahead is None:
            return replace(phase, is_change=False)
        wide = self.widen(split, here.time, here.state)
        if halt is None and here.guard in self._early_events(split)[1]:
            return self.phase(self.better_split(here.time, wide, split), here.time, wide, split)
        best = self.best_split(here.time, wide, split)
        if halt is not None and best is split:
            return halt
        if reason := self.obstacle(best, here.time, wide):
            return Termination(reason, here.time, here.state)
        return self.phase(best, here.time, wide, split)

    def phase(
        self, split: SplitModel, time: Any, wide: np.ndarray, last: SplitModel | None = None
    ) -> Phase:
        """The motion in a split from a wide state on; the variables of a run are those of each."""
        levels = {
            **guard_events(split.guards, bounds=split.bounds)[1],
            **self._early_events(split)[1],
        }
        state = split.narrow(float(time), wide.astype(float))
        return Phase(
            split, time, wide, state, partial(self.segment, split, state),
            dict.fromkeys(levels, self), successor=self, is_change=split is not last,
        )  # fmt: skip

    # -- splits -----------------------------------------------------------------------------

    def best_split(self, time: Any, wide: np.ndarray, last: SplitModel | None) -> SplitModel:
        """The split to go on in: one that is ready and good enough, else the first of those that
        can be made that is, else the best; not the last one, unless no other is much better."""
        plain = wide.astype(float)
        sizes = {p: p.quality(time, plain) for p in self.splits}
        ready = max(self.splits, key=lambda p: sizes[p], default=None)
        if ready is not None and ready is not last and sizes[ready] > CLEAR:
            return ready
        sizes |= self.make_splits(time, plain, CLEAR)
        best = max(self.splits, key=lambda p: sizes[p], default=None)
        if best is None or (last is None and not sizes[best] > LEAST):
            raise IntegrationError(
                f"system '{self.ground.home.system.name}': no velocities determine the motion at "
                f"the initial point ({self._show_state(plain)}): the constraints are dependent or "
                "the coordinates singular; start elsewhere",
                time,
                plain,
            )
        if last is not None and sizes[best] < GAIN * sizes[last]:
            return last
        return best

    def better_split(self, time: Any, wide: np.ndarray, last: SplitModel) -> SplitModel:
        """The best of the splits that are ready, or soon made, if it is much better than the last
        one."""
        sizes = {p: p.quality(time, wide) for p in self.splits}
        enough = BETTER * sizes[last]
        soon = last.program.weight <= HEAVY and len(self.splits) < MANY
        if soon and max(sizes.values()) <= enough:
            sizes |= self.make_splits(time, wide.astype(float), enough)
        best = max(self.splits, key=lambda p: sizes[p])
        return best if sizes[best] > enough else last

    def make_splits(self, time: Any, wide: np.ndarray, enough: float) -> dict[SplitModel, float]:
        """Splits that are made until one is good enough at a wide state, and how good they are."""
        began, sizes = perf_counter(), {}
        with suppress(np.linalg.LinAlgError):
            for equations, form in candidates(self.ground, float(time), wide):
                if any(p.form is form for p in self.splits):
                    continue
                made = SplitModel.of(
                    replace(self.ground, time=float(time)), equations, form, self.watch,
                    self.functions, wide,
                )  # fmt: skip
                self.splits.append(made)
                sizes[made] = made.quality(time, wide)
                if sizes[made] > enough:
                    break
        self.prepared += perf_counter() - began
        return sizes

    def obstacle(self, best: SplitModel, time: Any, wide: np.ndarray) -> str:
        """Why not even the best split leads on from a wide state; empty where it does."""
        size, least = best.quality(time, wide), LEAST if self.exact else FAINT
        strength = np.inf if size > CLEAR else self.ground.strength(float(time), wide.astype(float))
        if (both := min(size, strength)) < self.faintest:
            self.faintest, self.faintest_time = both, float(time)
        if size > least and strength > LEAST:
            return ""
        return DEPENDENT if strength < least else NOWHERE

    def _loss(self) -> Iterator[str]:
        """A note where the motion passed so near to a place that no split leads through that
        rounding, which is magnified by the square of the nearness, outgrows the tolerance."""
        lost = np.finfo(float).eps / self.faintest**2
        if not self.exact and lost > LOSS * self.chosen["tolerance"]:
            yield (
                "the motion passes close to where the constraints are dependent, at t = "
                f"{self.faintest_time:.6g}: up to {lost:.0e} is lost there by rounding, and as "
                f"much more as the motion magnifies it; a tol under {EXACT:.0e} takes more digits"
            )

    def _show_state(self, wide: np.ndarray) -> str:
        pairs = zip(self.ground.home.definition.coordinates, wide, strict=False)
        return ", ".join(f"{name} = {float(x):.6g}" for name, x in pairs)

    def _early_events(self, split: SplitModel) -> tuple[tuple[Guard, ...], dict[str, Any]]:
        falling = -1 if self.grid[-1] >= self.grid[0] else 1
        return guard_events(split.guards, EARLY, falling)

    # -- stretches --------------------------------------------------------------------------

    def segment(
        self, split: SplitModel, state: np.ndarray, wide: np.ndarray, times: np.ndarray
    ) -> Run:
        """Go on in a split until a divisor is small, or the grid ends."""
        began, time = perf_counter(), times[0]
        guards, levels = guard_events(split.guards, bounds=split.bounds)
        bounds = split.bounds_from(float(time), wide)
        marks, early = self._early_events(split)
        levels = {**levels, **early}
        functions = {**split.functions, **levels}
        values = self.ground.values(split.program, float(time), {**self.ground.constants, **bounds})
        probe = self.probe(split, float(time), values)
        if not split.equations.system.charts:
            self.check_notes += probe.check(state)
        problem = Problem(
            split.program, state, values, self._tolerance(split),
            (*self.events, *guards, *marks),
            quantities(split.bounded_form, functions) if functions else None, self.dense,
            probe.suspect(state), self.solver.progress, self._exact(split, time, wide, bounds),
            self.ground.changing,
            frozenset(levels),
            brief=self._likely_length(split, times),
        )  # fmt: skip
        poles = self._pole_notes(split)
        problem = poles.watch(problem, split.bounded_form, functions)
        functions |= poles.levels
        # a split has one program: stretches of ordinary size and others would have two
        units = self.units.setdefault(split, natural_units(problem))
        problem = replace(problem, units=units)
        if wide.dtype == object or self.exact:
            with mpmath.workprec(self.bits):
                times = in_kind(times, object)
        switched = through_switching_surfaces(
            self.method, problem, times, split.bounded_form, functions
        )
        if switched is not None:
            solver, chosen = switched.solver, switched.chosen
        else:
            solver, chosen = through_charts(
                self.method, problem, times, split.equations, functions, split.bounded_form
            )
        self.chosen = self.chosen or {**chosen, "tolerance": max(chosen["tolerance"], self.tol)}
        self.methods.setdefault(chosen["method"])
        self.prepared += perf_counter() - began
        smooth = switched is None
        return self.check(split, poles.with_notes(solver(times)), smooth)

    def _pole_notes(self, split: SplitModel) -> PoleNotes:
        """What looks for poles at which a split is regular, unless a chart's stepper does."""
        equations, form = split.equations, split.bounded_form
        alone = self.exact or split.program.is_rough
        charted = not alone and bool(kept_charts(equations, form))
        return PoleNotes.of(equations, split.program.state, self.watch.outputs, charted)

    def probe(self, split: SplitModel, time: float, values: Sequence[Any]) -> StateProbe:
        """Looks at single states of a split, from a time on."""
        name, changing = self.ground.home.system.name, self.ground.changing
        return StateProbe(name, split.bounded_form, split.program, values, time, changing)

    def _likely_length(self, split: SplitModel, times: np.ndarray) -> float:
        """What the next stretch will last at most, as the last ones of its split tell."""
        runs = [run for _, run in self.solver.parts]
        own = [run for phase, run in self.solver.parts if phase.what is split] or runs
        lengths = [abs(float(run.t[-1] - run.t[0])) for run in own[-RECENT:]]
        return LONGER * max(lengths) if lengths else abs(float(times[-1] - times[0]))

    def _tolerance(self, split: SplitModel) -> float:
        """The tolerance in a split, finer by as much as its divisors may magnify errors."""
        finer = max(NEAR * self.tol, EXACT) if split.guards else self.tol
        return min(self.tol, finer)

    def check(self, split: SplitModel, part: Run, smooth: bool) -> Run:
        """A stretch up to where it went wrong, if it did; what is to be said is noted."""
        watch, home = split.watch, self.ground.home
        watch.require_reactions(part.held, home.system.name)
        check = SolutionCheck(
            home, split.program,
            [float(x) for x in self.ground.values(split.program, float(part.t[0]))],
            self.chosen["tolerance"], part.steps, watch.integrals_to_follow(smooth),
            watch.relations, (), self.ground.changing,
            watch.integrals_to_follow(smooth, jumping=True),
        )  # fmt: skip
        t, states = part.t.astype(float), part.states.astype(float)
        breach, notes = check.breach(t, states, part.samples)
        self.check_notes += [note for note in notes if note not in self.check_notes]
        return part if breach is None else part.until(breach.row, breach.what, breach.last)

    def _exact(
        self, split: SplitModel, time: Any, wide: np.ndarray, bounds: Mapping[str, float]
    ) -> Callable[[int], Any]:
        def exact(bits: int) -> tuple[np.ndarray, list[Any]]:
            with mpmath.workprec(bits):
                first, constants = self.start.exact(bits)
                given = wide if wide.dtype == object else first
                state = split.narrow(mpmath.mpf(time), given, constants)
                exactly = {**constants, **{name: mpmath.mpf(x) for name, x in bounds.items()}}
                return state, self.ground.values(split.program, mpmath.mpf(time), exactly)

        return exact

    @property
    def exact(self) -> bool:
        """Whether the run is in high precision."""
        return is_exact(self.method, self.tol)

    def widen(self, split: SplitModel, time: Any, state: np.ndarray) -> np.ndarray:
        """The wide state of a state of a split."""
        with mpmath.workprec(self.bits):
            return split.widen(time, state, self._constants(state))

    def _constants(self, states: np.ndarray) -> Mapping[str, Any]:
        if states.dtype != object:
            return self.ground.constants
        return self.start.exact(self.bits)[1]

    # -- what is seen -----------------------------------------------------------------------

    def result(self, run: Run, busy: float) -> Trajectory:
        """The trajectory of a run through splits."""
        notes = *self.notes, *run.notes, *self.check_notes, *self._loss()
        whole = perf_counter() - self.began
        chosen = {**self.chosen, "method": ", ".join(self.methods)}
        cost = Cost(
            **chosen, setup=self.prepared, run=max(whole - self.prepared, 0.0),
            cpu=process_time() - busy, steps=run.steps, evaluations=run.evaluations,
            switches=run.switches,
        )  # fmt: skip
        rows = [(rows.phase.what, rows.t, rows.states) for rows in self.solver.rows]
        return replace(
            self._assemble(rows, cost),
            events=MappingProxyType({e.name: self._crossings(e.name) for e in self.events}),
            stopped=run.stopped,
            halted=run.halt.reason if run.halt is not None else "",
            interrupted=run.interrupted,
            within=(lambda times: self._inside(times, cost)) if self.dense else None,
            notes=(*dict.fromkeys(notes),),
        )

    def failure(self, run: Run, halt: Termination, busy: float) -> IntegrationError:
        """The error for a run that cannot go on in any split."""
        phase, last = self.solver.parts[-1]
        values = self.ground.values(phase.what.program, float(self.grid[0]))
        probe = self.probe(phase.what, float(self.grid[0]), values)
        return probe.failure(last.states[0], halt, self.result(run, busy))

    def _series(
        self, parts: list[tuple[SplitModel, np.ndarray, np.ndarray]]
    ) -> dict[str, np.ndarray]:
        """Everything watched at states of several splits, one after the other."""
        found = []
        for split, times, rows in parts:
            if len(times):
                with mpmath.workprec(self.bits):
                    times = in_kind(times, rows.dtype)
                    values = self.ground.values(split.program, times, self._constants(rows))
                    found.append(evaluate_watch(split.watch, split.program, times, rows, values))
        names = found[0] if found else {}
        return {
            name: np.concatenate([np.asarray(s[name]) for s in found])
            for name in names
            if all(name in s for s in found)
        }

    def _assemble(
        self, parts: list[tuple[SplitModel, np.ndarray, np.ndarray]], cost: Cost,
        order: np.ndarray | None = None,
    ) -> Trajectory:  # fmt: skip
        times, series = np.concatenate([t for _, t, _ in parts]), self._series(parts)
        with mpmath.workprec(self.bits):
            times = in_kind(times, parts[0][2].dtype)
        if order is not None:
            times, series = times[order], {n: x[order] for n, x in series.items()}
        names, constants = self._names, self._constants(parts[0][2])
        states = np.stack([series[f"home {n}"] for n in names], axis=-1)
        with mpmath.workprec(self.bits):
            return assemble_trajectory(
                self.namespace, self.watch, times, names, states, series, constants, cost
            )

    @property
    def _names(self) -> tuple[str, ...]:
        system = self.ground.home.system
        return tuple(map(plain_name, (*system.coordinates, *system.velocities)))

    def _crossings(self, name: str) -> Crossings:
        parts = [(phase.what, *run.crossings[name]) for phase, run in self.solver.parts]
        series = self._series(parts)
        none = np.empty(0)
        times = np.concatenate([none, *(t for _, t, _ in parts)])
        states = np.stack([series.get(f"home {n}", none) for n in self._names], axis=-1)
        shown = {n: series.get(n, none) for n in self.watch.outputs}
        return Crossings.of(times, states, self._names, shown)

    def _inside(self, times: np.ndarray, cost: Cost) -> Trajectory:
        """The motion at any times reached."""
        which = part_at([run.t[-1] for _, run in self.solver.parts], self.solver.order, times)
        parts, positions = [], []
        for i in np.unique(which):
            here, (phase, run) = np.flatnonzero(which == i), self.solver.parts[i]
            assert run.inside is not None
            parts.append((phase.what, times[here], run.inside(times[here])))
            positions.append(here)
        return self._assemble(parts, cost, np.argsort(np.concatenate(positions)))

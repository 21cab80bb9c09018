"""Ensembles: many starts, or many values of the parameters, of one system on one grid of times."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from threading import Event
from time import perf_counter
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.arguments import (
    CALLABLE,
    COUNT,
    FLAG,
    SEVERAL,
    TEXT,
    TOLERANCE,
    VALUES,
    accepts,
)
from voronec.algebra.typeset import html_table
from voronec.declaration.system import System, require_system
from voronec.declaration.worker_processes import Team
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import IntegrationError, VoronecError
from voronec.motion.batches import choose_lanes, require_method
from voronec.motion.carrier import CarriedBlock, Carrier, MotionBlock
from voronec.motion.inputs import Drive, drive
from voronec.motion.method_costs import step_cost
from voronec.motion.motion_pool import Many, many
from voronec.motion.one_by_one import LoneMotions, LoneStart
from voronec.motion.request import (  # fmt: skip
    Namespace,
    Starts,
    Values,
    grid_of,
    held_name,
    outputs_of,
    quantity,
    scene_of,
    spread_starts,
)
from voronec.motion.tolerances import EXACT
from voronec.motion.trajectory import Cost, Trajectory

if TYPE_CHECKING:
    from voronec.motion.storage import NamedArrays

FEW = 20
"""Rows of the table that a notebook shows."""
BATCHES, REPORTS = 8, 8
"""So many loads of the lanes at least go between two reports, and so many reports there are at
least where the motions suffice for both."""
STEPS, NUMBERS = 100_000, 2**22
"""So many steps, and numbers of states on the grid, go between two reports, unless that is less."""
LONE = 5e3
"""Microseconds that a motion takes alone, at least."""
WORTH = 1e6
"""Microseconds of work for which other processes are worth their start, which takes a second; by
the steps of the slowest ones, which go first, there is at least so much."""


@dataclass(frozen=True, eq=False, repr=False)
class Ensemble:
    """Many motions of one system on one grid of times.

    ``t`` has shape (k,); ``ensemble["u"]`` has shape (starts, k), by name, symbol or expression
    among ``outputs``.  What was not computed is not a number: a motion that failed keeps what came
    before, and ``errors`` tells by its position why it failed; one that the run did not come to is
    missing in ``finished``, of shape (starts,).  ``parameters`` are arrays (starts,).  ``notes``
    has by position what is to be said of motions, as in ``Trajectory``: that they passed a pole of
    their coordinates, or that an integral drifts that is only claimed.

    ``drift`` maps each integral that the equations in use can express to its largest change
    along each motion, (starts,), relative as in ``Trajectory``.  ``formulation`` names the
    variables of these equations, as in ``Model``.  ``interrupted`` says that the run was stopped by
    hand, and so does what is printed of it.
    """

    system: System
    t: np.ndarray
    outputs: tuple[str, ...]
    series: Mapping[str, np.ndarray]
    parameters: Mapping[str, np.ndarray]
    finished: np.ndarray
    errors: Mapping[int, VoronecError]
    drift: Mapping[str, np.ndarray]
    formulation: str
    cost: Cost
    interrupted: bool = False
    notes: Mapping[int, tuple[str, ...]] = field(default_factory=dict)

    def __getitem__(self, key: Any) -> np.ndarray:
        return self.series[held_name(key, self.series, "the ensemble holds")]

    def __len__(self) -> int:
        return len(self.finished)

    def plot(self, names: Sequence[str] | None = None) -> Any:
        """Quantities against the time, by default the outputs, as a matplotlib ``Figure``: some of
        the motions, the median of all, and between which values nine of ten lie.

        Raises ``DefinitionError`` for a name that the ensemble does not hold.
        """
        from voronec.motion.pictures.ensemble_picture import plot_ensemble

        return plot_ensemble(self, self.finished, names)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the motions to ``path``, as ``Trajectory.save`` does."""
        return self._arrays().save(path)

    def to_xarray(self) -> Any:
        """The motions as an ``xarray.Dataset``, the header as attributes."""
        return self._arrays().to_xarray()

    def to_pandas(self) -> Any:
        """The motions as a ``pandas.DataFrame``, a row for each motion at an instant."""
        return self._arrays().to_pandas()

    def _arrays(self) -> NamedArrays:
        """The motions along ``motion`` and ``t``."""
        from voronec.motion.storage import NamedArrays, of_motions, variables_of

        variables: dict[str, Any] = {
            "t": (("t",), self.t),
            "finished": (("motion",), self.finished),
        }
        variables |= {name: (("motion", "t"), self[name]) for name in self.outputs if name != "t"}
        each = of_motions(len(self), self.errors, self.parameters, drift=self.drift)
        return NamedArrays.of(
            self.system, "Ensemble", variables_of(variables, each), ("motion", "t"),
            ("motion", "t", *self.outputs), formulation=self.formulation,
            interrupted=self.interrupted, cost=asdict(self.cost),
            notes={str(i): list(told) for i, told in self.notes.items()},
        )  # fmt: skip

    def __repr__(self) -> str:
        span = f"t={float(self.t[0]):.6g}..{float(self.t[-1]):.6g}, {len(self.t)} instants"
        failed = f", {len(self.errors)} failed" if self.errors else ""
        left = len(self) - int(self.finished.sum()) - len(self.errors)
        failed += f", {left} not run: stopped by hand" if self.interrupted else ""
        what = f"{len(self)} motions{failed}, {span}, outputs=({', '.join(self.outputs)})"
        return f"Ensemble({self.system.name!r}, {what})"

    def _repr_html_(self) -> str:
        """For notebooks: where outputs end, how well integrals are kept, what failed."""
        rows = [(name, _range_of(self[name][:, -1], "at the end from {} to {}"))
                for name in self.outputs]  # fmt: skip
        rows += [(f"drift of {k}", _range_of(x, "{} to {}")) for k, x in self.drift.items()]
        rows += [(f"motion {i} failed", str(error)) for i, error in self.errors.items()]
        rows += [(f"motion {i}", note) for i, notes in self.notes.items() for note in notes]
        return html_table(repr(self), [*rows[:FEW], ("cost", str(self.cost))])


def _range_of(values: np.ndarray, words: str) -> str:
    """The least and the greatest of the values that are there."""
    numbers = np.asarray(values, dtype=float)
    there = numbers[np.isfinite(numbers)]
    if not len(there):
        return ""
    return words.format(f"{float(there.min()):.6g}", f"{float(there.max()):.6g}")


@accepts(
    outputs=SEVERAL,
    parameters=VALUES,
    inputs=VALUES,
    method=TEXT,
    tol=TOLERANCE,
    jobs=COUNT,
    progress=CALLABLE,
    strict=FLAG,
)
def ensemble(
    system: System | VoronecEquations,
    starts: Mapping[Any, Any] | Sequence[Values] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    times: Any = None,
    outputs: Sequence[Any] = (),
    scene: Any = None,
    method: str = "auto",
    tol: float = 1e-13,
    jobs: int = 1,
    progress: Callable[[float], Any] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    strict: bool = True,
) -> Ensemble:
    """The motions of one system from many starts, or with many values of its parameters.

    starts
        arrays of initial values by name or symbol, all of one length (a single number stands for
        all), or a sequence of such mappings, one for each motion.  What a start does not give
        comes from the scene, if one is named, else it is zero.
    parameters
        values by name or symbol; an array gives each motion its own.
    times, outputs, scene, tol
        as for ``integrate``.  The smallest model of the system that holds the outputs, whatever the
        start, is what is integrated.
    method
        ``heyoka`` carries several motions at once in the lanes of one batch integrator, compiled
        once; ``numba``, ``c`` and ``scipy`` (DOP853) run them one by one; ``auto`` takes heyoka
        where it installs, else numba or c where scipy would take longer than to compile.
    jobs
        processes that share the motions, where these are enough work; the numbers are those of
        one.  A script calls it under ``if __name__ == "__main__":`` then, since the processes
        read it.
    progress
        is called with the finished fraction.
    inputs
        values of the system's inputs, as for ``integrate``; with a table or a function of Python's
        the motions are integrated one by one.
    strict
        whether the first error is raised where every start is wrong; else all are in ``errors``.

    Motions that start at poles of coordinates, or pass near one or near a singular split of the
    velocities, and those that might reach the cut of an angle in a Lagrangian, are integrated again
    alone, as by ``integrate``.
    A start or a parameter from which no motion goes, and a motion that breaks down, loses a proved
    integral or does not obey the equations, is noted in ``errors``, and the others go on.
    Ctrl-C ends the run and keeps the motions that are done; none is while it is being set up.
    """
    began, tol = perf_counter(), max(tol, EXACT)  # many motions go in doubles
    declared = system.system if isinstance(system, VoronecEquations) else require_system(system)
    chosen_scene = scene_of(declared, scene, starts is None, "starts")
    single, columns = spread_starts(starts, parameters or {})
    grid = grid_of(declared, chosen_scene, times)
    begin, end = float(grid[0]), float(grid[-1])
    driven = drive(system, inputs, chosen_scene).over(begin, end)
    equations, columns = driven.equations, {**columns, **driven.parameters(begin, end)}
    namespace = Namespace.of(equations, driven.meaning)
    keys, actual = outputs_of(chosen_scene, outputs), equations.system
    wanted = dict(quantity(namespace, k) for k in keys or (*actual.coordinates, *actual.velocities))
    try:
        motions = many(equations, chosen_scene, single, columns, wanted, begin)
        alone = LoneMotions(motions, single, chosen_scene, method, tol, frozenset(motions.wrong))
        if driven.changing is not None:
            given = {**getattr(chosen_scene, "inputs", {}), **(inputs or {})}
            alone = replace(alone, declared=driven.original, inputs=given)
        every = alone.cause
        carrier, reason = _carrier(alone, tuple(wanted), keys, grid)
        filled = _ResultRows.empty(motions, tuple(wanted), grid)
    except KeyboardInterrupt:
        return _empty_ensemble(
            actual, tuple(wanted), grid, len(single), tol, perf_counter() - began
        )
    ready = perf_counter()
    team = filled.team(carrier, jobs)
    try:
        interrupted = not every and _run(filled, carrier, team, progress)
        interrupted = (
            filled.leave(motions.wrong)
            if interrupted
            else filled.go_on_alone(alone, team, bool(every), progress)
        )
    finally:
        team.end()
    if strict and not (motions.sound or filled.alone or interrupted):
        raise motions.wrong[0]
    costs = [cost for _, cost in sorted(filled.alone.items())]
    steps = filled.steps + sum(each.steps for each in costs)
    none_else = costs and (every or not motions.sound)
    cost = Cost(
        method=costs[0].method if none_else else carrier.method, reason=reason,
        tolerance=carrier.finest, setup=ready - began,
        run=perf_counter() - ready, steps=steps, evaluations=steps,
        switches=sum(each.switches for each in costs), formulation=motions.ground.formulation,
    )  # fmt: skip
    return filled.ensemble(cost, interrupted, driven)


def _carrier(
    alone: LoneMotions, outputs: tuple[str, ...], keys: Sequence[Any], grid: np.ndarray
) -> tuple[Carrier, str]:
    """What carries the motions, and why."""
    motions, method, tol = alone.motions, alone.method, alone.tol
    lanes, used = None, "scipy"
    if alone.cause:
        require_method(method)
        reason = f"{alone.cause}, so one by one"
    elif not motions.sound:
        reason = "each start alone"
    else:
        lanes, used, reason = choose_lanes(
            method, motions.program, tol, *motions.moving_lanes, grid
        )
    first = motions.one(next(iter(motions.sound), 0))
    lone = replace(alone, motions=first, starts=Starts.of(()), unplaced=frozenset())
    return Carrier(first, lone, grid, outputs, keys, tol, lanes, used), reason


def _empty_ensemble(
    system: System, outputs: tuple[str, ...], grid: np.ndarray, count: int, tol: float, spent: float
) -> Ensemble:
    """What there is when the set-up is stopped by hand."""
    cost = Cost("none", "stopped by hand while it was set up", tol, spent, 0.0, 0, 0)
    series = {name: np.full((count, len(grid)), np.nan) for name in outputs}
    finished = np.zeros(count, dtype=bool)
    for array in (grid, finished, *series.values()):
        array.flags.writeable = False
    return Ensemble(
        system, grid, outputs, MappingProxyType(series), {}, finished, {}, {}, "", cost, True
    )


@dataclass(eq=False)
class _ResultRows:
    """What is filled in as blocks and single motions are done."""

    motions: Many
    grid: np.ndarray
    series: dict[str, np.ndarray]
    drift: dict[str, np.ndarray]
    finished: np.ndarray
    errors: dict[int, VoronecError] = field(default_factory=dict)
    steps: int = 0
    collapsed: list[int] = field(default_factory=list)
    alone: dict[int, Cost] = field(default_factory=dict)
    notes: dict[int, tuple[str, ...]] = field(default_factory=dict)
    halt: Event = field(default_factory=Event)

    @classmethod
    def empty(cls, motions: Many, outputs: tuple[str, ...], grid: np.ndarray) -> _ResultRows:
        count = len(motions)
        return cls(
            motions=motions,
            grid=grid,
            series={name: np.full((count, len(grid)), np.nan) for name in outputs},
            drift={name: np.full(count, np.nan) for name in motions.ground.integrals},
            finished=np.zeros(count, dtype=bool),
            errors=dict(motions.wrong),
        )

    def team(self, carrier: Carrier, jobs: int) -> Team:
        """This process and others that carry motions as it does."""

        def here(task: MotionBlock | LoneStart) -> Any:
            if isinstance(task, MotionBlock):  # those that are carried by others are in few blocks
                return carrier.carry(task, self.halt.is_set)
            return carrier(task)

        return Team(jobs, carrier, here)

    def put(self, block: MotionBlock, found: CarriedBlock) -> int:
        """What came of the first motions of a block; how many they are."""
        self.steps += found.steps
        done = len(next(iter(found.series.values()), ()))
        where = block.numbers[:done]
        for arrays, parts in ((self.series, found.series), (self.drift, found.drift)):
            for name, part in parts.items():
                arrays[name][where] = part
        self.finished[where] = True
        for i, error in found.errors.items():
            self.finished[where[i]] = False
            self.errors[int(where[i])] = self.motions.error(
                where[i], str(error), "end the run before that", error.time, error.state
            )
        self.notes.update((int(where[i]), told) for i, told in found.notes.items())
        self.collapsed.extend(where[found.alone].tolist())
        return done

    def go_on_alone(
        self, alone: LoneMotions, team: Team, every: bool,
        progress: Callable[[float], Any] | None,
    ) -> bool:  # fmt: skip
        """Motions that went wrong, did not start, or came near a place where the equations are
        singular, once more, each alone: ``integrate`` goes on in other charts, or in all
        velocities; where no lanes carry them, ``every`` one.

        Whether it was stopped by hand.
        """
        motions = self.motions
        which = range(len(motions)) if every else sorted({*self.errors, *self.collapsed})
        left = dict.fromkeys(
            i for i in which
            if i not in self.errors or i in motions.wrong or motions.may_go_on
        )  # fmt: skip
        tasks = map(alone.start, [*left])
        try:
            for start, run in team.results(tasks, LONE * len(left) < WORTH):
                i = start.number
                if isinstance(run, VoronecError):
                    if every and not isinstance(run, IntegrationError) and i not in motions.wrong:
                        raise run  # what is asked for makes no sense, whatever the start
                    self.fails(i, run)
                else:
                    self.replaces(i, run)
                    if run.interrupted:
                        return self.leave(left)
                del left[i]
                if every and progress is not None:
                    progress(1 - len(left) / len(which))
        except KeyboardInterrupt:
            return self.leave(left)
        return False

    def leave(self, which: Iterable[int]) -> bool:
        """Stopped by hand: starts that were to go alone, and did not, have done nothing wrong."""
        for i in which:
            if i in self.motions.wrong:
                self.errors.pop(i, None)
        return True

    def fails(self, i: int, error: VoronecError) -> None:
        """A motion that fails alone too: its first error stays, if it had one."""
        if i in self.errors:
            return
        run = getattr(error, "trajectory", None)
        if run is not None and len(run) <= len(self.grid):
            self.fill(i, run)
        time = getattr(error, "time", None)
        late = np.abs(self.grid - self.grid[0]) > abs(float(time or self.grid[0]) - self.grid[0])
        for array in self.series.values():
            array[i, late] = np.nan
        self.errors[i] = error
        self.finished[i] = False

    def fill(self, i: int, run: Trajectory) -> None:
        """The rows of a motion, as far as it came."""
        for name, array in self.series.items():
            array[i, : len(run)] = run[name]

    def replaces(self, i: int, run: Trajectory) -> None:
        """The motion of a start, integrated alone."""
        if len(run) != len(self.grid):
            return
        self.fill(i, run)
        for name in self.drift.keys() & run.drift.keys():
            self.drift[name][i] = run.drift[name]
        self.alone[i] = run.cost
        if run.notes:
            self.notes[i] = run.notes
        self.finished[i] = True
        self.errors.pop(i, None)

    def ensemble(self, cost: Cost, interrupted: bool, driven: Drive) -> Ensemble:
        names = {*driven.original.parameter_names}
        for array in (self.grid, self.finished, *self.series.values()):
            array.flags.writeable = False
        return Ensemble(
            system=driven.original,
            t=self.grid,
            outputs=tuple(self.series),
            series=MappingProxyType(self.series),
            parameters=MappingProxyType(
                {name: x for name, x in self.motions.parameters.items() if name in names}
            ),
            finished=self.finished,
            errors=MappingProxyType(dict(sorted(self.errors.items()))),
            drift=MappingProxyType(self.drift),
            formulation=self.motions.ground.formulation,
            cost=cost,
            interrupted=interrupted,
            notes=MappingProxyType(self.notes),
        )


def _run(filled: _ResultRows, carrier: Carrier, team: Team, progress: Any) -> bool:
    """All motions, block by block; whether it was stopped by hand."""
    motions, done = filled.motions, 0
    try:
        sound = np.array(motions.sound, dtype=int)
        alone = motions.near_divisors[sound]
        filled.collapsed.extend(sound[alone].tolist())
        sound = sound[~alone]
        if carrier.lanes:  # those that go side by side wait for the slowest
            sound = sound[np.argsort(motions.paces[sound], kind="stable")]
        # the steps of the first ones, when they are known, tell how many are done soon
        first, size = carrier.first, carrier.first
        for part in (sound[:first], sound[first:]):
            if done:
                size = _block_size(filled, carrier, len(sound))
            each = range(0, len(part), size)
            blocks = (MotionBlock.of(motions, part[i : i + size]) for i in each)
            work = len(part) * filled.steps / first * _step_cost(carrier)
            for block, carried in team.results(blocks, work < WORTH):
                done += filled.put(block, carried)
                if progress is not None:
                    progress(done / len(sound))
    except KeyboardInterrupt:
        filled.halt.set()
        return True
    return False


def _step_cost(carrier: Carrier) -> float:
    """About how many microseconds a step of a motion takes."""
    lanes = carrier.lanes
    cost = step_cost(carrier.method, carrier.motions.program, carrier.finest)
    return cost if lanes is None else cost / lanes.integrator.batch.batch_size


def _block_size(filled: _ResultRows, carrier: Carrier, count: int) -> int:
    """How many go together after the first ones."""
    first, lanes = carrier.first, carrier.lanes
    if lanes is None:
        return first
    numbers = len(filled.grid) * filled.motions.states.shape[1]
    each = max(1, filled.steps // first)
    size = min(lanes.most, STEPS // each, NUMBERS // numbers, count // REPORTS)
    return max(size // first, BATCHES) * first

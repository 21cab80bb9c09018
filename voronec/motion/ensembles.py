"""Ensembles: many starts, or many values of the parameters, of one system on one grid of times."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass, field, replace
from itertools import islice
from queue import SimpleQueue
from threading import Event
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np

from voronec.algebra.arguments import CALLABLE, COUNT, SEVERAL, TEXT, TOLERANCE, VALUES, accepts
from voronec.algebra.typeset import html_table
from voronec.declaration.system import System, require_system
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, IntegrationError, VoronecError
from voronec.motion.angle_cuts import CutWatch
from voronec.motion.batches import Lanes, StopRequest, along, choose_lanes, require_method
from voronec.motion.inputs import Drive, drive
from voronec.motion.methods import METHODS
from voronec.motion.motion_pool import Drifts, Many, many
from voronec.motion.one_by_one import LoneMotions, SwitchedMotions, along_one
from voronec.motion.request import (  # fmt: skip
    Namespace,
    Values,
    grid_of,
    held_name,
    outputs_of,
    quantity,
    scene_of,
    spread_starts,
)
from voronec.motion.state_probe import at_each, changes
from voronec.motion.steppers.samples import OwnedSamples, by_owner
from voronec.motion.steppers.scipy_stepper import FINEST
from voronec.motion.tolerances import EXACT
from voronec.motion.trajectory import Cost, Trajectory
from voronec.motion.verify import CheckOfMany

__all__ = ["Ensemble", "ensemble"]

FEW = 20
"""Rows of the table that a notebook shows."""
BATCHES, REPORTS = 8, 8
"""So many loads of the lanes at least go between two reports, and so many reports there are at
least where the motions suffice for both."""
STEPS, NUMBERS = 100_000, 2**22
"""So many steps, and numbers of states on the grid, go between two reports, unless that is less."""
TOGETHER = 64
"""So many motions of a compiled loop go between two reports: they are looked at together."""


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
    along each motion, (starts,), relative as in ``Trajectory``.  ``level`` names the variables
    of these equations, as in ``Model``.  ``interrupted`` says that the run was stopped by hand, and
    so does what is printed of it.
    """

    system: System
    t: np.ndarray
    outputs: tuple[str, ...]
    series: Mapping[str, np.ndarray]
    parameters: Mapping[str, np.ndarray]
    finished: np.ndarray
    errors: Mapping[int, VoronecError]
    drift: Mapping[str, np.ndarray]
    level: str
    cost: Cost
    interrupted: bool = False
    notes: Mapping[int, tuple[str, ...]] = field(default_factory=dict)

    def __getitem__(self, key: Any) -> np.ndarray:
        return self.series[held_name(key, self.series, "the ensemble holds")]

    def __len__(self) -> int:
        return len(self.finished)

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
        threads, each with an integrator of its own: heyoka's compiled code, and numpy's, run side
        by side on several cores; scipy gains nothing by them and takes one.
    progress
        is called with the finished fraction.
    inputs
        values of the system's inputs, as for ``integrate``; with a table or a function of Python's
        the motions are integrated one by one.

    Motions that start at poles of coordinates, or pass near one or near a singular split of the
    velocities, and those that might reach the cut of an angle in a Lagrangian, are integrated again
    alone, as by ``integrate``.
    A start or a parameter from which no motion goes, and a motion that breaks down, loses a proved
    integral or does not obey the equations, is noted in ``errors``, and the others go on; where
    every start is wrong, the first error is raised.
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
    keys, own = outputs_of(chosen_scene, outputs), equations.system
    wanted = dict(quantity(namespace, k) for k in keys or (*own.coordinates, *own.velocities))
    try:
        motions = many(equations, chosen_scene, single, columns, wanted, begin)
        switched, lanes, carrier, reason = _carriers(driven, motions, method, tol, grid)
        finest = tol if lanes else max(tol, FINEST)
        filled = _ResultRows.empty(motions, tuple(wanted), grid, switched, finest, carrier)
    except KeyboardInterrupt:
        return _empty_ensemble(own, tuple(wanted), grid, len(single), tol, perf_counter() - began)
    ready = perf_counter()
    alone = LoneMotions(motions, single, chosen_scene, method, tol, frozenset(motions.wrong))
    if driven.changing is not None:
        given = {**getattr(chosen_scene, "inputs", {}), **(inputs or {})}
        alone = replace(alone, declared=driven.original, inputs=given)
    interrupted = driven.changing is None and _run(filled, lanes, tol, jobs, progress)
    if CutWatch.of(namespace).cuts:
        filled.collapsed.extend(motions.sound)
    interrupted = (
        filled.leave(motions.wrong) if interrupted else filled.go_on_alone(alone, keys, progress)
    )
    if not (motions.sound or filled.alone or interrupted):
        raise motions.wrong[0]
    steps = filled.steps + sum(cost.steps for cost in filled.alone)
    none_else = filled.alone and (driven.changing or not motions.sound)
    used = filled.alone[0].method if none_else else carrier
    cost = Cost(
        method=used, reason=reason,
        tolerance=tol if lanes else max(tol, FINEST), setup=ready - began,
        run=perf_counter() - ready, steps=steps, evaluations=steps,
        switches=sum(cost.switches for cost in filled.alone), level=motions.ground.level,
    )  # fmt: skip
    return filled.ensemble(cost, interrupted, driven)


def _carriers(
    driven: Drive, motions: Many, method: str, tol: float, grid: np.ndarray
) -> tuple[SwitchedMotions | None, Lanes | None, str, str]:
    """What integrates the motions, the method where nothing does that is made already, and why."""
    if driven.changing is not None:
        require_method(method)
        return None, None, "scipy", "an input changes in time, so one by one"
    switched = SwitchedMotions.of(motions, method, tol, grid)
    if switched is not None:
        return switched, None, switched.method, switched.reason
    if not motions.sound:
        return None, None, "scipy", "each start alone"
    return None, *choose_lanes(method, motions.program, tol, *motions.moving_lanes, grid)


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
    """What the workers fill in; each writes the rows of its own starts alone."""

    motions: Many
    grid: np.ndarray
    series: dict[str, np.ndarray]
    drift: dict[str, np.ndarray]
    drifts: Drifts
    finished: np.ndarray
    check: CheckOfMany
    switched: SwitchedMotions | None = None
    single: str = "scipy"
    errors: dict[int, VoronecError] = field(default_factory=dict)
    steps: int = 0
    collapsed: list[int] = field(default_factory=list)
    alone: list[Cost] = field(default_factory=list)
    notes: dict[int, tuple[str, ...]] = field(default_factory=dict)

    @classmethod
    def empty(
        cls,
        motions: Many,
        outputs: tuple[str, ...],
        grid: np.ndarray,
        switched: SwitchedMotions | None,
        tol: float,
        single: str,
    ) -> _ResultRows:
        def nothing(*shape: int) -> np.ndarray:
            return np.full(shape, np.nan)

        count, integrals = len(motions), motions.ground.integrals
        return cls(
            motions=motions,
            grid=grid,
            series={name: nothing(count, len(grid)) for name in outputs},
            drift={name: nothing(count) for name in integrals},
            drifts=Drifts(motions, tol),
            finished=np.zeros(count, dtype=bool),
            switched=switched,
            single=single,
            check=CheckOfMany(
                motions.namespace.equations,
                motions.program,
                tol,
                {name: f"integral {name}" for name in integrals},
                frozenset() if switched is None else switched.jumps,
            ),
            errors=dict(motions.wrong),
        )

    def put(self, where: np.ndarray, rows: np.ndarray, failed: Mapping[int, VoronecError]) -> None:
        """States (m, k, n) of some starts; ``failed`` by position among these."""
        values = self.motions.values[where][:, None, :]
        values = np.broadcast_to(values, (*rows.shape[:2], values.shape[-1]))
        names = self.motions.program.names
        found = at_each(self.motions.extras, names, self.grid, rows, values)
        for name, array in self.series.items():
            array[where] = found[name]
        for name, array in self.drift.items():
            series = found[f"integral {name}"]
            # a motion that failed has numbers up to there, if any
            change = np.fmax.reduce(changes(series, series[:, :1]), axis=1)
            array[where] = self.drifts.relative(
                name, change, series[:, 0], self.grid, rows, self.motions.values[where]
            )
        self.errors.update({int(where[i]): error for i, error in failed.items()})
        self.finished[where] = True
        self.finished[where[[*failed]]] = False

    def go_on_alone(
        self, alone: LoneMotions, outputs: Sequence[Any], progress: Callable[[float], Any] | None
    ) -> bool:
        """Motions that went wrong, did not start, or came near a place where the equations are
        singular, once more, each alone: ``integrate`` goes on in other charts and splits.  Where
        inputs change in time, that is all of them.

        Whether it was stopped by hand.
        """
        motions, changing = self.motions, alone.declared is not None
        which = range(len(motions)) if changing else sorted({*self.errors, *self.collapsed})
        count = 0
        try:
            for count, i in enumerate(which):
                if i in self.errors and i not in motions.wrong and not motions.may_go_on:
                    continue
                try:
                    run = alone.motion(i, self.grid, outputs)
                except VoronecError as error:
                    if changing and isinstance(error, DefinitionError) and i not in motions.wrong:
                        raise  # what is asked for makes no sense, whatever the start
                    self.fails(i, error)
                else:
                    self.replaces(i, run)
                    if run.interrupted:
                        return self.leave(which[count:])
                if changing and progress is not None:
                    progress((count + 1) / len(which))
        except KeyboardInterrupt:
            return self.leave(which[count:])
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
        self.alone.append(run.cost)
        if run.notes:
            self.notes[i] = run.notes
        self.finished[i] = True
        self.errors.pop(i, None)

    def ensemble(self, cost: Cost, interrupted: bool, driven: Drive) -> Ensemble:
        own = {*driven.original.parameter_names}
        for array in (self.grid, self.finished, *self.series.values()):
            array.flags.writeable = False
        return Ensemble(
            system=driven.original,
            t=self.grid,
            outputs=tuple(self.series),
            series=MappingProxyType(self.series),
            parameters=MappingProxyType(
                {name: x for name, x in self.motions.parameters.items() if name in own}
            ),
            finished=self.finished,
            errors=MappingProxyType(dict(sorted(self.errors.items()))),
            drift=MappingProxyType(self.drift),
            level=self.motions.ground.level,
            cost=cost,
            interrupted=interrupted,
            notes=MappingProxyType(self.notes),
        )


def _run(filled: _ResultRows, lanes: Lanes | None, tol: float, jobs: int, progress: Any) -> bool:
    """All motions, block by block; whether it was stopped by hand."""
    workers: SimpleQueue[Lanes | None] = SimpleQueue()
    halt, done = Event(), 0

    def work(block: np.ndarray) -> tuple[int, int]:
        own = workers.get()
        try:
            return len(block), _block(filled, own, block, tol, halt)
        finally:
            workers.put(own)

    try:
        sound = np.array(filled.motions.sound, dtype=int)
        alone = filled.motions.near_divisors[sound]
        filled.collapsed.extend(sound[alone].tolist())
        sound = sound[~alone]
        if lanes:  # those that go side by side wait for the slowest
            sound = sound[np.argsort(filled.motions.paces[sound], kind="stable")]
        for k in range(jobs if lanes else 1):
            workers.put(lanes.again() if lanes and k else lanes)
        for count, steps in _do_work(work, _blocks(filled, lanes, sound), jobs if lanes else 1):
            done, filled.steps = done + count, filled.steps + steps
            if progress is not None:
                progress(done / len(sound))
    except KeyboardInterrupt:
        halt.set()
        return True
    return False


def _blocks(filled: _ResultRows, lanes: Lanes | None, sound: np.ndarray) -> Iterator[np.ndarray]:
    """The starts that go together: first one load of the lanes, whose steps, when they are known,
    tell how many are done soon."""
    if lanes is None:
        compiled = filled.switched is None and METHODS[filled.single].loop
        first = size = TOGETHER if compiled else 1
    else:
        first = lanes.width
    yield from [sound[:first]] if len(sound) else []
    if lanes is not None:
        numbers = len(filled.grid) * filled.motions.states.shape[1]
        each = max(1, filled.steps // first)
        size = min(lanes.most, STEPS // each, NUMBERS // numbers, len(sound) // REPORTS)
        size = max(size // first, BATCHES) * first
    for i in range(first, len(sound), size):
        yield sound[i : i + size]


def _do_work(
    work: Callable[[Any], tuple[int, int]], blocks: Iterator[Any], jobs: int
) -> Iterator[tuple[int, int]]:
    """Do the work, from the second block on in threads where there are several jobs."""
    yield from map(work, islice(blocks, None if jobs == 1 else 1))
    if jobs == 1:
        return
    with ThreadPoolExecutor(jobs) as pool:
        left = {pool.submit(work, block) for block in blocks}
        try:
            while left:
                over, left = wait(left, return_when=FIRST_COMPLETED)
                for one in over:
                    yield one.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _block(
    filled: _ResultRows, lanes: Lanes | None, block: np.ndarray, tol: float, halt: Event
) -> int:
    """Some starts, as many at a time as may be; how many steps they took."""
    motions, width = filled.motions, lanes.most if lanes else 1
    over: list[_Load] = []
    taken = 0
    try:
        for i in range(0, len(block), width):
            where = block[i : i + width]
            states, values = motions.states[where], motions.values[where]
            if filled.switched is not None:
                rows, error, run = filled.switched.along(int(where[0]), filled.grid)
                rows, failed = rows[None], {} if error is None else {0: error}
                steps, samples = (0, []) if run is None else (run.steps, by_owner(run.samples))
            elif lanes is None:
                rows, error, run, short = along_one(
                    filled.single, motions.program, states[0], values[0], filled.grid, tol,
                    motions.divisor_watch(values[0]),
                )  # fmt: skip
                filled.collapsed.extend(where[:short].tolist())
                rows, failed = rows[None], {} if error is None else {0: error}
                steps, samples = run.steps, by_owner(run.samples)
            else:
                rows, failed, steps, near, samples = along(
                    lanes, states, values, filled.grid, halt.is_set
                )
                filled.collapsed.extend(where[near].tolist())
            taken += steps
            over.append((where, rows, failed, samples))
    except StopRequest:
        pass
    finally:
        _fill_sound(filled, over, taken)
    return taken


_Load = tuple[np.ndarray, np.ndarray, dict[int, IntegrationError], list[OwnedSamples]]
"""Motions, their states along the grid, what failed, and samples of steps, by their place here."""


def _fill_sound(filled: _ResultRows, over: list[_Load], steps: int) -> None:
    """Fill in what is done of a block, after a look at whether it went well."""
    if not over:
        return
    where = np.concatenate([w for w, *_ in over])
    rows = np.concatenate([r for _, r, *_ in over])
    failed, samples = dict[int, IntegrationError](), list[OwnedSamples]()
    for at, (_, _, errors, parts) in zip(
        np.cumsum([0, *(len(w) for w, *_ in over)]), over, strict=False
    ):
        failed |= {int(at) + i: error for i, error in errors.items()}
        samples += [(int(at) + own, part) for own, part in parts]
    values, grid = filled.motions.values[where], filled.grid
    breaches, notes = filled.check.breaches(grid, rows, values, steps / len(where), samples)
    filled.notes.update((int(where[i]), told) for i, told in notes.items())
    for i, breach in breaches.items():
        time, state = breach.last or (float(grid[breach.row]), rows[i, breach.row].copy())
        failed[i] = IntegrationError(f"{breach.what} after t = {time:.12g}", time, state)
        rows[i, breach.row + 1 :] = np.nan
    told: dict[int, VoronecError] = {
        i: filled.motions.error(
            where[i], str(error), "end the run before that", error.time, error.state
        )
        for i, error in failed.items()
    }
    filled.put(where, rows, told)
    # followed once more by ``integrate``, which tells what a pole leaves open
    filled.collapsed.extend(where[filled.motions.across_poles(rows)].tolist())

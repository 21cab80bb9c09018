"""A sweep over many motions, computed chunk by chunk into a folder."""

from __future__ import annotations

import inspect
import os
import platform
from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import closing
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from voronec.algebra.arguments import (
    CALLABLE,
    COUNT,
    FLAG,
    OPTIONAL_COUNT,
    PATH,
    TEXT,
    TOLERANCE,
    VALUES,
    accepts,
)
from voronec.declaration.system import System, require_system
from voronec.declaration.worker_processes import stop_reimport
from voronec.errors import DefinitionError
from voronec.motion.batches import require_method
from voronec.motion.formulation import DYNAMIC_FIELDS, spell
from voronec.motion.inputs import drive
from voronec.motion.request import Namespace, grid_of, scene_of
from voronec.motion.sections import starts_alike
from voronec.motion.storage import (
    header_of,
    meanings_of,
    require_library,
    versions,
)
from voronec.motion.tolerances import EXACT
from voronec.sweeps.engines import (
    Portion,
    compute_here,
    own_processes,
    spread,
    submit_to,
)
from voronec.sweeps.folder import SweepFolder, require_room
from voronec.sweeps.kept_sweep import Sweep
from voronec.sweeps.plan import SweepPlan, make_plan
from voronec.sweeps.records import EXTREMES, ChunkResult, RecordColumn, Task, read_records

ROWS, LEAST, PARTS = 2**14, 64, 8
"""Motions of a chunk: as many as fill heyoka's lanes well; of a small sweep a part."""
NUMBERS = 2**23
"""So many numbers of outputs at all instants a chunk may hold while it is computed."""
INSTANTS = 101
"""Of a span whose times are not given, where largest and least values are asked for."""
WORTH = 10.0
"""Seconds of work that are worth starting processes."""


@accepts(
    grid=VALUES, out=PATH, seed=COUNT, jobs=OPTIONAL_COUNT, parameters=VALUES, initial=VALUES,
    inputs=VALUES, method=TEXT, tol=TOLERANCE, chunk=OPTIONAL_COUNT, resume=FLAG, progress=CALLABLE,
)  # fmt: skip
def sweep(
    system: System, grid: Mapping[Any, Any] | None = None, starts: Any = None,
    record: Any = ("final", "drift"), out: str | os.PathLike[str] = "sweep.zarr", seed: int = 1,
    executor: Executor | None = None, jobs: int | None = None, times: Any = None,
    scene: str | None = None, parameters: Mapping[Any, Any] | None = None,
    initial: Mapping[Any, Any] | None = None, inputs: Mapping[Any, Any] | None = None,
    method: str = "auto", tol: float = 1e-13, chunk: int | None = None, resume: bool = False,
    progress: Callable[[float], Any] | None = None,
) -> Sweep:  # fmt: skip
    """Many motions of one system, and what is recorded of each, in a folder.

    grid
        parameters and initial values, by name or symbol, with the values that each takes: every
        combination is a motion, and each name an axis of what is recorded.
    starts
        arrays by name or a list of mappings, as for ``ensemble``, or ``vo.Draws``: each start with
        each place of the grid, along the axis ``start``.  They may hold parameters, too.
    record
        texts and functions, or a mapping of names to them.  ``final`` is the state at the end,
        ``final(x)`` or just ``x`` one quantity there, ``max(x)`` and ``min(x)`` its extremes at the
        instants, ``drift`` or ``drift(energy)`` the largest relative change of integrals at these,
        ``time(x=1)`` when that first happens (nan where it does not), ``section(x=0)`` all passages
        upwards, at most 1000 a motion, ``class`` that of each trace.  A function takes the
        ``Trajectory`` and returns a number; others processes find it in its module.
    out
        the folder, a name in ``.zarr``.  It is the log, too: the same call goes on where an earlier
        one was stopped or killed, and what another sweep wrote is never touched.  ``resume`` says
        that it must be there already.
    times
        instants, as for ``integrate``; one number is the end.  Without a list of them the start and
        the end are looked at, and 101 instants where a record asks for what lies between.
    scene, parameters, initial, inputs, method, tol
        as for ``integrate``: what the grid and the starts leave open.
    executor, jobs
        by default the cores of the machine, each a process, where the work takes longer than to
        start them; ``jobs=1`` stays in this process.  Or any ``concurrent.futures.Executor``, such
        as ``client.get_executor()`` of a ``dask.distributed.Client``.
    seed
        of random draws.
    chunk
        how many motions are computed and kept together (at most 16384).
    progress
        is called with the share that is done.

    Equal sweeps write equal bytes on one kind of machine, whoever computes; processors of another
    kind may differ in the last digits.  A motion that fails is a row with its ``reason``.  Ctrl-C
    keeps the chunks that are finished.  ``DefinitionError`` for what the system does not have, for
    a folder of another sweep, and for more rows than the disk holds.
    """
    stop_reimport()
    require_library("zarr")
    declared, tol = require_system(system), max(tol, EXACT)
    target = Path(out)
    if target.suffix != ".zarr":
        raise DefinitionError(f"out = '{target}': the folder of a sweep must end in .zarr")
    is_there = os.path.exists(target)  # false, too, where nobody may look
    if resume and not is_there:
        raise DefinitionError(f"there is no sweep '{target}' to go on with")
    require_method(method)
    task = _task(declared, record, times, scene, parameters, initial, inputs, method, tol)
    plan = _plan(task, grid, starts, seed, chunk)
    digests = _digests(plan, task, seed)
    whole = sha256(repr(sorted(digests.items())).encode()).hexdigest()
    folder = SweepFolder(target, plan, task.records, whole)
    header = header_of(
        declared, "Sweep", digest=whole, digests=digests, seed=seed,
        record=[r.column for r in task.records], scene=task.scene, method=method, tolerance=tol,
        times=task.times.tolist(), parameters=str(task.parameters), initial=str(task.initial),
        machine=platform.machine(), lanes=_lanes(), chunk=list(plan.box),
    )  # fmt: skip
    if not is_there:
        require_room(target, plan, task.records)
    with folder.drafts(header, meanings_of(declared)) as drafts:
        work = _SweepWork(task, plan, folder.kept_chunks(), progress)
        try:
            with closing(_results(work, executor, jobs)) as results:
                for number, computed in results:
                    drafts.keep(number, computed)
                    work.tell(number)
        except KeyboardInterrupt:
            return Sweep(target, interrupted=True)
    return Sweep(target)


def _task(
    system: System, record: Any, times: Any, scene: Any, parameters: Any, initial: Any, inputs: Any,
    method: str, tol: float,
) -> Task:  # fmt: skip
    """What is computed of every motion."""
    scene = scene or system.first_scene
    known = scene_of(system, scene, False)
    driven = drive(system, inputs, known)
    records = read_records(Namespace.of(driven.equations, driven.meaning), record)
    ends = grid_of(system, known, times)
    if times is None or np.ndim(times) == 0:
        between = any(r.kind in ("function", *EXTREMES) for r in records)
        ends = np.linspace(ends[0], ends[-1], INSTANTS if between else 2)
    return Task(system, scene, _by_name(parameters), _by_name(initial), _by_name(inputs), ends,
                records, method, tol)  # fmt: skip


def _by_name(given: Mapping[Any, Any] | None) -> dict[str, Any]:
    return {str(k): x for k, x in (given or {}).items()}


def _plan(task: Task, grid: Any, starts: Any, seed: int, chunk: int | None) -> SweepPlan:
    system = task.system

    def alike(count: int) -> list[dict[str, float]]:
        equations = drive(system, task.inputs, scene_of(system, task.scene, False)).equations
        known = scene_of(system, task.scene, False)
        return starts_alike(equations, known, task.initial, task.parameters, count, seed)

    plan = make_plan(system, grid, starts, seed, 1, alike)
    held = sum(r.kind in ("final", *EXTREMES) for r in task.records) + len(system.integrals)
    most = max(1, NUMBERS // (len(task.times) * max(held, 1)))
    if chunk is None:
        chunk = min(ROWS, max(LEAST, -(-len(plan) // PARTS)))
    reserved = {"finished", "reason", "log", *plan.axes, *plan.starts}
    taken = reserved & {r.column for r in task.records}
    if taken or chunk < 1:
        what = f"'{min(taken)}' is taken" if taken else f"chunk = {chunk}"
        raise DefinitionError(f"{what}; give the record another name, or chunk a number from 1 on")
    return SweepPlan(plan.axes, plan.starts, min(chunk, most))


def _lanes() -> int:
    """How many motions go side by side in heyoka's lanes on this processor; 1 without it."""
    try:
        import heyoka
    except ImportError:
        return 1
    return int(heyoka.recommended_simd_size())


def _digests(plan: SweepPlan, task: Task, seed: int) -> dict[str, str]:
    """A digest of each thing that the numbers rest on, by name."""
    system = task.system
    scene = scene_of(system, task.scene, False)
    parts: dict[str, Any] = {
        "system": [system.name, spell([getattr(system, n) for n in DYNAMIC_FIELDS])],
        "scene": [task.scene, spell(scene)],
        "grid": [(n, sha256(x.tobytes()).digest()) for n, x in plan.axes.items()],
        "starts": [(n, sha256(x.tobytes()).digest()) for n, x in plan.starts.items()],
        "record": [(r.column, r.kind, r.value, _source(r)) for r in task.records],
        "times": task.times.tobytes(),
        "parameters": spell(task.parameters), "initial": spell(task.initial),
        "inputs": spell(task.inputs), "method": task.method, "tolerance": task.tol, "seed": seed,
        "chunk": plan.box, "versions": versions(), "machine": [platform.machine(), _lanes()],
    }  # fmt: skip
    return {name: sha256(repr(x).encode()).hexdigest()[:16] for name, x in parts.items()}


def _source(record: RecordColumn) -> str:
    """What a record is of, as text: of a function its source, where that is known."""
    if record.kind != "function":
        return str(record.of)
    try:
        return inspect.getsource(record.of)
    except (OSError, TypeError):
        return getattr(record.of, "__qualname__", type(record.of).__qualname__)


class _SweepWork:
    """What is left to do, and how much is done."""

    def __init__(self, task: Task, plan: SweepPlan, finished: set[int], progress: Any) -> None:
        self.task, self.plan, self._progress = task, plan, progress
        self.left = [n for n in range(plan.chunks) if n not in finished]
        self._done = sum(len(plan.rows(n)) for n in finished)
        self.tell()

    def portions(self) -> Iterator[Portion]:
        """The chunks that are left, one by one."""
        for n in self.left:
            yield Portion(n, self.plan.rows(n), self.plan.columns(n))

    def tell(self, chunk: int | None = None, share: float = 0.0) -> None:
        """Tell of a chunk that is kept, or of a share of motions beside those."""
        self._done += 0 if chunk is None else len(self.plan.rows(chunk))
        if self._progress is not None:
            self._progress(min(1.0, self._done / len(self.plan) + share))


def _results(
    work: _SweepWork, executor: Executor | None, jobs: int | None
) -> Generator[tuple[int, ChunkResult], None, None]:
    """The results of the chunks that are left, from whoever computes them."""
    portions = work.portions()
    if executor is not None:
        yield from spread(portions, submit_to(executor, work.task))
        return
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    workers = min(jobs or cores or 1, max(1, len(work.left) - 1))
    each = work.plan.size / len(work.plan)
    here = compute_here(work.task, portions, lambda share: work.tell(share=share * each))
    began = perf_counter()
    for done, computed in enumerate(here, start=1):
        yield computed
        spent = (perf_counter() - began) / done
        # those of this process are in no hurry to be followed by others that have to start
        if workers > 1 and (jobs or spent * (len(work.left) - done) > WORTH):
            break
    else:
        return
    team = own_processes(workers, work.task)
    try:
        yield from spread(portions, team.submit)
    finally:
        team.end()

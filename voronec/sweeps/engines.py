"""Who computes the chunks of a sweep: this process, its own processes, any executor, or Dask.

Whoever computes gets a task, packed once, and what the motions of a chunk start from, and gives
back their numbers; the process of the sweep alone writes.  A chunk whose worker dies is given to
another.
"""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import lru_cache, partial
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from voronec.declaration.worker_processes import GUARD, ProcessEnd, Team, pack
from voronec.errors import DefinitionError, EngineLimit, VoronecError, quote
from voronec.motion.storage import require_library
from voronec.sweeps.records import ChunkResult, Task

MEND = "record functions that a module defines, or use jobs=1"
WINDOW = 128
"""So many chunks at most are with an executor at a time: they and their results take memory."""
DEATHS = 5
"""So many times one after another workers may die before a sweep gives up."""
ANSWER = 10
"""Seconds within which a scheduler must answer."""


class Portion(NamedTuple):
    """A chunk by its number, the numbers of its motions, and what these start from."""

    chunk: int
    rows: np.ndarray
    columns: Mapping[str, np.ndarray]


def compute_here(
    task: Task, portions: Iterable[Portion], progress: Callable[[float], Any]
) -> Iterator[tuple[int, ChunkResult]]:
    """Chunks computed in this process; ``progress`` hears of the share of the one at hand."""
    for portion in portions:
        yield portion.chunk, task.compute(portion.columns, portion.rows, progress)


Submit = Callable[[Portion], Future[ChunkResult]]


def submit_to(executor: Executor, task: Task) -> Submit:
    """What gives chunks to an executor; ``DefinitionError`` where the task cannot go there."""
    packed = pack(task, MEND)
    return lambda portion: executor.submit(_work, packed, portion)


def own_processes(jobs: int, task: Task) -> Team:
    """So many processes of this machine; ``DefinitionError`` where the task cannot go there."""
    return Team(jobs, partial(_work, pack(task, MEND)))


def spread(portions: Iterable[Portion], submit: Submit) -> Iterator[tuple[int, ChunkResult]]:
    """Chunks computed by whoever they are given to, in the order in which they come back.

    An error of voronec's is raised, ``EngineLimit`` where workers die again and again.
    """
    left = iter(portions)
    waiting: dict[Future[ChunkResult], tuple[Portion, int]] = {}
    again: list[Portion] = []
    deaths = generation = 0
    fruitful = False
    try:
        while True:
            for portion in (*again, *islice(left, max(0, WINDOW - len(waiting) - len(again)))):
                waiting[submit(portion)] = portion, generation
            again.clear()
            if not waiting:
                return
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                portion, born = waiting.pop(future)
                try:
                    computed = future.result()
                except Exception as error:
                    if isinstance(error, VoronecError) and not isinstance(error, ProcessEnd):
                        raise
                    again.append(portion)
                    # a death may take several chunks with it, and is counted once
                    deaths += born == generation
                    generation += born == generation
                    if deaths > (DEATHS if fruitful else 1):
                        raise _loss(error, fruitful) from None
                    continue
                deaths, fruitful = 0, True
                yield portion.chunk, computed
    except (BrokenProcessPool, RuntimeError, OSError) as error:  # it takes no more work
        raise _loss(error, fruitful) from None
    finally:
        for future in waiting:
            future.cancel()


def _loss(error: Exception, fruitful: bool) -> VoronecError:
    if isinstance(error, ProcessEnd | BrokenProcessPool) and not fruitful:
        return DefinitionError(f"the processes end before they have done anything; {GUARD}")
    return EngineLimit(
        f"the executor computes no more: {quote(f'{type(error).__name__}: {error}')}; what is "
        "finished is kept, and the same call goes on"
    )


@lru_cache(maxsize=2)
def _unpack(packed: bytes) -> Task:
    """A task, once a process: what is derived and compiled stays with its system."""
    task: Task = pickle.loads(packed)
    return task


_ONE_AT_A_TIME = threading.Lock()
"""Integrators are not shared: threads of one worker take turns."""


def _work(packed: bytes, portion: Portion) -> ChunkResult:
    with _ONE_AT_A_TIME:
        return _unpack(packed).compute(portion.columns, portion.rows)


@contextmanager
def dask_executor(where: str) -> Iterator[Executor]:
    """The executor of a Dask scheduler, named by its address or by a file that holds it.

    ``DefinitionError`` where it does not answer.
    """
    distributed = require_library("distributed")
    told = {"scheduler_file": where} if Path(where).is_file() else {"address": where}
    try:
        client = distributed.Client(**told, timeout=ANSWER, set_as_default=False)
    except (OSError, ValueError, TypeError, TimeoutError) as error:
        raise DefinitionError(
            f"the scheduler '{quote(where)}' does not answer: {quote(error)}; start it by 'dask "
            "scheduler', or name another"
        ) from None
    with client:
        yield client.get_executor()

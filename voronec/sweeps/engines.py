"""Who computes the chunks of a sweep: this process, its own processes, any executor, or Dask.

Whoever computes gets a task, packed once, and what the motions of a chunk start from, and gives
back their numbers; the process of the sweep alone writes.  A chunk whose worker dies is given to
another.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from voronec.errors import DefinitionError, EngineLimit, VoronecError, quote
from voronec.motion.storage import require_library
from voronec.sweeps.records import ChunkResult, Task

GUARD = "call vo.sweep under if __name__ == '__main__':, since its processes read the script"
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


def spread(
    task: Task, portions: Iterable[Portion], executor: Executor | OwnProcesses
) -> Iterator[tuple[int, ChunkResult]]:
    """Chunks computed by an executor, in the order in which they come back.

    An error of voronec's is raised; ``DefinitionError`` where the task cannot go to other
    processes, ``EngineLimit`` where workers die again and again.
    """
    packed, left = _pack(task), iter(portions)
    waiting: dict[Future[ChunkResult], tuple[Portion, int]] = {}
    again: list[Portion] = []
    deaths = generation = 0
    fruitful = False
    try:
        while True:
            for portion in (*again, *islice(left, max(0, WINDOW - len(waiting) - len(again)))):
                waiting[executor.submit(_work, packed, portion)] = portion, generation
            again.clear()
            if not waiting:
                return
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                portion, born = waiting.pop(future)
                try:
                    found = future.result()
                except VoronecError:
                    raise
                except Exception as error:
                    again.append(portion)
                    # a death takes all chunks of a pool with it, and is counted once
                    deaths += born == generation
                    generation += born == generation
                    if deaths > (DEATHS if fruitful else 1):
                        raise _loss(error, fruitful) from None
                    continue
                deaths, fruitful = 0, True
                yield portion.chunk, found
    except (BrokenProcessPool, RuntimeError, OSError) as error:  # it takes no more work
        raise _loss(error, fruitful) from None
    finally:
        for future in waiting:
            future.cancel()


def _loss(error: Exception, fruitful: bool) -> VoronecError:
    if isinstance(error, BrokenProcessPool) and not fruitful:
        return DefinitionError(f"the processes end before they have done anything; {GUARD}")
    return EngineLimit(
        f"the executor computes no more: {quote(f'{type(error).__name__}: {error}')}; what is "
        "finished is kept, and the same call goes on"
    )


def _pack(task: Task) -> bytes:
    try:
        return pickle.dumps(task)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise DefinitionError(
            f"this cannot go to other processes: {error}; record functions that a module defines, "
            "or use jobs=1"
        ) from None


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


class OwnProcesses:
    """An executor of so many processes, each set up once; where one dies, all are started anew.

    They end with this process, however that ends, and with ``end`` at once: each listens to a pipe.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._pool: ProcessPoolExecutor | None = None
        self._listening, self._held = multiprocessing.Pipe(duplex=False)

    def submit(self, work: Callable[..., Any], *given: Any) -> Future[Any]:
        """As ``Executor.submit``."""
        with suppress(BrokenProcessPool):
            return self._executor().submit(work, *given)
        self._pool = None
        return self._executor().submit(work, *given)

    def _executor(self) -> ProcessPoolExecutor:
        if self._pool is None:
            # spawned, not forked: the same on every platform, and no thread of a library is lost
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self.jobs, context, _listen, (self._listening,))
        return self._pool

    def end(self) -> None:
        """End the processes, whatever they are at."""
        self._held.close()
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)


def _listen(pipe: Any) -> None:
    """In a new process: end when the pipe does; Ctrl-C is for the process of the sweep."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def last() -> None:
        with suppress(EOFError, OSError):
            pipe.recv()
        os._exit(1)

    threading.Thread(target=last, daemon=True).start()


def stop_reimport() -> None:
    """End a process that reads the script which started it, and came to its sweep: the sweep itself
    tells why."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        sys.exit(1)


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

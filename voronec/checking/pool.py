"""Units over processes: one that dies takes only its own unit with it."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import connection, get_context, resource_tracker
from typing import Any

from voronec.checking.record import Finding, Result
from voronec.checking.unit import Unit
from voronec.checking.work import Bench, examine

__all__ = ["results_of"]

Progress = Callable[[str], None]


def results_of(
    units: Sequence[Unit], jobs: int, started: Progress
) -> Generator[Result, None, None]:
    """The results of all units, as they come; ``started`` hears what is being worked on.

    With one unit or one job everything stays in this process.  When the iterator is closed, the
    other processes are ended.
    """
    jobs = min(jobs, len(units))
    if jobs <= 1:
        bench = Bench()
        for unit in units:
            started(unit.name)
            yield examine(unit, bench)
        return
    waiting = list(reversed(units))
    workers = [_Worker.start() for _ in range(jobs)]
    try:
        while waiting or any(w.unit for w in workers):
            for worker in workers:
                if worker.unit is None and waiting:
                    worker.give(waiting.pop())
            started(", ".join(w.unit.name for w in workers if w.unit))
            for ready in connection.wait([w.pipe for w in workers if w.unit]):
                position = next(i for i, w in enumerate(workers) if w.pipe is ready)
                result = workers[position].take()
                if not workers[position].process.is_alive() and waiting:
                    workers[position] = _Worker.start()
                yield result
    finally:
        for worker in workers:
            worker.end()


@dataclass
class _Worker:
    """A process, the pipe to it, and the unit that it is at."""

    process: Any
    pipe: Any
    unit: Unit | None = None

    @classmethod
    def start(cls) -> _Worker:
        # Spawned, not forked: the same on every platform, and no thread of a library is lost.
        context = get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with _interrupt_blocked():
            process.start()
        theirs.close()
        return cls(process, ours)

    def give(self, unit: Unit) -> None:
        self.unit = unit
        self.pipe.send(unit)

    def take(self) -> Result:
        """The result of the unit at hand; that the process died is one."""
        unit, self.unit = self.unit, None
        assert unit is not None
        try:
            result: Result = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            how = f"the process that checked it ended with status {self.process.exitcode}"
            return Result(
                unit.kind, unit.name, unit.entry.place,
                (Finding(unit.kind, unit.name, "broken", how),),
            )  # fmt: skip
        return result

    def end(self) -> None:
        self.process.terminate()
        self.process.join()
        self.pipe.close()


@contextmanager
def _interrupt_blocked() -> Iterator[None]:
    """Ctrl-C waits; a process that starts inside never hears of it, not even while it imports."""
    if sys.platform == "win32":
        yield
        return
    resource_tracker.ensure_running()  # else the first start would start it, and unblock
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Any) -> None:
    """Examine the units that come through the pipe until it is closed."""
    # Ctrl-C goes to every process of the terminal; the first one decides what happens.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    bench = Bench()
    while True:
        try:
            unit = pipe.recv()
        except EOFError:
            return
        pipe.send(examine(unit, bench))

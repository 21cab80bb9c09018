"""Processes that share work: each is set up once, and does one task after another."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import current_process, get_context, resource_tracker
from queue import SimpleQueue
from threading import Thread
from typing import Any

from voronec.errors import DefinitionError, EngineLimit

GUARD = (
    "several jobs are processes, which read the script that starts them: call what takes jobs "
    "under if __name__ == '__main__':"
)
REIMPORT = 64
"""The status of a process that ends since it came to where the script starts processes."""


class ProcessEnd(EngineLimit):
    """A process ended in the middle of its work, with a ``status``."""

    def __init__(self, status: int | None) -> None:
        super().__init__(f"a process that shared the work ended with status {status}")
        self.status = status


def pack(thing: Any, mend: str = "use jobs=1") -> bytes:
    """A thing as it goes to other processes; where it cannot, ``DefinitionError`` with a
    ``mend``."""
    try:
        return pickle.dumps(thing)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise DefinitionError(f"this cannot go to other processes: {error}; {mend}") from None


def stop_reimport() -> None:
    """End a process that reads the script which started it, and came to where that starts
    processes: the one that started it tells why."""
    if getattr(current_process(), "_inheriting", False):
        sys.exit(REIMPORT)


@dataclass
class Worker:
    """A process, the pipe to it, and the function that does its ``work``, pickled until it is
    sent."""

    process: Any
    pipe: Any
    work: bytes

    @classmethod
    def start(cls, work: Callable[[Any], Any]) -> Worker:
        """A process without a task, which no interruption of its start ends.

        Raises ``DefinitionError`` where the work cannot go to another process.
        """
        stop_reimport()
        packed = pack(work)
        # Spawned, not forked: the same on every platform, and no thread of a library is lost.
        context = get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with _block_interrupt():
            process.start()
        theirs.close()
        return cls(process, ours, packed)

    def ask(self, task: Any) -> Any:
        """What comes of a task; an error is raised as it was, ``ProcessEnd`` where the process is
        no more, ``DefinitionError`` where it read a script that starts processes again."""
        with suppress(OSError):  # told by what is received
            if self.work:
                self.pipe.send_bytes(self.work)
                self.work = b""
            self.pipe.send(task)
        try:
            well, result = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            if self.process.exitcode == REIMPORT:
                raise DefinitionError(GUARD) from None
            raise ProcessEnd(self.process.exitcode) from None
        if not well:
            raise result
        return result

    def end(self) -> None:
        """End the process, whatever it is at."""
        self.process.terminate()
        self.process.join()
        self.pipe.close()


@contextmanager
def _block_interrupt() -> Iterator[None]:
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
    """Do the tasks that come through the pipe, until it is closed: whoever holds its other end is
    no more then, and whatever is at hand is for nobody."""
    # Ctrl-C goes to every process of the terminal; the first one decides what happens.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    given = SimpleQueue[bytes]()

    def listen() -> None:
        with suppress(EOFError, OSError):
            while True:
                given.put(pipe.recv_bytes())
        os._exit(1)

    Thread(target=listen, daemon=True).start()
    work = None
    while True:
        sent = given.get()
        try:
            task = pickle.loads(sent)
            if work is None:
                work = task
                continue
            answer = True, work(task)
        except Exception as error:
            answer = False, error
        pipe.send(answer)


@dataclass
class Team:
    """``jobs`` that share tasks: processes, to each of which the function ``there`` goes once, and
    this process for one of them where it has a function ``here``."""

    jobs: int
    there: Callable[[Any], Any]
    here: Callable[[Any], Any] | None = None
    _free: SimpleQueue[Any] = field(default_factory=SimpleQueue)
    _workers: list[Worker] = field(default_factory=list)
    _threads: ThreadPoolExecutor | None = None

    def submit(self, task: Any) -> Future[Any]:
        """What will come of a task; ``ProcessEnd`` where its process is no more, in whose place
        another starts."""
        if self._threads is None:
            if self.here is not None:
                self._free.put(self.here)
            for _ in range(self.jobs - self._free.qsize()):
                self._free.put(self._start().ask)
            self._threads = ThreadPoolExecutor(self.jobs)
        return self._threads.submit(self._one, task)

    def _start(self) -> Worker:
        self._workers.append(worker := Worker.start(self.there))
        return worker

    def _one(self, task: Any) -> Any:
        function = self._free.get() or self._start().ask
        try:
            return function(task)
        except ProcessEnd:
            function = None
            raise
        finally:
            self._free.put(function)

    def results(self, tasks: Iterable[Any], alone: bool) -> Generator[tuple[Any, Any], None, None]:
        """Tasks and what came of them, as it comes, from all, or of this process ``alone``, where
        it has a function."""
        if self.here is not None and (self.jobs == 1 or alone):
            yield from ((task, self.here(task)) for task in tasks)
            return
        left = {self.submit(task): task for task in tasks}
        while left:
            for future in wait(left, return_when=FIRST_COMPLETED).done:
                try:
                    yield left.pop(future), future.result()
                except ProcessEnd as ended:
                    raise DefinitionError(GUARD) if ended.status == 1 else ended from None

    def end(self) -> None:
        """End the processes, whatever they are at."""
        if self._threads is not None:
            self._threads.shutdown(wait=False, cancel_futures=True)
        while self._workers:
            self._workers.pop().end()

"""Processes that share work: each is set up once, and does one task after another."""

from __future__ import annotations

import pickle
import signal
import sys
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import get_context, resource_tracker
from queue import SimpleQueue
from typing import Any

from voronec.errors import DefinitionError, EngineLimit

GUARD = (
    "several jobs are processes, which read the script that starts them: call what takes jobs "
    "under if __name__ == '__main__':"
)


class ProcessEnd(EngineLimit):
    """A process ended in the middle of its work, with a ``status``."""

    def __init__(self, status: int | None) -> None:
        super().__init__(f"a process that shared the work ended with status {status}")
        self.status = status


@dataclass
class Worker:
    """A process, the pipe to it, the function that does its ``work``, pickled until it is sent,
    and the task that it is at."""

    process: Any
    pipe: Any
    work: bytes
    task: Any = None

    @classmethod
    def start(cls, work: Callable[[Any], Any]) -> Worker:
        """A process without a task, which no interruption of its start ends.

        Raises ``DefinitionError`` where the work cannot go to another process.
        """
        try:
            packed = pickle.dumps(work)
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            refusal = f"this cannot go to another process: {error}; use jobs=1"
            raise DefinitionError(refusal) from None
        # Spawned, not forked: the same on every platform, and no thread of a library is lost.
        context = get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with _block_interrupt():
            try:
                process.start()
            except RuntimeError:
                if "__mp_main__" not in sys.modules:
                    raise
                sys.exit(GUARD)  # a process reads the script that started it
        theirs.close()
        return cls(process, ours, packed)

    def give(self, task: Any) -> None:
        """Let it work on a task."""
        self.task = task
        if self.work:
            self.pipe.send_bytes(self.work)
            self.work = b""
        self.pipe.send(task)

    def take(self) -> Any:
        """What came of the task at hand; an error is raised as it was, ``ProcessEnd`` where the
        process is no more."""
        self.task = None
        try:
            well, result = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            raise ProcessEnd(self.process.exitcode) from None
        if not well:
            raise result
        return result

    def ask(self, task: Any) -> Any:
        """What comes of a task."""
        with suppress(OSError):  # told by what is taken
            self.give(task)
        return self.take()

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
    """Do the tasks that come through the pipe until it is closed."""
    # Ctrl-C goes to every process of the terminal; the first one decides what happens.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    work = None
    while True:
        try:
            sent = pipe.recv_bytes()
        except EOFError:
            return
        try:
            given = pickle.loads(sent)
            if work is None:
                work = given
                continue
            answer = True, work(given)
        except Exception as error:
            answer = False, error
        pipe.send(answer)


@dataclass
class Team:
    """``jobs`` that share tasks: one of this process, done by a function ``here``, the others by
    one that goes to them."""

    jobs: int
    here: Callable[[Any], Any]
    there: Callable[[Any], Any]
    workers: list[Worker] = field(default_factory=list)

    def results(self, tasks: Iterable[Any], alone: bool) -> Generator[tuple[Any, Any], None, None]:
        """Tasks and what came of them, as it comes, from all, or of this process ``alone``."""
        if self.jobs == 1 or alone:
            yield from ((task, self.here(task)) for task in tasks)
            return
        while len(self.workers) < self.jobs - 1:
            self.workers.append(Worker.start(self.there))
        free: SimpleQueue[Callable[[Any], Any]] = SimpleQueue()
        for function in (self.here, *(worker.ask for worker in self.workers)):
            free.put(function)

        def one(task: Any) -> tuple[Any, Any]:
            function = free.get()
            try:
                return task, function(task)
            except ProcessEnd as ended:
                raise DefinitionError(GUARD) if ended.status == 1 else ended from None
            finally:
                free.put(function)

        with ThreadPoolExecutor(self.jobs) as pool:
            left = {pool.submit(one, task) for task in tasks}
            try:
                while left:
                    over, left = wait(left, return_when=FIRST_COMPLETED)
                    for each in over:
                        yield each.result()
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                self.end()
                raise

    def end(self) -> None:
        """End the other processes, whatever they are at."""
        while self.workers:
            self.workers.pop().end()

"""Odd input at every door: files, texts, command lines, the Python names, the environment.

    python tools/fuzz.py doors [--seed N] [--count N] [--seconds S] [--jobs N] [--kind K] [--only I]

A door is made from the seed and its number alone, so ``--seed N --only I`` opens one again.  Doors
are opened in child processes; a failure is a traceback, an error that is not one of the package's
own or has several lines, a signal, a hang over 20 s, text of a user that was run, or a file that
was left half-written.  Exit status 1 where there is one.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import io
import multiprocessing as mp
import multiprocessing.connection
import os
import random
import resource
import shutil
import signal
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import sympy as sp
from shared.campaign import campaign_parser, read_campaign
from shared.child_time import ChildClock

import voronec as vo
from doors.commands import Wrong, command_door, environment_door, plugin_door
from doors.names import python_door
from doors.texts import text_door
from doors.values import CANARY
from voronec.errors import VoronecError

HANG = 20.0
"""Seconds of work after which a door hangs."""
WAIT = 200.0
"""Seconds after which it hangs though it does not work."""
MEMORY = 8 << 30
"""Bytes of address space of a child: what wants more ends with an error and not the machine."""
Door = tuple[str, Callable[[], Any]]
DOORS: dict[str, tuple[float, Callable[[random.Random, Path], Door]]] = {
    "names": (0.6, python_door),
    "texts": (0.1, text_door),
    "command": (0.25, command_door),
    "plugin": (0.12, plugin_door),
    "environment": (0.03, environment_door),
}
"""Kinds of doors, how often each is taken, and what opens one and tells what it found wrong."""


def main() -> int:
    """Open the doors, print a line for each failure and the counts."""
    chosen = _arguments()
    if chosen.only is not None:
        _watch_text()
        with tempfile.TemporaryDirectory(prefix="doors-") as home:
            kind, what, wrong = open_door(chosen.seed, chosen.only, chosen.kind, Path(home))
        print(f"{kind}: {what}\n{wrong or 'as it should be'}")
        return 1 if wrong else 0
    begun, failures, done = time.monotonic(), list[str](), collections.Counter[str]()
    print(f"seed {chosen.seed}, {chosen.count} doors, {chosen.seconds:g} s at most", flush=True)
    for number, kind, what, wrong in _results(chosen, begun):
        done[kind] += 1
        if wrong:
            failures.append(wrong.split(":")[0])
            print(f"--seed {chosen.seed} --only {number}  {kind}: {what}\n    {wrong}", flush=True)
    told = ", ".join(f"{n} {kind}" for kind, n in sorted(done.items()))
    print(f"{sum(done.values())} doors ({told}) in {time.monotonic() - begun:.0f} s")
    kinds = ", ".join(f"{n} {kind}" for kind, n in collections.Counter(failures).items())
    print(f"{len(failures)} failures{': ' + kinds if kinds else ''}")
    return 1 if failures else 0


def _arguments() -> argparse.Namespace:
    parser = campaign_parser(__doc__, DOORS)
    parser.add_argument("--first", type=int, default=0)
    return read_campaign(parser)


def open_door(seed: int, number: int, kind: str | None, home: Path) -> tuple[str, str, str]:
    """The kind of a door, what it is, and what is wrong there."""
    dice = random.Random(f"{seed}:{number}")
    kind = kind or dice.choices([*DOORS], [weight for weight, _ in DOORS.values()])[0]
    place = home / "here"
    place.mkdir()
    os.chdir(place)
    what, enter = DOORS[kind][1](dice, place)
    RAN.clear()
    kept = [(module, dict(vars(module))) for module in (sp, vo)]
    wrong = _enter(enter)
    for module, names in kept:  # a plugin may write ``sp.oo = ...``, which others would read
        vars(module).clear()
        vars(module).update(names)
    os.chdir(place)
    if RAN or any(place.rglob(CANARY)):
        wrong = f"text was run: {RAN[:1]}"
    wrong = wrong or _remains(place)
    os.chdir(home)
    for path in (place, *place.rglob("*")):
        with contextlib.suppress(OSError):
            path.chmod(0o700)
    shutil.rmtree(place, ignore_errors=True)
    return kind, what, wrong


def _enter(enter: Callable[[], Any]) -> str:
    """What is wrong with an outcome; empty where nothing is."""
    out, told = io.StringIO(), io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(told),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")
            enter()
    except Wrong as found:
        return str(found)
    except VoronecError as error:
        text = str(error)
        return "" if text.strip() and text.isprintable() else f"message: {text!r}"
    except KeyboardInterrupt:
        return ""
    except BaseException as error:
        at = traceback.extract_tb(error.__traceback__)
        own = [f for f in at if "/voronec/" in f.filename or "/systems/" in f.filename] or at
        where = f"{Path(own[-1].filename).name}:{own[-1].lineno}"
        return f"untyped: {type(error).__name__} at {where}: {ascii(error)[:150]}"
    text = told.getvalue()
    if "Traceback" in text:
        return f"traceback: {text.strip().splitlines()[-1]}"
    if "fault of voronec" in text:
        return f"untyped: {text.strip()[-250:]}"
    lines = [line for line in text.splitlines() if "\x1b[2K" not in line]
    bad = [line for line in lines if not line.isprintable()]
    return f"message: {bad[0]!r}" if bad else ""


RAN: list[str] = []
"""Text that was handed to an evaluator."""


def _watch_text() -> None:
    """SymPy's reader of text runs it: whoever comes there with a user's text has failed."""
    from sympy.parsing import sympy_parser

    run = sympy_parser.eval_expr

    def watch(code: str, *rest: Any) -> Any:
        frames = traceback.extract_stack()  # SymPy reads numbers and units of its own so
        own = any(f.name == "nsimplify" or "units" in f.filename for f in frames)
        # ``progress=sympy.sin``: what the caller's own function does with our words is its affair
        inner = [f for f in frames if "/voronec/" in f.filename][-1:]
        called = [(Path(f.filename).name, f.name) for f in inner] == [("arguments.py", "call")]
        if not own and not called:
            RAN.append(code[:80])
        return run(code, *rest)

    sympy_parser.eval_expr = watch


def _remains(place: Path) -> str:
    """What was left half-written: drafts, workshops, files of no bytes."""
    for path in place.rglob("*"):
        if path.name in ("here", "x.json", "x.toml", "plugin.py", "__pycache__") or (
            path.is_dir() and path.name[0] != "."
        ):
            continue
        if (path.name.startswith(".") and "voronec" in path.name) or ".partial" in path.name:
            return f"left: {path.name}"
        if path.is_file() and path.stat().st_size == 0:
            return f"left: {path.name} of no bytes"
    return ""


def _child(seed: int, kind: str | None, way: Any) -> None:
    """Open the doors whose numbers come along the way, until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    _watch_text()
    home = Path(tempfile.mkdtemp(prefix="doors-"))
    os.environ["XDG_CACHE_HOME"] = str(home / "cache")
    quiet = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(quiet, stream)
    try:
        while (number := way.recv()) is not None:
            try:
                way.send((number, *open_door(seed, number, kind, home)))
            except MemoryError:
                way.send((number, "?", "?", "memory: too much"))
                os._exit(1)
    finally:
        os.chdir("/")
        shutil.rmtree(home, ignore_errors=True)


class _Worker:
    """A child process and the door that it opens."""

    def __init__(self, seed: int, kind: str | None) -> None:
        self.way, inner = mp.Pipe()
        self.process = mp.get_context("fork").Process(target=_child, args=(seed, kind, inner))
        self.process.start()
        inner.close()
        self.number, self.clock = -1, ChildClock(self.process.pid)

    def open(self, number: int) -> None:
        self.number, self.clock = number, ChildClock(self.process.pid)
        self.way.send(number)

    def end(self) -> None:
        if self.process.is_alive():
            with contextlib.suppress(OSError):
                self.way.send(None)
            self.process.join(2)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()


def _results(chosen: argparse.Namespace, begun: float) -> Iterator[tuple[int, str, str, str]]:
    """Doors as they are done: number, kind, what it is, what is wrong."""
    numbers = iter(range(chosen.first, chosen.first + chosen.count))
    workers = [_Worker(chosen.seed, chosen.kind) for _ in range(chosen.jobs)]
    try:
        for worker in workers:
            worker.open(next(numbers))
        while workers:
            ready = multiprocessing.connection.wait([w.way for w in workers], timeout=1.0)
            for worker in [*workers]:
                lost = ""
                if worker.way in ready:
                    try:
                        yield worker.way.recv()
                    except (EOFError, OSError):
                        worker.process.join()
                        lost = f"signal: {worker.process.exitcode}"
                elif worker.clock.work_time() > HANG or worker.clock.wait_time() > WAIT:
                    worker.process.kill()
                    lost = f"hang: over {HANG:g} s"
                else:
                    continue
                if lost:
                    yield worker.number, chosen.kind or "?", "", lost
                    workers[workers.index(worker)] = worker = _Worker(chosen.seed, chosen.kind)
                number = next(numbers, None)
                if number is None or time.monotonic() - begun > chosen.seconds:
                    worker.end()
                    workers.remove(worker)
                else:
                    worker.open(number)
    finally:
        for worker in workers:
            worker.end()

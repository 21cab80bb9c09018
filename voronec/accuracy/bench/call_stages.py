"""Where the time of a whole call of ``integrate`` goes, stage by stage, in fresh processes.

A clock of the processor interrupts the call every half a millisecond; what went by since the last
time belongs to the stage of the innermost function that has one.  Nothing is slowed down by it.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import process_time
from types import FrameType, MappingProxyType
from typing import Any

from voronec.errors import DefinitionError

__all__ = ["STAGES", "CallStages", "measure_calls"]

STAGES = {
    "import": ("<frozen importlib",),
    "compilation": ("/heyoka/",),
    "code": ("/voronec/equations/program/",),
    "choice of the model": ("/voronec/motion/model/", "/voronec/motion/numeric_model"),
    "derivation": ("/voronec/equations/",),
    "checks": (
        "/voronec/motion/soundness", "/voronec/motion/state_probe",
        "/voronec/motion/split_models", "/voronec/motion/divisors",
        "/voronec/motion/singular_coordinates",
    ),
    "run": ("/voronec/motion/steppers/", "/voronec/motion/chart_stepper", "/scipy/"),
    "reading": ("/voronec/declaration/", "/voronec/motion/"),
}  # fmt: skip
"""Which files belong to which stage; the first that fits counts."""
OTHER = "other"
TICK = 5e-4
"""Seconds of the processor between two looks."""
AGAIN = 50
"""So often a call is made again: one takes a few looks only."""
PATIENCE = 300
"""Seconds after which a process is given up."""


@dataclass(frozen=True)
class CallStages:
    """Seconds of the processor by stage: of the first call ever, of the first call in a process
    where the disk knows the compiled code, imports included in both, and of a second call."""

    unknown: Mapping[str, float]
    known: Mapping[str, float]
    second: Mapping[str, float]

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold of it."""
        return {
            "first ever": dict(self.unknown), "first in a process": dict(self.known),
            "second": dict(self.second),
        }  # fmt: skip


def measure_calls(
    subject: str,
    scene: str | None,
    time: float | None,
    tolerance: float,
    values: Mapping[str, Mapping[str, str]] = MappingProxyType({}),
) -> CallStages:
    """The stages of calls for a system by name or file; ``values`` are ``parameters``, ``initial``
    and ``inputs`` of ``integrate``, as text.

    Raises ``DefinitionError`` where the system keeps no such clock, as Windows, or a call fails.
    """
    if not hasattr(signal, "setitimer"):
        raise DefinitionError("stages are told apart by a clock of Linux and macOS; run it there")
    with tempfile.TemporaryDirectory() as cache:
        span = "" if time is None else repr(time)
        words = [subject, scene or "", span, repr(tolerance), cache, json.dumps(dict(values))]
        unknown, known = _process(words), _process(words)
    return CallStages(unknown["first"], known["first"], known["second"])


def _process(words: list[str]) -> dict[str, dict[str, float]]:
    # by its path: to import it as a part of the package would load what is to be measured
    start = f"import runpy; runpy.run_path({__file__!r}, run_name='__main__')"
    command = [sys.executable, "-c", start, *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    lines = (done.stdout if done.returncode == 0 else done.stderr).splitlines()
    if done.returncode:
        # the last line of a traceback: the exception's name, and what it says
        what = lines[-1].partition(": ")[2] if lines else ""
        raise DefinitionError(what or f"{words[0]}: the call failed without a word")
    answer: dict[str, dict[str, float]] = json.loads(lines[-1])
    return answer


class _Looks:
    """Seconds by stage, while it is entered."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._last = 0.0

    def __enter__(self) -> _Looks:
        self._last = process_time()
        signal.signal(signal.SIGPROF, self._look)
        signal.setitimer(signal.ITIMER_PROF, TICK, TICK)
        return self

    def __exit__(self, *_: object) -> None:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        self._look(0, None)

    def _look(self, _signal: int, frame: FrameType | None) -> None:
        now = process_time()
        self.seconds[_stage(frame)] += now - self._last
        self._last = now


def _stage(frame: FrameType | None) -> str:
    while frame is not None:
        path = frame.f_code.co_filename.replace("\\", "/")
        for name, places in STAGES.items():
            if any(place in path for place in places):
                return name
        frame = frame.f_back
    return OTHER


def _main(words: list[str]) -> None:
    """In the fresh process: NAME|FILE SCENE TIME TOLERANCE CACHE VALUES."""
    subject, scene, time, tolerance, cache, values = words
    calls: list[Callable[[], Any]] = []
    with _Looks() as first:
        first.seconds["import"] = process_time()  # of Python itself
        try:
            import heyoka as hy

            hy.llvm_state.set_diskcache_path(cache)
        except (ImportError, AttributeError):
            pass
        from voronec.declaration.catalogue import load
        from voronec.motion import integrate

        system = load(subject)
        chosen = scene or ("default" if "default" in system.scenes else next(iter(system.scenes)))
        times = float(time) if time else None
        given = {"times": times, "tol": float(tolerance), **json.loads(values)}
        calls.append(lambda: integrate(system, chosen, **given))
        calls[0]()
    with _Looks() as second:
        for _ in range(AGAIN):
            calls[0]()
    each = {name: seconds / AGAIN for name, seconds in second.seconds.items()}
    print(json.dumps({"first": dict(first.seconds), "second": each}))


if __name__ == "__main__":
    _main(sys.argv[1:])

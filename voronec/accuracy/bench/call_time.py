"""The time of a call of ``integrate`` beside its steps, measured in fresh processes.

*Set-up*, cold and warm: deriving and compiling, imports excluded.  Cold, the user's caches and
heyoka's are in an empty folder; warm, a second process finds what the first left there.

*Stages* of a whole call: a clock of the processor interrupts it every half a millisecond; what
went by since the last time belongs to the stage of the innermost function that has one.  Nothing
is slowed down by it.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter, process_time
from types import FrameType, MappingProxyType
from typing import Any

from voronec.errors import DefinitionError

STAGES = {
    "import": ("<frozen importlib",),
    "compilation": ("/heyoka/",),
    "elimination": (
        "/voronec/algebra/elimination", "/voronec/algebra/stages",
        "/voronec/equations/program/low_rank",
    ),
    "code": ("/voronec/equations/program/",),
    "choice of the model": ("/voronec/motion/formulation/", "/voronec/motion/numeric_model"),
    "derivation": ("/voronec/equations/",),
    "checks": (
        "/voronec/motion/verify", "/voronec/motion/step_defects", "/voronec/motion/state_probe",
        "/voronec/motion/constraint_geometry", "/voronec/motion/singular_denominators",
        "/voronec/motion/singular_coordinates",
    ),
    "run": (
        "/voronec/motion/steppers/", "/voronec/motion/solve", "/voronec/motion/transitions/",
        "/scipy/",
    ),
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
Values = Mapping[str, Mapping[str, str]]
"""``parameters``, ``initial`` and ``inputs`` of ``integrate``, as text."""


@dataclass(frozen=True)
class SetupTime:
    """Seconds from a system to an integrator ready to run: of CPU, and by the clock.

    ``load`` is what running the system's own file takes, which is not part of these.
    """

    cold: float
    warm: float
    cold_clock: float
    warm_clock: float
    load: float
    method: str


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
    values: Values = MappingProxyType({}),
    method: str = "auto",
) -> CallStages:
    """The stages of calls for a system by name or file.

    Raises ``DefinitionError`` where the system keeps no such clock, as Windows, or a call fails.
    """
    if not hasattr(signal, "setitimer"):
        raise DefinitionError("stages are told apart by a clock of Linux and macOS; run it there")
    with tempfile.TemporaryDirectory() as cache:
        span = "" if time is None else repr(time)
        words = ["stages", subject, scene or "", cache, json.dumps(dict(values)), method]
        unknown, known = (_fresh_process([*words, span, repr(tolerance)]) for _ in range(2))
    return CallStages(unknown["first"], known["first"], known["second"])


def measure_setup(
    subject: str,
    scene: str | None,
    outputs: Sequence[str],
    method: str = "auto",
    values: Values = MappingProxyType({}),
) -> SetupTime | None:
    """Set-up of a system by name or file, in two fresh processes; None where one fails."""
    with tempfile.TemporaryDirectory() as cache:
        words = ["set-up", subject, scene or "", cache, json.dumps(dict(values)), method, *outputs]
        try:
            cold, warm = _fresh_process(words), _fresh_process(words)
        except DefinitionError:
            return None
    return SetupTime(
        cold["cpu"], warm["cpu"], cold["clock"], warm["clock"], warm["load"], warm["method"]
    )


def _fresh_process(words: Sequence[str]) -> dict[str, Any]:
    # by its path: to import it as a part of the package would load what is to be measured
    start = f"import runpy; runpy.run_path({__file__!r}, run_name='__main__')"
    command = [sys.executable, "-c", start, *words]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=PATIENCE,
            env=os.environ | {"XDG_CACHE_HOME": words[3]},
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise DefinitionError(f"{words[1]}: the call took more than {PATIENCE} s") from None
    lines = (done.stdout if done.returncode == 0 else done.stderr).splitlines()
    if done.returncode:
        # the last line of a traceback: the exception's name, and what it says
        what = lines[-1].partition(": ")[2] if lines else ""
        raise DefinitionError(what or f"{words[1]}: the call failed without a word")
    answer: dict[str, Any] = json.loads(lines[-1])
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


def import_everything() -> None:
    """All that an integration imports on its way: a small motion is computed first."""
    import sympy as sp

    from voronec.algebra.symbols import velocity
    from voronec.declaration.geometry import Fibration
    from voronec.declaration.scene import Scene
    from voronec.declaration.system import System
    from voronec.motion import integrate

    q = sp.Symbol("q")
    small = System(
        name="nothing",
        fibration=Fibration(base=(q,)),
        lagrangian=velocity(q) ** 2 / 2,
        scenes={"default": Scene(initial={q: 1})},
    )
    integrate(small, times=[0.0, 0.1], method="scipy")


def _keep_code_in(cache: str, method: str) -> None:
    """heyoka keeps its code in a folder, on any system; it is loaded only where it takes part."""
    if method not in ("auto", "heyoka"):
        return
    try:
        import heyoka as hy

        hy.llvm_state.set_diskcache_path(cache)
    except (ImportError, AttributeError):
        pass


def _setup(
    subject: str, scene: str, cache: str, values: str, method: str, *outputs: str
) -> dict[str, Any]:
    _keep_code_in(cache, method)
    from voronec.declaration.catalogue import load
    from voronec.motion import integrate

    import_everything()
    began = perf_counter()
    system = load(subject)
    loaded = perf_counter() - began
    chosen = str(scene or system.first_scene)
    start, end = (float(x) for x in system.scenes[chosen].times)
    soon = start + (end - start) / 1000
    began = process_time()
    cost = integrate(
        system, chosen, times=[start, soon], outputs=outputs, method=method, **json.loads(values)
    ).cost
    # so short a run costs nothing beside the set-up
    spent = process_time() - began
    return {"cpu": spent, "clock": cost.setup, "load": loaded, "method": cost.method}


def _stages(
    subject: str, scene: str, cache: str, values: str, method: str, span: str, tolerance: str
) -> dict[str, Any]:
    with _Looks() as first:
        first.seconds["import"] = process_time()  # of Python itself
        _keep_code_in(cache, method)
        from voronec.declaration.catalogue import load
        from voronec.motion import integrate

        system = load(subject)
        chosen = str(scene or system.first_scene)
        end = float(span) if span else None
        given = {"times": end, "tol": float(tolerance), "method": method, **json.loads(values)}
        integrate(system, chosen, **given)
    with _Looks() as second:
        for _ in range(AGAIN):
            integrate(system, chosen, **given)
    each = {name: seconds / AGAIN for name, seconds in second.seconds.items()}
    return {"first": dict(first.seconds), "second": each}


if __name__ == "__main__":
    kind, *words = sys.argv[1:]
    print(json.dumps(_setup(*words) if kind == "set-up" else _stages(*words)))

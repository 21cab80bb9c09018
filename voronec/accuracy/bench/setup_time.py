"""Set-up, cold and warm: deriving and compiling in a fresh process, imports excluded.

Cold, heyoka's disk cache is pointed to an empty folder by its own ``llvm_state`` functions; warm,
a second process finds what the first left there.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

__all__ = ["SetupTime", "measure_setup"]

PATIENCE = 300
"""Seconds after which a process is given up."""


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


def measure_setup(
    subject: str,
    scene: str | None,
    outputs: Sequence[str],
    method: str = "auto",
    values: Mapping[str, Mapping[str, str]] = MappingProxyType({}),
) -> SetupTime | None:
    """Set-up of a system by name or file, in two fresh processes; None where one fails.

    ``values`` are ``parameters``, ``initial`` and ``inputs`` of ``integrate``, as text.
    """
    with tempfile.TemporaryDirectory() as cache:
        words = [subject, scene or "", method, cache, json.dumps(dict(values)), *outputs]
        cold = _process(words)
        warm = None if cold is None else _process(words)
    if cold is None or warm is None:
        return None
    return SetupTime(
        cold["cpu"], warm["cpu"], cold["clock"], warm["clock"], warm["load"], warm["method"]
    )


def _process(words: Sequence[str]) -> dict[str, Any] | None:
    command = [sys.executable, "-m", "voronec.accuracy.bench.setup_time", *words]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=True)
        answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    except (subprocess.SubprocessError, ValueError, IndexError):
        return None
    return answer


def _import_everything() -> None:
    """All that an integration imports on its way: a small motion is computed first."""
    import sympy as sp

    import voronec as vo

    q = sp.Symbol("q")
    small = vo.System(
        name="nothing",
        fibration=vo.Fibration(base=(q,)),
        lagrangian=vo.velocity(q) ** 2 / 2,
        scenes={"default": vo.Scene(initial={q: 1})},
    )
    vo.integrate(small, times=[0.0, 0.1], method="scipy")


def _main(words: Sequence[str]) -> None:
    """In the fresh process: NAME|FILE SCENE METHOD CACHE VALUES [OUTPUT ...]."""
    from time import perf_counter, process_time

    subject, scene, method, cache, values, *outputs = words
    try:
        import heyoka as hy

        hy.llvm_state.set_diskcache_path(cache)
    except (ImportError, AttributeError):
        pass
    from voronec.declaration.catalogue import load
    from voronec.motion import integrate

    _import_everything()
    began = perf_counter()
    system = load(subject)
    loaded = perf_counter() - began
    chosen = scene or ("default" if "default" in system.scenes else next(iter(system.scenes)))
    start, end = (float(x) for x in system.scenes[chosen].times)
    soon = start + (end - start) / 1000
    began = process_time()
    cost = integrate(
        system, chosen, times=[start, soon], outputs=tuple(outputs), method=method,
        **json.loads(values),
    ).cost  # fmt: skip
    # so short a run costs nothing beside the set-up
    spent = process_time() - began
    found = {"cpu": spent, "clock": cost.setup, "load": loaded, "method": cost.method}
    print(json.dumps(found))


if __name__ == "__main__":
    _main(sys.argv[1:])

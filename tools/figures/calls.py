"""Rows of the table of speed: whole calls and set-up, in processes of their own, with caches of
their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from statistics import median

from figures.problems import Extent
from figures.table import Row

__all__ = ["ROWS", "setup"]

CHILD = """
import json, sys
from time import process_time
name, method, span, tried, imported = sys.argv[1:]
if method in ("numba", "c"):
    sys.modules["heyoka"] = None
import voronec as vo
if imported:
    from voronec.accuracy.bench.call_time import import_everything
    import_everything()
system, again = vo.load(name), []
since = process_time() if imported else 0.0
for _ in range(int(tried)):
    began = process_time()
    vo.integrate(system, times=float(span), tol=1e-11, method=method)
    again.append(process_time() - began)
    first = process_time() - since if len(again) == 1 else first
print(json.dumps([first, min(again[1:])]))
"""
SECOND = {"ball-on-sphere": 5, "demchenko": 12, "rattleback": 15}
"""Milliseconds that a second call may take."""


def _child(
    cache: str, name: str, method: str, span: float = 10.0, tried: int = 2, imported: bool = False
) -> list[float]:
    """CPU seconds of the first call in a fresh process, and the least of the others.

    The process keeps its caches in a folder.  Imports are part of the first call, unless
    everything is ``imported`` before.
    """
    # what numba and Python themselves keep is part of an installation that has run before
    environment = os.environ | {"XDG_CACHE_HOME": cache}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    words = [name, method, repr(span), str(tried), "imported" if imported else ""]
    done = subprocess.run(
        [sys.executable, "-c", CHILD, *words], capture_output=True, text=True, check=True,
        env=environment,
    )  # fmt: skip
    seconds: list[float] = json.loads(done.stdout.splitlines()[-1])
    return seconds


def _spread(times: Iterable[float]) -> tuple[float, float, float]:
    """The middle one, the smallest and the largest."""
    found = list(times)
    return median(found), min(found), max(found)


def calls(extent: Extent) -> Iterator[Row]:
    """From ``vo.integrate(system, ...)`` to the trajectory, and from nothing to it."""
    for name, allowed in SECOND.items():
        with tempfile.TemporaryDirectory() as cache:
            _child(cache, name, "auto")
            found = [
                _child(cache, name, "auto", tried=20 * extent.turns)
                for _ in range(extent.processes)
            ]
        (first, least, most), (second, low, high) = (
            _spread(times) for times in zip(*found, strict=True)
        )
        yield Row(
            f"whole call, {name}, T = 10, second call in a process",
            f"{allowed} ms",
            f"{1e3 * second:.1f} ms of CPU ({1e3 * low:.1f} to {1e3 * high:.1f})",
            bool(1e3 * second <= allowed),
            "the run itself takes a tenth of it; the rest reads what is asked, looks whether the "
            "motion obeys the equations, and evaluates outputs and integrals on the grid",
        )
        yield Row(
            f"whole call, {name}, T = 10, first in a process whose disk knows it, imports included",
            "0.4 s",
            f"{first:.2f} s of CPU ({least:.2f} to {most:.2f})",
            bool(first <= 0.4),
            "to start Python and import heyoka alone, which loads SymPy and NumPy itself, takes "
            "0.4 s on this machine; the rest is shared by the engine's modules, a tenth of a "
            "second for the methods of their dataclasses alone, and the system's own declaration; "
            "heyoka takes machine code from its disk in less than a twentieth of a second",
        )


COMPILERS = {
    "numba": "the integrator and the program are compiled as one function for each model",
    "c": "",
}
LATER = {
    "numba": "to import SymPy, NumPy and numba takes longer than that; numba loads all that it "
    "knows of NumPy, and SciPy's linear algebra, before it takes machine code from its disk",
    "c": "to import SymPy and NumPy, and to read the system, takes longer than that",
}


def compiled_calls(extent: Extent) -> Iterator[Row]:
    """The methods ``numba`` and ``c`` where heyoka is not installed."""
    for method, why in COMPILERS.items():
        with tempfile.TemporaryDirectory() as cache:
            ever = _child(cache, "ball-on-sphere", method)[0]
            later, least, most = _spread(
                _child(cache, "ball-on-sphere", method)[0] for _ in range(extent.processes)
            )
        what = f"method `{method}`, heyoka not installed, ball-on-sphere, T = 10"
        yield Row(
            f"{what}: first call ever, imports included",
            "10 s", f"{ever:.1f} s of CPU", bool(ever <= 10), why,
        )  # fmt: skip
        yield Row(
            f"{what}: first call in a later process, imports included",
            "0.5 s", f"{later:.2f} s of CPU ({least:.2f} to {most:.2f})", bool(later <= 0.5),
            LATER[method],
        )  # fmt: skip


def setup(extent: Extent) -> Iterator[Row]:
    """From a system to an integrator that has run, cold and again; of a chain of bodies, cold."""
    found = []
    for _ in range(extent.processes):
        with tempfile.TemporaryDirectory() as cache:
            found.append(_child(cache, "chaplygin-ball", "heyoka", 0.04, 5, imported=True))
    (cold, least, most), (warm, low, high) = (_spread(times) for times in zip(*found, strict=True))
    what = "Chaplygin ball with method heyoka, `integrate` over a span of no length"
    yield Row(
        f"set-up, warm, {what}: again in the same process",
        "0.1 s", f"{warm:.3f} s of CPU ({low:.3f} to {high:.3f})", warm <= 0.1,
        "heyoka takes the compiled code from memory, but builds its decomposition again",
    )  # fmt: skip
    yield Row(
        f"set-up, cold, {what}: derivation, smallest model and compilation, first in the process, "
        "caches empty, imports excluded",
        "1.5 s", f"{cold:.2f} s of CPU ({least:.2f} to {most:.2f})", cold <= 1.5,
        "most of it is heyoka's compiler",
    )  # fmt: skip
    chain = str(Path(__file__).with_name("chain.py"))
    with tempfile.TemporaryDirectory() as cache:
        cold = _child(cache, chain, "heyoka", 0.04, imported=True)[0]
    yield Row(
        "chain of 7 links, 3 blades, six degrees of freedom: derivation and compilation, cold",
        "under 10 s", f"{cold:.2f} s of CPU", cold < 10,
    )  # fmt: skip


ROWS: dict[str, Callable[[Extent], Iterator[Row]]] = {
    "calls": calls,
    "compiled-calls": compiled_calls,
}

"""Rows of the table of figures: whole calls in processes of their own, caches of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from statistics import median
from typing import Any

from figures.extent import Extent
from figures.table import Row

__all__ = ["ROWS", "in_process"]

CALL = """
import json, sys
from time import process_time
name, method, tried = sys.argv[1:]
if method in ("numba", "c"):
    sys.modules["heyoka"] = None
import voronec as vo
system, again = vo.load(name), []
for _ in range(int(tried)):
    began = process_time()
    vo.integrate(system, times=10, tol=1e-11, method=method)
    again.append(process_time() - began)
    first = process_time() if len(again) == 1 else first
print(json.dumps([first, min(again[1:])]))
"""
SECOND = {"ball-on-sphere": 5, "demchenko": 12, "rattleback": 15}
"""Milliseconds that a second call may take."""


def in_process(cache: str, *words: str) -> Any:
    """What a fresh Python says last, as JSON, when it keeps caches in a folder."""
    # what numba and Python themselves keep is part of an installation that has run before
    environment = os.environ | {"XDG_CACHE_HOME": cache}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    done = subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, check=True, env=environment
    )
    return json.loads(done.stdout.splitlines()[-1])


def _spread(times: Iterable[float]) -> tuple[float, float, float]:
    """The middle one, the smallest and the largest."""
    found = list(times)
    return median(found), min(found), max(found)


def calls(extent: Extent) -> Iterator[Row]:
    """From ``vo.integrate(system, ...)`` to the trajectory, and from nothing to it."""
    for name, allowed in SECOND.items():
        with tempfile.TemporaryDirectory() as cache:
            in_process(cache, "-c", CALL, name, "auto", "2")
            found = [
                in_process(cache, "-c", CALL, name, "auto", str(20 * extent.turns))
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
        words = ("-c", CALL, "ball-on-sphere", method, "2")
        with tempfile.TemporaryDirectory() as cache:
            ever = in_process(cache, *words)[0]
            later, least, most = _spread(
                in_process(cache, *words)[0] for _ in range(extent.processes)
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


ROWS: dict[str, Callable[[Extent], Iterator[Row]]] = {
    "calls": calls,
    "compiled-calls": compiled_calls,
}

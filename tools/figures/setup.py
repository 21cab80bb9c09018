"""Rows of the table of figures: set-up, cold and warm, and a large system."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from figures.table import Row
from voronec.accuracy.bench import at_error

__all__ = ["ROWS"]

SETUP = """
import json, sys, tempfile
from time import process_time
import heyoka as hy
hy.llvm_state.set_diskcache_path(sys.argv[1])
import voronec as vo
from voronec.accuracy.bench.setup_time import _import_everything
_import_everything()
ball = vo.load("chaplygin-ball")
times = []
for _ in range(5):
    began = process_time()
    vo.integrate(vo.derive(ball) if not times else ball, times=[0, 0.04], method="heyoka",
                 outputs=("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3"))
    times.append(process_time() - began)
print(json.dumps([times[0], min(times[1:])]))
"""


def setup() -> Iterator[Row]:
    """From a loaded system to an integrator that has run, in a fresh process."""
    colds, warms = [], []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as cache:
            cold, warm = _process("-c", SETUP, cache)
        colds.append(cold)
        warms.append(warm)
    cold, warm = min(colds), min(warms)
    what = "Chaplygin ball with method heyoka, `integrate` over a span of no length"
    yield Row(
        f"set-up, warm, {what}: again in the same process",
        "0.1 s",
        f"{warm:.3f} s of CPU",
        warm <= 0.1,
        "heyoka takes the compiled code from memory, but builds its decomposition again",
    )
    yield Row(
        f"set-up, cold, {what}: derivation, smallest model and compilation, first in the process, "
        "heyoka's cache empty, imports excluded",
        "1.5 s",
        f"{cold:.2f} s of CPU",
        cold <= 1.5,
        "most of it is heyoka's compiler",
    )


def _process(*words: str) -> Any:
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def chain() -> Iterator[Row]:
    """Six degrees of freedom, thousands of operations."""
    record = _process(str(Path(__file__).parents[1] / "bench.py"), "chain", "--json")
    setup, rows = record["setup"], record["rows"]
    cold = sum(s for name, s in setup.items() if "numba" not in name)
    what = f"chain of {record['system']}, six degrees of freedom"
    yield Row(
        f"{what}, {record['operations']} operations: derivation and compilation, cold",
        "under 10 s",
        f"{cold:.2f} s of CPU (heyoka {setup['heyoka, cold']:.2f} s)",
        cold < 10,
    )
    pairs = {
        method: [(r["error"], r["seconds"]) for r in rows if r["method"] == method]
        for method in ("heyoka", "scipy, numba", "numba")
    }
    # the finest run of heyoka is what the others are compared with
    pairs["heyoka"] = [(max(e, 1e-14), s) for e, s in pairs["heyoka"]]
    for error in (1e-6, 1e-9):
        ours, theirs, compiled = (
            at_error(pairs[m], error).seconds or np.nan for m in ("heyoka", "scipy, numba", "numba")
        )
        yield Row(
            f"{what}: against scipy's DOP853 with a right-hand side of numba, at error {error:g}",
            "not slower",
            f"{theirs / ours:.2f} times as fast ({1e3 * theirs:.3g} / {1e3 * ours:.3g} ms; not "
            f"asked: {1e3 * compiled:.3g} ms where DOP853 itself is compiled too)",
            bool(theirs >= ours),
            "heyoka's compact mode, which compiles so large a program in seconds, runs slower",
        )


ROWS: dict[str, Callable[[], Iterator[Row]]] = {"setup": setup, "chain": chain}

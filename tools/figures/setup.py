"""Rows of the table of figures: set-up, cold and warm, and a large system."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from statistics import median

from figures.calls import in_process
from figures.chain import against_numba, bicycle_problem, chain_problem
from figures.extent import Extent
from figures.table import Row

__all__ = ["ROWS"]

SETUP = """
import json
from time import process_time
import voronec as vo
from voronec.accuracy.bench.call_time import import_everything
import_everything()
ball = vo.load("chaplygin-ball")
times = []
for _ in range(5):
    began = process_time()
    vo.integrate(vo.derive(ball) if not times else ball, times=[0, 0.04], method="heyoka",
                 outputs=("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3"))
    times.append(process_time() - began)
print(json.dumps([times[0], min(times[1:])]))
"""


def setup(extent: Extent) -> Iterator[Row]:
    """From a loaded system to an integrator that has run, in a fresh process."""
    colds, warms = [], []
    for _ in range(extent.processes):
        with tempfile.TemporaryDirectory() as cache:
            cold, warm = in_process(cache, "-c", SETUP)
        colds.append(cold)
        warms.append(warm)
    what = "Chaplygin ball with method heyoka, `integrate` over a span of no length"
    yield Row(
        f"set-up, warm, {what}: again in the same process",
        "0.1 s",
        f"{median(warms):.3f} s of CPU ({min(warms):.3f} to {max(warms):.3f})",
        median(warms) <= 0.1,
        "heyoka takes the compiled code from memory, but builds its decomposition again",
    )
    yield Row(
        f"set-up, cold, {what}: derivation, smallest model and compilation, first in the process, "
        "caches empty, imports excluded",
        "1.5 s",
        f"{median(colds):.2f} s of CPU ({min(colds):.2f} to {max(colds):.2f})",
        median(colds) <= 1.5,
        "most of it is heyoka's compiler",
    )


def chain(extent: Extent) -> Iterator[Row]:
    """Six degrees of freedom, thousands of operations; a bicycle."""
    with tempfile.TemporaryDirectory() as cache:  # heyoka shall compile there, and only there
        record = in_process(cache, str(Path(__file__).parents[1] / "bench.py"), "chain", "--json")
    cold = sum(s for name, s in record["setup"].items() if "numba" not in name)
    yield Row(
        f"chain of {record['system']}, six degrees of freedom, {record['operations']} operations: "
        "derivation and compilation, cold",
        "under 10 s",
        f"{cold:.2f} s of CPU (heyoka {record['setup']['heyoka, cold']:.2f} s)",
        cold < 10,
    )
    for name, problem in {
        f"chain of {record['system']}, six degrees of freedom": chain_problem(),
        "bicycle, scene `default`": bicycle_problem(),
    }.items():
        errors = (1e-6, 1e-9)
        found = against_numba(problem, errors, extent.rounds)
        for method, error in product(("numba", "c"), errors):
            ours, hand = (found.at(m, error) for m in (method, "hand"))
            ratio, whole = ours.over(hand), found.at(method, error, "whole")
            auto = ", which `auto` takes for a heavy program," * (method == "c")
            yield Row(
                f"{name}: run of method `{method}`{auto} against DOP853 wholly in numba by hand, "
                f"at error {error:g}",
                "not slower than 1.1 times",
                f"{ratio.times()}; {1e3 * ours.median:.3g} / {1e3 * hand.median:.3g} ms; whole "
                f"call {1e3 * whole.median:.3g} ms",
                ratio.median <= 1.1,
                "the same stages, but for sums of products, which numba fuses and the C compiler "
                "does not; it compiles ten times as fast, and more than such a run gains"
                if method == "c"
                else "the same stages; some hundredths of a millisecond of a run are spent outside "
                "them",
            )


ROWS: dict[str, Callable[[Extent], Iterator[Row]]] = {"setup": setup, "chain": chain}

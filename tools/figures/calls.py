"""Rows of the table of speed: whole calls and set-up, in processes of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from statistics import median

import numpy as np

import voronec as vo
from figures.peers import PEERS
from figures.problems import Extent
from figures.race import clock
from figures.table import Row
from voronec.accuracy.bench import (
    CallStages,
    SetupTime,
    contenders,
    measure_calls,
    measure_setup,
    scene_problem,
)
from voronec.algebra.symbols import plain_name

__all__ = ["ROWS", "setup"]

SECOND = {"ball-on-sphere": 5, "demchenko": 12, "rattleback": 15}
"""Milliseconds that a second call may take."""


def _spread(times: Iterable[float]) -> tuple[float, float, float]:
    """The middle one, the smallest and the largest."""
    found = list(times)
    return median(found), min(found), max(found)


def _calls(name: str, method: str, extent: Extent) -> list[CallStages]:
    """Whole calls over T = 10, in pairs of fresh processes with caches of their own."""
    return [measure_calls(name, None, 10.0, 1e-11, method=method) for _ in range(extent.processes)]


def calls(extent: Extent) -> Iterator[Row]:
    """From ``vo.integrate(system, ...)`` to the trajectory, and from nothing to it."""
    for name, allowed in SECOND.items():
        found = _calls(name, "auto", extent)
        first, least, most = _spread(sum(one.known.values()) for one in found)
        second, low, high = _spread(sum(one.second.values()) for one in found)
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
    """The methods ``numba`` and ``c``, which load nothing of heyoka."""
    for method, why in COMPILERS.items():
        found = _calls("ball-on-sphere", method, extent)
        ever = median(sum(one.unknown.values()) for one in found)
        later, least, most = _spread(sum(one.known.values()) for one in found)
        what = f"method `{method}`, heyoka not loaded, ball-on-sphere, T = 10"
        yield Row(
            f"{what}: first call ever, imports included",
            "10 s", f"{ever:.1f} s of CPU", bool(ever <= 10), why,
        )  # fmt: skip
        yield Row(
            f"{what}: first call in a later process, imports included",
            "0.5 s", f"{later:.2f} s of CPU ({least:.2f} to {most:.2f})", bool(later <= 0.5),
            LATER[method],
        )  # fmt: skip


PREPARED: dict[str, tuple[float, tuple[str, ...]]] = {
    "sleigh": (20.0, ()), "ball-on-sphere": (10.0, ()), "demchenko": (10.0, ("u",)),
}  # fmt: skip
"""How long the motions of prepared problems are, and their outputs."""


def _seconds_of(prepared: vo.PreparedProblem, start: dict[str, float], grid: np.ndarray) -> float:
    return clock(lambda: prepared.run(start, times=grid))[1]


def prepared_runs(extent: Extent) -> Iterator[Row]:
    """``PreparedProblem.run`` and ``integrate`` from one start after another, beside heyoka's steps
    along equations by hand; the processor's time of the fastest call of each, in turns."""
    (contender,) = contenders(["heyoka-by-hand"], PEERS)
    for name, (end, outputs) in PREPARED.items():
        system = vo.load(name)
        asked = scene_problem(system, time=end, instants=51, outputs=outputs)
        by_hand = contender.prepare(asked)
        prepared = vo.prepare(system, "default", outputs, tol=1e-9)
        velocity = plain_name(system.velocities[-1])
        first = vo.integrate(system, times=asked.grid, tol=1e-9)[velocity][0]

        starts = [{velocity: float(first) * (1 + 1e-6 * k)} for k in range(100 * extent.rounds)]
        ours = min(_seconds_of(prepared, start, asked.grid) for start in starts)
        theirs = min(by_hand(1e-9).seconds for _ in range(extent.rounds))
        more = 1e3 * (ours - theirs)
        yield Row(
            f"run of a prepared problem, {name}, T = {end:g} at 1e-9, 51 instants, every start "
            "another: beyond heyoka by hand",
            "0.4 ms", f"{more:.2f} ms of CPU ({1e3 * theirs:.3f} by hand)", more <= 0.4,
            "the start is read and put on the constraints, the units of the states, poles and "
            "singular masses are looked at, and at the end whether the motion obeys the equations",
        )  # fmt: skip


def setup(extent: Extent) -> Iterator[Row]:
    """From a system to an integrator that is ready, cold and warm; of a chain of bodies, cold."""
    found = [_setup("chaplygin-ball") for _ in range(extent.processes)]
    warm, low, high = _spread(one.warm for one in found)
    cold, least, most = _spread(one.cold for one in found)
    what = "Chaplygin ball with method heyoka, `integrate` over a span of no length"
    yield Row(
        f"set-up, warm, {what}: in a process whose disk knows it, imports excluded",
        "0.1 s", f"{warm:.3f} s of CPU ({low:.3f} to {high:.3f})", warm <= 0.1,
        "heyoka takes the compiled code from its disk, but builds its decomposition again",
    )  # fmt: skip
    yield Row(
        f"set-up, cold, {what}: derivation, smallest model and compilation, first in the process, "
        "caches empty, imports excluded",
        "1.5 s", f"{cold:.2f} s of CPU ({least:.2f} to {most:.2f})", cold <= 1.5,
        "most of it is heyoka's compiler",
    )  # fmt: skip
    chain = _setup(str(Path(__file__).with_name("chain.py"))).cold
    yield Row(
        "chain of 7 links, 3 blades, six degrees of freedom: derivation and compilation, cold",
        "under 10 s", f"{chain:.2f} s of CPU", chain < 10,
    )  # fmt: skip


def _setup(name: str) -> SetupTime:
    found = measure_setup(name, None, (), method="heyoka")
    if found is None:
        raise OSError(f"set-up of {name}: a fresh process failed")
    return found


ROWS: dict[str, Callable[[Extent], Iterator[Row]]] = {
    "calls": calls,
    "prepared-runs": prepared_runs,
    "compiled-calls": compiled_calls,
}

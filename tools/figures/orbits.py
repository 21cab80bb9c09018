"""Periodic orbits and Lyapunov exponents in figures.

    python tools/bench.py orbits [families | speed | published]

families   ten families of periodic orbits in the catalogue: closure, trivial multipliers, seconds
speed      six exponents of the non-symmetric gyroscopic ball on a sphere, against C by hand at equal
           error, and against pynamicalsys where it is installed
published  exponents that are published, and integrable balls whose exponents vanish
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import sympy as sp

import voronec as vo
from voronec.dynamics.phase_space import PhaseSpace
from voronec.dynamics.variational import EVERY, variational_flow
from voronec.motion.steppers.dop853_source import FIFTH, STEP, THIRD, WEIGHTS

FAMILIES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("falling-disc", {"along": "energy", "to": 2.2}),
    ("falling-disc", {"along": "R", "to": 1.3}),
    ("chaplygin-ball", {"along": "energy", "to": 3.0}),
    ("zhukovsky-ball", {"along": "energy", "to": 2.4}),
    ("zhukovsky-ball", {"along": "k", "to": 0.6}),
    ("bobylev-ball", {"along": "energy", "to": 2.0}),
    ("ball-on-paraboloid", {"along": "energy", "to": 1.2}),
    ("spheroid-on-plane", {"along": "energy", "to": 5.6}),
    ("ellipsoid-on-plane", {"along": "energy", "to": 2.6}),
    ("displaced-ball-on-sphere", {"along": "energy", "to": 2.3}),
)
POINTS = 11
SPAN, REPEATS = 100.0, 7
ERROR = 1e-9
TOLERANCES = 10.0 ** np.arange(-7, -13.5, -0.5)
BY_HAND = Path(__file__).with_name("exponents_by_hand.c")


def main() -> int:
    """Print the figures that are asked for, or all of them."""
    kinds = {"families": families, "speed": speed, "published": published_values}
    for name in sys.argv[1:] or kinds:
        kinds[name]()
    return 0


def families() -> None:
    """Ten families."""
    print("| system | along | orbits | from | to | closure | trivial | multipliers | seconds |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name, given in FAMILIES:
        began = perf_counter()
        found = vo.periodic(vo.load(name), points=POINTS, **given)
        spent = perf_counter() - began
        first, last = found[given["along"]][[0, -1]]
        trivial = max(o.trivial_defect for o in found)
        largest = max(abs(o.multipliers).max(initial=0.0) for o in found)
        print(f"| {name} | {given['along']} | {len(found)}, {found.ended} | {first:.4g} | {last:.4g} "
              f"| {max(o.closure for o in found):.1e} | {trivial:.1e} | up to {largest:.5g} "
              f"| {spent:.1f} |", flush=True)  # fmt: skip


def speed() -> None:
    """Microseconds for a unit of time at an error of the state and of the logarithms."""
    space = PhaseSpace.of(vo.load("gyroscopic-ball-on-sphere"), None, None, None, None, ())
    start, values = space.motions.states[0], space.motions.values[0]
    with tempfile.TemporaryDirectory() as cache, _cache(cache):
        began = perf_counter()
        flow = variational_flow.__wrapped__(space.motions.program)
        built = perf_counter() - began

    def ours(tol: float) -> np.ndarray:
        state = flow.start(start)
        flow.go(state, SPAN, values, tol, EVERY)
        return np.concatenate([state.x, state.logs])

    by_hand = _by_hand(start, values)
    true = ours(1e-14)
    print(f"the two at 1e-14 differ by {np.abs(true - by_hand(1e-14)).max():.1e}")
    found = {}
    for name, run in (("voronec", ours), ("C by hand", by_hand)):
        rows = [(np.abs(run(tol) - true).max(), _seconds(run, tol)) for tol in TOLERANCES]
        errors, times = (np.log(np.array(part)) for part in zip(*rows, strict=True))
        order = np.argsort(errors)
        at = np.interp(np.log(ERROR), errors[order], times[order])
        found[name] = float(np.exp(at)) / SPAN * 1e6
        print(f"{name}: {found[name]:.1f} us for a unit of time at an error of {ERROR:g}")
    print(f"quotient {found['voronec'] / found['C by hand']:.2f}; compiled in {built:.2f} s")


def _cache(folder: str) -> Any:
    """A user's cache that is empty."""
    from unittest.mock import patch

    return patch.dict("os.environ", {"XDG_CACHE_HOME": folder})


def _seconds(run: Callable[[float], np.ndarray], tol: float) -> float:
    times = []
    for _ in range(REPEATS):
        began = perf_counter()
        run(tol)
        times.append(perf_counter() - began)
    return min(times)


def _by_hand(start: np.ndarray, values: np.ndarray) -> Callable[[float], np.ndarray]:
    """The C by hand, compiled as one does who wants it fast."""
    folder = tempfile.mkdtemp()
    words = ["cc", "-O3", "-march=native", "-shared", "-fPIC", str(BY_HAND), "-o", "hand.so", "-lm"]
    subprocess.run(words, cwd=folder, check=True)
    function = ctypes.CDLL(str(Path(folder) / "hand.so")).by_hand
    function.argtypes = [ctypes.c_void_p] * 6 + [ctypes.c_double] * 2
    rows = np.zeros((13, 12))
    for s, row in enumerate((*WEIGHTS[:12], STEP)):
        rows[s, list(row)] = list(row.values())
    fifth, third = np.zeros(12), np.zeros(12)
    fifth[list(FIFTH)], third[list(THIRD)] = list(FIFTH.values()), list(THIRD.values())
    given = np.ascontiguousarray(values)

    def run(tol: float) -> np.ndarray:
        z, logs = np.concatenate([start, np.eye(6).ravel()]), np.zeros(6)
        arrays = z, logs, given, rows, fifth, third
        function(*(a.ctypes.data for a in arrays), SPAN, tol)
        return np.concatenate([z[:6], logs])

    return run


def published_values() -> None:
    """Values beside those of books, and zeros."""
    x, y, z, tau = sp.symbols("x y z tau")
    v = vo.velocity
    potential = (x**2 + y**2) / 2 + x**2 * y - y**3 / 3
    kinetic = (v(x) ** 2 + v(y) ** 2) / 2
    henon = vo.System(
        "henon-heiles", vo.Fibration(base=(x, y)), kinetic - potential,
        integrals={"energy": kinetic + potential},
    )  # fmt: skip
    rows = (v(x) - 10 * (y - x), v(y) - x * (28 - z) + y, v(z) - x * y + sp.Rational(8, 3) * z)
    fibration = vo.Fibration(base=(tau,), fibre=(x, y, z))
    lorenz = vo.System("lorenz", fibration, v(tau) ** 2 / 2, rows)
    given: list[tuple[Any, dict[str, Any], str]] = [
        (lorenz, {"initial": {"x": 1, "y": 1, "z": 20}, "variables": ("x", "y", "z"),
                  "bar": 3e-3}, "0.9056, 0, -14.5723 [Sprott2003]"),
        (henon, {"initial": {"x": 0, "y": -0.25, v(x): 0.42081}, "bar": 5e-3, "until": 2e5},
         "0.047 [Skokos2010]"),
        *((vo.load(name), {}, "0") for name in ("chaplygin-ball", "zhukovsky-ball", "bobylev-ball")),
    ]  # fmt: skip
    for system, words, expected in given:
        began = perf_counter()
        found = vo.exponents(system, **words)
        print(f"{system.name}: published {expected}; {perf_counter() - began:.1f} s")
        print("\n".join(f"    {line}" for line in found.lines(0)), flush=True)

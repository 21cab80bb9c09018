"""Many motions at once: the third picture of the page of speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

import voronec as vo
from figures import table
from figures.numba_dop853 import compiled_dop853
from figures.peers import Formulation, by_hand
from figures.problems import Extent
from figures.race import clock
from voronec.accuracy.bench import scene_problem

NORMAL = ("gamma1", "gamma2", "gamma3")
SPIN = ("omega1", "omega2", "omega3")
SPAN, INSTANTS, ERROR = 10.0, 11, 1e-9
TOLERANCES = (1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 3e-14)
SAMPLE = 64
"""Starts by which a tolerance is chosen."""
SLOW = 100
"""Starts beyond which a loop in Python is not measured."""


@dataclass(frozen=True)
class Starts:
    """The ball on a sphere with spins drawn around those of its scene, and its program by hand."""

    count: int
    span: float

    @cached_property
    def spins(self) -> dict[str, np.ndarray]:
        """Angular velocities by name (count,)."""
        dice = np.random.default_rng(2)
        return {name: 1 + 0.3 * dice.normal(size=self.count) for name in SPIN}

    @cached_property
    def hand(self) -> Formulation:
        """The program by hand."""
        return by_hand(scene_problem(vo.load("ball-on-sphere"), time=self.span))

    @cached_property
    def rows(self) -> np.ndarray:
        """Its states at the start (count, 6)."""
        known = self.hand.values
        return np.array([
            self.hand.start({**known, **{n: x[i] for n, x in self.spins.items()}})
            for i in range(self.count)
        ])  # fmt: skip

    @cached_property
    def grid(self) -> np.ndarray:
        """The instants."""
        return np.linspace(0, self.span, INSTANTS)

    def outputs(self, rows: np.ndarray) -> np.ndarray:
        """gamma and omega (k, 6) of states (k, 6)."""
        known = self.hand.back(rows)
        return np.stack([known[n] for n in NORMAL + SPIN], axis=-1)


Loop = Callable[[Starts, float], np.ndarray]
"""All motions at a tolerance: gamma and omega (count, k, 6)."""


def _ensemble(ball: Any, starts: Starts, tol: float) -> np.ndarray:
    found = vo.ensemble(
        ball, starts.spins, times=starts.grid, outputs=NORMAL + SPIN, scene="default", tol=tol,
        method="heyoka", jobs=1,
    )  # fmt: skip
    return np.stack([found[n] for n in NORMAL + SPIN], axis=-1)


def _lanes(starts: Starts, tol: float) -> np.ndarray:
    """heyoka's batches, of as many lanes as the processor has."""
    import heyoka as hy

    width = hy.recommended_simd_size()
    states = np.resize(starts.rows, (-(-starts.count // width) * width, 6))
    grid = np.repeat(starts.grid[:, None], width, axis=1)
    one = hy.taylor_adaptive_batch(starts.hand.taylor, states[:width].T.copy(), tol=tol)
    found = []
    for place in range(0, len(states), width):
        one.set_time(0.0)
        one.state[:] = states[place : place + width].T
        found.append(one.propagate_grid(grid)[-1])
    return np.array([
        starts.outputs(load[:, :, lane]) for load in found for lane in range(width)
    ][: starts.count])  # fmt: skip


def _one_by_one(starts: Starts, tol: float, real: Any = float) -> np.ndarray:
    import heyoka as hy

    one = hy.taylor_adaptive(starts.hand.taylor, np.zeros(6, real), fp_type=real, tol=real(tol))
    found = []
    for state in starts.rows:
        one.time, one.state[:] = real(0), state
        found.append(starts.outputs(one.propagate_grid(starts.grid.astype(real))[-1]))
    return np.array(found, dtype=float)


def _numba(starts: Starts, tol: float) -> np.ndarray:
    advance, constants = _integrator()
    rows = np.empty((starts.count, INSTANTS, 6))
    for state, place in zip(starts.rows, rows, strict=True):
        advance(starts.grid, state, constants, tol, place)
    return np.array([starts.outputs(each) for each in rows])


@cache
def _integrator() -> tuple[Any, np.ndarray]:
    """DOP853 and the program by hand, compiled together, and the values of its parameters."""
    right, constants = Starts(1, SPAN).hand.source()
    return compiled_dop853(right, 6, False), constants


def _scipy(starts: Starts, tol: float) -> np.ndarray:
    from scipy.integrate import solve_ivp

    right, grid = starts.hand.right(), starts.grid
    options = {"t_eval": grid, "rtol": tol, "atol": tol}
    return np.array([
        starts.outputs(solve_ivp(right, (0, grid[-1]), state, "DOP853", **options).y.T)
        for state in starts.rows
    ])  # fmt: skip


def many(page: Path, extent: Extent) -> str:
    """Time a start against the number of starts, drawn beside the page, and the table."""
    span = SPAN * max(extent.spans, 0.1)
    loops: Mapping[str, Loop] = {
        "whole call of ensemble": partial(_ensemble, vo.derive(vo.load("ball-on-sphere"))),
        "heyoka by hand, in lanes": _lanes,
        "heyoka by hand, one by one": _one_by_one,
        "DOP853 in numba, by hand": _numba,
        "scipy's DOP853, lambdify by hand": _scipy,
    }
    lines = {name: _line(name, loop, span, extent) for name, loop in loops.items()}
    table.picture(
        lines, ("number of starts", "microseconds of CPU a start"),
        f"Ball on a sphere, T = {span:g}, error {ERROR:g}", page, "many",
    )  # fmt: skip
    head = ("microseconds a start", *(f"{count}" for count in extent.starts))
    return table.markdown(head, (
        (name, *(_text(dict(zip(*line, strict=True)).get(n)) for n in extent.starts))
        for name, line in lines.items()
    ))  # fmt: skip


def _text(time: float | None) -> str:
    return "" if time is None else f"{time:.0f}" if time >= 100 else f"{time:.3g}"


def _line(name: str, loop: Loop, span: float, extent: Extent) -> tuple[list[int], list[float]]:
    """Numbers of starts, and microseconds of each, at the coarsest tolerance that is good."""
    sample = Starts(SAMPLE, span)
    exact = _one_by_one(sample, 1e-18, np.longdouble)
    tol = next(
        (tol for tol in TOLERANCES if np.median(_apart(loop(sample, tol), exact)) <= ERROR),
        TOLERANCES[-1],
    )
    counts = [n for n in extent.starts if n <= SLOW or "scipy" not in name]
    times = []
    for count in counts:
        starts = Starts(count, span)
        _ = starts.rows, starts.spins  # drawn before the clock starts
        turns = max(1, min(extent.rounds, 1000 // count))
        times.append(1e6 * min(clock(partial(loop, starts, tol))[1] for _ in range(turns)) / count)
    return counts, times


def _apart(found: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """The largest error of each motion: values are (motions, k, 6)."""
    return np.asarray(np.abs(found - exact).max(axis=(1, 2)))

"""Rows of the table of figures: many motions, and long ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from time import process_time
from typing import Any

import numpy as np

import voronec as vo
from figures.peers import Formulation, by_hand, reduction
from figures.problems import Extent
from figures.race import OneRun, Race, clock, race
from figures.table import Row
from voronec.accuracy.bench import ReferenceProblem, scene_problem

__all__ = ["ROWS"]

BALL = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
ERROR = 1e-9
TOLS = (1e-9, 1e-10, 1e-11, 1e-12)
PYTHON = (1e-11, 1e-12, 1e-13, 3e-14)
WAYS = {
    "by hand": "(G, gamma) by hand, `lambdify` to `math` with `cse`",
    "written out": "(gamma, omega), no mass matrix, `lambdify` to `math`, `cse`",
    "plain": "the same equations, `lambdify` with nothing else said",
}


def _formulation(kind: str, problem: ReferenceProblem) -> Formulation:
    """The ball on a sphere by hand, or as the engine reduced it."""
    return by_hand(problem) if kind == "by hand" else reduction(problem, "invariants", kind)


def _values(form: Formulation, rows: np.ndarray) -> np.ndarray:
    """gamma and omega (k, 6) of states (k, n)."""
    known = form.back(rows)
    return np.stack([known[n] for n in BALL], axis=-1)


def drift(extent: Extent) -> Iterator[Row]:
    """Every integral over T = 1e5, from several starts."""
    ball = vo.derive(vo.load("ball-on-sphere"))
    names = tuple(ball.system.integrals)
    spans = tuple(extent.long * share for share in (1e-3, 1e-2, 1e-1, 1.0))
    changes = {name: np.zeros((8, len(spans))) for name in names}
    dice = np.random.default_rng(5)
    for row in range(8):
        spin = dict(zip(BALL[3:], dice.normal(size=3), strict=True))
        motion = vo.integrate(
            ball, times=np.linspace(0, spans[-1], 20_001), outputs=(*names, *BALL),
            initial={"u": 2, "theta": 1, "u1": 1, **spin}, method="heyoka", tol=1e-16,
        )  # fmt: skip
        for name in names:
            apart = np.abs(motion[name] / motion[name][0] - 1)
            changes[name][row] = [apart[motion.t <= span].max() for span in spans]
    worst = max(float(c[:, -1].max()) for c in changes.values())
    growth = {}
    for name, change in changes.items():
        typical = np.log(np.maximum(change, 1e-17)).mean(axis=0)  # over the starts
        growth[name] = float(np.polyfit(np.log(spans), typical, 1)[0])
    said = ", ".join(f"{name} t^{power:.2f}" for name, power in growth.items())
    yield Row(
        f"T = {extent.long:g}, every integral of the ball on a sphere, 8 starts, tolerance 1e-16",
        "relative drift under 1e-12, growing no faster than t^0.6",
        f"{worst:.1e} at worst; {said}",
        worst < 1e-12 and max(growth.values()) <= 0.6,
        "rounding errors of one start are a random walk, and a fit over few starts is rough",
    )


def ensembles(extent: Extent) -> Iterator[Row]:
    """A thousand starts on one core, against a loop over scipy."""
    end, dice = extent.many, np.random.default_rng(2)
    grid = np.linspace(0, end, 11)
    ball = vo.derive(vo.load("ball-on-sphere"))
    spins = {name: 1 + 0.3 * dice.normal(size=extent.starts) for name in BALL[3:]}
    problem, count = scene_problem(ball, time=end), extent.starts
    hand = by_hand(problem)
    exact = _in_long_doubles(hand, spins, grid)
    rough = _apart(_ensemble(ball, spins, grid, TOLS[0])[0], exact)
    few = np.argsort(rough)[[count // 4, count // 2, 3 * count // 4]]
    worst: dict[float, float] = {}

    def ours(tol: float) -> OneRun:
        found, seconds = _ensemble(ball, spins, grid, tol)
        apart = _apart(found, exact)
        worst[tol] = float(apart.max())
        return OneRun(float(np.median(apart)), seconds)

    starts = [{**hand.values, **{n: x[i] for n, x in spins.items()}} for i in few]
    runs: dict[str, Callable[[float], OneRun]] = {"ours": ours}
    runs |= {k: partial(_loop, _formulation(k, problem), starts, grid, exact[few]) for k in WAYS}
    tols = {"ours": TOLS, **dict.fromkeys(WAYS, PYTHON)}
    first = {name: {tol: run(tol) for tol in tols[name]} for name, run in runs.items()}
    found = race(runs, first, (ERROR,), extent.rounds)
    good = max((tol for tol in TOLS if first["ours"][tol].error <= ERROR), default=TOLS[-1])
    said = (
        f"of all starts at tolerance {good:g} the middle error is "
        f"{first['ours'][good].error:.1e}, the largest {worst[good]:.1e}"
    )
    yield from _ensemble_rows(found, extent, said)


def _ensemble_rows(found: Race, extent: Extent, said: str) -> Iterator[Row]:
    """The rows of an ensemble against each loop; ``said`` is what is told of our errors."""
    end, count = extent.many, extent.starts
    for kind, about in WAYS.items():
        theirs = found.at(kind, ERROR)
        for what, name, asked in (("run", "running", 800), ("whole", "whole call", 600)):
            seconds = found.at("ours", ERROR, what)
            ratio = theirs.over(seconds).times_factor(count)
            yield Row(
                f"ensemble of {count} starts, T = {end:g}, error {ERROR:g} in the middle, one "
                f"core, {name}, against a loop over scipy's DOP853 (over three starts, the "
                f"quartiles by our error): {about}",
                f"{asked} times faster",
                f"{ratio.times()}; {theirs.median:.3g} s / "
                f"{1e3 * seconds.median / count:.3g} ms per start; {said}",
                ratio.median >= asked,
                "eight lanes of one core give about three times the speed of one motion",
            )


def _in_long_doubles(
    hand: Formulation, spins: dict[str, np.ndarray], grid: np.ndarray
) -> np.ndarray:
    """States (starts, k, 6) of all starts by the program by hand, in numbers of 64 bits of
    mantissa."""
    import heyoka as hy

    real = np.longdouble
    one = hy.taylor_adaptive(hand.taylor, np.zeros(6, real), fp_type=real, tol=real(1e-18))
    rows = []
    for i in range(len(spins[BALL[3]])):
        one.time = real(0)
        one.state[:] = hand.start({**hand.values, **{n: x[i] for n, x in spins.items()}})
        rows.append(_values(hand, one.propagate_grid(grid.astype(real))[-1]))
    return np.array(rows, dtype=float)


def _ensemble(
    ball: Any, spins: dict[str, np.ndarray], grid: np.ndarray, tol: float
) -> tuple[np.ndarray, dict[str, float]]:
    """States of all starts (starts, k, 6), CPU time of the running, and of everything.

    The running is told from set-up by the reports of progress.
    """
    told: list[tuple[float, float]] = []
    found, whole = clock(
        lambda: vo.ensemble(
            ball, spins, times=grid, outputs=BALL, scene="default", tol=tol, method="heyoka",
            progress=partial(_note, told),
        )
    )  # fmt: skip
    return np.stack([found[n] for n in BALL], axis=-1), {"run": _pace(told), "whole": whole}


def _pace(told: list[tuple[float, float]]) -> float:
    """CPU seconds of all the way, from reports of progress."""
    (first, then), (last, now) = told[0], told[-1]
    return (now - then) / (last - first) if last > first else np.nan


def _note(told: list[tuple[float, float]], part: float) -> None:
    told.append((part, process_time()))


def _apart(found: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """The largest error of each motion: values are (motions, k, 6)."""
    return np.asarray(np.abs(found - exact).max(axis=(1, 2)))


def _loop(
    form: Formulation,
    starts: list[dict[str, float]],
    grid: np.ndarray,
    exact: np.ndarray,
    tol: float,
) -> OneRun:
    """scipy on a few starts: the middle error, and seconds for one."""
    from scipy.integrate import solve_ivp

    right, options = form.right(), {"t_eval": grid, "rtol": tol, "atol": tol}
    rows, seconds = clock(
        lambda: [
            solve_ivp(right, (0, grid[-1]), form.start(values), "DOP853", **options).y.T
            for values in starts
        ]
    )
    apart = _apart(np.array([_values(form, each) for each in rows]), exact)
    return OneRun(float(np.median(apart)), {"run": seconds / len(starts)})


CROSSINGS = 100
"""Over so many crossings errors are compared."""


def sections(extent: Extent) -> Iterator[Row]:
    """Points per second where gamma1 = 0, of one motion, and of four at once."""
    ball = vo.derive(vo.load("ball-on-sphere"))
    exact = _crossings(ball, 1e-16, CROSSINGS, 1)
    found_at = {tol: _crossings(ball, tol, CROSSINGS, 1).points for tol in TOLS}
    errors = {tol: float(np.abs(found - exact.points).max()) for tol, found in found_at.items()}

    def ours(starts: int, tol: float) -> OneRun:
        return OneRun(errors[tol], _seconds_a_point(ball, tol, starts, extent.crossings))

    problem = scene_problem(ball, time=float(exact.t[-1]))
    names = {4: "four motions at once", 1: "one motion"}
    events = {kind: partial(_events, _formulation(kind, problem), exact) for kind in WAYS}
    runs: dict[str, Any] = {names[n]: partial(ours, n) for n in names} | events
    tols = {**dict.fromkeys(names.values(), TOLS), **dict.fromkeys(WAYS, PYTHON)}
    found = race(
        runs,
        {name: {tol: run(tol) for tol in tols[name]} for name, run in runs.items()},
        (ERROR,),
        extent.rounds,
    )
    for kind, about in WAYS.items():
        theirs = found.at(kind, ERROR)
        for name in names.values():
            seconds, whole = (found.at(name, ERROR, what) for what in ("run", "whole"))
            ratio = theirs.over(seconds)
            yield Row(
                f"section points of the ball on a sphere, gamma1 = 0, {name}, error {ERROR:g} "
                f"over {CROSSINGS} crossings, against scipy's events: {about}",
                "200 times as many a second",
                f"{ratio.times()}; {1 / seconds.median:.3g} / {1 / theirs.median:.3g} a second; "
                f"whole call for {extent.crossings} points {theirs.over(whole).times()}",
                ratio.median >= 200,
                "heyoka's steps, and the record of their series, take seven tenths of the time of "
                "one motion; most of the rest is the search, on the polynomials of many steps",
            )


def _crossings(ball: Any, tol: float, crossings: int, starts: int, progress: Any = None) -> Any:
    spins = {"omega1": 0.5 + 0.1 * np.arange(starts)}
    return vo.section(
        ball, "gamma1", BALL, scene="default", starts=spins, crossings=crossings, tol=tol,
        method="heyoka", progress=progress,
    )  # fmt: skip


def _seconds_a_point(ball: Any, tol: float, starts: int, crossings: int) -> dict[str, float]:
    """CPU time of a point: without set-up, between the first report of progress and the last, and
    in a whole call."""
    told: list[tuple[float, float]] = []
    _, whole = clock(
        lambda: _crossings(ball, tol, crossings // starts, starts, partial(_note, told))
    )
    return {"run": _pace(told) / crossings, "whole": whole / crossings}


def _events(form: Formulation, exact: Any, tol: float) -> OneRun:
    """scipy's events over the same crossings: seconds a point."""
    from scipy.integrate import solve_ivp

    right, start = form.right(), form.start(form.values)
    # gamma1 is one entry of the state
    (place,) = np.nonzero(form.back(np.eye(len(start)))["gamma1"])[0]

    def event(_t: float, y: np.ndarray) -> float:
        return float(y[place])

    event.direction = 1  # type: ignore[attr-defined]
    span, options = (0.0, float(exact.t[-1]) + 1e-3), {"rtol": tol, "atol": tol}
    found, seconds = clock(lambda: solve_ivp(right, span, start, "DOP853", events=event, **options))
    rows = found.y_events[0][-len(exact.t) :]
    error = np.inf  # where a crossing is not found
    if len(rows) == len(exact.t):
        error = float(np.abs(_values(form, rows) - exact.points).max())
    return OneRun(error, {"run": seconds / len(exact.t)})


ROWS: dict[str, Callable[[Extent], Iterator[Row]]] = {
    "drift": drift,
    "ensembles": ensembles,
    "sections": sections,
}

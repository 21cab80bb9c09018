"""Rows of the table of figures: many motions, and long ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from time import process_time
from typing import Any

import numpy as np

import voronec as vo
from figures.extent import Extent
from figures.table import Row
from voronec.accuracy.bench import ask, at_error
from voronec.accuracy.bench.level import level
from voronec.accuracy.bench.peers.hand_programs import BY_HAND, right_side, start_values
from voronec.accuracy.bench.peers.scipy_lambdify import RIGHT_SIDES
from voronec.accuracy.bench.question import BenchMotion

__all__ = ["ROWS"]

BALL = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
ERROR = 1e-9
FEW = 3
"""So many starts stand for all of them in the loop over scipy."""
TOLS = (1e-9, 1e-10, 1e-11, 1e-12)
PYTHON = (1e-11, 1e-12, 1e-13, 3e-14)
WAYS = {
    "by hand": "(G, gamma) by hand, `lambdify` to `math` with `cse`",
    "written out": "(gamma, omega), no mass matrix, `lambdify` to `math`, `cse`",
    "plain": "the same equations, `lambdify` with nothing else said",
}


@dataclass(frozen=True)
class Peer:
    """Equations given to scipy's DOP853: ``start`` takes values by name to a state (n,), ``back``
    states (k, n) to gamma and omega (k, 6); gamma1 is the state's entry ``place``."""

    right: Callable[[float, np.ndarray], Any]
    start: Callable[[Mapping[str, float]], np.ndarray]
    back: Callable[[np.ndarray], np.ndarray]
    place: int

    @classmethod
    def of(cls, kind: str, question: BenchMotion) -> Peer:
        """The ball on a sphere by hand, or as the engine reduced it."""
        if kind == "by hand":
            program = BY_HAND[question.system.name](question.parameters)
            return cls(
                right_side(program),
                program.start,
                lambda rows: np.stack([program.back(rows)[n] for n in BALL], axis=-1),
                3,
            )
        at = level(question, "invariants")
        names = [str(s) for s in at.field.variables]
        order = [names.index(n) for n in BALL]
        return cls(
            RIGHT_SIDES[kind](at),
            lambda values: np.array([values[n] for n in names]),
            lambda rows: rows[..., order],
            names.index("gamma1"),
        )


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
    exact = _ensemble(ball, {n: x[:FEW] for n, x in spins.items()}, grid, 1e-16)[0]
    pairs, whole = [], np.inf
    for tol in TOLS:
        found, running, all_of_it = _ensemble(ball, spins, grid, tol)
        pairs.append((_apart(found, exact), running))
        if pairs[-1][0] <= ERROR:
            whole = min(whole, all_of_it)
    ours, count = at_error(pairs, ERROR).seconds or np.nan, extent.starts
    question = ask(ball, time=end)
    for kind, about in WAYS.items():
        theirs = at_error(_loop(question, kind, spins, grid, exact), ERROR).seconds or np.nan
        for what, seconds, asked in (("running", ours, 800), ("whole call", whole, 600)):
            ratio = theirs * count / FEW / seconds
            yield Row(
                f"ensemble of {count} starts, T = {end:g}, error {ERROR:g}, one core, {what}, "
                f"against a loop over scipy's DOP853 (timed over {FEW} starts): {about}",
                f"{asked} times faster",
                f"{ratio:.0f} times ({theirs / FEW:.3g} s / {1e3 * seconds / count:.3g} ms per "
                "start)",
                bool(ratio >= asked),
                "eight lanes of one core give about three times the speed of one motion",
            )


def _ensemble(
    ball: Any, spins: dict[str, np.ndarray], grid: np.ndarray, tol: float
) -> tuple[np.ndarray, float, float]:
    """States of the first few starts (few, k, 6), CPU time of the running, and of everything.

    The running is told from set-up by the reports of progress.
    """
    told: list[tuple[float, float]] = []
    best, whole = np.inf, np.inf
    for _ in range(2 if len(spins["omega1"]) > FEW else 1):
        told.clear()
        began = process_time()
        found = vo.ensemble(
            ball, spins, times=grid, outputs=BALL, scene="default", tol=tol, method="heyoka",
            progress=partial(_note, told),
        )  # fmt: skip
        whole = min(whole, process_time() - began)
        (first, then), (last, now) = told[0], told[-1]
        best = min(best, (now - then) / (last - first) if last > first else np.nan)
    return np.stack([found[n][:FEW] for n in BALL], axis=-1), best, whole


def _note(told: list[tuple[float, float]], part: float) -> None:
    told.append((part, process_time()))


def _apart(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(found - exact).max())


def _loop(
    question: BenchMotion, kind: str, spins: dict[str, np.ndarray], grid: np.ndarray,
    exact: np.ndarray,
) -> list[tuple[float, float]]:  # fmt: skip
    """(error, CPU seconds) of scipy on a few starts, at several tolerances; the best of three
    loops, since a single one has taken twice as long by chance."""
    from scipy.integrate import solve_ivp

    peer, pairs, usual = Peer.of(kind, question), [], start_values(question)
    starts = [peer.start({**usual, **{n: x[i] for n, x in spins.items()}}) for i in range(FEW)]
    for tol in PYTHON:
        seconds, options = np.inf, {"t_eval": grid, "rtol": tol, "atol": tol}
        for _ in range(3):
            began = process_time()
            rows = [
                solve_ivp(peer.right, (0, grid[-1]), y, "DOP853", **options).y.T for y in starts
            ]
            seconds = min(seconds, process_time() - began)
        pairs.append((_apart(np.array([peer.back(each) for each in rows]), exact), seconds))
    return pairs


CROSSINGS = 100
"""Over so many crossings errors are compared."""


def sections(extent: Extent) -> Iterator[Row]:
    """Points per second where gamma1 = 0, of one motion, and of four at once."""
    ball = vo.derive(vo.load("ball-on-sphere"))
    exact = _crossings(ball, 1e-16, CROSSINGS, 1)
    pairs: dict[int, list[tuple[float, float]]] = {1: [], 4: []}
    for tol in TOLS:
        found = _crossings(ball, tol, CROSSINGS, 1)
        error = float(np.abs(found.points - exact.points).max())
        for starts in pairs:
            pairs[starts].append((error, _seconds_a_point(ball, tol, starts, extent.crossings)))
    ours = {n: at_error(p, ERROR).seconds or np.nan for n, p in pairs.items()}
    question = ask(ball, time=float(exact.t[-1]))
    for kind, about in WAYS.items():
        theirs = at_error(_events(question, kind, exact), ERROR).seconds or np.nan
        for starts, name in ((4, "four motions at once"), (1, "one motion")):
            ratio = theirs / ours[starts]
            yield Row(
                f"section points of the ball on a sphere, gamma1 = 0, {name}, error {ERROR:g} "
                f"over {CROSSINGS} crossings, against scipy's events: {about}",
                "200 times as many a second",
                f"{ratio:.0f} times ({1 / ours[starts]:.3g} / {1 / theirs:.3g} a second)",
                bool(ratio >= 200),
                "a crossing is sought in Python on the polynomials of many steps at once, which "
                "costs as much as the steps",
            )


def _crossings(ball: Any, tol: float, crossings: int, starts: int, progress: Any = None) -> Any:
    spins = {"omega1": 0.5 + 0.1 * np.arange(starts)}
    return vo.section(
        ball, "gamma1", BALL, scene="default", starts=spins, crossings=crossings, tol=tol,
        method="heyoka", progress=progress,
    )  # fmt: skip


def _seconds_a_point(ball: Any, tol: float, starts: int, crossings: int) -> float:
    """CPU time of a point, without set-up: between the first report of progress and the last."""
    best = np.inf
    for _ in range(2):
        told: list[tuple[float, float]] = []
        note = partial(_note, told)
        _crossings(ball, tol, crossings // starts, starts, note)
        (first, then), (last, now) = told[0], told[-1]
        best = min(best, (now - then) / ((last - first) * crossings))
    return best


def _events(question: BenchMotion, kind: str, exact: Any) -> list[tuple[float, float]]:
    """(error, CPU seconds a point) of scipy's events over the same crossings."""
    from scipy.integrate import solve_ivp

    peer, pairs = Peer.of(kind, question), []
    start = peer.start(start_values(question))

    def event(_t: float, y: np.ndarray) -> float:
        return float(y[peer.place])

    event.direction = 1  # type: ignore[attr-defined]
    span = (0.0, float(exact.t[-1]) + 1e-3)
    for tol in PYTHON:
        began = process_time()
        found = solve_ivp(peer.right, span, start, "DOP853", events=event, rtol=tol, atol=tol)
        seconds = process_time() - began
        rows = found.y_events[0][-len(exact.t) :]
        if len(rows) == len(exact.t):
            pairs.append((_apart(peer.back(rows), exact.points), seconds / len(rows)))
    return pairs


ROWS: dict[str, Callable[[Extent], Iterator[Row]]] = {
    "drift": drift,
    "ensembles": ensembles,
    "sections": sections,
}

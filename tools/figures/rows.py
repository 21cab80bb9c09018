"""Rows of the table of figures: one motion, method against method at equal error."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

import voronec as vo
from figures.extent import Extent
from figures.table import Row
from voronec.accuracy.bench import (
    Bench,
    BenchMotion,
    BenchReference,
    Point,
    ask,
    difference,
    measure,
    reference,
)
from voronec.accuracy.bench.peers.hand_programs import BY_HAND, start_values
from voronec.accuracy.bench.runs import contenders

__all__ = ["ROWS", "ball", "measured", "rows_of"]

ERRORS = (1e-6, 1e-9)
LONG = 2.0
"""CPU seconds of a run above which it is not measured again: noise is small beside it."""
DOP853 = (1e-10, 1e-11, 1e-13, 3e-14)
"""Tolerances at which DOP853's errors at T = 1000 lie around 1e-6 and 1e-9."""


def rows_of(measurement: Callable[..., Iterator[Row]], *arguments: Any) -> list[Row]:
    """The rows of one measurement; what stops it is a missed row, and the others go on."""
    try:
        return list(measurement(*arguments))
    except (vo.VoronecError, ImportError, OSError, ValueError) as error:
        return [Row(measurement.__name__, "to be measured", f"it failed: {error}", False)]


@cache
def ball(extent: Extent) -> tuple[BenchMotion, BenchReference]:
    """The ball on a sphere, and its motion by two independent runs."""
    question = ask(vo.load("ball-on-sphere"), time=extent.span)
    return question, reference(question, 1e-12)


@cache
def measured(name: str, extent: Extent) -> Any:
    """One method on the ball, at its own tolerances, or those that matter of a slow one."""
    question, exact = ball(extent)
    chosen = DOP853 if "lambdify" in name else ()
    return measure(question, [name], chosen, budget=60.0, against=exact)[name]


def around(names: Iterable[str], errors: Iterable[float], extent: Extent) -> Bench:
    """Methods on the ball, those runs measured again in turn that lie around the errors."""
    question, exact = ball(extent)
    found = {name: measured(name, extent) for name in names}
    runs = {}
    for name in found:
        (contender,) = contenders([name])
        runs[name] = contender.prepare(question)
    best: dict[tuple[str, float], Point] = {}
    for _ in range(extent.rounds):
        for name, one in found.items():
            for p in _bracketing(one.good, errors):
                if p.per_unit * question.span < LONG:
                    seconds = runs[name](p.setting).seconds / question.span
                    key = (name, p.setting)
                    if key not in best or seconds < best[key].per_unit:
                        best[key] = replace(p, per_unit=seconds)
    methods = [
        replace(
            one,
            points=tuple(best.get((name, p.setting), p) for p in _bracketing(one.good, errors)),
        )
        for name, one in found.items()
    ]
    return Bench(question, exact, tuple(methods), {})


def _bracketing(points: list[Point], errors: Iterable[float]) -> list[Point]:
    """The runs next to the errors on either side."""
    kept = set()
    for error in errors:
        worse = [p for p in points if p.error > error]
        better = [p for p in points if p.error <= error]
        kept |= {min(worse, key=lambda p: p.error).setting} if worse else set()
        kept |= {min(better, key=lambda p: p.per_unit).setting} if better else set()
        kept |= {max(better, key=lambda p: p.error).setting} if better else set()
    return [p for p in points if p.setting in kept]


def _ratio(bench: Bench, slow: str, error: float, factor: float, row: str, why: str) -> Row:
    times = [bench[name].at(error).seconds for name in (slow, "heyoka")]
    ratio = bench.ratio(slow, "heyoka", error)
    if times[0] is None and times[1] is not None:
        alone = f"alone: the peer does not reach it ({1e6 * times[1]:.3g} µs per unit of time)"
        return Row(row, f"{factor:g} times faster", alone, True, why)
    if times[0] is None or times[1] is None:
        return Row(row, f"{factor:g} times faster", "that error is not reached", False, why)
    micro = [1e6 * x for x in times if x is not None]
    reached = f"{ratio:.3g} times ({micro[0]:.3g} / {micro[1]:.3g} µs per unit of time)"
    return Row(row, f"{factor:g} times faster", reached, ratio >= factor, why)


PEERS = {
    "dop853-by-hand": "(G, gamma) by hand, `lambdify` to `math` with `cse`",
    "dop853-lambdify-invariants": "(gamma, omega), no mass matrix, `lambdify` to `math`, `cse`",
    "dop853-lambdify-invariants-plain": "the same equations, `lambdify` with nothing else said",
    "dop853-lambdify-coordinates": "equations in Euler angles, `lambdify` with `cse`, "
    "`numpy.linalg.solve`",
}


def lambdify(extent: Extent) -> Iterator[Row]:
    """scipy's DOP853 with SymPy's lambdify, written by a good hand and by others."""
    bench = around(["heyoka", *PEERS], ERRORS, extent)
    for name, about in PEERS.items():
        for error, factor in zip(ERRORS, (500, 600), strict=True):
            yield _ratio(
                bench, name, error, factor,
                f"against scipy DOP853 at error {error:g}: {about}",
                "a peer that writes out what the engine found, on plain floats, is the fastest "
                "Python there is; the Taylor method saves least at coarse errors",
            )  # fmt: skip


def numba(extent: Extent) -> Iterator[Row]:
    """DOP853 compiled by numba."""
    names = {"dop853-numba": "SymPy's right-hand side", "dop853-numba-ours": "our program"}
    errors = {1e-9: 1.2, 1e-11: 1.0}
    bench = around(["heyoka", *names], errors, extent)
    for name, about in names.items():
        for error, factor in errors.items():
            yield _ratio(
                bench, name, error, factor,
                f"against DOP853 compiled by numba at error {error:g}: {about}",
                "both run machine code; the peer is our own compiled DOP853 with its stages "
                "written out; the best program by hand does little better here, so this is what "
                "Taylor's method has over DOP853 at this error",
            )  # fmt: skip


def by_hand(extent: Extent) -> Iterator[Row]:
    """heyoka by hand at equal error, as `integrate` runs, checks of the mass matrix included."""
    bench = around(["heyoka", "heyoka-by-hand"], ERRORS, extent)
    for error in ERRORS:
        ratio = bench.ratio("heyoka", "heyoka-by-hand", error)
        ours, hand = (
            1e6 * (bench[n].at(error).seconds or np.nan) for n in ("heyoka", "heyoka-by-hand")
        )
        yield Row(
            f"run of `integrate` against heyoka by hand in (G, gamma) at error {error:g}",
            "at most 1.0 times its time",
            f"{ratio:.2f} times ({ours:.3g} / {hand:.3g} µs per unit of time)",
            bool(ratio <= 1.0),
            "both take the same steps; as bare programs they are within a tenth of each other, "
            "and a run also looks whether the mass matrix is regular and the first step short "
            "enough, and hands arrays on, which takes a tenth of a millisecond however long it is",
        )


def finest(extent: Extent) -> Iterator[Row]:
    """How small the error becomes, and what the rounding of the start alone does."""
    question, exact = ball(extent)
    ours = min(measured("heyoka", extent).good, key=lambda p: p.error)
    hand = BY_HAND["ball-on-sphere"](question.parameters)
    start = hand.start(start_values(question))

    def rows(state: np.ndarray, tol: float) -> np.ndarray:
        import heyoka as hy

        made = hy.taylor_adaptive(hand.equations, state.tolist(), tol=tol, high_accuracy=True)
        return np.array(made.propagate_grid(question.grid)[-1])

    def apart(found: np.ndarray) -> float:
        values = hand.back(found)
        return max(
            float(difference(values[n], exact.values[n], False).max()) for n in question.outputs
        )

    theirs = min(apart(rows(start, tol)) for tol in (1e-14, 1e-15, 1e-16))
    usual, beside = rows(start, 1e-16), rows(start + np.spacing(start), 1e-16)
    moved = float(np.abs(beside - usual).max())
    yield Row(
        f"smallest error at T = {question.span:g}",
        "1e-12",
        f"{ours.error:.1e} at tolerance {ours.setting:g}; by hand with `high_accuracy` "
        f"{theirs:.1e}; one unit in the last place of the start moves the motion by {moved:.1e}",
        ours.error <= 1e-12,
        "numbers of the start are known to a unit in their last place, and the motion carries "
        "that further than 1e-12: no program in doubles gets below it but by chance, and more "
        "digits take another kind of numbers (`method='flint'`)",
    )


def without_heyoka(extent: Extent) -> Iterator[Row]:
    """The method `numba`, at equal error."""
    bench = around(["heyoka", "numba"], ERRORS[1:], extent)
    ratio = bench.ratio("numba", "heyoka", 1e-9)
    times = [1e6 * (bench[n].at(1e-9).seconds or np.nan) for n in ("numba", "heyoka")]
    yield Row(
        "run of method `numba` against method `heyoka` at error 1e-09",
        "at most 1.3 times its time",
        f"{ratio:.2f} times ({times[0]:.3g} / {times[1]:.3g} µs per unit of time)",
        bool(ratio <= 1.3),
        "DOP853 takes many more steps at such an error",
    )


def mujoco(extent: Extent) -> Iterator[Row]:
    """MuJoCo's best settings on the ball on a plane."""
    question = ask(vo.load("chaplygin-ball"), time=extent.many, instants=11)
    exact = reference(question, 1e-12)
    bench = measure(question, ["heyoka", "mujoco-best"], budget=10.0, against=exact)
    times = [bench[n].at(1e-6, n.startswith("m")) for n in ("mujoco-best", "heyoka")]
    ratio = (times[0].seconds or np.nan) / (times[1].seconds or np.nan)
    yield Row(
        "against MuJoCo's best setting at error 1e-6, ball on a plane, T = 100",
        "5000 times faster",
        f"{ratio:.0f} times ({1e6 * (times[0].seconds or np.nan):.3g} µs, {times[0].kind}, / "
        f"{1e6 * (times[1].seconds or np.nan):.3g} µs per unit of time)",
        bool(ratio >= 5000),
        "at such an error only; MuJoCo solves a more general problem",
    )


ROWS: dict[str, Callable[[Extent], Iterator[Row]]] = {
    "by-hand": by_hand,
    "finest": finest,
    "without-heyoka": without_heyoka,
    "lambdify": lambdify,
    "numba": numba,
    "mujoco": mujoco,
}

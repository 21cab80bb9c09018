"""Rows of the table of figures: one motion, method against method at equal error."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Any

import numpy as np

import voronec as vo
from figures.extent import Extent
from figures.race import OneRun, Race, Spread, clock, race
from figures.table import Row
from voronec.accuracy.bench import (
    Measured,
    ReferenceProblem,
    ReferenceSolution,
    ask,
    difference,
    measure,
    reference,
)
from voronec.accuracy.bench.peers.hand_programs import BY_HAND, start_values
from voronec.accuracy.bench.runs import contenders
from voronec.motion.methods import METHODS

__all__ = ["ROWS", "ball", "measure_ball", "rows_of"]

ERRORS = (1e-6, 1e-9)
DOP853 = (1e-10, 1e-11, 1e-13, 3e-14)
"""Tolerances at which DOP853's errors at T = 1000 lie around 1e-6 and 1e-9."""


def rows_of(measurement: Callable[..., Iterator[Row]], *arguments: Any) -> list[Row]:
    """The rows of one measurement; what stops it is a missed row, and the others go on."""
    try:
        return list(measurement(*arguments))
    except (vo.VoronecError, ImportError, OSError, ValueError) as error:
        return [Row(measurement.__name__, "to be measured", f"it failed: {error}", False)]


@cache
def ball(extent: Extent) -> tuple[ReferenceProblem, ReferenceSolution]:
    """The ball on a sphere, and its motion by two independent runs."""
    question = ask(vo.load("ball-on-sphere"), time=extent.span)
    return question, reference(question, 1e-12)


@cache
def measure_ball(name: str, extent: Extent) -> Measured:
    """One method on the ball, at its own tolerances, or those that matter of a slow one."""
    question, exact = ball(extent)
    chosen = DOP853 if "lambdify" in name else ()
    return measure(question, [name], chosen, budget=60.0, against=exact)[name]


def around(names: Iterable[str], errors: Iterable[float], extent: Extent) -> Race:
    """Methods on the ball in turn, at the errors; ours in whole calls too."""
    question, _ = ball(extent)
    known = {name: measure_ball(name, extent) for name in names}
    return race(
        {name: _runs(question, one) for name, one in known.items()},
        {name: _first(question, one) for name, one in known.items()},
        errors,
        extent.rounds,
    )


def _first(question: ReferenceProblem, one: Measured) -> dict[float, OneRun]:
    return {p.setting: OneRun(p.error, {"run": p.per_unit * question.span}) for p in one.good}


def _runs(question: ReferenceProblem, one: Measured) -> Callable[[float], OneRun]:
    """One method, run again at settings whose errors are known."""
    (contender,) = contenders([one.name])
    run, errors = contender.prepare(question), {p.setting: p.error for p in one.good}
    outputs = [question.expressions[n] for n in question.outputs]

    def once(tol: float) -> OneRun:
        seconds = {"run": run(tol).seconds}
        if one.name in METHODS:
            seconds["whole"] = clock(
                lambda: vo.integrate(
                    question.equations, question.bare, times=question.grid, outputs=outputs,
                    method=one.name, tol=tol,
                )
            )[1]  # fmt: skip
        return OneRun(errors[tol], seconds)

    return once


def _micro(spread: Spread, span: float) -> str:
    """Seconds of a run as microseconds per unit of time."""
    return f"{1e6 * spread.median / span:.3g}"


def _ratio(
    found: Race, slow: str, error: float, factor: float, row: str, why: str, span: float
) -> Row:
    theirs, ours = found.at(slow, error), found.at("heyoka", error)
    asked = f"{factor:g} times faster"
    if not ours.values:
        return Row(row, asked, "that error is not reached", False, why)
    if not theirs.values:
        alone = f"alone: the peer does not reach it ({_micro(ours, span)} µs per unit of time)"
        return Row(row, asked, alone, True, why)
    ratio, whole = theirs.over(ours), found.at("heyoka", error, "whole")
    reached = (
        f"{ratio.times()}; {_micro(theirs, span)} / {_micro(ours, span)} µs per unit of time; "
        f"whole call {theirs.over(whole).times()}"
    )
    return Row(row, asked, reached, ratio.median >= factor, why)


PEERS = {
    "dop853-by-hand": "(G, gamma) by hand, `lambdify` to `math` with `cse`",
    "dop853-lambdify-invariants": "(gamma, omega), no mass matrix, `lambdify` to `math`, `cse`",
    "dop853-lambdify-invariants-plain": "the same equations, `lambdify` with nothing else said",
    "dop853-lambdify-coordinates": "equations in Euler angles, `lambdify` with `cse`, "
    "`numpy.linalg.solve`",
}


def lambdify(extent: Extent) -> Iterator[Row]:
    """scipy's DOP853 with SymPy's lambdify, written by a good hand and by others."""
    found = around(["heyoka", *PEERS], ERRORS, extent)
    for name, about in PEERS.items():
        for error, factor in zip(ERRORS, (500, 600), strict=True):
            yield _ratio(
                found, name, error, factor,
                f"against scipy DOP853 at error {error:g}: {about}",
                "a peer that writes out what the engine found, on plain floats, is the fastest "
                "Python there is; the Taylor method saves least at coarse errors",
                extent.span,
            )  # fmt: skip


def numba(extent: Extent) -> Iterator[Row]:
    """DOP853 compiled by numba."""
    names = {
        "dop853-numba": "SymPy's right-hand side",
        "dop853-numba-ours": "our program",
        "dop853-numba-unrolled": "(G, gamma) by hand, scalars unrolled, without fast-math",
        "dop853-numba-fastmath": "(G, gamma) by hand, scalars unrolled, with fast-math",
    }
    errors = {1e-9: 1.2, 1e-11: 1.0}
    found = around(["heyoka", *names], errors, extent)
    for name, about in names.items():
        for error, factor in errors.items():
            yield _ratio(
                found, name, error, factor,
                f"against DOP853 compiled by numba at error {error:g}: {about}",
                "both run machine code, and fast-math gives the peer a tenth: this is what "
                "Taylor's method has over DOP853 at this error",
                extent.span,
            )  # fmt: skip


def by_hand(extent: Extent) -> Iterator[Row]:
    """heyoka by hand at equal error, as `integrate` runs, checks of the mass matrix included."""
    found, span = around(["heyoka", "heyoka-by-hand"], ERRORS, extent), extent.span
    for error in ERRORS:
        ours, hand = (found.at(n, error) for n in ("heyoka", "heyoka-by-hand"))
        ratio, whole = ours.over(hand), found.at("heyoka", error, "whole").over(hand)
        yield Row(
            f"run of `integrate` against heyoka by hand in (G, gamma) at error {error:g}",
            "at most 1.0 times its time",
            f"{ratio.times()}; {_micro(ours, span)} / {_micro(hand, span)} µs per unit of time; "
            f"whole call {whole.times()}",
            ratio.median <= 1.0,
            "both take the same steps; as bare programs they are within a tenth of each other, "
            "and a run also looks whether the mass matrix is regular and the first step short "
            "enough, and hands arrays on, which takes a tenth of a millisecond however long it is",
        )


def finest(extent: Extent) -> Iterator[Row]:
    """How small the error becomes, and what the rounding of the start alone does."""
    question, exact = ball(extent)
    ours = min(measure_ball("heyoka", extent).good, key=lambda p: p.error)
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
    """The methods `numba` and `c`, at equal error."""
    found, span = around(["heyoka", "numba", "c"], ERRORS[1:], extent), extent.span
    other, other_whole = (found.at("heyoka", 1e-9, what) for what in ("run", "whole"))
    for name in ("numba", "c"):
        ours = found.at(name, 1e-9)
        ratio, whole = ours.over(other), found.at(name, 1e-9, "whole").over(other_whole)
        yield Row(
            f"run of method `{name}` against method `heyoka` at error 1e-09",
            "at most 1.3 times its time",
            f"{ratio.times()}; {_micro(ours, span)} / {_micro(other, span)} µs per unit of time; "
            f"whole calls {whole.times()}",
            ratio.median <= 1.3,
            "DOP853 takes many more steps at such an error",
        )


def mujoco(extent: Extent) -> Iterator[Row]:
    """MuJoCo's best settings on the ball on a plane."""
    question = ask(vo.load("chaplygin-ball"), time=extent.many, instants=11)
    exact = reference(question, 1e-12)
    names = ("mujoco-best", "heyoka")
    bench = measure(question, names, budget=10.0, against=exact)
    known = {name: bench[name] for name in names}
    found = race(
        {name: _runs(question, one) for name, one in known.items()},
        {name: _first(question, one) for name, one in known.items()},
        (1e-6,),
        extent.rounds,
    )
    theirs, ours = (found.at(n, 1e-6, extrapolate=n.startswith("m")) for n in names)
    ratio, micro = theirs.over(ours), 1e6 / question.span
    whole = theirs.over(found.at("heyoka", 1e-6, "whole"))
    kind = bench[names[0]].at(1e-6, True).kind
    yield Row(
        "against MuJoCo's best setting at error 1e-6, ball on a plane, T = 100",
        "5000 times faster",
        f"{ratio.times()}; {micro * theirs.median:.3g} µs, {kind}, "
        f"/ {micro * ours.median:.3g} µs per unit of time; whole call {whole.times()}",
        ratio.median >= 5000,
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

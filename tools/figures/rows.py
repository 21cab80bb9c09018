"""Rows of the table of speed: one motion, method against method at equal error."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import product

import numpy as np

import voronec as vo
from figures.peers import by_hand
from figures.problems import Extent, around, exact, measurement, problem
from figures.race import Race, Spread, clock
from figures.table import Row
from voronec.motion.methods import CLOSED_FORM

__all__ = ["ROWS", "large"]

ERRORS = (1e-6, 1e-9)
BALL = "ball on a sphere"


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


def _against(
    extent: Extent, peers: Mapping[str, str], factors: Mapping[float, float], row: str, why: str
) -> Iterator[Row]:
    """heyoka on the ball against peers by name, at errors, each with the factor asked for."""
    found = around(BALL, ["heyoka", *peers], factors, extent)
    for (name, about), (error, factor) in product(peers.items(), factors.items()):
        text = f"{row} at error {error:g}: {about}"
        yield _ratio(found, name, error, factor, text, why, extent.span)


def lambdify(extent: Extent) -> Iterator[Row]:
    """scipy's DOP853 with SymPy's lambdify, written by a good hand and by others."""
    peers = {
        "dop853-by-hand": "(G, gamma) by hand, `lambdify` to `math` with `cse`",
        "dop853-lambdify-invariants": "(gamma, omega), no mass matrix, `lambdify` to `math`, `cse`",
        "dop853-lambdify-invariants-plain": "the same equations, `lambdify` with nothing else said",
        "dop853-lambdify-coordinates": "equations in Euler angles, `lambdify` with `cse`, "
        "`numpy.linalg.solve`",
    }
    yield from _against(
        extent, peers, {1e-6: 500, 1e-9: 600}, "against scipy DOP853",
        "a peer that writes out what the engine found, on plain floats, is the fastest "
        "Python there is; the Taylor method saves least at coarse errors",
    )  # fmt: skip


def numba(extent: Extent) -> Iterator[Row]:
    """DOP853 compiled by numba."""
    peers = {
        "dop853-numba": "SymPy's right-hand side",
        "dop853-numba-ours": "our program",
        "dop853-numba-by-hand": "(G, gamma) by hand, without fast-math",
        "dop853-numba-fastmath": "(G, gamma) by hand, with fast-math",
    }
    yield from _against(
        extent, peers, {1e-9: 1.2, 1e-11: 1.0}, "against DOP853 compiled by numba",
        "both run machine code, and fast-math gives the peer a tenth: this is what "
        "Taylor's method has over DOP853 at this error",
    )  # fmt: skip


def heyoka(extent: Extent) -> Iterator[Row]:
    """heyoka by hand at equal error, as `integrate` runs, checks of the mass matrix included."""
    found, span = around(BALL, ["heyoka", "heyoka-by-hand"], ERRORS, extent), extent.span
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
    asked, true = problem(BALL, extent), exact(BALL, extent)
    ours = min(measurement(BALL, "heyoka", extent).good, key=lambda p: p.error)
    hand = by_hand(asked)
    start = hand.start(hand.values)

    def rows(state: np.ndarray, tol: float) -> np.ndarray:
        import heyoka as hy

        made = hy.taylor_adaptive(hand.taylor, state.tolist(), tol=tol, high_accuracy=True)
        return np.array(made.propagate_grid(asked.grid)[-1])

    def apart(found: np.ndarray) -> float:
        return max(float(e.max()) for e in true.errors(hand.back(found)).values())

    theirs = min(apart(rows(start, tol)) for tol in (1e-14, 1e-15, 1e-16))
    usual, beside = rows(start, 1e-16), rows(start + np.spacing(start), 1e-16)
    moved = float(np.abs(beside - usual).max())
    yield Row(
        f"smallest error at T = {asked.span:g}",
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
    found, span = around(BALL, ["heyoka", "numba", "c"], ERRORS[1:], extent), extent.span
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
    plane, names = "ball on a plane", ("mujoco-best", "heyoka")
    found = around(plane, names, (1e-6,), extent)
    theirs, ours = (found.at(n, 1e-6, extrapolate=n == names[0]) for n in names)
    ratio, span = theirs.over(ours), problem(plane, extent).span
    whole = theirs.over(found.at("heyoka", 1e-6, "whole"))
    kind = measurement(plane, names[0], extent).at(1e-6, True).kind
    yield Row(
        "against MuJoCo's best setting at error 1e-6, ball on a plane, T = 100",
        "5000 times faster",
        f"{ratio.times()}; {_micro(theirs, span)} µs, {kind}, "
        f"/ {_micro(ours, span)} µs per unit of time; whole call {whole.times()}",
        ratio.median >= 5000,
        "at such an error only; MuJoCo solves a more general problem",
    )


def minimal(extent: Extent) -> Iterator[Row]:
    """Demchenko's ball: u and v on the smallest model, against everything in coordinates."""
    name, error = "Demchenko", 1e-9
    asked, true = problem(name, extent), exact(name, extent)
    found = around(name, ["heyoka", "heyoka-full"], (error,), extent)
    slow, fast = (found.at(n, error) for n in ("heyoka-full", "heyoka"))
    ratio, span = slow.over(fast), asked.span
    yield Row(
        f"minimal scene against the full model: Demchenko's ball, u and v wanted, error {error:g}",
        "3 times faster",
        f"{ratio.times()}; {_micro(slow, span)} / {_micro(fast, span)} µs per unit of time",
        ratio.median >= 3,
        "the full model is short: in the frame (s, tau, n) its mass matrix is diagonal, and u1, "
        "v1, theta add three equations of eight; both divide by sin u, which shortens their steps "
        "alike; in (G, gamma) the same motion takes a fifth fewer steps",
    )
    outputs = asked.outputs
    times = []
    for _ in range(extent.rounds + 1):  # the first makes what the others find
        run, seconds = clock(
            lambda: vo.integrate(
                asked.equations, asked.bare, times=asked.grid, outputs=outputs, method=CLOSED_FORM
            )
        )
        times.append(seconds)
    errors = true.errors({n: run[n] for n in outputs}, asked.angles)
    whole = Spread(tuple(times[1:]))
    ratio = slow.over(whole)
    yield Row(
        f"Demchenko's ball, u and v alone, T = {span:g}: whole call for the closed form "
        f"after the first, {len(asked.grid)} points, against the run of the full model at "
        "error 1e-09",
        "40 times faster",
        f"{ratio.times()}; {1e3 * slow.median:.3g} / {1e3 * whole.median:.3g} ms; error "
        f"{max(float(e.max()) for e in errors.values()):.1e}",
        ratio.median >= 40,
        "a call takes a fifth of a millisecond on an idle core whatever the span, half for u and v "
        "and half to read what is asked; the run of the full model grows with the span",
    )


def large(extent: Extent) -> Iterator[Row]:
    """A chain of six degrees of freedom, and a bicycle, by the compiled methods."""
    hand = "dop853-numba-ours"
    for name, about in {
        "chain": "chain of 7 links, 3 blades, six degrees of freedom",
        "bicycle": "bicycle, scene `default`",
    }.items():
        found = around(name, ("numba", "c", hand), ERRORS, extent)
        for method, error in product(("numba", "c"), ERRORS):
            ours, theirs = (found.at(m, error) for m in (method, hand))
            ratio, whole = ours.over(theirs), found.at(method, error, "whole")
            auto = ", which `auto` takes for a heavy program," * (method == "c")
            yield Row(
                f"{about}: run of method `{method}`{auto} against DOP853 wholly in numba by hand, "
                f"at error {error:g}",
                "not slower than 1.1 times",
                f"{ratio.times()}; {1e3 * ours.median:.3g} / {1e3 * theirs.median:.3g} ms; whole "
                f"call {1e3 * whole.median:.3g} ms",
                ratio.median <= 1.1,
                "the same stages, but for sums of products, which numba fuses and the C compiler "
                "does not; it compiles ten times as fast, and more than such a run gains"
                if method == "c"
                else "the same stages; some hundredths of a millisecond of a run are spent outside "
                "them",
            )


ROWS: dict[str, Callable[[Extent], Iterator[Row]]] = {
    "by-hand": heyoka,
    "finest": finest,
    "without-heyoka": without_heyoka,
    "lambdify": lambdify,
    "numba": numba,
    "mujoco": mujoco,
    "minimal": minimal,
}

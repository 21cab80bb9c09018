"""Rows of the table of figures: programs against programs, in integrators made ready."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from time import process_time
from typing import Any

import numpy as np

import voronec as vo
from figures.extent import Extent
from figures.race import Spread
from figures.table import Row
from voronec.accuracy.bench import ReferenceProblem, ReferenceSolution, ask, at_error, difference
from voronec.accuracy.bench.peers.hand_programs import BY_HAND, start_values
from voronec.accuracy.bench.runs import contenders
from voronec.equations.program import Program, hoist, taylor_system
from voronec.motion.numeric_model import make_model
from voronec.motion.request import Vocabulary

__all__ = ["ROWS"]

SHORT = 200.0
"""Runs short enough to fall between two disturbances."""
FINE = (1e-10, 1e-11, 1e-12, 1e-13)


def turns(runs: Mapping[Any, Callable[[], Any]], rounds: int) -> dict[Any, float]:
    """The shortest CPU time of each run, taken in turn so that noise hits all of them."""
    best = dict.fromkeys(runs, np.inf)
    for _ in range(rounds):
        for name, run in runs.items():
            began = process_time()
            run()
            best[name] = min(best[name], process_time() - began)
    return best


def repeat(
    runs: Mapping[Any, Callable[[], Any]], extent: Extent, more: int = 1
) -> list[dict[Any, float]]:
    """The shortest times of so many turns, in parts: one for each repetition."""
    rounds = max(1, more * extent.turns // extent.rounds)
    return [turns(runs, rounds) for _ in range(extent.rounds)]


@dataclass(frozen=True)
class CompiledMotion:
    """A program ready for heyoka: system, start and constants."""

    system: list[Any]
    start: np.ndarray
    constants: list[float]

    @classmethod
    def of(cls, program: Program, start: Any, values: Any) -> CompiledMotion:
        """As the engine itself hands it over."""
        raised = hoist(program)
        own = raised.program
        used = [i for i, p in enumerate(own.parameters) if p in own.derivative.symbols]
        numbers = raised.values(list(map(float, values)))[: max(used, default=-1) + 1]
        return cls(taylor_system(own), np.array(start, dtype=float), numbers)

    def integrator(self, tol: float, compact: bool = False) -> Any:
        """Compiled."""
        import heyoka as hy

        return hy.taylor_adaptive(
            self.system, self.start.tolist(), pars=self.constants, tol=tol, compact_mode=compact
        )


def smallest(question: ReferenceProblem) -> CompiledMotion:
    """The smallest model of a question's outputs, as on a fine grid: angles are read off."""
    form = question.equations.raw.form
    start = np.array([question.initial[str(s)] for s in (*form.coordinates, *form.velocities)])
    wanted = [question.expressions[n] for n in question.outputs]
    made = make_model(
        Vocabulary.of(question.equations), wanted, {}, start, question.parameters, 0.0, False
    )
    return CompiledMotion.of(made.program, *made.place(start, question.parameters, 0.0))


def _drive(integrator: Any, start: np.ndarray, span: float) -> Callable[[], None]:
    def run() -> None:
        integrator.time, integrator.state[:] = 0.0, start
        integrator.propagate_until(span)

    return run


def by_hand(extent: Extent) -> Iterator[Row]:
    """The engine's program against the best one by hand, tolerance by tolerance."""
    import heyoka as hy

    question = ask(vo.load("ball-on-sphere"), time=extent.span)
    ours = smallest(question)
    hand = BY_HAND["ball-on-sphere"](question.parameters)
    start = hand.start(start_values(question))
    ratios = []
    for tol in (1e-8, 1e-11, 1e-13):
        one = ours.integrator(tol)
        other = hy.taylor_adaptive(hand.equations, start.tolist(), tol=tol)
        found = repeat({
            "ours": _drive(one, ours.start, SHORT), "hand": _drive(other, start, SHORT)
        }, extent, more=3)  # fmt: skip
        ratios.append(Spread(tuple(best["ours"] / best["hand"] for best in found)))
    worst = max(ratios, key=lambda r: r.median)
    yield Row(
        "program reduced by the engine from Euler angles, against the best by hand in (G, gamma), "
        f"the same steps over {SHORT:g} units of time",
        "at most 1.1 times its time",
        f"{worst.times()}, at worst of three tolerances "
        f"({', '.join(f'{r.median:.2f}' for r in ratios)})",
        worst.median <= 1.1,
        "both have the same products, and constants are arguments of ours; the ratio moves by "
        "a few hundredths from run to run",
    )


def minimal(extent: Extent) -> Iterator[Row]:
    """Demchenko's ball: u and v on the smallest model, against everything in coordinates."""
    question = ask(vo.load("demchenko"), time=extent.span, outputs=("u", "v"))
    question = replace(question, angles=frozenset(("u", "v")))  # the peer's v has no whole turns
    run = contenders(["heyoka"])[0].prepare(question)
    few = smallest(question)
    program = Program.of(question.equations.form)
    every = CompiledMotion.of(
        program,
        [question.initial[str(s)] for s in program.state],
        [question.parameters[str(p)] for p in program.parameters],
    )
    exact = _demchenko_by_hand(question)
    small = [(t, _worst(question, run(t).values, exact)) for t in FINE]
    large = [(t, _worst(question, _whole(question, program, every, t), exact)) for t in FINE]
    span = question.span
    found = repeat(_model_runs(few, every, span), extent)
    error = 1e-9
    full = {mode: _seconds(found, mode, large, error) for mode in ("default", "compact")}
    mode = min(full, key=lambda m: full[m].median)
    slow, fast = full[mode], _seconds(found, "small", small, error)
    ratio = slow.over(fast)
    yield Row(
        f"minimal scene against the full model: Demchenko's ball, u and v wanted, error {error:g}",
        "3 times faster",
        f"{ratio.times()}; {1e6 * slow.median / span:.3g} / {1e6 * fast.median / span:.3g} µs per "
        f"unit of time; the full model in heyoka's {mode} mode, its better one",
        ratio.median >= 3,
        "the full model is short: in the frame (s, tau, n) its mass matrix is diagonal, and u1, "
        "v1, theta add three equations of eight; both divide by sin u, which shortens their steps "
        "alike; in (G, gamma) the same motion takes a fifth fewer steps",
    )
    yield _closed_form_call(question, exact, slow, extent)


def _model_runs(
    few: CompiledMotion, every: CompiledMotion, span: float
) -> dict[tuple[str, float], Callable[[], None]]:
    """Runs of the smallest model, and of the full one in both modes of heyoka, by tolerance."""
    runs = {("small", t): _drive(few.integrator(t), few.start, span) for t in FINE}
    for mode in ("default", "compact"):
        for t in FINE:
            integrator = every.integrator(t, compact=mode == "compact")
            runs[mode, t] = _drive(integrator, every.start, span)
    return runs


def _seconds(
    found: list[dict[Any, float]], side: str, pairs: list[tuple[float, float]], error: float
) -> Spread:
    """What a side costs at an error; ``pairs`` are its tolerances and what their errors are."""
    found_at = (at_error([(e, best[side, t]) for t, e in pairs], error) for best in found)
    return Spread(tuple(at.seconds or np.nan for at in found_at))


def _closed_form_call(
    question: ReferenceProblem, exact: ReferenceSolution, full: Spread, extent: Extent
) -> Row:
    """A whole call for the motion in closed form, against seconds of the ``full`` model."""

    def call() -> vo.Trajectory:
        return vo.integrate(
            question.equations, question.bare, times=question.grid, outputs=question.outputs,
            method="closed-form",
        )  # fmt: skip

    found = call()
    error = _worst(question, {n: found[n] for n in question.outputs}, exact)
    whole = Spread(tuple(best["call"] for best in repeat({"call": call}, extent)))
    ratio = full.over(whole)
    return Row(
        f"Demchenko's ball, u and v alone, T = {question.span:g}: whole call for the closed form "
        f"after the first, {len(question.grid)} points, against the run of the full model at "
        "error 1e-09",
        "40 times faster",
        f"{ratio.times()}; {1e3 * full.median:.3g} / {1e3 * whole.median:.3g} ms; error "
        f"{error:.1e}",
        ratio.median >= 40,
        "a call takes a fifth of a millisecond on an idle core whatever the span, half for u and v "
        "and half to read what is asked; the run of the full model grows with the span",
    )


def _demchenko_by_hand(question: ReferenceProblem) -> ReferenceSolution:
    """u and v by a program of its own kind, at the tolerance that drifts least."""
    import heyoka as hy

    hand = BY_HAND["demchenko"](question.parameters)
    start = hand.start(start_values(question))
    integrator = hy.taylor_adaptive(hand.equations, start.tolist(), tol=1e-16)
    values = hand.back(integrator.propagate_grid(question.grid)[-1])
    return ReferenceSolution(question.grid, values, 1e-12, ("by hand", ""))


def _worst(
    question: ReferenceProblem, values: Mapping[str, Any], exact: ReferenceSolution
) -> float:
    return max(
        float(difference(values[n], exact.values[n], n in question.angles).max())
        for n in question.outputs
    )


def _whole(
    question: ReferenceProblem, program: Program, every: CompiledMotion, tol: float
) -> dict[str, np.ndarray]:
    integrator = every.integrator(tol)
    integrator.time, integrator.state[:] = 0.0, every.start
    rows = integrator.propagate_grid(question.grid)[-1]
    return {str(s): column for s, column in zip(program.state, rows.T, strict=True)}


ROWS: dict[str, Callable[[Extent], Iterator[Row]]] = {"programs": by_hand, "minimal": minimal}

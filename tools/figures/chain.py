"""A program of thousands of operations: set-up, and time against error, of a chain on blades.

    python tools/bench.py chain --links 9 --blades 5 --json

heyoka compiles with empty caches; times are CPU times, the best of several runs.  The error is the
largest difference of a state at the end to heyoka's finest run; the finest DOP853 run says how far
that is to be trusted.  Needs heyoka, numba and scipy.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, partial
from time import process_time
from typing import Any

import numpy as np

import voronec as vo
from figures.race import OneRun, Race, race
from figures.systems import chain
from voronec.accuracy.bench import ask
from voronec.accuracy.bench.contender import time_fastest
from voronec.accuracy.bench.peers.numba_dop853 import right_hand_side, stepper_source
from voronec.accuracy.problem import lowest
from voronec.equations.program import HoistedProgram, Program, hoist, taylor_system
from voronec.equations.staged_equations import lean_form
from voronec.motion.methods import METHODS
from voronec.motion.steppers import Problem as Motion
from voronec.motion.steppers.numba_stepper import compiled_dop853

RUNS = 5
FINEST = 1e-16
TOLERANCES = {
    "heyoka": (FINEST, 1e-14, 1e-12, 1e-10, 1e-8),
    "scipy, numba": (1e-13, 1e-12, 1e-10, 1e-8, 1e-6),
    "numba": (1e-15, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6),
}


@dataclass(frozen=True)
class Problem:
    """A program with its constants raised, numbers for all, and a start."""

    raised: HoistedProgram
    constants: np.ndarray
    start: np.ndarray
    span: float

    @property
    def program(self) -> Program:
        """What runs."""
        return self.raised.program


def main() -> int:
    """Measure and print."""
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reader.add_argument("--links", type=int, default=7)
    reader.add_argument("--blades", type=int, default=3)
    reader.add_argument("--span", type=float, default=20.0)
    reader.add_argument("--json", action="store_true")
    given = reader.parse_args()
    record = measure(given.links, given.blades, given.span)
    print(json.dumps(record) if given.json else show(record))
    return 0


def measure(links: int = 7, blades: int = 3, span: float = 20.0) -> dict[str, Any]:
    """Everything, as a dictionary: ``setup`` in seconds, ``rows`` of method, tol, error, time."""
    setup: dict[str, float] = {}
    system = chain(links, blades)
    equations = clock(setup, "derivation", lambda: vo.derive(system))
    form = clock(setup, "straight-line form", lambda: lean_form(equations.raw))
    program = clock(setup, "program", lambda: Program.of(form))
    problem = pose(clock(setup, "constants", lambda: hoist(program)), span)
    methods = {
        "heyoka": clock(setup, "heyoka, cold", lambda: by_heyoka(problem)),
        "numba": clock(setup, "numba, cold", lambda: by_numba(problem)),
        "scipy, numba": by_scipy(problem),
    }
    reference, rows = None, []
    for method, tolerances in TOLERANCES.items():
        for tol in tolerances:
            seconds, state = best(partial(methods[method], tol))
            reference = state if reference is None else reference
            error = float(np.abs(state - reference).max())
            rows.append({"method": method, "tol": tol, "error": error, "seconds": seconds})
    return {
        "system": f"{links} links, {blades} blades", "degrees of freedom": links + 2 - blades,
        "operations": program.operations, "weight": round(program.weight, 1), "span": span,
        "setup": {k: round(v, 3) for k, v in setup.items()}, "rows": rows,
    }  # fmt: skip


def clock(setup: dict[str, float], name: str, work: Callable[[], Any]) -> Any:
    """What some work gives; its CPU time is written down."""
    began = process_time()
    found = work()
    setup[name] = process_time() - began
    return found


def best(work: Callable[[], np.ndarray]) -> tuple[float, np.ndarray]:
    """The shortest CPU time of several runs, and what the last gives."""
    seconds, found = float("inf"), work()
    for _ in range(RUNS):
        began = process_time()
        found = work()
        seconds = min(seconds, process_time() - began)
    return seconds, found


def pose(raised: HoistedProgram, span: float) -> Problem:
    """Numbers for the parameters, all different, and a lively start."""
    dice = np.random.default_rng(0)
    given = raised.original
    values = [1 + 0.03 * i for i in range(len(given.parameters))]
    places = 0.3 * dice.normal(size=len(given.coordinates))
    speeds = 0.4 * dice.normal(size=len(given.velocities))
    return Problem(raised, np.array(raised.values(values)), np.concatenate([places, speeds]), span)


@dataclass(frozen=True)
class PosedCall:
    """A problem, and the same as a whole call of ``integrate``, by a method at a tolerance."""

    problem: Problem
    call: Callable[[str, float], Any]


def chain_problem() -> PosedCall:
    """The chain that is measured by default."""
    equations = vo.derive(chain())
    problem = pose(hoist(Program.of(lean_form(equations.raw))), 20.0)
    given = problem.raised.original
    values = dict(zip(map(str, given.parameters), problem.constants.tolist(), strict=False))
    start = dict(zip(map(str, given.state), problem.start.tolist(), strict=True))
    call = partial(
        vo.integrate, equations, times=[0.0, problem.span], parameters=values, initial=start,
        outputs=tuple(start),
    )  # fmt: skip
    return PosedCall(problem, lambda method, tol: call(method=method, tol=tol))


def bicycle_problem() -> PosedCall:
    """The bicycle of the catalogue over its own span."""
    question = ask(vo.load("bicycle"))
    at = lowest(question)
    raised = hoist(at.program)
    problem = Problem(raised, np.array(raised.values(list(at.constants))), at.state, question.span)
    call = partial(
        vo.integrate, question.equations, question.bare, times=question.grid[[0, -1]]
    )  # fmt: skip
    return PosedCall(problem, lambda method, tol: call(method=method, tol=tol))


def against_numba(posed_call: PosedCall, errors: Iterable[float], rounds: int) -> Race:
    """At the end of a span: the methods `numba` and `c`, and by ``hand``."""
    problem = posed_call.problem
    by = by_numba(problem)
    original = problem.raised.original
    values, grid = problem.constants[: len(original.parameters)], np.array([0.0, problem.span])

    @cache
    def stepper_of(method: str, tol: float) -> Any:
        motion = Motion(original, problem.start, list(values), tol)
        return compiled_dop853(motion, METHODS[method].loop)

    _, exact = best(lambda: stepper_of("numba", 2.3e-14)(grid).states[-1])

    def ran(work: Callable[[], np.ndarray]) -> tuple[float, float]:
        state, seconds = time_fastest(work)
        return float(np.abs(state - exact).max()), seconds

    def hand(tol: float) -> OneRun:
        error, seconds = ran(lambda: by(tol))
        return OneRun(error, {"run": seconds})

    def ours(method: str, tol: float) -> OneRun:
        stepper = stepper_of(method, tol)
        error, seconds = ran(lambda: stepper(grid).states[-1])
        _, whole = time_fastest(lambda: posed_call.call(method, tol))
        return OneRun(error, {"run": seconds, "whole": whole})

    runs: dict[str, Callable[[float], OneRun]] = {"hand": hand}
    runs |= {method: partial(ours, method) for method in ("numba", "c")}
    tols = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
    return race(
        runs, {n: {tol: run(tol) for tol in tols} for n, run in runs.items()}, errors, rounds
    )


def by_heyoka(problem: Problem) -> Callable[[float], np.ndarray]:
    """Taylor's method; what is compiled for the finest tolerance is compiled again for others."""
    import heyoka as hy

    hy.llvm_state.set_diskcache_enabled(False)
    hy.llvm_state.set_memcache_limit(0)
    program = problem.program
    used = [i for i, p in enumerate(program.parameters) if p in program.derivative.symbols]
    system = taylor_system(program)
    numbers = problem.constants[: max(used, default=-1) + 1].tolist()
    made: dict[float, Any] = {}

    def integrator(tol: float) -> Any:
        if tol not in made:
            made[tol] = hy.taylor_adaptive(
                system, problem.start.tolist(), pars=numbers, tol=tol, compact_mode=True
            )
        return made[tol]

    def run(tol: float) -> np.ndarray:
        one = integrator(tol)
        one.time, one.state[:] = 0.0, problem.start
        one.propagate_until(problem.span)
        return np.array(one.state)

    integrator(FINEST)
    return run


def by_numba(problem: Problem) -> Callable[[float], np.ndarray]:
    """DOP853 and the right-hand side, both compiled by numba."""
    import numba

    right = numba.njit(right_hand_side(problem.program), error_model="numpy")
    namespace: dict[str, Any] = {"np": np, "right": right}
    exec(compile(stepper_source(len(problem.start)), "<dop853>", "exec"), namespace)
    advance = numba.njit(namespace["advance"], error_model="numpy")
    rows = np.empty((2, len(problem.start)))

    def run(tol: float, end: float = problem.span) -> np.ndarray:
        advance(np.array([0.0, end]), problem.start, problem.constants, tol, rows)
        return rows[1].copy()

    run(1e-3, 1e-3)
    return run


def by_scipy(problem: Problem) -> Callable[[float], np.ndarray]:
    """scipy's DOP853 with a right-hand side compiled by numba."""
    import numba
    from scipy.integrate import solve_ivp

    right = numba.njit(right_hand_side(problem.program), error_model="numpy")

    def derivative(t: float, state: np.ndarray) -> np.ndarray:
        result = np.empty(len(state))
        right(t, state, problem.constants, result)
        return result

    def run(tol: float) -> np.ndarray:
        span = (0.0, problem.span)
        found = solve_ivp(derivative, span, problem.start, "DOP853", rtol=tol, atol=tol)
        return np.array(found.y[:, -1])

    return run


def show(record: dict[str, Any]) -> str:
    """The record as text."""
    lines = [f"{k}: {v}" for k, v in record.items() if k not in ("setup", "rows")]
    lines += [f"set-up, {k}: {v:.2f} s" for k, v in record["setup"].items()]
    for row in record["rows"]:
        took = f"{row['seconds'] * 1e3:8.2f} ms"
        lines.append(f"{row['method']:13s} tol {row['tol']:.0e}  error {row['error']:.1e}  {took}")
    return "\n".join(lines)

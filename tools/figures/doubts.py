"""How often the check of runs doubts what is right, and how often it notices what is wrong.

python tools/bench.py doubts [--count 500] [--planted 200] [--seed 1] [--only SYSTEM]

Single runs and ensembles of systems of the catalogue are drawn: starts, spans, tolerances and grids
of 2 to 50 instants.  A run is *doubted* where the check integrates a part of it again, and *done
again* where it goes on by another method or in another model.  Whether it was right is told by a
run in other steps (``flint``, or heyoka at 1e-16) whose results are not checked.

Wrong runs are planted in the integrators: a rate that is 1 + 1e-4 times what it should be, a term
that is left out, a state that jumps by 1e-4 of its size on the way, and one that loses all but
seven digits there.  Each is *noticed* where an error is raised, or the run is done again.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from random import Random
from time import perf_counter
from typing import Any
from unittest.mock import patch

import numpy as np
import symengine as se
import sympy as sp

import voronec as vo
from voronec.algebra.symbols import plain_name
from voronec.motion import batches, methods
from voronec.motion.solve import Arrival, Phase, Solver
from voronec.motion.steppers import restart

HEAVY = ("rn", "bicycle", "torus", "rolling-body", "trailer", "in-time")
"""Parts of names of systems whose equations take long to derive."""
BLOCK = 10
"""So many runs in a row share their system."""
FAULTS = ("rate", "term", "jump", "digits")
WRONG = 1e-4
"""How large a fault is, and how far off a run is wrong, in units of its size."""
HARM = {"rate": 1e-6, "term": 1e-6, "jump": 1e-6, "digits": 1e-9}
"""A fault that makes less than this of the end of a run harms nothing."""
MANY = 8
"""Motions of an ensemble."""


@dataclass(frozen=True)
class Draw:
    """One run, as it is asked for; ``spread`` are the starts of an ensemble."""

    system: Any
    scene: str
    initial: dict[str, Any]
    times: list[float]
    tol: float
    fault: str
    dice: Random

    def run(self, **options: Any) -> Any:
        """The trajectory, or the ensemble."""
        own = self.system.system
        names = tuple(map(plain_name, (*own.coordinates, *own.velocities)))
        given: dict[str, Any] = {"times": self.times, "tol": self.tol, **options}
        given["outputs"] = names
        if any(isinstance(x, np.ndarray) for x in self.initial.values()):
            return vo.ensemble(self.system, self.initial, scene=self.scene, **given)
        return vo.integrate(self.system, self.scene, initial=self.initial, **given)


def systems() -> list[str]:
    """The systems that runs are drawn of."""
    return [name for name in vo.names() if not any(part in name for part in HEAVY)]


def draws(seed: int, count: int, only: str | None) -> Iterator[Draw]:
    """So many runs; those of a block share their system."""
    for k in range((count + BLOCK - 1) // BLOCK):
        dice = Random(f"{seed} system {k}")
        equations = vo.derive(vo.load(only or systems()[(7 * k + seed) % len(systems())]))
        if not equations.system.scenes:
            continue
        for i in range(min(BLOCK, count - k * BLOCK)):
            yield _draw(equations, Random(f"{seed} run {k} {i}"), dice)


def _draw(equations: Any, dice: Random, _: Random) -> Draw:
    system = equations.system
    scene = dice.choice([*system.scenes])
    own = system.scenes[scene].initial
    values = {p.symbol: sp.sympify(p.value) for p in system.parameters if p.value is not None}
    values |= {sp.Symbol(str(k)): sp.sympify(x) for k, x in system.scenes[scene].parameters.items()}
    many, initial = dice.random() < 0.2, dict[str, Any]()
    spin, speeds = dice.choice((0.3, 1.0, 3.0)), {plain_name(v) for v in system.velocities}
    for name in map(plain_name, (*system.coordinates, *system.velocities)):
        here = next((x for k, x in own.items() if str(k) == name), 0)
        base = sp.sympify(here).subs(values).subs(values)
        if not base.is_number or any(system.fibration.relations):
            continue
        spread = spin if name in speeds else 0.3
        moved = [float(base) + dice.gauss(0, spread) for _ in range(MANY if many else 1)]
        initial[name] = np.array(moved) if many else moved[0]
    end = round(float(np.exp(dice.uniform(0, np.log(60)))), 2)
    size = dice.randint(2, 50)
    times = np.linspace(0, end, size).tolist()
    if dice.random() < 0.3:
        times = sorted({0.0, *(round(dice.uniform(0, end), 4) for _ in range(size - 1))})
    tol = dice.choice((1e-13, 1e-13, 1e-9, 1e-6))
    return Draw(equations, scene, initial, times, tol, dice.choice(FAULTS), dice)


@dataclass
class ObservedQuantities:
    """What happens in a run: how often parts of it are integrated again, and for how long."""

    again: int = 0
    seconds: float = 0.0

    @contextmanager
    def count_doubts(self) -> Iterator[None]:
        """Count what is integrated again."""
        places = [m for m in _modules() if hasattr(m, "again")]
        with ExitStack() as stack:
            for module in places:
                stack.enter_context(patch.object(module, "again", self._with_count(module.again)))
            yield

    def _with_count(self, again: Callable[..., Any]) -> Callable[..., Any]:
        def wrapper(*given: Any) -> Any:
            began = perf_counter()
            try:
                return again(*given)
            finally:
                self.again, self.seconds = self.again + 1, self.seconds + perf_counter() - began

        return wrapper


def _modules() -> list[Any]:
    return [m for name, m in sys.modules.items() if name.startswith("voronec.motion")]


@contextmanager
def without_check() -> Iterator[None]:
    """Runs of which nothing is looked at."""
    with ExitStack() as stack:
        for module in _modules():
            for name in ("doubtful", "wrong_steps", "strayed_rows"):
                if hasattr(module, name):
                    stack.enter_context(patch.object(module, name, lambda *_, **__: []))
            for kind in (x for x in vars(module).values() if hasattr(x, "breach")):
                stack.enter_context(patch.object(kind, "breach", lambda *_, **__: (None, ())))
            for kind in (x for x in vars(module).values() if hasattr(x, "breaches")):
                stack.enter_context(patch.object(kind, "breaches", lambda *_, **__: ({}, {})))
        yield


def is_right(draw: Draw, found: Any) -> bool | None:
    """Whether a run is that of finer steps; None where these do not come to the end, or two of
    them do not agree."""
    try:
        with without_check():
            best = _values(draw, draw.run(tol=1e-16, method="heyoka"))
            other = _values(draw, draw.run(tol=1e-13, method="scipy"))
    except vo.VoronecError:
        return None
    own = _values(draw, found)
    size = np.maximum(1.0, np.abs(best))
    if best.shape != own.shape or not (np.abs(best - other) < WRONG / 10 * size).all():
        return None
    return bool((np.abs(best - own) < WRONG * size * max(1.0, draw.tol / 1e-9)).all())


def is_harmed(draw: Draw, found: Any) -> bool:
    """Whether a run with a fault is another than without it."""
    with without_check():
        sound = _values(draw, draw.run())
    size = np.maximum(1.0, np.abs(sound))
    return not (np.abs(sound - _values(draw, found)) <= HARM[draw.fault] * size).all()


def _values(draw: Draw, found: Any) -> np.ndarray:
    system = draw.system.system
    names = [plain_name(x) for x in (*system.coordinates, *system.velocities)]
    return np.stack([np.asarray(found[name], dtype=float) for name in names])


def _is_done_again(found: Any) -> bool:
    return "fails after" in found.cost.reason or bool(getattr(found, "errors", None))


def doubts(seed: int, count: int, only: str | None) -> None:
    """Draw runs, and print how many were doubted, done again, refused, and wrong."""
    seen, spent, again, runs = Counter[str](), 0.0, 0.0, 0
    for draw in draws(seed, count, only):
        watch, began, told = ObservedQuantities(), perf_counter(), ""
        try:
            with watch.count_doubts():
                found = draw.run()
        except vo.IntegrationError as error:
            found, told = None, str(error)
        except vo.VoronecError:
            continue
        taken, runs = perf_counter() - began, runs + 1
        spent, again = spent + taken, again + watch.seconds
        seen["refused"] += found is None
        if found is None:
            print(f"  refused: {draw.system.system.name}: {told[:120]}", flush=True)
        kinds = {
            "doubted": watch.again > 0,
            "done again": found is not None and _is_done_again(found),
        }
        for kind, is_so in kinds.items():
            if is_so:
                right = None if found is None else is_right(draw, found)
                seen[
                    f"{kind}, {'right' if right else 'undecided' if right is None else 'WRONG'}"
                ] += 1
                print(
                    f"  {kind}: {draw.system.system.name} {draw.scene}, {len(draw.times)} instants "
                    f"to {draw.times[-1]}, tol {draw.tol:g}, "
                    f"{'ensemble' if _is_many(draw) else 'single'}: {watch.again} parts,"
                    f" {watch.seconds:.3f} of {taken:.3f} s, right: {right}", flush=True,
                )  # fmt: skip
    print(f"{runs} runs, {spent:.1f} s, {100 * again / spent:.0f} % of it again: {dict(seen)}")


def _is_many(draw: Draw) -> bool:
    return any(isinstance(x, np.ndarray) for x in draw.initial.values())


@contextmanager
def fault_in(draw: Draw) -> Iterator[list[str]]:
    """A fault in the integrators of all methods; the list says what was planted."""
    make, lanes, done = methods._make_stepper, batches.lanes_of, list[str]()
    where = draw.dice.random()

    def faulty(program: Any) -> Any:
        block, results = program.derivative, list(program.derivative.results)
        lines = [list(line) for line in block.assignments]
        if draw.fault == "rate":
            i = int(where * len(results))
            results[i] = results[i] * (1 + se.RealDouble(WRONG))
        else:
            sums = [(k, e) for k, (_, e) in enumerate(lines) if isinstance(e, se.Add)]
            sums += [(-1 - k, e) for k, e in enumerate(results) if isinstance(e, se.Add)]
            if not sums:
                return program
            k, total = sums[int(where * len(sums))]
            less = se.Add(*total.args[1:])
            if k < 0:
                results[-1 - k] = less
            else:
                lines[k][1] = less
        done.append(draw.fault)
        return replace(
            program,
            derivative=replace(block, assignments=tuple(map(tuple, lines)), results=tuple(results)),
        )

    def wrong(method: str, problem: Any, reason: str) -> Any:
        if draw.fault in ("rate", "term"):
            return make(method, replace(problem, program=faulty(problem.program)), reason)
        solver, chosen = make(method, problem, reason)
        first = problem.start.copy()

        class Jump:
            """A fault that moves the state where the first phase ends."""

            def next(self, phase: Phase, here: Arrival) -> Phase:
                done.append(draw.fault)
                state = here.state.astype(float)
                if draw.fault == "digits":
                    state = state.astype(np.float32).astype(float)
                else:
                    i = int(where * 977) % len(state)
                    state[i] += WRONG * max(1.0, abs(state[i]))
                moved = replace(problem, start=state.copy())
                go = restart(make(method, moved, reason)[0], moved)
                return Phase(None, here.time, state, state, go, {}, is_change=False)

        def run(grid: np.ndarray) -> Any:
            at = float(grid[0] + (0.1 + 0.8 * where) * (grid[-1] - grid[0]))
            if len(done) or problem.changing is not None or len(grid) < 2:
                return solver(grid)
            phase = Phase(
                None, grid[0], first, first, lambda _, times: solver(times), {}, end=at,
                successor=Jump(),
            )  # fmt: skip
            return Solver(grid, problem.events, problem.dense).run(phase)

        return run, chosen

    def wrong_lanes(program: Any, *given: Any) -> Any:
        return lanes(faulty(program) if draw.fault in ("rate", "term") else program, *given)

    with (
        patch.object(methods, "_make_stepper", wrong),
        patch.object(batches, "lanes_of", wrong_lanes),
    ):
        yield done


def print_findings(seed: int, count: int, only: str | None) -> None:
    """Plant faults, and print how many of those that make a run wrong are noticed, by kind."""
    seen: Counter[tuple[str, str]] = Counter()
    for draw in draws(seed + 1000, count, only):
        try:
            with fault_in(draw) as done:
                found = draw.run()
        except vo.IntegrationError:
            seen[draw.fault, "noticed"] += 1
            print(f"  {draw.fault}: {draw.system.system.name}: noticed", flush=True)
            continue
        except vo.VoronecError:
            continue
        if not done:
            continue
        outcome = "noticed" if _is_done_again(found) else "missed"
        if outcome == "missed" and not is_harmed(draw, found):
            outcome = "harmless"
        seen[draw.fault, outcome] += 1
        print(
            f"  {draw.fault}: {draw.system.system.name} {draw.scene} {len(draw.times)} instants to "
            f"{draw.times[-1]}, tol {draw.tol:g}, {'ensemble' if _is_many(draw) else 'single'}: "
            f"{outcome}", flush=True,
        )  # fmt: skip
    for fault in FAULTS:
        counts = {what: n for (kind, what), n in sorted(seen.items()) if kind == fault}
        print(f"{fault}: {counts}")


def main() -> int:
    """Count doubts, and what is noticed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--count", type=int, default=500, help="how many runs are drawn")
    parser.add_argument("--planted", type=int, default=200, help="how many of them are made wrong")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", help="a system of the catalogue")
    given = parser.parse_args()
    if given.count:
        doubts(given.seed, given.count, given.only)
    if given.planted:
        print_findings(given.seed, given.planted, given.only)
    return 0

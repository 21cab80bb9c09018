"""What a step of heyoka and of our compiled DOP853 costs on the catalogue, the constants of
``voronec.motion.method_costs`` fitted to it, and whether the choices of ``auto`` are good.

    python tools/bench.py costs [NAME ...] [--tolerance 1e-9]

Each system runs its first scene for so long that what is no step does not count.  Errors are those
of the states at a few instants, against heyoka at 1e-16; the times are those at equal error.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import exp, log
from statistics import median

import numpy as np

import voronec as vo
from figures.table import markdown
from voronec.accuracy.bench import at_error
from voronec.equations.program import Program
from voronec.errors import VoronecError
from voronec.motion import method_costs
from voronec.motion.motion_start import InitialState
from voronec.motion.numeric_model import make_model
from voronec.motion.request import Namespace, StartData

METHODS = ("heyoka", "c")
STEPS, LONGEST = 3000, 1000.0
"""A motion takes about so many steps of heyoka, but no more units of time than the other."""
SHORT, REPEATS = 10.0, 3
SLOWER = 1.5
"""A choice is bad where the other method takes so many times less."""


@dataclass(frozen=True)
class SystemCosts:
    """Of one system: its program, seconds and steps by method and tolerance, errors beside them."""

    name: str
    program: Program
    runs: dict[tuple[str, float], tuple[float, int, float]]

    def seconds(self, method: str, error: float) -> float | None:
        """The time at an error."""
        own = [(e, s) for (name, _), (s, _, e) in self.runs.items() if name == method]
        return at_error(own, error, True).seconds

    def gain(self, tolerance: float) -> float | None:
        """How many times less DOP853 takes at the error that it makes at a tolerance."""
        error = self.runs["c", tolerance][2]
        found = [self.seconds(method, error) for method in METHODS]
        return None if None in found else found[0] / found[1]  # type: ignore[operator]


def measure(name: str, tolerance: float) -> SystemCosts | None:
    """One system; None where it is not one smooth run in its own coordinates."""
    system = vo.load(name)
    scene = system.scenes[str(system.first_scene)]
    equations = vo.derive(system)
    begin = float(scene.times[0])
    names = Namespace.of(equations)
    start = InitialState.of(names, StartData.of(names, scene), begin, False)
    made = make_model(names, (), {}, start.state, start.steady, begin, True)

    def run(method: str, tol: float, end: float) -> vo.Trajectory:
        grid = np.linspace(begin, begin + end, 11)
        return vo.integrate(equations, scene, times=grid, method=method, tol=tol)

    first = run("heyoka", 1e-16, SHORT)
    if first.cost.switches or made.is_rough:
        return None
    end = min(LONGEST, SHORT * STEPS / max(first.cost.steps, 1))
    true, runs = run("heyoka", 1e-16, end), {}
    for method in METHODS:
        for tol in (100 * tolerance, tolerance, tolerance / 100):
            each = [run(method, tol, end) for _ in range(REPEATS)]
            if each[0].cost.method != method or each[0].names != true.names:
                return None
            seconds, off = min(one.cost.cpu for one in each), np.abs(each[0].state - true.state)
            runs[method, tol] = seconds, each[0].cost.steps, float(off.max())
    return SystemCosts(name, made.program, runs)


def fit(found: Sequence[SystemCosts]) -> Iterator[str]:
    """The constants, each with how far half of the systems lie from it."""

    def spread(what: str, values: list[float]) -> str:
        middle = median(values)
        off = exp(median(abs(log(x / middle)) for x in values))
        return f"{what} = {middle:.3g}, half of the systems within {off:.2g} times"

    steps, taylor, evaluation, fine, coarse = [], [], [], [], []
    for one in found:
        program = one.program
        for (method, tol), (seconds, count, error) in one.runs.items():
            if method == "heyoka":
                order = method_costs.order_of(tol)
                own = 1e6 * seconds / count - method_costs.TAYLOR_STEP
                taylor.append(max(own, 1e-9) / order / program.weight)
                fine.append(error / tol)
            else:
                other = one.runs["heyoka", tol][1]
                steps.append(count / other * tol**0.125)
                coarse.append(error / tol)
                own = 1e6 * seconds / count - method_costs.DOP853_STEP
                evaluation.append(max(own, 1e-9) / program.evaluation_weight)
    yield spread("TAYLOR", taylor)
    yield spread("EVALUATION", evaluation)
    yield spread("STEPS", steps)
    yield f"FINER = {median(coarse) / median(fine):.3g}"


def main() -> int:
    """Measure, fit and check; 1 where a choice is bad."""
    parser = argparse.ArgumentParser(prog="tools/bench.py costs", description=__doc__)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--tolerance", type=float, default=1e-9)
    asked = parser.parse_args()
    found, lines, bad = [], [], []
    for name in asked.names or vo.names():
        try:
            one = measure(name, asked.tolerance)
        except VoronecError as error:
            print(f"{name}: {error}")
            continue
        gain = None if one is None else one.gain(asked.tolerance)
        if one is None or gain is None:
            continue
        found.append(one)
        model = method_costs.dop853_gain(one.program, asked.tolerance)
        chosen = method_costs.dop853_is_cheaper(one.program, asked.tolerance)
        loss = 1 / gain if chosen else gain
        bad += [name] if loss > SLOWER else []
        own = one.program
        lines.append((
            name, f"{own.weight:.0f}", own.evaluation_weight, f"{gain:.2f}", f"{model:.2f}",
            "c" if chosen else "heyoka",
        ))  # fmt: skip
        print(*lines[-1], flush=True)
    head = ("system", "weight", "evaluation weight", "heyoka / c", "model", "auto")
    print(markdown(head, lines), *fit(found), sep="\n")
    print(f"bad choices: {', '.join(bad) or 'none'}")
    return int(bool(bad))

"""Runs of prepared problems, every start another, beside heyoka's steps along equations by hand.

    python tools/bench.py prepared [--rounds 300]

Both at the tolerance 1e-9, at 51 instants, in turns; of each the processor's time of the fastest.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from time import perf_counter
from typing import Any

import voronec as vo
from figures.peers import PEERS
from figures.table import markdown
from voronec.accuracy.bench import contenders, scene_problem
from voronec.algebra.symbols import plain_name

TOLERANCE, INSTANTS = 1e-9, 51
PROBLEMS: dict[str, tuple[float, tuple[str, ...]]] = {
    "sleigh": (20.0, ()), "ball-on-sphere": (10.0, ()), "demchenko": (10.0, ("u",)),
}  # fmt: skip
"""How long the motions are, and their outputs."""


def fastest(call: Callable[[int], Any], rounds: int) -> float:
    """Milliseconds of the fastest of so many calls; processors' clocks tick too slowly for them."""
    found = []
    for k in range(rounds):
        began = perf_counter()
        call(k)
        found.append(perf_counter() - began)
    return 1e3 * min(found)


def line(name: str, end: float, outputs: tuple[str, ...], rounds: int) -> list[str]:
    """One system: by hand, by ``run`` of a prepared problem and by ``integrate``."""
    (contender,) = contenders(["heyoka-by-hand"], PEERS)
    system = vo.load(name)
    asked = scene_problem(system, time=end, instants=INSTANTS, outputs=outputs)
    by_hand, grid = contender.prepare(asked), asked.grid
    problem = vo.prepare(system, "default", outputs, tol=TOLERANCE)
    own = plain_name(system.velocities[-1])
    first = float(vo.integrate(system, times=grid, tol=TOLERANCE)[own][0])

    def start(k: int) -> dict[str, float]:
        return {own: first * (1 + 1e-6 * k)}

    hand = 1e3 * min(by_hand(TOLERANCE).seconds for _ in range(3))
    run = fastest(lambda k: problem.run(start(k), times=grid), rounds)
    whole = fastest(
        lambda k: vo.integrate(
            system, "default", grid, outputs, initial=start(k), tol=TOLERANCE
        ),
        rounds,
    )  # fmt: skip
    return [name, *(f"{x:.3f}" for x in (hand, run, whole, run - hand))]


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="tools/bench.py prepared", description=__doc__)
    parser.add_argument("--rounds", type=int, default=300)
    rounds = parser.parse_args().rounds
    head = ("system", "by hand, ms", "run", "integrate", "run beyond by hand")
    print(markdown(head, [line(n, *asked, rounds) for n, asked in PROBLEMS.items()]))
    return 0

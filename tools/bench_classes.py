"""Very many random motions classified, each class held against roots counted on a refined grid.

    python tools/bench_classes.py [SYSTEM] [--count N] [--seed S]

The grid knows nothing of discs and balls: it walks from the start to where f changes its sign, and
counts the changes of sign of phi between.  Where the two disagree, the grid is refined.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from time import process_time
from typing import Any

import numpy as np
import sympy as sp

import voronec as vo
from voronec.algebra.symbols import plain_name
from voronec.closed.classes.curve import declared
from voronec.closed.classes.settled import UNDECIDED, classify_many

GRIDS = (2_000, 20_000, 400_000)
"""Points between the parallels of the sphere on which the trace is; the next for disagreements."""
CHUNK = 4_000
LOOPS = {"A": 0, "B": 1, "C": 2, "C1": 2, "C2": 2}


def drawn(system: Any, count: int, seed: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Parameters around the defaults, with either sign where it is free, and any start."""
    dice = np.random.default_rng(seed)
    parameters = {}
    for p in system.parameters:
        value = float(p.value or 1) * np.exp(dice.normal(size=count) * 0.7)
        parameters[p.name] = value if p.positive else value * dice.choice([-1, 1], count)
    start = {plain_name(q): dice.uniform(0, np.pi, count) for q in system.coordinates}
    start |= {plain_name(v): dice.normal(size=count) * 1.5 for v in system.velocities}
    return parameters, start


def counted(known: Any, trace: str, values: list[np.ndarray], points: int) -> Any:
    """Changes of sign of phi between the ends of each motion."""
    curve = known.curve(trace)
    own = values[len(values) - len(known.system.parameters) :]
    *constants, place, _ = sp.lambdify(known.inputs, known.starting, "numpy", cse=True)(*values)
    rows = sp.lambdify(known.level, (*known.quartic, *curve.cosine, *curve.phi), "numpy", cse=True)(
        *own, *constants
    )
    count = len(values[0])
    numbers = [np.broadcast_to(np.asarray(r, dtype=float), count)[:, None] for r in rows]
    quartic, (offset, slope), phi = numbers[:5], numbers[5:7], numbers[7:]
    sides = (np.array([[-1.0, 1.0]]) - offset) / slope
    low, high = sides.min(axis=1, keepdims=True), sides.max(axis=1, keepdims=True)
    place = np.broadcast_to(place, count)[:, None]
    steps = np.linspace(0, 1, points)[None, :]
    ends = [_end(quartic, place + (side - place) * steps) for side in (low, high)]
    lower, upper = ends
    wave = (1 - np.cos(np.linspace(0, np.pi, points + 1)[None, 1:-1])) / 2
    signs = np.sign(_horner(phi, lower + (upper - lower) * wave))
    return np.sum(np.abs(np.diff(signs, axis=1)) > 1, axis=1)


def _end(quartic: Any, grid: np.ndarray) -> np.ndarray:
    """Where f first falls below zero on the way along the grid."""
    below = _horner(quartic, grid) < 0
    found = below.any(axis=1)
    first = np.where(found, below.argmax(axis=1), grid.shape[1] - 1)[:, None]
    outer = np.take_along_axis(grid, first, axis=1)
    inner = np.take_along_axis(grid, np.maximum(first - 1, 0), axis=1)
    for _ in range(60):
        middle = (inner + outer) / 2
        bad = _horner(quartic, middle) < 0
        inner, outer = np.where(bad, inner, middle), np.where(bad, middle, outer)
    return inner


def _horner(coefficients: Any, x: np.ndarray) -> np.ndarray:
    total = np.zeros_like(x)
    for c in coefficients[::-1]:
        total = total * x + c
    return total


def disagreeing(known: Any, trace: str, found: Any, values: list[np.ndarray]) -> np.ndarray:
    """The motions whose count of reversals is not that of the finest grid."""
    left = np.arange(len(values[0]))
    for points in GRIDS:
        wrong = []
        for i in range(0, len(left), max(1, CHUNK * GRIDS[0] // points)):
            part = left[i : i + max(1, CHUNK * GRIDS[0] // points)]
            number = counted(known, trace, [v[part] for v in values], points)
            wrong.append(part[number != found.reversals[part]])
        left = np.concatenate(wrong) if wrong else left[:0]
    return left


def main() -> int:
    """Classify, compare, and print a line for each trace."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("system", nargs="?", default="demchenko")
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    told = parser.parse_args()
    system = vo.load(told.system)
    known = declared(system)
    parameters, start = drawn(system, told.count, told.seed)
    from voronec.closed.classes.many import arrays

    values, bad = arrays(known, parameters, start), 0
    for curve in known.curves:
        began = process_time()
        found = classify_many(system, parameters, start, curve.title)
        seconds = process_time() - began
        began = process_time()
        wrong = disagreeing(known, curve.title, found, values)
        undecided = int(np.sum(found.labels == UNDECIDED))
        bad += len(wrong) + undecided
        labels = Counter(found.labels.tolist()).most_common()
        tally = ", ".join(f"{label} {n}" for label, n in labels)
        print(f"{curve.title}: {told.count} motions in {seconds:.1f} s of processor time; {tally}")
        against = f"against the grid {len(wrong)} disagree {wrong[:5].tolist()}"
        print(f"  undecided {undecided}; {against} ({process_time() - began:.1f} s)")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())

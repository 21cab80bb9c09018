"""Rows of the table of figures of the closed form: classes of traces, and the gallery."""

from __future__ import annotations

import os
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from time import process_time
from typing import Any

import numpy as np

import voronec as vo
from figures.measure import command
from figures.table import Row

COUNT = 100_000
GRIDS = (1_000, 20_000, 400_000)
"""Points between the parallels; the next for motions on which the classes disagree."""
BLOCK = 4_000_000
"""Points of all motions at once."""
REVERSALS = {"A": 0, "B": 1, "C1": 2, "C2": 2, "C": 2}
Data = dict[str, np.ndarray]


def draw(count: int, seed: int) -> Data:
    """Data of outer, inner and shell rolling, a third of each."""
    dice = np.random.default_rng(seed)
    r2 = dice.uniform(0.2, 3, count)
    radii = [dice.uniform(0.1, 6, count), -r2 - dice.uniform(0.1, 6, count)]
    radii.append(-r2 * dice.uniform(0.05, 0.95, count))
    found = {"R1": np.choose(np.arange(count) % 3, radii), "R2": r2}
    mass = dice.uniform(0.1, 4, count)
    filled, hollow = dice.uniform(0.02, 2 / 3, count), dice.uniform(0.5, 2, count)
    found |= {"M": mass, "A": np.where(np.arange(count) % 3 == 2, hollow, filled) * mass * r2**2}
    found |= {n: dice.uniform(0.02, 3.12, count) for n in ("u", "u1")}
    found |= {n: dice.uniform(-4, 4, count) for n in ("k", "v", "v1", "theta", "s", "tau", "n")}
    return found


def polynomials(d: Data) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray]:
    """f (5, n), the polynomials whose roots are reversals (3, n), and x at the start, in doubles
    from the formulas on paper."""
    x, curved = np.cos(d["u"]), d["R2"] / d["R1"]
    own, a, k, mu = d["M"] * d["R2"] ** 2, d["A"], d["k"], 1 + curved
    p, axial = own + a, a * d["n"] + k * mu * x
    s2, s1 = -k * mu * (own * mu + 2 * a) / (2 * a), (own * mu + a) * axial / a
    s = np.array([p * d["s"] * np.sin(d["u"]) - s2 * x**2 - s1 * x, s1, s2])
    energy = p * (d["s"] ** 2 + d["tau"] ** 2) + a * d["n"] ** 2
    w = np.array([energy - axial**2 / a, 2 * axial * k * mu / a, -((k * mu) ** 2) / a])
    f = np.zeros((5, len(x)))
    for i in range(3):
        f[i] += w[i] / p
        f[i + 2] -= w[i] / p
        for j in range(3):
            f[i + j] -= s[i] * s[j] / p**2
    return f / mu**2, {"on the ball": s, "on the sphere": w - k * s / p}, x


def count_reversals(d: Data, trace: str, points: int) -> np.ndarray:
    """Reversals between the parallels, by changes of sign on a grid."""
    f, reversing, x = polynomials(d)
    size = max(1, BLOCK // points)
    return np.concatenate([
        _count(f[:, i : i + size], reversing[trace][:, i : i + size], x[i : i + size], points)
        for i in range(0, len(x), size)
    ])  # fmt: skip


def _count(f: np.ndarray, s: np.ndarray, x: np.ndarray, points: int) -> np.ndarray:
    low, high = (_end(f, x, side, points) for side in (-1.0, 1.0))
    steps = np.sin(np.linspace(0, np.pi / 2, points + 1)[1:-1]) ** 2
    signs = np.sign(_value(s, low + (high - low) * steps[:, None]))
    return np.sum(signs[1:] * signs[:-1] < 0, axis=0)


def _end(f: np.ndarray, x: np.ndarray, side: float, points: int) -> np.ndarray:
    """Where f first falls below zero on the way from x to +-1."""
    grid = x + (side - x) * np.linspace(0, 1, points)[:, None]
    below = _value(f, grid) < 0
    below[-1] = True
    first = np.maximum(below.argmax(axis=0), 1)
    column = np.arange(len(x))
    inner, outer = grid[first - 1, column], grid[first, column]
    for _ in range(60):
        middle = (inner + outer) / 2
        good = _value(f, middle) >= 0
        inner, outer = np.where(good, middle, inner), np.where(good, outer, middle)
    return inner


def _value(coefficients: np.ndarray, x: np.ndarray) -> np.ndarray:
    total = np.zeros_like(x)
    for c in coefficients[::-1]:
        total = total * x + c
    return total


def classes() -> Iterator[Row]:
    """Very many random motions classified, against counting."""
    from voronec.closed.classes.survey import classify_many

    data, system = draw(COUNT, 6), vo.load("demchenko")
    parameters = {n: data[n] for n in ("R1", "R2", "M", "A", "k")}
    start = {n: x for n, x in data.items() if n not in parameters}
    for trace in ("on the ball", "on the sphere"):
        began = process_time()
        labels = np.asarray(classify_many(system, parameters, start, trace).labels)
        seconds = process_time() - began
        expected = np.array([REVERSALS.get(str(label), -1) for label in labels])
        left = np.arange(COUNT)
        for points in GRIDS:
            if not len(left):
                break
            part = {n: x[left] for n, x in data.items()}
            left = left[count_reversals(part, trace, points) != expected[left]]
        tally = ", ".join(f"{n} {label}" for label, n in Counter(labels.tolist()).most_common())
        yield Row(
            f"{COUNT:g} random motions classified, outer, inner and shell, {trace}, against roots "
            "counted on a refined grid",
            f"{len(left)} otherwise; {tally}; {seconds:.1f} s of CPU",
        )


def gallery() -> Iterator[Row]:
    """A motion of every class found and drawn, by the command."""
    with tempfile.TemporaryDirectory() as folder:
        program: Any = (sys.executable, "-m", "voronec", "gallery", "demchenko", "--out", folder)
        began = os.times()
        wall, run = command(*program)
        ended = os.times()
    seconds = sum(ended[2:4]) - sum(began[2:4])
    last = (run.stderr or run.stdout).strip().splitlines()[-1:]
    told = f"{seconds:.0f} s of CPU, {wall:.0f} s by the clock"
    told = told if run.returncode == 0 else f"it failed: {' '.join(last)}"
    yield Row("`voronec gallery demchenko`: every class found and drawn", told)


ROWS: dict[str, Callable[[], Iterator[Row]]] = {"classes": classes, "gallery": gallery}

"""Methods that take turns: what each costs at equal error, and ratios with their spread."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from time import process_time
from typing import Any

import numpy as np

from voronec.accuracy.bench import at_error

LONG = 2.0
"""CPU seconds above which a run is measured twice only."""


@dataclass(frozen=True)
class Spread:
    """One figure in each repetition."""

    values: tuple[float, ...]

    @property
    def median(self) -> float:
        """The middle one."""
        return median(self.values) if self.values else np.nan

    def times(self) -> str:
        """The figure as a ratio in words."""
        if not self.values:
            return "nobody knows how many times"
        middle, least, most = (
            f"{x:.0f}" if x >= 100 else f"{x:.3g}"
            for x in (self.median, min(self.values), max(self.values))
        )
        return f"{middle} times ({least} to {most} in {len(self.values)})"

    def over(self, other: Spread) -> Spread:
        """Ratios, repetition by repetition."""
        return Spread(tuple(a / b for a, b in zip(self.values, other.values, strict=False)))


@dataclass(frozen=True)
class OneRun:
    """The error of a run, and its CPU seconds by what they count: ``run``, ``whole``."""

    error: float
    seconds: Mapping[str, float]


@dataclass(frozen=True)
class Race:
    """Runs by method and setting, from coarse to fine, each setting with its repetitions."""

    runs: Mapping[str, Mapping[float, Sequence[OneRun]]]

    def at(self, name: str, error: float, what: str = "run", extrapolate: bool = False) -> Spread:
        """Seconds at an error in each repetition; empty where that error is not reached."""
        rows = self.runs.get(name, {}).values()
        found = [
            at_error(
                [(row[k].error, row[k].seconds[what]) for row in rows], error, extrapolate
            ).seconds
            for k in range(min(map(len, rows), default=0))
        ]
        return Spread(tuple(x for x in found if x is not None))


def race(
    runs: Mapping[str, Callable[[float], OneRun]],
    first: Mapping[str, Mapping[float, OneRun]],
    errors: Iterable[float],
    rounds: int,
) -> Race:
    """``first`` says what each method does at its settings; those that lie around the errors are
    run again in turn."""
    errors = tuple(errors)
    chosen = {name: brackets(first[name], errors) for name in runs}
    found: dict[str, dict[float, list[OneRun]]] = {n: {s: [] for s in chosen[n]} for n in runs}
    for name, settings in chosen.items():
        for setting, one in settings.items():
            if max(one.seconds.values()) > LONG:
                found[name][setting].append(one)
    for turn in range(rounds):
        for name, run in runs.items():
            for setting, done in found[name].items():
                if not (turn and max(done[0].seconds.values()) > LONG):
                    done.append(run(setting))
    return Race(found)


def brackets(runs: Mapping[float, OneRun], errors: Sequence[float]) -> dict[float, OneRun]:
    """Of runs by their settings, those next to the errors on either side, and the cheapest that is
    good enough."""
    kept = set()
    for error in errors:
        worse = {s: r.error for s, r in runs.items() if r.error > error}
        better = {s: r for s, r in runs.items() if r.error <= error}
        kept |= {min(worse, key=worse.__getitem__)} if worse else set()
        if better:
            kept.add(min(better, key=lambda s: max(better[s].seconds.values())))
            kept.add(max(better, key=lambda s: better[s].error))
    return {s: r for s, r in runs.items() if s in kept}


def clock(work: Callable[[], Any]) -> tuple[Any, float]:
    """What some work gives, and its CPU seconds."""
    began = process_time()
    found = work()
    return found, process_time() - began

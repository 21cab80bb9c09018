"""Smooth runs, old code against new: the same steps and evaluations, in the same time?

    python tools/bench.py smooth OLD/.venv/bin/python NEW/.venv/bin/python [SYSTEM ...]

Every scene of the catalogue that both know is integrated by both, nine times each, by turns, in
two processes that stay.  Times are seconds of the processor for a whole ``integrate``, equations
derived and code compiled before.  Exit 1 where steps or evaluations differ, or the median over all
scenes of the ratio of medians is above ``--allow``.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import median
from typing import Any

WORKER = """
import json, sys, time
import voronec as vo

known = {}
for line in sys.stdin:
    system, scene, method = json.loads(line)
    try:
        if not system:
            found = {name: list(vo.load(name).scenes) for name in vo.names()}
        else:
            if system not in known:
                known.clear()
                known[system] = vo.derive(vo.load(system))
            began = time.process_time()
            run = vo.integrate(known[system], scene, method=method)
            spent = time.process_time() - began
            cost = run.cost
            found = [cost.method, cost.level, cost.steps, cost.evaluations, spent]
    except Exception as error:
        found = {"error": f"{type(error).__name__}: {error}"}
    print("=" + json.dumps(found), flush=True)
"""
MARGIN = 1.1
"""The largest ratio of times, new to old."""


class Worker:
    """One interpreter, which integrates what it is told."""

    def __init__(self, python: str) -> None:
        # nothing of the folder that this is called in must be imported
        self.process = subprocess.Popen(
            [python, "-c", WORKER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            cwd=tempfile.gettempdir(),
        )  # fmt: skip

    def ask(self, system: str = "", scene: str = "", method: str = "auto") -> Any:
        """The answer of the worker: the scenes of all systems, or the cost of one run."""
        assert self.process.stdin is not None and self.process.stdout is not None
        print(json.dumps([system, scene, method]), file=self.process.stdin, flush=True)
        for line in self.process.stdout:
            if line.startswith("="):
                return json.loads(line[1:])
        raise SystemExit("an interpreter ended")


@dataclass(frozen=True)
class Row:
    """What one scene took: method, level, steps and evaluations of both, median seconds of both."""

    scene: str
    old: list[Any]
    new: list[Any]

    @property
    def same(self) -> bool:
        """Whether both took the same way."""
        return self.old[:4] == self.new[:4]

    @property
    def ratio(self) -> float:
        """Of the times, new to old."""
        return float(self.new[4] / self.old[4])

    def __str__(self) -> str:
        way = f"{self.new[0]}, {self.new[2]} steps, {self.new[3]} evaluations"
        if not self.same:
            way = f"DIFFERS: {self.old[:4]} became {self.new[:4]}"
        times = f"{1e3 * self.old[4]:8.1f} {1e3 * self.new[4]:8.1f} ms {self.ratio:6.2f}"
        return f"{self.scene:44} {times}  {way}"


def rows(old: Worker, new: Worker, wanted: list[str], method: str, times: int) -> Iterator[Row]:
    """The scenes in turn; those on which either fails are told and left out."""
    scenes, known = old.ask(), new.ask()
    for system in wanted or scenes:
        for scene in scenes.get(system, ()):
            name = f"{system} {scene}"
            if scene not in known.get(system, ()):
                print(f"{name}: one side alone has it")
                continue
            runs = [(old.ask(system, scene, method), new.ask(system, scene, method))]  # warm
            if not any(isinstance(x, dict) for x in runs[0]):
                runs = [
                    (old.ask(system, scene, method), new.ask(system, scene, method))
                    for _ in range(times)
                ]
            failed = [x["error"] for x in runs[0] if isinstance(x, dict)]
            if failed:
                print(f"{name}: {len(failed)} of 2 refuse: {failed[-1][:120]}")
                continue
            medians = [median(run[side][4] for run in runs) for side in (0, 1)]
            first = runs[0]
            yield Row(name, [*first[0][:4], medians[0]], [*first[1][:4], medians[1]])


def main() -> int:
    """Compare, print, judge."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("old", help="the Python of the old code")
    parser.add_argument("new", help="the Python of the new code")
    parser.add_argument("systems", nargs="*", help="by default all")
    parser.add_argument("--method", default="auto")
    parser.add_argument("--times", type=int, default=9)
    parser.add_argument("--allow", type=float, default=MARGIN, help="the largest ratio of times")
    given = parser.parse_intermixed_args()
    old, new = Worker(given.old), Worker(given.new)
    found = []
    for row in rows(old, new, given.systems, given.method, given.times):
        print(row, flush=True)
        found.append(row)
    if not found:
        print("no scene was integrated by both")
        return 1
    ratio, different = median(row.ratio for row in found), [r for r in found if not r.same]
    print(
        f"{len(found)} scenes; median ratio of times {ratio:.3f}, from "
        f"{min(r.ratio for r in found):.2f} to {max(r.ratio for r in found):.2f}; "
        f"{len(different)} took other steps"
    )
    return 1 if different or ratio > given.allow else 0

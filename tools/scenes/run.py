"""Random motions of random systems, the engine against an independent route in high precision.

    .venv/bin/python tools/fuzz.py scenes --seed 1 --count 500
    .venv/bin/python tools/fuzz.py scenes --seed 1 --kind nonsmooth --seconds 60
    .venv/bin/python tools/fuzz.py scenes --seed 1 --kind smooth --only 317 --system sleigh
    .venv/bin/python tools/fuzz.py scenes --seed 1 --kind smooth --first 1500 --count 1500

Systems are those of the catalogue and made ones (``mechanics.py``); parameters, starts, grids,
outputs, methods and tolerances are drawn, near and at singular places of the coordinates among
them.  The truth comes from ``reference.py``.  What the truth itself loses is known from a
second resolution, what the motion makes of small errors from motions nearby, which leave it at the
start, at some instants on the way, and where it is fastest: an answer is *wrong* where it is off by
more than the larger of 1e-10 and 100 u times the condition of that output, and
no error was raised; it is *refused* where an error was raised though the multiplier equations are
well conditioned (under 1e8) all along.  Refusals of motions that are not smooth are not counted,
nor are those of starts at which the coordinates themselves are singular: they are told apart.
What is wrong and comes with a note that errors have added up is told apart, too.
The status is 1 where anything was wrong or broke down, or where more than 0.5 % was refused.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from time import monotonic
from typing import Any

from shared.child_time import ChildClock

from scenes.scene import KINDS, catalogue_names

PATIENCE = 120.0
"""Seconds of work after which a scene counts as one that hangs."""
WAIT = 1800.0
"""Seconds after which it hangs though it does not work."""
REFUSALS = 0.005
"""So large a part of the scenes may be refused."""
FAILURES = ("wrong", "crash", "hang", "broken")


@dataclass(frozen=True)
class Verdict:
    """What came of one scene."""

    kind: str
    index: int
    system: str
    outcome: str
    detail: str = ""
    snippet: str = ""


def judge_scenes(seed: int, system: str | None, pipe: Connection) -> None:
    """Judge scenes as they are asked for: a process of its own, since scenes may end it."""
    from scenes.scene import Workshop

    workshop = Workshop(seed, system)
    while True:
        asked = pipe.recv()
        if asked is None:
            return
        kind, index = asked
        found = workshop.judge(kind, index, lambda *about: pipe.send(about))
        pipe.send(Verdict(kind, index, *found))


class Court:
    """Scenes judged one after the other, in a process that is begun anew where one ends it."""

    def __init__(self, seed: int, system: str | None) -> None:
        self.seed, self.system = seed, system
        self._context = multiprocessing.get_context("spawn")
        self._process: Any = None
        self._pipe: Any = None

    def verdict(self, kind: str, index: int) -> Verdict:
        """The verdict on one scene."""
        if self._process is None:
            self._pipe, theirs = self._context.Pipe()
            self._process = self._context.Process(
                target=judge_scenes, args=(self.seed, self.system, theirs), daemon=True
            )
            self._process.start()
            theirs.close()
        self._pipe.send((kind, index))
        outcome, (system, snippet) = "hang", (self.system or "", "")
        try:
            while self._answers():
                found = self._pipe.recv()
                if isinstance(found, Verdict):
                    return found
                system, snippet = found  # what is being judged
        except (EOFError, ConnectionResetError):
            outcome = "crash"
        self.close()
        return Verdict(kind, index, system, outcome, f"the process: {outcome}", snippet)

    def _answers(self) -> bool:
        """Whether an answer came before the process has worked for too long."""
        clock = ChildClock(self._process.pid)
        while not self._pipe.poll(1.0):
            if clock.work_time() > PATIENCE or clock.wait_time() > WAIT:
                return False
        return True

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None


def scenes(kinds: list[str], only: int | None, count: int) -> Iterator[tuple[str, int]]:
    """Kind and number of the scenes, kinds by turns."""
    if only is not None:
        yield from ((kind, only) for kind in kinds)
        return
    block = 5  # scenes of a block share their system
    for i in range(count):
        yield kinds[i // block % len(kinds)], i // block // len(kinds) * block + i % block


def main() -> int:
    """Judge scenes until their number or the time is reached."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=10**9, help="how many scenes")
    parser.add_argument("--first", type=int, default=0, help="the number of the first of each kind")
    parser.add_argument("--seconds", type=float, help="how long")
    parser.add_argument("--kind", choices=[*KINDS, "all"], default="all")
    parser.add_argument("--system", help="a system of the catalogue, or 'made'")
    parser.add_argument("--only", type=int, help="this scene alone")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    if given.system not in (None, "made", *catalogue_names()):
        parser.error(f"there is no system '{given.system}'")
    if given.count == 10**9 and given.seconds is None and given.only is None:
        given.count = 100
    kinds = [*KINDS] if given.kind == "all" else [given.kind]
    # smooth motions are most of what people integrate
    weighed = [*kinds, "smooth", "smooth"] if given.kind == "all" else kinds
    began, court, found = monotonic(), Court(given.seed, given.system), []
    numbered = Counter[str]()
    try:
        for kind, _ in scenes(weighed, given.only, given.count):
            if given.seconds is not None and monotonic() - began > given.seconds:
                break
            index = given.only if given.only is not None else given.first + numbered[kind]
            numbered[kind] += 1
            verdict = court.verdict(kind, index)
            found.append(verdict)
            _tell(verdict, given)
    except KeyboardInterrupt:
        print("stopped by hand", file=sys.stderr)
    finally:
        court.close()
    return _summary(found, given)


def _tell(verdict: Verdict, given: argparse.Namespace) -> None:
    if given.json or (verdict.outcome not in (*FAILURES, "refused") and given.only is None):
        return
    system = f" --system {given.system}" if given.system else ""
    again = f"--seed {given.seed} --kind {verdict.kind}{system} --only {verdict.index}"
    print(f"{verdict.outcome}: {verdict.system}: {verdict.detail}", flush=True)
    print(f"    again: .venv/bin/python tools/fuzz.py scenes {again}")
    print("".join(f"    {line}\n" for line in verdict.snippet.splitlines()), flush=True)


def _summary(found: list[Verdict], given: argparse.Namespace) -> int:
    tally = Counter((v.kind, v.outcome) for v in found)
    judged = sum(v.outcome in ("right", "wrong", "refused") for v in found)
    failed = sum(v.outcome in FAILURES for v in found)
    refused = sum(v.outcome == "refused" for v in found)
    if given.json:
        counts = {f"{kind}: {outcome}": n for (kind, outcome), n in sorted(tally.items())}
        bad = [asdict(v) for v in found if v.outcome in (*FAILURES, "refused")]
        print(json.dumps({"seed": given.seed, "counts": counts, "failures": bad}, indent=1))
    else:
        print(f"seed {given.seed}: {len(found)} scenes, {judged} judged")
        for (kind, outcome), number in sorted(tally.items()):
            print(f"  {kind:10} {outcome:24} {number}")
    return int(failed > 0 or refused > max(REFUSALS * judged, 0))

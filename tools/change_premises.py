"""Premises of a paper's derived systems changed one at a time, and what is proved all the same.

    python tools/change_premises.py [--paper NAME] [--section K] [--seconds S]

A premise is a parameter in the Lagrangian, a constraint, or the definition of a quasi-velocity of a
system that the dictionaries of a section derive.  Each is changed (doubled, or a sign turned), and
the section is audited again.  Printed are how many proved records fail, those that are proved all
the same though what is derived beside them has changed, and those that fail with no premise: such
a record must be true whatever the premise, or it was compared with the print.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import voronec as vo
from voronec.algebra.symbols import velocity
from voronec.audit.record import worst
from voronec.audit.run import Work, items
from voronec.audit.transcript import formulas_by_label
from voronec.catalogue import load_paper
from voronec.errors import VoronecError

__all__ = ["Premise", "main", "premises"]

Verdicts = dict[str, tuple[str, str]]
"""Record -> its verdict, and what is printed as derived."""


@dataclass(frozen=True)
class Premise:
    """One premise of one system, and the system without it."""

    system: str
    what: str
    changed: vo.System


def main() -> int:
    """Change every premise; print what fails and what is proved all the same."""
    chosen = _arguments()
    begun = time.process_time()
    for k in _sections(chosen):
        seen: dict[str, vo.System] = {}
        before = _audited(chosen.paper, k, partial(_noted, seen))
        print(f"section {k}: {len(before)} records, derived from {', '.join(seen) or 'no system'}")
        failed: set[str] = set()
        for premise in (p for system in seen.values() for p in premises(system)):
            after = _after(chosen.paper, k, premise)
            good = [name for name, (verdict, _) in before.items() if verdict == "proved"]
            fail = [n for n in good if after.get(n, ("", ""))[0] != "proved"]
            same = [n for n in good if n not in fail and after[n][1] != before[n][1]]
            failed |= set(fail)
            told = f"; proved all the same: {', '.join(same)}" if same else ""
            print(f"  {premise.system}, {premise.what}: {len(fail)} fail{told}", flush=True)
            if chosen.seconds and time.process_time() - begun > chosen.seconds:
                return 0
        never = [n for n, (v, _) in before.items() if v == "proved" and n not in failed]
        print(f"  fail with no premise: {', '.join(never) or 'none'}", flush=True)
    return 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--paper", default="demchenko")
    parser.add_argument("--section", type=int, default=0, help="its number; 0 for all")
    parser.add_argument("--seconds", type=float, default=0.0, help="of CPU; 0 for no limit")
    return parser.parse_args()


def _sections(chosen: argparse.Namespace) -> list[int]:
    count = len(load_paper(chosen.paper).sections)
    return [chosen.section] if chosen.section else list(range(1, count + 1))


def premises(system: vo.System) -> Iterator[Premise]:
    """Every premise of a system, changed."""
    energy = system.lagrangian
    symbols = {getattr(p, "symbol", p) for p in system.parameters}
    for symbol in sorted(energy.free_symbols & symbols, key=str):
        changed = replace(system, lagrangian=energy.xreplace({symbol: 2 * symbol}))
        yield Premise(system.name, f"{symbol} doubled in the Lagrangian", changed)
    dots = [velocity(q) for q in (*system.fibration.base, *system.fibration.fibre)]
    for i, constraint in enumerate(system.constraints):
        held = [d for d in dots[: len(system.fibration.base)] if constraint.has(d)]
        if held:
            turned = constraint.expand().xreplace({held[0]: -held[0]})
            every = (*system.constraints[:i], turned, *system.constraints[i + 1 :])
            yield Premise(
                system.name,
                f"a sign turned in constraint {i + 1}",
                replace(system, constraints=every),
            )
    frame = system.frame
    if isinstance(frame, vo.Frame) and frame.brackets is None:
        for i, (name, value) in enumerate(zip(frame.velocities, frame.expressions, strict=True)):
            values = (*frame.expressions[:i], 2 * value, *frame.expressions[i + 1 :])
            pairs = dict(zip(frame.velocities, values, strict=True))
            yield Premise(
                system.name,
                f"{name} doubled in its definition",
                replace(system, frame=vo.Frame.quasi(pairs)),
            )


def _noted(seen: dict[str, vo.System], system: vo.System) -> vo.System:
    return seen.setdefault(system.name, system)


def _after(paper: str, k: int, premise: Premise) -> Verdicts:
    """The verdicts with one premise changed; nothing where no system comes of it."""

    def change(system: vo.System) -> vo.System:
        return premise.changed if system.name == premise.system else system

    try:
        return _audited(paper, k, change)
    except VoronecError:
        return {}


def _audited(paper: str, k: int, change: Callable[[vo.System], Any]) -> Verdicts:
    """The verdicts of a section whose systems are changed before they are derived."""
    derive = vo.derive

    def changed(system: vo.System, *arguments: Any, **options: Any) -> Any:
        return derive(change(system), *arguments, **options)

    for name in [n for n in sys.modules if n.startswith(f"voronec.systems.{paper}")]:
        del sys.modules[name]  # what is kept there was derived from other premises
    vo.derive = changed
    try:
        whole = load_paper(paper)
        work = Work(whole.sections[k - 1], formulas_by_label(whole.sections), corrects=False)
        return {item.called: _verdict(work, item) for item in items(work.transcript)}
    finally:
        vo.derive = derive


def _verdict(work: Work, item: Any) -> tuple[str, str]:
    found = work.examine(item)
    return worst(e.record.verdict for e in found), "; ".join(e.record.derived or "" for e in found)


if __name__ == "__main__":
    sys.exit(main())

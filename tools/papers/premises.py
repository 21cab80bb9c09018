"""Premises of a paper's derived systems changed one at a time, and what is proved all the same.

    python tools/paper.py premises [--paper NAME] [--section K] [--seconds S] [--system NAME]
                                    [--premise WORDS]

A premise is a parameter in the Lagrangian, a velocity in it, that no place of the fibre is marked
out by it, a force, a constraint, or the definition of a quasi-velocity of a system that the
dictionaries of a section derive. Each is changed (doubled, or a sign turned), and the records that
name the system as their source are audited again. Printed are how many of them fail, which are
proved all the same though what is derived beside them has changed, and which fail with no premise
of the system they name: such a record is true whatever the system does, or it was compared with the
print. Then the exit status is 1.
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
from voronec.audit import Check, Sentence
from voronec.audit.paper_audit import AuditItem, Work, items
from voronec.audit.record import worst
from voronec.audit.transcript import formulas_by_label
from voronec.declaration.catalogue import load_paper
from voronec.errors import VoronecError

NOTHING = ("nothing is claimed", "defined in words", "a condition")
"""How the method of a record begins that was compared with nothing."""


@dataclass(frozen=True)
class Premise:
    """One premise of one system, and the system without it."""

    system: str
    what: str
    changed: vo.System


@dataclass(frozen=True)
class PremiseVerdict:
    """A record's verdict, what is printed as derived beside each source, and all its sources."""

    verdict: str
    derived: tuple[tuple[str, str], ...]
    sources: str

    @property
    def good(self) -> bool:
        """Whether something was compared with what is derived, and agrees."""
        return self.verdict == "proved" and bool(self.sources)

    def names(self, system: str) -> bool:
        """Whether a system is a source of it."""
        return f"'{system}'" in self.sources

    def beside(self, system: str) -> list[str]:
        """What is printed as derived beside the formulas that name a system."""
        return [derived for source, derived in self.derived if f"'{system}'" in source]


Verdicts = dict[str, PremiseVerdict]


def main() -> int:
    """Change every premise; print what fails and what is proved all the same."""
    chosen = _arguments()
    begun, wrong = time.process_time(), 0
    for k in _sections(chosen):
        seen: dict[str, vo.System] = {}
        before = _audit(chosen.paper, k, partial(note_system, seen))
        print(f"section {k}: {len(before)} records, derived from {', '.join(seen) or 'no system'}")
        for name, system in seen.items():
            rest = {r for r, told in before.items() if told.good and told.names(name)}
            if not rest or chosen.system not in ("", name):
                continue
            wrong += _change_premises(chosen, k, system, before, rest)
            if chosen.seconds and time.process_time() - begun > chosen.seconds:
                print(f"stopped after {chosen.seconds:.0f} s")
                return int(wrong > 0)
    return int(wrong > 0)


def _change_premises(
    chosen: argparse.Namespace, k: int, system: vo.System, before: Verdicts, names: set[str]
) -> int:
    """Change the premises of one system; how many of the records that name it never fail, or are
    proved all the same though what is derived has changed."""
    never, held, count = set(names), set(names), 0
    for premise in premises(system):
        if chosen.premise not in premise.what:
            continue
        after, refusal = _after(chosen.paper, k, premise, names)
        fail = {n for n in names if n not in after or not after[n].good}
        good = {n for n in names - fail if before[n].verdict == "proved"}
        name = system.name
        same = [n for n in good if after[n].beside(name) != before[n].beside(name)]
        never -= fail
        held -= set() if refusal else fail
        count += len(same)
        told = f"; proved all the same: {', '.join(sorted(same))}" if same else ""
        told += f"; the section is refused: {refusal}" if refusal else ""
        what = f"{premise.system}, {premise.what}"
        print(f"  {what}: {len(fail)} of {len(names)} fail{told}", flush=True)
    for what, which in (("fail with no premise", never), ("fail by refusal alone", held - never)):
        print(f"  {system.name}: {what}: {', '.join(sorted(which)) or 'none'}", flush=True)
    return len(never) + count


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--paper", default="demchenko")
    parser.add_argument("--section", type=int, default=0, help="its number; 0 for all")
    parser.add_argument("--system", default="", help="one of those that the sections derive")
    parser.add_argument("--premise", default="", help="words in what is changed; all by default")
    parser.add_argument("--seconds", type=float, default=0.0, help="of CPU; 0 for no limit")
    return parser.parse_args()


def _sections(chosen: argparse.Namespace) -> list[int]:
    count = len(load_paper(chosen.paper).sections)
    return [chosen.section] if chosen.section else list(range(1, count + 1))


def premises(system: vo.System) -> Iterator[Premise]:
    """Every premise of a system, changed."""
    for what, changes in (*_energies(system), *_constraints(system), *_velocities(system)):
        yield Premise(system.name, what, replace(system, **changes))


Change = tuple[str, dict[str, Any]]


def _energies(system: vo.System) -> Iterator[Change]:
    """Parameters and velocities in the Lagrangian, its symmetry along the fibre, and forces."""
    energy = system.lagrangian
    symbols = {getattr(p, "symbol", p) for p in system.parameters}
    dots = [velocity(q) for q in system.fibration.base]
    for symbol in (*sorted(energy.free_symbols & symbols, key=str), *dots[:1]):
        if energy.has(symbol):
            changed = energy.xreplace({symbol: 2 * symbol})
            yield f"{symbol} doubled in the Lagrangian", {"lagrangian": changed}
    for place in system.fibration.fibre[:1]:
        yield f"the Lagrangian times 1 + {place}^2", {"lagrangian": energy * (1 + place**2)}
    for place, force in list(system.forces.items())[:1]:
        yield f"the force on {place} doubled", {"forces": {**system.forces, place: 2 * force}}


def _constraints(system: vo.System) -> Iterator[Change]:
    dots = [velocity(q) for q in (*system.fibration.base, *system.fibration.fibre)]
    for i, constraint in enumerate(system.constraints):
        held = [d for d in dots[: len(system.fibration.base)] if constraint.has(d)]
        if held:
            turned = constraint.expand().xreplace({held[0]: -held[0]})
            every = (*system.constraints[:i], turned, *system.constraints[i + 1 :])
            yield f"a sign turned in constraint {i + 1}", {"constraints": every}


def _velocities(system: vo.System) -> Iterator[Change]:
    frame = system.frame
    if not isinstance(frame, vo.Frame) or frame.brackets is not None:
        return
    for i, (name, value) in enumerate(zip(frame.velocities, frame.expressions, strict=True)):
        values = (*frame.expressions[:i], 2 * value, *frame.expressions[i + 1 :])
        pairs = dict(zip(frame.velocities, values, strict=True))
        yield f"{name} doubled in its definition", {"frame": vo.Frame.quasi(pairs)}


def note_system(seen: dict[str, vo.System], system: vo.System) -> vo.System:
    """The system as it is; the first one of each name stands for those that share it."""
    seen.setdefault(system.name, system)
    return system


def _after(paper: str, k: int, premise: Premise, names: set[str]) -> tuple[Verdicts, str]:
    """The verdicts of some records with one premise changed; none, and why, where a dictionary of
    the section is refused."""

    def change(system: vo.System) -> vo.System:
        """The same change of each system of that name: of a ball outside, inside, on a plane."""
        if system.name != premise.system:
            return system
        found = [p.changed for p in premises(system) if p.what == premise.what]
        return found[0] if found else system

    try:
        return _audit(paper, k, change, names), ""
    except VoronecError as error:
        return {}, str(error)


def _audit(
    paper: str, k: int, change: Callable[[vo.System], Any], names: set[str] | None = None
) -> Verdicts:
    """The verdicts of a section whose systems are changed before they are derived."""
    derive, descend = vo.derive, vo.descend

    def with_change(make: Any) -> Any:
        return lambda system, *arguments, **options: make(change(system), *arguments, **options)

    for name in [n for n in sys.modules if n.startswith(f"voronec.systems.{paper}")]:
        del sys.modules[name]  # what is kept there was derived from other premises
    vo.derive, vo.descend = with_change(derive), with_change(descend)
    try:
        whole = load_paper(paper)
        work = Work(whole.sections[k - 1], formulas_by_label(whole.sections), corrects=False)
        every = [i for i in items(work.transcript) if names is None or i.designation in names]
        return {item.designation: _tell(work, item) for item in every}
    finally:
        vo.derive, vo.descend = derive, descend


def _tell(work: Work, item: AuditItem) -> PremiseVerdict:
    found = work.examine(item)
    checks: list[Check | Sentence] = [f.display.check(f.position) for f in item.formulas]
    checks += [item.sentence] if item.sentence is not None else []
    origins = [_origins(work, check) for check in checks]
    nothing = any(e.record.method.startswith(NOTHING) for e in found)
    return PremiseVerdict(
        worst(e.record.verdict for e in found),
        tuple((o, e.record.derived or "") for o, e in zip(origins, found, strict=True)),
        "" if nothing else "; ".join(sorted({*origins} - {""})),
    )


def _origins(work: Work, check: Check | Sentence) -> str:
    """What a check is compared with: its own source in place of that of its dictionary."""
    if check.source:
        return check.source
    if isinstance(check, Check) and check.role in ("words", "condition", "definition"):
        return ""
    several = check.also if isinstance(check, Check) else ()
    return "; ".join(work.bench.study(check, name).origin for name in ("", *several))

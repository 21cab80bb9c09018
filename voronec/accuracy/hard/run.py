"""All methods on all cases, one after another."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from voronec.accuracy.hard.case import HardCase
from voronec.accuracy.hard.reference import Reference, reference
from voronec.accuracy.hard.trial import Trial, attempt
from voronec.declaration.catalogue import load
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit
from voronec.motion.methods import METHODS

__all__ = ["CaseResult", "available", "trials"]


@dataclass(frozen=True, eq=False)
class CaseResult:
    """A case, its reference (None where no motion starts) and what every method made of it."""

    case: HardCase
    reference: Reference | None
    trials: tuple[Trial, ...]

    @property
    def good(self) -> bool:
        """Whether the tool's own choice is never silently wrong."""
        return all(t.good for t in self.trials if t.automatic)


def available(methods: Iterable[str] = METHODS) -> tuple[str, ...]:
    """Those of the methods that are installed."""
    return tuple(m for m in methods if METHODS[m].is_there)


def trials(
    cases: Sequence[HardCase],
    methods: Sequence[str] = (),
    progress: Callable[[str], None] | None = None,
) -> Iterator[CaseResult]:
    """The findings case by case, each as soon as it is there.

    ``methods`` are those wanted, ``auto`` and ``default`` among them or not; by default these two
    (the tool's own choice at its finest, and at the tolerance of ``integrate``), whatever the case
    says is worth waiting for, and the closed form where the system declares one.  Where ``auto``
    takes a method that is tried as well, it is tried once and marked.  A case without a reference
    that can be had here is ``unjudged``.
    """
    derived: dict[str, VoronecEquations] = {}
    for position, case in enumerate(cases):
        say = progress or (lambda _: None)
        say(f"{position + 1}/{len(cases)} {case.name}: reference ...")
        if case.system not in derived:
            derived[case.system] = derive(load(case.system))
        equations = derived[case.system]
        found: list[Trial] = []
        try:
            known = reference(case, equations) if case.level else None
        except EngineLimit as limit:
            yield CaseResult(case, None, (Trial(case.name, "-", "unjudged", reason=str(limit)),))
            continue
        own = ("closed-form",) if case.level and equations.system.motion is not None else ()
        for method in methods or ("auto", "default", *available(case.methods), *own):
            if any(t.automatic and t.chosen == method for t in found):
                continue
            say(f"{position + 1}/{len(cases)} {case.name}: {method} ...")
            found.append(attempt(case, equations, method, known))
        yield CaseResult(case, known, tuple(found))

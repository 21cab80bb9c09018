"""Changes of a formula that has no value as printed: those that give it one, and one that fits."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from voronec.audit.correction.changes import Change, applied
from voronec.audit.correction.goals import along, holds
from voronec.audit.correction.sampling import Sampler
from voronec.audit.latex.nodes import Derivative, Integral, Name, Partial, walk
from voronec.audit.latex.reader import read
from voronec.audit.meaning import SENSELESS, UnknownName, evaluate
from voronec.audit.paper import Check
from voronec.audit.structure import names_constant, whole_name
from voronec.audit.study import Study, key_of
from voronec.audit.transcript import assignments
from voronec.errors import DefinitionError

__all__ = ["Screen", "unknown_places"]

SEEDS = (0, 2)
"""The points at which a changed formula must hold before it is put to the proof: roots are real."""
WORK = {Derivative: 60, Partial: 1500}
"""How many derivatives are taken at each point, for all changes together."""
FEWER = 4
"""For how many values of the free indices it is tried at each point."""


class Screen:
    """Points at which changed formulas are tried; what they share is evaluated once."""

    def __init__(self, check: Check, study: Study) -> None:
        self.check, self.study = check, study
        self.samplers = [Sampler(study, seed, along=along(check), work=WORK) for seed in SEEDS]

    def fitting(self, printed: str, changes: Iterable[Change]) -> Iterator[Change]:
        """The changes after which the formula has a value and holds at the points."""
        for change in changes:
            latex, _ = applied(printed, change.pieces)
            if self._fits(latex):
                yield change

    def _fits(self, latex: str) -> bool:
        try:
            chain = read(latex, self.study.vocabulary)
            if any(isinstance(part, Integral) for part in walk(chain)):
                return True  # it has no numbers to go by
            wheres = assignments(chain, self.study)[:FEWER]
            return all(
                holds(chain, self.check, self.study, sampler, where)
                for sampler in self.samplers
                for where in wheres
            )
        except SENSELESS:
            return False


def unknown_places(printed: str, study: Study, new: Collection[str] = ()) -> list[tuple[int, int]]:
    """Where the first name stands that is unknown and none of the ``new`` ones; else nothing."""
    try:
        chain = read(printed, study.vocabulary)
        (where, *_) = assignments(chain, study)
        for part in chain.parts:
            if not names_constant(part) and whole_name(part, study) not in new:
                evaluate(part, study, where)
    except UnknownName as unknown:
        names = [part for part in walk(chain) if isinstance(part, Name)]
        return [name.at for name in names if _called(name) == unknown.name]
    except SENSELESS:
        return []
    return []


def _called(name: Name) -> str:
    try:
        return key_of(name)
    except DefinitionError:
        return ""

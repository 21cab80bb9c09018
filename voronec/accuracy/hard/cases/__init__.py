"""The catalogue of hard cases: those of this package, and those beside systems of others.

A plugin declares its own beside its system, ``HARD_CASES = (HardCase(...), ...)`` in the module
that holds ``SYSTEM``.  Nothing is imported from a system here: systems are named.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module

from voronec.accuracy.hard.case import HardCase
from voronec.accuracy.hard.cases.growth import GROWTH
from voronec.accuracy.hard.cases.limits import LIMITS
from voronec.accuracy.hard.cases.poles import POLES
from voronec.accuracy.hard.cases.spans import SPANS
from voronec.declaration.catalogue import entries
from voronec.errors import DefinitionError, did_you_mean

__all__ = ["CASES", "QUICK", "every_case", "named_cases"]

CASES: tuple[HardCase, ...] = (*POLES, *GROWTH, *LIMITS, *SPANS)
"""The cases of this package."""
QUICK = ("near-the-pole", "start-at-the-pole", "near-a-separatrix", "turning-point", "no-gyroscope")
"""A short selection, for tests."""
OWN = "voronec"


def every_case() -> tuple[tuple[HardCase, ...], tuple[str, ...]]:
    """All cases, and a warning for each module of others that could not be read."""
    found, warnings = list(CASES), []
    for entry in entries()[0]:
        if entry.distribution == OWN or not entry.module:
            continue
        try:
            found += _beside(entry.module)
        except Exception as error:  # somebody else's module may fail in any way
            warnings.append(f"the hard cases of system '{entry.name}' cannot be read: {error}")
    return tuple(found), tuple(warnings)


def _beside(module: str) -> tuple[HardCase, ...]:
    declared = getattr(import_module(module), "HARD_CASES", ())
    for case in declared:
        if not isinstance(case, HardCase):
            raise DefinitionError(
                f"{module}: an entry of HARD_CASES is a {type(case).__name__}; write "
                "HARD_CASES = (HardCase(...),)"
            )
    return tuple(declared)


def named_cases(names: Iterable[str], among: Iterable[HardCase]) -> tuple[HardCase, ...]:
    """The cases of those names; ``DefinitionError`` with the nearest names for an unknown one."""
    known = {case.name: case for case in among}
    chosen = []
    for name in names:
        if name not in known:
            raise DefinitionError(f"there is no hard case '{name}'{did_you_mean(name, known)}")
        chosen.append(known[name])
    return tuple(chosen)

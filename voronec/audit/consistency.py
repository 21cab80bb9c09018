"""Definitions are consistent where the formulas that use them are proved with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from voronec.audit.latex.nodes import Call, Chain, Dot, Name, Variation, walk
from voronec.audit.record import FormulaRecord
from voronec.audit.study import name_or_nothing


@dataclass(frozen=True)
class Examination:
    """A formula with its verdict, and what others need to know of it: plain data.

    name
        the label, or the place, of its unit; ``label`` is the label alone.
    defines
        the key of the name that a definition defines, whatever its indices.
    uses
        the keys of the names in the formula.
    premises
        labels of the conditions that are in force.
    condition
        whether the formula is such a condition.
    """

    record: FormulaRecord
    name: str
    label: str | None = None
    defines: str = ""
    uses: tuple[str, ...] = ()
    premises: tuple[str, ...] = ()
    condition: bool = False


def with_uses(examined: Examination, everything: Sequence[Examination]) -> FormulaRecord:
    """The record of a formula; for a definition it names the formulas that are proved with it."""
    record = examined.record
    if record.verdict != "definition" or not (examined.defines or examined.condition):
        return record
    users = _users(examined, everything)
    good = [e.name for e in users if e.record.verdict == "proved"]
    good += [f"{e.name} as corrected" for e in users if e.record.correction]
    called = ", ".join(dict.fromkeys(good))
    text = f"consistent with its uses in {called}" if good else "no proved formula here needs it"
    return replace(record, method=f"{record.method}; {text}")


def _users(examined: Examination, everything: Sequence[Examination]) -> list[Examination]:
    """What names the thing defined, or names what another definition makes of it."""
    users: list[Examination] = []
    waiting = [examined]
    while waiting:
        one = waiting.pop()
        for other in everything:
            uses = one.label in other.premises if one.condition else one.defines in other.uses
            if uses and other is not examined and other not in users:
                users.append(other)
                if other.record.verdict == "definition" and other.defines:
                    waiting.append(other)
    return [e for e in everything if e in users]


def defined_name(chain: Chain) -> str:
    """What a formula defines: its left side, or the last thing there that is varied."""
    left = chain.parts[0]
    if isinstance(left, Call):
        left = left.function
    if isinstance(left, (Name, Dot, Variation)):
        return _family(left)
    varied = [part for part in walk(left) if isinstance(part, (Variation, Name))]
    last = [part for part in varied if isinstance(part, Variation)][-1:]
    return _family((last or varied)[0]) if varied else ""


def families(chain: Chain | None) -> tuple[str, ...]:
    """Keys of the names, velocities and variations in a formula, whatever their indices."""
    keys = [_family(part) for part in walk(chain) if isinstance(part, (Name, Dot, Variation))]
    return tuple(dict.fromkeys(keys))


def _family(node: Any) -> str:
    return name_or_nothing(node, lambda _: "#")

"""Definitions are consistent where the formulas that use them are proved with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from voronec.audit.nodes import Call, Chain, Dot, Name, Variation, walk
from voronec.audit.paper import Check
from voronec.audit.record import FormulaRecord
from voronec.audit.study import key_of
from voronec.audit.transcript import Formula
from voronec.errors import DefinitionError

__all__ = ["Examined", "with_uses"]


@dataclass(frozen=True)
class Examined:
    """A formula with its verdict; ``chain`` is ``None`` where it could not be read.

    ``ordinal`` is the place of its unit in the section.
    """

    formula: Formula
    check: Check
    chain: Chain | None
    record: FormulaRecord
    ordinal: int

    @property
    def called(self) -> str:
        """The label in parentheses, or the place."""
        label = self.formula.unit.label
        return f"({label})" if label else f"display {self.ordinal}"


def with_uses(examined: Examined, everything: Sequence[Examined]) -> FormulaRecord:
    """The record of a formula; for a definition it names the formulas that are proved with it."""
    record, chain = examined.record, examined.chain
    if record.verdict != "definition" or chain is None:
        return record
    others = [e for e in everything if e is not examined and e.chain is not None]
    if examined.check.role == "condition":
        users = [e for e in others if examined.formula.unit.label in e.check.given]
    else:
        users = [e for e in others if _defined(chain) in _families(e.chain)]
    good = [e.called for e in users if e.record.verdict == "proved"]
    good += [f"{e.called} as corrected" for e in users if e.record.correction]
    called = ", ".join(dict.fromkeys(good))
    text = f"consistent with its uses in {called}" if good else "not used in the formulas audited"
    return replace(record, method=f"{record.method}; {text}")


def _defined(chain: Chain) -> str:
    """What a formula defines: its left side, or the last thing there that is varied."""
    left = chain.parts[0]
    if isinstance(left, Call):
        left = left.function
    if isinstance(left, (Name, Dot, Variation)):
        return _family(left)
    varied = [part for part in walk(left) if isinstance(part, (Variation, Name))]
    last = [part for part in varied if isinstance(part, Variation)][-1:]
    return _family((last or varied)[0])


def _families(chain: Chain | None) -> set[str]:
    """Keys of the names, velocities and variations in a formula, whatever their indices."""
    return {_family(part) for part in walk(chain) if isinstance(part, (Name, Dot, Variation))}


def _family(node: Any) -> str:
    try:
        return key_of(node, lambda _: "#")
    except DefinitionError:
        return ""

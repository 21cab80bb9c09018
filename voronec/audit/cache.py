"""Finished verdicts of an audit on disk, each under a digest of what it rests on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from voronec.audit.consistency import Examined
from voronec.audit.record import FormulaRecord
from voronec.keeping import Store

__all__ = ["Cache"]

KEPT = 200
"""How many sections, in whatever state of their sources, keep their verdicts."""


@dataclass(frozen=True)
class Cache:
    """A folder with one file for each unit; a file that is missing or broken is no verdict."""

    folder: Path

    @classmethod
    def of_user(cls) -> Cache:
        """The folder ``voronec/audit`` among the user's caches."""
        return cls(Store.of_user("audit").folder)

    def load(self, key: str, ordinal: int) -> list[Examined] | None:
        """The verdicts of a unit, or ``None``."""
        try:
            return [_examined(entry) for entry in Store(self.folder).load(key, str(ordinal))]
        except (ValueError, TypeError, KeyError, AttributeError):
            return None

    def store(self, key: str, ordinal: int, found: Sequence[Examined]) -> None:
        """Keep the verdicts of a unit, whole or not at all."""
        Store(self.folder, KEPT).save(key, str(ordinal), [asdict(e) for e in found])


def _examined(entry: dict[str, Any]) -> Examined:
    rest = {name: value for name, value in entry.items() if name != "record"}
    rest["uses"], rest["given"] = tuple(rest["uses"]), tuple(rest["given"])
    return Examined(FormulaRecord.from_dict(entry["record"]), **rest)

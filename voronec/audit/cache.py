"""Finished verdicts on disk, each under a digest of what it rests on."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from voronec.audit.consistency import Examined
from voronec.audit.record import FormulaRecord

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
        home = Path.home()
        if sys.platform == "win32":
            base = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
        elif sys.platform == "darwin":
            base = home / "Library" / "Caches"
        else:
            base = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
        return cls(base / "voronec" / "audit")

    def load(self, key: str, ordinal: int) -> list[Examined] | None:
        """The verdicts of a unit, or ``None``."""
        try:
            entries = json.loads(self._file(key, ordinal).read_text(encoding="utf-8"))
            return [_examined(entry) for entry in entries]
        except (OSError, ValueError, TypeError, KeyError):
            return None

    def store(self, key: str, ordinal: int, found: Sequence[Examined]) -> None:
        """Keep the verdicts of a unit, whole or not at all; a folder that cannot be written
        costs only the time of the next audit."""
        file = self._file(key, ordinal)
        draft = file.with_suffix(f".{os.getpid()}")
        try:
            if not file.parent.exists():
                self._make_room()
                file.parent.mkdir(parents=True, exist_ok=True)
            draft.write_text(json.dumps([asdict(e) for e in found]), encoding="utf-8")
            draft.replace(file)
        except OSError:
            return

    def _make_room(self) -> None:
        """Forget the sections that were audited longest ago."""
        if self.folder.exists():
            known = sorted(self.folder.iterdir(), key=lambda folder: folder.stat().st_mtime)
            for folder in known[: max(len(known) + 1 - KEPT, 0)]:
                shutil.rmtree(folder, ignore_errors=True)

    def _file(self, key: str, ordinal: int) -> Path:
        return self.folder / key[:24] / f"{ordinal}.json"


def _examined(entry: dict[str, Any]) -> Examined:
    rest = {name: value for name, value in entry.items() if name != "record"}
    rest["uses"], rest["given"] = tuple(rest["uses"]), tuple(rest["given"])
    return Examined(FormulaRecord.from_dict(entry["record"]), **rest)

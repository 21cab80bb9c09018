"""Results on disk, as JSON, each under a digest of what it rests on."""

from __future__ import annotations

import json
import os
import shutil
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["Store"]


@dataclass(frozen=True)
class Store:
    """A folder with one subfolder for each digest; of these the newest ``kept`` stay.

    A file that is missing or broken is no result.
    """

    folder: Path
    kept: int = 200

    @classmethod
    def of_user(cls, part: str, kept: int = 200) -> Store:
        """The folder ``voronec/part`` among the user's caches."""
        home = Path.home()
        if sys.platform == "win32":
            base = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
        elif sys.platform == "darwin":
            base = home / "Library" / "Caches"
        else:
            base = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
        return cls(base / "voronec" / part, kept)

    def load(self, key: str, name: str) -> Any:
        """What was kept, or ``None``."""
        try:
            return json.loads(self._file(key, name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None

    def save(self, key: str, name: str, value: Any) -> None:
        """Keep a value, whole or not at all; a folder that cannot be written costs only the
        time of the next run."""
        file = self._file(key, name)
        draft = file.with_suffix(f".{os.getpid()}")
        try:
            if not file.parent.exists():
                self._make_room()
                file.parent.mkdir(parents=True, exist_ok=True)
            draft.write_text(json.dumps(value), encoding="utf-8")
            draft.replace(file)
        except OSError:
            with suppress(OSError):
                draft.unlink()

    def _make_room(self) -> None:
        """Forget what was made longest ago."""
        if self.folder.exists():
            known = sorted(self.folder.iterdir(), key=lambda folder: folder.stat().st_mtime)
            for folder in known[: max(len(known) + 1 - self.kept, 0)]:
                shutil.rmtree(folder, ignore_errors=True)

    def _file(self, key: str, name: str) -> Path:
        return self.folder / key[:24] / f"{name}.json"

"""Finished verdicts on disk, each kept for as long as nothing that it rests on has changed.

A verdict rests on the transcription of its section, on the source of the modules that the section
takes its checks and dictionaries from, on the source of the engine, and on the versions of the
libraries that the engine computes with.
"""

from __future__ import annotations

import ast
import inspect
import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache as remembered
from hashlib import sha256
from pathlib import Path
from typing import Any

from voronec.audit.consistency import Examined
from voronec.audit.paper import Check, Section
from voronec.audit.record import FormulaRecord

__all__ = ["Cache", "section_key"]

LIBRARIES = ("sympy", "symengine", "flint")
KEPT = 200
"""How many sections, in whatever state of their sources, keep their verdicts."""
BYSTANDERS = {"report", "cli", "flow", "program"}
"""Parts of the package on which no verdict rests."""


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
            for folder in known[:-KEPT]:
                shutil.rmtree(folder, ignore_errors=True)

    def _file(self, key: str, ordinal: int) -> Path:
        return self.folder / key[:24] / f"{ordinal}.json"


def _examined(entry: dict[str, Any]) -> Examined:
    record = dict(entry["record"])
    for name in ("changes", "struck"):
        record[name] = tuple((a, b) for a, b in record[name])
    for name in ("quantifiers", "ranges"):
        record[name] = tuple(record[name])
    rest = {name: value for name, value in entry.items() if name != "record"}
    rest["uses"], rest["given"] = tuple(rest["uses"]), tuple(rest["given"])
    return Examined(FormulaRecord(**record), **rest)


def section_key(section: Section) -> str:
    """A digest of all that the verdicts of a section rest on."""
    mark = sha256(_engine().encode())
    for part in (section, *section.inherits):
        for display in (*part.displays, *part.inline):
            mark.update(display.latex.encode() + b"\0")
        mark.update("\0".join(sentence.says for sentence in part.sentences).encode())
        for file in _sources(part):
            mark.update(file.read_bytes())
    return mark.hexdigest()


@remembered
def _engine() -> str:
    """A digest of the engine and of the libraries below it."""
    root = Path(__file__).resolve().parents[1]
    mark = sha256(sys.version.encode())
    for name in LIBRARIES:
        mark.update(f"{name} {__import__(name).__version__}".encode())
    for file in sorted(root.rglob("*.py")):
        if file.relative_to(root).parts[0] not in BYSTANDERS:
            mark.update(file.read_bytes())
    return mark.hexdigest()


def _sources(section: Section) -> list[Path]:
    """The files of the section's own functions, and those that they import, except the engine."""
    waiting = {Path(name) for function in _functions(section) if (name := _file_of(function))}
    found: set[Path] = set()
    while waiting:
        file = waiting.pop()
        found.add(file)
        waiting |= set(_imported(file)) - found
    return sorted(found)


def _functions(section: Section) -> Iterator[Callable[..., Any]]:
    yield section.studies
    for sentence in section.sentences:
        yield sentence.decide
    for display in (*section.displays, *section.inline):
        for check in display.checks:
            yield from (f for f in _hooks(check) if f is not None)


def _hooks(check: Check) -> tuple[Callable[..., Any] | None, ...]:
    return check.truth, check.value, check.derived, check.decide


def _file_of(function: Callable[..., Any]) -> str | None:
    try:
        return inspect.getsourcefile(inspect.unwrap(function))
    except TypeError:
        return None  # a partial or another object without source: its module is named elsewhere


def _imported(file: Path) -> Iterator[Path]:
    """The files of relative imports, wherever in the module they stand."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom) or node.level == 0:
            continue
        base = file.parents[node.level - 1].joinpath(*(node.module or "").split("."))
        names = [base / alias.name for alias in node.names]
        for place in (base, *names):
            for candidate in (place.with_suffix(".py"), place / "__init__.py"):
                if candidate.is_file():
                    yield candidate

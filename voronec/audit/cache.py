"""Finished verdicts of an audit on disk, each under a digest of what it rests on.

They rest on what the section declares; on the source of the modules that its functions come from
and of those that these import, as far as they are no installed libraries; on the systems that these
load by name; on the engine; and on the libraries that the engine computes with.  A data file that a
study reads is not seen.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from voronec.audit.consistency import Examination
from voronec.audit.display import Check, Display
from voronec.audit.paper import Section
from voronec.audit.record import FormulaRecord
from voronec.audit.sentence import Sentence
from voronec.declaration.source_digest import closure, digest
from voronec.declaration.whole_files import Store

DECIDER = "voronec.audit.paper_audit"
"""The module that decides what an audit says."""


@dataclass(frozen=True)
class Basis:
    """The declarations of a section as text, and the files that it rests on."""

    declaration: str
    files: tuple[Path, ...]

    @classmethod
    def of(cls, section: Section, paper: Iterable[Section] = ()) -> Basis:
        """Collect them; ``paper`` holds the sections to whose formulas its sentences may refer."""
        refers = any(slot.kind == "reference" for s in section.sentences for slot in s.slots)
        others = [d.latex for s in paper for d in s.displays] if refers else []
        return cls(
            _declaration_text(section) + _text(others), tuple(sorted(closure(_origins(section))))
        )

    def digest(self) -> str:
        """A digest of everything, with the files as they are now."""
        return digest(self.declaration, self.files, DECIDER)


def _declaration_text(section: Section) -> str:
    """All that the section declares, functions by their names."""
    return _text((section.title, section.displays, section.inline, section.sentences))


def _text(value: Any) -> str:
    if isinstance(value, (Display, Sentence, Check)) or hasattr(value, "__dataclass_fields__"):
        parts = [f"{f.name}={_text(getattr(value, f.name))}" for f in fields(value)]
        return f"{type(value).__name__}({', '.join(parts)})"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_text(k)}: {_text(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (tuple, list)):
        return "(" + ", ".join(map(_text, value)) + ")"
    if callable(value) and hasattr(value, "__qualname__"):
        return f"{value.__module__}.{value.__qualname__}"
    return repr(value)


def _origins(section: Section) -> set[Path]:
    """The files in which the section's functions are written."""
    files = set()
    for function in _functions(section):
        file = inspect.getsourcefile(inspect.unwrap(function)) if _has_source(function) else None
        if file is not None:
            files.add(Path(file).resolve())
    return files


def _has_source(function: Any) -> bool:
    return inspect.isfunction(inspect.unwrap(function))


def _functions(section: Section) -> Iterator[Callable[..., Any]]:
    yield section.studies
    for sentence in section.sentences:
        if sentence.decide is not None:
            yield sentence.decide
        if sentence.derived is not None:
            yield sentence.derived
    for display in (*section.displays, *section.inline):
        for check in display.checks:
            hooks = (check.truth, check.value, check.derived, check.decide)
            yield from (hook for hook in hooks if hook is not None)


SECTIONS = 200
"""How many sections, in whatever state of their sources, keep their verdicts."""


@dataclass(frozen=True)
class Cache:
    """A folder with one file for each unit; a file that is missing or damaged is no verdict."""

    folder: Path

    @classmethod
    def of_user(cls) -> Cache:
        """The folder ``voronec/audit`` among the user's caches."""
        return cls(Store.of_user("audit").folder)

    def load(self, key: str, ordinal: int) -> list[Examination] | None:
        """The verdicts of a unit, or ``None``."""
        kept = Store(self.folder).load(key, str(ordinal))
        return None if kept is None else [_read_examination(entry) for entry in kept]

    def store(self, key: str, ordinal: int, found: Sequence[Examination]) -> None:
        """Keep the verdicts of a unit, whole or not at all."""
        Store(self.folder, SECTIONS).save(key, str(ordinal), [asdict(e) for e in found])


def _read_examination(entry: dict[str, Any]) -> Examination:
    rest = {name: value for name, value in entry.items() if name != "record"}
    rest["uses"], rest["premises"] = tuple(rest["uses"]), tuple(rest["premises"])
    return Examination(FormulaRecord.from_dict(entry["record"]), **rest)

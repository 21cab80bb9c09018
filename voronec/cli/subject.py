"""What a command is about: a system of the catalogue, or one that a file defines."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from voronec.declaration.catalogue import SUFFIXES, Entry, entry_of, is_file, load_file
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.declaration.system import System

__all__ = ["entry_of_name", "is_file", "resolve"]


def resolve(subject: str) -> tuple[System, Path | None]:
    """The system, and the folder of its file."""
    if is_file(subject):
        return load_file(subject), Path(subject).parent
    entry = entry_of_name(subject)
    return entry.load(), entry.origin.parent if entry.origin is not None else None


def entry_of_name(name: str) -> Entry:
    """Where the system of that name stands; a file of that name is told of."""
    try:
        return entry_of(name)
    except DefinitionError as error:
        for suffix in SUFFIXES:
            if Path(name + suffix).is_file():
                raise DefinitionError(f"{error} For the file, say '{name}{suffix}'") from None
        raise

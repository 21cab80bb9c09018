"""What a command is about: a system of the catalogue, or one that a file defines."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from voronec.declaration.catalogue import (
    SUFFIXES,
    Entry,
    entry_of,
    file_entry,
    is_file,
    load_file,
    require_suffix,
)
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.declaration.system import System
    from voronec.proof.check import Inventory


def resolve(subject: str) -> tuple[System, Path | None]:
    """The system, and the folder of its file."""
    if is_file(subject):
        return load_file(subject), Path(subject).parent
    entry = entry_of_name(subject)
    return entry.load(), entry.origin.parent if entry.origin is not None else None


def name_in(stock: Inventory, subject: str) -> str:
    """The name under which an inventory holds a NAME or a FILE."""
    return (
        file_entry(subject).name if is_file(subject) else entry_of_name(subject, stock.entry).name
    )


def entry_of_name(name: str, find: Callable[[str], Entry] = entry_of) -> Entry:
    """Where the system of that name stands; a file of that name, or of one that differs in its
    suffix, is told of."""
    try:
        return find(name)
    except DefinitionError as error:
        require_suffix(Path(name))
        for stem, suffix in product((name, os.path.splitext(name)[0]), SUFFIXES):
            if Path(stem + suffix).is_file():
                raise DefinitionError(f"{error} For the file, say '{stem}{suffix}'") from None
        raise

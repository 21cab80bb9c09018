"""Writing results so that nothing is ever half-written."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from voronec.errors import DefinitionError

__all__ = ["create", "delivery", "refuse_file"]


@contextmanager
def delivery(folder: Path) -> Iterator[Path]:
    """A workshop for files, which are moved into ``folder`` when, and only when, all are done.

    Files of the same names are replaced, others in ``folder`` stay.
    """
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        workshop = Path(tempfile.mkdtemp(prefix=".voronec-", dir=folder.parent))
    except OSError as error:
        raise DefinitionError(f"'{folder}' cannot be written: {error.strerror}") from None
    try:
        yield workshop
        folder.mkdir(exist_ok=True)
        for file in sorted(workshop.iterdir()):
            os.replace(file, folder / file.name)
    except OSError as error:
        raise DefinitionError(f"'{folder}' cannot be written: {error.strerror}") from None
    finally:
        shutil.rmtree(workshop, ignore_errors=True)


def refuse_file(folder: Path) -> None:
    """Raise ``DefinitionError`` where the folder to be written exists as a file."""
    if folder.exists() and not folder.is_dir():
        raise DefinitionError(f"'{folder}' is a file; give a folder with --out")


def create(path: Path, text: str) -> None:
    """Write a new file; one that is there is never touched."""
    try:
        with path.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise DefinitionError(f"'{path}' exists; remove it, or choose another name") from None
    except OSError as error:
        raise DefinitionError(f"'{path}' cannot be written: {error.strerror}") from None

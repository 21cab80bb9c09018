"""Writing results so that nothing is ever half-written."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from voronec.errors import DefinitionError

__all__ = ["create", "deliver", "delivery", "refuse_file", "wanted_folder"]


@contextmanager
def delivery(folder: Path) -> Iterator[Path]:
    """A workshop for files, which are moved into ``folder`` when, and only when, all are done.

    Files of the same names are replaced, others in ``folder`` stay.
    """
    # A folder that exists may lie in one that must not be written.
    place = folder if folder.is_dir() else folder.parent
    try:
        place.mkdir(parents=True, exist_ok=True)
        workshop = Path(tempfile.mkdtemp(prefix=".voronec-", dir=place))
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


def wanted_folder(name: str) -> Path:
    """The folder for results, refused before any work where it could not be written after it.

    Nothing is created: a nameless file is tried in the folder, or in the nearest one above it that
    exists.
    """
    if not name.strip():
        raise DefinitionError("the folder for --out has no name; write: --out FOLDER")
    folder = Path(name)
    refuse_file(folder)
    above = folder.absolute()
    while not above.exists() and above != above.parent:
        above = above.parent
    if not above.is_dir():
        raise DefinitionError(f"'{folder}' cannot be written: '{above}' is no folder")
    if not os.access(above, os.W_OK | os.X_OK):
        raise DefinitionError(f"'{folder}' cannot be written: '{above}' allows no new files")
    try:
        with tempfile.TemporaryFile(dir=above):
            return folder
    except OSError as error:
        raise DefinitionError(f"'{folder}' cannot be written: {error.strerror}") from None


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


def deliver(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all; one that is there is replaced."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        draft.write_bytes(content.encode() if isinstance(content, str) else content)
        draft.replace(path)
    except OSError as error:
        raise DefinitionError(f"'{path}' cannot be written: {error.strerror}") from None
    finally:
        draft.unlink(missing_ok=True)

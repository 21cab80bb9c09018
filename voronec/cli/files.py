"""Where commands write their results: refused before the work, delivered after it, whole."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from voronec.declaration.whole_files import replace_file, unwritable, workshop
from voronec.errors import DefinitionError


def deliver(folder: Path, write: Callable[[Path], Any], products: Iterable[str] = ()) -> list[Path]:
    """What ``write`` puts into a workshop is moved into ``folder`` when, and only when, all is
    done; returns the files by name.

    Files of the same names are replaced; of ``products``, what this command may make, those go that
    an earlier run has left and this one did not make.  Others in ``folder`` stay.
    """
    # A folder that exists may lie in one that must not be written.
    try:
        place = folder if folder.is_dir() else folder.parent
        place.mkdir(parents=True, exist_ok=True)
        with workshop(place) as drafts:
            try:
                write(drafts)
            except DefinitionError as error:
                raise DefinitionError(str(error).replace(str(drafts), str(folder))) from None
            folder.mkdir(exist_ok=True)
            made = sorted(drafts.iterdir())
            for file in made:
                os.replace(file, folder / file.name)
            for name in {*products} - {file.name for file in made}:
                (folder / name).unlink(missing_ok=True)
            return [folder / file.name for file in made]
    except (OSError, UnicodeEncodeError) as error:
        raise unwritable(folder, error) from None


def write_picture_and_table(found: Any, name: str, workshop: Path) -> None:
    """The picture of what was found, and its table: ``NAME.svg`` and ``NAME.csv``."""
    from voronec.motion.pictures.run_pictures import save

    save(found.plot(), workshop / f"{name}.svg")
    found.save(workshop / f"{name}.csv")


def wanted_folder(name: str) -> Path:
    """The folder for results, refused before any work where it could not be written after it.

    Nothing is created: a nameless file is tried in the folder, or in the nearest one above it that
    exists.
    """
    if not name.strip():
        raise DefinitionError("the folder for --out has no name; write: --out FOLDER")
    if "\0" in name:
        raise DefinitionError(f"--out {name!a} is no name of a folder; write: --out FOLDER")
    folder = Path(name)
    try:
        os.fsencode(folder)
        refuse_file(folder)
        above = folder.absolute()
        while not above.exists() and above != above.parent:
            above = above.parent
        if not above.is_dir():
            raise DefinitionError(f"'{folder}' cannot be written: '{above}' is no folder")
        if not os.access(above, os.W_OK | os.X_OK):
            raise DefinitionError(f"'{folder}' cannot be written: '{above}' allows no new files")
        with tempfile.TemporaryFile(dir=above):
            return folder
    except (OSError, UnicodeEncodeError) as error:
        raise unwritable(folder, error) from None


def refuse_file(folder: Path) -> None:
    """Raise ``DefinitionError`` where the folder to be written exists as a file."""
    if folder.exists() and not folder.is_dir():
        raise DefinitionError(f"'{folder}' is a file; give a folder with --out")


def replace(path: Path, content: str | bytes) -> None:
    """Write a file, in folders that are made if need be; one that is there is replaced."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except (OSError, UnicodeEncodeError) as error:
        raise unwritable(path, error) from None
    replace_file(path, content)


def create(path: Path, text: str) -> None:
    """Write a new file; one that is there is never touched."""
    try:
        with workshop(path.parent) as drafts:
            (drafts / path.name).write_text(text, encoding="utf-8")
            if os.path.lexists(path):
                raise FileExistsError
            os.rename(drafts / path.name, path)
    except FileExistsError:
        raise DefinitionError(f"'{path}' exists; remove it, or choose another name") from None
    except (OSError, UnicodeEncodeError) as error:
        raise unwritable(path, error) from None

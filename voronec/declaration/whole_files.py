"""Files that appear whole or not at all, whatever ends the writing.

What is written is a draft in a workshop, a hidden folder beside its place, and is moved there when
it is done.  A workshop is locked by the process that writes in it, so that one whose process was
killed is known, and goes when somebody next writes into the same folder.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from voronec.errors import DefinitionError

__all__ = [
    "Store",
    "draft",
    "keep_file",
    "make_room",
    "replace_file",
    "unwritable",
    "user_cache",
    "workshop",
]

PREFIX = ".voronec-"
LOCK = "lock"
FORGOTTEN = 60.0
"""Seconds after which a workshop that nobody has locked is a leftover: locking takes none."""


def unwritable(place: Path, error: OSError | UnicodeEncodeError) -> DefinitionError:
    """The error of a place that cannot be written, or whose name no file can have."""
    what = getattr(error, "strerror", None) or error
    return DefinitionError(f"'{place}' cannot be written: {what}; choose another place")


def user_cache(part: str) -> Path:
    """The folder ``voronec/part`` among the user's caches; one that nobody can write in where the
    user has no home."""
    try:
        home = Path.home()
    except RuntimeError:
        home = Path(os.devnull)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    return base / "voronec" / part


def make_room(folder: Path, kept: int) -> None:
    """Forget what was changed longest ago in a folder of caches, so that ``kept`` stay with one
    that is new."""
    with suppress(OSError):
        known = sorted(folder.iterdir(), key=lambda one: one.stat().st_mtime)
        for one in known[: max(len(known) + 1 - kept, 0)]:
            if one.is_dir():
                shutil.rmtree(one, ignore_errors=True)
            else:
                one.unlink(missing_ok=True)


def keep_file(file: Path, content: bytes) -> None:
    """Write a file of a cache, whole or not at all; where it cannot be written, that costs only the
    time of the next process."""
    made = file.with_suffix(f".{os.getpid()}")
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            made.write_bytes(content)
            made.replace(file)
        except OSError:
            made.unlink()


@dataclass(frozen=True)
class Store:
    """Results as JSON, in a folder with one subfolder for each digest; of these the newest
    ``capacity`` stay.

    A file that is missing is no result, nor is one that is not as it was written: that is named,
    and goes.
    """

    folder: Path
    capacity: int = 200

    @classmethod
    def of_user(cls, part: str, capacity: int = 200) -> Store:
        """The folder ``voronec/part`` among the user's caches."""
        return cls(user_cache(part), capacity)

    def load(self, key: str, name: str) -> Any:
        """What was kept, or ``None``."""
        file = self._file(key, name)
        try:
            mark, text = json.loads(file.read_bytes())
            if mark == sha256(text.encode()).hexdigest():
                return json.loads(text)
        except OSError:
            return None
        except (ValueError, TypeError, AttributeError):
            pass
        warnings.warn(f"the kept result '{file}' is damaged; it is made anew", stacklevel=2)
        with suppress(OSError):
            file.unlink()
        return None

    def save(self, key: str, name: str, value: Any) -> None:
        """Keep a value."""
        file = self._file(key, name)
        if not file.parent.exists():
            make_room(self.folder, self.capacity)
        text = json.dumps(value)
        keep_file(file, json.dumps([sha256(text.encode()).hexdigest(), text]).encode())

    def _file(self, key: str, name: str) -> Path:
        return self.folder / key[:24] / f"{name}.json"


@contextmanager
def workshop(folder: Path) -> Iterator[Path]:
    """An empty folder for drafts on the same disk as ``folder``, gone at the end."""
    _sweep(folder)
    made = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))
    lock = None
    try:
        lock = _lock(made / LOCK, os.O_CREAT)
        drafts = made / "drafts"
        drafts.mkdir()
        yield drafts
    finally:
        shutil.rmtree(made, ignore_errors=True)
        if lock is not None:
            os.close(lock)


@contextmanager
def draft(path: Path) -> Iterator[Path]:
    """A file of the same name to write, which takes the place of ``path`` when it is done.

    ``DefinitionError`` where it cannot be written; what is there then stays as it was.
    """
    try:
        if path.exists() and not path.is_file():
            raise DefinitionError(
                f"'{path}' is no file that could be replaced; choose another name"
            )
        with workshop(path.parent) as made:
            yield made / path.name
            os.replace(made / path.name, path)
    except (OSError, UnicodeEncodeError) as error:
        raise unwritable(path, error) from None


def replace_file(path: Path, content: str | bytes) -> None:
    """Write a file; one that is there is replaced."""
    with draft(path) as new:
        new.write_bytes(content.encode() if isinstance(content, str) else content)


def _sweep(folder: Path) -> None:
    """Remove the workshops of processes that were killed."""
    with suppress(OSError):
        for old in folder.glob(f"{PREFIX}*"):
            with suppress(OSError):
                if old.is_dir() and not old.is_symlink() and _is_left(old):
                    shutil.rmtree(old, ignore_errors=True)


def _is_left(old: Path) -> bool:
    try:
        lock = _lock(old / LOCK)
    except BlockingIOError:
        return False
    except FileNotFoundError:
        return time.time() - old.stat().st_mtime > FORGOTTEN
    if lock is None:
        return False
    os.close(lock)
    return True


def _lock(path: Path, flags: int = 0) -> int | None:
    """An open file that is locked until its process ends; None where there are no locks."""
    try:
        import fcntl
    except ImportError:  # not on Windows
        return None
    file = os.open(path, os.O_RDWR | flags, 0o600)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(file)
        raise
    except OSError:  # a file system without locks
        os.close(file)
        return None
    return file

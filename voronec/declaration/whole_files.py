"""Files that appear whole or not at all, whatever ends the writing, and the user's caches.

What is written is a draft in a workshop, a hidden folder beside its place, and is moved there when
it is done.  A workshop is locked by the process that writes in it, so that one whose process was
killed is known, and goes when somebody next writes into the same folder.

Caches hold code: models are pickles, and programs are loaded.  So they lie in folders that this
user alone can change, and what others own or can write there is not used, but named once.
"""

from __future__ import annotations

import json
import os
import shutil
import stat
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from voronec.errors import DefinitionError

PREFIX = ".voronec-"
LOCK = "lock"
DIGEST = 64
"""The digits of the digest that a sealed file begins with."""
FORGOTTEN = 60.0
"""Seconds after which a workshop that nobody has locked is a leftover: locking takes none."""


def unwritable(place: Path, error: OSError | UnicodeEncodeError) -> DefinitionError:
    """The error of a place that cannot be written, or whose name no file can have."""
    what = getattr(error, "strerror", None) or error
    return DefinitionError(f"'{place}' cannot be written: {what}; choose another place")


def user_cache(part: str) -> Path:
    """The folder ``voronec/part`` among the user's caches, made if need be, which this user alone
    can read and write; one that nobody can write in where there is none."""
    with suppress(OSError):
        base = _caches()
        base.mkdir(0o700, parents=True, exist_ok=True)
        if not has_foreign(base, above=True):
            make_private(ours := base / "voronec")
            make_private(ours / part)
            return ours / part
    return Path(os.devnull) / "voronec" / part


def _caches() -> Path:
    """The folder of all caches of the user.  Names that are empty or relative are ignored, as the
    XDG Base Directory Specification has it: caches would lie wherever a command is called."""
    home, named = Path(os.environ.get("HOME", os.path.expanduser("~"))), ""
    if sys.platform == "win32":
        named, usual = os.environ.get("LOCALAPPDATA", ""), home / "AppData" / "Local"
    elif sys.platform == "darwin":
        usual = home / "Library" / "Caches"
    else:
        named, usual = os.environ.get("XDG_CACHE_HOME", ""), home / ".cache"
    return next(p for p in (Path(named), usual, Path(os.devnull)) if p.is_absolute())


def make_private(folder: Path, *inside: Path) -> None:
    """Make a folder that this user alone can read and write; ``PermissionError`` where others can
    write in it, or own it or what is ``inside``."""
    folder.mkdir(0o700, parents=True, exist_ok=True)
    if has_foreign(folder, *inside):
        raise PermissionError(folder)
    with suppress(OSError):  # a disk that is read alone
        folder.chmod(0o700)


def has_foreign(*places: Path, above: bool = False) -> bool:
    """Whether one of these files and folders may hold what others wrote: this is named, once.

    A folder ``above`` those of caches may belong to the system, and be shared if everybody keeps
    what is his there, as ``/tmp`` is.
    """
    for place in places:
        with suppress(OSError):  # it is not there
            if not _is_ours(place, above):
                _name(place)
                return True
    return False


def _is_ours(place: Path, above: bool = False) -> bool:
    if sys.platform == "win32":  # there no file has a numbered owner or such a mode; the folder of
        return True  # a user's data is private by its list of rights, which Python does not read
    seen = place.stat() if above else place.lstat()
    owners = (os.geteuid(), 0) if above else (os.geteuid(),)
    is_shared = seen.st_mode & 0o022 and not (above and seen.st_mode & stat.S_ISVTX)
    return seen.st_uid in owners and not is_shared and not stat.S_ISLNK(seen.st_mode)


@cache
def _name(place: Path) -> None:
    warnings.warn(
        f"'{place}' belongs to another user, can be written by others, or is a link: what is kept "
        "there is not used; make it your own, or remove it",
        stacklevel=3,
    )


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
    with suppress(OSError):
        make_private(file.parent)
        # new, by a name that nobody can guess, for this user alone
        opened, made = tempfile.mkstemp(dir=file.parent)
        try:
            with open(opened, "wb") as new:
                new.write(content)
            os.replace(made, file)
        except OSError:
            os.unlink(made)


def keep_with_digest(file: Path, content: bytes) -> None:
    """Write a file of a cache with the digest of its content."""
    keep_file(file, sha256(content).hexdigest().encode() + content)


def read_with_digest(file: Path, what: str) -> bytes | None:
    """The content of a file that was kept with its digest, or ``None``.

    What is damaged is named as ``what``, and goes; what others may have written is not read.
    """
    with suppress(OSError):
        if has_foreign(file.parent, file):
            return None
        content = file.read_bytes()
        if sha256(content[DIGEST:]).hexdigest().encode() == content[:DIGEST]:
            return content[DIGEST:]
        warnings.warn(f"the kept {what} '{file}' is damaged; it is made anew", stacklevel=3)
        file.unlink()
    return None


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
        content = read_with_digest(self._file(key, name), "result")
        return None if content is None else json.loads(content)

    def save(self, key: str, name: str, value: Any) -> None:
        """Keep a value."""
        file = self._file(key, name)
        if not file.parent.exists():
            make_room(self.folder, self.capacity)
        keep_with_digest(file, json.dumps(value).encode())

    def _file(self, key: str, name: str) -> Path:
        return self.folder / key[:24] / f"{name}.json"


@contextmanager
def workshop(folder: Path) -> Iterator[Path]:
    """An empty folder for drafts on the same disk as ``folder``, gone at the end."""
    _sweep(folder)
    made = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))
    lock = None
    try:
        lock = lock_file(made / LOCK, os.O_CREAT)
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
                if _is_ours(old) and old.is_dir() and _is_left(old):
                    shutil.rmtree(old, ignore_errors=True)


def _is_left(old: Path) -> bool:
    try:
        lock = lock_file(old / LOCK)
    except BlockingIOError:
        return False
    except FileNotFoundError:
        return time.time() - old.stat().st_mtime > FORGOTTEN
    if lock is None:
        return False
    os.close(lock)
    return True


def lock_file(path: Path, flags: int = 0) -> int | None:
    """An open file that is locked until it is closed, or its process ends; None where there are no
    locks.  ``BlockingIOError`` where another process has locked it."""
    try:
        import fcntl
    except ImportError:  # not on Windows
        return None
    file = os.open(path, os.O_RDWR | os.O_NOFOLLOW | flags, 0o600)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(file)
        raise
    except OSError:  # a file system without locks
        os.close(file)
        return None
    return file

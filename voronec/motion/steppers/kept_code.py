"""Machine code of generated functions, kept on disk: numba makes it once for each machine.

numba keeps what it compiles beside the file in which a function stands.  So each source is written
into a folder of its own among the user's caches, called by a digest of all that the source comes
from.  A list of digests tells whether the files are those that were written: machine code that was
damaged would run.

Functions of two sources bear names of their own in machine code: of those whose names and arguments
are the same a process keeps the one that it read first, and would run it for both.
"""

from __future__ import annotations

import json
import os
import shutil
import warnings
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from voronec.declaration.whole_files import make_room, user_cache

__all__ = ["kept_function"]

SOURCES = 200
"""How many sources keep their code; those that were made longest ago give way."""
SOURCE, LIST = "source.py", "digests.json"


def kept_function(
    name: str, signature: str, key: str, source: Callable[[], str]
) -> Callable[..., Any]:
    """The function ``name`` of a generated source, compiled for a numba ``signature``.

    ``key`` is all that ``source()`` depends on: where its code is on disk, it is not called.
    Raises ``ImportError`` without numba.
    """
    import numba

    digest = sha256(f"{key}\n{numba.__version__}\n{version('numpy')}".encode()).hexdigest()
    folder = user_cache("code") / digest[:24]
    text = _sound_source(folder)
    if text is not None:
        with suppress(Exception):  # what another version wrote may fail in any way
            return _load(folder, text, name, signature)
        _forget(folder, "cannot be read")
    text = source()
    try:
        make_room(folder.parent, SOURCES)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / SOURCE).write_text(text, encoding="utf-8")
    except OSError:  # a folder that cannot be written costs only the time of the next run
        return _compile(text, SOURCE, name, signature, keep=False)
    return _load(folder, text, name, signature)


def _load(folder: Path, text: str, name: str, signature: str) -> Callable[..., Any]:
    """The function from the code in a folder, which is made where it is not there yet."""
    function = _compile(text, str(folder / SOURCE), name, signature, keep=True)
    if function.stats.cache_misses:
        _write_list(folder)
    return function


def _compile(text: str, place: str, name: str, signature: str, keep: bool) -> Any:
    import numba

    mark = sha256(text.encode()).hexdigest()[:24]

    def jit(function: Any) -> Any:
        function.__qualname__ = f"{function.__name__}_{mark}"
        # sums of products may be fused; their order stays, as results must not depend on the caller
        options = {"error_model": "numpy", "fastmath": {"contract"}}
        if function.__name__ != name:
            return numba.njit(**options)(function)
        return numba.njit(signature, cache=keep, **options)(function)

    # numba keeps only functions of a module that can be imported
    namespace: dict[str, Any] = {"np": np, "jit": jit, "__name__": __name__}
    exec(compile(text, place, "exec"), namespace)
    return namespace[name]


def _sound_source(folder: Path) -> str | None:
    """The source in a folder, where all is as it was written; None where there is none."""
    try:
        known = json.loads((folder / LIST).read_text(encoding="utf-8"))
        if known == _digests(folder):
            return (folder / SOURCE).read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError):
        pass
    _forget(folder, "is damaged")
    return None


def _forget(folder: Path, why: str) -> None:
    warnings.warn(f"the compiled code in '{folder}' {why}; it is made anew", stacklevel=4)
    shutil.rmtree(folder, ignore_errors=True)


def _digests(folder: Path) -> dict[str, str]:
    files = sorted(p for p in folder.rglob("*") if p.suffix in (".py", ".nbi", ".nbc"))
    return {p.name: sha256(p.read_bytes()).hexdigest() for p in files}


def _write_list(folder: Path) -> None:
    draft = folder / f"{LIST}.{os.getpid()}"
    with suppress(OSError):
        draft.write_text(json.dumps(_digests(folder)), encoding="utf-8")
        draft.replace(folder / LIST)

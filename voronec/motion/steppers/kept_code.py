"""Machine code of generated functions, kept on disk: numba, or the C compiler, makes it once for
each machine.

numba keeps what it compiles beside the file in which a function stands.  So each source is written
into a folder of its own among the user's caches, called by a digest of all that the source comes
from.  A list of digests tells whether the files are those that were written: machine code that was
damaged would run.  A folder appears at once and whole: code is made in a draft of it.

Functions of two sources bear names of their own in machine code: of those whose names and arguments
are the same a process keeps the one that it read first, and would run it for both.
"""

from __future__ import annotations

import ctypes
import json
import os
import platform
import shutil
import subprocess
import tempfile
import warnings
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from math import sqrt
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from voronec.declaration.whole_files import has_foreign, keep_file, make_room, user_cache
from voronec.errors import DefinitionError, EngineLimit

T = TypeVar("T")
SOURCES = 200
"""How many sources keep their code; those that were made longest ago give way."""
SOURCE, LIST, LIBRARY = "source.py", "digests.json", "library.so"
SUFFIXES = (".py", ".nbi", ".nbc", ".c", ".so")
COMPILER = "cc"
"""The name by which systems call their C compiler."""


def kept_function(
    name: str, signature: str, key: str, source: Callable[[], str]
) -> Callable[..., Any]:
    """The function ``name`` of a generated source, compiled for a numba ``signature``.

    ``key`` is all that ``source()`` depends on: where its code is on disk, it is not called.
    Raises ``ImportError`` without numba.
    """
    import numba

    digest = sha256(f"{key}\n{numba.__version__}\n{np.__version__}".encode()).hexdigest()
    folder = user_cache("code") / digest[:24]
    text = sound_source(folder)
    if text is not None:
        with suppress(Exception):  # what another version wrote may fail in any way
            return _load(folder, text, name, signature)
        _forget(folder, "cannot be read")
    text = source()

    def make(draft: Path) -> Callable[..., Any]:
        (draft / SOURCE).write_text(text, encoding="utf-8")
        return _load(draft, text, name, signature)

    return _load_or_make(folder, make)


def kept_library(
    key: str, sources: Callable[[], dict[str, str]], effort: str = "-O1"
) -> ctypes.CDLL:
    """The library that the C compiler makes of generated sources, which are files by name.

    ``key`` is all that ``sources()`` depends on; ``effort`` is the compiler's word for how much it
    optimises: more than -O1 pays only for loops.  Raises ``DefinitionError`` where there is no
    compiler, and ``EngineLimit`` where it fails.
    """
    place = shutil.which(COMPILER)
    if place is None:
        raise DefinitionError(
            f"there is no C compiler '{COMPILER}' here; install one, or use method='scipy'"
        )
    seen = os.stat(place)
    machine = (platform.platform(), platform.machine(), seen.st_size, seen.st_mtime_ns)
    folder = user_cache("code") / sha256(f"{key}\n{effort}\n{machine}".encode()).hexdigest()[:24]
    if _is_sound(folder):
        with suppress(OSError):
            return ctypes.CDLL(str(folder / LIBRARY))
        _forget(folder, "cannot be read")
    return _load_or_make(folder, lambda draft: _build(place, draft, sources(), effort))


def _load_or_make(folder: Path, make: Callable[[Path], T]) -> T:
    """What is made in a draft, which becomes ``folder`` where nobody else was faster."""
    make_room(folder.parent, SOURCES)
    try:
        draft = tempfile.TemporaryDirectory(dir=folder.parent)
    except OSError:  # a folder that cannot be written costs only the time of the next run
        draft = tempfile.TemporaryDirectory()
    with draft as name:
        made = make(Path(name))
        write_list(Path(name))
        with suppress(OSError):
            os.rename(name, folder)
    return made


def _build(compiler: str, draft: Path, sources: dict[str, str], effort: str) -> ctypes.CDLL:
    """A library compiled in a folder, without its sources."""
    for name, text in sources.items():
        (draft / name).write_text(text, encoding="utf-8")
    # more than -O1 takes longer to compile and gains nothing without fused sums of products, and
    # these do not cancel where they should, as on the way out of a plane of symmetry
    words = [compiler, effort, "-std=c99", "-shared", "-fPIC", "-o", LIBRARY, *sources, "-lm"]
    try:
        done = subprocess.run(words, cwd=draft, capture_output=True, text=True, check=False)
        if done.returncode:
            raise _failure(done.stderr)
        for name in sources:
            (draft / name).unlink()
        return ctypes.CDLL(str(draft / LIBRARY))
    except OSError as error:
        raise _failure(str(error)) from None


def _failure(said: str) -> EngineLimit:
    first = next(
        (line.strip() for line in said.splitlines() if "error" in line), said.strip()[:200]
    )
    return EngineLimit(
        f"the C compiler '{COMPILER}' failed: {first or 'it said nothing'}; use method='scipy'"
    )


def _load(folder: Path, text: str, name: str, signature: str) -> Callable[..., Any]:
    """The function from the code in a folder, which is made where it is not there yet."""
    function = _compile(text, str(folder / SOURCE), name, signature)
    if function.stats.cache_misses:
        write_list(folder)
    return function


def _compile(text: str, place: str, name: str, signature: str) -> Any:
    import numba
    from numba.core.compiler_lock import global_compiler_lock

    mark = sha256(text.encode()).hexdigest()[:24]

    def jit(function: Any) -> Any:
        function.__qualname__ = f"{function.__name__}_{mark}"
        # sums of products may be fused; their order stays, as results must not depend on the caller
        options = {"error_model": "numpy", "fastmath": {"contract"}}
        if function.__name__ != name:
            return numba.njit(**options)(function)
        return numba.njit(signature, cache=True, **options)(function)

    # numba keeps only functions of a module that can be imported
    namespace: dict[str, Any] = {"np": np, "sqrt": sqrt, "jit": jit, "__name__": __name__}
    with global_compiler_lock:  # NUMBA_CACHE_DIR would lead elsewhere
        elsewhere, numba.config.CACHE_DIR = numba.config.CACHE_DIR, ""
        try:
            exec(compile(text, place, "exec"), namespace)
        finally:
            numba.config.CACHE_DIR = elsewhere
    return namespace[name]


def sound_source(folder: Path) -> str | None:
    """The source in a folder, where all is as it was written; None where there is none."""
    return (folder / SOURCE).read_text(encoding="utf-8") if _is_sound(folder) else None


def _is_sound(folder: Path) -> bool:
    """Whether there is code in a folder, as this user wrote it; what is damaged is named and taken
    away."""
    if not folder.exists() or has_foreign(folder, *folder.rglob("*")):
        return False
    with suppress(OSError, ValueError):
        if json.loads((folder / LIST).read_text(encoding="utf-8")) == _digests(folder):
            return True
    _forget(folder, "is damaged")
    return False


def _forget(folder: Path, why: str) -> None:
    warnings.warn(f"the compiled code in '{folder}' {why}; it is made anew", stacklevel=4)
    shutil.rmtree(folder, ignore_errors=True)


def _digests(folder: Path) -> dict[str, str]:
    files = sorted(p for p in folder.rglob("*") if p.suffix in SUFFIXES)
    return {p.name: sha256(p.read_bytes()).hexdigest() for p in files}


def write_list(folder: Path) -> None:
    """Keep the digests of the code in a folder, which only its owner can then write."""
    for made in folder.rglob("*"):  # where a group shares its files, compilers let it write them
        made.chmod(made.stat().st_mode & ~0o022)
    keep_file(folder / LIST, json.dumps(_digests(folder)).encode())

"""The files that a result rests on, and a digest of them.

A result rests on the file that declares it; on the modules that this one imports, as far as they
are no installed libraries; on the systems that these load by name; on the engine; and on the
libraries that the engine computes with.
"""

from __future__ import annotations

import ast
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from functools import cache as remembered
from hashlib import sha256
from pathlib import Path

from voronec.catalogue import entry_of, names

__all__ = ["closure", "digest", "engine_digest", "engine_folder"]

LIBRARIES = ("sympy", "symengine", "flint", "mpmath", "numpy")
BYSTANDERS = frozenset(("report", "cli", "flow", "program"))
"""Parts of the package on which no verdict rests."""


def digest(declared: str, files: Iterable[Path], bystanders: frozenset[str] = BYSTANDERS) -> str:
    """A digest of a text, of files as they are now, and of the engine without some parts."""
    mark = sha256(engine_digest(bystanders).encode())
    mark.update(declared.encode())
    for file in files:
        mark.update(b"\0" + file.name.encode() + b"\0")
        mark.update(file.read_bytes() if file.is_file() else b"")
    return mark.hexdigest()


@remembered
def engine_digest(bystanders: frozenset[str] = BYSTANDERS) -> str:
    """A digest of the engine and of the libraries below it."""
    mark = sha256(sys.version.encode())
    for name in LIBRARIES:
        mark.update(f"{name} {__import__(name).__version__}\0".encode())
    root = engine_folder()
    for file in sorted(root.rglob("*.py")):
        part = file.relative_to(root).parts[0]
        if part not in bystanders | {"systems", "docs"}:
            mark.update(str(file.relative_to(root)).encode() + b"\0" + file.read_bytes())
    return mark.hexdigest()


def engine_folder() -> Path:
    """The folder of the package ``voronec``."""
    return Path(__file__).resolve().parents[1]


def closure(files: Iterable[Path]) -> set[Path]:
    """The files, and those they import or load, directly or not."""
    waiting, found = set(files), set[Path]()
    while waiting:
        file = waiting.pop()
        if file in found or not file.is_file() or not _is_own(file):
            continue
        found.add(file)
        waiting |= _rested_on(file)
    return found


def _is_own(file: Path) -> bool:
    """Whether a file is somebody's paper or system, and not the engine."""
    root = engine_folder()
    return not (root in file.parents and file.relative_to(root).parts[0] != "systems")


@remembered
def _libraries() -> tuple[Path, ...]:
    """The folders in which libraries are installed."""
    return tuple({Path(sysconfig.get_path(n)).resolve() for n in ("stdlib", "purelib", "platlib")})


def _rested_on(file: Path) -> set[Path]:
    found: set[Path] = set()
    try:
        tree = ast.parse(file.read_bytes())
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return found  # a library in another encoding or of another Python: its bytes count alone
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            found |= set(_imported(file, node))
        elif isinstance(node, ast.Import):
            for alias in node.names:
                found |= set(_absolute(file, alias.name))
        elif isinstance(node, ast.Call) and _called(node.func) == "load":
            found |= set(_loaded(node))
    return found


def _called(function: ast.expr) -> str:
    return getattr(function, "attr", getattr(function, "id", ""))


def _imported(file: Path, node: ast.ImportFrom) -> Iterator[Path]:
    names = [alias.name for alias in node.names]
    if node.level == 0:
        for name in ("", *(f".{n}" for n in names)):
            yield from _absolute(file, f"{node.module}{name}")
        return
    base = file.parents[node.level - 1].joinpath(*(node.module or "").split("."))
    for place in (base, *(base / name for name in names)):
        yield from _at(place)


def _absolute(file: Path, module: str) -> Iterator[Path]:
    """A module beside the file, above it in its package, or loaded from a place of its own."""
    parts = module.split(".")
    for folder in (file.parent, *file.parents):
        if folder in _libraries():
            break
        if folder == file.parent or folder.name == parts[0]:
            top = folder.parent if folder.name == parts[0] else folder
            yield from _at(top.joinpath(*parts))
    known = getattr(sys.modules.get(module), "__file__", None) or ""
    place = Path(known).resolve()
    if known.endswith(".py") and not any(library in place.parents for library in _libraries()):
        yield place


def _at(place: Path) -> Iterator[Path]:
    """The file of a module, and of the package around it."""
    for candidate in (place.with_suffix(".py"), place / "__init__.py"):
        if candidate.is_file():
            yield candidate.resolve()


def _loaded(node: ast.Call) -> Iterator[Path]:
    """The files of the system that a call of ``load`` names; of every system, if it names none."""
    argument = node.args[0] if node.args else None
    wanted = [argument.value] if isinstance(argument, ast.Constant) else names()
    for name in wanted:
        if name in names():
            origin = entry_of(name).origin
            if origin is not None:
                yield origin.resolve()

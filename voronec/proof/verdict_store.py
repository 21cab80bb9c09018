"""Finished verdicts on disk, as JSON, each under a digest of what it rests on.

A result rests on the file that declares it; on the modules that this one imports, as far as they
are no installed libraries; on the systems that these load by name; on the modules of the engine
that decide it, and on those behind the names that the files use, with all that these import; and
on the libraries that the engine computes with.  Modules are read off the imports: no list is kept.
"""

from __future__ import annotations

import ast
import json
import os
import re
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache as remembered
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

from voronec.declaration.catalogue import entry_of, names
from voronec.declaration.whole_files import make_room, user_cache

__all__ = [
    "Store",
    "closure",
    "digest",
    "engine_digest",
    "engine_folder",
    "modules_in",
    "platform_text",
]


LIBRARIES = ("sympy", "symengine", "python-flint", "mpmath", "numpy")
PACKAGE = "voronec"
IMPORT = re.compile(
    rf"^[ \t]*(?:from[ \t]+({PACKAGE}[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n#]*)"
    rf"|import[ \t]+({PACKAGE}[\w.]*)(?:[ \t]+as[ \t]+(\w+))?)",
    re.MULTILINE,
)
ANNOTATION = re.compile(r"^if TYPE_CHECKING:\n(?:[ \t]+[^\n]*\n|\n)+", re.MULTILINE)
"""Imports of names that only annotate: nothing rests on them."""


def digest(declared: str, files: Iterable[Path], decider: str) -> str:
    """A digest of a text, of files as they are now, and of the engine as far as ``decider``, the
    module that decides, and the files rest on it."""
    files = [*files]
    texts = [f.read_bytes() if f.is_file() else b"" for f in files]
    used = {module for text in texts for module in _uses(text)}
    mark = sha256(engine_digest(frozenset((decider, *used))).encode())
    mark.update(declared.encode())
    for file, text in zip(files, texts, strict=True):
        mark.update(b"\0" + file.name.encode() + b"\0" + text)
    return mark.hexdigest()


@remembered
def engine_digest(modules: frozenset[str]) -> str:
    """A digest of modules of the engine, of what they import, and of the libraries below."""
    mark = sha256(platform_text().encode())
    for file in _engine_files(modules):
        mark.update(_digest_of(file))
    return mark.hexdigest()


@remembered
def platform_text() -> str:
    """The versions of Python and of the libraries that the engine computes with, as one text."""
    return "\0".join([sys.version, *(f"{name} {version(name)}" for name in LIBRARIES)])


@remembered
def _digest_of(file: Path) -> bytes:
    """A digest of a module of the engine, with its name."""
    name = str(file.relative_to(engine_folder())).encode()
    return sha256(name + b"\0" + file.read_bytes()).digest()


def _engine_files(modules: Iterable[str]) -> list[Path]:
    """The files of modules of the engine and of all that they import, inside functions too."""
    waiting, found = set(modules), dict[str, Path]()
    while waiting:
        module = waiting.pop()
        file = _file_of(module)
        if module not in found and file is not None:
            found[module] = file
            waiting |= _imports_of(file) | {module.rpartition(".")[0]}
    return sorted(found.values())


@remembered
def _imports_of(file: Path) -> frozenset[str]:
    text = file.read_text(encoding="utf-8")
    # a room that imports nothing by itself names under TYPE_CHECKING what it loads on use
    is_room = file.name == "__init__.py" and file.parent != engine_folder()
    return frozenset(modules_in(text if is_room else ANNOTATION.sub("", text)))


@remembered
def _uses(source: bytes) -> frozenset[str]:
    return frozenset(modules_in(source.decode("utf-8", "replace")))


def modules_in(text: str) -> Iterator[str]:
    """Modules of the engine that a source imports, and the homes of names that it takes from the
    package itself."""
    prefixes = set[str]()
    for origin, imported, module, alias in IMPORT.findall(text):
        if module:
            yield module
            prefixes.add(alias or module)
            continue
        yield origin
        for name in re.findall(r"\w+", re.sub(r"\bas\s+\w+|#[^\n]*", "", imported)):
            inner = f"{origin}.{name}"
            yield _homes().get(name, inner) if origin == PACKAGE else inner
    for prefix in prefixes:
        for name in re.findall(rf"\b{re.escape(prefix)}\.(\w+)", text):
            yield _homes().get(name, f"{PACKAGE}.{name}")


def _homes() -> dict[str, str]:
    """Where the names of the package itself are defined."""
    homes: dict[str, str] = sys.modules[PACKAGE]._HOME
    return homes


def _file_of(module: str) -> Path | None:
    parts = module.split(".")
    if parts[0] != PACKAGE or parts[1:2] in (["systems"], ["docs"]):
        return None
    place = engine_folder().joinpath(*parts[1:])
    candidates = (place / "__init__.py", place.with_suffix(".py"))
    return next((c for c in candidates if c.is_file()), None)


@remembered
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
        waiting |= _files_under(file)
    return found


def _is_own(file: Path) -> bool:
    """Whether a file is somebody's paper or system, and not the engine."""
    root = engine_folder()
    return not (root in file.parents and file.relative_to(root).parts[0] != "systems")


@remembered
def _libraries() -> tuple[Path, ...]:
    """The folders in which libraries are installed."""
    return tuple({Path(sysconfig.get_path(n)).resolve() for n in ("stdlib", "purelib", "platlib")})


def _files_under(file: Path) -> set[Path]:
    found: set[Path] = set()
    for node in _importing_nodes(file.read_bytes()):
        if isinstance(node, ast.ImportFrom):
            found |= set(_imported_files(file, node))
        elif isinstance(node, ast.Import):
            for alias in node.names:
                found |= set(_absolute(file, alias.name))
        elif isinstance(node, ast.Call):
            found |= set(_loaded_files(node))
    return found


@remembered
def _importing_nodes(source: bytes) -> tuple[ast.AST, ...]:
    """The imports of a source, and its calls of ``load``."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ()  # a library in another encoding or of another Python: its bytes count alone
    return tuple(
        node
        for node in (ast.walk(tree) if b"load" in source else _statements([tree]))
        if isinstance(node, ast.ImportFrom | ast.Import)
        or (isinstance(node, ast.Call) and _name_of_call(node.func) == "load")
    )


def _statements(nodes: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """The statements of a source without their expressions, which are most of it."""
    for node in nodes:
        yield node
        for part in ("body", "orelse", "finalbody", "handlers", "cases"):
            inner = getattr(node, part, ())
            yield from _statements(inner if isinstance(inner, list) else ())


def _name_of_call(function: ast.expr) -> str:
    return getattr(function, "attr", getattr(function, "id", ""))


def _imported_files(file: Path, node: ast.ImportFrom) -> Iterator[Path]:
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


def _loaded_files(node: ast.Call) -> Iterator[Path]:
    """The files of the system that a call of ``load`` names; of every system, if it names none."""
    argument = node.args[0] if node.args else None
    wanted = [argument.value] if isinstance(argument, ast.Constant) else names()
    for name in wanted:
        if name in names():
            origin = entry_of(name).origin
            if origin is not None:
                yield origin.resolve()


@dataclass(frozen=True)
class Store:
    """A folder with one subfolder for each digest; of these the newest ``capacity`` stay.

    A file that is missing or broken is no result.
    """

    folder: Path
    capacity: int = 200

    @classmethod
    def of_user(cls, part: str, capacity: int = 200) -> Store:
        """The folder ``voronec/part`` among the user's caches."""
        return cls(user_cache(part), capacity)

    def load(self, key: str, name: str) -> Any:
        """What was kept, or ``None``."""
        try:
            return json.loads(self._file(key, name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None

    def save(self, key: str, name: str, value: Any) -> None:
        """Keep a value, whole or not at all; a folder that cannot be written costs only the
        time of the next run."""
        file = self._file(key, name)
        draft = file.with_suffix(f".{os.getpid()}")
        try:
            if not file.parent.exists():
                make_room(self.folder, self.capacity)
                file.parent.mkdir(parents=True, exist_ok=True)
            draft.write_text(json.dumps(value), encoding="utf-8")
            draft.replace(file)
        except OSError:
            with suppress(OSError):
                draft.unlink()

    def _file(self, key: str, name: str) -> Path:
        return self.folder / key[:24] / f"{name}.json"

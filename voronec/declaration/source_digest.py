"""What a result rests on, and a digest of it, under which the result may be kept.

It rests on the file that declares it; on the modules that this one imports, as far as they
are no installed libraries; on the systems that these load by name; on the modules of the engine
that decide it, and on those behind the names that the files use, with all that these import; and
on the libraries that the engine computes with.  Modules are read off the imports: no list is kept.
"""

from __future__ import annotations

import ast
import os
import re
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from functools import cache as remembered
from hashlib import sha256
from pathlib import Path

from voronec.declaration.catalogue import entry_of, names
from voronec.declaration.whole_files import Store

LIBRARIES = ("sympy", "symengine", "python-flint", "mpmath", "numpy")
PACKAGE = "voronec"
ASIDE = ("systems", "docs")
"""Folders of a package that is installed which are no engine."""
ENGINES = 8
"""Engines whose imports are kept."""
IMPORT = re.compile(
    rf"^[ \t]*(?:from[ \t]+({PACKAGE}[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n#]*)"
    rf"|import[ \t]+({PACKAGE}[\w.]*)(?:[ \t]+as[ \t]+(\w+))?)",
    re.MULTILINE,
)
ANNOTATION = re.compile(r"^if TYPE_CHECKING:\n(?:[ \t]+[^\n]*\n|\n)+", re.MULTILINE)
"""Imports of names that only annotate: nothing rests on them."""


def digest(declared: str, files: Iterable[Path], decider: str) -> str:
    """A digest of a text, of files as they are now, of the libraries that the engine computes with,
    and of the engine as far as ``decider``, the module that decides, and the files rest on it."""
    files = [*files]
    texts = [f.read_bytes() if f.is_file() else b"" for f in files]
    used = {module for text in texts for module in _uses(text)}
    engine = engine_digest(frozenset((decider, *used)))
    mark = sha256(f"{platform_text()}\0{engine}\0{declared}".encode())
    for file, text in zip(files, texts, strict=True):
        mark.update(b"\0" + file.name.encode() + b"\0" + text)
    return mark.hexdigest()


@remembered
def engine_digest(modules: frozenset[str]) -> str:
    """A digest of modules of the engine and of all that they import, inside functions too."""
    engine, waiting, digests = _engine(engine_folder()), {*modules}, dict[str, str]()
    while waiting:
        module = waiting.pop()
        if module in engine and module not in digests:
            digests[module], imported = engine[module]
            waiting |= {module.rpartition(".")[0], *imported}
    return sha256(repr(sorted(digests.items())).encode()).hexdigest()


def room_modules(room: str) -> frozenset[str]:
    """The modules in a room of the engine."""
    return frozenset(m for m in _engine(engine_folder()) if m.startswith(f"{PACKAGE}.{room}."))


@remembered
def platform_text() -> str:
    """The versions of Python and of the libraries that the engine computes with, as one text."""
    from importlib.metadata import version  # takes long to load, and runs do without

    return "\0".join([sys.version, *(f"{name} {version(name)}" for name in LIBRARIES)])


@remembered
def _engine(root: Path) -> dict[str, tuple[str, list[str]]]:
    """Of each module of the engine a digest and what it imports, kept for later processes while the
    times and sizes of the files stay: to read them takes longer than many a run."""
    aside = tuple(str(root / folder) for folder in ASIDE)
    tree = [(place, n) for place, _, names in os.walk(root) for n in names if n.endswith(".py")]
    files = sorted(os.path.join(*pair) for pair in tree if not pair[0].startswith(aside))
    state = [(f, (s := os.stat(f)).st_mtime_ns, s.st_size) for f in files]
    store, key = Store.of_user("engine", ENGINES), sha256(repr(state).encode()).hexdigest()
    known: dict[str, tuple[str, list[str]]] | None = store.load(key, "modules")
    if known is None:
        known = dict(_reading(root, Path(file)) for file in files)
        store.save(key, "modules", known)
    return known


def _reading(root: Path, file: Path) -> tuple[str, tuple[str, list[str]]]:
    """The name of a module, a digest of it, and the modules that it imports."""
    text = file.read_text(encoding="utf-8")
    inner = file.relative_to(root).with_suffix("").parts
    is_package = inner[-1] == "__init__"
    # a room that imports nothing by itself names under TYPE_CHECKING what it loads on use
    is_room = is_package and len(inner) > 1
    imported = {*modules_in(text if is_room else ANNOTATION.sub("", text))}
    name = ".".join((PACKAGE, *inner[: len(inner) - is_package]))
    return name, (sha256(text.encode()).hexdigest(), sorted(imported))


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


@remembered
def engine_folder() -> Path:
    """The folder of the package ``voronec``."""
    return Path(__file__).resolve().parents[1]


def closure(files: Iterable[Path]) -> set[Path]:
    """The files, and those they import or load, directly or not."""
    waiting, reached = set(files), set[Path]()
    while waiting:
        file = waiting.pop()
        if file in reached or not file.is_file() or not _is_own(file):
            continue
        reached.add(file)
        waiting |= _files_under(file)
    return reached


def _is_own(file: Path) -> bool:
    """Whether a file is somebody's paper or system, and not the engine."""
    root = engine_folder()
    return not (root in file.parents and file.relative_to(root).parts[0] != "systems")


@remembered
def _libraries() -> tuple[Path, ...]:
    """The folders in which libraries are installed."""
    return tuple({Path(sysconfig.get_path(n)).resolve() for n in ("stdlib", "purelib", "platlib")})


def _files_under(file: Path) -> set[Path]:
    files: set[Path] = set()
    for node in _importing_nodes(file.read_bytes()):
        if isinstance(node, ast.ImportFrom):
            files |= set(_imported_files(file, node))
        elif isinstance(node, ast.Import):
            for alias in node.names:
                files |= set(_absolute(file, alias.name))
        elif isinstance(node, ast.Call):
            files |= set(_loaded_files(node))
    return files


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

"""Which systems there are, and where: found without running anybody's code, loaded on request.

A distribution registers systems under the entry-point group ``voronec.systems``:

    anything = "package.folder"           every module of that folder is a system, and defines
                                          SYSTEM; ``rolling_coin.py`` is called ``rolling-coin``
    name     = "package.module:OBJECT"    one system, called ``name``

The systems of this project come in by the first of these doors.  A system whose module is a
folder may have a paper beside it, the module ``paper`` that defines ``PAPER``.
"""

from __future__ import annotations

import pkgutil
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib import import_module, metadata
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.errors import DefinitionError, did_you_mean
from voronec.execution import failure, run_file

if TYPE_CHECKING:
    from voronec.system import System

__all__ = [
    "Entry",
    "entries",
    "load",
    "load_file",
    "load_paper",
    "load_paper_file",
    "names",
    "papers",
]

GROUP = "voronec.systems"
OWN = "voronec"


@dataclass(frozen=True)
class Entry:
    """Where one system is defined; ``trouble`` says why it cannot even be looked for."""

    name: str
    module: str
    attribute: str = "SYSTEM"
    distribution: str = OWN
    trouble: str = ""

    @property
    def origin(self) -> Path | None:
        """The file of the system's module."""
        spec = _find(self.module)
        return Path(spec.origin) if spec is not None and spec.origin else None

    def load(self) -> System:
        """Import the module and return its system; ``DefinitionError`` whatever goes wrong."""
        from voronec.system import System

        if self.trouble:
            raise DefinitionError(f"system '{self.name}': {self.trouble}")
        found = _import(self.name, self.module, self.attribute)
        if not isinstance(found, System):
            raise DefinitionError(
                f"system '{self.name}': {self.module}:{self.attribute} is a "
                f"{type(found).__name__}, not a voronec.System"
            )
        return found


def entries() -> tuple[tuple[Entry, ...], tuple[str, ...]]:
    """All systems, sorted by name, each once, and warnings; nobody's code is run.

    Where a name is registered twice, this project's own entry stands, then the first by name of
    distribution.
    """
    found: dict[str, Entry] = {}
    warnings = []
    for entry in _registered():
        if entry.name in found:
            warnings.append(
                f"system '{entry.name}' of '{entry.distribution}' is hidden by that of "
                f"'{found[entry.name].distribution}'; rename one of them"
            )
        else:
            found[entry.name] = entry
    return tuple(found[name] for name in sorted(found)), tuple(warnings)


def names() -> list[str]:
    """The names of all systems, without loading any of them."""
    return [entry.name for entry in entries()[0]]


def load(name: str) -> System:
    """The system of that name; ``DefinitionError`` with the nearest names where there is none."""
    return entry_of(name).load()


def entry_of(name: str) -> Entry:
    """Where the system of that name is defined."""
    known = {entry.name: entry for entry in entries()[0]}
    if name not in known:
        raise DefinitionError(unknown("system", name, known))
    return known[name]


def papers() -> list[str]:
    """The names of the systems that have a paper beside them, without loading anything."""
    return [entry.name for entry in entries()[0] if _find(f"{entry.module}.paper") is not None]


def load_paper(name: str) -> Any:
    """The ``PAPER`` beside a system."""
    known = papers()
    if name not in known:
        raise DefinitionError(unknown("paper", name, known))
    return _import(name, f"{entry_of(name).module}.paper", "PAPER")


def load_file(path: str | Path) -> System:
    """The system that a Python file defines as ``SYSTEM``.

    Raises ``DefinitionError``, with the line where there is one, where the file cannot be read,
    does not parse, raises, or defines no system.
    """
    from voronec.system import System

    namespace = run_file(Path(path))
    found = namespace.get("SYSTEM")
    if not isinstance(found, System):
        what = "no SYSTEM" if found is None else f"SYSTEM as a {type(found).__name__}"
        raise DefinitionError(f"{path} defines {what}; end it with SYSTEM = voronec.System(...)")
    return found


def load_paper_file(path: str | Path) -> Any:
    """What a Python file defines as ``PAPER``; ``DefinitionError`` as ``load_file`` has it."""
    found = run_file(Path(path)).get("PAPER")
    if found is None:
        raise DefinitionError(
            f"{path} defines no PAPER; end it with PAPER = voronec.audit.Paper(...)"
        )
    return found


def unknown(kind: str, name: str, known: Iterable[str]) -> str:
    """The message for a name that is none of the known ones: the nearest, else all of them."""
    return f"there is no {kind} '{name}'" + did_you_mean(name, known)


def _registered() -> Iterator[Entry]:
    """Every registered system, this project's first."""

    def rank(point: metadata.EntryPoint) -> tuple[bool, str, str]:
        name = _distribution(point)
        return name != OWN, name, point.name

    for point in sorted(metadata.entry_points(group=GROUP), key=rank):
        owner = _distribution(point)
        module, _, attribute = (part.strip() for part in point.value.partition(":"))
        spec = _find(module)
        if attribute:
            trouble = "" if spec else f"its module '{module}' of '{owner}' is not found"
            yield Entry(point.name, module, attribute, owner, trouble)
        elif spec is None or spec.submodule_search_locations is None:
            trouble = f"the entry point of '{owner}' names '{module}', which is not a folder of "
            yield Entry(
                point.name, module, "SYSTEM", owner, trouble + "modules; use 'module:SYSTEM'"
            )
        else:
            for found in pkgutil.iter_modules(spec.submodule_search_locations):
                if not found.name.startswith("_"):
                    name = found.name.replace("_", "-")
                    yield Entry(name, f"{module}.{found.name}", distribution=owner)


def _distribution(point: metadata.EntryPoint) -> str:
    return str(point.dist.name) if point.dist is not None else ""


def _find(module: str) -> ModuleSpec | None:
    """The spec of a module, without importing the packages above it."""
    locations = None
    spec: ModuleSpec | None = None
    parts = module.split(".")
    for depth in range(1, len(parts) + 1):
        name = ".".join(parts[:depth])
        spec = next(filter(None, (f.find_spec(name, locations) for f in sys.meta_path)), None)
        if spec is None:
            return None
        locations = spec.submodule_search_locations
        if locations is None and depth < len(parts):
            return None
    return spec


def _import(name: str, module: str, attribute: str) -> Any:
    """An attribute of a module; ``DefinitionError`` whatever its code does."""
    try:
        found = import_module(module)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        spec = _find(module)
        near = str(Path(spec.origin).parent) if spec is not None and spec.origin else module
        what = failure(error, near)
        raise DefinitionError(f"system '{name}' cannot be loaded: {what}") from error
    if not hasattr(found, attribute):
        raise DefinitionError(f"system '{name}': the module '{module}' defines no {attribute}")
    return getattr(found, attribute)

"""Which systems there are, and where: found without running anybody's code, loaded on request.

A distribution registers systems under the entry-point group ``voronec.systems``:

    anything = "package.folder"           every module of that folder is a system, and defines
                                          SYSTEM; ``rolling_coin.py`` is called ``rolling-coin``
    name     = "package.module:OBJECT"    one system, called ``name``

The systems of this project come in by the first of these doors.  Beside a system, its module may
define ``RELATIONS`` and ``SQUARES``, tuples of them.  A system whose module is a folder may have a
paper beside it, the module ``paper`` that defines ``PAPER``.
"""

from __future__ import annotations

import gc
import os
import pkgutil
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.algebra.arguments import PATH, accepts
from voronec.declaration.plugin_files import failure, run_file
from voronec.errors import DefinitionError, did_you_mean

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from voronec.declaration.relation import Relation, Square
    from voronec.declaration.system import System

GROUP = "voronec.systems"
OWN = "voronec"
OWN_FOLDER = "voronec.systems"
"""What this project registers under the group, and where its systems are looked for before any
other distribution is."""


@dataclass(frozen=True)
class Entry:
    """Where one system is defined: a module, or a file with a ``path`` of its own.

    ``trouble`` says why it cannot even be looked for; ``member`` is which of a family it is, where
    the module defines ``MEMBERS``, functions by name that make them.
    """

    name: str
    module: str
    attribute: str = "SYSTEM"
    distribution: str = OWN
    trouble: str = ""
    path: str = ""
    member: str = ""

    @property
    def origin(self) -> Path | None:
        """The file of the system's module."""
        if self.path:
            return Path(self.path)
        spec = _find(self.module)
        return Path(spec.origin) if spec is not None and spec.origin else None

    @property
    def place(self) -> str:
        """The file, else the module, for messages."""
        return str(self.origin or self.module)

    def load(self) -> System:
        """Import the module and return its system; ``DefinitionError`` whatever goes wrong."""
        from voronec.declaration.system import System

        if self.trouble:
            raise DefinitionError(f"system '{self.name}': {self.trouble}")
        if self.path and not self.member:
            return load_file(self.path)
        system = self._definitions().get(self.attribute)
        if self.member:
            system = self._make_member(system)
        if not isinstance(system, System):
            raise DefinitionError(
                f"system '{self.name}': {self.module}:{self.attribute} is a "
                f"{type(system).__name__}, not a voronec.System"
            )
        if system.name != self.name:
            raise DefinitionError(
                f"system '{self.name}': the system in {self.place} calls itself "
                f"'{system.name}'; write name='{self.name}'"
            )
        return system

    def _definitions(self) -> Mapping[str, Any]:
        """The names that the file or the module defines."""
        if self.path:
            return _definitions_in(Path(self.path))
        return vars(_import(self.name, self.module, self.attribute))

    def _make_member(self, family: Any) -> Any:
        """The member of a family, made once: what is derived of it is kept with it;
        ``DefinitionError`` where its function fails."""
        try:
            make = family[self.member]
            return make() if self.path else _member_of(make)  # a file is read anew each time
        except Exception as error:
            what = failure(error, str(self.origin.parent if self.origin else self.module))
            raise DefinitionError(f"system '{self.name}' cannot be made: {what}") from error

    def load_members(self) -> tuple[str, ...]:
        """Which members the family in this module or file has; none where it is one system."""
        if not self.path and not self.module:
            return ()
        makers = self._definitions().get("MEMBERS", {})
        if not isinstance(makers, Mapping) or not all(callable(make) for make in makers.values()):
            raise DefinitionError(
                f"{self.place}: MEMBERS is no mapping of functions; write MEMBERS = "
                "{'member': function that makes it}"
            )
        return tuple(map(str, makers))

    def of_member(self, member: str) -> Entry:
        """A member of this family; ``DefinitionError`` where there is none of that name."""
        name = f"{self.name}@{member}"
        among = self.load_members()
        if member not in among:
            known = [f"{self.name}@{m}" for m in among] or [self.name]
            raise DefinitionError(unknown("system", name, known))
        return self.member_entry(member)

    def member_entry(self, member: str) -> Entry:
        """The member of that name, which this family is known to have."""
        return replace(self, name=f"{self.name}@{member}", attribute="MEMBERS", member=member)

    def load_relations(self) -> tuple[tuple[Relation, ...], tuple[Square, ...]]:
        """The ``RELATIONS`` and ``SQUARES`` beside the system; ``DefinitionError`` as ``load``."""
        from voronec.declaration.relation import Relation, Square

        space = self._definitions()
        relations = self._several(space, "RELATIONS", Relation)
        return relations, self._several(space, "SQUARES", Square)

    def _several(self, space: Any, title: str, kind: type) -> tuple[Any, ...]:
        """What the module declares under a title: a tuple of things of one kind."""
        things = space.get(title, ())
        entry = f"write {title} = ({kind.__name__}(...),)"
        if not isinstance(things, (tuple, list)):
            what = type(things).__name__
            raise DefinitionError(f"{self.place}: {title} is a {what}, not a tuple; {entry}")
        for position, thing in enumerate(things):
            if not isinstance(thing, kind):
                what = type(thing).__name__
                raise DefinitionError(
                    f"{self.place}: entry {position + 1} of {title} is a {what}; {entry}"
                )
        return tuple(things)


@cache
def _member_of(make: Callable[[], Any]) -> Any:
    """What the function of a family in an imported module makes."""
    return make()


def entries() -> tuple[tuple[Entry, ...], tuple[str, ...]]:
    """All systems, sorted by name, each once, and warnings; nobody's code is run.

    Where a name is registered twice, this project's own entry stands, then the first by name of
    distribution.
    """
    registry: dict[str, Entry] = {}
    warnings = []
    for entry in registered_entries():
        if entry.name in registry:
            warnings.append(
                f"system '{entry.name}' of '{entry.distribution}' is hidden by that of "
                f"'{registry[entry.name].distribution}'; rename one of them"
            )
        else:
            registry[entry.name] = entry
    return tuple(registry[name] for name in sorted(registry)), tuple(warnings)


def names() -> list[str]:
    """The names of all systems, without loading any of them."""
    return [entry.name for entry in entries()[0]]


SUFFIXES = (".py", ".toml")
"""What the files end in that define systems: Python, and text."""
RESULTS = (".npz", ".parquet", ".zarr")
"""What the files end in that hold results."""


def is_file(subject: str) -> bool:
    """Whether NAME|FILE means a file: it ends as files of systems or of results do, or has a
    separator of paths."""
    return subject.endswith((*SUFFIXES, *RESULTS)) or os.sep in subject


@accepts(name=PATH)
def load(name: str | os.PathLike[str]) -> System:
    """The system of that name, or the one that a file declares.

    A file is a path, or a name that ends in ``.py``, which is run, or in ``.toml``, which is only
    read.  ``DefinitionError`` with the nearest names where there is no such system, and with the
    line where a file is wrong.
    """
    with no_collection():
        if isinstance(name, os.PathLike) or is_file(name):
            return load_file(Path(name))
        return entry_of(name).load()


def entry_of(name: str) -> Entry:
    """Where the system of that name is defined."""
    family, at, member = name.partition("@")
    entry = next((e for e in _in_folder(OWN_FOLDER, OWN) if e.name == family), None)
    if entry is None:
        known = {e.name: e for e in entries()[0]}
        if family not in known:
            raise DefinitionError(unknown("system", name, known))
        entry = known[family]
    return entry.of_member(member) if at else entry


def members(name: str) -> list[str]:
    """Which members the family of that name has, ``NAME@MEMBER``; none where it is one system."""
    return list(entry_of(name).load_members())


def file_entry(path: str | Path) -> Entry:
    """The system that a file defines, as an entry; raises as ``load_file``."""
    return Entry(load_file(path).name, "", path=str(Path(path).resolve()))


def papers() -> list[str]:
    """The names of the systems that have a paper beside them, without loading anything."""
    return [entry.name for entry in entries()[0] if _find(f"{entry.module}.paper") is not None]


def load_paper(name: str) -> Any:
    """The ``PAPER`` beside a system."""
    known = papers()
    if name not in known:
        raise DefinitionError(unknown("paper", name, known))
    return _import(name, f"{entry_of(name).module}.paper", "PAPER").PAPER


def load_file(path: str | Path) -> System:
    """The system that a Python file defines as ``SYSTEM``, or that a TOML file declares.

    Raises ``DefinitionError``, with the line where there is one, where the file cannot be read,
    does not parse, raises, or defines no system.
    """
    from voronec.declaration.system import System

    system = _definitions_in(Path(path)).get("SYSTEM")
    if not isinstance(system, System):
        what = "no SYSTEM" if system is None else f"SYSTEM as a {type(system).__name__}"
        raise DefinitionError(f"{path} defines {what}; end it with SYSTEM = voronec.System(...)")
    return system


def _definitions_in(path: Path) -> Mapping[str, Any]:
    """The names that a file defines: a Python file is run, a text is read."""
    require_suffix(path)
    if path.suffix != ".toml":
        return run_file(path)
    from voronec.declaration.system_text import read_system

    return {"SYSTEM": read_system(path)}


def require_suffix(path: Path) -> None:
    """Refuse a folder, and a file that is neither Python nor a text of a system by its name."""
    if path.suffix in RESULTS:
        raise DefinitionError(f"'{path}' holds a result, not a system: open it by voronec.open")
    if os.path.isdir(path):
        raise DefinitionError(f"'{path}' is a folder; give the file in it that defines the system")
    # not Path.is_file, for which a name that is too long is an error of the system
    if path.suffix not in SUFFIXES and os.path.isfile(path):
        raise DefinitionError(
            f"'{path}' defines no system: a file must end in {' or '.join(SUFFIXES)}; rename it"
        )


def load_paper_file(path: str | Path) -> Any:
    """What a Python file defines as ``PAPER``; ``DefinitionError`` as ``load_file`` has it."""
    paper = _definitions_in(Path(path)).get("PAPER")
    if paper is None:
        raise DefinitionError(
            f"{path} defines no PAPER; end it with PAPER = voronec.audit.Paper(...)"
        )
    return paper


def unknown(kind: str, name: str, known: Iterable[str]) -> str:
    """The message for a name that is none of the known ones: the nearest, else all of them; for one
    that ends nearly as a file does, the files that may be meant."""
    from difflib import get_close_matches

    stem, ending = os.path.splitext(name)
    if get_close_matches(ending, SUFFIXES):
        known = [stem + suffix for suffix in SUFFIXES]
    return f"there is no {kind} '{name}'" + did_you_mean(name, known)


def registered_entries() -> Iterator[Entry]:
    """Every registered system, those that are hidden too, this project's first."""

    def rank(point: EntryPoint) -> tuple[bool, str, str]:
        name = _distribution(point)
        return name != OWN, name, point.name

    # loads slowly, and a system of this project is found without
    from importlib.metadata import entry_points

    for point in sorted(entry_points(group=GROUP), key=rank):
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
            yield from _in_folder(module, owner)


def _in_folder(module: str, owner: str) -> Iterator[Entry]:
    """The systems in a folder of modules."""
    spec = _find(module)
    locations = None if spec is None else spec.submodule_search_locations
    for submodule in pkgutil.iter_modules(locations or ()):
        if not submodule.name.startswith("_"):
            name = submodule.name.replace("_", "-")
            yield Entry(name, f"{module}.{submodule.name}", distribution=owner)


def _distribution(point: EntryPoint) -> str:
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
    """A module that defines an attribute; ``DefinitionError`` whatever its code does."""
    try:
        loaded = import_module(module)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        spec = _find(module)
        near = str(Path(spec.origin).parent) if spec is not None and spec.origin else module
        what = failure(error, near)
        raise DefinitionError(f"system '{name}' cannot be loaded: {what}") from error
    if not hasattr(loaded, attribute):
        raise DefinitionError(f"system '{name}': the module '{module}' defines no {attribute}")
    return loaded


@contextmanager
def no_collection() -> Iterator[None]:
    """No search for garbage inside, and none of what is there by the end but with all that is old:
    what modules hold stays, and to look through SymPy's thousands of objects again and again takes
    a tenth of the time of loading it."""
    collects = gc.isenabled()
    before = gc.get_count()[0]
    gc.disable()
    try:
        yield
    finally:
        if collects:
            made = gc.get_count()[0] - before
            # what is frozen is counted one by one, which is for a load that made much
            if made > gc.get_threshold()[0] and not gc.get_freeze_count():
                # frozen and thawed, all objects are of the oldest generation
                gc.freeze()
                gc.unfreeze()
            gc.enable()

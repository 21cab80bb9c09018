"""What models of one system are made of, kept on disk for later processes.

What is kept is packed, and what is used is unpacked, in the process that made it too: packing may
change the order of terms, and no bit of a motion may depend on where its model came from.
"""

from __future__ import annotations

import os
import pickle
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, TypeVar

import flint
import numpy
import symengine
import sympy as sp

from voronec.declaration.source_digest import engine_digest, room_modules
from voronec.declaration.system import System
from voronec.declaration.whole_files import (
    keep_with_digest,
    make_room,
    read_with_digest,
    user_cache,
)

T = TypeVar("T")
FILES = 300
"""So many files stay; those that nobody used for longest give way."""
ROOM = "motion"
"""Where models are made: they rest on all of it, and on what it imports."""
LIBRARIES = (sp, symengine, flint, numpy)
DYNAMIC_FIELDS = (
    "fibration", "lagrangian", "constraints", "parameters", "possible", "forces", "frame",
    "invariants", "integrals", "inputs", "charts",
)  # fmt: skip
"""The fields of a system that its equations and models come from."""


class ModelCache:
    """Values that come from a system and from what is ``wanted`` of it, by name.

    They lie in one file, called by a digest of all that they come from, the engine and the
    libraries below it included: what another version kept has another name.
    """

    def __init__(self, system: System, wanted: Any) -> None:
        self._system = system
        below = [
            engine_digest(room_modules(ROOM)),
            sys.version,
            *(x.__version__ for x in LIBRARIES),
        ]
        declared = [getattr(system, n) for n in DYNAMIC_FIELDS]
        said = spell([below, declared, wanted])
        self._file = user_cache("models") / sha256(said.encode()).hexdigest()[:32]
        self._packed = _read(self._file)
        self._on_disk = {*self._packed}

    def __contains__(self, name: str) -> bool:
        return name in self._packed

    def once(self, name: str, make: Callable[[], T]) -> T:
        """The value of a name, made where it is not kept yet; ``keep`` writes it down."""
        if name not in self._packed:
            made = make()
            packed = _pack(made, self._system)
            if packed is None:
                return made
            self._packed[name] = packed
        kept: T = self.value_of(name)
        return kept

    def value_of(self, name: str) -> Any:
        """The value of a name that is kept."""
        return _Unpickler(self._packed[name], self._system).load()

    def forget(self, name: str) -> None:
        """Forget the values whose names begin so."""
        self._packed = {n: packed for n, packed in self._packed.items() if not n.startswith(name)}

    def keep(self) -> None:
        """Write what is new to disk, whole or not at all; a folder that cannot be written costs
        only the time of the next process."""
        if self._packed.keys() == self._on_disk:
            return
        make_room(self._file.parent, FILES)
        keep_with_digest(self._file, pickle.dumps(self._packed))
        self._on_disk = {*self._packed}


def _read(file: Path) -> dict[str, bytes]:
    """What a file holds; nothing where there is none, where it is not as it was written, or where
    others may have written it: to unpickle is to run."""
    if (content := read_with_digest(file, "model")) is None:
        return {}
    with suppress(OSError):
        os.utime(file)
    known: dict[str, bytes] = pickle.loads(content)
    return known


def _pack(value: Any, system: System) -> bytes | None:
    """A value as bytes; None where it holds what cannot be packed."""
    into = BytesIO()
    try:
        _Pickler(into, system).dump(value)
    except (pickle.PicklingError, TypeError, AttributeError, RuntimeError, RecursionError):
        return None
    return into.getvalue()


class _Pickler(pickle.Pickler):
    """ModelCache all but the system, which stands in whatever comes from it."""

    def __init__(self, into: BytesIO, system: System) -> None:
        super().__init__(into, protocol=pickle.HIGHEST_PROTOCOL)
        self._system = system

    def persistent_id(self, value: Any) -> str | None:
        """The name of the system; None for what is packed."""
        return "system" if value is self._system else None


class _Unpickler(pickle.Unpickler):
    def __init__(self, packed: bytes, system: System) -> None:
        super().__init__(BytesIO(packed))
        self._system = system

    def persistent_load(self, name: str) -> System:
        """The system."""
        return self._system


def spell(value: Any) -> str:
    """Text that tells values apart: systems, scenes, expressions, records and mappings of these."""
    return _Spelling().of(value)


class _Spelling:
    """Text that tells values apart: two that differ in a symbol's assumptions differ in it.

    Every expression is spelled once, and called by its number where it stands again.
    """

    def __init__(self) -> None:
        self._numbers: dict[Any, int] = {}

    def of(self, value: Any) -> str:
        """The text of a value: expressions, records, mappings and sequences of these."""
        if isinstance(value, sp.Basic):
            return self._expression(value)
        if is_dataclass(value):
            parts = [getattr(value, f.name) for f in fields(value)]
            return type(value).__name__ + self.of(parts)
        if isinstance(value, Mapping):
            return "{" + ",".join(f"{self.of(k)}:{self.of(x)}" for k, x in value.items()) + "}"
        if isinstance(value, list | tuple):
            return "(" + ",".join(map(self.of, value)) + ")"
        return repr(value)

    def _expression(self, expr: sp.Basic) -> str:
        if not expr.args:
            return sp.srepr(expr)
        if expr in self._numbers:
            return f"#{self._numbers[expr]}"
        kind = f"{expr.func.__module__}.{expr.func.__name__}"
        text = f"{kind}({','.join(map(self.of, expr.args))})"
        self._numbers[expr] = len(self._numbers)
        return text

"""Packages whose names load on first use."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def load_on_use(
    package: str, homes: Mapping[str, str]
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """``__all__``, ``__getattr__`` and ``__dir__`` of a package.

    ``homes`` has the names that each module hands out, separated by blanks; a module is one of the
    package, or stands by its whole name, ``voronec.`` and so on.
    """
    places = {
        name: module if "." in module else f"{package}.{module}"
        for module, names in homes.items()
        for name in names.split()
    }

    def load(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        return getattr(import_module(places[name]), name)

    return sorted(places), load, lambda: sorted(places)

"""Coordinates and velocities in whose place a level has other variables."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from voronec.model.level import Level

__all__ = ["absent"]


def absent(level: Level, needed: set[Any], names: tuple[Any, ...]) -> Iterator[tuple[Any, str]]:
    """Which of the ``names`` are no variables of the level, and in which needed ones each stands.

    The list is empty where nothing that is needed holds it.
    """
    for x in names:
        if x in level.variables:
            continue
        holders = [
            str(y) for y in level.variables if y in needed and x in level.start[y].free_symbols
        ]
        yield x, ", ".join(holders)

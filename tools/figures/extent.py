"""How far the measurements of speed go: in full, or short, to see that each of them runs."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["FULL", "SHORT", "Extent"]


@dataclass(frozen=True)
class Extent:
    """Units of time of one motion, of many and of long ones; starts, crossings, repetitions."""

    span: float = 1000.0
    many: float = 100.0
    long: float = 1e5
    starts: int = 1000
    crossings: int = 8000
    turns: int = 30
    rounds: int = 5
    processes: int = 3


FULL = Extent()
SHORT = Extent(20.0, 5.0, 200.0, 32, 4000, 2, 1, 1)
"""So far only that everything is called; figures mean nothing then."""

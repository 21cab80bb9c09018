"""A system without what it claims: what a test says of it is then all that is said."""

from __future__ import annotations

from typing import Any

from voronec import System

KEPT = "fibration lagrangian constraints parameters possible forces frame inputs".split()


def bare(system: System, name: str = "", **changes: Any) -> System:
    """The system by another name, with changes, without its claims, charts and scenes."""
    kept = {field: getattr(system, field) for field in KEPT}
    return System(**{**kept, "name": name or system.name, **changes})

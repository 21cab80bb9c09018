"""Garbage collection, put off where most of what is made stays."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["no_collection", "rare_collection"]


@contextmanager
def no_collection() -> Iterator[None]:
    """No search for garbage inside: what modules hold stays, and to look through SymPy's thousands
    of objects again and again takes a tenth of the time of loading it."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


OBJECTS = 100_000
"""So many new ones a command makes before garbage is searched for; Python's own number is 700."""


@contextmanager
def rare_collection() -> Iterator[None]:
    """A search for garbage only now and then inside: a command is over soon."""
    before = gc.get_threshold()
    gc.set_threshold(OBJECTS, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)

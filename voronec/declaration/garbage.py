"""Modules loaded without searches for garbage between."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["no_collection"]


@contextmanager
def no_collection() -> Iterator[None]:
    """No search for garbage inside, and none of what is there by the end but with all that is old:
    what modules hold stays, and to look through SymPy's thousands of objects again and again takes
    a tenth of the time of loading it."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            if not gc.get_freeze_count():
                # frozen and thawed, all objects are of the oldest generation
                gc.freeze()
                gc.unfreeze()
            gc.enable()

"""Sweeps: many motions over grids, lists and random draws, in folders that outlive processes.

    rows  ->  chunks  ->  numbers of a chunk  ->  a shard of the folder  ->  pictures

``plan.py`` says which motions there are, ``records.py`` what is recorded of them, ``engines.py``
who computes, ``folder.py`` where it is kept, ``whole_sweep.py`` puts these together, and
``kept_sweep.py`` opens what is there.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.sweeps.kept_sweep import Sweep
    from voronec.sweeps.plan import Draws
    from voronec.sweeps.whole_sweep import sweep

__all__ = ["Draws", "Sweep", "sweep"]

_HOME = {"kept_sweep": ("Sweep",), "plan": ("Draws",), "whole_sweep": ("sweep",)}


def __getattr__(name: str) -> Any:
    for module, names in _HOME.items():
        if name in names:
            return getattr(import_module(f"voronec.sweeps.{module}"), name)
    raise AttributeError(f"module 'voronec.sweeps' has no attribute '{name}'")

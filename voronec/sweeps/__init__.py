"""Sweeps: many motions over grids, lists and random draws, in folders that outlive processes.

    rows  ->  chunks  ->  numbers of a chunk  ->  a shard of the folder  ->  pictures

``plan.py`` says which motions there are, ``records.py`` what is recorded of them, ``engines.py``
who computes, ``folder.py`` where it is kept, ``whole_sweep.py`` puts these together, and
``kept_sweep.py`` opens what is there.
"""

from typing import TYPE_CHECKING

from voronec.algebra.lazy_names import load_on_use

if TYPE_CHECKING:
    from voronec.sweeps.kept_sweep import Sweep as Sweep
    from voronec.sweeps.plan import Draws as Draws
    from voronec.sweeps.whole_sweep import sweep as sweep

__all__, __getattr__, __dir__ = load_on_use(
    __name__,
    {
        "kept_sweep": "Sweep",
        "plan": "Draws",
        "whole_sweep": "sweep",
    },
)

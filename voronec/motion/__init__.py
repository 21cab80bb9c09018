"""Motions: a system, its initial data and a grid of times make a ``Trajectory``.

Names load on first use: the table of methods is read where nothing is integrated.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from voronec.motion.ensembles import Ensemble, ensemble
    from voronec.motion.inputs import Sampled, Table
    from voronec.motion.prepared_problem import PreparedProblem, integrate, prepare
    from voronec.motion.request import Event
    from voronec.motion.sections import Section, section
    from voronec.motion.trajectory import Cost, Crossings, Trajectory

__all__ = [
    "Cost",
    "Crossings",
    "Ensemble",
    "Event",
    "PreparedProblem",
    "Sampled",
    "Section",
    "Table",
    "Trajectory",
    "ensemble",
    "integrate",
    "prepare",
    "section",
]

_HOME = {
    "ensembles": ("Ensemble", "ensemble"),
    "request": ("Event",),
    "prepared_problem": ("PreparedProblem", "integrate", "prepare"),
    "sections": ("Section", "section"),
    "inputs": ("Sampled", "Table"),
    "trajectory": ("Cost", "Crossings", "Trajectory"),
}


def __getattr__(name: str) -> Any:
    for module, names in _HOME.items():
        if name in names:
            return getattr(import_module(f"voronec.motion.{module}"), name)
    raise AttributeError(f"module 'voronec.motion' has no attribute '{name}'")

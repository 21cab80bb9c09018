"""Motions: a system, its initial data and a grid of times make a ``Trajectory``."""

from voronec.motion.ensembles import Ensemble, ensemble
from voronec.motion.events import Crossings, Event
from voronec.motion.integration import integrate
from voronec.motion.sections import Section, section
from voronec.motion.tables import Table
from voronec.motion.trajectory import Cost, Trajectory

__all__ = [
    "Cost",
    "Crossings",
    "Ensemble",
    "Event",
    "Section",
    "Table",
    "Trajectory",
    "ensemble",
    "integrate",
    "section",
]

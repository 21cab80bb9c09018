"""Motions: a system, its initial data and a grid of times make a ``Trajectory``."""

from voronec.flow.ensembles import Ensemble, ensemble
from voronec.flow.events import Crossings, Event
from voronec.flow.motion import integrate
from voronec.flow.sections import Section, section
from voronec.flow.tables import Table
from voronec.flow.trajectory import Cost, Trajectory

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

"""Motions: a system, its initial data and a grid of times make a ``Trajectory``."""

from voronec.flow.motion import integrate
from voronec.flow.trajectory import Cost, Trajectory

__all__ = ["Cost", "Trajectory", "integrate"]
